"""Sweeps on Ray: that an address answers soon or not at all, and a cluster that loses a node."""

import importlib.util
import os
import signal
import socket
import sys
import time
import types
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from mpma_mj.errors import BadOptionError, WorkerError
from mpma_mj.experiments import cluster
from mpma_mj.experiments.backend import open_backend
from mpma_mj.experiments.study import run_study
from mpma_mj.training.config import versions
from tests.experiments.runs import TINY_WORDS, environment, mpma, run_files, sweep_of
from tests.experiments.test_backend import Double

ROOT = Path(__file__).parents[2]

needs_ray = pytest.mark.skipif(importlib.util.find_spec("ray") is None, reason="needs ray")


@pytest.mark.parametrize("address", ["head", "head:", ":6379", "ray://head:10001", "head:6379/x"])
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(BadOptionError, match="expected HOST:PORT of a Ray cluster's head"):
        cluster._check_answers(address)


def test_a_port_where_nobody_listens_is_refused_at_once() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    for address in (f"127.0.0.1:{port}", "127.0.0.1:99999"):
        with pytest.raises(BadOptionError, match=f"address {address}: no Ray cluster answers"):
            cluster._check_answers(address)


@pytest.mark.parametrize(
    ("said", "shown"),
    [("", "nothing"), ("[2026-01-01 12:00:00 W 1 1] gcs.cc:2: No token", "No token")],
)
def test_an_attempt_that_hangs_is_ended(
    said: str, shown: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    number = tmp_path / "number"
    code = f"import os, sys, time; open({str(number)!r}, 'w').write(str(os.getpid()));"
    code += f" print({said!r}, file=sys.stderr, flush=True); time.sleep(1000)"
    monkeypatch.setattr(cluster, "_CONNECT", code)
    monkeypatch.setattr(cluster, "_PATIENCE", 1.0)
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"127.0.0.1:{server.getsockname()[1]}"
        with pytest.raises(BadOptionError, match=rf"answers \(within 1 s: {shown}\);"):
            cluster._check_answers(address)
    with pytest.raises(ProcessLookupError):
        os.kill(int(number.read_text()), 0)


def test_an_attempt_that_fails_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "_CONNECT", "raise SystemExit('a cluster of Ray 1.0')")
    with pytest.raises(BadOptionError, match=r"answers \(a cluster of Ray 1\.0\)"):
        cluster._check_answers("auto")


def test_an_attempt_that_succeeds_does_not_wait_until_it_has_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    slow = "import atexit, time\n\ndef init(**_):\n    atexit.register(time.sleep, 1000)\n"
    (tmp_path / "ray.py").write_text(slow)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    cluster._check_answers("auto")


def test_without_ray_the_command_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(BadOptionError, match=r"in a checkout, pip install -e '\.\[ray\]'"):
        open_backend("ray", 1, None)


def test_workers_of_other_versions_are_refused() -> None:
    assert cluster.do(Double(number=2), versions()) == 4
    with pytest.raises(WorkerError, match=r"has numpy .*, the command 0\.1; install the same"):
        cluster.do(Double(number=2), versions() | {"numpy": "0.1"})


TOKEN = str(uuid.uuid4())  # Ray reads it once for a process


