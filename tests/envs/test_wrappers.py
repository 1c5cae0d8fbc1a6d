import copy
import itertools
from collections.abc import Callable
from pathlib import Path

import dm_env
import imageio.v2 as imageio
import numpy as np
import pytest

from mpma_mj import load, metrics
from mpma_mj.agents import (
    AgentSpec,
    FeedbackOnly,
    FeedbackOnlyConfig,
    RandomAgent,
    RandomConfig,
)
from mpma_mj.envs import gl
from mpma_mj.envs.gym_env import ImitationEnv
from mpma_mj.envs.wrappers import Evaluate, FeedbackAssist, RecordVideo, Wrapper
from mpma_mj.errors import (
    BadOptionError,
    RenderingError,
    RunFolderError,
    StateError,
    VideoError,
)
from mpma_mj.training.rollout import record_epoch
from tests.conftest import Encoder

Act = Callable[[dict[str, np.ndarray]], np.ndarray]


def ymca(arms: str = "physics", repeats: int = 1) -> dm_env.Environment:
    return load("ymca", arms=arms, repeats=repeats)


SPEC = AgentSpec(4, np.ones(8), 0.05)


def at_random(seed: int = 0) -> Act:
    return RandomAgent(RandomConfig(), SPEC, seed=seed).act


def nothing(observation: dict[str, np.ndarray]) -> np.ndarray:
    return np.zeros(8)


def danced(env: dm_env.Environment, act: Act) -> list[dm_env.TimeStep]:
    timesteps = [env.reset()]
    while not timesteps[-1].last():
        timesteps.append(env.step(act(timesteps[-1].observation)))
    return timesteps


def stacked(timesteps: list[dm_env.TimeStep], name: str) -> np.ndarray:
    return np.stack([t.observation[name] for t in timesteps])


def assert_same(some: list[dm_env.TimeStep], others: list[dm_env.TimeStep]) -> None:
    assert len(some) == len(others)
    for one, other in zip(some, others, strict=True):
        assert one[:3] == other[:3]
        assert one.observation.keys() == other.observation.keys()
        for name, values in one.observation.items():
            np.testing.assert_array_equal(other.observation[name], values)


@pytest.fixture
def _opengl() -> None:
    try:
        gl.require_backend()
    except RenderingError as error:
        pytest.skip(str(error))


def test_wrappers_hand_on_what_they_do_not_have() -> None:
    env = ymca()
    wrapped = Evaluate(FeedbackAssist(Wrapper(env), gain=0.5))
    assert isinstance(wrapped, dm_env.Environment)
    assert wrapped.task is env.task
    assert wrapped.physics is env.physics
    assert wrapped.control_timestep() == env.control_timestep()
    assert wrapped.gain == 0.5
    for spec in ("action_spec", "observation_spec", "reward_spec", "discount_spec"):
        assert getattr(wrapped, spec)() == getattr(env, spec)()
    with pytest.raises(AttributeError, match="nonsense"):
        _ = wrapped.nonsense
    assert not hasattr(Evaluate(env), "gain")


def test_a_wrapper_that_holds_nothing_yet_can_be_asked() -> None:
    with pytest.raises(AttributeError):
        _ = Wrapper.__new__(Wrapper).task
    assert copy.copy(Wrapper(ymca())).task is not None


@pytest.mark.parametrize("wrap", [Wrapper, Evaluate, FeedbackAssist])
def test_other_interfaces_are_refused(wrap: type[Wrapper]) -> None:
    for other in (ImitationEnv(), None):
        with pytest.raises(BadOptionError, match=r"expected what mpma_mj\.load returned; for Gym"):
            wrap(other)


def test_a_film_cannot_be_copied(tmp_path: Path) -> None:
    with pytest.raises(
        StateError, match="cannot be pickled or copied; copy the environment inside"
    ):
        copy.deepcopy(RecordVideo(ymca(), tmp_path / "a.mp4"))


def test_a_copy_goes_on_identically() -> None:
    env = ymca()
    env.reset()
    env.step(np.ones(8))
    other = copy.deepcopy(env)
    for _ in range(5):
        one, two = env.step(np.ones(8)), other.step(np.ones(8))
        np.testing.assert_array_equal(one.observation["posture"], two.observation["posture"])


