"""The page without a browser: widgets by the messages that a browser sends."""

import dataclasses
import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("viser")

from mpma_mj.agents import FeedbackOnlyConfig
from mpma_mj.browser.episode_factory import EpisodeFactory
from mpma_mj.browser.page import LOOK_AT
from mpma_mj.browser.simulation import LiveSimulation
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import BadOptionError
from mpma_mj.motions import ymca
from mpma_mj.robots.robot_file import CATALOGUE
from mpma_mj.training.config import RunConfig
from tests.browser.conftest import Stage, served
from tests.browser.viewer import until


def without_modules(env: EnvironmentOptions) -> LiveSimulation:
    config = RunConfig(agent=FeedbackOnlyConfig(), agent_name="feedback_only", env=env)
    return LiveSimulation(EpisodeFactory(config, ymca()))


def test_first_viewer_has_the_controls_and_it_plays(stage: Stage) -> None:
    viewer, live = stage.viewer(), stage.simulation
    until(lambda: viewer.find("Pause") and len(live.moments) > 5)
    viewer.set("Pause", True)
    until(lambda: not live.playing and viewer.find("Play"))
    viewer.set("Play", True)
    until(lambda: live.playing and viewer.find("Pause"))


def test_one_viewer_has_the_controls_until_another_takes_them(stage: Stage) -> None:
    first = stage.viewer()
    until(lambda: first.find("module 1"))
    second = stage.viewer()
    until(lambda: second.find("Take the controls"))
    assert not second.find("module 1")
    second.set("Take the controls", True)
    until(lambda: second.find("module 1") and first.find("Take the controls"))
    assert not first.find("module 1")
    second.set("module 1", False)
    until(lambda: stage.simulation.enabled_modules == [False, True, True])


def test_controls_of_a_viewer_who_leaves_go_to_the_next_one(stage: Stage) -> None:
    first = stage.viewer()
    until(lambda: first.find("Pause"))
    second = stage.viewer()
    until(lambda: second.find("Take the controls"))
    first.set("module 2", False)
    until(lambda: stage.simulation.enabled_modules == [True, False, True])
    first.close()
    until(lambda: second.find("module 2"))
    assert second.value("module 2") is False
    assert not second.find("Take the controls")
    second.close()
    until(lambda: stage.page.controls is None)
    third = stage.viewer()
    until(lambda: third.find("module 2"))


def test_all_viewers_see_the_same(stage: Stage) -> None:
    viewers = [stage.viewer(), stage.viewer()]
    until(lambda: len(stage.simulation.moments) > 20)
    stage.simulation.request(stage.simulation.pause)
    hand = "/arms/left_hand"
    place = stage.simulation.episode.env.physics.named.data.xpos["left_hand"]
    for viewer in viewers:
        until(lambda v=viewer: np.allclose(v.positions.get(hand, 0.0), place, atol=1e-5))
        assert "λ" in viewer.text()


def test_module_that_is_switched_off_controls_nothing_until_it_is_on(stage: Stage) -> None:
    viewer, live = stage.viewer(), stage.simulation
    viewer.set("module 2", False)
    until(lambda: live.enabled_modules == [True, False, True])
    until(lambda: live.moment.responsibility[1] == 0.0 and "off" in viewer.text())
    viewer.set("module 2", True)
    until(lambda: live.moment.responsibility[1] > 0.0 and "off" not in viewer.text())


def test_what_the_program_sets_is_no_users_wish(stage: Stage) -> None:
    viewer, live = stage.viewer(), stage.simulation
    until(lambda: len(live.moments) > 20 and viewer.value("step") > 10)
    assert live.playing
    assert live.shown is None


def test_scrubbing_shows_the_past_and_starts_there(stage: Stage) -> None:
    viewer, live = stage.viewer(), stage.simulation
    until(lambda: len(live.moments) > 20)
    viewer.set("step", 7)
    until(lambda: live.shown == 7 and "step 7;" in viewer.text())
    assert not live.playing
    viewer.set("step", 200)  # which is still to come
    until(lambda: viewer.value("step") == live.shown == len(live.moments) - 1)
    viewer.set("step", 7)
    until(lambda: live.shown == 7)
    viewer.set("move", "start here")
    until(lambda: len(live.moments) == 8 and live.shown is None)
    viewer.set("move", "step")
    until(lambda: len(live.moments) == 9)
    viewer.set("move", "restart")
    until(lambda: len(live.moments) == 1)


