"""Motions of two arms that are imitated: built in, or read from recordings."""

from mpma_mj.motions.built_in import BUILT_IN
from mpma_mj.motions.export import export_motion
from mpma_mj.motions.loader import read_motion
from mpma_mj.motions.motion import Motion, save_motion
from mpma_mj.motions.synthetic import ymca

__all__ = ["BUILT_IN", "Motion", "export_motion", "read_motion", "save_motion", "ymca"]
