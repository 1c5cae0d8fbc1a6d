"""Models with other parameters on file."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

import mpma_mj
from mpma_mj.envs.model import make_model
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.errors import RunFolderError
from mpma_mj.robots.robot_file import read_robot
from mpma_mj.sysid import write_model
from mpma_mj.sysid.parameters import scaled
from tests.sysid.conftest import perturbed

MODEL = make_model(EnvironmentOptions())
FIELDS = ("actuator_gainprm", "actuator_biasprm", "dof_damping", "dof_armature", "body_mass")
FIELDS += ("body_inertia", "body_subtreemass", "dof_invweight0", "body_ipos", "actuator_forcerange")


def assert_same(one: mujoco.MjModel, other: mujoco.MjModel) -> None:
    for field in FIELDS:
        assert np.allclose(getattr(one, field), getattr(other, field), rtol=2e-5, atol=1e-9), field


def test_a_written_model_is_that_in_memory_and_can_be_danced_with(tmp_path: Path) -> None:
    factors = perturbed(1)
    write_model(tmp_path / "a.xml", factors)
    assert_same(make_model(EnvironmentOptions(robot=tmp_path / "a.xml")), scaled(MODEL, factors))
    env = mpma_mj.load(
        "ymca", robot=tmp_path / "a.xml", latency=2, actuator_strength=2.0, payload=1.0
    )
    env.reset()
    assert np.isfinite(env.step(np.ones(8)).observation["posture"]).all()


def test_a_written_model_without_factors_is_the_base(tmp_path: Path) -> None:
    write_model(tmp_path / "a.xml", {})
    assert_same(make_model(EnvironmentOptions(robot=tmp_path / "a.xml")), MODEL)


def test_a_model_may_have_a_name_and_a_folder_that_are_not_utf8(tmp_path: Path) -> None:
    factors = perturbed(1)
    written = tmp_path / "robots\udcff" / "a\udcff.xml"
    write_model(written, factors)
    assert_same(make_model(EnvironmentOptions(robot=written)), scaled(MODEL, factors))
    for copy in ("b.xml", "c.xml"):  # the second holds the folder of the first
        write_model(tmp_path / copy, {}, written)
        written = tmp_path / "robots\udcff" / copy
        (tmp_path / copy).rename(written)
        assert_same(make_model(EnvironmentOptions(robot=written)), scaled(MODEL, factors))


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
    text = (
        read_robot("two_arm")
        .model.read_text()
        .replace('inertiafromgeom="false"', 'inertiafromgeom="true"')
    )
    text = text.replace("<compiler ", '<compiler meshdir="meshes" ')
    text = text.replace("<asset>", '<asset><mesh name="plate" file="plate.obj"/>')
    text = text.replace(
        '<geom name="left_hand" ', '<geom type="mesh" mesh="plate"/><geom name="left_hand" '
    )
    base = tmp_path / "base.xml"
    base.write_text(text)
    written = tmp_path / "elsewhere" / "a.xml"
    write_model(written, {"forearm_mass": 1.2}, base)
    expected = scaled(make_model(EnvironmentOptions(robot=base)), {"forearm_mass": 1.2})
    assert expected.body("torso").mass != MODEL.body("torso").mass  # from geoms
    assert_same(make_model(EnvironmentOptions(robot=written)), expected)
