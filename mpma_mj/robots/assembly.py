"""Assembly of a robot's model for imitation: two arms of four joints, all else at rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.errors import BadOptionError, one_line
from mpma_mj.kinematics import SIDES
from mpma_mj.robots.arm_checks import check_joints, check_points, check_shoulders
from mpma_mj.robots.geometry import POINTS, arm_points, chains, torso_axes
from mpma_mj.robots.model_file import read_model_file
from mpma_mj.robots.robot import Robot
from mpma_mj.robots.scene import add_scene
from mpma_mj.robots.self_contact import exclude_touching
from mpma_mj.robots.surface import bodies_below, lowest_point, reach, seen_geoms
from mpma_mj.utils.input_files import file_problem

__all__ = ["HANDS", "assemble"]

Array = NDArray[np.float64]

HANDS = tuple(f"{side}_hand" for side in SIDES)
"""Bodies at the wrists, which carry the payload and that perturbations act on."""

_SITE = {"size": [0.01] * 3, "group": 4, "rgba": [1.0, 1.0, 1.0, 0.5]}

_REMOVED = (
    *("keys", "sensors", "actuators", "tendons", "equalities", "pairs", "tuples"),
    *("sites", "cameras", "lights"),
)
_HIDDEN = 3  # first group of geoms that is not drawn by default
_ABOVE_FLOOR = 0.05  # m, of hanging arms above the floor (choice)
_IF_IDEAL = {"force": 1.0, "armature": 0.01, "damping": 0.0, "kv": 1.0}
"""Values of ideal arms where they are unknown, which nothing depends on."""


def assemble(robot: Robot, *, ideal: bool = False) -> mujoco.MjSpec:
    """Return the model of a robot: an upright torso that looks along x, on the floor at z = 0.

    All joints but the eight of the arms are welded, at their angles of rest. The eight are moved by
    velocity actuators of their names; nothing else acts on them than what the robot's file says.
    Sites `left_shoulder` to `right_wrist` mark the points of the arms, bodies `left_hand` and
    `right_hand` their wrists. Planes of the world, which are floors, are left out; light, sky,
    floor, cameras and options are those of two_arm.xml, so that contacts are off. Where they are
    switched on, bodies that touch in plain poses do not touch.

    Args:
        robot: The robot; the model of a complete one is returned as it is.
        ideal: Whether the arms follow commands exactly, so that of the physical values only speeds
            have to be known.

    Raises:
        BadOptionError: The model cannot be read, does not fit the robot's file, or a physical value
            is unknown.
    """
    if robot.path != robot.model and (problem := file_problem(robot.model)):
        raise BadOptionError(f"{robot.path}: its model {robot.model}: {problem}")
    spec = read_model_file(robot.model)
    if robot.complete:
        return spec
    try:
        _build(robot, spec, ideal=ideal)
    except (ValueError, mujoco.FatalError) as error:
        if isinstance(error, BadOptionError):
            raise
        raise BadOptionError(f"{robot.model}: {one_line(error)}") from None
    return spec


def _build(robot: Robot, spec: mujoco.MjSpec, *, ideal: bool) -> None:
    """Change the model as `assemble` says."""
    spec.compiler.fusestatic = False  # on by default for URDF
    bare = spec.compile()
    check_joints(robot, bare)
    data = _at_rest(robot, bare)
    joints = [bare.joint(name).id for name in robot.joints]
    wrists = [bare.joint(name).id for name in robot.wrists] if robot.wrists else [None, None]
    points = np.stack(
        [arm_points(bare, data, joints[4 * i : 4 * i + 4], wrists[i]) for i in range(2)]
    )
    check_points(robot, points)
    check_shoulders(robot, data, joints, points)
    for kind in _REMOVED:
        for element in list(getattr(spec, kind)):
            spec.delete(element)
    for geom in list(spec.worldbody.geoms):
        if geom.type == mujoco.mjtGeom.mjGEOM_PLANE:
            spec.delete(geom)
    bodies = {body.id: body for body in spec.bodies}
    _hide_collision_shapes(bodies)
    _name_bodies(spec, bodies)
    _pose_bodies(robot, bare, data, bodies)
    _replace_joints(robot, spec, bare, data, bodies, joints)
    _add_actuators(robot, spec, ideal=ideal)
    _mark_points(bare, data, bodies, joints, points)
    _stand(robot, spec, bare, data, joints, points)
    model = spec.compile()
    try:
        arms = chains(model, robot.joints)
    except BadOptionError as error:
        raise error.with_context(robot.path) from None
    exclude_touching(spec, model, robot.joints, arms)


def _at_rest(robot: Robot, model: mujoco.MjModel) -> mujoco.MjData:
    """Return the pose in which the arms' joint angles are zero, and all others at rest."""
    data = mujoco.MjData(model)
    for name, angle in (*dict.fromkeys(robot.joints, 0.0).items(), *robot.rest.items()):
        data.qpos[model.joint(name).qposadr] = angle
    mujoco.mj_kinematics(model, data)
    return data


