"""Pages that play a scene: what they contain, and how large they are."""

import base64
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mpma_mj.cli import main
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.visualization.colours import hex_to_rgb, module_colours
from tests.conftest import Refused
from tests.robots.small_robot import installed


def test_without_viser_it_is_said_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refused: Refused
) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    message = (
        "pages need viser, which is not installed; pip install 'mpma-mj[web]', or in a checkout"
    )
    refused(["play", "ymca", "--out", str(tmp_path / "a.html")], message)
    assert list(tmp_path.iterdir()) == []


def page_of(source: Path, path: Path, *words: str) -> str:
    pytest.importorskip("viser")
    assert main(["play", str(source), "--out", str(path), *words]) == 0
    return path.read_text("utf-8")


def recording_of(page: str) -> dict[str, Any]:
    """Return what a page plays."""
    msgspec, zstandard = pytest.importorskip("msgspec"), pytest.importorskip("zstandard")
    found = re.search(r'__VISER_EMBED_DATA__="([^"]+)"', page)
    assert found
    content = zstandard.ZstdDecompressor().decompress(base64.b64decode(found[1])[8:])
    length = int.from_bytes(content[:8], "little")
    return msgspec.msgpack.decode(content[8 : 8 + length])


def test_a_page_has_bars_and_letter_of_each_step(
    small_run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.html"
    page = page_of(small_run, path, "--from", "1", "--to", "6")
    assert capsys.readouterr().out == f"{path}\n"
    trace = RunFolder(small_run).read_trace().cut(20, 120)
    recording = recording_of(page)
    assert recording["durationSeconds"] == pytest.approx(5.0)
    letters, heights = {}, {}
    for time, message in recording["messages"]:
        updates = dict(message.get("updates", {}))
        if message.get("name") == "/label" and "text" in updates:
            letters[round(time, 2)] = updates["text"]
        if message.get("name") == "/responsibility/1" and "scale" in updates:
            heights[round(time, 2)] = updates["scale"][2]
    assert list(letters.values())[:5] == list("MCAYM")
    steps = [round(20.0 * time) for time in heights]
    assert len(steps) > 20
    expected = np.maximum(trace.with_modules().responsibility[steps, 0].round(2), 0.002)
    np.testing.assert_allclose(list(heights.values()), expected, atol=1e-6)
    boxes = [m for _, m in recording["messages"] if m["type"] == "BoxMessage"]
    colours = [tuple(box["props"]["color"]) for box in boxes]
    assert colours == [hex_to_rgb(colour) for colour in module_colours(len(colours))]
    assert len(colours) == trace.with_modules().responsibility.shape[1]


def test_without_captions_a_page_has_neither(tmp_path: Path) -> None:
    recording = recording_of(page_of(Path("ymca"), tmp_path / "a.html", "--no-captions"))
    kinds = {message["type"] for _, message in recording["messages"]}
    assert "MeshMessage" in kinds
    assert not kinds & {"BoxMessage", "LabelMessage"}


def test_ten_seconds_are_a_file_that_can_be_sent(small_run: Path, tmp_path: Path) -> None:
    page_of(small_run, tmp_path / "a.html", "--to", "10")
    assert (tmp_path / "a.html").stat().st_size < 1_200_000


@pytest.mark.filterwarnings("ignore:ymca")
@pytest.mark.parametrize(("robot", "largest"), [("cmu_humanoid", 1_200_000), ("h1", 6_000_000)])
def test_a_page_of_a_robot_can_be_sent_too(robot: str, largest: int, tmp_path: Path) -> None:
    installed(robot)
    page = page_of(Path("ymca"), tmp_path / "a.html", "--robot", robot)
    assert (tmp_path / "a.html").stat().st_size < largest
    meshes = [m for _, m in recording_of(page)["messages"] if m["type"] == "MeshMessage"]
    assert len(meshes) > 20
