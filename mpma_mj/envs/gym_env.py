"""Gymnasium's interface to the environment, with observations as a dictionary or as one array.

env = gymnasium.make("mpma_mj:TwoArmImitation-v0", motion="ymca", arms="physics")
env = gymnasium.make("mpma_mj:TwoArmImitationFlat-v0", motion="dance.tsv")
"""

from __future__ import annotations

import copy
import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, SupportsFloat

import gymnasium
import mujoco
import numpy as np
from gymnasium.envs.registration import EnvSpec
from numpy.typing import ArrayLike, NDArray

from mpma_mj.envs.load import make_environment
from mpma_mj.envs.observation import action_space, flatten, observation_space
from mpma_mj.envs.options import check_seed, options_among
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.envs.rendering import ArmRenderer, checked_mode, make_renderer
from mpma_mj.envs.vector_conventions import check_no_options
from mpma_mj.motions import Motion

if TYPE_CHECKING:
    from mpma_mj.envs.viewer import ArmViewer

__all__: list[str] = ["FlatImitationEnv", "ImitationEnv"]

Array = NDArray[np.float64]

# The next step depends on this state alone; the rest of MuJoCo's data follows from it.
_STATE = mujoco.mjtState.mjSTATE_INTEGRATION


class ImitationEnv(gymnasium.Env[Any, Any]):
    """Follow a demonstrated motion with both arms.

    Observation, action and reward are those of `mpma_mj.load`, number for number. Observations
    are float64, as they are computed. The action space is float32, as reinforcement learning
    libraries expect (their policies return it, and Gymnasium's own MuJoCo environments have the
    same pair); float64 actions are accepted too and are not rounded.

    An episode is truncated at the end of the demonstration, and terminated if the simulation
    diverges or the arms are farther away than `termination_distance`. `info` contains

    - `reward_terms`: the terms of the reward by name, each in [0, 1];
    - `clipped`: the number of entries of the action outside [-1, 1], which were clipped;
    - `termination_reason`: why the episode has ended; empty while it continues;
    - `plant`: with the option `plants`, the index of the plant that the next action meets;
    - `latency`: where this option is a range, the latency that the next action meets, in control
      steps;
    - each option that is a range, under its name, as drawn for this episode, such as `payload`;
    - at the end of an episode `p_e_percent` and `mpkpe_m`, its tracking errors (see `metrics`), of
      the true posture of the arms.

    Episodes follow from the seed: `reset(seed=s)` starts the first episode of seed s, and
    `reset()` the next one. Before any `reset(seed=…)` it is the argument `seed`. In Gymnasium's
    own vector environments pass a seed to the first reset, or all have the same noise.

    Attributes:
        last_observation: The last observation as a dictionary, also of flat environments.
        max_joint_speed: Joint speeds that action 1 commands, shape (8,), rad/s.
        control_timestep: Time between two actions, s.

    A pickled environment, or a copy, continues as the original does, with another renderer.
    It is made again from its motion and options, so a recording has to stay where it was.
    """

    _flat = False
    _spec: EnvSpec | None = None
    metadata = {"render_modes": ["rgb_array", "human"], "render_fps": 20}  # noqa: RUF012

    def __init__(
        self,
        motion: Motion | str | Path = "ymca",
        *,
        seed: int = 0,
        render_mode: str | None = None,
        width: int = 640,
        height: int = 480,
        camera: str = "front",
        **options: Any,
    ) -> None:
        """Load the environment.

        Args:
            motion: The motion, or its name, or the path of a recording.
            seed: Seed of everything random.
            render_mode: "rgb_array" for pictures, "human" for MuJoCo's viewer in real time, or None
                for neither.
            width: Width of pictures, pixels.
            height: Height of pictures, pixels.
            camera: Name of the model's camera for pictures; ours has front, side, three_quarter.
            **options: The fields of `EnvironmentOptions`, such as arms="kinematic".

        Raises:
            BadOptionError: An option is out of bounds, or does not exist.
            MpmaError: The motion cannot be read, or is faster than the arms.
        """
        self._motion, self._options = motion, options_among(locals())
        self.render_mode = checked_mode(render_mode, self.metadata["render_modes"])
        self._view: dict[str, Any] = {"width": width, "height": height, "camera": camera}
        self._env = make_environment(motion, self._options, seed)
        self._over = True
        self.last_observation: dict[str, Array] = {}
        self.max_joint_speed: Array = self._env.task.max_joint_speed
        self.control_timestep: float = self._env.control_timestep()
        self._viewer: ArmViewer | None = None
        self._renderer = self._make_renderer()
        self.metadata = self.metadata | {"render_fps": round(1.0 / self.control_timestep, 3)}
        self.action_space = action_space()
        shapes = {name: spec.shape for name, spec in self._env.observation_spec().items()}
        self.observation_space = observation_space(shapes, flat=self._flat)
        # Not from the clock: a run is reproducible from its options.
        super().reset(seed=int(self._env.task.seed))

    @property
    def spec(self) -> EnvSpec | None:
        """Specification of Gymnasium, with the length of an episode as `max_episode_steps`."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        # Gymnasium sets it once the environment is made, which alone has the motion's length.
        if spec is not None:
            spec = dataclasses.replace(spec, max_episode_steps=self._env.task.steps)
        self._spec = spec

    @property
    def physics(self) -> PhysicsArms:
        """The arms."""
        return self._env.physics

    @property
    def last_action(self) -> Array:
        """The last action as it was given, shape (8,)."""
        return self._env.task.last_action

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start the next episode, or the first one of a seed.

        Args:
            seed: Seed of everything random, a whole number from 0 up.
            options: None or empty.

        Returns:
            Observation and info.

        Raises:
            BadOptionError: The seed is negative or no integer, or there are options.
        """
        check_no_options(options)
        seed = None if seed is None else check_seed(seed)
        super().reset(seed=seed)
        if seed is not None:
            self._env.task.seed = seed
            self._env.task.episode = 0
        timestep = self._env.reset()
        self._over = False
        if self.render_mode == "human":
            self._show()
        return self._pack(timestep.observation), self._info()

    def step(self, action: ArrayLike) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        """Move the arms for one control step.

        Args:
            action: Joint velocities over the joints' top speeds, shape (8,); entries outside
                [-1, 1] are clipped.

        Returns:
            Observation, reward, whether the episode is terminated, whether it is truncated, and
            `info`, as the class describes them.

        Raises:
            BadOptionError: The action has another shape, or an entry is no finite number.
            ResetNeeded: No episode has begun, or it is over.
        """
        if self._over:
            raise gymnasium.error.ResetNeeded("no episode is under way; call reset()")
        timestep = self._env.step(action)
        self._over = timestep.last()
        if self.render_mode == "human":
            self._show()
        terminated = self._over and timestep.discount == 0.0
        truncated = self._over and not terminated
        observation, info = self._pack(timestep.observation), self._info()
        if self._over:
            info |= self.tracking_errors()
        return observation, float(timestep.reward), terminated, truncated, info

    def tracking_errors(self) -> dict[str, float]:
        """Return `p_e_percent` and `mpkpe_m` of the episode so far; see `metrics`."""
        return self._env.task.tracking_errors(self._env.physics)

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture of the arms and of the demonstration's ghost, or show them.

        Returns:
            Picture, shape (height, width, 3), or None where the mode is "human".

        Raises:
            RenderingError: OpenGL does not draw, or there is no display.
        """
        if self._renderer is not None:
            return self._renderer.picture(self._env.task.reference)
        if self.render_mode is None:
            gymnasium.logger.warn('nothing is drawn without a render_mode, such as "rgb_array"')
        else:
            self._show()
        return None

    def close(self) -> None:
        """Release the OpenGL context and close the window; the next picture opens them again."""
        if self._renderer is not None:
            self._renderer.close()
        if self._viewer is not None:
            self._viewer.close()
        self._viewer = None

    def __copy__(self) -> Self:
        """Return a copy that shares nothing with this one, as a deep copy does."""
        return copy.deepcopy(self)

    def __getstate__(self) -> dict[str, Any]:
        """Return motion, options and state; no model, no renderer."""
        dropped = ("_env", "_renderer", "_viewer")
        physics = self._env.physics
        return {name: value for name, value in vars(self).items() if name not in dropped} | {
            "task": vars(self._env.task),
            "arms": physics.get_state(_STATE),
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Make the environment again and set its state."""
        task, arms = state.pop("task"), state.pop("arms")
        vars(self).update(state)
        self._env = make_environment(self._motion, self._options)
        self._viewer, self._renderer = None, self._make_renderer()
        self._env.reset()  # or its first step would be one
        vars(self._env.task).update(task)
        physics = self._env.physics
        self._env.task.set_plant(physics)
        physics.set_state(arms, _STATE)
        mujoco.mj_kinematics(physics.model.ptr, physics.data.ptr)  # positions from the state

    def _make_renderer(self) -> ArmRenderer | None:
        return make_renderer(self._env.physics, self.render_mode, **self._view)

    def _pack(self, observation: dict[str, Array]) -> Any:
        self.last_observation = observation
        return flatten(observation) if self._flat else observation

    def _info(self) -> dict[str, Any]:
        task = self._env.task
        hidden = {"plant": task.plant, "latency": task.latency} | task.drawn
        return {
            "reward_terms": task.reward_terms(self._env.physics),
            "clipped": task.clipped,
            "termination_reason": task.termination_reason,
        } | {name: now for name, now in hidden.items() if now is not None}

    def _show(self) -> None:
        if self._viewer is None:
            from mpma_mj.envs.viewer import ArmViewer  # and the libraries of windows

            self._viewer = ArmViewer(self._env.physics, self.control_timestep)
        self._viewer.show(self._env.task.reference)


class FlatImitationEnv(ImitationEnv):
    """The same with observations as one array, float64, shape (52 + C,).

    In this order, C being the context's length: posture 0 to 11, reference 12 to 23, target
    24 to 35, context from 36, then eight joint angles, rad, and eight joint velocities, rad/s;
    at the end `lookahead` and `phase`, with the options of these names, and `move`, with
    `error_observation`.

    Gymnasium's `FlattenObservation` returns the same array, but cannot be pickled, adds 15 % to
    a step, and cannot be registered with an entry point for vectors.
    """

    _flat = True
