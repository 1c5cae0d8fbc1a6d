"""Videos of episodes."""

import copy
import os
from pathlib import Path

import imageio.v2 as imageio
import numpy as np
import pytest

from mpma_mj.envs.wrappers import RecordVideo
from mpma_mj.errors import (
    BadOptionError,
    RunFolderError,
    StateError,
    VideoError,
)
from tests.conftest import Encoder
from tests.envs.episodes import assert_same, at_random, danced, ymca
from tests.envs.test_gl import python


def test_a_recording_wrapper_cannot_be_copied(tmp_path: Path) -> None:
    with pytest.raises(
        StateError, match="cannot be pickled or copied; copy the environment inside"
    ):
        copy.deepcopy(RecordVideo(ymca(), tmp_path / "a.mp4"))


@pytest.mark.usefixtures("opengl")
def test_every_episode_has_a_video(tmp_path: Path) -> None:
    env = RecordVideo(ymca(), tmp_path / "new" / "{episode}.mp4")
    plain = ymca()
    for number in range(2):
        assert_same(danced(env, at_random(number)), danced(plain, at_random(number)))
        assert sorted(p.name for p in (tmp_path / "new").iterdir()) == [
            f"{i}.mp4" for i in range(number + 1)
        ]
    env.close()
    reader = imageio.get_reader(tmp_path / "new" / "1.mp4")
    assert reader.get_meta_data()["fps"] == pytest.approx(1.0 / env.control_timestep())
    frames = [np.asarray(frame, float) for frame in reader]
    assert len(frames) == env.task.steps + 1
    assert frames[0].shape == (480, 640, 3)
    assert np.abs(frames[0] - frames[40]).max() > 50


@pytest.mark.usefixtures("opengl")
def test_a_video_has_its_name_once_it_is_complete(tmp_path: Path) -> None:
    path = tmp_path / "dance.mp4"
    with RecordVideo(ymca(), path, camera="side") as env:
        env.reset()
        assert list(tmp_path.iterdir()) == []
        for _ in range(4):
            env.step(np.zeros(8))
        assert not path.exists()
    assert list(tmp_path.iterdir()) == [path]
    assert sum(1 for _ in imageio.get_reader(path)) == 4


@pytest.mark.usefixtures("opengl")
def test_an_episode_that_is_broken_off_has_a_video_unless_it_has_no_step(tmp_path: Path) -> None:
    env = RecordVideo(ymca(), tmp_path / "{episode}.mp4")
    for steps in (2, 0, 3):
        env.reset()
        for _ in range(steps):
            env.step(np.zeros(8))
    env.reset()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["0.mp4", "2.mp4"]
    assert [sum(1 for _ in imageio.get_reader(tmp_path / f"{i}.mp4")) for i in (0, 2)] == [2, 3]
    env.close()


@pytest.mark.usefixtures("opengl")
def test_a_video_that_fails_leaves_nothing_and_the_episode_goes_on(
    tmp_path: Path, encoder: Encoder
) -> None:
    encoder("exit 3")
    env = RecordVideo(ymca(), tmp_path / "dance.mp4")
    env.reset()
    with pytest.raises(
        VideoError, match=r"dance\.mp4: the video was not written: ffmpeg failed: exit code 3"
    ):
        env.step(np.zeros(8))
    assert list(tmp_path.iterdir()) == []
    env.step(np.zeros(8))
    env.close()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize("leave", ["reset", "close"])
def test_a_video_whose_end_cannot_be_written_leaves_the_one_before(
    leave: str, tmp_path: Path, encoder: Encoder
) -> None:
    path = tmp_path / "dance.mp4"
    with RecordVideo(ymca(), path) as env:
        env.reset()
        env.step(np.zeros(8))
    old = path.read_bytes()
    encoder('cat > /dev/null; echo half > "$video"; exit 228')
    env = RecordVideo(ymca(), path)
    env.reset()
    env.step(np.zeros(8))
    with pytest.raises(VideoError, match="exit code 228"):
        getattr(env, leave)()
    assert path.read_bytes() == old
    assert list(tmp_path.iterdir()) == [path]
    env.close()


@pytest.mark.usefixtures("opengl")
def test_an_impossible_folder_is_reported_at_the_first_step(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    env = RecordVideo(ymca(), tmp_path / "file" / "dance.mp4")
    env.reset()
    with pytest.raises(RunFolderError, match="is a file, not a folder"):
        env.step(np.zeros(8))


def test_invalid_paths_and_cameras_are_refused(tmp_path: Path) -> None:
    for name in ("{ep}.mp4", "{}.mp4", "{episode:03d}.mp4"):
        with pytest.raises(BadOptionError, match=r"expected no braces but those of \{episode\}"):
            RecordVideo(ymca(), tmp_path / name)
    for path in (tmp_path / "dance.gif", None, 3, b"dance.mp4"):
        with pytest.raises(BadOptionError, match=r"ends in \.mp4"):
            RecordVideo(ymca(), path)  # type: ignore[arg-type]
    with pytest.raises(BadOptionError, match="front, side, three_quarter"):
        RecordVideo(ymca(), tmp_path / "dance.mp4", camera="above")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
@pytest.mark.usefixtures("opengl")
def test_a_forked_process_leaves_the_video_to_its_parent(tmp_path: Path) -> None:
    code = f"""
import gc, mpma_mj, numpy as np, os, signal
from mpma_mj.envs.wrappers import RecordVideo
from mpma_mj.errors import RenderingError
env = RecordVideo(mpma_mj.load("ymca", repeats=1), {str(tmp_path / "a.mp4")!r})
env.reset(), env.step(np.zeros(8))
if not os.fork():
    signal.alarm(60)  # it would hang
    try: env.step(np.zeros(8))
    except RenderingError as error: print(error, flush=True)
    env.close()
    os._exit(0)
print(os.wait()[1])
env.step(np.zeros(8)), env.close()
"""
    result = python(code)
    refusal, status = result.stdout.splitlines()
    assert refusal.startswith("no picture: this process was forked"), result.stderr
    assert (status, result.stderr) == ("0", "")
    assert sum(1 for _ in imageio.get_reader(tmp_path / "a.mp4")) == 2
