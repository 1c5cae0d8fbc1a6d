"""Tables of the study `scaling`, and sentences on where more no longer helps."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import get_args

from mpma_mj.experiments.records import Record, converged, matching
from mpma_mj.experiments.scaling import Amount, Scaling, Size, Unit, Varying, labels
from mpma_mj.experiments.training import Column
from mpma_mj.utils.text import markdown_table

__all__ = ["TOLERANCE", "as_markdown", "fixed", "least_enough", "named", "saturation"]

TOLERANCE = 0.1  # of the best value; what is nearer counts as good (choice)

_COLUMNS = (
    Column("p_e, %", "p_e_percent", 2),
    Column("prediction error, %", "prediction_error_percent", 2),
    Column("feedback ratio", "feedback_ratio", 3),
    Column("epochs", "epochs", 1),
    Column("nmi of label and module", "nmi", 2),
    Column("modules used", "modules_used", 1),
    Column("entropy of λ in the whole (usage), 1 is all modules alike", "entropy.usage", 2),
    Column("entropy of λ at a time (sharing), 0 is one module alone", "entropy.sharing", 2),
)


def as_markdown(study: Scaling, records: Sequence[Record]) -> str:
    """Return a table for each measure, means over seeds, and where it saturates."""
    amounts = study.amounts

    def table(title: str, cell: Callable[[Amount, Size], str]) -> str:
        head = ["modules", "nodes", *(named([amount]) for amount in amounts)]
        rows = [
            [str(size.modules), str(size.nodes), *(cell(amount, size) for amount in amounts)]
            for size in study.sizes
        ]
        return f"**{title}**\n\n{markdown_table(head, rows)}"

    def mean(column: Column) -> Callable[[Amount, Size], str]:
        return lambda amount, size: _number(
            study.mean(records, amount, size, column.measure), column.digits
        )

    def count(amount: Amount, size: Size) -> str:
        return str(converged(matching(records, labels(amount, size))))

    return "\n\n".join(
        [
            "Means over seeds; columns are what is learned, rows are the sizes of the agent.",
            *(table(column.title, mean(column)) for column in _COLUMNS),
            table("runs that converged", count),
            "**Where it saturates**",
            f"Enough is the least number with which p_e is within {100 * TOLERANCE:.0f} % of the"
            " lowest that was reached.",
            "\n".join(f"- {sentence}" for sentence in saturation(study, records)),
        ]
    )


def saturation(study: Scaling, records: Sequence[Record]) -> list[str]:
    """Return in sentences from which size on more does not help, and the cost of more motion."""
    sentences = []
    for unit in get_args(Unit):
        own = [amount for amount in study.amounts if amount.unit == unit]
        sentences += _enough(study, unit, own, records)
        sentences.append(_most_used(study, unit, own, records))
        size = study.crossing
        found = (_number(study.mean(records, one, size, "p_e_percent"), 2) for one in own)
        sentences.append(
            f"More {unit}: p_e with {fixed('nodes', size)} and {fixed('modules', size)} is"
            f" {', '.join(found)} % for {named(own)}."
        )
    return sentences


def least_enough(found: Mapping[int, float]) -> int | None:
    """Return the least size whose value is within `TOLERANCE` of the best, the lowest.

    Args:
        found: Values by size; those that are NaN do not count.

    Returns:
        The size; None if there is no value.
    """
    known = {size: value for size, value in found.items() if math.isfinite(value)}
    if not known:
        return None
    most = min(known.values()) * (1.0 + TOLERANCE)
    return min(size for size, value in known.items() if value <= most)


def named(amounts: Sequence[Amount]) -> str:
    """Return in words how much is learned; all have the same unit."""
    numbers = ", ".join(f"{amount.number:g}" for amount in amounts)
    last = amounts[-1]
    return (
        f"{numbers} s" if last.unit == "seconds" else f"{numbers} {_noun('motions', last.number)}"
    )


def fixed(varying: Varying, size: Size) -> str:
    """Return in words the number that is the same all along a line of sizes."""
    other: Varying = "nodes" if varying == "modules" else "modules"
    number = getattr(size, other)
    return f"{number} {_noun(other, number)}"


def _enough(
    study: Scaling, unit: Unit, amounts: Sequence[Amount], records: Sequence[Record]
) -> list[str]:
    """Return how many modules and nodes are enough for p_e."""
    sentences = []
    for varying, line in study.lines.items():
        if len(line) < 2:
            continue
        groups: dict[str, list[Amount]] = {}
        for amount in amounts:
            found = {
                getattr(size, varying): study.mean(records, amount, size, "p_e_percent")
                for size in line
            }
            groups.setdefault(str(least_enough(found) or "–"), []).append(amount)
        listed = "; ".join(f"{least} for {named(group)}" for least, group in groups.items())
        sentences.append(f"More {unit}, {fixed(varying, line[0])}: enough {varying} are {listed}.")
    return sentences


def _most_used(
    study: Scaling, unit: Unit, amounts: Sequence[Amount], records: Sequence[Record]
) -> str:
    """Return how many modules are used at most."""
    most = []
    for amount in amounts:
        found = [
            study.mean(records, amount, size, "modules_used") for size in study.lines["modules"]
        ]
        most.append(max((value for value in found if math.isfinite(value)), default=math.nan))
    return (
        f"More {unit}: most modules used {', '.join(_number(value, 1) for value in most)} for"
        f" {named(amounts)}; {max(study.modules)} is the most there are."
    )


def _noun(plural: str, number: float) -> str:
    return plural.removesuffix("s") if number == 1 else plural


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "–"
