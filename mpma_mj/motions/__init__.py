"""What is imitated: movements of two arms, built in or read from recordings."""

from mpma_mj.motions.loader import BUILT_IN, read_motion
from mpma_mj.motions.motion import Motion
from mpma_mj.motions.ymca import ymca

__all__ = ["BUILT_IN", "Motion", "read_motion", "ymca"]
