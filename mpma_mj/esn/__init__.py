"""Echo state networks: banks of reservoirs and their readouts."""

from mpma_mj.esn.bank import ReservoirBank
from mpma_mj.esn.precision import PRECISION, Features
from mpma_mj.esn.readout import ReadoutBank

__all__ = ["PRECISION", "Features", "ReadoutBank", "ReservoirBank"]
