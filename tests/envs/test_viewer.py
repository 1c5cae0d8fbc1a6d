"""The window."""

import pickle

import numpy as np
import pytest
from gymnasium.utils.passive_env_checker import env_render_passive_checker
from numpy.typing import NDArray

from mpma_mj.errors import RenderingError
from tests.envs.gym_episodes import actions, assert_same, make
from tests.envs.test_gl import python
from tests.envs.window import Window

Array = NDArray[np.float64]


def test_without_a_display_there_is_no_window() -> None:
    code = (
        "import gymnasium\n"
        "from mpma_mj.errors import RenderingError\n"
        "env = gymnasium.make('mpma_mj:TwoArmImitation-v0', render_mode='human')\n"
        "try: env.reset()\n"
        "except RenderingError as error: print(error)"
    )
    for display in ({}, {"DISPLAY": ":98765"}):
        result = python(code, **display)
        expected = 'no window: there is no display here; use render_mode="rgb_array"\n'
        assert result.stdout == expected, result.stderr


def test_a_window_follows_the_steps_and_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    from mpma_mj.envs import viewer

    monkeypatch.setattr(viewer, "_missing_display", lambda: None)
    monkeypatch.setattr("mujoco.viewer.launch_passive", Window)
    env, plain = make(render_mode="human"), make()
    assert_same(env.reset(seed=0), plain.reset(seed=0))
    for action in actions(3):
        assert_same(env.step(action), plain.step(action))
    assert env_render_passive_checker(env.unwrapped) is None
    window = env.unwrapped._viewer._window
    assert window.synced == 5
    assert window.user_scn.ngeom == 8  # of one ghost
    assert window.texts == []
    copied = pickle.dumps(env)
    env.close()
    assert not window.open
    other = pickle.loads(copied)
    other.step(np.zeros(8))
    other.close()


def test_a_second_window_is_refused_while_one_is_open(monkeypatch: pytest.MonkeyPatch) -> None:
    from mpma_mj.envs import viewer

    monkeypatch.setattr(viewer, "_missing_display", lambda: None)
    monkeypatch.setattr("mujoco.viewer.launch_passive", Window)
    first, second = make(render_mode="human"), make(render_mode="human")
    first.reset()
    with pytest.raises(RenderingError, match="no second window: MuJoCo opens one at a time"):
        second.reset()
    first.close()
    second.reset()
    second.close()
