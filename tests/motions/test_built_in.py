import shutil
from collections.abc import Callable
from pathlib import Path

import gymnasium
import numpy as np
import pytest

import mpma_mj
from mpma_mj.errors import BadOptionError, UnknownMotionError
from mpma_mj.motions import BUILT_IN, read_motion, save_motion
from mpma_mj.motions.built_in import HAND_MADE, built_in, file_stem
from mpma_mj.motions.semaphore import semaphore
from mpma_mj.training.dataset import expand_folders
from tests.conftest import Refused

SPELLED = "semaphore:hi you"


@pytest.mark.parametrize("name", [*BUILT_IN, SPELLED])
def test_every_name_is_that_of_a_motion(name: str) -> None:
    make = built_in(name)
    assert make is not None
    motion = read_motion(name, rate=10.0)
    np.testing.assert_array_equal(motion.posture, make(10.0, 1.0).posture)
    assert motion.name == file_stem(name)


def test_help_and_errors_name_every_dance() -> None:
    dances = [name for name in BUILT_IN if not name.startswith("synthetic")]
    assert ", ".join([*dances, "semaphore:WORD"]) == HAND_MADE


@pytest.mark.parametrize(
    ("source", "stem"),
    [
        ("ymca", "ymca"),
        ("semaphore: a  B ", "semaphore-A-B"),
        ("mocap/dance.c3d", "dance"),
        ("./semaphore:HI.npz", "semaphore:HI"),
    ],
)
def test_files_are_called_as_the_motion(source: str, stem: str) -> None:
    assert file_stem(source) == stem


def test_a_file_or_folder_of_such_a_name_can_be_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    motion = semaphore("OTHER")
    save_motion(tmp_path / "semaphore:A" / "dance.npz", motion)
    shutil.copy(tmp_path / "semaphore:A" / "dance.npz", "semaphore:HI")
    assert read_motion("semaphore:HI").name == "semaphore-HI"
    assert read_motion("./semaphore:HI").name == motion.name
    (tmp_path / "ymca").mkdir()
    assert expand_folders(["semaphore:A", "ymca"]) == ("semaphore:A", "ymca")
    (path,) = expand_folders(["./semaphore:A"])
    assert read_motion(path).name == motion.name
    assert read_motion("semaphore:A").name == "semaphore-A"


LIBRARY: list[Callable[[str], object]] = [
    read_motion,
    mpma_mj.load,
    lambda motion: mpma_mj.make_vec(2, motion),
    lambda motion: gymnasium.make("mpma_mj:TwoArmImitation-v0", motion=motion),
    lambda motion: mpma_mj.imitate(motion, epochs=1),
]


@pytest.mark.parametrize("face", LIBRARY)
@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("semaphore:", "semaphore has no word; expected the letters A to Z"),
        ("semaphore", "semaphore has no word"),
        ("semaphore:AC/DC", "semaphore has no sign '/'; expected the letters A to Z, digits"),
    ],
)
def test_the_library_refuses_what_cannot_be_spelled(
    face: Callable[[str], object], source: str, message: str
) -> None:
    with pytest.raises(BadOptionError, match=message):
        face(source)


@pytest.mark.parametrize(
    "command",
    [
        "imitate {} --no-video",
        "motion {}",
        "play {} --out x.csv",
        "compare {} --no-video",
        "sweep {}",
        "study latency --motion {}",
        "study unseen synthetic-1 {}",
    ],
)
@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("semaphore:", "mpma: semaphore has no word; expected the letters A to Z"),
        ("semaphore:É", "mpma: semaphore has no sign 'É'; expected the letters A to Z, digits"),
        ("semphore:HI", "'semphore:HI'; expected"),
    ],
)
def test_the_command_line_refuses_it(
    command: str,
    source: str,
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    refused: Refused,
) -> None:
    monkeypatch.chdir(tmp_path)
    refused([word.format(source) for word in command.split()], message)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("source", "question"),
    [
        ("semphore:HELLO", "did you mean semaphore:HELLO?"),
        ("semaphor", "did you mean semaphore:WORD?"),
        ("semphore:{x}", "did you mean semaphore:WORD?"),
        ("Wave", "did you mean wave?"),
        ("ymca:fast", "did you mean ymca?"),
        ("macarena", "or the path of a recording"),
    ],
)
def test_an_unknown_name_is_answered_with_all_and_the_nearest(source: str, question: str) -> None:
    with pytest.raises(UnknownMotionError) as caught:
        read_motion(source)
    assert f"no motion '{source}'; expected {HAND_MADE}, synthetic" in str(caught.value)
    assert str(caught.value).endswith(question)
