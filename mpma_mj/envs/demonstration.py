"""Demonstration of an episode, with everything random in it."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpma_mj import joint_paths
from mpma_mj.arm_kinematics import TWO_ARMS, ArmKinematics
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.randomisation import Randomisation
from mpma_mj.envs.schedules import LatencySchedule, PlantSchedule
from mpma_mj.envs.step_rules import top_speeds
from mpma_mj.errors import StateError
from mpma_mj.motions import Motion
from mpma_mj.motions.transforms import repeat
from mpma_mj.utils.seeding import stream

__all__: list[str] = ["Demonstration", "Episode"]

Array = NDArray[np.float64]

_PUSH_DURATION = 0.1  # s (choice)


@dataclass(frozen=True, eq=False)
class Episode:
    """Everything random in an episode, drawn before it begins; or in those of a batch.

    Attributes:
        start: Step of the demonstration at which it starts, from 0.
        reference: Demonstrated postures with their noise, shape (T + N, 12), N being the number of
            targets beyond the last moment, which repeat its posture.
        reference_angles: Feasible joint angles with the same noise, shape (T + N, 8), rad; None for
            a motion without them.
        sensor_noise: Noise on the observed state of the arms, shape (T, 28): posture, joint
            angles in rad, joint velocities in rad/s; None without noise.
        perturbations: Forces on left and right hand, shape (T, 2, 3), N; None without forces.
        plant: Index of the plant that is on, shape (T,); None without plants.
        latency: Latency in force, shape (T,), control steps; None where it is one number.
        drawn_options: Options that `Randomisation` has drawn, shape (K,).
    """

    start: int
    reference: Array
    reference_angles: Array | None
    sensor_noise: Array | None
    perturbations: Array | None
    plant: NDArray[np.intp] | None
    latency: NDArray[np.intp] | None
    drawn_options: Array

    def repeated(self, count: int) -> Episode:
        """Return a batch of so many copies, its arrays with an axis in front."""
        arrays: dict[str, Any] = {name: np.array([array] * count) for name, array in self._arrays()}
        return dataclasses.replace(self, **arrays)

    def replace(self, row: int, episode: Episode) -> None:
        """Replace the arrays of one episode of a batch.

        Args:
            row: Index of the episode in the batch.
            episode: Episode of the same shape.
        """
        for (_, batch), (_, array) in zip(self._arrays(), episode._arrays(), strict=True):
            batch[row] = array

    def _arrays(self) -> Iterator[tuple[str, NDArray[Any]]]:
        """Yield names and arrays, of those that there are."""
        for field in dataclasses.fields(self):
            array = getattr(self, field.name)
            if isinstance(array, np.ndarray):
                yield field.name, array


class Demonstration:
    """Several repetitions of a motion, as episodes demonstrate them.

    Attributes:
        motion: The motion.
        period: Number of steps from one repetition to the next.
        context: Context at each of the T moments, shape (T, C).
        phase: Sine and cosine of the progress of the repetition, shape (T, 2).
        randomisation: Options that are drawn for each episode.
        kinematics: Kinematics of the arms.
        top_speeds: Joint velocities that action 1 commands, shape (8,), rad/s.
        largest_move: Move of each joint in a step at its top speed, shape (8,), rad.
    """

    def __init__(
        self,
        motion: Motion,
        options: EnvironmentOptions,
        max_joint_speed: Array,
        kinematics: ArmKinematics = TWO_ARMS,
    ) -> None:
        """Repeat the motion.

        Args:
            motion: The motion; for other arms than `two_arm` with feasible angles.
            options: Options of the environment.
            max_joint_speed: Top speed of each joint, shape (8,), rad/s.
            kinematics: Kinematics of the arms.

        Raises:
            StateError: The motion has no joint angles of arms that are not `two_arm`.
        """
        self.motion = motion
        self._options, self.kinematics = options, kinematics
        self._max_joint_speed = max_joint_speed
        self.largest_move = 1.0 / motion.rate * max_joint_speed
        self.top_speeds = top_speeds(max_joint_speed, kinematics.joint_names, options.locked_joint)
        self._plants = PlantSchedule(options, motion.rate)
        self._latencies = LatencySchedule(options, motion.rate)
        self.randomisation = Randomisation(options)
        repeats = options.repeats
        if kinematics != TWO_ARMS and motion.angles_of != kinematics.name:
            raise StateError(
                f"{motion.name} has no joint angles of {kinematics.name}",
                remedy="make it feasible for that robot",
            )
        self._clean, self.context, self._feasible = repeat(
            motion, repeats, max_joint_speed, kinematics
        )
        between = len(self._clean) - repeats * len(motion)  # postures of all return moves
        self.period = len(motion) + between // max(repeats - 1, 1)
        turn = 2.0 * np.pi * np.arange(len(self._clean)) / self.period
        self.phase = np.stack([np.sin(turn), np.cos(turn)], axis=1)

    @property
    def steps(self) -> int:
        """Number of steps of an episode that starts at the beginning."""
        return len(self._clean) - 1

    def episode(self, seed: int, number: int, start: int | None = None) -> Episode:
        """Draw an episode; it depends on seed, number and start alone.

        Args:
            seed: Seed of everything random.
            number: Number of the episode, from 0.
            start: Step at which it starts; by the option `random_start` if not given.
        """
        if start is None and self._options.random_start:
            start = int(stream(seed, "start", number).integers(self.steps))
        start = start or 0
        drawn = self.randomisation.draw(seed, number)
        size = self.randomisation.value("reference_noise", drawn)
        reference, angles = self._with_noise(stream(seed, "demonstration", number), size)
        return Episode(
            start=start,
            reference=reference,
            reference_angles=angles,
            sensor_noise=self._sensor_noise(seed, number, drawn),
            perturbations=self._draw_perturbations(seed, number),
            plant=self._plants.draw(seed, number, start, len(self._clean)),
            latency=self._latencies.draw(seed, number, start, len(self._clean)),
            drawn_options=drawn,
        )

    def start_of(self, episode: Episode) -> tuple[Array, Array]:
        """Return initial joint angles, rad, and joint velocities, rad/s, each shape (8,)."""
        if not self._options.random_start:
            return self._first_angles, np.zeros(8)
        now, after = self._angles[episode.start : episode.start + 2]
        velocity = (after - now) * self.motion.rate
        return now, np.clip(velocity, -self.top_speeds, self.top_speeds)

    @property
    def has_angles(self) -> bool:
        """Whether the motion has feasible joint angles, which are demonstrated, too."""
        return self._feasible is not None

    @functools.cached_property
    def _first_angles(self) -> Array:
        if self._feasible is not None:
            return self._feasible[0]
        return self.kinematics.angles(self._clean[0], near=np.zeros(8))

    @functools.cached_property
    def _angles(self) -> Array:
        if self._feasible is not None:
            return self._feasible
        return joint_paths.continuous_angles(self._clean, self._first_angles)

    def _with_noise(self, rng: np.random.Generator, size: float) -> tuple[Array, Array | None]:
        """Draw the noise of the demonstration, of a standard deviation.

        Where the motion has feasible joint angles, noise is drawn on them, since near a singular
        pose noise on the posture would be a large one on the angles; the posture then moves as the
        angles move theirs.
        """
        vectors = self._clean.reshape(-1, 4, 3)
        angles = self._feasible
        if angles is None:
            vectors = vectors + size * rng.standard_normal(vectors.shape)
        else:
            still = self.kinematics.posture(angles)
            angles = angles + size * rng.standard_normal(angles.shape)
            moved = self.kinematics.posture(angles) - still
            vectors = vectors + moved.reshape(vectors.shape)
            angles = self._with_end(angles)
        vectors /= np.linalg.norm(vectors, axis=-1, keepdims=True)
        return self._with_end(vectors.reshape(-1, 12)), angles

    def _with_end(self, rows: Array) -> Array:
        """Return rows with the last one repeated, as often as targets are observed beyond it."""
        beyond = max(1, self._options.lookahead)
        return np.concatenate([rows, np.repeat(rows[-1:], beyond, axis=0)])

    def _sensor_noise(self, seed: int, number: int, drawn: Array) -> Array | None:
        if not np.any(self._options.observation_noise):  # neither the number nor an end
            return None
        scale = np.concatenate([np.ones(12 + 8), self._max_joint_speed])
        noise = stream(seed, "sensors", number).standard_normal((len(self._clean), len(scale)))
        return self.randomisation.value("observation_noise", drawn) * scale * noise

    def _draw_perturbations(self, seed: int, number: int) -> Array | None:
        """Draw perturbations: a Poisson process, directions uniform on the sphere."""
        if not self._options.perturbed:
            return None
        rate, size = self._options.perturbation
        rng = stream(seed, "pushes", number)
        moments = len(self._clean)
        length = max(1, round(_PUSH_DURATION * self.motion.rate))
        forces = np.zeros((moments, 2, 3))
        for begin in np.repeat(np.arange(moments), rng.poisson(rate / self.motion.rate, moments)):
            direction = rng.standard_normal(3)
            force = size * direction / np.linalg.norm(direction)
            forces[begin : begin + length, rng.integers(2)] += force
        return forces
