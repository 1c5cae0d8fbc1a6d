"""Small commands that write files, each with the commands that come before it."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["SCENARIOS", "TINY", "Scenario"]

TINY = "--nodes 4 --modules 2 --repeats 1"
_TRAIN = f"imitate ymca {TINY} --no-video"


class Scenario(NamedTuple):
    """A command that is killed.

    Attributes:
        words: Its words.
        before: Commands whose files it finds.
        needs: Package without which it cannot run.
    """

    words: str
    before: tuple[str, ...] = ()
    needs: str = "mpma_mj"


_RUN = (f"{_TRAIN} --out run",)

SCENARIOS = {
    "imitate": Scenario(f"{_TRAIN} --out run"),
    "imitate, plants": Scenario(
        f"{_TRAIN} --plants default payload=2 --epochs-per-plant 1 --epochs 3 --out run"
    ),
    "imitate --resume": Scenario(
        "imitate --resume run --epochs 30 --no-video", (f"{_TRAIN} --epochs 1 --out run",)
    ),
    "imitate --overwrite": Scenario(
        f"{_TRAIN} --overwrite --out run",
        (f"{_TRAIN} --seed 1 --epochs 2 --out run", "analyse run"),
    ),
    "imitate --init": Scenario(f"{_TRAIN} --init run --out next", _RUN),
    "sweep": Scenario(
        f"sweep ymca --grid nodes=3,4 {TINY} --epochs 2 --runs 2 --workers 1 --out s"
    ),
    "study": Scenario("study table1 --nodes 3 4 --epochs 2 --runs 1 --workers 1 --out s"),
    "evaluate": Scenario("evaluate run --disturbances payload --levels 1 2 --out e", _RUN),
    "compare": Scenario(
        f"compare ymca {TINY} --runs 1 --epochs 2 --fine-tune 1 --workers 1 --no-video --out c"
    ),
    "analyse modules": Scenario("analyse run", _RUN),
    "analyse lesion": Scenario("analyse run lesion --fine-tune 0", _RUN),
    "analyse free-running": Scenario("analyse run free-running", _RUN),
    "play --out": Scenario("play run --out joints.csv", _RUN),
    "motion --out": Scenario("motion ymca --out dance.npz --picture dance.png"),
    "record": Scenario("record run --episodes 1 --out data", _RUN, "minari"),
    "record --overwrite": Scenario(
        "record run --episodes 1 --overwrite --out data",
        (*_RUN, "record run --episodes 2 --out data"),
        "minari",
    ),
}
"""Commands by name."""
