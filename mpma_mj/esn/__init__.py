"""Echo state networks: banks of reservoirs and their readouts."""

from mpma_mj.esn.bank import ReservoirBank
from mpma_mj.esn.precision import PRECISION, Features
from mpma_mj.esn.readout import ReadoutBank
from mpma_mj.esn.replay import Replay

__all__ = ["PRECISION", "Features", "ReadoutBank", "Replay", "ReservoirBank"]
