import ast
import copy
import pickle
import re
import warnings
from pathlib import Path

import pytest

import mpma_mj
from mpma_mj.cli import main
from mpma_mj.errors import BadOptionError, MpmaError, RecordingWarning, one_line, placeholder
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.utils.text import as_flag

PACKAGE = Path(mpma_mj.__file__).parent
LIBRARY = (
    *("agents", "analysis", "envs", "esn", "evaluation", "experiments", "motions", "sysid"),
    *("training", "utils", "visualization"),
)


def test_an_error_names_options_in_the_language_of_its_reader() -> None:
    error = MpmaError("a gap of 0.4 s", remedy="bridge it with {max_gap=0.4}, or drop {start}")
    assert str(error) == "a gap of 0.4 s; bridge it with max_gap=0.4, or drop start"
    assert error.describe(as_flag) == "a gap of 0.4 s; bridge it with --max-gap 0.4, or drop --from"


def test_a_bad_option_is_data() -> None:
    error = BadOptionError(option="max_gap", value=-1, expected="0 or more", remedy="drop {repair}")
    assert (error.option, error.value, error.expected) == ("max_gap", -1, "0 or more")
    assert str(error) == "max_gap is -1; expected 0 or more; drop repair"
    assert error.describe(as_flag) == "--max-gap is -1; expected 0 or more; drop --repair"


def test_a_long_value_is_cut() -> None:
    error = BadOptionError(option="payload", value=[0.5] * 1000, expected="0 to 1000")
    assert len(str(error)) < 400
    assert str(error).endswith("…; expected 0 to 1000")


def test_braces_of_a_value_are_no_option() -> None:
    assert str(BadOptionError("weights are {left=3}")) == "weights are {left=3}"
    assert str(BadOptionError(option="map", value="{a=b}")) == "map is '{a=b}'"


@pytest.mark.parametrize("value", ['"left_elbow=A+B"', "{", "}", "{a=b}", "{{}}", "a}} or {b", ""])
def test_a_remedy_shows_any_value_as_it_is(value: str) -> None:
    error = MpmaError(
        "lost", remedy=f"take {placeholder('map', value)} or {placeholder('up', 'z')}"
    )
    assert str(error) == f"lost; take map={value} or up=z"
    assert error.describe(as_flag) == f"lost; take --map {value} or --up z"


def test_what_an_error_is_about_is_put_in_front_and_its_options_are_kept() -> None:
    error = BadOptionError(option="nodes", value=0, expected="1 or more", remedy="drop {nodes}")
    told = error.with_context("{payload} 3").with_context("mpma")
    assert type(told) is BadOptionError
    assert told.option == "nodes"
    assert told.describe(as_flag) == (
        "mpma: {payload} 3: --nodes is 0; expected 1 or more; drop --nodes"
    )
    assert str(error) == "nodes is 0; expected 1 or more; drop nodes"


def test_a_warning_names_options_in_the_language_of_its_reader() -> None:
    report = ImportReport()
    report.warn("it has no rate", remedy="{rate_in} gives one")
    assert report.warnings == ["it has no rate; rate_in gives one"]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        report.emit_warnings("{dance}.csv")
    (warning,) = (found.message for found in caught)
    assert isinstance(warning, RecordingWarning)
    assert str(warning) == "{dance}.csv: it has no rate; rate_in gives one"
    assert warning.describe(as_flag) == "{dance}.csv: it has no rate; --rate-in gives one"


def test_the_command_line_tells_warnings_with_its_options(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["motion", "ymca", "--to", "99"]) == 0
    assert "mpma: warning: ymca: ymca ends at 3.75 s; --to 99 is later than that" in (
        capsys.readouterr().err
    )


@pytest.mark.parametrize("copied", [copy.copy, lambda error: pickle.loads(pickle.dumps(error))])
def test_an_error_survives_the_way_from_a_worker(copied: object) -> None:
    error = BadOptionError(option="nodes", value=0, expected="1 or more", remedy="drop {nodes}")
    assert callable(copied)
    assert str(copied(error.with_context("here"))) == f"here: {error}"


@pytest.mark.parametrize("folder", LIBRARY)
def test_the_library_does_not_speak_the_command_line(folder: str) -> None:
    flags = []
    for path in (PACKAGE / folder).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                text = re.sub("`[^`]*`", "", node.value)  # another program's command is quoted
                flags += [f"{path.name}: {text}"] * bool(re.search(r"(?<!\w)--[a-z]", text))
    assert not flags


def test_a_range_is_written_as_it_is_typed_and_in_python_as_a_tuple() -> None:
    error = BadOptionError(option="switch_every", value=(3.0, 1.0), expected="two times")
    assert str(error) == "switch_every is (3.0, 1.0); expected two times"
    assert error.describe(as_flag) == "--switch-every is 3.0 1.0; expected two times"


def test_what_a_foreign_library_says_is_one_line() -> None:
    assert one_line(ValueError("two\nlines,\r\n  \x1b[31mred")) == "two lines, \\x1b[31mred"


def test_a_foreign_warning_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(_: object) -> None:
        warnings.warn("two\nlines", UserWarning, stacklevel=1)

    monkeypatch.setattr("mpma_mj.commands.motion.InspectMotion.run", run)
    assert main(["motion", "ymca"]) == 0
    assert capsys.readouterr().err == "mpma: warning: two lines\n"
