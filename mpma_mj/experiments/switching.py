"""Study `switching`: plants are learned one after the other, then they switch unannounced."""

from __future__ import annotations

import contextlib
import copy
import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.agents import Agent, agent_class
from mpma_mj.agents.wrappers import paired_models_of
from mpma_mj.context import active_label
from mpma_mj.envs.options import MASS_OPTIONS
from mpma_mj.evaluation.evaluate import EVALUATION_EPISODE, learn_episodes, tracking_errors
from mpma_mj.experiments.study import (
    DRAWN,
    Agents,
    Record,
    Study,
    StudyJob,
    batches,
    lost,
    of_agent,
    over_seeds,
)
from mpma_mj.motions import Motion
from mpma_mj.options import Arms
from mpma_mj.trace import Trace
from mpma_mj.training.config import RunConfig
from mpma_mj.training.dataset import read_motions
from mpma_mj.training.factory import agent_of, make_environments, one_thread
from mpma_mj.training.history import part_metrics
from mpma_mj.training.rollout import rollout
from mpma_mj.training.trainer import check
from mpma_mj.utils.text import markdown_table

__all__ = ["AGENTS", "PLANTS", "Switching", "found_plants", "steps_to_lead"]

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

PLANTS: dict[str, dict[str, float]] = {
    "empty": {},
    "3 kg": {"payload": 3.0},
    "gain 0.6": {"actuator_gain": 0.6},
    "gain 1.5": {"actuator_gain": 1.5},
}
"""Options of the plants by name, in the order in which they are learned (choice)."""

AGENTS: Agents = {
    "mpma": {"agent": "mpma"},
    "mpma, 1 × 200": {"agent": "mpma", "modules": 1, "nodes": 200},
    "single, 200": {"agent": "single", "nodes": 200},
    "single, 800": {"agent": "single", "nodes": 800},
    "single, history": {"agent": "single", "nodes": 200, "history": True},
    "adaptive": {"agent": "adaptive"},
    "resolved rate": {"agent": "resolved_rate"},
    "oracle": {"agent": "oracle"},
}
"""Agents of the study."""

_SWITCH_EVERY = (1.0, 3.0)  # s
_EPISODES = 2  # with switches
_LESIONED = "mpma"
_DIGITS = 4  # of what is drawn


@dataclass(frozen=True, kw_only=True)
class Switching(Study):
    """Plants that are learned one after the other and then switch; see `Study`.

    Attributes:
        motion: The motion.
        arms: Kind of arms.
        epochs: Epochs in each plant.
        agents: The agents.
    """

    name: ClassVar[str] = "switching"
    motion: str = "ymca"
    arms: Arms = "physics"
    epochs: int = 3
    agents: Agents = field(default_factory=lambda: AGENTS)

    @property
    def plants(self) -> dict[str, dict[str, float]]:
        """The plants; ideal arms have no mass, and carry no load."""
        if self.arms == "physics":
            return PLANTS
        return {name: plant for name, plant in PLANTS.items() if not {*plant} & {*MASS_OPTIONS}}

    def jobs(self) -> list[SwitchingJob]:
        """Return a job for each batch of runs; errors as of `Study`."""
        base = RunConfig.of(
            self.motion,
            arms=self.arms,
            plants=tuple(self.plants.values()),
            epochs_per_plant=self.epochs,
            seed=self.seed,
        )
        motion = read_motions(base)
        check(base, motion)
        return [
            SwitchingJob(
                agent=name,
                configs=configs,
                motion=motion,
                plants=tuple(self.plants),
                drawn_seed=self.seed,
            )
            for name, configs in batches(self.agents, base, self.runs)
        ]

    def table(self, records: Sequence[Record]) -> str:
        """Return the table of agents, and the lesions of mpma."""
        head = ["agent", *self.plants, "mean", "switched", "first plant kept", "plants found"]
        head += ["steps to lead", "learned share", "feedback ratio"]
        rows = [self._row(agent, of_agent(records, agent)) for agent in self.agents]
        parts = [
            markdown_table(head, rows),
            f"p_e in %; means over {self.runs} seeds with 95 % bootstrap intervals. First plant"
            f" kept: p_e in {next(iter(self.plants))} after all plants over p_e there before the"
            f" second. Plants found: runs that found exactly {len(self.plants)}. Steps to lead:"
            " median from a switch to the first step in which the modules of the right plant"
            f" lead; the whole stretch where they never do.{lost(records)}",
        ]
        lesioned = [one for one in of_agent(records, _LESIONED) if "lesion" in one]
        if lesioned:
            cells = [
                [off, *(over_seeds(lesioned, "lesion", off, on).text(2) for on in self.plants)]
                for off in self.plants
            ]
            parts += [
                markdown_table(
                    ["modules switched off", *(f"in {on}" for on in self.plants)], cells
                ),
                f"p_e of {_LESIONED} over that of the intact agent, by the plant whose modules are"
                " switched off and the plant that is on.",
            ]
        return "\n\n".join(parts) + "\n"

    def draw(self, path: Path, records: Sequence[Record]) -> None:
        """Write the figure."""
        from mpma_mj.experiments.switching_figure import write_figure

        write_figure(path, records, tuple(self.agents), tuple(self.plants))

    def _row(self, agent: str, records: Sequence[Record]) -> list[str]:
        cells = [over_seeds(records, "p_e", plant).text(2) for plant in self.plants]
        cells += [over_seeds(records, name).text(3) for name in ("mean", "switched")]
        cells.append(over_seeds(records, "first_kept").text(2))
        found = [one["plants"] for one in records if one.get("plants") is not None]
        cells.append(f"{found.count(len(self.plants))} of {len(found)}" if found else "–")
        steps = [s for one in records for s in one.get("steps_to_lead") or ()]
        cells.append(f"{statistics.median(steps):g}" if steps else "–")
        shares = (over_seeds(records, name) for name in ("learned_share", "feedback_ratio"))
        return [agent, *cells, *(share.text(3) for share in shares)]


