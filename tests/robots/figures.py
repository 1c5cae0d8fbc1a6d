"""Figures of boxes and hinges, in which arms are looked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mujoco

__all__ = ["ARM", "compile_figure", "figure", "names", "urdf_figure"]

ARM = {"pitch": "0 1 0", "roll": "1 0 0", "yaw": "0 0 1", "elbow": "0 1 0"}
"""Joints of an arm from the shoulder outward, with their axes."""

_LEG = {"hip_yaw": "0 0 1", "hip_roll": "1 0 0", "hip_pitch": "0 1 0", "knee": "0 1 0"}
_RANGES = {"elbow": "-2.5 .1", "knee": "0 2"}
_BALL = '<geom type="sphere" size=".03"/>'

Link = tuple[str, str, str, str]
"""Place of a body, and name, axis and range of its joint."""


def names(side: str, form: str = "{side}_{joint}", joints: Sequence[str] = tuple(ARM)) -> list[str]:
    """Return the names of joints of one side."""
    return [form.format(side=side, s=side[0], joint=joint) for joint in joints]


def figure(
    *,
    form: str = "{side}_{joint}",
    arms: Sequence[str] = ("left", "right"),
    arm: Mapping[str, str] = ARM,
    lengths: tuple[float, float] = (0.3, 0.25),
    offset: float = 0.0,
    waist: int = 1,
    wrist: Sequence[str] = ("1 0 0",),
    fingers: int = 0,
    legs: bool = True,
    ranges: Mapping[str, str] | None = None,
    frame: str = "",
) -> str:
    """Return the MJCF of a figure that looks along x and hangs its arms.

    Args:
        form: Form of the names of joints, of side, s (its first letter) and joint.
        arms: Sides of the arms, in the model's order.
        arm: Joints of an arm with their axes; the last one is an upper arm further out.
        lengths: Lengths of upper arm and forearm, m.
        offset: By how much the axes of a shoulder miss one another, m.
        waist: Number of hinges of the waist.
        wrist: Axes of hinges at the wrist.
        fingers: Number of fingers of two hinges each.
        legs: Whether there are legs.
        ranges: Ranges of joints of an arm, as they are written.
        frame: Attributes of a frame around the figure.
    """
    allowed = _RANGES | dict(ranges or {})
    text = ""
    for side in arms:
        y = 1.0 if side == "left" else -1.0
        places = [f"0 {0.2 * y} 0", *[f"{offset} {offset * y} 0"] * (len(arm) - 2)]
        shoulder_to_elbow = _links(
            side, form, arm, [*places, f"0 0 -{lengths[0]}"], "-3 3", allowed
        )
        hand = _links(
            side,
            form,
            {f"wrist{number}": axis for number, axis in enumerate(wrist)},
            [f"0 0 -{lengths[1]}", *["0 0 0"] * len(wrist)],
            "-1 1",
            allowed,
        )
        inner = _BALL
        for number in range(fingers):
            joints = {f"finger{number}_knuckle": "0 1 0", f"finger{number}_tip": "0 1 0"}
            places = [f"{0.02 * number} 0 -.05", "0 0 -.03"]
            inner += _nested(_links(side, form, joints, places, "0 1", allowed), _BALL)
        forearm = f'<geom type="capsule" size=".03" fromto="0 0 0 0 0 -{lengths[1]}"/>'
        text += _nested(shoulder_to_elbow, forearm + _nested(hand, inner))
    axes = ("0 0 1", "0 1 0", "1 0 0")
    text = _nested([("0 0 0", f"waist{i}", axes[i % 3], "-1 1") for i in range(waist)], text)
    for side, y in (("left", 0.1), ("right", -0.1)) if legs else ():
        places = [f"0 {y} -.5", "0 0 -.01", "0 0 -.01", "0 0 -.4"]
        shank = '<geom type="box" size=".05 .05 .4" pos="0 0 -.4"/>'
        text += _nested(_links(side, form, _LEG, places, "-1 1", _RANGES), shank)
    return (
        f'<mujoco><compiler angle="radian"/><worldbody><frame {frame}><body pos="0 0 1">'
        f'<freejoint/><geom type="box" size=".1 .15 .25" pos="0 0 -.25"/>{text}</body></frame>'
        "</worldbody></mujoco>"
    )


def compile_figure(**options: object) -> mujoco.MjModel:
    """Return the compiled figure."""
    return mujoco.MjModel.from_xml_string(figure(**options))  # type: ignore[arg-type]


def urdf_figure(
    limit: str = 'velocity="3" effort="20"', visible: str = "", mass: float = 1.0
) -> str:
    """Return a URDF of two arms on a box.

    Args:
        limit: Attributes of <limit> of all joints, besides their ranges.
        visible: What is added to the forearms.
        mass: Mass of the links, kg; their inertia is in proportion.
    """
    text = _urdf_link("base", 10.0, '<geometry><box size=".2 .3 .5"/></geometry>')
    for side, y in (("left", 0.2), ("right", -0.2)):
        places = [f"0 {y} .3", "0 0 0", "0 0 0", "0 0 -.3", "0 0 -.25"]
        parent = "base"
        for (joint, axis), place in zip({**ARM, "wrist": "1 0 0"}.items(), places, strict=True):
            name = f"{side}_{joint}"
            low, high = _RANGES.get(joint, "-3 3").split()
            shape = visible if joint == "elbow" else ""
            text += _urdf_link(f"{name}_link", mass, shape)
            text += (
                f'<joint name="{name}" type="revolute"><parent link="{parent}"/>'
                f'<child link="{name}_link"/><origin xyz="{place}"/><axis xyz="{axis}"/>'
                f'<limit lower="{low}" upper="{high}" {limit}/></joint>'
            )
            parent = f"{name}_link"
    return f'<robot name="figure">{text}</robot>'


def _urdf_link(name: str, mass: float, shape: str) -> str:
    moments = " ".join(f'i{axis}="{0.01 * mass}"' for axis in ("xx", "yy", "zz"))
    rest = 'ixy="0" ixz="0" iyz="0"'
    inertial = f'<inertial><mass value="{mass}"/><inertia {moments} {rest}/></inertial>'
    collision = f"<collision>{shape}</collision>" if shape else ""
    return f'<link name="{name}">{inertial}{collision}</link>'


def _links(
    side: str,
    form: str,
    joints: Mapping[str, str],
    places: Sequence[str],
    usual: str,
    ranges: Mapping[str, str],
) -> list[Link]:
    found = names(side, form, list(joints))
    return [
        (place, name, axis, ranges.get(joint, usual))
        for place, name, (joint, axis) in zip(places, found, joints.items(), strict=False)
    ]


def _nested(links: Sequence[Link], inner: str) -> str:
    """Return bodies in one another, each with a joint, around what is in the last."""
    for place, name, axis, allowed in reversed(links):
        joint = f'<joint name="{name}" axis="{axis}" range="{allowed}"/>'
        inner = f'<body pos="{place}">{joint}{_BALL}{inner}</body>'
    return inner
