"""Record of what runs and environments compute, to the bit, and comparison of two records.

    python benchmarks/record_behaviour.py record before.json --recording dance.tsv
    python benchmarks/record_behaviour.py record before.json --recordings DIR
    python benchmarks/record_behaviour.py compare before.json after.json

A renovation has to leave a record as it was. Names that changed since the first record are in
`RENAMED`, so that a new record speaks with the old names. Records of two machines differ.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
import tempfile
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

import mpma_mj
from mpma_mj.envs.load import arm_limits
from mpma_mj.errors import MpmaError
from mpma_mj.motions.built_in import BUILT_IN
from mpma_mj.motions.feasibility import demand_lines
from mpma_mj.motions.loader import import_motion
from mpma_mj.motions.options import ReadingOptions
from mpma_mj.training import run as runs
from mpma_mj.training.config import RunConfig
from mpma_mj.training.dataset import read_motions
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.training.trainer import train_batch
from mpma_mj.utils.data_files import read_arrays

Record = dict[str, str]

RENAMED: dict[str, str] = {
    "lookahead": "future",
    "best_epoch": "kept_epoch",
    "motions": "movements",
}
"""Names of the first record by today's: parts between slashes of a record's keys."""

SEEDS = (0, 1, 2)
ARMS = ("physics", "kinematic")
PAPER: dict[str, Any] = {"models": "posture", "rule": "gated"}
AGENTS: dict[str, dict[str, Any]] = {
    "weighted": {"agent": "mpma"},
    "gated": {"agent": "mpma"} | PAPER,
    "mosaic": {"agent": "mosaic"},
    "hammer": {"agent": "hammer"},
    "mosaic, posture": {"agent": "mosaic", "models": "posture"},
    "hammer, posture": {"agent": "hammer", "models": "posture"},
    "single": {"agent": "single"},
    "adaptive": {"agent": "adaptive"},
    "oracle": {"agent": "oracle"},
}
ABLATIONS: dict[str, dict[str, Any]] = {
    "no predictors": {"responsibility_predictors": False},
    "no forward gating": {"forward_gating": False},
    "history": {"history": True},
    "no temperature": {"temperature": 0.0},
    "own command": PAPER | {"efference_copy": "module"},
    "no proprioception": PAPER | {"proprioception": False},
    "ridge": {"ridge": 0.1},
    "plants": {"plants": [{}, {"actuator_gain": 0.6}], "epochs_per_plant": 4},
}
ABLATIONS |= {
    f"hears {name}": {"context_signal": name}
    for name in ("nothing", "constant", "shuffled", "halves")
}
NODES, EPOCHS, MODULES = 30, 25, 3

ENVIRONMENTS: dict[str, dict[str, Any]] = {
    "physics": {"arms": "physics"},
    "kinematic": {"arms": "kinematic"},
    "hard": {
        "payload": 1.0,
        "actuator_strength": 0.5,
        "latency": 2,
        "observation_noise": 0.02,
        "perturbation": (1.0, 30.0),
        "collisions": True,
    },
    "eased": {
        "gravity_compensation": True,
        "random_start": True,
        "termination_distance": 0.4,
        "reward_weights": {"left_upper_arm": 3.0},
        "lookahead": 4,
        "phase": True,
    },
    "locked": {
        "locked_joint": "left_elbow",
        "reference_noise": 0.0,
        "repeats": 2,
        "control_timestep": 0.04,
    },
    "plants": {"plants": [{}, {"payload": 3.0, "damping": 2.0}], "switch_every": (0.5, 1.5)},
}

READINGS: dict[str, dict[str, Any]] = {
    "default": {},
    "50 Hz": {"rate": 50.0, "cutoff": 6.0, "segments": 3},
    "given": {"rate_in": 60.0, "unit": "mm", "up": "z", "tempo": 0.7, "loop": True},
    "mended": {"repair": True, "longest": True, "max_gap": 1.0, "context": "changes"},
    "events": {"context": "events", "start": 0.1, "end": 1.5},
}
"""Ways in which each recording is read."""


def main() -> int:
    """Record or compare; return 1 where records differ."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    verbs = parser.add_subparsers(dest="verb", required=True)
    recording = verbs.add_parser("record")
    recording.add_argument("out", type=Path)
    recording.add_argument("--recording", help="a recording that is imitated besides ymca")
    recording.add_argument("--recordings", type=Path, help="read files below a folder, run none")
    recording.add_argument("--quick", action="store_true", help="one seed, physics arms, ymca")
    comparing = verbs.add_parser("compare")
    comparing.add_argument("before", type=Path)
    comparing.add_argument("after", type=Path)
    given = parser.parse_args()
    if given.verb == "compare":
        return compare(_read(given.before), _read(given.after))
    record: Record = {}
    found = (
        entries(given.recording, quick=given.quick)
        if given.recordings is None
        else reading_entries(given.recordings)
    )
    for key, value in found:
        record[_old(key)] = value
    given.out.write_text(json.dumps(record, indent=0) + "\n", encoding="utf-8")
    return 0


