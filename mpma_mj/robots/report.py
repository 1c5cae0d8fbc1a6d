"""Report on a robot: its arms, what they reach, and what is unknown of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.kinematics import SIDES
from mpma_mj.robots.assembly import assemble
from mpma_mj.robots.chain import Chain
from mpma_mj.robots.geometry import POINTS, chains
from mpma_mj.robots.poses import POSES, pose_angles, pose_directions
from mpma_mj.robots.reachability import REACHED, deviation, reachable_share
from mpma_mj.robots.robot import QUANTITIES, JointValues, Robot

__all__ = ["PoseResult", "RobotReport"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PoseResult:
    """How near a robot comes to a pose.

    Attributes:
        joint_angles: Joint angles, shape (8,), rad.
        directions: Directions u and f of both arms in the pose, shape (2, 6).
        deviations: Deviation of each arm from them, shape (2,), degrees.
    """

    joint_angles: Array
    directions: Array
    deviations: Array

    def __str__(self) -> str:
        """Return the deviations as text."""
        left, right = (f"{degrees:.1f}°" for degrees in self.deviations)
        text = f"{left} off" if left == right else f"left {left}, right {right} off"
        return f"{text}, out of reach" if self.deviations.max() > REACHED else text


class RobotReport:
    """Properties of a robot of which physical values may be unknown.

    Attributes:
        robot: The robot.
        model: Its model, assembled.
        chains: Its left and its right arm.
        poses: Its results in `POSES`.
    """

    def __init__(self, robot: Robot) -> None:
        """Assemble the robot; raises a BadOptionError as `assemble` does."""
        one = {"speed": JointValues((1.0,) * 4, "choice: shows where arms are")}  # if unknown
        posed = replace(robot, physical=one | {k: v for k, v in robot.physical.items() if v.values})
        self.robot = robot
        self.model: mujoco.MjModel = assemble(posed, ideal=True).compile()
        self.chains = chains(self.model, robot.joints)
        self.poses = {pose: _pose_result(self.chains, pose) for pose in POSES}

    def reachable(self, directions: Array) -> tuple[float, float]:
        """Return the share of postures that the left and the right arm reach to 5°.

        Args:
            directions: Directions u and f of both arms, shape (N, 12).
        """
        left, right = self.chains
        halves = directions[:, :6], directions[:, 6:]
        return reachable_share(left, halves[0]), reachable_share(right, halves[1])

    def lines(self) -> list[str]:
        """Return what the robot is, as lines of text."""
        robot = self.robot
        title = "" if robot.title == robot.name else f"{robot.title}, "
        lines = [f"{robot.name}: {title}{robot.model}"]
        for side, four in zip(SIDES, (robot.joints[:4], robot.joints[4:]), strict=True):
            lines.append(f"{side:<10}{', '.join(four)}")
        if not robot.complete:
            end = ", ".join(robot.wrists) if robot.wrists else "what is farthest from the elbow"
            lines.append(f"{'forearms':<10}end at {end}")
        lines.append(f"{'lengths':<10}{self._lengths()}")
        lines.append(f"{'ranges':<10}{self._ranges()}")
        for pose, result in self.poses.items():
            lines.append(f"{'' if pose in list(POSES)[1:] else 'poses':<10}{pose:<14}{result}")
        return lines

    def physical_lines(self, comments: Mapping[str, str]) -> list[str]:
        """Return the physical values with their sources, as lines of text.

        Args:
            comments: Comments on unknown values by their quantity.
        """
        if self.robot.complete:
            return [f"{'physical':<10}as the model has it"]
        lines = []
        for quantity, unit in QUANTITIES.items():
            known = self.robot.physical.get(quantity, JointValues())
            if known.values is not None:
                numbers = ", ".join(f"{value:g}" for value in known.values)
                lines.append(f"{quantity:<10}{numbers} {unit} ({known.source})")
            else:
                comment = f"; {comments[quantity]}" if quantity in comments else ""
                lines.append(f"{quantity:<10}unknown{comment}")
        return lines

    @property
    def unknown(self) -> list[str]:
        """Physical values that are unknown."""
        if self.robot.complete:
            return []
        known = self.robot.physical
        return [q for q in QUANTITIES if known.get(q, JointValues()).values is None]

    def _lengths(self) -> str:
        data = mujoco.MjData(self.model)
        mujoco.mj_kinematics(self.model, data)
        points = [[data.site(f"{side}_{point}").xpos for point in POINTS] for side in SIDES]
        lengths = np.linalg.norm(np.diff(points, axis=1), axis=-1)
        return ", ".join(
            f"{side} upper arm {upper_arm:.3f} m, forearm {forearm:.3f} m"
            for side, (upper_arm, forearm) in zip(SIDES, lengths, strict=True)
        )

    def _ranges(self) -> str:
        """Return the ranges of the left arm's joints, and those of the right arm that differ."""
        left, right = ([_ranges(c)[i] for i in range(4)] for c in self.chains)
        return f"left {', '.join(left)}; right {', '.join(right)}"


def _ranges(chain: Chain) -> list[str]:
    return [
        f"{np.degrees(low):.0f}…{np.degrees(high):.0f}°" if np.isfinite(high - low) else "free"
        for low, high in zip(chain.lowest, chain.highest, strict=True)
    ]


def _pose_result(arms: Sequence[Chain], pose: str) -> PoseResult:
    angles, directions = pose_angles(arms, pose), pose_directions(pose)
    off = [
        deviation(c, q, d) for c, q, d in zip(arms, angles.reshape(2, 4), directions, strict=True)
    ]
    return PoseResult(angles, directions, np.array(off))