@dataclass(frozen=True, eq=False, kw_only=True)
class SwitchingJob(StudyJob):
    """Runs of one agent; see `StudyJob`.

    Attributes:
        motion: The motion.
        plants: Names of the plants.
        drawn_seed: Seed of the run of which an episode with switches is kept to be drawn.
    """

    motion: Motion
    plants: tuple[str, ...]
    drawn_seed: int

    def do(self) -> list[Record]:
        """Learn each plant in turn, then imitate in each and in changing ones."""
        with one_thread():
            agent, before = self._learned()
            each = [self._imitate(agent, plant) for plant in range(len(self.plants))]
            switched = self._switched(agent)
            lesions = self._lesions(agent, each) if self.agent == _LESIONED else None
            plants = self._plants(agent)
        return [
            self._record(
                run,
                [traces[run] for traces in each],
                [traces[run] for traces in switched],
                float(before[run]),
                None if plants is None else int(plants[run]),
                lesions,
            )
            for run in range(len(self.configs))
        ]

    def _learned(self) -> tuple[Agent, Array]:
        """Return the agents after training, and p_e in the first plant before the others, (R,)."""
        config, seeds = self.configs[0], [config.seed for config in self.configs]
        epochs = config.env.epochs_per_plant
        with contextlib.closing(make_environments(config, seeds, self.motion)) as envs:
            agent = agent_of(config, envs, seeds)
            learns = agent_class(config.agent_name).trainable
            if learns:
                learn_episodes(envs, agent, range(epochs))
            # A copy: agents that learn at every step shall not learn from this episode.
            before = tracking_errors(self._imitate(copy.deepcopy(agent), 0))
            if learns:
                learn_episodes(envs, agent, range(epochs, epochs * len(self.plants)))
        return agent, before

    def _imitate(self, agent: Agent, plant: int) -> list[Trace | None]:
        """Return the traces of an episode in one plant, with the same noise for each agent."""
        return self._episode(agent, {"epochs_per_plant": 1}, self._first + plant)

    def _switched(self, agent: Agent) -> list[list[Trace | None]]:
        """Return the traces of episodes with switches."""
        first = self._first + len(self.plants)
        changes = {"switch_every": _SWITCH_EVERY}
        return [self._episode(agent, changes, first + number) for number in range(_EPISODES)]

    def _episode(
        self, agent: Agent, changes: Mapping[str, Any], episode: int
    ) -> list[Trace | None]:
        """Return the trace of each run in an episode; None where it diverged.

        Nothing is refitted after it, but agents that learn at every step do so.
        """
        seeds = [config.seed for config in self.configs]
        envs = make_environments(self.configs[0], seeds, self.motion, changes)
        with contextlib.closing(envs):
            recorded = rollout(envs, agent, episode)
        return [recorded.of_run(run) for run in range(len(seeds))]

    def _lesions(self, agent: Agent, intact: Sequence[list[Trace | None]]) -> Array:
        """Return p_e without the modules of a plant over p_e with them, shape (W, P, R)."""
        pairs, modules = paired_models_of(agent), self._modules
        enabled = pairs.enabled_modules
        whole = np.array([tracking_errors(traces) for traces in intact])
        ratios = []
        for plant in range(len(enabled) // modules):
            mask = enabled.copy()
            mask[plant * modules : (plant + 1) * modules] = False
            pairs.set_enabled_modules(mask)
            without = [tracking_errors(self._imitate(agent, on)) for on in range(len(self.plants))]
            ratios.append(np.array(without) / whole)
        pairs.set_enabled_modules(enabled)
        return np.array(ratios)

    @property
    def _first(self) -> int:
        """Number of the first of the episodes of which no training has the noise.

        With one episode in each plant, it is in the first.
        """
        return len(self.plants) * EVALUATION_EPISODE

    @property
    def _modules(self) -> int:
        """Number of modules for each plant."""
        return int(self.configs[0].options().get("modules", 1))

    def _plants(self, agent: Agent) -> Indices | None:
        """Return the number of plants found, (R,); None for an agent that looks for none."""
        looks = (self.configs[0].option("max_plants") or 1) > 1 and not agent.is_told_plant
        return agent.state_dict()["plants.recruited"].astype(int) if looks else None

    def _record(
        self,
        run: int,
        each: Sequence[Trace | None],
        switched: Sequence[Trace | None],
        before: float,
        plants: int | None,
        lesions: Array | None,
    ) -> Record:
        """Return the record of a run."""
        record: Record = {"agent": self.agent, "seed": self.configs[run].seed, "plants": plants}
        traces = [trace for trace in (*each, *switched) if trace is not None]
        record["diverged"] = math.isnan(before) or len(traces) < len(each) + len(switched)
        if record["diverged"]:
            return record
        alone, changing = traces[: len(each)], traces[len(each) :]
        errors = tracking_errors(alone).tolist()
        record |= {
            "p_e": dict(zip(self.plants, errors, strict=True)),
            "mean": statistics.fmean(errors),
            "switched": statistics.fmean(tracking_errors(changing)),
            "first_kept": errors[0] / before,
        }
        whole = [part_metrics(trace, np.ones(len(trace), bool)) for trace in alone]
        for name in ("learned_share", "feedback_ratio"):
            if name in whole[0]:
                record[name] = statistics.fmean(one[name] for one in whole)
        if self.configs[run].seed == self.drawn_seed:
            record[DRAWN] = self._drawn(changing, None)
        if plants is None:
            return record
        matched = found_plants(alone, self._modules)
        record["steps_to_lead"] = [
            steps for trace in changing for steps in steps_to_lead(trace, matched, self._modules)
        ]
        if DRAWN in record:
            record[DRAWN] = self._drawn(changing, matched)
        if lesions is not None:
            record["lesion"] = {
                off: dict(zip(self.plants, lesions[found, :, run].tolist(), strict=True))
                for off, found in zip(self.plants, matched, strict=True)
            }
        return record

    def _drawn(self, traces: Sequence[Trace], matched: Sequence[int] | None) -> Record:
        """Return the signals of the episode with most plants, as lists."""
        trace = max(traces, key=lambda one: len(np.unique(_true_plants(one))))
        drawn: Record = {
            "rate": self.motion.rate,
            "plant": _true_plants(trace).tolist(),
            "label": active_label(trace.context[:-1]).tolist(),
            "labels": list(self.motion.labels),
            "error": _rounded(metrics.error_over_time(trace.posture, trace.reference)[1:]),
        }
        if matched is not None:
            share = trace.with_modules().responsibility
            drawn["responsibility"] = _rounded(share)
            drawn |= {"modules": self._modules, "matched": list(matched)}
        return drawn


def _rounded(array: Array) -> Any:
    return array.round(_DIGITS).tolist()


def _true_plants(trace: Trace) -> Indices:
    """Return the plant at each step of a trace from an environment with plants."""
    assert trace.plant is not None
    return trace.plant


def _belief(trace: Trace, modules: int) -> Array:
    """Return the responsibility of each plant that an agent has found, shape (T, W)."""
    responsibility = trace.with_modules().responsibility
    return responsibility.reshape(len(responsibility), -1, modules).sum(axis=2)


def found_plants(alone: Sequence[Trace], modules: int) -> list[int]:
    """Return for each plant the agent's plant with the largest mean responsibility in it.

    Args:
        alone: Trace of an episode in each plant.
        modules: Modules for each plant.
    """
    return [int(_belief(trace, modules).mean(axis=0).argmax()) for trace in alone]


def steps_to_lead(trace: Trace, matched: Sequence[int], modules: int) -> list[int]:
    """Return the steps from each switch until the modules of the right plant lead.

    Args:
        trace: Trace of an episode with switches.
        matched: The agent's plant for each plant.
        modules: Modules for each plant.

    Returns:
        Steps; the length of the stretch where they do not lead before the next switch.
    """
    plants = _true_plants(trace)
    right = _belief(trace, modules).argmax(axis=1) == np.array(matched)[plants]
    switches = np.flatnonzero(np.diff(plants)) + 1
    stretches = np.split(right, switches)[1:]
    return [int(part.argmax()) if part.any() else len(part) for part in stretches]
