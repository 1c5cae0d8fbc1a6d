"""Stable-Baselines3: its vectors, its checker, its logs, and a training."""

import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from mpma_mj.envs.gym_env import FlatImitationEnv, ImitationEnv
from mpma_mj.envs.make_vec import make_vec
from mpma_mj.errors import BadOptionError
from tests.envs.test_gl import environment, python


def test_without_the_library_one_line_says_how_to_install_it() -> None:
    code = """
import sys; sys.modules["stable_baselines3"] = None
try: import mpma_mj.envs.sb3
except ImportError as error: print(error)
"""
    (line,) = python(code).stdout.splitlines()
    assert line.startswith("mpma_mj.envs.sb3 needs Stable-Baselines3, which is not installed; pip")


@pytest.fixture
def sb3() -> Any:
    pytest.importorskip("stable_baselines3")
    from mpma_mj.envs import sb3

    return sb3


OPTIONS: dict[str, Any] = {"repeats": 1, "random_start": True, "termination_distance": 0.4}


@pytest.mark.parametrize(("kind", "flat"), [(FlatImitationEnv, True), (ImitationEnv, False)])
def test_numbers_are_those_of_its_own_vectors(sb3: Any, kind: Any, flat: bool) -> None:
    from stable_baselines3.common.vec_env import DummyVecEnv

    theirs = DummyVecEnv([lambda: kind(**OPTIONS) for _ in range(3)])
    ours = sb3.make_sb3_vec(3, "ymca", flat=flat, **OPTIONS)
    assert ours.seed(7) == theirs.seed(7) == [7, 8, 9]
    one, other, ended = ours.reset(), theirs.reset(), 0
    rng = np.random.default_rng(0)
    for _ in range(150):
        compare(one, other)
        assert ours.venv.reset_infos == theirs.reset_infos
        actions = rng.uniform(-1, 1, (3, 8)).astype(np.float32)
        one, *outcome, infos = ours.step(actions)
        other, *expected, their_infos = theirs.step(actions)
        np.testing.assert_array_equal(outcome, expected)
        assert outcome[0].dtype == expected[0].dtype
        for row in np.flatnonzero(outcome[1]):
            del infos[row]["episode"]  # that of the monitor
            compare(
                infos[row].pop("terminal_observation"), their_infos[row]["terminal_observation"]
            )
            del their_infos[row]["terminal_observation"]
            assert infos[row] == their_infos[row]
            ended += 1
    assert ended > 3
    ours.close()


def compare(one: Any, other: Any) -> None:
    if not isinstance(one, dict):
        one, other = {"": one}, {"": other}
    for name, values in one.items():
        assert values.dtype == np.float32
        np.testing.assert_allclose(values, other[name], rtol=1e-6, atol=1e-6)


def test_episodes_are_logged_with_their_tracking_errors(sb3: Any) -> None:
    env = sb3.make_sb3_vec(2, "ymca", arms="kinematic", repeats=1, feedback_gain=1.0)
    env.reset()
    over = np.zeros(2, bool)
    while not over.all():
        _, _, over, infos = env.step(np.zeros((2, 8)))
    for info in infos:
        assert info["TimeLimit.truncated"]
        assert 0.0 < info["episode"]["p_e_percent"] < 3.0
        assert info["episode"]["termination_reason"] == "the demonstration is over"
    env.close()


def test_attributes_and_methods(sb3: Any) -> None:
    plants = [{}, {"actuator_gain": 0.5}]
    env = sb3.make_sb3_vec(
        3, "ymca", arms="kinematic", repeats=1, feedback_gain=0.5, plants=plants, epochs_per_plant=1
    )
    env.reset()
    assert env.get_attr("steps") == [env.unwrapped.envs.unwrapped.steps] * 3
    assert env.get_attr("plant", [0, 2]) == [0, 0]
    env.set_attr("gain", 0.25)
    assert env.get_attr("gain") == [0.25] * 3
    assert env.env_is_wrapped(gymnasium.Wrapper) == [False] * 3
    with pytest.raises(AttributeError, match="gian"):
        env.set_attr("gian", 1.0)
    with pytest.raises(BadOptionError, match="indices is 0; expected None, as all share"):
        env.set_attr("gain", 1.0, indices=0)
    for options in ({"mass": 3}, True, np.ones(2)):
        env.set_options(options)
        with pytest.raises(BadOptionError, match="reset has no options"):
            env.reset()
    env.set_options()
    for seed in ("3", [], -1, True, np.nan):
        with pytest.raises(BadOptionError, match=r"seed is .*; expected a whole number from 0 up"):
            env.seed(seed)
    env.reset()  # with the seeds as they were
    env.close()


