"""Input files: what is no regular file is refused by every reader before it is opened."""

import os
import signal
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import NoReturn

import pytest

from mpma_mj.errors import MpmaError
from mpma_mj.motions import read_motion
from mpma_mj.motions.audio_segments import bars
from mpma_mj.motions.context import read_labels
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.mapping import parse_mapping
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.motions.readers.recognise import open_recording
from mpma_mj.sysid.log import read_log
from mpma_mj.utils.input_files import file_problem, is_web_address
from tests.conftest import Refused

GIGABYTE = 1_000_000_000
# Each with the ending that it is known by.
READERS = {
    "recording.bvh": read_motion,
    "labels.csv": lambda path: read_labels(Path(path)),
    "sound.wav": lambda path: bars(Path(path)),
    "points.toml": parse_mapping,
    "bones.asf": lambda path: open_recording(_amc(), ImportReport(), ReadingOptions(skeleton=path)),
    "log.csv": read_log,
}


SPECIAL = {
    "pipe": "is a pipe, not a file; save its content to a file first",
    "socket": "is a socket, not a file; save its content to a file first",
    "device": "is a device, not a file; save its content to a file first",
    "folder": "is a folder; give the path of a file in it",
    "dead link": "is a link to a file that is not there",
    "loop": "cannot be read (Too many levels of symbolic links); check the path",
    "huge": "MB; expected at most",
    "nothing": "no such file; check the path",
}


def _amc() -> Path:
    path = Path("dance.amc")
    path.write_text(":FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 0 0 0 0 0\n")
    return path


@pytest.fixture(autouse=True)
def _in_a_folder_where_nothing_hangs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[None]:
    """End a test in which a file was opened that never ends."""

    def end(*_: object) -> NoReturn:
        raise AssertionError("a file was opened that never ends")

    monkeypatch.chdir(tmp_path)
    previous = signal.signal(signal.SIGALRM, end)
    signal.alarm(20)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, previous)


def _make(kind: str, name: str) -> None:
    match kind:
        case "pipe":
            os.mkfifo(name)
        case "socket":
            with socket.socket(socket.AF_UNIX) as opened:
                opened.bind(name)
        case "device":
            Path(name).symlink_to("/dev/zero")
        case "folder":
            Path(name).mkdir()
        case "dead link":
            Path(name).symlink_to("gone")
        case "loop":
            Path(name).symlink_to(name)
        case "huge":
            with Path(name).open("wb") as file:
                file.truncate(5 * GIGABYTE)  # sparse


@pytest.mark.parametrize("kind", SPECIAL)
@pytest.mark.parametrize("name", READERS)
def test_every_reader_refuses_what_is_no_file_in_one_line(name: str, kind: str) -> None:
    _make(kind, name)
    with pytest.raises(MpmaError) as caught:
        READERS[name](name)
    message = str(caught.value)
    assert f"{name}: " in message
    assert SPECIAL[kind] in message
    assert "\n" not in message


@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize("start", ["https://example.org/", "HTTP://example.org/", "s3://bucket/"])
def test_every_reader_refuses_a_web_address(name: str, start: str) -> None:
    with pytest.raises(MpmaError, match="is a web address; download it first") as caught:
        READERS[name](start + name)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "words",
    [
        *(["motion"], ["play"], ["imitate"], ["imitate", "ymca", "--labels"]),
        ["play", "--out", "a.csv"],
    ],
)
def test_commands_refuse_a_pipe_and_a_web_address(words: list[str], refused: Refused) -> None:
    os.mkfifo("x.csv")
    refused([*words, "x.csv"], "x.csv: is a pipe, not a file")
    refused([*words, "/dev/zero"], "/dev/zero: is a device, not a file")
    refused([*words, "https://example.org/x.csv"], "is a web address; download it first")


def test_what_lies_in_a_folder_is_checked_as_well(refused: Refused) -> None:
    Path("dances").mkdir()
    os.mkfifo("dances/x.csv")  # which may be a recording or labels
    refused(["imitate", "dances"], "dances/x.csv: is a pipe, not a file")
    Path("links").mkdir()
    Path("links/x.bvh").symlink_to("y.bvh")
    refused(["imitate", "links"], "links/x.bvh: is a link to a file that is not there; mend or")
    os.mkfifo("bones.asf")
    refused(["motion", str(_amc())], "bones.asf: is a pipe, not a file")


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("x" * 300, "cannot be read (File name too long); check the path"),
        ("a\0b", "cannot be read (embedded null byte); check the path"),
        ("file/in it", "cannot be read (Not a directory); check the path"),
        ("file", ""),
    ],
)
def test_names_that_no_file_has(name: str, problem: str) -> None:
    Path("file").touch()
    assert file_problem(name) == problem
    if problem:
        with pytest.raises(MpmaError) as caught:
            read_motion(name)
        assert problem in str(caught.value)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_that_may_not_be_read_is_refused() -> None:
    Path("file").touch(mode=0o000)
    assert file_problem("file") == "cannot be read; check its permissions"


def test_a_folder_that_is_named_like_a_web_address_is_none() -> None:
    assert is_web_address("https:/x")
    assert not is_web_address("https-x/y")
    Path("https:").mkdir()
    Path("https:/x").touch()
    assert file_problem("https:/x") == ""
