"""Finding out the parameters of the arms' model from a log of what arms did."""

from mpma_mj.sysid.identified import Identified, identify
from mpma_mj.sysid.log import RobotLog, read_log, write_log
from mpma_mj.sysid.model_file import write_model
from mpma_mj.sysid.record import record

__all__ = [
    "Identified",
    "RobotLog",
    "identify",
    "read_log",
    "record",
    "write_log",
    "write_model",
]
