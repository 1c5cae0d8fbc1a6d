"""Command `mpma record`."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mpma_mj.cli import main
from tests.conftest import Refused

minari = pytest.importorskip("minari")
pytest.importorskip("h5py")

TINY = ["--arms", "kinematic", "--repeats", "1"]


def opened(folder: Path) -> Any:
    return minari.MinariDataset(folder / "data")


def test_a_trained_run_is_recorded(tmp_path: Path) -> None:
    run, out = tmp_path / "run", tmp_path / "d.minari"
    words = ["imitate", "ymca", "--nodes", "10", *TINY, "--seed", "3", "--no-video"]
    assert main([*words, "--out", str(run)]) == 0
    assert main(["record", str(run), "--episodes", "2", "--out", str(out)]) == 0
    dataset = opened(out)
    assert len(dataset) == 2
    assert dataset.recover_environment().spec.kwargs == {
        "motion": "ymca",
        "arms": "kinematic",
        "repeats": 1,
    }
    metadata = json.loads((out / "data" / "metadata.json").read_text())
    assert metadata["algorithm_name"] == "MPMA"
    trained = json.loads((run / "summary.json").read_text())["p_e_percent"]
    assert metadata["expert_p_e_percent"] < 1.5 * trained


def test_an_agent_that_learns_is_trained_first_and_another_acts_at_once(tmp_path: Path) -> None:
    for agent, name in (("mpma", "MPMA"), ("resolved_rate", "ResolvedRate")):
        out = tmp_path / agent
        words = ["record", "ymca", "--agent", agent, *TINY, "--episodes", "1", "--out", str(out)]
        assert main(words) == 0
        metadata = json.loads((out / "data" / "metadata.json").read_text())
        assert metadata["algorithm_name"] == name
        assert metadata["expert_p_e_percent"] < 0.3


def test_options_of_the_environment_are_kept(tmp_path: Path) -> None:
    out = tmp_path / "d"
    words = ["record", "ymca", "--agent", "oracle", "--out", str(out), "--repeats", "1"]
    words += ["--plants", "payload=0", "payload=2", "--lookahead", "2", "--epochs-per-plant", "1"]
    assert main([*words, "--nodes", "10", "--modules", "2", "--episodes", "1"]) == 0
    dataset = opened(out)
    env = dataset.recover_environment()
    assert env.spec.kwargs["plants"] == [{"payload": 0.0}, {"payload": 2.0}]
    observation, info = env.reset(seed=1)
    assert info["plant"] == 0
    np.testing.assert_array_equal(observation, dataset[0].observations[0])


def test_bad_input_is_refused_before_training_in_one_line(tmp_path: Path, refused: Refused) -> None:
    out = tmp_path / "d"
    base = ["record", "ymca", "--out", str(out)]
    refused([*base, "--episodes", "0"], "mpma: --episodes is 0; expected a whole number of at lea")
    refused(["record", "ymca"], "mpma: --out is missing")
    refused([*base, "--agent", "mosiac"], "mpma: --agent is 'mosiac'; expected one of")
    refused([*base, "--tempo", "2"], "mpma: a dataset keeps the name or path of one motion")
    refused([*base[:1], str(tmp_path / "none"), *base[2:]], "none: no such file")
    assert not out.exists()
    out.mkdir()
    (out / "mine").touch()
    refused([*base, "--overwrite"], "d: already exists, and is no dataset; choose another folder")
    (out / "data").mkdir()
    (out / "data" / "metadata.json").touch()
    refused(base, "d: already exists; --overwrite replaces it")


@pytest.mark.parametrize(
    "option",
    [
        *(["--seed", "1"], ["--seed=0"], ["--agent", "single"], ["--agent", "mpma"]),
        *(["--arms", "physics"], ["--payload", "0"], ["--no-strict"], ["--nodes", "50"]),
    ],
)
def test_options_of_training_are_refused_with_a_trained_run_even_as_its_defaults(
    option: list[str], tmp_path: Path, refused: Refused
) -> None:
    (tmp_path / "config.json").touch()
    words = ["record", str(tmp_path), "--out", str(tmp_path / "d"), "--episodes", "1", *option]
    flag = option[0].partition("=")[0].replace("--no-", "--")
    own = "is a trained run, which has its own agent, environment and seed"
    refused(words, f"{own}; leave {flag} out")


def test_a_run_of_an_agent_from_outside_is_recorded_with_its_class(
    tmp_path: Path, refused: Refused
) -> None:
    (tmp_path / "mine.py").write_text(
        "from mpma_mj.agents.mpma import MPMA\n\n\nclass Mine(MPMA):\n    pass\n"
    )
    run, out = str(tmp_path / "run"), str(tmp_path / "d")
    agent = ["--agent", f"{tmp_path / 'mine.py'}:Mine"]
    words = ["imitate", "ymca", *agent, "--nodes", "10", *TINY, "--epochs", "1", "--no-video"]
    assert main([*words, "--out", run]) == 0
    refused(["record", run, *agent, "--seed", "0", "--out", out], "leave --seed out")
    assert main(["record", run, *agent, "--episodes", "1", "--out", out]) == 0
    metadata = json.loads((tmp_path / "d" / "data" / "metadata.json").read_text())
    assert metadata["algorithm_name"] == "Mine"
