"""The comparison of arms, and its command as a user types it."""

import csv
import dataclasses
import json
import shutil
import subprocess
import sys
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest

from mpma_mj.cli import main
from mpma_mj.envs.model import MODEL_PATH
from mpma_mj.experiments.backend import open_backend
from mpma_mj.experiments.compare import ARMS, NOTHING, Cell, CompareJob, compare, jobs
from mpma_mj.experiments.compare_figure import first_dances, write_dances, write_transfer
from mpma_mj.experiments.compare_table import as_csv, as_markdown
from mpma_mj.experiments.compare_video import write_side_by_side
from mpma_mj.motions import ymca
from mpma_mj.trace import Trace
from mpma_mj.training.config import RunConfig
from mpma_mj.training.run_folder import RunFolder

SMALL = tuple(RunConfig.of(nodes=20, modules=2, repeats=1, seed=seed) for seed in (0, 1))


@pytest.fixture(scope="module")
def cells() -> list[Cell]:
    cells = {job.learned: job.do() for job in jobs(SMALL, ymca(), epochs=8, adaptation=2)}
    return [cell for learned in (NOTHING, *ARMS) for cell in cells[learned]]


def test_every_agent_dances_on_every_kind_of_arms(cells: list[Cell]) -> None:
    pairs = [(cell.learned, cell.danced) for cell in cells]
    assert pairs == [(a, b) for a in (NOTHING, *ARMS) for b in ARMS]
    assert all(len(cell.dances) == 2 for cell in cells)
    dances = [dance for cell in cells for dance in cell.dances if dance]
    assert {len(dance.trace.action) for dance in dances} == {len(ymca()) - 1}


def test_a_users_arms_are_compared_as_they_are(tmp_path: Path) -> None:
    own = tmp_path / "strong.xml"
    text = MODEL_PATH.read_text(encoding="utf-8")
    own.write_text(text.replace('kv="20"', 'kv="40"'), encoding="utf-8")
    config = RunConfig.of(agent="single", nodes=5, repeats=1)

    def torque(config: RunConfig) -> float:
        job = CompareJob(NOTHING, (config,), ymca(), epochs=1, adaptation=1)
        return job.do()[1].values("mean_torque_nm")[0]

    assert torque(config.replace(model=str(own))) > 1.1 * torque(config)


def test_workers_bring_the_same_in_the_same_order(cells: list[Cell]) -> None:
    with open_backend("processes", 2, None) as backend:
        found = compare(jobs(SMALL, ymca(), epochs=8, adaptation=2), backend)
    assert as_csv(found) == as_csv(cells)


def test_feedback_alone_is_a_step_behind_and_who_has_learned_is_not(cells: list[Cell]) -> None:
    for cell in cells:
        expected = 50.0 if cell.learned == NOTHING else 0.0
        assert cell.values("lag_ms") == pytest.approx([expected] * 2, abs=15.0)
        if cell.learned == NOTHING:
            assert np.isnan(cell.adapted).all()
            assert cell.values("feedback_ratio") == pytest.approx([1.0] * 2)
        else:
            assert np.isfinite(cell.adapted).all()


def test_weight_costs_torque_and_ideal_arms_have_none(cells: list[Cell]) -> None:
    torque = {(c.learned, c.danced): c.values("mean_torque_nm") for c in cells}
    for learned in (NOTHING, *ARMS):
        assert torque[learned, "kinematic"] == []
        assert min(torque[learned, "physics"]) > max(torque[learned, "compensated"]) > 0.0


def test_tables_have_a_row_for_each_pair_and_each_agent(cells: list[Cell]) -> None:
    lines = as_markdown(cells, 2).splitlines()
    assert lines[0].startswith("| learned on | danced on | epochs | p_e, % | after 2 epochs |")
    assert sum(line.startswith("| nothing |") for line in lines) == 3
    assert lines[2].count("–") == 5  # epochs, adapted, torques and work
    rows = list(csv.DictReader(as_csv(cells).splitlines()))
    assert len(rows) == 12 * 2
    of_last = cells[-1].dances[1]
    assert of_last is not None
    assert float(rows[-1]["p_e_percent"]) == of_last.measures["p_e_percent"]
    assert rows[0]["work_j"] == rows[0]["adapted_p_e_percent"] == rows[0]["epochs"] == ""