def test_drawn_options_are_those_of_each_environment(sb3: Any) -> None:
    env = sb3.make_sb3_vec(2, "ymca", repeats=1, payload=(0, 3))
    env.reset()
    drawn = env.get_attr("drawn")
    assert drawn == [{"payload": info["payload"]} for info in env.unwrapped.reset_infos]
    assert drawn[0] != drawn[1]
    over = np.zeros(2, bool)
    while not over.all():
        _, _, over, infos = env.step(np.zeros((2, 8), np.float32))
    assert [{"payload": info["payload"]} for info in infos] == drawn
    assert env.get_attr("drawn") != drawn
    env.close()


def test_other_modes_of_autoreset_are_refused(sb3: Any) -> None:
    with pytest.raises(BadOptionError, match="autoreset_mode is 'NEXT_STEP'; expected SAME_STEP"):
        sb3.SB3VecEnv(make_vec(2, arms="kinematic"))


@pytest.mark.usefixtures("opengl")
def test_pictures_are_a_grid(sb3: Any) -> None:
    view = {"render_mode": "rgb_array", "width": 40, "height": 30}
    env = sb3.make_sb3_vec(3, "ymca", arms="kinematic", repeats=1, **view)
    env.reset()
    assert env.render().shape == (60, 80, 3)
    assert len(env.env_method("render")) == 3
    env.close()


@pytest.mark.parametrize("kind", [FlatImitationEnv, ImitationEnv])
def test_its_checker_finds_nothing(kind: Any) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        checker.check_env(kind(repeats=1), skip_render_check=True)


def test_monitors_take_the_tracking_errors_also_from_processes() -> None:
    pytest.importorskip("stable_baselines3")
    program = """
import numpy as np
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import SubprocVecEnv
if __name__ == "__main__":
    env = make_vec_env("mpma_mj:TwoArmImitationFlat-v0", 2, vec_env_cls=SubprocVecEnv,
        env_kwargs=dict(arms="kinematic", repeats=1), vec_env_kwargs=dict(start_method="spawn"),
        monitor_kwargs=dict(info_keywords=("p_e_percent", "mpkpe_m")))
    env.reset()
    over = np.zeros(2, bool)
    while not over.all():
        _, _, over, infos = env.step(np.zeros((2, 8)))
    print(*[info["episode"]["p_e_percent"] > 0 for info in infos])
    env.close()
"""
    assert run(program) == "True True"


TRAIN = """
from stable_baselines3 import PPO
print(PPO("MlpPolicy", env, n_steps=64, device="cpu").learn(128).num_timesteps)
"""


def test_two_updates_of_ppo_train_where_nothing_was_chosen() -> None:
    pytest.importorskip("stable_baselines3")
    program = """
import gymnasium
env = gymnasium.make("mpma_mj:TwoArmImitationFlat-v0", motion="ymca", arms="kinematic")
"""
    assert run(program + TRAIN) == "128"


@pytest.mark.usefixtures("opengl")
def test_ppo_trains_in_a_process_that_has_drawn() -> None:
    pytest.importorskip("stable_baselines3")
    program = """
from mpma_mj.envs.sb3 import make_sb3_vec
env = make_sb3_vec(2, "ymca", arms="kinematic", render_mode="rgb_array")
env.reset()
env.render()
"""
    assert run(program + TRAIN) == "128"


def run(program: str) -> str:
    """Return the last line that a program prints, which has to end without an error."""
    file = Path("program.py")
    command = [sys.executable, str(file)]
    file.write_text(program)
    result = subprocess.run(command, env=environment(), capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    return result.stdout.splitlines()[-1]


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"paylod": 1}, r"^no option 'paylod'; did you mean payload\?$"),
        ({"feedbak_gain": 1}, r"^no option 'feedbak_gain'; did you mean feedback_gain\?$"),
        ({"options": {}}, "^no option 'options'"),
        ({"feedback_gain": -1}, "^feedback_gain is -1; expected 0 to 1$"),
        ({"feedback_gain": np.zeros(2)}, r"^feedback_gain is array\(.*\); expected 0 to 1$"),
        ({"feedback_gain": False}, "^feedback_gain is False; expected 0 to 1$"),
        ({"camera": "nope"}, "^camera is 'nope'; expected one of the model's cameras: front"),
    ],
)
def test_bad_options_are_one_line(sb3: Any, options: dict[str, Any], message: str) -> None:
    with pytest.raises(BadOptionError, match=message):
        sb3.make_sb3_vec(2, arms="kinematic", **options)


def test_other_environments_are_refused(sb3: Any) -> None:
    for env in (None, "ymca", ImitationEnv(arms="kinematic")):
        with pytest.raises(BadOptionError, match=r"expected an environment of mpma_mj\.make_vec"):
            sb3.SB3VecEnv(env)


def test_another_autoreset_is_refused(sb3: Any) -> None:
    with pytest.raises(BadOptionError, match="begins episodes at the same step; leave out"):
        sb3.make_sb3_vec(2, arms="kinematic", autoreset_mode="DISABLED")