def compare(before: Record, after: Record) -> int:
    """Print the entries that differ and how many are in one record alone; return 1 for either."""
    both = [key for key in before if key in after]
    differing = [key for key in both if before[key] != after[key]]
    for key in differing:
        print(f"{key}: {before[key]} -> {after[key]}")
    print(f"{len(differing)} of {len(both)} entries differ")
    print(f"{len(before) - len(both)} are missing, {len(after) - len(both)} are new")
    return 0 if not differing and len(before) == len(both) == len(after) else 1


def entries(recording: str | None, *, quick: bool) -> Iterator[tuple[str, str]]:
    """Yield all entries of a record: their keys and their values."""
    motions = ["ymca"] if recording is None or quick else ["ymca", recording]
    seeds, kinds = (SEEDS[:1], ARMS[:1]) if quick else (SEEDS, ARMS)
    for number, motion in enumerate(motions):
        name = "recording" if number else motion
        for arms in kinds:
            for title, options in AGENTS.items():
                _say(f"{name}, {arms}: {title}")
                yield from run_entries(f"{name}/{arms}/{title}", motion, arms, options, seeds)
    for title, options in ABLATIONS.items():
        _say(f"ablation: {title}")
        yield from run_entries(f"ablation/{title}", "ymca", "physics", options, SEEDS[:1])
    for title, options in ENVIRONMENTS.items():
        _say(f"environment: {title}")
        yield from environment_entries(f"environment/{title}", options)


def run_entries(
    key: str, motion: str, arms: Any, options: dict[str, Any], seeds: tuple[int, ...]
) -> Iterator[tuple[str, str]]:
    """Yield what runs came to: each alone and in a folder, and all in one batch."""
    configs = [
        RunConfig.of(motion, arms=arms, nodes=NODES, modules=MODULES, seed=seed, **options)
        for seed in seeds
    ]
    for config in configs:
        with tempfile.TemporaryDirectory() as folder:
            run = RunFolder(Path(folder) / "run")
            runs.train(config, EPOCHS, folder=run)
            summary = json.loads((run.path / "summary.json").read_text("utf-8"))
            yield from _numbers(f"{key}/{config.seed}/summary", summary)
            for file in ("trace", "checkpoint/best"):
                kind = file.split("/")[0]
                arrays, _ = read_arrays(run.path / f"{file}.npz", kind)
                for name, array in arrays.items():
                    yield f"{key}/{config.seed}/{kind}/{name}", _hash(array)
    for config, summary in zip(
        configs, train_batch(configs, read_motions(configs[0]), EPOCHS), strict=True
    ):
        yield from _numbers(f"{key}/batch {config.seed}/summary", summary)


