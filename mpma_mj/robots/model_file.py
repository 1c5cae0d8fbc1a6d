"""Model files of users, looked through first: MuJoCo bounds neither its time nor its memory."""

from __future__ import annotations

import math
import os
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.parsers import expat

import mujoco

from mpma_mj.errors import BadOptionError
from mpma_mj.robots.urdf import mend_urdf
from mpma_mj.utils.input_files import MISSING, SMALL_FILE, file_problem

__all__ = ["read_model_file"]

# Bounds far beyond any arms (choices); the compiler takes seconds at each of them.
_ELEMENTS = 10_000  # of all files, after replication
_CELLS = 2**26  # of all grids, pictures and arrays
_FILE = 200_000_000  # bytes of a mesh or picture
_DEPTH = 10  # of files that include one another
_MEMORY = 2**32  # bytes
_ITERATIONS = 10_000
_TIMESTEP = (1e-5, 1.0)  # s

# Attributes whose product is how many elements, or cells, an element stands for.
_ELEMENTS_OF = dict.fromkeys(("replicate", "composite", "flexcomp"), ("count",))
_CELLS_OF = {
    "hfield": ("nrow", "ncol"),
    "texture": ("width", "height"),
    "mesh": ("params",),
    "user": ("dim",),
    "contact": ("num",),
    "global": ("offwidth", "offheight"),
    "quality": ("shadowsize", "shadowsize"),
}
_SIZES = 64  # cells that each of the numbers of `size` reserves (choice)
_FOLDERS = ("assetdir", "meshdir", "texturedir")
_PACKAGE = "package://"
_PNG = b"\x89PNG\r\n\x1a\n"

Element = tuple[str, dict[str, str], float]
"""Name, attributes and number of copies."""


def read_model_file(path: Path) -> mujoco.MjSpec:
    """Read an MJCF or URDF file.

    Args:
        path: The file.

    Returns:
        The model, which compiles in bounded time and memory.

    Raises:
        BadOptionError: It has more than any arms need, or it or a file that it names is none
            that can be read.
        ValueError: MuJoCo cannot read it.
    """
    _Size(path).add(path)
    spec = mujoco.MjSpec.from_file(os.fsencode(path))  # the name may not be UTF-8
    for mesh in spec.meshes:
        mesh.file = _in_packages(path, mesh.file)
    if path.suffix.lower() == ".urdf":
        mend_urdf(spec)
    option = spec.option
    low, high = _TIMESTEP
    if not low <= option.timestep <= high:
        raise BadOptionError(
            f"{path}: timestep is {option.timestep:g} s; expected {low:g} to {high:g} s"
        )
    for name in ("iterations", "ls_iterations", "noslip_iterations", "ccd_iterations"):
        _check_most(path, getattr(option, name), _ITERATIONS, name)
    _check_most(path, spec.memory, _MEMORY, "bytes of memory")
    return spec


def _check_most(path: Path, number: float, most: int, what: str) -> None:
    """Check that a model is not too large; raises a BadOptionError."""
    if not number <= most:
        raise BadOptionError(f"{path}: has {number:,.0f} {what}; expected at most {most:,}")


