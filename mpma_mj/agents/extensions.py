"""Classes from outside the package, named by a file or a module.

Nothing else in the package imports code by a name from outside.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import inspect
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

from mpma_mj.errors import BadOptionError, one_line
from mpma_mj.utils.input_files import SMALL_FILE, file_problem
from mpma_mj.utils.text import did_you_mean

__all__ = ["load_class", "path_of"]

_PREFIX = "_mpma_mj_extension_"  # of the names of modules from files


def load_class(path: str, option: str, required: Sequence[str], *, base: type) -> type:
    """Import a class.

    Args:
        path: Where it is: my_agents.py:MyAgent, relative to the working directory, or
            package.module:MyAgent.
        option: Name of the option that named it.
        required: Names of the attributes that the class has to have.
        base: Class of this package from which it may inherit them.

    Raises:
        BadOptionError: File, module or class is missing, the module raises on import, or the
            class lacks an attribute or defines no abstract method.
    """
    home, _, name = path.rpartition(":")

    def refusal(expected: str, remedy: str = "") -> BadOptionError:
        return BadOptionError(option=option, value=path, expected=expected, remedy=remedy)

    if not home or not name.isidentifier():
        raise refusal("a path such as my_file.py:MyClass or package.module:MyClass")
    if home.endswith(".py") and (problem := file_problem(home, largest=SMALL_FILE)):
        raise refusal(f"a file of Python, but {Path(home).resolve()}: {problem}")
    try:
        module = _from_file(Path(home)) if home.endswith(".py") else importlib.import_module(home)
        found = getattr(module, name, None)  # which may import, too
    except (Exception, SystemExit) as error:  # whatever a module of somebody else's may raise
        cause = one_line(f"{type(error).__name__}: {error}")
        raise refusal(f"a module that can be imported ({cause})") from None
    if found is None:
        classes = [key for key, value in vars(module).items() if inspect.isclass(value)]
        expected = f"a class of {home}, but it has no {name}"
        raise refusal(expected, did_you_mean(name, classes))
    if not inspect.isclass(found):
        raise refusal(f"a class, but {name} is an object of type {type(found).__name__}")
    abstract: frozenset[str] = getattr(found, "__abstractmethods__", frozenset())
    lacking = [n for n in required if n in abstract or not hasattr(found, n)]
    lacking += sorted(abstract.difference(required))
    if lacking:
        inherit = f"inherit from {base.__module__}.{base.__qualname__}, or "
        raise refusal(
            f"a class with {', '.join(lacking)}, which {name} lacks",
            f"{'' if issubclass(found, base) else inherit}add {'them' if lacking[1:] else 'it'}",
        )
    return found


def path_of(kind: type) -> str:
    """Return the path by which another process imports a class of a file; empty for others."""
    if not kind.__module__.startswith(_PREFIX):
        return ""
    return f"{sys.modules[kind.__module__].__file__}:{kind.__qualname__}"


def _from_file(path: Path) -> ModuleType:
    """Return the module of a file, which is executed the first time only.

    It has a name that no other module has, under which dataclasses and pickle find it.
    """
    file = path.resolve()
    name = f"{_PREFIX}{hashlib.sha256(str(file).encode()).hexdigest()[:16]}"
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None, "files that end in .py have a loader"
    assert spec.loader is not None
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module
