"""Names that no font, formula or terminal likes: a dance by any name is danced to the end."""

import json
import os
import shutil
import subprocess
import warnings
from collections.abc import Callable
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text

from mpma_mj.cli import main
from mpma_mj.errors import MpmaError
from mpma_mj.motions import Motion, read_motion, ymca
from mpma_mj.motions.motion import load_motion, save_motion
from mpma_mj.utils.atomic_files import write_text
from mpma_mj.utils.data_files import read_arrays, write_arrays
from mpma_mj.utils.progress import show_range, show_runs
from mpma_mj.utils.text import printable, shell_word
from mpma_mj.visualization.figure_file import figure_file
from mpma_mj.visualization.responsibility_strip import Strip
from tests.conftest import Refused, dancer, markers_of, with_trunk
from tests.test_cli import mpma

WriteTsv = Callable[..., Path]

NOT_UTF8 = "dance\udcff"  # as Python has the name b"dance\xff"
FORMULA = "take$1_$2"
NAMES = (FORMULA, r"$\bad$", NOT_UTF8, "two\nlines", "red\x1b[31m", "turn\u202e", "踊り🕺")
SHOWN = (
    *(FORMULA, r"$\bad$", r"dance\udcff", r"two\nlines", r"red\x1b[31m", r"turn\u202e", "踊り🕺"),
)
TINY = ("--nodes", 5, "--modules", 2, "--repeats", 1, "--epochs", 2, "--no-video")


@pytest.mark.parametrize(("name", "shown"), [*zip(NAMES, SHOWN, strict=True)])
def test_a_name_is_shown_as_it_is_but_for_what_is_no_text(name: str, shown: str) -> None:
    assert printable(name) == shown
    assert printable(shown) == shown


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no Bash")
@pytest.mark.parametrize("name", [*NAMES, "co nv", "-dash", "-\n'\\x", "it's", "a\u2028b", "\x1bf"])
def test_a_shell_reads_the_name_of_a_hint_as_it_is(name: str) -> None:
    word = shell_word(Path(name))
    assert printable(word) == word
    assert not word.startswith("-")
    typed = f"printf %s {word}"
    read = subprocess.run(["bash", "-c", typed], capture_output=True, check=True).stdout
    assert read == os.fsencode(f"./{name}" if name.startswith("-") else name)


@pytest.mark.parametrize("name", NAMES)
def test_a_motion_has_names_that_can_be_shown(name: str, tmp_path: Path) -> None:
    one = ymca()
    motion = Motion(one.posture, one.context, (name, *"MCA"), one.rate, name, f"file {name}")
    shown = printable(name)
    assert (motion.name, motion.labels[0], motion.source) == (shown, shown, f"file {shown}")
    save_motion(tmp_path / f"{name}.npz", motion)
    again = load_motion(tmp_path / f"{name}.npz")
    assert again is not None
    assert (again.name, again.labels) == (motion.name, motion.labels)


def test_files_hold_any_name(tmp_path: Path) -> None:
    write_text(tmp_path / "a.csv", f"{NOT_UTF8},1\n")
    assert (tmp_path / "a.csv").read_text(encoding="utf-8") == "dance\\udcff,1\n"
    write_arrays(tmp_path / "a.npz", "trace", {"a": np.zeros(1)}, {"motion": NOT_UTF8})
    assert read_arrays(tmp_path / "a.npz", "trace")[1]["motion"] == NOT_UTF8


