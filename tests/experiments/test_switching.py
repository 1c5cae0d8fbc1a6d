"""Study of plants that switch."""

import json
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import numpy as np
import pytest
from numpy.typing import NDArray

from mpma_mj.agents import Agent
from mpma_mj.agents.base import ModuleSignals
from mpma_mj.cli import main
from mpma_mj.envs.vector_env import VectorImitationEnv
from mpma_mj.evaluation.evaluate import learn_episodes
from mpma_mj.experiments import switching
from mpma_mj.experiments.study import Agents, Record, run_study
from mpma_mj.experiments.switching import Switching
from mpma_mj.experiments.switching_job import found_plants, leads_rightly, steps_to_lead
from mpma_mj.experiments.switching_video import smoothed_error
from mpma_mj.trace import SIGNALS, Trace
from tests.experiments.runs import run_files

TINY: Agents = {
    "mpma": {"agent": "mpma", "nodes": 10, "modules": 2, "repeats": 1},
    "adaptive": {"agent": "adaptive", "nodes": 10, "repeats": 1},
    "resolved rate": {"agent": "resolved_rate", "repeats": 1},
}


def trace_of(plants: list[int], leads: list[int]) -> Trace:
    """Return a trace in which modules of given plants, two each of three, lead."""
    share: NDArray[np.float64] = np.zeros((len(leads), 6))
    share[np.arange(len(leads)), 2 * np.array(leads) + np.arange(len(leads)) % 2] = 1.0
    modules = ModuleSignals(
        share, share, np.zeros((len(leads), 6, 8)), np.zeros((len(leads), 6, 12))
    )
    none = dict.fromkeys(SIGNALS, np.zeros(len(leads)))
    return Trace(**none, modules=modules, plant=np.array(plants))


def test_a_plant_is_matched_with_what_leads_while_it_is_on() -> None:
    alone = [trace_of([0] * 4, [2, 2, 1, 2]), trace_of([1] * 4, [0, 0, 0, 1])]
    assert found_plants(alone, 2) == [2, 0]


