"""Errors of the parser, as the command line prints them."""

import pytest

from mpma_mj.commands.parser_errors import parser_error
from tests.conftest import Refused


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("imitate ymca --nodes x", "--nodes is 'x'; expected an integer"),
        ("imitate ymca --nodes 2.5", "--nodes is '2.5'; expected an integer"),
        ("imitate ymca --tempo fast", "--tempo is 'fast'; expected a number, or auto"),
        ("imitate ymca --arms rubber", "--arms is 'rubber'; expected one of physics, kinematic"),
        ("imitate ymca --switch-every 1 b", "--switch-every is 1, b; expected two numbers"),
        ("imitate ymca --perturbation 1 b", "--perturbation is 1, b; expected two numbers"),
        ("imitate ymca --perturbation 1", "--perturbation takes 2 values"),
        ("imitate ymca --reward-weights a", "--reward-weights has a name without a number"),
        ("imitate --nodes", "--nodes has no value; give one"),
        ("imitate --bogus", "imitate has no option --bogus; mpma imitate --help lists all"),
        ("imitate --bogus=3", "imitate has no option --bogus; mpma imitate --help lists all"),
        ("imitate ymca --nodez 3", "imitate has no option --nodez; did you mean --nodes?"),
        ("imitate ymca --rate-in x", "--rate-in is 'x'; expected a number"),
        ("motion F --unit foot", "--unit is 'foot'; expected one of m, cm, mm, inch"),
        ("motion F --unit None", "--unit is 'None'; expected one of m, cm, mm, inch"),
        ("motion F --up w", "--up is 'w'; expected one of x, y, z, -x, -y, -z"),
        ("study table1 --nodes 3 x", "--nodes is 3, x; expected integers"),
        ("study scaling --lengths x", "--lengths is 'x'; expected numbers"),
        ("study table1 --nodes", "--nodes has no value; give one"),
        ("study agents --agents", "--agents has no value; give one"),
        ("sweep --grid", "--grid has no value; give one"),
        ("imitate --reward-weights", "--reward-weights has no value; give one"),
        ("study latency --bogus", "study latency has no option --bogus; mpma study latency --help"),
        (
            "study latency a.bvh",
            "study latency has no use for 'a.bvh'; give a motion with --motion",
        ),
        ("study table1 a.bvh", "study table1 has no use for 'a.bvh'; leave it out"),
        (
            "analyse RUN modules --beat 0.5",
            "analyse modules has no option --beat; mpma analyse modules --help lists all",
        ),
        ("motion F --start 1", "motion has no option --start, which is --from on the command line"),
        ("imitate F --end 1", "imitate has no option --end, which is --to on the command line"),
        ("imitate F --start", "imitate has no option --start, which is --from"),
        ("motion F --startle 1", "motion has no option --startle; mpma motion --help lists all"),
        ("sweep nodes=5", "no motion 'nodes=5'; did you mean --grid nodes=5?"),
        (
            "sweep ymca nodes=5,10 --runs 2",
            "no motion 'nodes=5,10'; did you mean --grid nodes=5,10?",
        ),
        (
            "imitate F --latency",
            "--latency has no value; expected one whole number, such as 3, or a",
        ),
        ("imitate F --latency x", "--latency has 'x'; expected one whole number, such as 3, or a"),
        ("play ymca dance.csv", "play has no use for 'dance.csv'; leave it out"),
        ("motion -dash.tsv", "'-dash.tsv' begins like an option; for a file, write ./-dash.tsv"),
        ("play ymca --out -runs/a.mp4", "'-runs/a.mp4' begins like an option; for a file, write"),
        ("motion", "no motion given; try: mpma motion dance.c3d --video"),
        ("identify", "no log given; try: mpma identify robot.csv"),
        ("play", "no run or motion given; try: mpma play runs/ymca --out dance.mp4"),
    ],
)
def test_what_cannot_be_parsed_is_one_line(words: str, message: str, refused: Refused) -> None:
    refused(words.split(), f"mpma: {message}")


def test_an_error_that_is_not_known_is_printed_without_its_frame() -> None:
    box = (
        "╭─ Title ────────╮\n│ Something is   │\n│ wrong. More.   │\n│ ────────────── │\n"
        "│ run mpma play --help │\n╰────────────────╯\n"
    )
    assert parser_error(box, "") == "Something is wrong; mpma play --help lists all options"


def test_frames_of_terminals_without_line_drawing_are_removed_too() -> None:
    error = "invalid choice 'a' for argument '--up'. Expected one of ('x',)."
    box = f" Invalid choice \n ---------------- \n {error} "
    assert parser_error(box, "") == "--up is 'a'; expected one of 'x'"
