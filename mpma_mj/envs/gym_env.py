"""The Gymnasium face of the environment.

Observations are a dictionary, or one array:

    env = gymnasium.make("mpma_mj:TwoArmImitation-v0", motion="ymca", arms="physics")
    env = gymnasium.make("mpma_mj:TwoArmImitationFlat-v0", motion="dance.tsv")
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, SupportsFloat

import gymnasium
import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpma_mj.envs.load import make_environment
from mpma_mj.envs.options import check_seed, options_from
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.envs.rendering import ArmRenderer
from mpma_mj.envs.spaces import action_space, flatten, observation_space
from mpma_mj.errors import BadOptionError

if TYPE_CHECKING:
    from mpma_mj.envs.viewer import ArmViewer

__all__ = ["FlatImitationEnv", "ImitationEnv"]

Array = NDArray[np.float64]

# All that a next step depends on; the rest of MuJoCo's data follows from it.
_STATE = mujoco.mjtState.mjSTATE_INTEGRATION


class ImitationEnv(gymnasium.Env[Any, Any]):
    """Follow a demonstrated movement with both arms.

    Observation, action and reward are those of `mpma_mj.load`, number for number. Observations
    are float64, as they are computed. The action space is float32, as reinforcement learning
    libraries expect of it (a policy's output is, and Gymnasium's own MuJoCo environments have
    both so); float64 actions are taken too and are not rounded.

    An episode is truncated at the end of the demonstration, and terminated if the simulation
    diverges or the arms are farther off than `termination_distance` allows. `info` holds

    - `reward_terms`: the terms of the reward by name, each in [0, 1];
    - `clipped`: how many entries of the action were beyond [-1, 1], and were clipped;
    - `termination_reason`: why the episode has ended; empty while it goes on.

    Episodes follow from the seed: `reset(seed=s)` starts the first episode of seed s, and
    `reset()` the next one. Before any seed is given it is the option `seed`. In a vector
    environment give one to the first reset, or all environments see the same noise.

    Attributes:
        seen: The last observation as a dictionary, also where the environment is flat.
        max_joint_speed: Joint speeds that action 1 commands, shape (8,), rad/s.
        control_timestep: Time between two actions, s.

    A pickled environment, or a copy, goes on as the original does, with a renderer of its own;
    it is made again from its options, so a recording has to be where it was.
    """

    _flat = False
    metadata = {"render_modes": ["rgb_array", "human"], "render_fps": 20}  # noqa: RUF012

    def __init__(self, *, render_mode: str | None = None, **options: Any) -> None:
        """Load the environment.

        Args:
            render_mode: "rgb_array" for pictures, shape (480, 640, 3), "human" for MuJoCo's
                viewer at the speed of life, or None for neither.
            **options: Those of `mpma_mj.load`.

        Raises:
            BadOptionError: An option is outside what it may be, or there is none of that name.
            MpmaError: The movement cannot be read, or is faster than the arms.
        """
        modes = self.metadata["render_modes"]
        if render_mode is not None and render_mode not in modes:
            raise BadOptionError(f"render_mode is '{render_mode}'; expected {' or '.join(modes)}")
        self.render_mode = render_mode
        self._options = options_from(**options)
        self._env = make_environment(self._options)
        self._over = True
        self.seen: dict[str, Array] = {}
        self.max_joint_speed: Array = self._env.task.max_joint_speed
        self.control_timestep: float = self._env.control_timestep()
        self._renderer: ArmRenderer | None = None
        self._viewer: ArmViewer | None = None
        self.metadata = self.metadata | {"render_fps": round(1.0 / self.control_timestep, 3)}
        self.action_space = action_space()
        shapes = {name: spec.shape for name, spec in self._env.observation_spec().items()}
        self.observation_space = observation_space(shapes, flat=self._flat)
        # Not from the clock: a run can be had again from its options.
        super().reset(seed=int(self._env.task.seed))

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
            seed: Seed of the demonstration's noise, a whole number from 0 up.
            options: There are none.

        Returns:
            Observation and info.

        Raises:
            BadOptionError: The seed is no whole number from 0 up, or there are options.
        """
        if options:
            raise BadOptionError(f"options is {options!r}; expected none, reset has no options")
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
            action: Joint velocities over the joints' top speeds, shape (8,); what is beyond
                [-1, 1] is clipped.

        Returns:
            Observation, reward, whether the episode is terminated, whether it is truncated, and
            `info`, as the class describes them.

        Raises:
            BadOptionError: The action has another shape, or holds what is no finite number.
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
        observation = self._pack(timestep.observation)
        return observation, float(timestep.reward), terminated, truncated, self._info()

    def render(self) -> NDArray[np.uint8] | None:
        """Draw the arms and the demonstration's ghost.

        Returns:
            Picture, shape (480, 640, 3), or None where the mode is "human".

        Raises:
            RenderingError: OpenGL does not draw, or there is no display.
        """
        if self.render_mode is None:
            gymnasium.logger.warn('nothing is drawn without a render_mode, such as "rgb_array"')
            return None
        if self.render_mode == "human":
            self._show()
            return None
        self._renderer = self._renderer or ArmRenderer(self._env.physics)
        return self._renderer.picture(self._ghost())

    def close(self) -> None:
        """Give back the OpenGL context, and close the window; what is drawn next opens them."""
        if self._renderer is not None:
            self._renderer.close()
        if self._viewer is not None:
            self._viewer.close()
        self._renderer = self._viewer = None

    def __getstate__(self) -> dict[str, Any]:
        """Return what makes the environment again and where it is; no model, no renderer."""
        left = ("_env", "_renderer", "_viewer")
        physics = self._env.physics
        return {name: value for name, value in vars(self).items() if name not in left} | {
            "task": vars(self._env.task),
            "arms": physics.get_state(_STATE),
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Make the environment again and take it to where it was."""
        task, arms = state.pop("task"), state.pop("arms")
        vars(self).update(state)
        self._renderer = self._viewer = None
        self._env = make_environment(self._options)
        self._env.reset()  # or its first step would be one
        vars(self._env.task).update(task)
        physics = self._env.physics
        physics.set_state(arms, _STATE)
        mujoco.mj_kinematics(physics.model.ptr, physics.data.ptr)  # positions from the state

    def _pack(self, observation: dict[str, Array]) -> Any:
        self.seen = observation
        return flatten(observation) if self._flat else observation

    def _info(self) -> dict[str, Any]:
        task = self._env.task
        terms = task.reward_terms(self._env.physics)
        return {
            "reward_terms": terms,
            "clipped": task.clipped,
            "termination_reason": task.termination_reason,
        }

    def _ghost(self) -> Array:
        return self._env.task.reference

    def _show(self) -> None:
        if self._viewer is None:
            from mpma_mj.envs.viewer import ArmViewer  # and the libraries of windows

            self._viewer = ArmViewer(self._env.physics, self.control_timestep)
        self._viewer.show(self._ghost())


class FlatImitationEnv(ImitationEnv):
    """The same with observations of one array, float64, shape (52 + C,).

    In this order, C being the context's length: posture 0 to 11, reference 12 to 23, target
    24 to 35, context from 36, then eight joint angles, rad, and eight joint velocities, rad/s;
    at the end `lookahead` and `phase`, where options ask for them.
    """

    _flat = True
