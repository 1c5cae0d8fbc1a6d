"""Chains of known robots, and random ones."""

import numpy as np
from hypothesis import strategies as st

from mpma_mj.errors import BadOptionError
from mpma_mj.robots.chain import Chain

__all__ = ["CHAINS", "LEFT", "RIGHT", "chains", "random_chain", "unit"]

FREE = np.full(4, np.inf)

# The arms of the package.
LEFT = Chain(
    np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, 1], [0, -1, 0]]),
    np.array([0, 0, -1.0]),
    np.array([0, 0, -1.0]),
    -FREE,
    FREE,
)
RIGHT = Chain(LEFT.axes * [[-1.0], [1], [-1], [1]], LEFT.upper_arm, LEFT.forearm, -FREE, FREE)

CHAINS = {
    # like Unitree H1: the first axis is tilted by 25°, the upper arm 3° off the third
    "tilted": Chain(
        np.array([[0, 0.906308, 0.422618], [1, 0, 0], [0, 0, 1], [0, 1, 0]]),
        np.array([0.056, 0, -0.998]),
        np.array([0.998, 0.002, -0.063]),
        np.array([-2.87, -0.34, -1.3, -1.25]),
        np.array([2.87, 3.11, 4.45, 2.61]),
    ),
    # like OpenArm: flexion first, narrow ranges
    "narrow": Chain(
        np.array([[0, 1.0, 0], [-1, 0, 0], [0, 0, -1], [0, -1, 0]]),
        np.array([0, 0, -1.0]),
        np.array([0, 0, -1.0]),
        np.array([-3.491, -3.316, -1.571, 0.0]),
        np.array([1.396, 0.175, 1.571, 2.443]),
    ),
    # like the CMU humanoid: third axis and elbow are parallel, the upper arm across both
    "parallel": Chain(
        np.array([[-0.866, 0, -0.5], [0, -1, 0], [0.5, 0, -0.866], [0.5, 0, -0.866]]),
        np.array([0, 1.0, 0]),
        np.array([0, 1.0, 0]),
        np.array([-1.1, -1.571, -1.047, -0.175]),
        np.array([1.571, 1.571, 1.571, 2.967]),
    ),
}


def unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def random_chain(rng: np.random.Generator) -> Chain:
    """Return an arm of any axes, without ranges."""
    while True:
        try:
            return Chain(rng.normal(size=(4, 3)), *rng.normal(size=(2, 3)), -FREE, FREE)
        except BadOptionError:  # two of them are parallel
            continue


chains = st.integers(0, 2**32 - 1).map(lambda seed: random_chain(np.random.default_rng(seed)))
