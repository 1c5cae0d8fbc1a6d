"""Echo state networks: banks of reservoirs and their readouts."""

from mpma_mj.esn.feature_replay import FeatureReplay
from mpma_mj.esn.precision import PRECISION, Features
from mpma_mj.esn.readout import ReadoutBank, Ridge
from mpma_mj.esn.reservoir import ReservoirBank

__all__ = ["PRECISION", "FeatureReplay", "Features", "ReadoutBank", "ReservoirBank", "Ridge"]
