"""What the parameters change in a model, in memory and on file."""

from pathlib import Path

import hypothesis
import mujoco
import numpy as np
import pytest
from hypothesis import strategies

import mpma_mj
from mpma_mj.envs.model import MODEL_PATH, make_model
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import RunFolderError
from mpma_mj.sysid import RobotLog, write_model
from mpma_mj.sysid.parameters import UNITS, changed, values
from mpma_mj.sysid.simulate import FeatureReplay, threads
from tests.sysid.conftest import LATENCY, perturbed

MODEL = make_model(EnvironmentOptions())
FIELDS = ("actuator_gainprm", "actuator_biasprm", "dof_damping", "dof_armature", "body_mass")
FIELDS += ("body_inertia", "body_subtreemass", "dof_invweight0", "body_ipos", "actuator_forcerange")


@hypothesis.given(
    strategies.fixed_dictionaries({name: strategies.floats(0.3, 3.0) for name in UNITS})
)
@hypothesis.settings(max_examples=10)
def test_values_are_multiplied_and_the_model_stays_as_it_is(factors: dict[str, float]) -> None:
    before = values(MODEL)
    after = values(changed(MODEL, factors))
    for name in UNITS:
        assert np.allclose(after[name], factors[name] * before[name], rtol=1e-12)
        assert np.array_equal(values(MODEL)[name], before[name])


def test_masses_are_those_of_the_arms_and_no_others() -> None:
    masses = values(MODEL)
    assert masses["upper_arm_mass"] == pytest.approx(1.9783)
    assert masses["forearm_mass"] == pytest.approx(1.1826 + 0.4453)
    heavier = changed(MODEL, {"upper_arm_mass": 2.0, "forearm_mass": 2.0})
    assert heavier.body("torso").mass == MODEL.body("torso").mass
    assert heavier.body("left_hand").inertia == pytest.approx(2.0 * MODEL.body("left_hand").inertia)


def test_a_common_factor_on_all_parameters_and_forces_changes_no_movement(log: RobotLog) -> None:
    # So a log in which no actuator reaches its greatest force does not show the common factor.
    double = changed(MODEL, dict.fromkeys(UNITS, 2.0))
    begins = np.array([10])
    with threads() as pool:
        replay = FeatureReplay(pool, MODEL, log, begins, length=40, steps=10)
        weak, _ = replay.simulate(double, 0)
        double.actuator_forcerange *= 2.0
        strong, _ = replay.simulate(double, 0)
        plain, _ = replay.simulate(MODEL, 0)
    assert np.abs(strong - plain).max() < 1e-9
    assert np.abs(weak - plain).max() > 0.1  # forces are reached here


def test_the_true_parameters_replay_a_log_exactly(log: RobotLog, factors: dict[str, float]) -> None:
    begins = np.array([10, 30])
    with threads() as pool:
        replay = FeatureReplay(pool, MODEL, log, begins, length=20, steps=10)
        exact = replay.simulate(changed(MODEL, factors), 10 * LATENCY)
        late, _ = replay.simulate(changed(MODEL, factors), 10 * LATENCY + 1)
    for simulated, measured in zip(exact, replay.measured(), strict=True):
        assert np.abs(simulated - measured).max() < 1e-3  # of numbers with six digits on file
    assert np.abs(late - replay.measured()[0]).max() > 0.01


def assert_same(one: mujoco.MjModel, other: mujoco.MjModel) -> None:
    for field in FIELDS:
        assert np.allclose(getattr(one, field), getattr(other, field), rtol=2e-5, atol=1e-9), field


def test_a_written_model_is_that_in_memory_and_can_be_danced_with(tmp_path: Path) -> None:
    factors = perturbed(1)
    write_model(tmp_path / "a.xml", factors)
    assert_same(make_model(EnvironmentOptions(model=tmp_path / "a.xml")), changed(MODEL, factors))
    env = mpma_mj.load(
        "ymca", model=tmp_path / "a.xml", latency=2, actuator_strength=2.0, payload=1.0
    )
    env.reset()
    assert np.isfinite(env.step(np.ones(8)).observation["posture"]).all()


def test_a_written_model_without_factors_is_the_base(tmp_path: Path) -> None:
    write_model(tmp_path / "a.xml", {})
    assert_same(make_model(EnvironmentOptions(model=tmp_path / "a.xml")), MODEL)


def test_a_model_may_have_a_name_and_a_folder_that_are_not_utf8(tmp_path: Path) -> None:
    factors = perturbed(1)
    written = tmp_path / "robots\udcff" / "a\udcff.xml"
    write_model(written, factors)
    assert_same(make_model(EnvironmentOptions(model=written)), changed(MODEL, factors))
    for copy in ("b.xml", "c.xml"):  # the second holds the folder of the first
        write_model(tmp_path / copy, {}, written)
        written = tmp_path / "robots\udcff" / copy
        (tmp_path / copy).rename(written)
        assert_same(make_model(EnvironmentOptions(model=written)), changed(MODEL, factors))


def test_a_model_that_cannot_be_written_is_an_error_of_its_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(spec: mujoco.MjSpec, path: bytes) -> None:
        raise mujoco.FatalError("Error writing resource")

    monkeypatch.setattr(mujoco.MjSpec, "to_file", full)
    with pytest.raises(RunFolderError, match=r"a\.xml: cannot be written \(Error writing"):
        write_model(tmp_path / "a.xml", {})
    assert list(tmp_path.iterdir()) == []


def test_masses_from_geoms_and_meshes_in_folders_are_kept(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    corners = ((0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1))
    faces = ((1, 3, 2), (1, 2, 4), (1, 4, 3), (2, 3, 4))
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {a} {b} {c}" for a, b, c in faces]
    (tmp_path / "meshes" / "plate.obj").write_text("\n".join(lines))
    text = MODEL_PATH.read_text().replace('inertiafromgeom="false"', 'inertiafromgeom="true"')
    text = text.replace("<compiler ", '<compiler meshdir="meshes" ')
    text = text.replace("<asset>", '<asset><mesh name="plate" file="plate.obj"/>')
    text = text.replace(
        '<geom name="left_hand" ', '<geom type="mesh" mesh="plate"/><geom name="left_hand" '
    )
    base = tmp_path / "base.xml"
    base.write_text(text)
    written = tmp_path / "elsewhere" / "a.xml"
    write_model(written, {"forearm_mass": 1.2}, base)
    expected = changed(make_model(EnvironmentOptions(model=base)), {"forearm_mass": 1.2})
    assert expected.body("torso").mass != MODEL.body("torso").mass  # from geoms
    assert_same(make_model(EnvironmentOptions(model=written)), expected)


def test_joints_in_bodies_of_their_own_belong_to_the_upper_arm() -> None:
    spec = mujoco.MjSpec.from_file(str(MODEL_PATH))
    for side in ("left", "right"):
        bone = spec.body(f"{side}_upper_arm").add_body(name=f"{side}_bone", mass=0.5)
        bone.inertia, bone.explicitinertial = np.full(3, 1e-3), True
    assert values(spec.compile())["upper_arm_mass"] == pytest.approx(1.9783 + 0.5)
