"""The Gymnasium face of the environment.

Observations are a dictionary, or one array:

    env = gymnasium.make("mpma_mj:TwoArmImitation-v0", motion="ymca", arms="physics")
    env = gymnasium.make("mpma_mj:TwoArmImitationFlat-v0", motion="dance.tsv")
"""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any, SupportsFloat

import gymnasium
import mujoco
import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from mpma_mj.envs.load import load
from mpma_mj.envs.rendering import ArmRenderer
from mpma_mj.errors import BadOptionError

if TYPE_CHECKING:
    from mpma_mj.envs.viewer import ArmViewer

__all__ = ["FlatImitationEnv", "ImitationEnv"]

Array = NDArray[np.float64]

# Coordinates of unit vectors, which may be rounded to a little more than 1.
_UNIT = 1.0 + 1e-9
_BOUNDS = {"posture": (-_UNIT, _UNIT), "reference": (-_UNIT, _UNIT), "target": (-_UNIT, _UNIT)}
_BOUNDS["context"] = (0.0, 1.0)
# Shoulders turn without end, and arms that have mass overshoot, elbows their range too: the one
# bound of angles and velocities that holds is where MuJoCo takes a simulation for diverged.
_NO_BOUND = (-mujoco.mjMAXVAL, mujoco.mjMAXVAL)

# All that a next step depends on; the rest of MuJoCo's data follows from it.
_STATE = mujoco.mjtState.mjSTATE_INTEGRATION


class ImitationEnv(gymnasium.Env[Any, Any]):
    """Follow a demonstrated movement with both arms.

    Observation, action and reward are those of `mpma_mj.load`, number for number. Observations
    are float64, as they are computed. The action space is float32, as reinforcement learning
    libraries expect of it (a policy's output is, and Gymnasium's own MuJoCo environments have
    both so); float64 actions are taken too and are not rounded.

    An episode is truncated at the end of the demonstration and terminated if the simulation
    diverges. `info["reward_terms"]` holds the terms of the reward by name, each in [0, 1].

    Episodes follow from the seed: `reset(seed=s)` starts the first episode of seed s, and
    `reset()` the next one. Before any seed is given it is the option `seed`. In a vector
    environment give one to the first reset, or all environments see the same noise.

    A pickled environment, or a copy, goes on as the original does, with a renderer of its own;
    it is made again from its options, so a recording has to be where it was.
    """

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
        known = inspect.signature(load).parameters
        for name in options:
            if name not in known:
                raise BadOptionError(
                    f"no option '{name}'; expected one of {', '.join(known)}, render_mode"
                )
        modes = self.metadata["render_modes"]
        if render_mode is not None and render_mode not in modes:
            raise BadOptionError(f"render_mode is '{render_mode}'; expected {' or '.join(modes)}")
        self.render_mode = render_mode
        self._options = options
        self._env = load(**options)
        self._over = True
        self._renderer: ArmRenderer | None = None
        self._viewer: ArmViewer | None = None
        rate = 1.0 / self._env.control_timestep()
        self.metadata = self.metadata | {"render_fps": round(rate, 3)}
        self.action_space = spaces.Box(-1.0, 1.0, self._env.action_spec().shape)  # float32
        self.observation_space = self._space(
            {name: _box(name, spec.shape) for name, spec in self._env.observation_spec().items()}
        )
        # Not from the clock: a run can be had again from its options.
        super().reset(seed=int(options.get("seed", known["seed"].default)))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start the next episode, or the first one of a seed.

        Args:
            seed: Seed of the demonstration's noise, a whole number from 0 up.
            options: Not used.

        Returns:
            Observation, and the terms of the reward at the start.
        """
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
                [-1, 1] is clipped, and what is not a number makes the simulation diverge.

        Returns:
            Observation, reward, whether the simulation has diverged, whether the demonstration
            is at its end, and the terms of the reward.

        Raises:
            BadOptionError: The action has another shape.
            ResetNeeded: No episode has begun, or it is over.
        """
        if self._over:
            raise gymnasium.error.ResetNeeded("no episode is under way; call reset()")
        action = np.asarray(action, np.float64)
        if action.shape != self.action_space.shape:
            raise BadOptionError(
                f"action has shape {action.shape}; expected {self.action_space.shape}"
            )
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
            "task": vars(self._env.task).copy(),
            "arms": physics.get_state(_STATE),
            "diverged": physics.diverged,
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Make the environment again and take it to where it was."""
        state = state.copy()
        task, arms, diverged = (state.pop(name) for name in ("task", "arms", "diverged"))
        vars(self).update(state)
        self._renderer = self._viewer = None
        self._env = load(**self._options)
        self._env.reset()  # or its first step would be one
        vars(self._env.task).update(task)
        physics = self._env.physics
        physics.set_state(arms, _STATE)
        mujoco.mj_step1(physics.model.ptr, physics.data.ptr)  # positions from the state
        physics.diverged = diverged

    def _space(self, parts: dict[str, spaces.Box[np.float64]]) -> spaces.Space[Any]:
        return spaces.Dict(list(parts.items()))  # a dictionary would be sorted by name

    def _pack(self, observation: dict[str, Array]) -> Any:
        return observation

    def _info(self) -> dict[str, Any]:
        physics = self._env.physics
        terms = self._env.task.reward_terms(physics)
        # Where arms that diverged are, says nothing: as in the reward.
        return {
            "reward_terms": {k: 0.0 if physics.diverged else float(v) for k, v in terms.items()}
        }

    def _ghost(self) -> Array:
        return self._env.task.get_observation(self._env.physics)["reference"]

    def _show(self) -> None:
        if self._viewer is None:
            from mpma_mj.envs.viewer import ArmViewer  # and the libraries of windows

            self._viewer = ArmViewer(self._env.physics, self._env.control_timestep())
        self._viewer.show(self._ghost())


class FlatImitationEnv(ImitationEnv):
    """The same with observations of one array, float64, shape (52 + C,).

    In this order, C being the context's length: posture 0 to 11, reference 12 to 23, target
    24 to 35, context from 36, then eight joint angles, rad, and eight joint velocities, rad/s.
    """

    def _space(self, parts: dict[str, spaces.Box[np.float64]]) -> spaces.Space[Any]:
        low = np.concatenate([part.low for part in parts.values()])
        high = np.concatenate([part.high for part in parts.values()])
        self._order = tuple(parts)
        return spaces.Box(low, high, dtype=np.float64)

    def _pack(self, observation: dict[str, Array]) -> Array:
        return np.concatenate([observation[name] for name in self._order])


def _box(name: str, shape: tuple[int, ...]) -> spaces.Box[np.float64]:
    low, high = _BOUNDS.get(name, _NO_BOUND)
    return spaces.Box(low, high, shape, dtype=np.float64)
