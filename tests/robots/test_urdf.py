"""URDF files as makers write them: what MuJoCo refuses of them, and arms do without."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from mpma_mj.robots.model_file import read_model_file
from mpma_mj.robots.scene import TWO_ARM_MODEL
from mpma_mj.robots.urdf import mend_urdf, unread_meshes
from tests.robots.figures import urdf_figure

BALL = '<geometry><sphere radius="0.03"/></geometry>'
MESH = '<geometry><mesh filename="forearm.dae"/></geometry>'


def read(folder: Path, text: str) -> mujoco.MjSpec:
    path = folder / "my.urdf"
    path.write_text(text)
    return read_model_file(path)


def test_a_urdf_that_is_as_it_should_be_stays_so(tmp_path: Path) -> None:
    spec = read(tmp_path, urdf_figure(visible=BALL))
    spec.compiler.fusestatic = False
    model = spec.compile()
    assert model.ngeom == 3
    np.testing.assert_allclose(model.body("left_elbow_link").inertia, 0.01)
    assert model.body("left_elbow_link").mass == pytest.approx(1.0)


def test_links_of_no_mass_get_next_to_none(tmp_path: Path) -> None:
    model = read(tmp_path, urdf_figure(mass=0.0)).compile()
    assert 0.0 < model.body("left_roll_link").mass[0] < 1e-5


def test_meshes_that_mujoco_does_not_read_are_left_out(tmp_path: Path) -> None:
    spec = read(tmp_path, urdf_figure(visible=MESH))
    assert (len(spec.meshes), len(spec.geoms)) == (0, 1)
    spec.compile()
    assert unread_meshes(tmp_path / "my.urdf") == ("forearm.dae",)
    assert unread_meshes(TWO_ARM_MODEL) == ()


def test_mending_twice_is_mending_once(tmp_path: Path) -> None:
    spec = read(tmp_path, urdf_figure(mass=0.0))
    once = spec.to_xml()
    mend_urdf(spec)
    assert spec.to_xml() == once
