"""Echo state networks: banks of reservoirs and their readouts."""

from mpma_mj.esn.readout import ReadoutBank, Ridge
from mpma_mj.esn.reservoir import PRECISION, FeatureReplay, Features, ReservoirBank

__all__ = ["PRECISION", "FeatureReplay", "Features", "ReadoutBank", "ReservoirBank", "Ridge"]
