"""Imitate a motion with late and noisy senses, beyond `mpma study latency`; print p_e as Markdown.

python benchmarks/latency.py --runs 10 --recording dance.tsv
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import tyro
from numpy.typing import NDArray

import mpma_mj
from mpma_mj.agents import Agent
from mpma_mj.agents.anticipation import Anticipation
from mpma_mj.agents.state_models import StateModels
from mpma_mj.agents.wrappers import Frozen
from mpma_mj.evaluation.evaluate import EVALUATION_EPISODE, posture_errors_percent
from mpma_mj.evaluation.statistics import interval
from mpma_mj.motions.motion import Motion
from mpma_mj.motions.transforms import with_context_of
from mpma_mj.trace import Trace
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import agent_of, make_environments, one_thread
from mpma_mj.training.rollout import rollout
from mpma_mj.training.trainer import Trainer

Options = Mapping[str, Any]
Array = NDArray[np.float64]

PLANTS = [{}, {"payload": 3.0}, {"actuator_gain": 0.6}, {"actuator_gain": 1.5}]
NAMES = ("empty", "3 kg", "gain 0.6", "gain 1.5")
EPOCHS = 6
THREE: Options = {"latency": 3, "lookahead": 4}


def main(
    runs: int = 10, seed: int = 0, motion: str = "ymca", recording: Path | None = None
) -> None:
    """Train and evaluate every row.

    Args:
        runs: Number of seeds, at least 2.
        seed: First seed.
        motion: What is learned: a built-in motion, or the path of a recording.
        recording: A motion never seen; its row is left out without it.
    """
    if runs < 2:
        raise SystemExit(f"--runs is {runs}; expected at least 2, which are trained as a batch")
    with one_thread():
        bench = Bench([*range(seed, seed + runs)], motion)
        _parts(bench, recording)
        _prompt(bench)
        _noise(bench)
        _plants(bench)


class Bench:
    """Seeds and motion that all rows have in common."""

    def __init__(self, seeds: list[int], motion: str) -> None:
        """Read the motion."""
        self.seeds, self.motion = seeds, mpma_mj.read_motion(motion)

    def trained(self, env: Options, epochs: int = EPOCHS, **options: Any) -> Agent:
        """Return agents that were trained in an environment, as a batch."""
        config = RunConfig.of("ymca", **options)
        configs = [config.replace(seed=seed) for seed in self.seeds]
        trainer = Trainer(configs, self.motion, env, keep_states=False)
        with contextlib.closing(trainer):
            trainer.run(epochs, stop=False)
        if trainer.failed:
            raise SystemExit(f"diverged: {trainer.failed}")
        return trainer.agent

    def traces(
        self,
        agent: Agent,
        env: Options,
        episode: int = EVALUATION_EPISODE,
        motion: Motion | None = None,
    ) -> list[Trace]:
        """Return the traces of an episode without learning."""
        envs = make_environments(RunConfig(), self.seeds, motion or self.motion, env)
        with contextlib.closing(envs):
            recorded = rollout(envs, Frozen(agent), episode)
        traces = [recorded.of_run(run) for run in range(len(self.seeds))]
        return [trace for trace in traces if trace is not None]

    def errors(self, *args: Any, **options: Any) -> Array:
        """Return p_e of an episode without learning, shape (R,), percent."""
        return posture_errors_percent(self.traces(*args, **options))

    def loaded(self, agent: Agent, env: Options) -> Agent:
        """Return the agents as they are, made for another environment."""
        envs = make_environments(RunConfig(), self.seeds, self.motion, env)
        with contextlib.closing(envs):
            other = agent_of(RunConfig(), envs, self.seeds)
        other.load_state_dict(agent.state_dict())
        return other


def _parts(bench: Bench, recording: Path | None) -> None:
    """Print a dance never seen with 150 ms, and what happens without a part."""
    print("| 150 ms | p_e, % |\n|---|---|", flush=True)
    if recording is not None:
        music = with_context_of(mpma_mj.read_motion(str(recording)), bench.motion)
        unseen = _cell(bench.errors(bench.trained(THREE), THREE, motion=music))
        print(f"| a dance never seen | {unseen} |", flush=True)
    ablations: dict[str, tuple[Options, Any]] = {
        "kinematic prior, and the episode's own steps": (THREE, _without(StateModels)),
        "one step shown, target held": ({"latency": 3}, _without(Anticipation)),
    }
    for name, (env, without) in ablations.items():
        with without:
            agent = bench.trained(env)
        print(f"| {name} | {_cell(bench.errors(agent, env))} |", flush=True)
    print(flush=True)


def _prompt(bench: Bench) -> None:
    """Print latencies of agents that have learned without one."""
    print("| trained without latency, then | shown as far | one step |\n|---|---|---|", flush=True)
    agent = bench.trained({}, epochs=4)
    for k in range(4):
        cells = []
        for lookahead in (k + 1, 0):
            env = {"latency": k, "lookahead": lookahead}
            cells.append(_cell(bench.errors(bench.loaded(agent, env), env)))
        print(f"| {50 * k} ms | {' | '.join(cells)} |", flush=True)
    print(flush=True)


def _noise(bench: Bench) -> None:
    """Print noise on the observations of agents that have learned without it."""
    print("| observation noise, % | without | with a state estimate |\n|---|---|---|", flush=True)
    agents = [bench.trained({}, epochs=4, state_estimate=estimate) for estimate in (False, True)]
    for noise in (0.0, 0.02, 0.05, 0.1):
        env = {"observation_noise": noise}
        cells = [_cell(bench.errors(agent, env)) for agent in agents]
        print(f"| {100 * noise:g} | {' | '.join(cells)} |", flush=True)
    print(flush=True)


def _plants(bench: Bench) -> None:
    """Print four plants, three epochs each, with late and noisy senses."""
    print(f"| four plants | {' | '.join(NAMES)} | mean | switched | plants found |")
    print("|---|" + "---|" * (len(NAMES) + 3), flush=True)
    late: Options = {"latency": 2, "lookahead": 3}
    noisy: Options = {"observation_noise": 0.02}
    estimate = {"state_estimate": True}
    rows: dict[str, tuple[Options, Options]] = {
        "undisturbed": ({}, {}),
        "100 ms": (late, {}),
        "2 % noise": (noisy, {}),
        "2 % noise, state estimate": (noisy, estimate),
        "100 ms and 2 % noise, state estimate": ({**late, **noisy}, estimate),
        "100 ms, oracle": (late, {"agent": "oracle"}),
    }
    for name, (env, options) in rows.items():
        agent = bench.trained({"plants": PLANTS, "epochs_per_plant": 3, **env}, 12, **options)
        each = [
            bench.errors(agent, {"plants": PLANTS, "epochs_per_plant": 1, **env}, episode)
            for episode in range(1000, 1000 + len(PLANTS))
        ]
        switching = {"plants": PLANTS, "switch_every": (1.0, 3.0), **env}
        switched = np.mean([bench.errors(agent, switching, k) for k in (1001, 1002)], axis=0)
        cells = [_cell(one) for one in (*each, np.mean(each, axis=0), switched)]
        found = agent.state_dict()["plants.recruited"]
        print(f"| {name} | {' | '.join(cells)} | {found.tolist()} |", flush=True)


def _without(kind: type[StateModels] | type[Anticipation]) -> Any:
    """Return a context in which instances of a class learn nothing."""
    return mock.patch.object(kind, "learn", return_value=np.zeros(8))


def _cell(errors: Array) -> str:
    """Return mean and 95 % interval over seeds."""
    return interval(errors.tolist()).text(3)


if __name__ == "__main__":
    tyro.cli(main)
