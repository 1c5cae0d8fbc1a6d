"""The command line as a user types it."""

import contextlib
import io
import logging
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import tomllib
import weakref
from collections.abc import Sequence
from pathlib import Path

import pytest

from mpma_mj import __version__, cli
from mpma_mj.cli import main
from mpma_mj.commands import COMMANDS, GROUPS
from mpma_mj.commands.imitate import Imitate
from mpma_mj.commands.study import RunStudy
from tests.conftest import Refused

TINY = ("--nodes", 5, "--modules", 2, "--repeats", 1, "--epochs", 1, "--no-video")
SMALL_COMPARISON = (
    *("--nodes", 5, "--modules", 2, "--epochs", 1, "--fine-tune", 1),
    *("--runs", 1, "--workers", 1, "--no-video"),
)
ROOT = Path(__file__).parent.parent
PICTURES = {"responsibility.png", "module_output.png", "trajectory.png"}


def mpma(*words: object, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run the command in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "mpma_mj.cli", *map(str, words)],
        capture_output=True,
        text=True,
        env=os.environ | environment,
        check=False,
    )


def test_a_command_that_is_not_there_is_one_line(refused: Refused) -> None:
    refused(["imitat"], "mpma: no command 'imitat'; did you mean mpma imitate?")
    refused(["--imitate"], "mpma: no command '--imitate'; did you mean mpma imitate?")
    refused(["dance"], "mpma: no command 'dance'; mpma alone lists all")


@pytest.mark.parametrize("words", [[], ["help"], ["--help"], ["-h"]])
def test_mpma_alone_lists_all_commands_by_group_with_an_example(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line for line in lines if line in GROUPS] == list(GROUPS)
    assert [line.split()[0] for line in lines if line.startswith("  ") and line[2] != " "] == list(
        COMMANDS
    )
    assert max(map(len, lines)) <= 88


@pytest.mark.parametrize(
    "example", [example for group in GROUPS.values() for _, example in group.values()]
)
def test_examples_are_understood(example: str) -> None:
    mpma, *words = example.split()
    assert mpma == "mpma"
    expected = RunStudy if words[0] == "study" else COMMANDS[words[0]]
    assert isinstance(cli._parse(words), expected)


def test_help_with_a_command_is_its_help(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["help", "play"])
    assert capsys.readouterr().out.startswith("usage: mpma play ")


def test_bash_completes_commands_and_options(tmp_path: Path) -> None:
    script = tmp_path / "mpma.bash"
    with pytest.raises(SystemExit):
        main(["--tyro-write-completion", "bash", str(script)])
    ask = (
        'source "$0"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _tyro_mpma; echo "${COMPREPLY[@]}"'
    )
    for words, completed in {
        "mpma im": "imitate",
        "mpma imitate --over": "--overwrite",
        "mpma play --ou": "--out",
    }.items():
        bash = ["bash", "-c", ask, str(script), *words.split()]
        result = subprocess.run(bash, capture_output=True, text=True, check=False)
        assert result.stdout.split() == completed.split(), result.stderr


@pytest.mark.parametrize("words", [[], ["klingon"], ["bash", "one", "more"]])
def test_completion_for_no_shell_is_one_line(words: list[str], refused: Refused) -> None:
    refused(["--tyro-print-completion", *words], "try: mpma --tyro-print-completion bash")