def test_steps_to_lead_count_from_the_switch_and_end_with_the_next() -> None:
    plants = [0, 0, 0, 1, 1, 1, 0, 0, 1, 1]
    leads_ = [0, 2, 2, 2, 0, 2, 2, 0, 2, 2]
    # Plant 0 is the agent's 2, plant 1 its 0: right one step late, then at once, then never.
    trace = trace_of(plants, leads_)
    assert steps_to_lead(trace, [2, 0], 2) == [1, 0, 2]
    assert leads_rightly(trace, [2, 0], 2).tolist() == [bool(int(right)) for right in "0110101000"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a small study."""
    folder = tmp_path_factory.mktemp("switching")
    run_study(Switching(runs=2, epochs=2, agents=TINY, arms="kinematic"), folder, 1)
    return folder


def test_two_workers_find_what_one_finds(folder: Path, tmp_path: Path) -> None:
    run_study(Switching(runs=2, epochs=2, agents=TINY, arms="kinematic"), tmp_path, 2)
    for name in ("results.csv", "table.md", *(f"runs/{path.name}" for path in run_files(folder))):
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes()


def test_the_table_has_a_row_for_each_agent_and_lesions(folder: Path) -> None:
    table = (folder / "table.md").read_text()
    rows = [line.split(" | ")[0].strip("| ") for line in table.splitlines() if line[:1] == "|"]
    first = ["agent", "---|---|---|---|---|---|---|---|---|---|---|---", *TINY]
    assert rows[:5] == first
    assert rows[-3:] == ["empty", "gain 0.6", "gain 1.5"]
    assert " of 2 | " in table
    assert (folder / "figure.png").stat().st_size > 10_000


def test_ideal_arms_carry_no_load() -> None:
    assert [*Switching(arms="kinematic").plants] == ["empty", "gain 0.6", "gain 1.5"]
    jobs = Switching(arms="kinematic", runs=1, agents=TINY).jobs()
    assert {len(job.configs[0].env.plants or ()) for job in jobs} == {3}


def test_plants_can_be_learned_in_reverse_order() -> None:
    study = Switching(reverse=True, runs=1, agents=TINY)
    assert [*study.plants] == [*reversed(switching.PLANTS)]
    gains = [plant.actuator_gain for plant in study.jobs()[0].configs[0].env.plants or ()]
    assert gains == [1.5, 0.6, None, None]


def test_the_command_runs_a_study_and_resumes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(switching, "AGENTS", {"resolved rate": TINY["resolved rate"]})
    words = ["study", "switching", "--runs", "2", "--workers", "1", "--out", str(tmp_path)]
    assert main(words) == 0
    first = capsys.readouterr()
    assert first.out.splitlines()[-1] == str(tmp_path)
    assert "| resolved rate | " in first.out
    assert main(words) == 0
    again = capsys.readouterr()
    assert again.out == first.out
    assert "resuming: 2 of 2 runs are done" in again.err


def test_a_run_whose_training_diverged_has_no_measures(monkeypatch: pytest.MonkeyPatch) -> None:
    study = Switching(runs=2, epochs=1, agents={"adaptive": TINY["adaptive"]})
    (job,) = study.jobs()

    def lose_the_second(envs: VectorImitationEnv, agent: Agent, episodes: range) -> Any:
        errors = learn_episodes(envs, agent, episodes)
        errors[-1:, 1] = np.nan
        return errors

    monkeypatch.setattr("mpma_mj.experiments.switching_job.learn_episodes", lose_the_second)
    first, second = job.do()
    assert not first["diverged"]
    assert second == {"agent": "adaptive", "seed": 1, "plants": None, "diverged": True}
    table = study.table([first, second])
    assert f"| {first['mean']:.3f} | {first['switched']:.3f} |" in table


def records_of(folder: Path) -> list[Record]:
    files = [json.loads(path.read_text()) for path in run_files(folder)]
    return [record for file in files for record in file["records"]]


@pytest.mark.usefixtures("opengl")
def test_the_video_shows_every_step_of_two_agents(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(switching, "_IN_VIDEO", ("mpma", "adaptive"))
    study = Switching(runs=2, epochs=2, agents=TINY, arms="kinematic")
    run_study(study, folder, 1)
    assert not (folder / "video.mp4").exists()
    run_study(study, folder, 1, video=iter)
    frames = list(iio.imiter(folder / "video.mp4"))
    drawn = [one["drawn"] for one in records_of(folder) if "drawn" in one]
    assert {len(frames)} == {len(one["plant"]) for one in drawn}
    assert frames[0].shape == (560, 976, 3)
    left, right = (frame.astype(int) for frame in np.split(frames[0], 2, axis=1))
    assert abs(left[32:392] - right[32:392]).max() > 30  # they do not do the same
    bands = frames[0][392 + 10, 4:470].astype(int)
    assert len({tuple(colour // 40) for colour in bands}) > 1  # plants switch


def test_the_error_of_a_step_is_the_mean_around_it() -> None:
    error = smoothed_error({"error": [0.0] * 10 + [5.0] + [0.0] * 10})
    assert error.tolist() == [0.0] * 8 + [1.0] * 5 + [0.0] * 8


def test_a_study_with_a_video_says_where_opengl_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(switching, "AGENTS", {"resolved rate": TINY["resolved rate"]})
    monkeypatch.setattr("mpma_mj.commands.workers.missing_opengl", lambda: "mpma: no OpenGL")
    words = ["study", "switching", "--runs", "1", "--workers", "1", "--out", str(tmp_path)]
    assert main(words) == 0
    assert capsys.readouterr().err.splitlines()[-1] == "mpma: no OpenGL"
    assert (tmp_path / "figure.png").exists()
    assert not (tmp_path / "video.mp4").exists()
