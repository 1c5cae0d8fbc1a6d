"""Headers of TRC files as programs and people write them: right, or refused."""

from pathlib import Path

import numpy as np
import pytest

from mpma_mj.errors import MotionFileError
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.readers.recognise import open_recording
from mpma_mj.motions.readers.recording import Recording
from tests.motions.readers import writers

NAMES = "LSHO\t\t\tLELB\t\t\tLWRI\t\t\tRSHO\t\t\tRELB\t\t\tRWRI\t\t"


def read(path: Path, text: str) -> Recording:
    path.write_text(text)
    return open_recording(path, ImportReport())


@pytest.mark.parametrize(
    "names",
    [
        "LSHO\tLELB\tLWRI\tRSHO\tRELB\tRWRI",
        NAMES.replace("\t\t\t", "\t\t"),
        NAMES.replace("\t\t\tLWRI", "\t\tLWRI"),
        "\t" + NAMES,
    ],
)
@pytest.mark.parametrize("axes", ["\t\tX1", "X1", "no"])
def test_names_a_few_tabs_apart_are_in_order(tmp_path: Path, names: str, axes: str) -> None:
    points = writers.arm_points()
    text = writers.trc_text(points)
    assert NAMES in text
    lines = text.replace(NAMES, names).replace("\t\tX1", axes).splitlines()
    text = "\n".join(["" if line.startswith("no") else line for line in lines]) + "\n"
    recording = read(tmp_path / "dance.trc", text)
    for name, track in recording.load(recording.names).items():
        np.testing.assert_array_equal(track, points[name])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("\t60\t6\tmm", "\t60\t7\tmm", "6 names, 7 markers by NumMarkers"),
        ("\tZ6", "\tZ6\tX7\tY7\tZ7", "6 names, 6 markers by NumMarkers, 7 titles X"),
        ("\tRWRI", "", "5 names"),
        ("1350.0\n", "1350.0\t1.0\n", r"6\.333 columns in threes"),
    ],
)
def test_a_header_that_contradicts_itself_is_refused(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    text = writers.trc_text(writers.arm_points()).replace(NAMES, NAMES.replace("\t\t\t", "\t"))
    if old == "1350.0\n":
        lines = text.splitlines()
        text = "\n".join([*lines[:6], *(f"{line}\t1.0" for line in lines[6:])]) + "\n"
    else:
        assert old in text
        text = text.replace(old, new)
    with pytest.raises(MotionFileError, match=f"contradict each other: .*{message}"):
        read(tmp_path / "dance.trc", text)


@pytest.mark.parametrize("rate", ["100 Hz", "100,00", "100.0Hz", "1.0e2"])
def test_rates_may_have_a_unit_or_a_comma(tmp_path: Path, rate: str) -> None:
    text = writers.trc_text(writers.arm_points())
    recording = read(tmp_path / "dance.trc", text.replace("\n100\t", f"\n{rate}\t"))
    assert recording.rate == 100.0


def test_a_table_with_spaces_is_read(tmp_path: Path) -> None:
    points = writers.arm_points()
    text = writers.trc_text(points).replace("\t\t\t", "\t").replace("\t", "  ")
    recording = read(tmp_path / "dance.trc", text.replace("PathFile", "pathfile"))
    assert (recording.rate, recording.unit, recording.frames) == (100.0, 0.001, 60)
    for name, track in recording.load(recording.names).items():
        np.testing.assert_array_equal(track, points[name])


@pytest.mark.parametrize(("unit", "metres"), [("ft", 0.3048), ("Feet", 0.3048), ("m", 1.0)])
def test_units_are_read(tmp_path: Path, unit: str, metres: float) -> None:
    text = writers.trc_text(writers.arm_points()).replace("\tmm\t", f"\t{unit}\t")
    assert read(tmp_path / "dance.trc", text).unit == metres