def _hide_collision_shapes(bodies: Mapping[int, Any]) -> None:
    """Hide what collides on bodies that have a mesh for looks alone, as drawing takes time."""
    for body in bodies.values():
        colliding = [geom for geom in body.geoms if geom.contype or geom.conaffinity]
        looks = any(
            geom.type == mujoco.mjtGeom.mjGEOM_MESH and geom not in colliding for geom in body.geoms
        )
        for geom in colliding if looks else ():
            geom.group = _HIDDEN


def _name_bodies(spec: mujoco.MjSpec, bodies: Mapping[int, Any]) -> None:
    """Give all bodies names, of which those of the hands are free."""
    for index, body in bodies.items():
        if body.name in HANDS:
            free = f"{body.name}_link"
            for exclude in spec.excludes:
                for key in ("bodyname1", "bodyname2"):
                    if getattr(exclude, key) == body.name:
                        setattr(exclude, key, free)
            body.name = free
        body.name = body.name or f"body_{index}"


def _pose_bodies(
    robot: Robot, bare: mujoco.MjModel, data: mujoco.MjData, bodies: Mapping[int, Any]
) -> None:
    """Turn bodies to where their joints at rest, and the zero of the arms' joints, put them."""
    named = [bare.joint(name) for name in (*robot.joints, *robot.rest)]
    moved = {int(j.bodyid[0]) for j in named if data.qpos[j.qposadr] != bare.qpos0[j.qposadr]}
    for index in moved:
        parent, body = int(bare.body_parentid[index]), bodies[index]
        inverse, turned = np.empty(4), np.empty(4)
        mujoco.mju_negQuat(inverse, data.xquat[parent])
        mujoco.mju_mulQuat(turned, inverse, data.xquat[index])
        body.pos = _in_body(data, parent, data.xpos[index])
        body.quat, body.alt.type = turned, mujoco.mjtOrientation.mjORIENTATION_QUAT
        if body.frame is not None:
            body.set_frame(bodies[parent].add_frame())


def _replace_joints(
    robot: Robot,
    spec: mujoco.MjSpec,
    bare: mujoco.MjModel,
    data: mujoco.MjData,
    bodies: Mapping[int, Any],
    joints: Sequence[int],
) -> None:
    """Replace the joints of the arms by plain ones of the same axes and ranges; delete all others.

    Plain ones have neither springs nor friction nor limits of force.
    """
    empty = mujoco.MjSpec()  # whose defaults are MuJoCo's, not the robot's own
    for index in joints:
        name, body = bare.joint(index).name, int(bare.jnt_bodyid[index])
        old = spec.joint(name)
        limited, limits = old.limited, old.range.copy()
        if own := robot.ranges.get(name):
            limited, limits = True, np.degrees(own) if spec.compiler.degree else np.array(own)
        spec.delete(old)
        bodies[body].add_joint(
            empty.default,
            name=name,
            type=mujoco.mjtJoint.mjJNT_HINGE,
            pos=_in_body(data, body, data.xanchor[index]),
            axis=data.xmat[body].reshape(3, 3).T @ data.xaxis[index],
            limited=limited,
            range=limits,
        )
    kept = {bare.joint(index).name for index in joints}
    for joint in list(spec.joints):
        if joint.name not in kept:
            spec.delete(joint)
    for body in bodies.values():
        body.gravcomp = 0.0


