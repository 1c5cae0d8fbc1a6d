"""Meshes of geoms: surfaces by their volume."""

import math

import mujoco
import numpy as np
import pytest

from mpma_mj.visualization.meshes import geom_mesh, limb_mesh

SHAPES = {
    '<geom type="sphere" size="0.3"/>': 4 / 3 * math.pi * 0.3**3,
    '<geom type="ellipsoid" size="0.1 0.2 0.4"/>': 4 / 3 * math.pi * 0.1 * 0.2 * 0.4,
    '<geom type="capsule" size="0.1 0.5"/>': math.pi * 0.1**2 * (1.0 + 4 / 3 * 0.1),
    '<geom type="cylinder" size="0.2 0.5"/>': math.pi * 0.2**2 * 1.0,
    '<geom type="box" size="0.1 0.2 0.3"/>': 8 * 0.1 * 0.2 * 0.3,
    '<geom type="mesh" mesh="corner"/>': 1 / 6,
}


def compiled(body: str) -> mujoco.MjModel:
    corner = '<mesh name="corner" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>'
    xml = f"<mujoco><asset>{corner}</asset><worldbody>{body}</worldbody></mujoco>"
    return mujoco.MjModel.from_xml_string(xml)


@pytest.mark.parametrize("geom", SHAPES)
def test_a_surface_encloses_the_shapes_volume_with_its_faces_outward(geom: str) -> None:
    vertices, faces = geom_mesh(compiled(geom), 0)
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    volume = np.sum(a * np.cross(b, c)) / 6.0
    assert volume == pytest.approx(SHAPES[geom], rel=0.05)


def test_a_plane_faces_up_and_a_height_field_is_left_out() -> None:
    vertices, _ = geom_mesh(compiled('<geom type="plane" size="0 2 1"/>'), 0)
    np.testing.assert_allclose(np.ptp(vertices, axis=0), [10.0, 4.0, 0.0], atol=1e-3)
    field = (
        '<mujoco><asset><hfield name="f" nrow="2" ncol="2" size="1 1 1 1"/></asset><worldbody>'
        '<geom type="hfield" hfield="f"/></worldbody></mujoco>'
    )
    assert geom_mesh(mujoco.MjModel.from_xml_string(field), 0) is None


def test_a_limb_ends_in_a_sphere() -> None:
    vertices, _ = limb_mesh(0.3)
    assert np.linalg.norm(vertices - [0.0, 0.0, 0.3], axis=1).min() == pytest.approx(0.058)
    assert vertices[:, 2].min() == 0.0