def test_a_dance_that_diverged_is_told_and_counts_in_no_mean(cells: list[Cell]) -> None:
    last = cells[-1]
    lost = Cell(
        last.learned, last.danced, last.seeds, last.epochs, (None, last.dances[1]), last.adapted
    )
    table = as_markdown([*cells[:-1], lost], 2)
    assert "1 of 24 dances diverged; they count in no mean." in table
    assert len(lost.values("p_e_percent")) == 1
    assert "diverged" not in as_markdown(cells, 2)


def test_the_command_writes_tables_and_figures(tmp_path: Path) -> None:
    out = tmp_path / "out"
    words = "compare ymca --runs 1 --nodes 10 --modules 2 --epochs 2 --adaptation 1 --no-video"
    command = [sys.executable, "-m", "mpma_mj.cli", *words.split(), "--out", str(out)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert result.stdout.splitlines()[-1] == str(out)
    told = sorted(line.split()[-1] for line in result.stderr.splitlines())
    assert told == sorted([NOTHING, *ARMS])
    assert (out / "compare.md").read_text().strip() in result.stdout
    assert json.loads((out / "compare.json").read_text())["runs"] == 1
    for picture in ("transfer.png", "dances.png"):
        assert (out / picture).read_bytes().startswith(b"\x89PNG")
    assert {path.name for path in out.iterdir()} == {
        *("compare.md", "compare.csv", "compare.json", "transfer.png", "dances.png"),
    }


def test_a_comparison_in_the_folder_of_a_run_leaves_the_run(
    small_run: Path, tmp_path: Path
) -> None:
    folder = RunFolder(shutil.copytree(small_run, tmp_path / "run"))
    before = folder.read_config()
    words = "compare ymca --runs 1 --nodes 5 --modules 2 --epochs 1 --adaptation 1 --no-video"
    assert main([*words.split(), "--out", str(folder.path)]) == 0
    assert folder.read_config() == before


def test_a_movement_that_is_danced_once_is_drawn_too(cells: list[Cell], tmp_path: Path) -> None:
    write_dances(tmp_path / "dances.png", cells, ymca())
    assert (tmp_path / "dances.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.filterwarnings("error")
def test_where_all_diverged_there_are_pictures_and_no_dances(
    cells: list[Cell], tmp_path: Path
) -> None:
    lost = [
        dataclasses.replace(cell, dances=(None, None), adapted=np.full(2, np.nan)) for cell in cells
    ]
    assert first_dances(lost) == {}
    write_transfer(tmp_path / "transfer.png", lost, 2)
    write_dances(tmp_path / "dances.png", lost, ymca())
    assert "24 of 24 dances diverged" in as_markdown(lost, 2)


@pytest.mark.usefixtures("opengl")
def test_the_video_has_all_arms_side_by_side_and_every_step(
    cells: list[Cell], tmp_path: Path
) -> None:
    dances = {}
    for name, dance in first_dances(cells).items():
        cut = len(dance.trace) - 6
        signals = {name: signal[:-cut] for name, signal in dance.trace.to_arrays().items()}
        dances[name] = dataclasses.replace(dance, trace=Trace.from_arrays(signals))
    path = tmp_path / "dances.mp4"
    write_side_by_side(path, dances, ymca(), iter)
    frames = iio.imread(path).astype(int)
    assert frames.shape == (6, 480, 4 * 480, 3)
    panels = np.split(frames[0], 4, axis=1)
    # Ideal arms stand elsewhere than heavy ones only a little, but their titles are others.
    assert all(np.abs(panels[0][:24] - panel[:24]).max() > 100 for panel in panels[1:])
    assert all(panel[24:384].std() > 10 for panel in panels)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("", "no motion given; try: mpma compare ymca"),
        ("nonsense", "nonsense"),
        ("ymca --runs 0", "runs is 0; expected at least 1"),
        ("ymca --epochs 0", "epochs is 0; expected at least 1"),
        ("ymca --adaptation 0", "adaptation is 0; expected at least 1"),
        ("ymca --nodes 0", "nodes is 0"),
        ("ymca --modules 0", "modules is 0"),
        ("ymca --agent open_loop", "--agent is 'open_loop'; expected an agent that learns"),
        ("ymca --agent mosaic --rule gated", "mosaic has no option --rule"),
        ("ymca --tempo 5", "slow the movement with --tempo"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(
    words: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    command = ["compare", *words.split(), "--no-video", "--out", str(tmp_path / "out")]
    assert main(command) == 2
    told = [line for line in capsys.readouterr().err.splitlines() if line.startswith("mpma: ")]
    assert len(told) == 1
    assert said in told[0]
    assert "Traceback" not in told[0]
