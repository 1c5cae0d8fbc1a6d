"""Table of recordings whose true postures are known."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.import_cases import main, read_all
from mpma_mj.motions.export import export_motion
from tests.motions.known_motions import moving

TURN = 0.2  # rad


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with a true motion at 60 Hz, and recordings that are right and wrong."""
    angles = 0.5 + 0.3 * np.sin(np.arange(60)[:, None] / 12.0 + np.arange(8))
    truth = moving(angles, 60.0)
    table = np.column_stack([np.arange(60) / 60.0, truth.posture])
    np.savetxt(tmp_path / "truth.csv", table, delimiter=",", header="time", fmt="%.6f")
    export_motion(tmp_path / "right.bvh", truth)
    export_motion(tmp_path / "slow.trc", moving(angles, 20.0))
    export_motion(tmp_path / "longer.trc", moving(np.tile(angles, (2, 1)), 60.0))
    angles[:, 3] += TURN
    export_motion(tmp_path / "wrong.trc", moving(angles, 60.0))
    (tmp_path / "empty.csv").touch()
    (tmp_path / "README.md").write_text("no recording")
    return tmp_path


def test_each_recording_has_its_errors_or_its_refusal(folder: Path) -> None:
    cases = {case.name: case for case in read_all(folder)}
    assert set(cases) == {"right.bvh", "slow.trc", "longer.trc", "wrong.trc", "empty.csv"}
    refused = cases["empty.csv"]
    assert (refused.result, refused.message) == ("refused", "is empty; export the recording again")
    assert all(error.max() < 0.5 for error in cases["right.bvh"].errors)
    # At a third of the rate, frame for frame, as a format may declare no rate of its own.
    assert all(error.max() < 0.5 for error in cases["slow.trc"].errors)
    assert all(error.size == 0 for error in cases["longer.trc"].errors)
    largest = [error.max() for error in cases["wrong.trc"].errors]
    assert largest == pytest.approx([0.0, np.degrees(TURN), 0.0, 0.0], abs=0.5)
    assert cases["right.bvh"].joint_range == pytest.approx(0.6, abs=0.05)


def test_the_table_has_a_row_for_each_file(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(folder)
    head, _, *rows, empty, counts, worst = capsys.readouterr().out.splitlines()
    assert {row.count("|") for row in (head, *rows)} == {9}
    assert [row.split("|")[1].strip() for row in rows] == sorted(
        ["right.bvh", "slow.trc", "longer.trc", "wrong.trc", "empty.csv"]
    )
    assert (empty, counts.partition(":")[0]) == ("", "5 files")
    assert worst.startswith("largest error: 11.")
    assert worst.endswith("° of wrong.trc")