def environment_entries(key: str, options: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the observations and rewards of episodes behind each interface."""
    actions = np.random.default_rng(0).uniform(-1.2, 1.2, (400, 3, 8))
    env = mpma_mj.load("ymca", seed=5, **options)
    steps = [env.reset(), *(env.step(action) for action in actions[:, 0])]
    reward = np.array([step.reward for step in steps], float)
    yield from _episode(f"{key}/load", [step.observation for step in steps], reward)
    envs = mpma_mj.make_vec(3, "ymca", seed=5, **options)
    outcomes = [(envs.reset()[0], np.zeros(3)), *(envs.step(action)[:2] for action in actions)]
    yield from _episode(
        f"{key}/make_vec", [seen for seen, _ in outcomes], np.stack([r for _, r in outcomes])
    )
    envs.close()
    for kind in ("", "Flat"):
        name = f"mpma_mj:TwoArmImitation{kind}-v0"
        alone = gymnasium.make(name, motion="ymca", seed=5, **options)
        seen, rewards = [alone.reset()[0]], []
        for action in actions[:, 0]:
            observation, own, terminated, truncated, _ = alone.step(action)
            seen.append(observation)
            rewards.append(float(own))
            if terminated or truncated:
                seen.append(alone.reset()[0])
        yield from _episode(f"{key}/gymnasium{kind}", seen, np.array(rewards))


def reading_entries(folder: Path) -> Iterator[tuple[str, str]]:
    """Yield what reading comes to for built-in motions and every file below a folder."""
    limits = arm_limits("physics")
    sources = [(name, name) for name in BUILT_IN]
    paths = sorted(path for path in folder.rglob("*") if path.is_file() and not path.is_symlink())
    sources += [(f"reading:{path.relative_to(folder)}", str(path)) for path in paths]
    for key, source in sources:
        for title, options in READINGS.items():
            rate = {"rate": options["rate"]} if "rate" in options else {}
            others = {name: value for name, value in options.items() if name != "rate"}
            try:
                with warnings.catch_warnings(record=True) as caught:
                    warnings.simplefilter("always")
                    motion = mpma_mj.read_motion(source, **options)
                same, facts = import_motion(source, ReadingOptions(**others), **rate)
            except MpmaError as error:
                message = str(error).replace(str(folder), "")
                yield f"{key}/{title}/refusal", f"{type(error).__name__}: {message}"
                continue
            for name in ("posture", "context"):
                yield f"{key}/{title}/{name}", _hash(getattr(motion, name))
            for name in ("labels", "rate", "name", "source", "tempo"):
                yield f"{key}/{title}/{name}", repr(getattr(motion, name))
            messages = [str(warning.message) for warning in caught]
            report = [*facts.lines(same), *demand_lines(same, limits)]
            for name, lines in (("warnings", messages), ("report", report)):
                yield f"{key}/{title}/{name}", "\n".join(lines).replace(str(folder), "")


def _episode(
    key: str, observations: list[Any], rewards: NDArray[np.float64]
) -> Iterator[tuple[str, str]]:
    yield f"{key}/reward", _hash(rewards)
    if isinstance(observations[0], Mapping):
        for name in observations[0]:
            yield f"{key}/{name}", _hash(np.stack([seen[name] for seen in observations]))
    else:
        yield f"{key}/observation", _hash(np.stack(observations))


def _numbers(key: str, content: Any) -> Iterator[tuple[str, str]]:
    """Yield every number below a key, exactly."""
    if isinstance(content, Mapping):
        for name, value in content.items():
            yield from _numbers(f"{key}/{name}", value)
    elif isinstance(content, list | tuple):
        for number, value in enumerate(content):
            yield from _numbers(f"{key}/{number}", value)
    elif not isinstance(content, str):
        yield key, repr(content.item() if isinstance(content, np.generic) else content)


def _hash(array: NDArray[Any]) -> str:
    """Return type, shape and digest of an array."""
    digest = hashlib.sha256(np.ascontiguousarray(array).tobytes()).hexdigest()
    return f"{array.dtype} {array.shape} {digest[:24]}"


def _old(key: str) -> str:
    return "/".join(RENAMED.get(part, part) for part in key.split("/"))


def _read(path: Path) -> Record:
    record: Record = json.loads(path.read_text("utf-8"))
    return record


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
