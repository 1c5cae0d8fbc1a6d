"""Command `mpma robot`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from mpma_mj.commands.folders import check_new_file
from mpma_mj.envs.gl import require_backend
from mpma_mj.errors import BadOptionError

if TYPE_CHECKING:
    from mpma_mj.robots.new_robot import NewRobot
    from mpma_mj.robots.report import RobotReport

__all__ = ["DescribeRobot"]

_UNEQUAL = 0.05  # share of postures by which arms that are mirror images may differ (choice)
_ROBOT = ".toml"
_MODELS = (".xml", ".mjcf", ".urdf")
_JOINTS = tyro.conf.arg(metavar="JOINT JOINT JOINT JOINT")


@dataclass(frozen=True)
class DescribeRobot:
    """Find the two arms of a robot's model, write its robot file, and draw it in plain poses.

    Such as mpma robot my_robot.urdf; a name of the catalogue, or a robot file, is drawn only.
    """

    robot: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="MODEL|ROBOT")]
    """MJCF or URDF file; or a robot file (.toml), or a robot of the catalogue, such as h1."""
    left: Annotated[tuple[str, ...], _JOINTS] = ()
    """Joints of the left arm, from the shoulder outward; found if not given."""
    right: Annotated[tuple[str, ...], _JOINTS] = ()
    """Joints of the right arm."""
    wrist: Annotated[tuple[str, ...], tyro.conf.arg(metavar="{LEFT RIGHT}|tip")] = ()
    """Joints at the ends of the forearms; or tip, where they end with what is farthest from the
    elbow; found if not given."""
    up: Literal["x", "-x", "y", "-y", "z", "-z"] | None = None
    """Direction from pelvis to head in the model's frame; guessed if not given."""
    name: str | None = None
    """Name of the robot; that of the model's file if not given."""
    out: Path | None = None
    """Robot file, .toml; NAME.toml if not given."""
    picture: bool = True
    """Draw T-pose, arms down, up and forward next to the robot file, as NAME-poses.png."""
    overwrite: bool = False
    """Replace the robot file if it exists."""

    def run(self) -> str:
        """Describe the robot and return the command to go on with."""
        from mpma_mj.robots.robot_file import catalogue, write_robot
        from mpma_mj.utils.text import printable, shell_word

        path = Path(self.robot)
        is_model = path.suffix.lower() in _MODELS or (path.is_file() and path.suffix != _ROBOT)
        is_robot = self.robot in catalogue() or not is_model
        name = self._name(is_robot=is_robot)
        out = path if path.suffix == _ROBOT else self.out or Path(f"{name}.toml")
        if not is_robot:
            check_new_file("out", out, (_ROBOT,), overwrite=self.overwrite)
        picture = out.with_name(f"{out.stem}-poses.png") if self.picture else None
        if picture is not None:
            require_backend()
        new, report = self._described(name, is_robot=is_robot)
        print("\n".join(map(printable, _lines(new, report))))
        if picture is not None:
            _draw(picture, report)
            print(printable(f"{'picture':<10}{picture}"))
        if is_robot:
            return _next(self.robot, self.robot, report)
        write_robot(out, new.robot, new.comments)
        print(printable(f"{'file':<10}{out}"))
        return _next(shell_word(out), out, report)

    def _name(self, *, is_robot: bool) -> str:
        """Return the name of the robot; raises a BadOptionError for options that do not apply."""
        from mpma_mj.robots.robot_file import NAME, robot_name

        if is_robot:
            for option in ("left", "right", "wrist", "up", "name", "out"):
                if getattr(self, option):
                    problem = "is for a model; a robot file says it itself"
                    raise BadOptionError(f"{problem}, so change it there", option=option)
            return Path(self.robot).stem
        if self.name is not None and not NAME.fullmatch(self.name):
            expected = "letters, digits, _ and -"
            raise BadOptionError(option="name", value=self.name, expected=expected)
        return self.name or robot_name(Path(self.robot))

    def _described(self, name: str, *, is_robot: bool) -> tuple[NewRobot, RobotReport]:
        from mpma_mj.robots.new_robot import NewRobot, describe_model
        from mpma_mj.robots.report import RobotReport
        from mpma_mj.robots.robot_file import read_robot
        from mpma_mj.robots.torso_guess import UPS

        if is_robot:
            new = NewRobot(read_robot(self.robot))
        else:
            new = describe_model(
                Path(self.robot),
                name=name,
                left=self.left,
                right=self.right,
                wrist=self.wrist,
                up=None if self.up is None else UPS[self.up],
            )
        return new, RobotReport(new.robot)


def _lines(new: NewRobot, report: RobotReport) -> list[str]:
    """Return what is known of a robot, as lines of text."""
    from mpma_mj.motions import ymca
    from mpma_mj.robots.reachability import REACHED, both_arms

    lines = report.lines()
    if new.guesses:
        lines.insert(1, f"{'guessed':<10}{'; '.join(new.guesses)}")
    shares = [report.reachable(postures) for postures in (ymca().posture, both_arms())]
    of_ymca, of_people = (f"{50 * (left + right):.0f} %" for left, right in shares)
    lines.append(
        f"{'reachable':<10}{of_ymca} of the postures of ymca and {of_people} of others of people,"
        f" within {REACHED:g}°"
    )
    left, right = shares[1]  # the same for mirror images
    if abs(left - right) > _UNEQUAL:
        lines.append(
            f"{'':<10}left {100 * left:.0f} %, right {100 * right:.0f} % of these others: where the"
            " model's ranges are not mirrored, give [model.range] in the robot file"
        )
    if new.unread:
        endings = ", ".join(sorted({Path(file).suffix for file in new.unread}))
        lines.append(
            f"{'meshes':<10}{len(new.unread)} left out, as MuJoCo does not read {endings}; as"
            " .obj or .stl they are seen"
        )
    return [*lines, *report.physical_lines(new.comments)]


def _draw(path: Path, report: RobotReport) -> None:
    from mpma_mj.visualization.robot_poses import write_poses

    robot = report.robot
    title = f"{robot.name}: left blue, right orange; thin lines where the segments should be"
    write_poses(path, report.model, robot.joints, report.poses, title)


def _next(word: str, file: str | Path, report: RobotReport) -> str:
    """Return what to do next."""
    kinematic = " --arms kinematic" if report.unknown else ""
    command = f"mpma imitate ymca --robot {word}{kinematic}"
    if "speed" in report.unknown:
        return f"next: write the joints' top speeds and their source into {file}, then {command}"
    return f"next: {command}"
