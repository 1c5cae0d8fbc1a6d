"""Finding out the parameters of the arms' model from a log of what arms did."""

from mpma_mj.identification.identified import Identified, identify
from mpma_mj.identification.log import RobotLog, read_log, write_log
from mpma_mj.identification.model_file import write_model
from mpma_mj.identification.record import record

__all__ = [
    "Identified",
    "RobotLog",
    "identify",
    "read_log",
    "record",
    "write_log",
    "write_model",
]
