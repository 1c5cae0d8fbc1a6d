"""Runs of the study `switching`: plants in turn, then each alone, then with switches."""

from __future__ import annotations

import contextlib
import copy
import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj import metrics
from mpma_mj.agents import Agent, agent_class
from mpma_mj.agents.wrappers import paired_models_of
from mpma_mj.context import active_label
from mpma_mj.envs.load import arm_limits
from mpma_mj.evaluation.evaluate import EVALUATION_EPISODE, learn_episodes, posture_errors_percent
from mpma_mj.experiments.study import DRAWN, Record, StudyJob
from mpma_mj.motions import Motion
from mpma_mj.trace import Trace
from mpma_mj.training.factory import agent_of, make_environments, one_thread
from mpma_mj.training.history import part_metrics
from mpma_mj.training.rollout import rollout

__all__ = ["SwitchingJob", "found_plants", "leads_rightly", "steps_to_lead"]

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_SWITCH_EVERY = (1.0, 3.0)  # s
_EPISODES = 2  # with switches
_DIGITS = 4  # of what is drawn


@dataclass(frozen=True, eq=False, kw_only=True)
class SwitchingJob(StudyJob):
    """Runs of one agent; see `StudyJob`.

    Attributes:
        motion: The motion.
        plants: Names of the plants.
        drawn_seed: Seed of the run of which an episode with switches is kept to be drawn.
        lesions: Whether the modules of each plant are switched off, too.
    """

    motion: Motion
    plants: tuple[str, ...]
    drawn_seed: int
    lesions: bool

    def do(self) -> list[Record]:
        """Learn each plant in turn, then imitate in each and in changing ones."""
        with one_thread():
            agent, before = self._learned()
            each = [self._imitate(agent, plant) for plant in range(len(self.plants))]
            switched = self._switched(agent)
            lesions = self._lesions(agent, each) if self.lesions else None
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
        """Return the agents after training, and p_e in the first plant before the others.

        p_e has shape (R,), percent; it is NaN where training diverged.
        """
        config, seeds = self.configs[0], [config.seed for config in self.configs]
        learns = agent_class(config.agent_name).trainable
        epochs = config.env.epochs_per_plant if learns else 0
        with contextlib.closing(make_environments(config, seeds, self.motion)) as envs:
            agent = agent_of(config, envs, seeds)
            first = learn_episodes(envs, agent, range(epochs))
            # A copy: agents that learn at every step shall not learn from this episode.
            before = posture_errors_percent(self._imitate(copy.deepcopy(agent), 0))
            others = learn_episodes(envs, agent, range(epochs, epochs * len(self.plants)))
        diverged = np.isnan(np.concatenate([first, others])).any(axis=0)
        return agent, np.where(diverged, np.nan, before)

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
        whole = np.array([posture_errors_percent(traces) for traces in intact])
        ratios = []
        for plant in range(len(enabled) // modules):
            mask = enabled.copy()
            mask[plant * modules : (plant + 1) * modules] = False
            pairs.set_enabled_modules(mask)
            without = [
                posture_errors_percent(self._imitate(agent, on)) for on in range(len(self.plants))
            ]
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
        looks = (self.configs[0].option("max_plants") or 1) > 1 and not agent.observes_plant
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
        errors = posture_errors_percent(alone).tolist()
        record |= {
            "p_e": dict(zip(self.plants, errors, strict=True)),
            "mean": statistics.fmean(errors),
            "switched": statistics.fmean(posture_errors_percent(changing)),
            "first_kept": errors[0] / before,
        }
        whole = [part_metrics(trace, np.ones(len(trace), bool)) for trace in alone]
        for name in ("learned_share", "feedback_ratio"):
            if name in whole[0]:
                record[name] = statistics.fmean(one[name] for one in whole)
        matched = None if plants is None else found_plants(alone, self._modules)
        if self.configs[run].seed == self.drawn_seed:
            record[DRAWN] = self._drawn(changing, matched)
        if matched is None:
            return record
        steps = [steps_to_lead(trace, matched, self._modules) for trace in changing]
        record["steps_to_lead"] = [count for episode in steps for count in episode]
        right, alone_right = (
            [float(leads_rightly(trace, matched, self._modules).mean()) for trace in some]
            for some in (changing, alone)
        )
        record["right_share"] = statistics.fmean(right)
        record["right_share_alone"] = dict(zip(self.plants, alone_right, strict=True))
        if lesions is not None:
            record["lesion"] = {
                off: dict(zip(self.plants, lesions[found, :, run].tolist(), strict=True))
                for off, found in zip(self.plants, matched, strict=True)
            }
        return record

    def _drawn(self, traces: Sequence[Trace], matched: Sequence[int] | None) -> Record:
        """Return the signals of the episode with most plants, as lists."""
        kinematics = arm_limits(self.configs[0].env).kinematics
        trace = max(traces, key=lambda one: len(np.unique(_true_plants(one))))
        drawn: Record = {
            "rate": self.motion.rate,
            "plant": _true_plants(trace).tolist(),
            "label": active_label(trace.context[:-1]).tolist(),
            "labels": list(self.motion.labels),
            "error": _rounded(metrics.error_over_time(trace.posture, trace.reference)[1:]),
            "joint_angles": _rounded(trace.true_joint_angles(kinematics)[1:]),
            "reference": _rounded(trace.reference[1:]),
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


def leads_rightly(trace: Trace, matched: Sequence[int], modules: int) -> NDArray[np.bool_]:
    """Return whether the modules of the right plant lead at each step, shape (T,).

    Args:
        trace: Trace of an episode with plants.
        matched: The agent's plant for each plant.
        modules: Modules for each plant.
    """
    return _belief(trace, modules).argmax(axis=1) == np.array(matched)[_true_plants(trace)]


def steps_to_lead(trace: Trace, matched: Sequence[int], modules: int) -> list[int]:
    """Return the steps from each switch until the modules of the right plant lead.

    Args:
        trace: Trace of an episode with switches.
        matched: The agent's plant for each plant.
        modules: Modules for each plant.

    Returns:
        Steps; the length of the stretch where they do not lead before the next switch.
    """
    switches = np.flatnonzero(np.diff(_true_plants(trace))) + 1
    stretches = np.split(leads_rightly(trace, matched, modules), switches)[1:]
    return [int(part.argmax()) if part.any() else len(part) for part in stretches]