class _Size:
    """Number of elements and cells of a model, with all files that it names."""

    def __init__(self, path: Path) -> None:
        """Start with nothing; `path` is that of the model."""
        self._path = path
        self._elements = self._cells = 0.0
        self._folders = {path.parent}

    def add(self, path: Path, copies: float = 1.0, around: tuple[Path, ...] = ()) -> None:
        """Add a file with all files that it names.

        Args:
            path: The file.
            copies: How often the model has its elements.
            around: Files around it, each of which includes the next.
        """
        if problem := file_problem(path, largest=SMALL_FILE):
            raise BadOptionError(f"{path}: {problem}; expected an MJCF file")
        if path.resolve() in around:
            raise BadOptionError(f"{self._path}: includes {path} in itself; leave that out")
        _check_most(self._path, len(around), _DEPTH, f"files in one another, the last is {path}")
        around = (*around, path.resolve())
        elements = self._elements_of(path, copies)
        for name, attributes, _ in elements:
            if name == "compiler":
                self._folders |= {path.parent / attributes.get(key, "") for key in _FOLDERS}
        attached = sum(copies for name, _, copies in elements if name == "attach")
        for name, attributes, copies in elements:
            self._add_cells(name, attributes, copies)
            for key in attributes if name != "key" else ():
                if key.startswith("file"):
                    for file in self._places(path, attributes[key]):
                        if name == "include":
                            self.add(file, copies, around)
                        elif name == "model":
                            self.add(file, 1.0 + attached, around)
                        else:
                            self._add_file(file)

    def _elements_of(self, path: Path, copies: float) -> list[Element]:
        """Return the elements of a file, counted."""
        elements: list[Element] = []
        stack = [copies]

        def start(name: str, attributes: dict[str, str]) -> None:
            number = stack[-1] * _product(attributes, _ELEMENTS_OF.get(name, ()))
            elements.append((name, attributes, stack[-1]))
            stack.append(number if name == "replicate" else stack[-1])
            self._elements += number
            _check_most(self._path, self._elements, _ELEMENTS, "elements")

        def refuse(*_: object) -> None:
            raise BadOptionError(f"{path}: declares a document type, which MJCF has not; remove it")

        parser = expat.ParserCreate("utf-8")  # whatever it declares: MuJoCo reads nothing else
        parser.StartElementHandler, parser.EndElementHandler = start, lambda _: stack.pop()
        parser.StartDoctypeDeclHandler = refuse  # for entities that are made of one another
        try:
            parser.Parse(path.read_bytes(), True)
        except expat.ExpatError as error:
            raise BadOptionError(
                f"{path}: is no MJCF file: no XML in UTF-8 ({error}); correct it"
            ) from None
        return elements

    def _add_cells(self, name: str, attributes: Mapping[str, str], copies: float) -> None:
        """Add the cells of an element."""
        if name == "size":
            sizes = [_product(attributes, [key]) for key in attributes if key.startswith("n")]
            cells = _SIZES * sum(sizes)
        else:
            keys = _CELLS_OF.get(name, ())
            cells = _product(attributes, keys) if set(keys) & attributes.keys() else 0.0
        self._cells += copies * cells
        _check_most(self._path, self._cells, _CELLS, f"cells, the last of them by <{name}>")

    def _places(self, path: Path, name: str) -> list[Path]:
        """Return where a file may lie that another one names, where there is something."""
        folders = {path.parent, *self._folders}
        name = _in_packages(path, name)
        # The name alone for <compiler strippath="true"/>.
        tries = {folder / kind for folder in folders for kind in (name, Path(name).name)}
        return [place for place in sorted(tries) if file_problem(place) != MISSING]

    def _add_file(self, path: Path) -> None:
        """Add a mesh, picture or the like."""
        if problem := file_problem(path, largest=_FILE):
            raise BadOptionError(f"{self._path}: names {path}, which {problem}")
        with path.open("rb") as file:
            head = file.read(24)
        if head.startswith(_PNG) and len(head) == 24:
            self._cells += math.prod(struct.unpack(">II", head[16:]))
            _check_most(self._path, self._cells, _CELLS, f"cells, the last of them by {path}")


def _in_packages(path: Path, name: str) -> str:
    """Return where a file of a ROS package is, `package://…`, as URDF has it; others as they are.

    The package is a folder beside the model, or beside one of the folders around it.
    """
    if not name.startswith(_PACKAGE):
        return name
    inside = name.removeprefix(_PACKAGE).lstrip("/")
    places = (folder / inside for folder in path.absolute().parents)
    return str(next((place for place in places if file_problem(place) != MISSING), name))


def _product(attributes: Mapping[str, str], names: Sequence[str]) -> float:
    """Return the product of the numbers in some attributes, each 1 where MuJoCo refuses it."""
    product = 1.0
    for name in names:
        for word in attributes.get(name, "").split():
            try:
                product *= abs(float(word))
            except ValueError:
                continue
    return product
