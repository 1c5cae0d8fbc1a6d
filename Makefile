# Two commands for a fresh machine: `make dance` and `make test`. The rest is for developers.

PYTHON ?= $(firstword $(foreach name,python3.12 python3.11 python3,$(shell command -v $(name) 2>/dev/null)))
BIN := .venv/bin

.PHONY: help dance test test-slow check format build clean

dance: .venv/installed  ## train the built-in dance and make its video
	$(BIN)/mpma imitate ymca --out runs/ymca --overwrite

test: .venv/installed-dev  ## quick tests, under 3 minutes on two cores
	$(BIN)/pytest -n 2 -q

test-slow: .venv/installed-dev  ## what takes longer
	$(BIN)/pytest -n 2 -q -m slow

check: .venv/installed-dev  ## formatting, lint, types
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

format: .venv/installed-dev  ## rewrite to the house style
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

build: .venv/installed-dev  ## wheel and sdist into dist/
	$(BIN)/python -m build

help:  ## this list
	@sed -n 's/^\([a-z-]*\):.*## /\1\t/p' Makefile | expand -t 12

clean:  ## everything that can be made again, except runs
	rm -rf .venv build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis

.venv/installed: .venv/made pyproject.toml
	$(BIN)/pip install --quiet --editable .
	touch $@

.venv/installed-dev: .venv/made pyproject.toml
	$(BIN)/pip install --quiet --editable '.[dev]'
	touch $@ .venv/installed

.venv/made:
	@test -n "$(PYTHON)" || { echo "No Python found: install Python 3.11 or 3.12."; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 12))' || { \
	  echo "$(PYTHON) is not Python 3.11 or 3.12: install one, or say make PYTHON=/path/to/python3.11"; exit 1; }
	@$(PYTHON) -m venv .venv || { \
	  echo "No virtual environment: on Debian and Ubuntu, apt install python3-venv"; rm -rf .venv; exit 1; }
	@touch $@