@pytest.fixture
def own_clusters(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make clusters that nobody else can use and that find this checkout."""
    monkeypatch.setenv("RAY_AUTH_MODE", "token")
    monkeypatch.setenv("RAY_AUTH_TOKEN", TOKEN)
    monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "0")
    monkeypatch.setenv("PYTHONPATH", str(ROOT))


@pytest.fixture
def two_nodes(own_clusters: None) -> Iterator[Any]:
    """Yield a cluster of a head that does no work and two nodes with a worker each."""
    from ray.cluster_utils import Cluster

    nodes = Cluster(initialize_head=True, head_node_args={"num_cpus": 0})
    for _ in range(2):
        nodes.add_node(num_cpus=1)
    nodes.wait_for_nodes()
    yield nodes
    nodes.shutdown()


def busy_worker(node: Any) -> int:
    """Wait until a worker of a node is at work and return its process id."""
    raylet = node.all_processes["raylet"][0].process.pid
    children = Path(f"/proc/{raylet}/task/{raylet}/children")
    while True:
        for child in children.read_text().split():
            if Path(f"/proc/{child}/cmdline").read_bytes().startswith(b"ray::do"):
                return int(child)
        time.sleep(0.01)


def rows_without_attempts(folder: Path) -> list[list[str]]:
    """Return the rows of a sweep, whose last column is the number of attempts."""
    lines = (folder / "results.csv").read_text().splitlines()
    assert lines[0].endswith(",attempts")
    return [line.split(",")[:-1] for line in lines]


@needs_ray
@pytest.mark.slow
def test_a_node_that_dies_on_the_way_changes_no_result(tmp_path: Path, two_nodes: Any) -> None:
    out = tmp_path / "ray"
    grid = "nodes=300,301,302,303,304,305,306,307"  # of which each takes a while
    words = ("sweep", "--grid", grid, "--runs", 8, *TINY_WORDS[2:], "--out", out)
    command = mpma(*words, "--backend", "ray", "--address", two_nodes.address, cwd=tmp_path)
    while not run_files(out):
        assert command.poll() is None, command.communicate()
        time.sleep(0.01)
    node = two_nodes.worker_nodes.copy().pop()
    os.kill(busy_worker(node), signal.SIGKILL)  # before its node, which would let it end its work
    two_nodes.remove_node(node, allow_graceful=False)
    printed, errors = command.communicate(timeout=300)
    assert command.returncode == 0, errors
    assert "Traceback" not in errors
    assert printed.startswith("| nodes |")
    assert "were tried again, because their worker died." in printed
    here = tmp_path / "here"
    other = mpma(*words[:-1], here)
    assert other.communicate()[0].count("\n| 3") == 8
    assert rows_without_attempts(out) == rows_without_attempts(here)


@needs_ray
@pytest.mark.slow
def test_a_head_that_dies_is_one_line_and_the_command_goes_on(
    tmp_path: Path, two_nodes: Any
) -> None:
    words = ("sweep", "--grid", "nodes=300,301,302,303", "--runs", 8, *TINY_WORDS[2:])
    words += ("--out", tmp_path / "out", "--backend", "ray", "--address")
    command = mpma(*words, two_nodes.address, cwd=tmp_path)
    while not run_files(tmp_path / "out"):
        assert command.poll() is None, command.communicate()
        time.sleep(0.01)
    for name in ("gcs_server", "raylet"):
        os.kill(two_nodes.head_node.all_processes[name][0].process.pid, signal.SIGKILL)
    printed, errors = command.communicate(timeout=300)
    assert (command.returncode, printed) == (1, "")
    assert errors.splitlines()[-1].startswith("mpma: the head of the Ray cluster, ")
    assert "GCS" not in errors  # Ray's own log
    done = len(run_files(tmp_path / "out"))
    again = type(two_nodes)(initialize_head=True, head_node_args={"num_cpus": 1})
    try:
        printed, errors = mpma(*words, again.address, cwd=tmp_path).communicate(timeout=300)
    finally:
        again.shutdown()
    assert printed.count("\n| 30") == 4, errors
    assert f"resuming: {done} of 32 runs are done" in errors


@needs_ray
@pytest.mark.slow
@pytest.mark.usefixtures("own_clusters")
def test_a_node_without_the_package_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ghost = types.ModuleType("ghost")
    exec("def do(work, versions): ...", vars(ghost))
    monkeypatch.setitem(sys.modules, "ghost", ghost)
    ghost.do.__module__ = "ghost"
    monkeypatch.setattr(cluster, "do", ghost.do)
    with pytest.raises(WorkerError, match="a node of the cluster cannot import mpma_mj"):
        run_study(sweep_of(), tmp_path / "out", 1, backend="ray")


@needs_ray
@pytest.mark.slow
@pytest.mark.usefixtures("own_clusters")
def test_a_cluster_of_its_own_gives_the_same_results(tmp_path: Path) -> None:
    study = sweep_of("nodes=5,6", runs=3)
    tables = [
        run_study(study, tmp_path / name, 2, backend=name)  # type: ignore[arg-type]
        for name in ("ray", "processes")
    ]
    assert tables[0] == tables[1]
    assert rows_without_attempts(tmp_path / "ray") == rows_without_attempts(tmp_path / "processes")


@needs_ray
@pytest.mark.slow
def test_something_else_that_listens_is_given_up_within_seconds(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"127.0.0.1:{server.getsockname()[1]}"
        words = ("sweep", "--runs", 1, *TINY_WORDS, "--backend", "ray", "--address", address)
        command = mpma(*words, "--out", tmp_path / "new", env=environment(PYTHONPATH=str(ROOT)))
        printed, errors = command.communicate(timeout=60)
    assert command.returncode == 2
    assert errors.splitlines()[-1].startswith(f"mpma: address {address}: no Ray cluster answers")
    assert len(errors.splitlines()) == 1
    assert printed == ""
    assert not (tmp_path / "new").exists()
