"""README, CONTRIBUTING and the site: examples run as they stand, options and links exist."""

import ast
import importlib
import importlib.util
import math
import re
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

import mpma_mj
from mpma_mj.cli import main
from mpma_mj.motions.built_in import built_in
from mpma_mj.motions.readers.recognise import TEXT_FORMATS
from mpma_mj.training.run_folder import RunFolder

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]
EXAMPLES = {
    f"{page.stem} {number}": code
    for page in PAGES
    for number, code in enumerate(re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL))
}


def imported(code: str) -> set[str]:
    """Return the packages that code imports."""
    nodes = list(ast.walk(ast.parse(code)))
    plain = {alias.name for n in nodes if isinstance(n, ast.Import) for alias in n.names}
    named = {str(n.module) for n in nodes if isinstance(n, ast.ImportFrom)}
    return {name.split(".")[0] for name in plain | named}


def example(part: str) -> str:
    """Return the only example that contains some text."""
    (code,) = (code for code in EXAMPLES.values() if part in code)
    return code


def shown_options() -> set[tuple[str, str]]:
    """Return each command that a page shows, with each of its options."""
    lines = "\n".join(page.read_text("utf-8") for page in PAGES)
    command = r"study [a-z0-9]+(?= |$)|analyse \S+ [a-z-]+|(?!study)[a-z0-9]+"
    commands = re.findall(rf"^mpma ({command})( .*)?$", lines, re.MULTILINE)
    return {
        (command, option)
        for command, rest in commands
        for option in re.findall(r"--[a-z-]+", rest.split("#")[0])
    }


@pytest.mark.parametrize("title", EXAMPLES)
def test_examples_run(title: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code = EXAMPLES[title]
    optional = ("gymnasium", "stable_baselines3", "cma", "torch", "minari", "d3rlpy")
    for package in optional:
        if package in imported(code) and importlib.util.find_spec(package) is None:
            pytest.skip(f"{package} is not installed")
    monkeypatch.chdir(tmp_path)
    exec(compile(code, title, "exec"), {"__name__": "__main__"})


def test_tensorboard_shows_the_error_that_the_page_logs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("stable_baselines3")
    pytest.importorskip("tensorboard")
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    monkeypatch.chdir(tmp_path)
    code = example("class LogError").replace("16", "2")  # environments
    exec(code.replace("seed=0,", 'seed=0, tensorboard_log="logs",'), {"__name__": "__main__"})

    events = EventAccumulator("logs/PPO_1").Reload()
    (error,) = events.Scalars("rollout/p_e_percent")
    assert error.step == 2 * 2 * 128
    assert 1.0 < error.value < 5.0


def test_every_way_has_an_example() -> None:
    for library in ("stable_baselines3", "cma"):
        assert any(library in imported(code) for code in EXAMPLES.values())


@pytest.mark.parametrize("command", sorted({command for command, _ in shown_options()}))
def test_options_that_are_shown_exist(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main([*command.split(), "--help"])
    offered = set(re.findall(r"--[a-z-]+", capsys.readouterr().out))
    assert {option for name, option in shown_options() if name == command} - offered == set()


def test_the_gallery_has_ten_small_loops_of_built_in_motions(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.syspath_prepend(DOCS)
    gallery = importlib.import_module("make_gallery")
    page = gallery.PAGE.read_text("utf-8")
    dances = gallery.entries(page)
    assert len(dances) == page.count("![") == 10
    for _, (command, motion, *_) in dances:
        assert command == "imitate"
        assert built_in(motion)
    sizes = {path.stem: path.stat().st_size for path in gallery.PICTURES.iterdir()}
    assert sizes.keys() == {name for name, _ in dances}
    assert max(sizes.values()) < 150_000
    assert sum(sizes.values()) < 1_200_000


@pytest.mark.usefixtures("opengl")
def test_a_loop_of_the_gallery_is_drawn_from_a_run(
    small_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(DOCS)
    gallery = importlib.import_module("make_gallery")
    gallery.write_loop(tmp_path / "loop.webp", small_run)
    motion = RunFolder(small_run).read_motion()
    with Image.open(tmp_path / "loop.webp") as loop:
        assert loop.size == (300, 270)
        assert loop.n_frames == math.ceil(len(motion) / 2)


@pytest.mark.parametrize(
    "words",
    [["--agent", "my_agents.py:Biased"], ["--models", "posture", "--rule", "r.py:WinnerRule"]],
)
def test_outside_classes_of_the_page_train_on_the_command_line(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("my_agents.py").write_text(example("class Biased").split("\n\nenv = ")[0])
    Path("r.py").write_text(example("class WinnerRule").split("\n\nconfig = ")[0])

    arguments = ["imitate", "ymca", *words, "--epochs", "1", "--no-video", "--out", "run"]

    assert main(arguments) == 0
    assert main(["imitate", "--resume", "run", "--no-video"]) == 2  # names no class
    assert main(["imitate", "--resume", "run", *words, "--epochs", "1", "--no-video"]) == 0


def test_the_reader_of_the_page_reads_a_motion_where_the_page_puts_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    exec(example("def convert"), {})  # writes dance.frames, and dance.npz of the same points
    reader: dict[str, Any] = {}
    exec(example("def is_frames"), reader)
    monkeypatch.setitem(TEXT_FORMATS, reader["is_frames"], reader["read_frames"])

    from_frames = mpma_mj.read_motion("dance.frames", rate_in=20.0)
    from_npz = mpma_mj.read_motion("dance.npz")

    assert (from_frames.posture == from_npz.posture).all()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for path in re.findall(r"\]\((?!http)([^)#]+)", page.read_text(encoding="utf-8")):
        assert (page.parent / path).exists(), path


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_to_headings_that_exist(page: Path) -> None:
    links = re.findall(r"\]\((?!http)([^)#]*)#([^)]+)\)", page.read_text(encoding="utf-8"))
    for path, anchor in links:
        text = (page.parent / path if path else page).read_text(encoding="utf-8")
        headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
        anchors = {re.sub(r"[^\w -]", "", h.lower()).replace(" ", "-") for h in headings}
        assert anchor in anchors, f"{path}#{anchor}"
