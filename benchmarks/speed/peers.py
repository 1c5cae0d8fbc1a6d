"""Other people's libraries at the same work; ReservoirPy where it is installed."""

from __future__ import annotations

import functools
import importlib.metadata
import importlib.util
from collections.abc import Callable
from typing import Any

import numpy as np
from dm_control import suite
from numpy.random import Generator

from benchmarks.speed.environment import bare_steps, env_steps
from benchmarks.speed.timing import Case, Report, Sizes, in_turn, ratio
from benchmarks.speed.training import Rehearsal
from mpma_mj.agents.config import MPMAConfig
from mpma_mj.envs.load import load
from mpma_mj.training.config import RunConfig
from mpma_mj.training.factory import one_thread

__all__ = ["joined", "measure", "stepped"]

Step = Callable[[Any], Any]  # from an input, shape (D,), to an output, shape (K,)

_STEPS = 100  # of what is stepped with inputs of its own
_CONNECTIONS = 10  # of a neuron, as in our own
_REACHER = "dm_control's reacher"


def measure(sizes: Sizes) -> Report:
    """Time peers beside ours, all per control step of one run."""
    config = RunConfig.of(nodes=sizes.nodes)
    reacher = functools.partial(suite.load, "reacher", "easy")
    pushes = np.random.default_rng(0).uniform(-1.0, 1.0, (_STEPS, *reacher().action_spec().shape))
    one, many = "our agent, act and observe", f"our agents, {sizes.runs} side by side, per run"
    networks: dict[str, Case] = {}
    note = "ReservoirPy is not installed; `pip install -e '.[bench]'` brings it."
    with one_thread():
        ours = Rehearsal(config)
        if importlib.util.find_spec("reservoirpy") is not None:
            note = f"ReservoirPy {importlib.metadata.version('reservoirpy')}."
            for name, make in (("models", joined), ("nodes", stepped)):
                case = _networks(config, ours, make)
                networks[f"the same networks as ReservoirPy's {name}"] = case
        cases = {
            one: ours.acts,
            many: Rehearsal(config, sizes.runs).acts,
            "our arms, env.step": env_steps(load()),
            "our arms, bare mj_step calls": bare_steps(load()),
            f"{_REACHER}, env.step": env_steps(reacher(), pushes),
            f"{_REACHER}, bare mj_step calls": bare_steps(reacher(), pushes),
        }
        times = in_turn("timing peers", cases | networks, sizes.rounds)
    for arms in ("our arms", _REACHER):
        floor = times[f"{arms}, bare mj_step calls"]
        times[f"{arms}, env.step less its physics"] = times[f"{arms}, env.step"] - floor
    targets = {
        f"{theirs} over {name}": ratio(times[theirs], times[name], least, at_least=True)
        for theirs in networks
        for name, least in ((one, 2.5), (many, 6.0))
    }
    return Report(times, targets, (note,))


def _networks(config: RunConfig, ours: Rehearsal, make: Callable[..., Step]) -> Case:
    """Return control steps of networks of the sizes of our agent's, three a module.

    They do less than ours: without noise, gates and feedback controller, and nothing is remembered
    to be learned from. Readouts hear reservoir and input, as ours do. Each is stepped once a
    control step, since a step leads to the next input.
    """
    settings, state = config.agent, ours.agent.state_dict()
    assert isinstance(settings, MPMAConfig)
    rng, networks = np.random.default_rng(0), []
    for name in ("inverse", "forward", "predictor"):
        *_, outputs, features = state[f"{name}.weights"].shape
        inputs = features - settings.nodes
        for _ in range(settings.modules):
            step = make(settings.nodes, settings.spectral_radius, inputs, outputs, rng)
            networks.append((step, rng.uniform(-1.0, 1.0, (_STEPS, inputs))))

    def run() -> int:
        for number in range(_STEPS):
            for step, inputs in networks:
                step(inputs[number])
        return _STEPS

    return Case(run)


def joined(nodes: int, radius: float, inputs: int, outputs: int, rng: Generator) -> Step:
    """Return the step of a network as a `Model`, as ReservoirPy's users have it."""
    from reservoirpy.nodes import Input

    source, readout = Input(), _readout(nodes + inputs, outputs, rng)
    model = (source >> _reservoir(nodes, radius, rng) >> readout) & (source >> readout)
    return model.step


def stepped(nodes: int, radius: float, inputs: int, outputs: int, rng: Generator) -> Step:
    """Return the step of a network whose nodes are stepped one by one, which costs less."""
    readout, reservoir = _readout(nodes + inputs, outputs, rng), _reservoir(nodes, radius, rng)
    return lambda x: readout.step(np.concatenate([reservoir.step(x), x]))


def _reservoir(nodes: int, radius: float, rng: Generator) -> Any:
    from reservoirpy.mat_gen import uniform
    from reservoirpy.nodes import Reservoir

    return Reservoir(
        nodes,
        sr=radius,
        rc_connectivity=min(1.0, _CONNECTIONS / nodes),
        input_connectivity=1.0,
        W=uniform,
        Win=uniform,
        seed=rng.spawn(1)[0],
    )


def _readout(features: int, outputs: int, rng: Generator) -> Any:
    from reservoirpy.nodes import Ridge

    return Ridge(Wout=rng.uniform(-1.0, 1.0, (features, outputs)), bias=np.zeros(outputs))
