from .base import Agent as Agent
from .base import AgentSpec as AgentSpec
from .baselines import (
    FeedbackOnly as FeedbackOnly,
)
from .baselines import (
    OpenLoop as OpenLoop,
)
from .baselines import (
    RandomAgent as RandomAgent,
)
from .config import (
    AgentConfig as AgentConfig,
)
from .config import (
    FeedbackOnlyConfig as FeedbackOnlyConfig,
)
from .config import (
    GrowingConfig as GrowingConfig,
)
from .config import (
    HAMMERConfig as HAMMERConfig,
)
from .config import (
    MOSAICConfig as MOSAICConfig,
)
from .config import (
    MPMAConfig as MPMAConfig,
)
from .config import (
    NetworkConfig as NetworkConfig,
)
from .config import (
    OpenLoopConfig as OpenLoopConfig,
)
from .config import (
    RandomConfig as RandomConfig,
)
from .config import (
    SingleConfig as SingleConfig,
)
from .growing import GrowingMPMA as GrowingMPMA
from .hammer import HAMMER as HAMMER
from .learning_rules import (
    Epoch as Epoch,
)
from .learning_rules import (
    LearningRule as LearningRule,
)
from .learning_rules import (
    Readouts as Readouts,
)
from .learning_rules import (
    learning_rule as learning_rule,
)
from .mosaic import MOSAIC as MOSAIC
from .mpma import MPMA as MPMA
from .mpma import Single as Single
from .registry import AGENTS as AGENTS
from .registry import agent_class as agent_class
from .signals import AgentSignals as AgentSignals
from .signals import ModuleSignals as ModuleSignals
