"""Other people's libraries at the same work, where they are installed."""

from __future__ import annotations

import functools
import importlib.metadata
import importlib.util

import numpy as np
from dm_control import suite

from mpma_mj.agents.config import MPMAConfig
from mpma_mj.bench.environment import bare_steps, env_steps
from mpma_mj.bench.rehearsal import Rehearsal
from mpma_mj.bench.report import Report
from mpma_mj.bench.reservoirs import reservoirs
from mpma_mj.bench.timing import Case, Progress, in_turn, ratio, spread
from mpma_mj.envs.gym_env import FlatImitationEnv
from mpma_mj.envs.load import load
from mpma_mj.motions import ymca
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import agent_of, make_environments, one_thread
from mpma_mj.training.rollout import record_epoch

__all__ = ["PACKAGES", "measure"]

PACKAGES = {"reservoirpy": "ReservoirPy", "stable_baselines3": "Stable-Baselines3"}
"""What is timed where it is installed: names of modules, and what people call them."""

_CONFIG = RunConfig()
_RUNS = 20
_ROUNDS = 11
_LONGER_THAN_AN_EPISODE = 1024
_STEPS = 100  # of what is stepped with inputs of its own

_ONE, _MANY = "our agent, act and observe", f"our agents, {_RUNS} side by side, per run"
_WANTED = {_ONE: 2.5, _MANY: 6.0}  # how many times as fast as ReservoirPy
_NETWORKS = {  # by whether reservoir and readout are joined
    "the same networks as ReservoirPy's models": True,
    "the same networks as ReservoirPy's nodes": False,
}
_OUR_LOOP, _THEIR_LOOP = "our loop, an episode recorded", "Stable-Baselines3's PPO, one collected"
_REACHER = "dm_control's reacher, env.step"
_REACHER_FLOOR = "dm_control's reacher, bare mj_step calls"
_OUR_STEP, _OUR_FLOOR = "our arms, env.step", "our arms, bare mj_step calls"


def measure(progress: Progress) -> Report:
    """Time peers beside ours, all per control step of one run.

    Args:
        progress: Shows how far the rounds are.
    """
    there = {name for name in PACKAGES if importlib.util.find_spec(name) is not None}
    reacher = functools.partial(suite.load, "reacher", "easy")
    pushes = np.random.default_rng(0).uniform(-1.0, 1.0, (_STEPS, *reacher().action_spec().shape))
    with one_thread():
        one = Rehearsal.alone(_CONFIG)
        cases = {_ONE: one.acts, _MANY: Rehearsal.side_by_side(_CONFIG, _RUNS).acts}
        cases |= {_OUR_STEP: env_steps(load()), _OUR_FLOOR: bare_steps(load())}
        cases |= {
            _REACHER: env_steps(reacher(), pushes),
            _REACHER_FLOOR: bare_steps(reacher(), pushes),
        }
        cases[_OUR_LOOP] = _our_loop()
        if "reservoirpy" in there:
            cases |= {name: _networks(one, joined) for name, joined in _NETWORKS.items()}
        if "stable_baselines3" in there:
            cases[_THEIR_LOOP] = _their_loop()
        times = in_turn(cases, progress(range(_ROUNDS), "timing peers"))
    for step, floor in ((_OUR_STEP, _OUR_FLOOR), (_REACHER, _REACHER_FLOOR)):
        times[f"{step} less its physics"] = times[step] - times[floor]
    ratios = {
        f"{theirs} over {ours}": ratio(times[theirs], times[ours], wanted, at_least=True)
        for theirs in _NETWORKS
        if theirs in times
        for ours, wanted in _WANTED.items()
    }
    return Report(
        seconds={name: spread(values) for name, values in times.items()},
        ratios=ratios,
        notes=tuple(_note(name, name in there) for name in PACKAGES),
    )


def _networks(one: Rehearsal, joined: bool) -> Case:
    """Return the networks of our agent in ReservoirPy."""
    config, state = _CONFIG.agent, one.agent.state_dict()
    assert isinstance(config, MPMAConfig)
    sizes = []
    for name in ("inverse", "forward", "predictor"):
        *_, outputs, features = state[f"{name}.weights"].shape
        sizes.append((features - config.nodes, outputs))
    radius = config.spectral_radius
    return reservoirs(config.modules, config.nodes, radius, sizes, _STEPS, joined=joined)


def _our_loop() -> Case:
    """Return the loop around an agent that does next to nothing."""
    config = _CONFIG.replace(agent="random")
    env = make_environments(config, config.seed, ymca())
    agent = agent_of(config, env, config.seed)
    return Case(lambda: len(record_epoch(env, agent, 0)))


def _their_loop() -> Case:
    """Return an episode's rollout by PPO with its default network, without learning from it."""
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.callbacks import StopTrainingOnMaxEpisodes

    torch.set_num_threads(1)
    model = PPO(
        "MlpPolicy", FlatImitationEnv(), n_steps=_LONGER_THAN_AN_EPISODE, device="cpu", seed=0
    )

    def run() -> int:
        model.learn(_LONGER_THAN_AN_EPISODE, callback=StopTrainingOnMaxEpisodes(1))
        return int(model.num_timesteps)

    return Case(run)


def _note(name: str, there: bool) -> str:
    if there:
        return f"{PACKAGES[name]} {importlib.metadata.version(name.replace('_', '-'))}."
    return f"{PACKAGES[name]} is not installed; `pip install -e '.[bench]'` brings it."
