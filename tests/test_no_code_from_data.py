"""No file that is read, whatever it names, leads to code: only what the user names is imported."""

import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mpma_mj
from mpma_mj.agents import MPMAConfig
from mpma_mj.cli import main
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import MpmaError
from mpma_mj.robots.robot_file import read_robot
from mpma_mj.training.config import RunConfig
from mpma_mj.training.run import resume
from mpma_mj.training.run_folder import RunFolder, open_runs
from mpma_mj.utils import data_files

TRAP = "open('sprung', 'w')\nclass Evil:\n    name = 'evil'\n"
NAMES = ("evil:Evil", "evil.py:Evil", "evil", "os:system", "mpma_mj.agents.mpma:MPMA\nevil:Evil")


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run of one epoch."""
    path = tmp_path_factory.mktemp("runs") / "run"
    env = EnvironmentOptions(arms="kinematic", repeats=1)
    agent = MPMAConfig(nodes=10, modules=2)
    return mpma_mj.imitate("ymca", agent=agent, env=env, epochs=1).save(path)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the working directory, which has a module that shows when it is imported."""
    (tmp_path / "evil.py").write_text(TRAP)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "evil", raising=False)
    return tmp_path


def test_the_trap_works(here: Path) -> None:
    assert main(["imitate", "ymca", "--agent", "evil:Evil", "--no-video"]) == 2
    assert (here / "sprung").exists()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("option", ["agent", "rule", "rule object", "own rule"])
def test_a_run_folder_imports_nothing(trained: Path, here: Path, option: str, name: str) -> None:
    folder = shutil.copytree(trained, here / "run")
    content = data_files.read_json(folder / "config.json")
    agent = content["config"]["agent"]
    if option == "agent":
        agent["name"] = name
    elif option == "rule":
        agent["rule"] = name
    else:
        own = "mpma_mj.agents.learning_rules:importlib" if option == "own rule" else name
        agent["rule"] = {"class": own, "options": {"name": "evil"}}
    data_files.write_json(folder / "config.json", content)
    for file in ("best", "latest"):  # so that the checkpoints belong to this config
        state, meta = data_files.read_arrays(folder / f"checkpoint/{file}.npz", "checkpoint")
        meta["config"] = content["config"]
        data_files.write_arrays(folder / f"checkpoint/{file}.npz", "checkpoint", state, meta)
    for words in (
        ["play", "run", "--out", "a.csv"],
        ["evaluate", "run", "--disturbances", "payload", "--levels", "1", "--out", "evaluation"],
        ["analyse", "run", "lesion", "--fine-tune", "0"],
        ["analyse", "run", "free-running"],
        ["imitate", "--resume", "run", "--epochs", "1", "--no-video"],
        ["imitate", "ymca", "--init", "run", "--epochs", "1", "--no-video", "--out", "new"],
        ["record", "run", "--out", "dataset", "--episodes", "1"],
        ["motion", "run"],
    ):
        assert main(words) in (0, 2), words
    api: tuple[Callable[[], Any], ...] = (
        lambda: mpma_mj.load_agent(folder),
        lambda: resume(RunFolder(folder), 1),
        lambda: open_runs([folder])[0].read_config(),
        lambda: RunConfig.from_json(content["config"]),
        lambda: mpma_mj.imitate("ymca", init=folder, epochs=1),
    )
    for call in api:
        try:
            call()
        except (MpmaError, ValueError, KeyError, TypeError):
            continue
    assert not (here / "sprung").exists()
    assert "evil" not in sys.modules


@pytest.mark.parametrize("name", NAMES)
def test_the_folder_of_a_study_imports_nothing(here: Path, name: str) -> None:
    header = {"kind": "study", "format": data_files.FORMAT, "study": name, "settings": {}}
    (here / "sweep").mkdir()
    data_files.write_json(here / "sweep" / "study.json", header)
    assert main(["sweep", "ymca", "--runs", "1", "--workers", "1", "--out", "sweep"]) == 2
    assert main(["study", "agents", "--runs", "1", "--workers", "1", "--out", "sweep"]) == 2
    assert not (here / "sprung").exists()


@pytest.mark.parametrize("name", ["evil:Evil", "evil.py", "evil.so"])
def test_recordings_models_and_maps_import_nothing(here: Path, name: str) -> None:
    text = read_robot("two_arm").model.read_text()
    extension = f'<extension><plugin plugin="{name}"><instance name="a"/></plugin></extension>'
    model = text.replace("</mujoco>", f"{extension}</mujoco>")
    (here / "robot.xml").write_text(model)
    (here / "map.toml").write_text(f'left_elbow = "{name}"\n"{name}" = "os:system"\n')
    (here / "dance.csv").write_text(f"time,{name}_x,{name}_y,{name}_z\n" + "0,1,2,3\n0.1,1,2,3\n")
    np.savez(
        here / "dance.npz", rate=20.0, labels=np.array([name]), pose=np.array([Bomb()], object)
    )
    (here / "dance.pkl").write_bytes(b"cevil\nEvil\n.")
    for words in (
        ["imitate", "ymca", "--robot", "robot.xml", "--epochs", "1", "--no-video", "--out", "a"],
        ["motion", "dance.csv", "--map", "map.toml"],
        ["motion", "dance.csv"],
        ["motion", "dance.npz"],
        ["motion", "dance.pkl"],
    ):
        assert main(words) == 2, words
    assert not (here / "sprung").exists()


@pytest.mark.parametrize(
    "place",
    [
        'package = "evil"\nfile = "evil.sub/arms.xml"',
        'package = "evil.sub"\nfile = "evil/arms.xml"',
        'description = "evil"',
        'description = "../evil"',
        'menagerie = "evil"\nfile = "evil.py"',
        'file = "evil.py"',
    ],
)
def test_robot_files_import_nothing(here: Path, place: str) -> None:
    arms = 'left = ["a", "b", "c", "d"]\nright = ["e", "f", "g", "h"]\nforearm = "tip"\n'
    head = 'name = "evil"\ntitle = "Evil"\nlicence = "?"\n[model]\n'
    (here / "evil.toml").write_text(f"{head}{place}\nup = [0, 0, 1]\n{arms}")
    assert main(["imitate", "ymca", "--robot", "evil.toml", "--no-video", "--out", "a"]) == 2
    assert not (here / "sprung").exists()
    assert "evil" not in sys.modules


class Bomb:
    """What springs the trap when it is unpickled."""

    def __reduce__(self) -> tuple[Any, ...]:
        return exec, ("open('sprung', 'w')",)
