"""That the examples of the documentation run as they stand."""

import ast
import importlib.util
import re
import subprocess
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parent.parent / "docs"
EXAMPLES = {
    f"{page.stem} {number}": code
    for page in sorted(DOCS.glob("*.md"))
    for number, code in enumerate(re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL))
}


def imported(code: str) -> set[str]:
    """Return the packages that code imports."""
    nodes = list(ast.walk(ast.parse(code)))
    plain = {alias.name for n in nodes if isinstance(n, ast.Import) for alias in n.names}
    named = {str(n.module) for n in nodes if isinstance(n, ast.ImportFrom)}
    return {name.split(".")[0] for name in plain | named}


@pytest.mark.parametrize("title", EXAMPLES)
def test_examples_run(title: str, tmp_path: Path) -> None:
    code = EXAMPLES[title]
    for package in ("gymnasium", "stable_baselines3", "cma"):  # optional
        if package in imported(code) and importlib.util.find_spec(package) is None:
            pytest.skip(f"{package} is not installed")
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=tmp_path
    )
    assert result.returncode == 0, result.stderr


def test_every_way_has_an_example() -> None:
    assert ["stable_baselines3" in imported(code) for code in EXAMPLES.values()].count(True) == 1
    assert ["cma" in imported(code) for code in EXAMPLES.values()].count(True) == 1


@pytest.mark.parametrize("page", sorted(DOCS.glob("*.md")), ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for path in re.findall(r"\]\((?!http)([^)#]+)", page.read_text(encoding="utf-8")):
        assert (DOCS / path).exists(), path
