"""Places of models: installed packages, registries that download, and their absence."""

import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from mpma_mj.errors import BadOptionError
from mpma_mj.robots.model_sources import find_model

ROBOT = Path("robots/my.toml")
BESIDE = {"file": "my.xml"}


class UnreachableError(Exception):
    """What a registry raises."""


def menagerie(monkeypatch: pytest.MonkeyPatch, folder: Path, *, cached: bool, online: bool) -> None:
    """Install a registry whose only robot is h1."""

    def path(progress: None) -> Path:
        if not (cached or online):
            raise UnreachableError("https://x:\n no network")
        return folder

    def get(name: str) -> SimpleNamespace:
        if name != "h1":
            raise UnreachableError("Unknown robot")
        return SimpleNamespace(path=path)

    module = ModuleType("mujoco_menagerie")
    module.__dict__.update(
        get=get,
        Cache=lambda: SimpleNamespace(is_cached=lambda robot: cached),
        MenagerieError=UnreachableError,
    )
    monkeypatch.setitem(sys.modules, "mujoco_menagerie", module)


def descriptions(monkeypatch: pytest.MonkeyPatch, folder: Path, text: str) -> None:
    """Install descriptions, of which h1_description has some source text."""
    package = folder / "robot_descriptions"
    package.mkdir()
    package.joinpath("__init__.py").touch()
    package.joinpath("h1_description.py").write_text(text)
    monkeypatch.syspath_prepend(folder)
    for name in ("robot_descriptions", "robot_descriptions.h1_description"):
        monkeypatch.delitem(sys.modules, name, raising=False)


def distribution(monkeypatch: pytest.MonkeyPatch, folder: Path) -> Path:
    """Install a package with a model in `share`, and return its path."""
    model = folder / "share" / "my_models" / "v2" / "my.xml"
    model.parent.mkdir(parents=True)
    model.touch()
    site = folder / "lib" / "site-packages"
    info = site / "my_models-1.0.dist-info"
    info.mkdir(parents=True)
    info.joinpath("METADATA").write_text("Metadata-Version: 2.1\nName: my-models\nVersion: 1.0\n")
    info.joinpath("RECORD").write_text(f"../../{model.relative_to(folder).as_posix()},,\n")
    monkeypatch.syspath_prepend(site)
    return model


def test_a_model_is_beside_its_robot_file() -> None:
    assert find_model(ROBOT, [BESIDE]) == (0, Path("robots/my.xml"))


def test_a_package_is_found_wherever_it_installs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = distribution(monkeypatch, tmp_path)
    source = {"package": "my-models", "file": "my_models/v2/my.xml"}
    assert find_model(ROBOT, [source]) == (0, model.resolve())


def test_a_package_is_not_imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "editable_models"
    package.mkdir()
    package.joinpath("__init__.py").write_text("raise ImportError")
    package.joinpath("my.xml").touch()
    monkeypatch.syspath_prepend(tmp_path)
    source = {"package": "editable-models", "file": "editable_models/my.xml"}
    assert find_model(ROBOT, [source]) == (0, package / "my.xml")


@pytest.mark.parametrize("cached", [True, False])
def test_what_is_on_this_machine_comes_before_what_has_to_be_fetched(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cached: bool
) -> None:
    menagerie(monkeypatch, tmp_path, cached=cached, online=True)
    sources = [{"menagerie": "h1", "file": "h1.xml"}, BESIDE]
    expected = (0, tmp_path / "h1.xml") if cached else (1, Path("robots/my.xml"))
    assert find_model(ROBOT, sources) == expected
    assert find_model(ROBOT, sources[:1]) == (0, tmp_path / "h1.xml")


def test_a_description_is_cloned_in_silence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    text = "import sys\nprint('Cloning')\nsys.stderr.write('99 %')\nURDF_PATH = 'h1.urdf'\n"
    descriptions(monkeypatch, tmp_path, text)
    assert find_model(ROBOT, [{"description": "h1_description"}]) == (0, Path("h1.urdf"))
    assert capfd.readouterr() == ("", "")


def test_all_that_is_absent_is_said_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco_menagerie", None)
    monkeypatch.setitem(sys.modules, "robot_descriptions", None)
    sources = [
        {"menagerie": "h1", "file": "h1.xml"},
        {"package": "no-such-package", "file": "no_such_package/h1.xml"},
        {"description": "h1_description"},
    ]
    with pytest.raises(BadOptionError) as caught:
        find_model(ROBOT, sources)
    assert str(caught.value) == (
        f"{ROBOT}: finds no model: pip install 'mpma-mj[robots]', or pip install --no-deps"
        " no-such-package, or pip install robot_descriptions"
    )


@pytest.mark.parametrize("name", ["h1", "h2"])
def test_a_registry_that_cannot_be_reached_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    menagerie(monkeypatch, tmp_path, cached=False, online=False)
    descriptions(monkeypatch, tmp_path, "raise RuntimeError('cmd failed\\n git')")
    with pytest.raises(BadOptionError) as caught:
        find_model(
            ROBOT,
            [{"menagerie": name, "file": "h1.xml"}, {"description": f"{name}_description"}],
        )
    message = str(caught.value)
    assert f"mujoco_menagerie cannot fetch {name} (" in message
    assert f"robot_descriptions cannot fetch {name}_description (" in message
    assert ("no network" in message) == (name == "h1")
    assert "check the network" in message
    assert "\n" not in message
