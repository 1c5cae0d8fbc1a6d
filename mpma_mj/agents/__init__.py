"""Agents, which act and learn by observations alone.

Names are imported when they are used first, so that configs load without networks.
"""

import lazy_loader

<<<<<<< HEAD
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
=======
if TYPE_CHECKING:
    from mpma_mj.agents.adaptive import Adaptive as Adaptive
    from mpma_mj.agents.base import Agent as Agent
    from mpma_mj.agents.base import AgentSpec as AgentSpec
    from mpma_mj.agents.baselines import FeedbackOnly as FeedbackOnly
    from mpma_mj.agents.baselines import OpenLoop as OpenLoop
    from mpma_mj.agents.baselines import RandomAgent as RandomAgent
    from mpma_mj.agents.baselines import ResolvedRate as ResolvedRate
    from mpma_mj.agents.config import AdaptiveConfig as AdaptiveConfig
    from mpma_mj.agents.config import AgentConfig as AgentConfig
    from mpma_mj.agents.config import FeedbackOnlyConfig as FeedbackOnlyConfig
    from mpma_mj.agents.config import HAMMERConfig as HAMMERConfig
    from mpma_mj.agents.config import MOSAICConfig as MOSAICConfig
    from mpma_mj.agents.config import MPMAConfig as MPMAConfig
    from mpma_mj.agents.config import NetworkConfig as NetworkConfig
    from mpma_mj.agents.config import OpenLoopConfig as OpenLoopConfig
    from mpma_mj.agents.config import OracleConfig as OracleConfig
    from mpma_mj.agents.config import RandomConfig as RandomConfig
    from mpma_mj.agents.config import ResolvedRateConfig as ResolvedRateConfig
    from mpma_mj.agents.config import SingleConfig as SingleConfig
    from mpma_mj.agents.hammer import HAMMER as HAMMER
    from mpma_mj.agents.learning_rules import Epoch as Epoch
    from mpma_mj.agents.learning_rules import LearningRule as LearningRule
    from mpma_mj.agents.learning_rules import Readouts as Readouts
    from mpma_mj.agents.learning_rules import learning_rule as learning_rule
    from mpma_mj.agents.mosaic import MOSAIC as MOSAIC
    from mpma_mj.agents.mpma import MPMA as MPMA
    from mpma_mj.agents.mpma import Single as Single
    from mpma_mj.agents.oracle import Oracle as Oracle
    from mpma_mj.agents.registry import AGENTS as AGENTS
    from mpma_mj.agents.registry import agent_class as agent_class
    from mpma_mj.agents.signals import AgentSignals as AgentSignals
    from mpma_mj.agents.signals import ModuleSignals as ModuleSignals

_NAMES = {
    "adaptive": ("Adaptive",),
    "base": ("Agent", "AgentSpec"),
    "baselines": ("FeedbackOnly", "OpenLoop", "RandomAgent", "ResolvedRate"),
    "config": (
        "AdaptiveConfig",
        "AgentConfig",
        "FeedbackOnlyConfig",
        "HAMMERConfig",
        "MOSAICConfig",
        "MPMAConfig",
        "NetworkConfig",
        "OpenLoopConfig",
        "OracleConfig",
        "RandomConfig",
        "ResolvedRateConfig",
        "SingleConfig",
    ),
    "hammer": ("HAMMER",),
    "learning_rules": ("Epoch", "LearningRule", "Readouts", "learning_rule"),
    "mosaic": ("MOSAIC",),
    "mpma": ("MPMA", "Single"),
    "oracle": ("Oracle",),
    "registry": ("AGENTS", "agent_class"),
    "signals": ("AgentSignals", "ModuleSignals"),
}
_HOMES = {name: home for home, names in _NAMES.items() for name in names}

__all__ = list(_HOMES)


def __getattr__(name: str) -> Any:
    """Import a public name when it is used first, so that configs load without networks."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
>>>>>>> joint-tests
