"""Errors of the parser, as the command line prints them."""

import pytest

from mpma_mj.commands.parser_errors import parser_error
from tests.conftest import Refused


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("imitate ymca --nodes x", "--nodes is 'x'; expected an integer"),
        ("imitate ymca --nodes 2.5", "--nodes is '2.5'; expected an integer"),
        ("imitate ymca --tempo fast", "--tempo is 'fast'; expected a number"),
        ("imitate ymca --arms rubber", "--arms is 'rubber'; expected one of physics, kinematic"),
        ("imitate ymca --switch-every 1 b", "--switch-every is 1, b; expected two numbers"),
        ("imitate ymca --perturbation 1 b", "--perturbation is 1, b; expected two numbers"),
        ("imitate ymca --perturbation 1", "--perturbation takes 2 values"),
        ("imitate ymca --reward-weights a", "--reward-weights has a name without a number"),
        ("imitate --nodes", "--nodes has no value; give one"),
        ("imitate --bogus", "mpma imitate has no option --bogus; mpma imitate --help lists all"),
        ("imitate --bogus=3", "mpma imitate has no option --bogus; mpma imitate --help lists all"),
        ("imitate ymca --nodez 3", "mpma imitate has no option --nodez; did you mean --nodes?"),
        ("play ymca dance.csv", "mpma play has no use for 'dance.csv'; leave it out"),
        ("play", "RUN|MOTION is missing; mpma play --help shows what is needed"),
    ],
)
def test_what_cannot_be_parsed_is_one_line(words: str, message: str, refused: Refused) -> None:
    refused(words.split(), f"mpma: {message}")


def test_an_error_that_is_not_known_is_printed_without_its_frame() -> None:
    box = "╭─ Title ────────╮\n│ Something is   │\n│ wrong.         │\n╰────────────────╯\n"
    assert parser_error(box, "mpma play").endswith("Something is wrong.")


def test_frames_of_terminals_without_line_drawing_are_removed_too() -> None:
    error = "invalid choice 'a' for argument '--up'. Expected one of ('x',)."
    box = f" Invalid choice \n ---------------- \n {error} "
    assert parser_error(box, "mpma play") == "--up is 'a'; expected one of 'x'"
