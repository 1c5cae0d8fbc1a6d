"""Structure: which folder may import from which, and no circles."""

import ast
import functools
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parent.parent / "mpma_mj"

# A folder or module imports only from rows below its own, and within its row.
CHAIN = (
    ("__main__",),
    ("cli",),
    ("commands",),
    ("browser",),
    ("analysis",),
    ("experiments", "sysid"),
    ("evaluation",),
    ("training",),
    ("visualization",),
    ("trace",),
    ("agents", "envs"),
    ("motions", "esn"),
    ("robots",),
    ("metrics", "feedback"),
    ("arm_kinematics",),
    ("context", "joint_paths"),
    ("kinematics",),
    ("utils", "options"),
    ("errors", "_version"),
)
LEVEL = {name: level for level, row in enumerate(CHAIN) for name in row}


@functools.cache
def modules() -> dict[str, Path]:
    """Return all modules of the package by name, but for the package's root."""
    found = {}
    for path in PACKAGE.rglob("*.py"):
        parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    del found["mpma_mj"]
    return found


def imports(path: Path, *, at_runtime: bool) -> set[str]:
    """Return the modules of the package that a module imports, also within functions.

    Args:
        path: The module's file.
        at_runtime: Whether imports for type checkers and those within functions are left out.
    """
    tree = ast.parse(path.read_text("utf-8"))
    found = set()
    body = tree.body if at_runtime else ast.walk(tree)
    for node in body:
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("mpma_mj"):
            assert node.module is not None
            known = modules()
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                found.add(inner if inner in known else node.module)
    return found


def folder(module: str) -> str:
    return module.split(".")[1]


@pytest.mark.parametrize("module", sorted(modules()))
def test_a_module_imports_only_from_folders_below_its_own(module: str) -> None:
    level = LEVEL[folder(module)]
    against = {
        other
        for other in imports(modules()[module], at_runtime=False)
        if other != "mpma_mj" and folder(other) != folder(module) and LEVEL[folder(other)] <= level
    }
    assert not against


def test_no_module_imports_itself_through_others() -> None:
    known = modules()
    graph = {name: imports(path, at_runtime=True) & known.keys() for name, path in known.items()}
    state: dict[str, str] = {}

    def visit(module: str, way: tuple[str, ...]) -> None:
        assert state.get(module) != "open", " -> ".join((*way, module))
        if module not in state:
            state[module] = "open"
            for other in sorted(graph[module]):
                visit(other, (*way, module))
            state[module] = "done"

    for module in sorted(graph):
        visit(module, ())


def test_no_module_of_the_core_is_longer_than_a_screenful_of_350_lines() -> None:
    core = (
        *(
            "agents",
            "envs",
            "esn",
            "evaluation",
            "motions",
            "robots",
            "training",
            "utils",
            "visualization",
            "browser",
        ),
    )
    long = {
        name: lines
        for name, path in modules().items()
        if folder(name) in core and (lines := len(path.read_text("utf-8").splitlines())) > 350
    }
    assert not long