def test_tempo_payload_gain_and_latency_follow_their_sliders(stage: Stage) -> None:
    viewer, live = stage.viewer(), stage.simulation
    values = {"tempo": 2.0, "payload, kg": 3.0, "gain": 0.5, "latency, steps": 2}
    for label, value in values.items():
        viewer.set(label, value)
    until(lambda: live.intervention.latency == 2)
    assert live.tempo == 2.0
    assert (live.intervention.payload, live.intervention.actuator_gain) == (3.0, 0.5)
    viewer.set("payload, kg", 99.0)  # as it can be typed beside the slider
    until(lambda: live.intervention.payload == 5.0)
    viewer.set("payload, kg", values["payload, kg"])
    until(lambda: live.intervention.payload == 3.0)
    other = stage.viewer()
    other.set("Take the controls", True)
    until(lambda: other.find("latency, steps"))
    assert {label: other.value(label) for label in values} == values
    viewer.set("Take the controls", True)
    viewer.set("plant", "as in the run")
    until(lambda: live.intervention.payload is None and viewer.value("latency, steps") == 0)
    until(lambda: viewer.value("payload, kg") == 0.0 and viewer.value("gain") == 1.0)


def test_plants_are_switched_by_buttons() -> None:
    plants = ({}, {"payload": 3.0})
    env = EnvironmentOptions(plants=plants, switch_every=(1000, 2000))
    with served(without_modules(env)) as stage:
        viewer, live = stage.viewer(), stage.simulation
        viewer.set("plant", "plant 2")
        until(lambda: live.moment.plant == 1 and "plant 2: payload=3" in viewer.text())
        until(lambda: viewer.value("payload, kg") == 3.0)
        viewer.set("payload, kg", 1.0)
        until(lambda: live.intervention.payload == 1.0)
        viewer.set("plant", "plant 1")
        until(lambda: live.moment.plant == 0 and live.intervention.payload is None)


def test_dragged_hand_is_pushed_by_the_viewer_in_control_alone(stage: Stage) -> None:
    first, live = stage.viewer(), stage.simulation
    until(lambda: first.find("Pause"))
    second = stage.viewer()
    until(lambda: second.find("Take the controls"))
    grab = "/arms/right_hand/grab"
    second.drag(grab, "start", (3.0, 0.0, 1.0))
    first.drag(grab, "start", (0.0, -3.0, 1.0))
    until(lambda: live.moment.push.any())
    assert live.moment.push[1, 1] < -40.0  # to where the first drags
    assert np.linalg.norm(live.moment.push[1]) == pytest.approx(80.0)
    assert not live.moment.push[0].any()
    until(lambda: "80 N, right hand" in first.text() and live.recent_error_percent > 1.0)
    first.drag(grab, "end", (0.0, -3.0, 1.0))
    until(lambda: not live.moment.push.any())


def test_hand_is_let_go_when_the_viewer_leaves(stage: Stage) -> None:
    viewer, live = stage.viewer(), stage.simulation
    until(lambda: viewer.find("Pause"))
    viewer.drag("/arms/left_hand/grab", "start", (0.0, 3.0, 1.0))
    until(lambda: live.moment.push.any())
    viewer.close()
    until(lambda: not live.moment.push.any())


def test_other_arms_dance_beside_those_of_the_run(stage: Stage) -> None:
    viewer, live = stage.viewer(), stage.simulation
    viewer.set("kinematic arms", True)
    until(lambda: "/beside/left_hand" in viewer.positions)
    before = viewer.positions["/beside/left_hand"]
    until(lambda: not np.allclose(viewer.positions["/beside/left_hand"], before))
    viewer.set("kinematic arms", False)
    until(lambda: live.compared is None)
    removed = {"type": "RemoveSceneNodeMessage", "name": "/beside"}
    until(lambda: any(removed.items() <= message.items() for message in list(viewer.messages)))
    viewer.set("kinematic arms", True)
    until(lambda: live.compared is not None)


def test_ideal_arms_are_not_pushed_and_carry_nothing() -> None:
    with served(without_modules(EnvironmentOptions(arms="kinematic"))) as stage:
        viewer = stage.viewer()
        until(lambda: viewer.find("physics arms"))
        uuid = viewer.find("payload, kg")
        assert uuid is None or not viewer.widgets[uuid]["props"]["visible"]
        assert not any(str(m.get("name")).endswith("/grab") for m in list(viewer.messages))
        assert "λ" not in viewer.text()