def _add_actuators(robot: Robot, spec: mujoco.MjSpec, *, ideal: bool) -> None:
    """Add velocity actuators of the joints' names, with the physical values of the robot."""
    empty, speed = mujoco.MjSpec(), robot.values("speed")
    force, armature, damping, kv = (
        robot.values(quantity, otherwise if ideal else None)
        for quantity, otherwise in _IF_IDEAL.items()
    )
    for index, name in enumerate(robot.joints):
        joint = spec.joint(name)
        joint.armature, joint.damping = armature[index], [damping[index], 0.0, 0.0]
        actuator = spec.add_actuator(
            empty.default, name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT
        )
        actuator.set_to_velocity(kv=kv[index])
        actuator.ctrllimited, actuator.ctrlrange = True, [-speed[index], speed[index]]
        actuator.forcelimited, actuator.forcerange = True, [-force[index], force[index]]


def _mark_points(
    bare: mujoco.MjModel,
    data: mujoco.MjData,
    bodies: Mapping[int, Any],
    joints: Sequence[int],
    points: Array,
) -> None:
    """Add sites at the points of the arms, and bodies at the wrists."""
    empty = mujoco.MjSpec()
    for arm, side in enumerate(SIDES):
        for point, place, joint in zip(POINTS, points[arm], (2, 3, 3), strict=True):
            body = int(bare.jnt_bodyid[joints[4 * arm + joint]])
            inside = _in_body(data, body, place)
            bodies[body].add_site(empty.default, name=f"{side}_{point}", pos=inside, **_SITE)
        hand = bodies[body].add_body(name=f"{side}_hand", pos=inside)
        hand.explicitinertial, hand.ipos = True, np.zeros(3)  # by default ipos would be pos


def _stand(
    robot: Robot,
    spec: mujoco.MjSpec,
    bare: mujoco.MjModel,
    data: mujoco.MjData,
    joints: Sequence[int],
    points: Array,
) -> None:
    """Turn the robot upright, set it on the floor, and add the scene."""
    axes = torso_axes(points, robot.up)
    middle, (_, _, up) = points[:, 0].mean(axis=0), axes
    arms = [bodies_below(bare, int(bare.jnt_bodyid[joint])) for joint in joints[::4]]
    lengths = [
        np.linalg.norm(elbow - shoulder)
        + max(
            reach(bare, data, seen_geoms(bare, int(bare.jnt_bodyid[joint])), elbow),
            float(np.linalg.norm(wrist - elbow)),  # of arms of which nothing is seen
        )
        for (shoulder, elbow, wrist), joint in zip(points, joints[3::4], strict=True)
    ]
    fixed = [g for g in seen_geoms(bare) if int(bare.geom_bodyid[g]) not in arms[0] + arms[1]]
    floor = min(
        lowest_point(bare, data, fixed, up), float(middle @ up - max(lengths)) - _ABOVE_FLOOR
    )
    place = np.array([0.0, 0.0, float(middle @ up) - floor])
    turn = np.empty(4)
    mujoco.mju_mat2Quat(turn, axes.ravel())
    frame = spec.worldbody.add_frame(pos=place - axes @ middle, quat=turn)
    for element in (*spec.worldbody.bodies, *spec.worldbody.geoms, *spec.worldbody.frames):
        if element.frame is None and element is not frame:
            element.set_frame(frame)
    apart = float(np.linalg.norm(points[0, 0] - points[1, 0]))
    add_scene(spec, place, apart / 2.0 + float(max(lengths)))


def _in_body(data: mujoco.MjData, body: int, point: Array) -> Array:
    """Return a point of the world frame in the frame of a body, shape (3,), m."""
    return data.xmat[body].reshape(3, 3).T @ (point - data.xpos[body])
