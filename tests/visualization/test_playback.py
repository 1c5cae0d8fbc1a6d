"""What a player shows next, as laws."""

import copy

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpma_mj.visualization.playback import LEFT, RIGHT, SPACE, Player

COUNTS = st.integers(0, 300)


@st.composite
def players(draw: st.DrawFn) -> Player:
    steps = draw(st.integers(2, 100))
    return Player(steps, draw(st.integers(0, steps - 1)), draw(st.booleans()))


@given(players(), COUNTS)
def test_pause_holds_the_step(player: Player, count: int) -> None:
    player.paused = True
    before = player.step
    for _ in range(count):
        player.advance()
    assert player.step == before


@given(players(), COUNTS)
def test_steps_on_and_as_many_back_return(player: Player, count: int) -> None:
    before = player.step
    for key in [RIGHT] * count + [LEFT] * count:
        player.press(key)
        player.advance()
    assert player.step == before


@given(players())
def test_playing_comes_by_every_step_and_round_again(player: Player) -> None:
    player.paused = False
    shown = []
    for _ in range(player.steps):
        shown.append(player.step)
        player.advance()
    assert sorted(shown) == list(range(player.steps))
    assert player.step == shown[0]


@given(players(), st.sampled_from([RIGHT, LEFT]))
def test_an_arrow_pauses_and_goes_to_a_neighbour(player: Player, key: int) -> None:
    before = player.step
    player.press(key)
    assert player.paused
    assert (player.step - before) % player.steps == (1 if key == RIGHT else player.steps - 1)


@given(players())
def test_space_twice_is_nothing_and_once_stays_at_the_step(player: Player) -> None:
    before = copy.copy(player)
    player.press(SPACE)
    assert (player.step, player.paused) == (before.step, not before.paused)
    player.press(SPACE)
    assert player == before


@given(players(), st.integers(0, 400).filter(lambda key: key not in (SPACE, RIGHT, LEFT)))
def test_other_keys_do_nothing(player: Player, key: int) -> None:
    before = copy.copy(player)
    player.press(key)
    assert player == before


def test_keys_have_the_codes_of_the_windows_library() -> None:
    glfw = pytest.importorskip("glfw")
    assert (SPACE, RIGHT, LEFT) == (glfw.KEY_SPACE, glfw.KEY_RIGHT, glfw.KEY_LEFT)
