"""Configs of the built-in agents: fields, documentation and bounds, each in one place.

Only names and numbers, so that the command line can show them without loading any network.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, TypeAlias, get_args

from mpma_mj.errors import BadOptionError
from mpma_mj.options import ContextSignal, EfferenceCopy, Models, RuleName
from mpma_mj.utils.validation import Bounds, check_fields

if TYPE_CHECKING:
    from mpma_mj.agents.learning_rules import LearningRule

    Rule: TypeAlias = str | LearningRule
else:
    Rule = str  # all that a command line or a file can hold

__all__ = [
    "CONFIG_TYPES",
    "JOINTS",
    "POSTURE",
    "RULES",
    "RULE_MEMBERS",
    "AgentConfig",
    "FeedbackOnlyConfig",
    "GrowingConfig",
    "HAMMERConfig",
    "MOSAICConfig",
    "MPMAConfig",
    "NetworkConfig",
    "OpenLoopConfig",
    "RandomConfig",
    "SingleConfig",
]

JOINTS = 8
"""Length of an action."""

POSTURE = 12
"""Length of a posture."""

RULES = f"{', '.join(get_args(RuleName))}, or the path of a class, such as my_rules.py:MyRule"
"""What names a learning rule."""

RULE_MEMBERS = (
    *("fit", "partial_fit", "next_sigma"),
    *("forgetting", "first_sigma", "online"),
)
"""Methods and attributes of a learning rule; see `LearningRule`."""

_Modules = Annotated[int, Bounds(1, 1000)]
_Ridge = Annotated[float, Bounds(0.0, 1e6, above=True)]
_LearningRate = Annotated[float, Bounds(0.0, 2.0, above=True, below=True)]


@dataclass(frozen=True, kw_only=True)
class AgentConfig:
    """Config of an agent that has nothing to set; base of all others."""

    def __post_init__(self) -> None:
        """Check the fields against their bounds.

        Raises:
            BadOptionError: A value is of another type, or out of bounds.
        """
        check_fields(self)


@dataclass(frozen=True, kw_only=True)
class RandomConfig(AgentConfig):
    """Config of random actions, which have nothing to set."""


@dataclass(frozen=True, kw_only=True)
class OpenLoopConfig(AgentConfig):
    """Config of the open loop, which has nothing to set."""


@dataclass(frozen=True, kw_only=True)
class FeedbackOnlyConfig(AgentConfig):
    """Config of the feedback controller, which has nothing to set."""


@dataclass(frozen=True, kw_only=True)
class NetworkConfig(AgentConfig):
    """Config of echo state networks.

    Attributes:
        nodes: Neurons of each reservoir, N.
        proprioception: Whether inverse and forward models receive the joint angles too; the
            paper's do not. A posture has two solutions in joint angles, and the effect of a joint
            velocity depends on which is held: an arm that was raised through straight forward
            has turned over.
        spectral_radius: Spectral radius of the reservoirs; 0.1 in the paper.
        reservoir_noise: Noise level ν of the reservoirs; 0.2 in the paper.
        context_signal: What the agent receives as context: the motion's labels; or, to find out
            what they are good for, nothing, a constant, the labels in random order, or each
            stretch of a label in two halves.
    """

    nodes: Annotated[int, Bounds(1, 20000)] = 200
    proprioception: bool = True
    spectral_radius: Annotated[float, Bounds(0.0, 1.0, below=True)] = 0.1
    reservoir_noise: Annotated[float, Bounds(0.0, 1.0, below=True)] = 0.2
    context_signal: ContextSignal = "labels"

    @property
    def state_size(self) -> int:
        """Length of the proprioceptive state that models receive."""
        return POSTURE + (2 * JOINTS if self.proprioception else 0)


@dataclass(frozen=True, kw_only=True)
class SingleConfig(NetworkConfig):
    """Config of one pair of inverse and forward model.

    Attributes:
        rule: Learning rule: "weighted" is ours, "gated" the paper's; or the path of a class,
            such as my_rules.py:MyRule.
        efference_copy: Command that forward models receive: the total, or each module's own as in
            the paper's text.
        ridge: Ridge ρ of the readouts, per step; with 0.1 or more a motion continues without its
            demonstration (choice).
    """

    rule: Rule = "weighted"
    efference_copy: EfferenceCopy = "total"
    ridge: _Ridge = 1e-4

    def __post_init__(self) -> None:
        """Check the fields; a rule that is named by a path is imported by the agent only."""
        super().__post_init__()
        rule: object = self.rule
        if isinstance(rule, str):
            fits = rule in get_args(RuleName) or ":" in rule
        else:
            fits = all(hasattr(rule, name) for name in RULE_MEMBERS)
        if not fits or isinstance(rule, type):
            expected = f"{RULES}, or an instance of LearningRule"
            raise BadOptionError(option="rule", value=rule, expected=expected)


@dataclass(frozen=True, kw_only=True)
class MPMAConfig(SingleConfig):
    """Config of the Multiple Paired Models Architecture.

    Attributes:
        modules: Number of modules, M.
        responsibility_predictors: Whether priors are the responsibility predictors' output; if
            not, they are uniform.
        forward_gating: Whether responsibility depends on the forward models' prediction errors.
    """

    modules: _Modules = 4
    responsibility_predictors: bool = True
    forward_gating: bool = True
    models: Models = "posture"
    max_plants: Annotated[int, Bounds(1, 100)] = 5


@dataclass(frozen=True, kw_only=True)
class GrowingConfig(MPMAConfig):
    """Config of MPMA with recruitment of modules; `modules` is their largest number."""


@dataclass(frozen=True, kw_only=True)
class MOSAICConfig(NetworkConfig):
    """Config of MOSAIC.

    Attributes:
        modules: Number of modules, M.
        forward_rate: Learning rate η of the forward models (choice).
        inverse_rate: Learning rate η of the inverse models (choice).
        predictor_rate: Learning rate η of the responsibility predictors (choice).
        sigma: Width σ of the likelihood, in units of posture (choice).
    """

    modules: _Modules = 4
    forward_rate: _LearningRate = 0.2
    inverse_rate: _LearningRate = 0.2
    predictor_rate: _LearningRate = 0.1
    sigma: Annotated[float, Bounds(0.0, 1e3, above=True)] = 0.5


@dataclass(frozen=True, kw_only=True)
class HAMMERConfig(NetworkConfig):
    """Config of HAMMER, which has a pair for each label of the context.

    Attributes:
        ridge: Ridge ρ of the readouts, per step (choice).
    """

    ridge: _Ridge = 1e-4


CONFIG_TYPES: dict[str, type[AgentConfig]] = {
    "mpma": MPMAConfig,
    "growing": GrowingConfig,
    "mosaic": MOSAICConfig,
    "hammer": HAMMERConfig,
    "single": SingleConfig,
    "feedback_only": FeedbackOnlyConfig,
    "open_loop": OpenLoopConfig,
    "random": RandomConfig,
}
"""Classes of the built-in agents' configs by the agents' names, as in `registry.AGENTS`."""
