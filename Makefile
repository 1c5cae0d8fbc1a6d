# Two commands for a fresh machine: `make dance` and `make test`. The rest is for developers.

FITS := import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 12))
# The first that runs and fits: a name may be there and lead to nothing.
PYTHON ?= $(shell for name in python3.12 python3.11 python3 python; do \
  $$name -c '$(FITS)' >/dev/null 2>&1 && echo $$name && break; done)
BIN := .venv/bin

SECONDS ?= 600

.PHONY: help dance test test-slow test-web test-video test-robots test-lowest coverage check format bench campaign docs gallery build clean

dance: .venv/installed  ## train the built-in dance and make its video
	@echo "Training two arms to dance, and drawing the video"
	$(BIN)/mpma imitate ymca --out runs/ymca --overwrite

test: .venv/installed-dev  ## quick tests, under 4 minutes on two cores
	$(BIN)/pytest -n 2 --dist worksteal -q -rs

test-slow: .venv/installed-dev  ## what takes longer
	$(BIN)/pytest -n 2 -q -m slow

test-web: .venv/installed-dev  ## the page in a real browser: Chromium of the system, or Playwright's
	@echo "Installing viser and Playwright into .venv"
	$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[web]' playwright
	command -v chromium google-chrome >/dev/null || $(BIN)/playwright install chromium
	$(BIN)/pytest -q -rs -m web

test-video: .venv/installed-dev  ## dance from video, with mediapipe
	@echo "Installing mediapipe into .venv"
	$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[video]'
	$(BIN)/pytest -q -rs tests/motions/readers/video

test-robots: .venv/installed-dev  ## robots of other packages: H1, G1, YuMi, OpenArm
	@echo "Installing robosuite-models and openarm-mujoco, which hold the models, into .venv"
	$(BIN)/pip install --quiet --disable-pip-version-check --no-deps robosuite-models openarm-mujoco
	$(BIN)/pytest -q -rs tests/robots tests/envs/test_robots.py

test-lowest: .venv/installed-dev  ## quick tests with the lowest versions that pyproject.toml declares
	@echo "Installing the lowest versions into .venv-lowest"
	$(BIN)/uv venv --clear --seed --python $(BIN)/python .venv-lowest
	$(BIN)/uv pip install --python .venv-lowest --resolution lowest-direct --editable '.[dev]'
	.venv-lowest/bin/python -m pytest -n 2 -q -rs

coverage: .venv/installed-dev  ## which lines the quick tests reach, as text and in htmlcov/
	$(BIN)/pytest -n 2 -q --cov=mpma_mj --cov-report=term:skip-covered --cov-report=html

check: .venv/installed-dev  ## formatting, lint, types
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

bench: .venv/installed-dev  ## speed beside bare physics and peers; ARGS="environment" is part of it
	$(BIN)/python -m benchmarks.speed $(ARGS)

campaign: .venv/installed-dev  ## try to lose or invent results: kills, damage, leaks; SECONDS=600 SEED=1
	$(BIN)/python -m benchmarks.campaign --seconds $(SECONDS) $(if $(SEED),--seed $(SEED))

format: .venv/installed-dev  ## rewrite to the house style
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

docs: .venv/installed-docs  ## the site, docs/_build/index.html; warnings are errors
	MUJOCO_GL=disable $(BIN)/sphinx-build --fail-on-warning --keep-going -q -b html docs docs/_build

gallery: .venv/installed-dev  ## the pictures of docs/gallery.md, 3 minutes; ARGS="wave" is one
	$(BIN)/python docs/make_gallery.py $(ARGS)

build: .venv/installed-dev  ## wheel and sdist into dist/
	$(BIN)/python -m build

help:  ## this list
	@sed -n 's/^\([a-z-]*\):.*## /\1\t/p' Makefile | expand -t 12

clean:  ## everything that can be made again, except runs
	rm -rf .venv .venv-lowest build dist docs/_build htmlcov .coverage *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis

.venv/installed: .venv/made pyproject.toml
	@echo "Installing mpma-mj and the packages that it needs into .venv"
	$(BIN)/pip install --disable-pip-version-check --editable .
	touch $@

.venv/installed-dev: .venv/made pyproject.toml
	@echo "Installing mpma-mj, the packages that it needs and those of developers into .venv"
	$(BIN)/pip install --disable-pip-version-check --editable '.[dev]'
	touch $@ .venv/installed

.venv/installed-docs: .venv/made pyproject.toml
	$(BIN)/pip install --quiet --editable '.[docs]'
	touch $@

.venv/made:
	@$(or $(PYTHON),false) -c '$(FITS)' || { \
	  echo "Needs Python 3.11 or 3.12: install one, or say make PYTHON=/path/to/python3.11"; exit 1; }
	@echo "Creating a virtual environment for $$($(PYTHON) --version) in .venv"
	@$(PYTHON) -m venv .venv || { \
	  echo "No virtual environment: on Debian and Ubuntu, apt install python3-venv"; rm -rf .venv; exit 1; }
	@touch $@
