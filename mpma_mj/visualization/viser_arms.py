"""Arms, the demonstration's ghost and a force as nodes of a viser scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from mpma_mj.envs.model import geom_colours
from mpma_mj.errors import MpmaError
from mpma_mj.visualization.meshes import geom_mesh, limb_mesh

if TYPE_CHECKING:
    import viser

__all__ = [
    "ArmNodes",
    "ForceNode",
    "GhostNodes",
    "add_lights",
    "quaternion_from_z",
    "require_web",
]

Array = NDArray[np.float64]
_SHOWN_GROUPS = 3  # MuJoCo's own viewers hide geoms of groups 3 and up
_GHOST, _GHOST_OPACITY = (26, 31, 46), 0.35
_FORCE = (213, 94, 0)
_NEWTONS_A_METRE = 200.0


def require_web() -> None:
    """Check that viser, with which pages are made, can be imported.

    Raises:
        MpmaError: viser is not installed.
    """
    try:
        import viser  # noqa: F401
    except ImportError:
        raise MpmaError(
            "pages need viser, which is not installed; pip install 'mpma-mj[web]', or in a"
            " checkout pip install -e '.[web]'"
        ) from None


def add_lights(scene: viser.SceneApi) -> None:
    """Light a scene from the sky and from one side, without shadows.

    They take the place of viser's lights and of its photograph of surroundings, with which
    software draws four times longer.
    """
    scene.configure_environment_map(None)
    scene.configure_default_lights(enabled=False)
    scene.add_light_hemisphere("/lights/sky", ground_color=(140, 142, 150), intensity=2.2)
    scene.add_light_directional("/lights/key", intensity=2.2, position=(2.5, 2.0, 3.5))


class ArmNodes:
    """A model's bodies as frames, each with meshes for its geoms.

    A body that the joints do not move is sent once; of the others, only what changes.

    Attributes:
        geoms: Meshes by index of the geom; those of height fields and hidden groups are left out.
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        *,
        name: str = "/arms",
        position: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> None:
        """Add the nodes, in the pose of `data`.

        Args:
            scene: Scene of a server or of a client.
            model: Model of the arms; may change colours and sizes of its geoms later.
            data: Pose of the arms.
            name: Name of the node that holds all others.
            position: Place of the model's origin in the scene, m.
        """
        self._model = model
        self.root = scene.add_frame(name, show_axes=False, position=position)
        self._bodies = {}
        self.geoms: dict[int, viser.MeshHandle] = {}
        self._moving = [i for i in range(model.nbody) if model.body_weldid[i] != 0]
        colours = geom_colours(model)
        for body in range(model.nbody):
            frame = f"{name}/{_node(model.body(body).name, body)}"
            self._bodies[body] = scene.add_frame(
                frame, show_axes=False, position=data.xpos[body], wxyz=data.xquat[body]
            )
            first = int(model.body_geomadr[body])
            for geom in range(first, first + int(model.body_geomnum[body])):
                if model.geom_group[geom] >= _SHOWN_GROUPS:
                    continue
                mesh = geom_mesh(model, geom)
                if mesh is None:
                    continue
                alpha = float(colours[geom, 3])
                self.geoms[geom] = scene.add_mesh_simple(
                    f"{frame}/{_node(model.geom(geom).name, geom)}",
                    *mesh,
                    color=_rgb(colours[geom]),
                    opacity=None if alpha == 1.0 else alpha,
                    flat_shading=bool(model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH),
                    cast_shadow=False,
                    position=model.geom_pos[geom],
                    wxyz=model.geom_quat[geom],
                    visible=alpha > 0.0,
                )
        self._looks = self._present_looks()

    def update(self, data: mujoco.MjData, model: mujoco.MjModel | None = None) -> None:
        """Take the pose of `data`, and colours and sizes of a model; of the present one if None."""
        self._model = self._model if model is None else model
        for body in self._moving:
            node = self._bodies[body]
            node.position, node.wxyz = data.xpos[body], data.xquat[body]
        looks = self._present_looks()
        if not np.array_equal(looks, self._looks):
            for geom in np.flatnonzero((looks != self._looks).any(axis=1)):
                self._change(int(geom))
            self._looks = looks

    def _present_looks(self) -> Array:
        """Return sizes and colours of all geoms, shape (G, 7)."""
        return np.hstack([self._model.geom_size, geom_colours(self._model)])

    def _change(self, geom: int) -> None:
        node, mesh = self.geoms.get(geom), geom_mesh(self._model, geom)
        if node is None or mesh is None:
            return
        colour = geom_colours(self._model)[geom]
        node.vertices = mesh[0].astype(np.float32)
        node.color, node.visible = _rgb(colour), bool(colour[3] > 0.0)
        node.opacity = None if colour[3] == 1.0 else float(colour[3])


