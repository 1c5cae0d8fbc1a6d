"""Comparison of robots: agents trained on each of them, and evaluated there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents.registry import check_trainable
from mpma_mj.envs.load import arm_limits
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.envs.plants import PLANT_OPTIONS
from mpma_mj.errors import BadOptionError, DivergedError
from mpma_mj.evaluation.evaluate import EvalCondition, evaluate, posture_errors_percent
from mpma_mj.experiments.backend import Backend, Work
from mpma_mj.experiments.batching import seeds
from mpma_mj.experiments.compare import Episode, done_by_name, measured
from mpma_mj.motions import Motion
from mpma_mj.motions.feasibility import JointLimits
from mpma_mj.motions.reach import Reach, reach_of
from mpma_mj.options import TWO_ARM
from mpma_mj.robots.robot import Robot
from mpma_mj.robots.robot_file import read_robot
from mpma_mj.trace import Trace
from mpma_mj.training.config import RunConfig
from mpma_mj.training.dataset import read_motions
from mpma_mj.training.trainer import check, train_agents

__all__ = ["OnRobot", "RobotJob", "compare_robots", "robot_jobs"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class OnRobot:
    """R agents that were trained on a robot and are evaluated there.

    Attributes:
        robot: The robot.
        limits: Limits of its joints.
        motion: The motion, feasible for the robot.
        reach: How much of the motion it can do.
        seeds: Seed of each agent.
        epochs: Number of the best epoch of each, from 1, shape (R,).
        episodes: Episode of each; None where the simulation diverged.
        feedback: p_e of the feedback controller alone with each seed, shape (R,), percent; NaN
            where the simulation diverged.
    """

    robot: Robot
    limits: JointLimits
    motion: Motion
    reach: Reach
    seeds: tuple[int, ...]
    epochs: Array
    episodes: tuple[Episode | None, ...]
    feedback: Array

    def values(self, measure: str) -> list[float]:
        """Return a measure of all episodes that have it."""
        found = [episode.measures.get(measure, np.nan) for episode in self.episodes if episode]
        return [value for value in found if np.isfinite(value)]


@dataclass(frozen=True, eq=False)
class RobotJob(Work):
    """Agents that are trained on a robot, and evaluated there.

    Attributes:
        configs: Config of each of R runs, with the robot; they differ in their seeds only.
        motion: The motion, feasible for the robot.
        epochs: Largest number of epochs of training.
    """

    configs: tuple[RunConfig, ...]
    motion: Motion
    epochs: int

    @property
    def trained_on(self) -> str:
        """The robot as it was given."""
        return str(self.configs[0].env.robot)

    def do(self) -> OnRobot:
        """Train and evaluate.

        Raises:
            DivergedError: A simulation diverged in training.
        """
        condition = EvalCondition(self.trained_on, self.motion, {})
        untrained = [config.replace(agent="feedback_only") for config in self.configs]
        try:
            trained = train_agents(self.configs, self.motion, self.epochs, {})
            feedback = train_agents(untrained, self.motion, 1, {})
        except DivergedError as error:
            raise error.with_context(self.trained_on) from None
        options = self.configs[0].env
        arms, limits = PhysicsArms.make(options), arm_limits(options)
        episodes = tuple(
            None if trace is None else self._measured(trace, arms)
            for trace in evaluate(trained, condition)
        )
        return OnRobot(
            read_robot(options.robot),
            limits,
            self.motion,
            reach_of(self.motion, limits),
            tuple(trained.seeds),
            trained.epochs.astype(float),
            episodes,
            posture_errors_percent(evaluate(feedback, condition)),
        )

    def _measured(self, trace: Trace, arms: PhysicsArms) -> Episode:
        """Return an episode with its measures, among them shares of the joints' limits."""
        episode = measured(trace, self.configs[0].env, self.motion.rate, arms)
        moves = np.abs(np.diff(trace.true_joint_angles(arms.kinematics), axis=0))
        shares = {"speed_share": np.max(moves * self.motion.rate / arms.max_joint_speed)}
        if episode.effort is not None:
            force = arms.model.actuator_forcerange[arms.actuator_indices, 1]
            shares["torque_share"] = np.mean(np.abs(episode.effort.torque) / force)
        episode.measures.update({name: float(share) for name, share in shares.items()})
        return episode


def robot_jobs(
    config: RunConfig, robots: Sequence[str], *, runs: int, epochs: int
) -> list[RobotJob]:
    """Return the jobs of a comparison, one a robot.

    Args:
        config: Config of the first run; its robot does not count.
        robots: Names of robots, or paths of their files.
        runs: Number of runs on each robot, with seeds from that of the config.
        epochs: Largest number of epochs of a run.

    Raises:
        MpmaError: A robot does not exist, or lacks a value that is needed; an option is out of
            bounds, or means something else on each robot; the agent does not learn; or the motion
            cannot be read.
    """
    _check(config, robots, epochs)
    _check_names(robots)
    jobs = []
    for robot in robots:
        own = config.replace(robot=robot)
        motion = read_motions(own)
        check(own, motion)
        jobs.append(RobotJob(tuple(seeds(own, runs)), motion, epochs))
    return jobs


def compare_robots(
    jobs: Sequence[RobotJob],
    backend: Backend,
    on_trained: Callable[[str], None] = lambda robot: None,
) -> list[OnRobot]:
    """Train and evaluate on each robot.

    Args:
        jobs: The jobs.
        backend: The workers.
        on_trained: Called with the robot of a job that is done.

    Returns:
        The results, in the order of the jobs.

    Raises:
        DivergedError: A simulation diverged in training.
        WorkerError: A worker died repeatedly.
    """
    found: dict[str, OnRobot] = done_by_name(jobs, backend, on_trained)
    return [found[job.trained_on] for job in jobs]


def _check_names(robots: Sequence[str]) -> None:
    """Check that all robots exist, before any learns, and differ; raises a BadOptionError."""
    names = list[str]()
    for robot in robots:
        try:
            name = read_robot(robot).name
        except BadOptionError as error:
            if error.option == "robot":
                raise BadOptionError(
                    option="robots", value=robot, expected=error.expected, remedy=error.remedy
                ) from None
            raise
        if name in names:
            remedy = "give {robots} once each, and own robots names of their own"
            raise BadOptionError(f"robot {name} is given twice", remedy=remedy)
        names.append(name)


def _check(config: RunConfig, robots: Sequence[str], epochs: int) -> None:
    """Check what does not depend on a robot; raises a BadOptionError."""
    if epochs < 1:
        raise BadOptionError(option="epochs", value=epochs, expected="at least 1")
    env = config.env
    if env.robot != TWO_ARM:
        problem = "is for one robot, but several are compared"
        raise BadOptionError(problem, option="robot", remedy="leave it out, or leave {robots} out")
    if env.locked_joint is not None:
        problem = "is a joint of one robot, but several are compared"
        raise BadOptionError(problem, option="locked_joint", remedy="leave it out")
    if env.plants is not None:
        problem = "robots are compared, each without plants"
        raise BadOptionError(problem, remedy="leave {plants} out")
    for name in PLANT_OPTIONS:
        if name in env.ranges:
            expected = "one number, as robots are compared with a single plant"
            raise BadOptionError(option=name, value=env.ranges[name], expected=expected)
    if config.reading.tempo == "auto":
        problem = "is another tempo for each robot, but they are compared at one"
        raise BadOptionError(f"auto {problem}", option="tempo", remedy="give a number")
    check_trainable(config.agent_name)
