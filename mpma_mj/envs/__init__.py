"""Environments: two arms that imitate, simulated or kinematic, behind one interface."""

from mpma_mj.envs.load import ARMS, Arms, load
from mpma_mj.envs.physics import KinematicArms, PhysicsArms
from mpma_mj.envs.task import TwoArmImitation

__all__ = ["ARMS", "Arms", "KinematicArms", "PhysicsArms", "TwoArmImitation", "load"]
