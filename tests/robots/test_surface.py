"""Surfaces of geoms: their lowest and farthest points."""

import mujoco
import numpy as np
import pytest

from mpma_mj.robots.surface import (
    bodies_below,
    lowest_point,
    middle_of_farthest,
    reach,
    seen_geoms,
)

TURN = "euler='0.4 0.9 0'"


def model(body: str) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Return a model of bodies in the world, and its simulation."""
    text = f"<mujoco><compiler angle='radian'/><worldbody>{body}</worldbody></mujoco>"
    made = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(made)
    mujoco.mj_kinematics(made, data)
    return made, data


@pytest.mark.parametrize(
    ("geom", "half_height"),
    [
        ("type='sphere' size='0.3'", 0.3),
        ("type='capsule' size='0.1 0.5'", 0.6),
        ("type='capsule' size='0.1 0.5' zaxis='1 0 1'", 0.1 + 0.5 * np.sqrt(0.5)),
        ("type='cylinder' size='0.3 0.4' zaxis='0 1 1'", 0.7 * np.sqrt(0.5)),
        ("type='cylinder' size='0.3 0.4'", 0.4),
        ("type='box' size='0.1 0.2 0.3' axisangle='1 0 0 0.7853981633974483'", 0.5 * np.sqrt(0.5)),
        ("type='ellipsoid' size='0.1 0.1 0.3' zaxis='1 0 1'", np.sqrt((0.01 + 0.09) / 2.0)),
    ],
)
def test_the_lowest_point_is_exact(geom: str, half_height: float) -> None:
    made, data = model(f"<geom {geom} pos='0 0 2'/>")
    up = np.array([0.0, 0.0, 1.0])
    assert lowest_point(made, data, [0], up) == pytest.approx(2.0 - half_height, abs=1e-6)


def test_the_lowest_vertex_of_a_mesh_counts() -> None:
    made, data = model("<geom type='plane' size='1 1 1'/>")
    assert lowest_point(made, data, [0], np.array([0.0, 0.0, 1.0])) == np.inf
    text = (
        "<mujoco><asset><mesh name='m' vertex='0 0 0 1 0 0 0 1 0 0 0 1' scale='1 1 2'/></asset>"
        "<worldbody><geom type='mesh' mesh='m' euler='180 0 0' pos='0 0 1'/></worldbody></mujoco>"
    )
    made = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(made)
    mujoco.mj_kinematics(made, data)
    assert lowest_point(made, data, [0], np.array([0.0, 0.0, 1.0])) == pytest.approx(-1.0)


def test_the_farthest_end_of_a_limb_is_found() -> None:
    made, data = model("<geom type='capsule' size='0.05' fromto='0 0 0 0.6 0 0'/>")
    end = middle_of_farthest(made, data, [0], np.zeros(3))
    assert end[0] == pytest.approx(0.62, abs=0.02)
    np.testing.assert_allclose(end[1:], 0.0, atol=0.005)
    assert reach(made, data, [0], np.zeros(3)) == pytest.approx(0.65, abs=0.001)


def test_where_nothing_is_there_is_no_end() -> None:
    made, data = model("<body/>")
    assert middle_of_farthest(made, data, [], np.ones(3)).tolist() == [1.0, 1.0, 1.0]
    assert reach(made, data, [], np.ones(3)) == 0.0


def test_what_is_hidden_or_transparent_is_not_seen() -> None:
    shown = "<geom name='shown' size='1'/>"
    hidden = "<geom name='hidden' size='1' group='3'/><geom name='clear' size='1' rgba='1 1 1 0'/>"
    made, _ = model(f"<body name='a'>{hidden}<body name='b'>{shown}</body></body>")
    assert [made.geom(geom).name for geom in seen_geoms(made)] == ["shown"]
    made, _ = model(f"<body name='a'>{hidden}</body>{shown}")
    below = seen_geoms(made, below=made.body("a").id)
    assert [made.geom(geom).name for geom in below] == ["hidden", "clear"]


def test_bodies_below_are_those_that_hang_on_one() -> None:
    made, _ = model("<body name='a'><body name='b'><body name='c'/></body></body><body name='d'/>")
    names = [made.body(body).name for body in bodies_below(made, made.body("a").id)]
    assert names == ["a", "b", "c"]
