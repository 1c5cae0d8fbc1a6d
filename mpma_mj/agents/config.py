"""Configs of agents with networks, and of all built-in agents by name.

Fields, documentation and bounds, each in one place; only names and numbers, so that the command
line can show them without loading any network.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Annotated, TypeAlias, get_args

from mpma_mj.agents.basic_config import (
    AgentConfig,
    BCConfig,
    DAggerConfig,
    DMPConfig,
    FeedbackOnlyConfig,
    OpenLoopConfig,
    ProMPConfig,
    RandomConfig,
    ResolvedRateConfig,
)
from mpma_mj.errors import BadOptionError
from mpma_mj.options import ContextSignal, EfferenceCopy, Models, RuleName
from mpma_mj.utils.validation import Bounds

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
    "AdaptiveConfig",
    "AgentConfig",
    "BCConfig",
    "DAggerConfig",
    "DMPConfig",
    "FeedbackOnlyConfig",
    "HAMMERConfig",
    "MOSAICConfig",
    "MPMAConfig",
    "NetworkConfig",
    "OpenLoopConfig",
    "OracleConfig",
    "PairedConfig",
    "ProMPConfig",
    "RandomConfig",
    "ResolvedRateConfig",
    "SingleConfig",
    "check_models",
]

JOINTS = 8
"""Length of an action."""

POSTURE = 12
"""Length of a posture."""

RULES = f"{', '.join(get_args(RuleName))}, or the path of a class, such as my_rules.py:MyRule"
"""What names a learning rule."""

RULE_MEMBERS = (
    *("fit", "partial_fit"),
    *("models", "forgetting", "sigma", "online", "immediate"),
)
"""Methods and attributes of a learning rule; see `LearningRule`."""

_BUILT_IN_MODELS = {"weighted": "joint", "gated": "posture"}
_OWN_OPTIONS = {
    "joint": (
        *("history", "inverse_ridge", "max_latency", "state_estimate"),
        *("max_plants", "temperature", "novelty", "switching_probability"),
    ),
    "posture": ("proprioception", "efference_copy"),
}

_Modules = Annotated[int, Bounds(1, 1000)]
_Ridge = Annotated[float, Bounds(0.0, 1e6, above=True)]
_LearningRate = Annotated[float, Bounds(0.0, 2.0, above=True, below=True)]


@dataclass(frozen=True, kw_only=True)
class NetworkConfig(AgentConfig):
    """Config of echo state networks.

    Attributes:
        nodes: Neurons of each reservoir, N.
        spectral_radius: Spectral radius of the reservoirs; 0.1 in the paper.
        reservoir_noise: Noise level ν of the reservoirs; 0.2 in the paper.
        context_signal: What the agent receives as context: the motion's labels; or, to measure
            their effect, nothing, a constant, the labels in random order, or each
            stretch of a label in two halves.
    """

    nodes: Annotated[int, Bounds(1, 20000)] = 50
    spectral_radius: Annotated[float, Bounds(0.0, 1.0, below=True)] = 0.1
    reservoir_noise: Annotated[float, Bounds(0.0, 1.0, below=True)] = 0.2
    context_signal: ContextSignal = "labels"


@dataclass(frozen=True, kw_only=True)
class PairedConfig(NetworkConfig):
    """Config of pairs of inverse and forward model.

    Attributes:
        models: Space of the models: "joint" models are ours, "posture" models the paper's.
        history: Whether joint models receive the last move and the last action, too.
        proprioception: Whether posture models receive the joint angles too; the paper's do
            not. A posture has two solutions in joint angles, and the effect of a joint
            velocity depends on which is held: an arm that was raised through straight forward
            has turned over.
    """

    models: Models = "joint"
    history: bool = False
    proprioception: bool = True

    def __post_init__(self) -> None:
        """Check the fields.

        Raises:
            BadOptionError: A value is out of bounds, or belongs to models of the other space.
        """
        super().__post_init__()
        other = "posture" if self.models == "joint" else "joint"
        for field in fields(self):
            if field.name in _OWN_OPTIONS[other] and getattr(self, field.name) != field.default:
                raise BadOptionError(
                    option=field.name,
                    value=getattr(self, field.name),
                    expected=f"the default, as {self.models} models do not use it",
                    remedy=f"leave {{{field.name}}} out, or choose {{models={other}}}",
                )


@dataclass(frozen=True, kw_only=True)
class SingleConfig(PairedConfig):
    """Config of one pair of inverse and forward model.

    Attributes:
        nodes: Neurons of each reservoir, N; as many as four modules have (choice).
        rule: Learning rule: "weighted" for joint models is ours, "gated" for posture models the
            paper's; or the path of a class, such as my_rules.py:MyRule.
        inverse_ridge: Ridge of joint inverse models, as a share of each feature's own second moment
            (choice).
        max_latency: Largest latency that joint models compensate, control steps; 0 for none.
        state_estimate: Whether observation and prediction share the state that joint models
            receive, against noise on the observations.
        ridge: Ridge ρ of all other readouts, per step; with 0.1 or more a motion of posture models
            continues without its demonstration (choice).
        efference_copy: Command that posture forward models receive: the total, or each module's own
            as in the paper's text.
    """

    nodes: Annotated[int, Bounds(1, 20000)] = 200
    rule: Rule = "weighted"
    inverse_ridge: _Ridge = 0.03
    max_latency: Annotated[int, Bounds(0, 100)] = 5
    state_estimate: bool = False
    ridge: _Ridge = 1e-4
    efference_copy: EfferenceCopy = "total"

    def __post_init__(self) -> None:
        """Check the fields; a rule that is named by a path is imported by the agent only.

        Raises:
            BadOptionError: A value is out of bounds, or does not fit the models.
        """
        super().__post_init__()
        rule: object = self.rule
        if isinstance(rule, str):
            fits = rule in get_args(RuleName) or ":" in rule
        else:
            fits = all(hasattr(rule, name) for name in RULE_MEMBERS)
        if not fits or isinstance(rule, type):
            expected = f"{RULES}, or an instance of LearningRule"
            raise BadOptionError(option="rule", value=rule, expected=expected)
        needed = (
            _BUILT_IN_MODELS.get(rule) if isinstance(rule, str) else getattr(rule, "models", "")
        )
        if needed:
            check_models(rule, needed, self.models)

    @property
    def compensates_latency(self) -> bool:
        """Whether the models are joint models, which predict the effect of commands under way."""
        return self.models == "joint"


def check_models(rule: object, needed: str, models: str) -> None:
    """Refuse a learning rule that is made for other models.

    Args:
        rule: Name of the rule, or the rule.
        needed: Space of the models that it is made for.
        models: Space of the agent's models.

    Raises:
        BadOptionError: They differ.
    """
    if needed != models:
        name = rule if isinstance(rule, str) else type(rule).__name__
        fitting = next(rule for rule, space in _BUILT_IN_MODELS.items() if space == models)
        remedy = f"choose {{models={needed}}}, or {{rule={fitting}}}"
        raise BadOptionError(
            option="rule",
            value=name,
            expected=f"a rule for {models} models",
            remedy=f"{name} is for {needed} models: {remedy}",
        )


@dataclass(frozen=True, kw_only=True)
class MPMAConfig(SingleConfig):
    """Config of the Multiple Paired Models Architecture.

    Attributes:
        nodes: Neurons of each reservoir, N.
        modules: Number of modules, M; of joint models, for each plant.
        max_plants: Largest number of plants that joint models distinguish.
        temperature: Exponent τ of the modules' likelihood inside a plant: at 0 the context alone
            divides the motion, at 1 prediction noise would (choice).
        novelty: Novelty above which a plant is new; about 1 where a plant model is right (choice).
        switching_probability: Probability of a switch of plants, a step (choice).
        responsibility_predictors: Whether priors are the responsibility predictors' output; if
            not, they are uniform.
        forward_gating: Whether responsibility depends on prediction errors.
    """

    nodes: Annotated[int, Bounds(1, 20000)] = 50
    modules: _Modules = 4
    max_plants: Annotated[int, Bounds(1, 100)] = 5
    temperature: Annotated[float, Bounds(0.0, 1.0)] = 0.1
    novelty: Annotated[float, Bounds(1.0, 1e3, above=True)] = 3.0
    switching_probability: Annotated[float, Bounds(0.0, 0.5, above=True)] = 0.03
    responsibility_predictors: bool = True
    forward_gating: bool = True


@dataclass(frozen=True, kw_only=True)
class OracleConfig(MPMAConfig):
    """Config of MPMA that observes which plant is on."""


@dataclass(frozen=True, kw_only=True)
class AdaptiveConfig(NetworkConfig):
    """Config of one inverse model that adapts at every step.

    Attributes:
        forgetting: Forgetting μ, a step: it remembers about 1 / (1 - μ) steps (choice).
        inverse_ridge: Ridge, as a share of each feature's own second moment (choice).
    """

    forgetting: Annotated[float, Bounds(0.5, 1.0, below=True)] = 0.98
    inverse_ridge: _Ridge = 0.03


@dataclass(frozen=True, kw_only=True)
class MOSAICConfig(PairedConfig):
    """Config of MOSAIC.

    Attributes:
        modules: Number of modules, M.
        forward_rate: Learning rate η of the forward models (choice).
        inverse_rate: Learning rate η of the inverse models; 0.02 of joint models and 0.2 of posture
            models if not given (choice).
        predictor_rate: Learning rate η of the responsibility predictors (choice).
        sigma: Width σ of the likelihood, in units of posture (choice).
    """

    modules: _Modules = 4
    forward_rate: _LearningRate = 0.2
    inverse_rate: _LearningRate | None = None
    predictor_rate: _LearningRate = 0.1
    sigma: Annotated[float, Bounds(0.0, 1e3, above=True)] = 0.5


@dataclass(frozen=True, kw_only=True)
class HAMMERConfig(PairedConfig):
    """Config of HAMMER, which has a pair for each label of the context.

    Attributes:
        inverse_ridge: Ridge of joint inverse models, as a share of each feature's own second moment
            (choice).
        ridge: Ridge ρ of all other readouts, per step (choice).
    """

    inverse_ridge: _Ridge = 0.03
    ridge: _Ridge = 1e-4


CONFIG_TYPES: dict[str, type[AgentConfig]] = {
    "mpma": MPMAConfig,
    "mosaic": MOSAICConfig,
    "hammer": HAMMERConfig,
    "single": SingleConfig,
    "adaptive": AdaptiveConfig,
    "oracle": OracleConfig,
    "bc": BCConfig,
    "dagger": DAggerConfig,
    "promp": ProMPConfig,
    "dmp": DMPConfig,
    "resolved_rate": ResolvedRateConfig,
    "feedback_only": FeedbackOnlyConfig,
    "open_loop": OpenLoopConfig,
    "random": RandomConfig,
}
"""Classes of the built-in agents' configs by the agents' names, as in `registry.AGENTS`."""
