"""System identification: the parameters of the arms' model from a robot's log."""

from mpma_mj.sysid.fit import identify
from mpma_mj.sysid.log import RobotLog, read_log, record, write_log
from mpma_mj.sysid.model_file import write_model
from mpma_mj.sysid.report import Identified

__all__ = [
    "Identified",
    "RobotLog",
    "identify",
    "read_log",
    "record",
    "write_log",
    "write_model",
]