def test_errors_are_shown_in_the_page_and_the_next_request_goes_on(stage: Stage) -> None:
    viewer, live = stage.viewer(), stage.simulation

    def fail() -> None:
        raise BadOptionError("<b>no</b>, another one")

    until(lambda: live.playing)
    live.request(fail)
    until(lambda: "&lt;b&gt;no&lt;/b&gt;, another one" in viewer.text())
    assert not live.playing
    late = stage.viewer()
    until(lambda: "another one" in late.text())
    viewer.set("move", "restart")
    until(lambda: "another one" not in viewer.text())
    live.request(fail)
    until(lambda: "another one" in viewer.text())
    viewer.set("Play", True)
    until(lambda: live.playing and "another one" not in viewer.text())


def test_labels_are_text_whatever_they_hold() -> None:
    label = "<img src=http://example.com/x.png>"
    motion = dataclasses.replace(ymca(), labels=(label, "M", "C", "A"))
    config = RunConfig(agent=FeedbackOnlyConfig(), agent_name="feedback_only")
    with served(LiveSimulation(EpisodeFactory(config, motion))) as stage:
        viewer = stage.viewer()
        until(lambda: "&lt;img" in viewer.text())
        assert "<img" not in viewer.text()


def test_latency_of_the_run_may_be_longer_than_by_hand() -> None:
    with served(without_modules(EnvironmentOptions(latency=15))) as stage:
        viewer = stage.viewer()
        until(lambda: viewer.find("kinematic arms"))
        assert viewer.value("latency, steps") == 15
        assert stage.simulation.error == ""


@pytest.mark.filterwarnings("ignore:ymca")
def test_a_robot_of_another_size_is_seen_as_our_own_arms() -> None:
    seen = {}
    for robot in ("two_arm", "cmu_humanoid"):
        with served(without_modules(EnvironmentOptions(robot=robot, repeats=1))) as stage:
            viewer = stage.viewer()
            until(lambda v=viewer: v.find("Pause"))
            places = [m for m in viewer.messages if m["type"] == "SetCameraPositionMessage"]
            middles = [m for m in viewer.messages if m["type"] == "SetCameraLookAtMessage"]
            physics = stage.simulation.episode.env.physics
            shoulders = physics.site_positions(np.zeros(12))[:, 0].mean(axis=0)
            seen[robot] = [
                (np.array(middles[-1]["look_at"]) - shoulders),
                (np.array(places[-1]["position"]) - middles[-1]["look_at"]),
            ]
            assert stage.simulation.error == ""
    np.testing.assert_allclose(seen["two_arm"][0], np.array(LOOK_AT) - [0.0, 0.0, 1.15], atol=1e-6)
    ratios = [np.linalg.norm(b) / np.linalg.norm(a) for a, b in zip(*seen.values(), strict=True)]
    assert ratios == pytest.approx([0.7291 / 0.7406] * 2, rel=1e-3)


@pytest.mark.filterwarnings("ignore:ymca")
def test_a_robot_whose_forces_are_unknown_has_ideal_arms_only(tmp_path: Path) -> None:
    text = (CATALOGUE / "cmu_humanoid.toml").read_text("utf-8")
    start = text.index("[force]")
    own = tmp_path / "own.toml"
    own.write_text(f'{text[:start]}[force]\nsource = "unknown"\n')
    env = EnvironmentOptions(arms="kinematic", robot=str(own), repeats=1)
    with served(without_modules(env)) as stage:
        viewer = stage.viewer()
        viewer.set("physics arms", True)
        until(lambda: "is unknown" in viewer.text())
        assert stage.simulation.compared is None


def test_page_has_no_button_to_share_it(stage: Stage) -> None:
    viewer = stage.viewer()
    until(lambda: viewer.find("Pause"))
    themes = [m for m in viewer.messages if m["type"] == "ThemeConfigurationMessage"]
    assert themes
    assert not any(theme["show_share_button"] for theme in themes)


def test_arms_are_lit_without_a_photograph_that_is_slow_to_draw(stage: Stage) -> None:
    viewer = stage.viewer()
    until(lambda: viewer.find("Pause"))
    surroundings = [m for m in viewer.messages if m["type"] == "EnvironmentMapMessage"]
    assert surroundings
    assert not any(m.get("hdri_data") or m.get("hdri") for m in surroundings)  # as in 1.1.1, 1.1.0
    assert any(m["type"] == "DirectionalLightMessage" for m in viewer.messages)


def test_closing_and_opening_pages_keeps_the_loop_going(stage: Stage) -> None:
    for _ in range(5):
        viewer = stage.viewer()
        until(lambda v=viewer: v.find("Pause"))
        viewer.close()
    until(lambda: stage.page.controls is None)
    before = len(stage.simulation.moments)
    time.sleep(0.3)
    assert len(stage.simulation.moments) != before
    assert stage.simulation.error == ""
