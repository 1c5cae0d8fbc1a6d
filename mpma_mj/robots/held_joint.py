"""Joint angles of a chain that come near to directions where one joint is held at an angle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mpma_mj.robots.chain import Chain
from mpma_mj.robots.rotations import about, between, circle, frame, rotated

__all__ = ["with_first", "with_third"]

Array = NDArray[np.float64]


def with_first(chain: Chain, directions: Array, first: Array) -> Array:
    """Solve for the other joints where the first is held.

    The second brings the third axis, the third both directions, and the elbow the forearm as near
    to their places as it alone can.

    Args:
        chain: The arm.
        directions: Unit vectors u and f, shape (..., 6).
        first: Angles of the first joint, shape (...), rad.

    Returns:
        Joint angles, shape (..., 2, 4), rad, for both ways to bend the elbow.
    """
    upper_arm, forearm = (
        rotated(one, chain.axes[0], -first)[..., None, :]
        for one in (directions[..., :3], directions[..., 3:])
    )
    elbow = circle(
        chain.axes[3], chain.forearm, chain.upper_arm, between(upper_arm, forearm)[..., 0]
    )
    bent = rotated(chain.forearm, chain.axes[3], elbow)
    third_axis = np.swapaxes(frame(chain.upper_arm, bent), -1, -2) @ chain.axes[2]
    place = (frame(upper_arm, forearm) @ third_axis[..., None])[..., 0]
    second = about(chain.axes[1], chain.axes[2], place)
    upper_arm, forearm = (rotated(one, chain.axes[1], -second) for one in (upper_arm, forearm))
    third = about(
        chain.axes[2],
        np.stack(np.broadcast_arrays(chain.upper_arm, bent), axis=-2),
        np.stack([upper_arm, forearm], axis=-2),
        together=True,
    )
    elbow = about(chain.axes[3], chain.forearm, rotated(forearm, chain.axes[2], -third))
    return np.stack(
        [np.broadcast_to(first[..., None], second.shape), second, third, elbow], axis=-1
    )


def with_third(chain: Chain, directions: Array, third: Array) -> Array:
    """Solve for the other joints where the third is held.

    The first two bring the upper arm to its place, if they can, and the elbow the forearm as near
    to its place as it can.

    Args:
        chain: The arm.
        directions: Unit vectors u and f, shape (..., 6).
        third: Angles of the third joint, shape (...), rad.

    Returns:
        Joint angles, shape (..., 2, 4), rad.
    """
    upper_arm, forearm = directions[..., None, :3], directions[..., None, 3:]
    moved = rotated(chain.upper_arm, chain.axes[2], third)
    second = circle(
        chain.axes[1], moved, chain.axes[0], between(chain.axes[0], upper_arm[..., 0, :])
    )
    first = about(chain.axes[0], rotated(moved[..., None, :], chain.axes[1], second), upper_arm)
    third = np.broadcast_to(third[..., None], second.shape)
    for axis, angle in zip(chain.axes[:3], (first, second, third), strict=True):
        forearm = rotated(forearm, axis, -angle)
    elbow = about(chain.axes[3], chain.forearm, forearm)
    return np.stack([first, second, third, elbow], axis=-1)