def test_closing_closes_what_is_inside() -> None:
    class Door(Wrapper):
        closed = False

        def close(self) -> None:
            self.closed = True

    door = Door(ymca())
    with Evaluate(FeedbackAssist(door)):
        assert not door.closed
    assert door.closed


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_assisted_doing_nothing_is_feedback_alone(arms: str) -> None:
    env = ymca(arms)
    limits = {
        "max_joint_speed": env.task.max_joint_speed,
        "control_timestep": env.control_timestep(),
    }
    alone = danced(env, FeedbackOnly(FeedbackOnlyConfig(), AgentSpec(4, **limits)).act)
    assert_same(danced(FeedbackAssist(ymca(arms), gain=1.0), nothing), alone)


def test_assistance_of_gain_zero_changes_nothing() -> None:
    assert_same(danced(FeedbackAssist(ymca(), gain=0.0), at_random()), danced(ymca(), at_random()))


def test_assisted_actions_are_the_sum_clipped() -> None:
    env = FeedbackAssist(ymca(), gain=0.7)
    env.reset()
    for act in itertools.repeat(at_random(), 20):
        action = act({})
        env.step(action)
        expected = np.clip(action + env.last_feedback, -1.0, 1.0)
        np.testing.assert_array_equal(env.last_action, expected)
    assert (np.abs(env.last_feedback) <= 0.7).all()
    assert env.last_feedback.any()


def test_what_an_agent_writes_into_observations_is_no_matter() -> None:
    def vandal(observation: dict[str, np.ndarray]) -> np.ndarray:
        for values in observation.values():
            values[:] = 0.0
        return np.zeros(8)

    env = Evaluate(FeedbackAssist(ymca()))
    rewards = [t.reward for t in danced(env, nothing)]
    assert [t.reward for t in danced_again(env, vandal)] == rewards
    assert env.episode_metrics[0] == env.episode_metrics[1]


def danced_again(env: dm_env.Environment, act: Act) -> list[dm_env.TimeStep]:
    env.task.episode = 0
    return danced(env, act)


@pytest.mark.parametrize("gain", [-0.1, 1.1, float("nan")])
def test_a_gain_that_is_none_is_refused(gain: float) -> None:
    with pytest.raises(BadOptionError, match="expected 0 to 1"):
        FeedbackAssist(ymca(), gain=gain)
    env = FeedbackAssist(ymca())
    with pytest.raises(BadOptionError, match="expected 0 to 1"):
        env.gain = gain


def test_evaluating_changes_nothing() -> None:
    assert_same(danced(Evaluate(ymca()), at_random()), danced(ymca(), at_random()))


@pytest.mark.parametrize("arms", ["physics", "kinematic"])
def test_measures_are_those_of_a_trace(arms: str) -> None:
    env = Evaluate(ymca(arms))
    trace = record_epoch(env, RandomAgent(RandomConfig(), SPEC, seed=3), 0)
    posture, reference = trace.posture[1:], trace.reference[1:]
    sites = env.physics.site_positions
    assert env.episode_metrics == [
        {
            "p_e_percent": metrics.posture_error_percent(posture, reference),
            "mpkpe_m": metrics.mpkpe(sites(posture), sites(reference)),
            "mean_reward": float(np.mean(trace.reward)),
            "steps": len(posture),
            "terminated": False,
        }
    ]


def test_the_feedback_ratio_is_that_of_the_steps() -> None:
    assist = FeedbackAssist(ymca(), gain=0.5)
    env = Evaluate(Wrapper(assist))
    feedback, action = [], []
    act, timestep = at_random(), env.reset()
    while not timestep.last():
        timestep = env.step(0.3 * act({}))
        feedback.append(assist.last_feedback)
        action.append(assist.last_action)
    ratio = metrics.feedback_ratio(np.stack(feedback), np.stack(action))
    assert env.episode_metrics[0]["feedback_ratio"] == ratio
    assert 0.0 < ratio < 2.0
    danced(env, nothing)
    assert env.episode_metrics[1]["feedback_ratio"] == 1.0


def test_episodes_are_measured_each_and_only_whole_ones() -> None:
    env = Evaluate(ymca("kinematic"))
    act = at_random()
    env.reset()
    for _ in range(5):
        env.step(act({}))
    assert env.episode_metrics == []
    danced(env, act)
    assert env.step(act({})).first()  # as dm_env has it: begins the next
    for _ in range(env.task.steps):
        timestep = env.step(act({}))
    assert timestep.last()
    assert [m["steps"] for m in env.episode_metrics] == [env.task.steps] * 2