def test_a_repertoire_of_such_names_is_learned_and_examined(
    write_tsv: WriteTsv, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    markers = with_trunk(markers_of(dancer(ymca(rate=60.0).posture[:90])))
    recordings = [write_tsv(markers, name=f"{name}.tsv") for name in NAMES]
    run = tmp_path / "[run]\udcff$1_$2"
    words = [*recordings, *TINY, "--out", run]
    assert main(["imitate", *map(str, words)]) == 0
    assert all(line.startswith("epoch") for line in capsys.readouterr().err.splitlines())
    assert tuple(json.loads((run / "summary.json").read_text())["dominant_module"]) == SHOWN
    assert len(list((run / "figures").glob("*.png"))) == 3
    for analysis, *words in (["modules"], ["free-running"], ["lesion", "--fine-tune", "0"]):
        assert main(["analyse", str(run), analysis, *words]) == 0
        assert (run / "figures" / f"{analysis.replace('-', '_')}.png").exists()
    told = capsys.readouterr().err.splitlines()
    assert told[-1] == "[run]\\udcff$1_$2: dropping modules"
    assert not any("warning" in line for line in told)
    assert main(["imitate", "--resume", str(run), "--epochs", "1", "--no-video"]) == 0
    assert len((run / "metrics.csv").read_text().splitlines()) == 1 + 3


def test_a_run_of_a_name_that_is_not_utf8_has_a_folder_whose_name_is(
    write_tsv: WriteTsv, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = write_tsv(name=f"{NOT_UTF8}.tsv")
    monkeypatch.chdir(tmp_path)
    result = mpma("imitate", recording, *TINY)
    assert result.returncode == 0, result.stderr
    run = Path(result.stdout.splitlines()[-1])
    assert run.name.startswith(r"dance\udcff-20")
    assert (run / "figures" / "trajectory.png").exists()
    saved = json.loads((run / "config.json").read_text())["config"]["motions"]
    assert saved == [str(recording)]


@pytest.mark.parametrize(("name", "shown"), [*zip(NAMES, SHOWN, strict=True)])
def test_messages_show_a_name_on_one_line(
    name: str, shown: str, write_tsv: WriteTsv, monkeypatch: pytest.MonkeyPatch, refused: Refused
) -> None:
    monkeypatch.chdir(write_tsv(name=f"{name}.tsv", edit=lambda text: "").parent)
    refused(["motion", f"{name}.tsv"], f"mpma: {shown}.tsv: is empty; export the recording again")
    refused(["imitate", f"{name}.bvh"], f"mpma: {shown}.bvh: no such file; check the path")
    refused(["play", f"{name}"], f"mpma: no run or motion '{shown}'; expected the folder of a run")
    refused(["play", "--out", f"{name}.avi", "ymca"], f"mpma: --out is {f'{name}.avi'!r}; expected")
    with pytest.raises(MpmaError) as caught:
        read_motion(f"{name}.tsv")
    assert str(caught.value) == f"{shown}.tsv: is empty; export the recording again"
    with pytest.raises(MpmaError) as caught:
        read_motion(f"{name}.tsv", skeleton=f"{name}.asf")
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(("name", "shown"), [*zip(NAMES, SHOWN, strict=True)])
def test_such_a_recording_is_inspected_and_exported(
    name: str,
    shown: str,
    write_tsv: WriteTsv,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    markers = with_trunk(markers_of(dancer(ymca(rate=60.0).posture)))
    path = write_tsv(markers, name=f"{name}.tsv", edit=lambda t: t.replace("FRAMES\t", "FRAMES\t9"))
    folder = path.parent
    monkeypatch.chdir(folder)
    assert main(["motion", f"{name}.tsv", "--out", f"{name}.npz"]) == 0
    printed = capsys.readouterr()
    (warning,) = printed.err.splitlines()
    assert warning.startswith(f"mpma: warning: {shown}.tsv: the file declares 9228 frames")
    assert printed.out.splitlines()[0].startswith(f"{shown}: Qualisys TSV, 228 frames")
    assert printed.out.splitlines()[-2:] == [f"{shown}-motion.png", f"{shown}.npz"]
    assert main(["play", f"{name}.npz", "--out", f"{name}.csv"]) == 0
    assert capsys.readouterr().out == f"{shown}.csv\n"
    written = {f"{name}.npz", f"{name}.csv", f"{shown}-motion.png"}
    assert {path.name for path in folder.iterdir()} == {f"{name}.tsv", *written}


@pytest.mark.usefixtures("opengl")
def test_such_a_run_has_a_video(small_run: Path, tmp_path: Path) -> None:
    run = tmp_path / NOT_UTF8
    shutil.copytree(small_run, run)
    assert main(["play", str(run), "--out", str(run / "dance.mp4"), "--size", "320x240"]) == 0
    assert (run / "dance.mp4").stat().st_size > 10_000


def test_the_strip_shows_labels_of_any_kind() -> None:
    one = ymca()
    labels = Motion(one.posture, one.context, NAMES[:4], one.rate, "name", "source").labels
    context = np.repeat(np.eye(4), 10, axis=0)
    frame = Strip(context, context, labels, labels).under(np.full((480, 640, 3), 200, np.uint8), 35)
    assert frame[:480].min() < 100  # the label in the corner


def test_a_recordings_page_stands_by_its_printable_name(
    write_tsv: WriteTsv,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    spans = "0,1,$\\bad$\n1,2,$x\n2,9,踊り\n"
    (tmp_path / "labels.csv").write_text(spans, encoding="utf-8")
    markers = with_trunk(markers_of(dancer(ymca(rate=60.0).posture)))
    recording = write_tsv(markers, name=f"{NOT_UTF8}.tsv")
    monkeypatch.chdir(tmp_path)
    assert main(["motion", str(recording), "--labels", "labels.csv"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    assert printed.out.encode("utf-8")
    assert printed.out.splitlines()[-1] == r"dance\udcff-motion.png"
    assert (tmp_path / r"dance\udcff-motion.png").exists()


def test_studies_draw_and_write_such_names(write_tsv: WriteTsv, tmp_path: Path) -> None:
    recordings = [str(write_tsv(name=f"{name}.tsv")) for name in (FORMULA, NOT_UTF8)]
    words = ["--runs", "1", "--nodes", "5", "--epochs", "1", "--workers", "1"]
    words += ["--agents", "mpma", "--to", "1", "--out", str(tmp_path / "agents")]
    assert main(["study", "agents", *recordings, *words]) == 0
    assert (tmp_path / "agents" / "figure.png").exists()
    assert r"dance\udcff" in (tmp_path / "agents" / "results.csv").read_text(encoding="utf-8")


def test_a_figure_is_free_of_mathematics_whatever_the_user_has_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Text] = []
    save = FigureCanvasAgg.print_png

    def look(canvas: FigureCanvasAgg, path: Path) -> None:
        save(canvas, path)
        drawn.extend(text for text in canvas.figure.findobj(Text) if isinstance(text, Text))

    monkeypatch.setattr(FigureCanvasAgg, "print_png", look)
    users = {"text.usetex": True, "axes.formatter.use_mathtext": True}
    with matplotlib.rc_context(users):
        with figure_file(tmp_path / "a.png", 3.0, 2.0) as figure:
            axis = figure.subplots()
            axis.plot([0.0, 1e9], label="$1_$2")
            axis.set_xticks([0, 1], ["$1_$2", r"$\bad$"])
            axis.legend()
        assert {name: matplotlib.rcParams[name] for name in users} == users
        assert matplotlib.rcParams["text.parse_math"]
    assert (tmp_path / "a.png").exists()
    assert {text.get_text() for text in drawn if "$" in text.get_text()} == {"$1_$2", r"$\bad$"}
    assert not any(text.get_parse_math() or text.get_usetex() for text in drawn)


def test_characters_that_the_font_lacks_are_drawn_without_a_word(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with figure_file(tmp_path / "a.png", 2.0, 2.0) as figure:
            figure.suptitle("踊り🕺")
    assert (tmp_path / "a.png").exists()


def test_a_drawing_that_fails_leaves_the_old_figure(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_text("old")
    with pytest.raises(ZeroDivisionError), figure_file(tmp_path / "a.png", 2.0, 2.0) as figure:
        figure.suptitle(str(1 / 0))
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]
    assert (tmp_path / "a.png").read_text() == "old"


@pytest.mark.parametrize("is_terminal", ["", "1"])
def test_progress_shows_brackets_as_they_are(
    is_terminal: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("FORCE_COLOR", is_terminal)  # by which rich knows
    monkeypatch.setenv("COLUMNS", "200")
    list(show_range(range(1), "[red]run[/x]"))
    assert "[red]run[/x]" in capsys.readouterr().err
    with show_runs(1, 0) as show:
        show(1, "[red]run[/x] :o:")
    assert ("[red]run[/x] :o:" in capsys.readouterr().err) == (not is_terminal)  # else a bar