class GhostNodes:
    """Demonstrated posture: four limbs, with spheres for elbows and wrists at their ends."""

    def __init__(
        self,
        scene: viser.SceneApi,
        segment_lengths: Array,
        *,
        name: str = "/ghost",
        position: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> None:
        """Add the nodes.

        Args:
            scene: Scene of a server or of a client.
            segment_lengths: Lengths of the four segments, shape (4,), m.
            name: Name of the node that holds all others.
            position: Place of the model's origin in the scene, m.
        """
        self.root = scene.add_frame(name, show_axes=False, position=position)
        self._limbs = [
            scene.add_mesh_simple(
                f"{name}/{i}",
                *limb_mesh(float(length)),
                color=_GHOST,
                opacity=_GHOST_OPACITY,
                cast_shadow=False,
                receive_shadow=False,
            )
            for i, length in enumerate(segment_lengths)
        ]

    def update(self, positions: Array) -> None:
        """Take a posture.

        Args:
            positions: Shoulder, elbow and wrist of the left and the right arm, shape (2, 3, 3), m,
                as `PhysicsArms.site_positions` returns them.
        """
        starts, ends = positions[:, :2].reshape(4, 3), positions[:, 1:].reshape(4, 3)
        for limb, start, end in zip(self._limbs, starts, ends, strict=True):
            limb.position, limb.wxyz = start, quaternion_from_z(end - start)


class ForceNode:
    """Arrow for a force, 1 m for 200 N."""

    def __init__(self, scene: viser.SceneApi, *, name: str = "/force") -> None:
        """Add the node, which is not visible while there is no force."""
        self._arrow = scene.add_arrows(
            name, np.zeros((1, 2, 3)), _FORCE, shaft_radius=0.012, head_radius=0.03, visible=False
        )

    def update(self, position: Array, force: Array) -> None:
        """Show a force.

        Args:
            position: Where it acts, shape (3,), m.
            force: The force, shape (3,), N.
        """
        self._arrow.visible = bool(np.any(force))
        if self._arrow.visible:
            points = [position, position + force / _NEWTONS_A_METRE]
            self._arrow.points = np.array([points], np.float32)


def quaternion_from_z(direction: Array) -> Array:
    """Return the shortest turn from the z axis to a direction, shape (4,), w first.

    Args:
        direction: Direction, shape (3,), of any length but 0.
    """
    x, y, z = direction / np.linalg.norm(direction)
    if z < -1.0 + 1e-9:  # half a turn, about any axis across
        return np.array([0.0, 1.0, 0.0, 0.0])
    turn = np.array([1.0 + z, -y, x, 0.0])
    return turn / np.linalg.norm(turn)


def _node(name: str, index: int) -> str:
    """Return a name for a node; a slash would make it the child of another one."""
    return name.replace("/", "|") or str(index)


def _rgb(colour: Array) -> tuple[int, int, int]:
    red, green, blue = (round(255 * float(share)) for share in colour[:3])
    return red, green, blue