def test_a_simulation_that_diverges_is_told() -> None:
    env = Evaluate(ymca())
    env.reset()
    env.step(np.zeros(8))
    env.physics.data.qvel[:] = 1e12
    assert env.step(np.zeros(8)).last()
    assert env.episode_metrics[0]["terminated"]
    assert env.episode_metrics[0]["steps"] == 2


@pytest.mark.usefixtures("_opengl")
def test_every_episode_becomes_a_video_of_its_own(tmp_path: Path) -> None:
    env = RecordVideo(ymca(), tmp_path / "new" / "{episode}.mp4")
    plain = ymca()
    for number in range(2):
        assert_same(danced(env, at_random(number)), danced(plain, at_random(number)))
        assert sorted(p.name for p in (tmp_path / "new").iterdir()) == [
            f"{i}.mp4" for i in range(number + 1)
        ]
    env.close()
    reader = imageio.get_reader(tmp_path / "new" / "1.mp4")
    assert reader.get_meta_data()["fps"] == pytest.approx(1.0 / env.control_timestep())
    frames = [np.asarray(frame, float) for frame in reader]
    assert len(frames) == env.task.steps + 1
    assert frames[0].shape == (480, 640, 3)
    assert np.abs(frames[0] - frames[40]).max() > 50


@pytest.mark.usefixtures("_opengl")
def test_a_video_has_its_name_when_it_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "dance.mp4"
    with RecordVideo(ymca(), path, camera="side") as env:
        env.reset()
        assert list(tmp_path.iterdir()) == []
        for _ in range(4):
            env.step(np.zeros(8))
        assert not path.exists()
    assert list(tmp_path.iterdir()) == [path]
    assert sum(1 for _ in imageio.get_reader(path)) == 4


@pytest.mark.usefixtures("_opengl")
def test_an_episode_that_is_left_is_a_video_and_one_without_a_step_is_none(tmp_path: Path) -> None:
    env = RecordVideo(ymca(), tmp_path / "{episode}.mp4")
    for steps in (2, 0, 3):
        env.reset()
        for _ in range(steps):
            env.step(np.zeros(8))
    env.reset()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["0.mp4", "2.mp4"]
    assert [sum(1 for _ in imageio.get_reader(tmp_path / f"{i}.mp4")) for i in (0, 2)] == [2, 3]
    env.close()


@pytest.mark.usefixtures("_opengl")
def test_a_video_that_fails_leaves_nothing_and_the_episode_goes_on(
    tmp_path: Path, encoder: Encoder
) -> None:
    encoder("exit 3")
    env = RecordVideo(ymca(), tmp_path / "dance.mp4")
    env.reset()
    with pytest.raises(VideoError, match=r"dance\.mp4: no new video, ffmpeg failed: exit code 3"):
        env.step(np.zeros(8))
    assert list(tmp_path.iterdir()) == []
    env.step(np.zeros(8))
    env.close()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("_opengl")
@pytest.mark.parametrize("leave", ["reset", "close"])
def test_a_video_whose_end_cannot_be_written_leaves_the_one_before(
    leave: str, tmp_path: Path, encoder: Encoder
) -> None:
    path = tmp_path / "dance.mp4"
    with RecordVideo(ymca(), path) as env:
        env.reset()
        env.step(np.zeros(8))
    old = path.read_bytes()
    encoder('cat > /dev/null; echo half > "$video"; exit 228')
    env = RecordVideo(ymca(), path)
    env.reset()
    env.step(np.zeros(8))
    with pytest.raises(VideoError, match="exit code 228"):
        getattr(env, leave)()
    assert path.read_bytes() == old
    assert list(tmp_path.iterdir()) == [path]
    env.close()


@pytest.mark.usefixtures("_opengl")
def test_a_folder_that_cannot_be_is_told_at_the_first_step(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    env = RecordVideo(ymca(), tmp_path / "file" / "dance.mp4")
    env.reset()
    with pytest.raises(RunFolderError, match="cannot be written"):
        env.step(np.zeros(8))


def test_a_video_says_what_it_cannot_be(tmp_path: Path) -> None:
    for name in ("{ep}.mp4", "{}.mp4", "{episode:03d}.mp4"):
        with pytest.raises(BadOptionError, match=r"expected no braces but those of \{episode\}"):
            RecordVideo(ymca(), tmp_path / name)
    with pytest.raises(BadOptionError, match=r"ends in \.mp4"):
        RecordVideo(ymca(), tmp_path / "dance.gif")
    with pytest.raises(BadOptionError, match="front, side, three_quarter"):
        RecordVideo(ymca(), tmp_path / "dance.mp4", camera="above")