@pytest.mark.parametrize(
    ("stop", "code", "message"),
    [
        (MemoryError(), 1, "mpma: not enough memory"),
        (KeyboardInterrupt(), 130, "mpma: interrupted"),
        (signal.SIGTERM, 143, "mpma: interrupted"),
        (signal.SIGHUP, 129, "mpma: interrupted"),
    ],
)
def test_what_stops_a_run_from_outside_is_one_line(
    stop: BaseException | signal.Signals,
    code: int,
    message: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def stopped(self: Imitate) -> Path:
        if isinstance(stop, BaseException):
            raise stop
        signal.raise_signal(stop)
        return Path()

    monkeypatch.setattr(Imitate, "run", stopped)
    assert main(["imitate", "ymca"]) == code
    printed = capsys.readouterr().err
    assert printed.startswith(message)
    assert len(printed.splitlines()) == 1
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL


@pytest.mark.parametrize("error", [ImportError("no initialization"), TypeError("argument 1")])
def test_code_in_c_that_is_interrupted_is_one_line(
    error: Exception, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stopped(self: Imitate) -> Path:
        with contextlib.suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        raise error

    monkeypatch.setattr(Imitate, "run", stopped)
    assert main(["imitate", "ymca"]) == 130
    assert capsys.readouterr().err == "mpma: interrupted\n"

    def broken(self: Imitate) -> Path:
        raise ImportError("no such module")

    monkeypatch.setattr(Imitate, "run", broken)
    with pytest.raises(ImportError, match="no such module"):
        main(["imitate", "ymca"])


STOPPED_BY_AN_IMPORT = """
import runpy, signal, sys
class Stopper:
    def find_spec(self, name, path=None, target=None):
        if name == sys.argv[1]:
            signal.raise_signal(signal.Signals[sys.argv[2]])
sys.meta_path.insert(0, Stopper())
{start}
"""


@pytest.mark.parametrize(
    ("start", "module"),
    [
        ("from {}", "mpma_mj"),
        ("runpy.run_module('mpma_mj', run_name='__main__')", "mpma_mj.cli"),
    ],
)
@pytest.mark.parametrize(("name", "code"), [("SIGINT", 130), ("SIGTERM", 143)])
def test_a_signal_before_the_command_line_is_imported_is_one_line(
    start: str, module: str, name: str, code: int
) -> None:
    script = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["scripts"]["mpma"]
    start = start.format(script.replace(":", " import ") + "; main()")
    program = [sys.executable, "-c", STOPPED_BY_AN_IMPORT.format(start=start), module, name]
    result = subprocess.run(program, capture_output=True, check=False)
    assert (result.returncode, result.stderr) == (code, b"mpma: interrupted\n")


def ended_by(run: str) -> tuple[int, bytes]:
    """Return exit code and errors of a command line whose work is done by the function `run`."""
    code = f"import signal, sys, weakref\nfrom mpma_mj import cli\n{run}"
    code += "cli._run = run\nsys.exit(cli.main([]))\n"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    return result.returncode, result.stderr


def test_a_signal_in_code_from_text_leaves_the_exit_code() -> None:
    code = """
def run(words):
    exec("signal.raise_signal(signal.SIGTERM)", globals())
"""
    assert ended_by(code) == (143, b"mpma: interrupted\n")


def test_a_signal_in_a_callback_of_a_weak_reference_is_not_lost(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    class Thing:
        pass

    def stopped(self: Imitate) -> Path:
        thing = Thing()
        weakref.finalize(thing, signal.raise_signal, signal.SIGTERM)
        del thing
        time.sleep(30.0)
        raise AssertionError("the signal was lost")

    monkeypatch.setattr(Imitate, "run", stopped)
    assert main(["imitate", "ymca"]) == 143
    assert capsys.readouterr().err == "mpma: interrupted\n"


def test_a_signal_that_is_lost_at_the_end_changes_nothing() -> None:
    code = """
class Thing: pass
def run(words):
    thing = Thing()
    weakref.finalize(thing, signal.raise_signal, signal.SIGTERM)
    del thing
"""
    assert ended_by(code) == (0, b"")


def test_what_other_libraries_log_is_not_shown(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def logs(self: Imitate) -> None:
        logging.getLogger("other").warning("something")

    monkeypatch.setattr(Imitate, "run", logs)
    assert main(["imitate", "ymca"]) == 0
    assert capsys.readouterr().err == ""


def test_an_ignored_hangup_stays_ignored(monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(self: Imitate) -> None:
        signal.raise_signal(signal.SIGHUP)

    monkeypatch.setattr(Imitate, "run", stopped)
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does
    try:
        assert main(["imitate", "ymca"]) == 0
    finally:
        signal.signal(signal.SIGHUP, before)


def main_that_nobody_reads(words: Sequence[object], monkeypatch: pytest.MonkeyPatch) -> int:
    """Run the command with a closed pipe as its output; return its exit code."""
    reader, writer = os.pipe()
    os.close(reader)
    with io.TextIOWrapper(os.fdopen(writer, "wb", 0), write_through=True) as pipe:
        monkeypatch.setattr(sys, "stdout", pipe)
        return main([*map(str, words)])


@pytest.mark.parametrize("words", [["motion", "ymca"], ["imitate", "--help"], ["--version"]])
def test_output_that_nobody_reads_any_more_ends_the_command_quietly(
    words: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main_that_nobody_reads(words, monkeypatch) == 141
    assert capsys.readouterr().err == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no full device")
@pytest.mark.parametrize("words", [["motion", "ymca"], ["imitate", "--help"], ["--version"]])
def test_output_to_a_full_disk_is_one_line(words: list[str], tmp_path: Path) -> None:
    command = [sys.executable, "-m", "mpma_mj", *words]
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(
            command, stdout=full, stderr=subprocess.PIPE, cwd=tmp_path, check=False
        )
    told = b"mpma: standard output: No space left on device; let it go elsewhere\n"
    assert (ended.returncode, ended.stderr) == (1, told)


def test_the_process_also_ends_quietly(tmp_path: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "mpma_mj.cli", "imitate", "--help"]
    try:
        result = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, check=False)
    finally:
        os.close(writer)
    assert (result.returncode, result.stderr) == (141, b"")


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.strip() == f"mpma {__version__}"


def test_help_imports_neither_mujoco_nor_scipy() -> None:
    code = (
        "import sys; from mpma_mj import cli\n"
        "try: cli.main(['imitate', '--help'])\n"
        "except SystemExit: pass\n"
        "assert not {'mujoco', 'scipy', 'matplotlib'} & set(sys.modules)"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert result.returncode == 0, result.stderr


@pytest.mark.parametrize(
    "words", [["imitate", ""], ["evaluate", "run", "--out", ""], ["imitate", "--out="]]
)
def test_an_empty_argument_is_one_line_and_exit_2(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 2
    assert capsys.readouterr().err.endswith(
        "is an empty argument; give it a value, or leave it out\n"
    )


@pytest.mark.parametrize("command", COMMANDS)
def test_help_shows_no_empty_default_and_no_none(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main([command, "--help"])
    printed = capsys.readouterr().out
    assert "--help" in printed
    assert "(default: )" not in printed
    assert "None" not in printed
    assert "STR|PATH" not in printed
    assert not re.search(r"`\w+`", printed)


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["imitate", "ymca", "--random-start"], "training imitates whole episodes"),
        (["sweep", "--termination-distance=0.3"], "training imitates whole episodes"),
        (["compare", "--no-random-start"], "training imitates whole episodes"),
    ],
)
def test_an_option_that_a_command_would_refuse_is_not_listed(
    words: list[str], reason: str, capsys: pytest.CaptureFixture[str]
) -> None:
    option = next(word for word in words if word.startswith("--")).partition("=")[0]
    assert main(words) == 2
    option = option.replace("--no-", "--")
    message = f"mpma: {words[0]} has no option {option}; leave it out: {reason}"
    assert capsys.readouterr().err.startswith(message)
    with pytest.raises(SystemExit):
        main([words[0], "--help"])
    assert f"{option} " not in capsys.readouterr().out


def test_a_run_is_whole_on_a_terminal_that_lacks_its_characters(tmp_path: Path) -> None:
    plain = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    result = mpma("imitate", "ymca", *TINY, "--out", tmp_path / "run", **plain)
    assert result.returncode == 0, result.stderr
    assert "label ? dominant module: Y ? " in result.stdout
    assert {path.name for path in (tmp_path / "run" / "figures").iterdir()} == PICTURES


def terminal_of(encoding: str) -> io.TextIOWrapper:
    return io.TextIOWrapper(io.BytesIO(), encoding=encoding, write_through=True)


def shown_on(terminal: io.TextIOWrapper) -> str:
    assert isinstance(terminal.buffer, io.BytesIO)
    return terminal.buffer.getvalue().decode(terminal.encoding)


def test_tables_are_shown_on_a_terminal_that_lacks_their_characters(
    small_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = shutil.copytree(small_run, tmp_path / "run")
    terminal = terminal_of("ascii")
    monkeypatch.setattr(sys, "stdout", terminal)
    assert main(["analyse", str(run), "lesion", "--fine-tune", "0"]) == 0
    assert "largest ? at once" in shown_on(terminal)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_commands_help_is_shown_on_a_terminal_of_ascii(
    command: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal = terminal_of("ascii")
    monkeypatch.setattr(sys, "stdout", terminal)
    with pytest.raises(SystemExit) as ended:
        main([command, "--help"])
    assert ended.value.code == 0
    assert "usage: mpma" in shown_on(terminal)
    assert terminal.errors == "strict"  # as it was


def test_errors_name_files_that_a_terminal_cannot_show(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = terminal_of("ascii")
    monkeypatch.setattr(sys, "stderr", terminal)
    assert main(["imitate", "踊り\udcff.csv"]) == 2
    shown = r"\u8e0a\u308a\udcff.csv"
    assert shown_on(terminal) == f"mpma: {shown}: no such file; check the path\n"


@pytest.mark.parametrize(
    ("words", "files"),
    [
        (["imitate", "ymca", *TINY, "--out", "run"], ["run/figures/trajectory.png"]),
        (["motion", "ymca", "--out", "a.npz"], ["ymca-motion.png", "a.npz"]),
        (["analyse", "small"], ["small/modules.json", "small/figures/modules.png"]),
        (
            ["compare", "ymca", *SMALL_COMPARISON, "--out", "compared"],
            ["compared/transfer.png", "compared/episodes.png"],
        ),
    ],
)
def test_files_are_written_before_anything_is_printed(
    words: list[object],
    files: list[str],
    small_run: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    shutil.copytree(small_run, tmp_path / "small")
    monkeypatch.chdir(tmp_path)
    assert main_that_nobody_reads(words, monkeypatch) == 141
    for name in files:
        assert (tmp_path / name).exists(), name


REFUSED_EARLY = """
import sys
from mpma_mj.cli import main
folder, *commands = sys.argv[1:]
for command in commands:
    assert main([*command.split(), folder]) == 2
    heavy = {"mujoco", "dm_control", "scipy", "sklearn", "matplotlib"} & set(sys.modules)
    assert not heavy, (command, heavy)
"""
NEED_A_RUN = (
    *("evaluate", "analyse", "analyse lesion", "play"),
    *("imitate --resume", "imitate ymca --init"),
)


def test_a_folder_that_is_no_run_is_refused_before_anything_large_is_imported(
    tmp_path: Path,
) -> None:
    program = [sys.executable, "-c", REFUSED_EARLY, str(tmp_path), *NEED_A_RUN]
    result = subprocess.run(program, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    told = (
        f"mpma: {tmp_path}: is not a run (no readable config.json); expected a folder that mpma"
        " imitate wrote, such as runs/ymca\n"
    )
    assert result.stderr == told * len(NEED_A_RUN)
