"""What viewers see of a recording: the frames of all bodies that move (``/tf``), and all shapes once (``/scene``).

All of it is derived from the states, which are the data; reading a recording ignores it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from taskgist.common.arrays import Array
from taskgist.recording.recording import Recording, nanoseconds, rounded
from taskgist.world.geometry.transforms import Pose, matrix_from_wxyz, multiply, rotate, wxyz_from_matrix
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State

# --- JSON schemas of the Foxglove messages that a recording carries for viewers, under their well-known names.
#
# The same fields as in the published schemas (https://github.com/foxglove/foxglove-sdk/tree/main/schemas/jsonschema);
# a test holds the messages to the official Protobuf definitions.

Schema = dict[str, Any]


def _message(title: str, **properties: Schema) -> Schema:
    return {"title": title, "type": "object", "properties": properties}


def _list(items: Schema) -> Schema:
    return {"type": "array", "items": items}


def _clock(title: str, seconds: Schema) -> Schema:
    nanoseconds = {"type": "integer", "minimum": 0, "maximum": 999_999_999}
    return _message(title, sec=seconds, nsec=nanoseconds)


NUMBER: Schema = {"type": "number"}
TEXT: Schema = {"type": "string"}
FLAG: Schema = {"type": "boolean"}
INDEX: Schema = {"type": "integer", "minimum": 0}

TIME = _clock("time", {"type": "integer", "minimum": 0})
DURATION = _clock("duration", {"type": "integer"})
VECTOR3 = _message("foxglove.Vector3", x=NUMBER, y=NUMBER, z=NUMBER)
POINT3 = _message("foxglove.Point3", x=NUMBER, y=NUMBER, z=NUMBER)
QUATERNION = _message("foxglove.Quaternion", x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER)
POSE = _message("foxglove.Pose", position=VECTOR3, orientation=QUATERNION)
COLOR = _message("foxglove.Color", r=NUMBER, g=NUMBER, b=NUMBER, a=NUMBER)
KEY_VALUE = _message("foxglove.KeyValuePair", key=TEXT, value=TEXT)

FRAME_TRANSFORM = _message(
    "foxglove.FrameTransform",
    timestamp=TIME,
    parent_frame_id=TEXT,
    child_frame_id=TEXT,
    translation=VECTOR3,
    rotation=QUATERNION,
)
FRAME_TRANSFORMS = _message("foxglove.FrameTransforms", transforms=_list(FRAME_TRANSFORM))

_ARROW = _message(
    "foxglove.ArrowPrimitive",
    pose=POSE,
    shaft_length=NUMBER,
    shaft_diameter=NUMBER,
    head_length=NUMBER,
    head_diameter=NUMBER,
    color=COLOR,
)
_CUBE = _message("foxglove.CubePrimitive", pose=POSE, size=VECTOR3, color=COLOR)
_SPHERE = _message("foxglove.SpherePrimitive", pose=POSE, size=VECTOR3, color=COLOR)
_CYLINDER = _message(
    "foxglove.CylinderPrimitive", pose=POSE, size=VECTOR3, bottom_scale=NUMBER, top_scale=NUMBER, color=COLOR
)
_LINE = _message(
    "foxglove.LinePrimitive",
    type={"title": "foxglove.LineType", "oneOf": [{"const": number} for number in range(3)]},
    pose=POSE,
    thickness=NUMBER,
    scale_invariant=FLAG,
    points=_list(POINT3),
    color=COLOR,
    colors=_list(COLOR),
    indices=_list(INDEX),
)
_TRIANGLES = _message(
    "foxglove.TriangleListPrimitive",
    pose=POSE,
    points=_list(POINT3),
    color=COLOR,
    colors=_list(COLOR),
    indices=_list(INDEX),
)
_TEXT = _message(
    "foxglove.TextPrimitive",
    pose=POSE,
    billboard=FLAG,
    font_size=NUMBER,
    scale_invariant=FLAG,
    color=COLOR,
    text=TEXT,
)
_MODEL = _message(
    "foxglove.ModelPrimitive",
    pose=POSE,
    scale=VECTOR3,
    color=COLOR,
    override_color=FLAG,
    url=TEXT,
    media_type=TEXT,
    data={"type": "string", "contentEncoding": "base64"},
)
_ENTITY = _message(
    "foxglove.SceneEntity",
    timestamp=TIME,
    frame_id=TEXT,
    id=TEXT,
    lifetime=DURATION,
    frame_locked=FLAG,
    metadata=_list(KEY_VALUE),
    arrows=_list(_ARROW),
    cubes=_list(_CUBE),
    spheres=_list(_SPHERE),
    cylinders=_list(_CYLINDER),
    lines=_list(_LINE),
    triangles=_list(_TRIANGLES),
    texts=_list(_TEXT),
    models=_list(_MODEL),
)
_DELETION = _message(
    "foxglove.SceneEntityDeletion",
    timestamp=TIME,
    type={"title": "foxglove.SceneEntityDeletionType", "oneOf": [{"const": number} for number in range(2)]},
    id=TEXT,
)
SCENE_UPDATE = _message("foxglove.SceneUpdate", deletions=_list(_DELETION), entities=_list(_ENTITY))


# --- MuJoCo's shapes as Foxglove's primitives. Foxglove gives whole edges and diameters, MuJoCo halves and radii.

Message = dict[str, Any]
Drawn = Iterator[tuple[str, Message]]
"""Pairs of a list in a foxglove.SceneEntity, such as "cubes", and a primitive for it."""

LISTS = ("cubes", "spheres", "cylinders", "triangles")
PLANE_EDGE_M = 10.0
"""Edge of a floor that has none."""

_PLANE_THICKNESS_M = 0.002
_DECIMALS = 5


def primitives(scene: Scene, geom: int, pose: Pose) -> Drawn:
    """How a shape of a scene is drawn; kinds that Foxglove has no primitive for are left out.

    Args:
        scene: The scene.
        geom: Index of the shape.
        pose: Where it is, in the frame of the entity.
    """
    draw = _DRAWERS.get(int(scene.model.geom_type[geom]))
    for kind, primitive in () if draw is None else draw(scene, geom, pose):
        yield kind, primitive | {"color": _color(scene, geom)}


def pose_message(pose: Pose) -> Message:
    """A foxglove.Pose."""
    w, x, y, z = _rounded_list(wxyz_from_matrix(pose.matrix))
    return {"position": vector(pose.position), "orientation": {"x": x, "y": y, "z": z, "w": w}}


def vector(values: Any) -> Message:
    """A foxglove.Vector3, or foxglove.Point3."""
    x, y, z = _rounded_list(values)
    return {"x": x, "y": y, "z": z}


def _box(scene: Scene, geom: int, pose: Pose) -> Drawn:
    yield "cubes", {"pose": pose_message(pose), "size": vector(2.0 * scene.model.geom_size[geom])}


def _plane(scene: Scene, geom: int, pose: Pose) -> Drawn:
    half_x, half_y, _ = scene.model.geom_size[geom]
    size = (2.0 * half_x or PLANE_EDGE_M, 2.0 * half_y or PLANE_EDGE_M, _PLANE_THICKNESS_M)
    beneath = Pose(pose.to_world((0.0, 0.0, -_PLANE_THICKNESS_M / 2)), pose.matrix)
    yield "cubes", {"pose": pose_message(beneath), "size": vector(size)}


def _sphere(scene: Scene, geom: int, pose: Pose) -> Drawn:
    diameter = 2.0 * scene.model.geom_size[geom][0]
    yield "spheres", {"pose": pose_message(pose), "size": vector((diameter, diameter, diameter))}


def _ellipsoid(scene: Scene, geom: int, pose: Pose) -> Drawn:
    yield "spheres", {"pose": pose_message(pose), "size": vector(2.0 * scene.model.geom_size[geom])}


def _cylinder(scene: Scene, geom: int, pose: Pose) -> Drawn:
    radius, half_length, _ = scene.model.geom_size[geom]
    size = vector((2.0 * radius, 2.0 * radius, 2.0 * half_length))
    yield "cylinders", {"pose": pose_message(pose), "size": size, "bottom_scale": 1.0, "top_scale": 1.0}


def _capsule(scene: Scene, geom: int, pose: Pose) -> Drawn:
    half_length = scene.model.geom_size[geom][1]
    yield from _cylinder(scene, geom, pose)
    for end in (-half_length, half_length):
        yield from _sphere(scene, geom, Pose(pose.to_world((0.0, 0.0, end)), pose.matrix))


def _mesh(scene: Scene, geom: int, pose: Pose) -> Drawn:
    model = scene.model
    mesh = int(model.geom_dataid[geom])
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    triangles = {"points": [vector(vertex) for vertex in vertices], "indices": np.ravel(faces).tolist(), "colors": []}
    yield "triangles", {"pose": pose_message(pose), **triangles}


_DRAWERS: dict[int, Callable[[Scene, int, Pose], Drawn]] = {
    0: _plane,
    2: _sphere,
    3: _capsule,
    4: _ellipsoid,
    5: _cylinder,
    6: _box,
    7: _mesh,
}
"""By MuJoCo's numbers of kinds, mjtGeom."""


def _color(scene: Scene, geom: int) -> Message:
    model = scene.model
    material = int(model.geom_matid[geom])
    rgba = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
    return dict(zip("rgba", (round(float(channel), 3) for channel in rgba), strict=True))


def _rounded_list(values: Any) -> list[float]:
    rounded: list[float] = (np.round(np.asarray(values, dtype=np.float64), _DECIMALS) + 0.0).tolist()
    return rounded


WORLD = "world"
DECIMALS = 3  # of metres and quaternions: for the eye; the states keep more
BLOCK = 256
"""As many frames are worked on at a time: some two million numbers."""
DRAWN_GROUPS = range(3)  # those that rays meet, and that MuJoCo draws by default


class Viewer:
    """The messages for viewers of one recording, at its precision on disk.

    Args:
        recording: The recording.
    """

    def __init__(self, recording: Recording) -> None:
        self._recording, self._scene = recording, recording.scene
        self._times_ns = nanoseconds(recording.times_s)
        self._stage = Stage(recording.scene)
        self._names = [_body_name(recording, body) for body in range(recording.scene.model.nbody)]
        self._moving = self._that_move()

    def transforms(self, first: int, last: int) -> Iterator[Message]:
        """Where the bodies that ever move are in each frame of a range: foxglove.FrameTransforms messages."""
        poses = self._poses(first, last)
        moving = sorted(self._moving)
        parents = self._scene.model.body_parentid[moving]
        chained = np.isin(parents, moving)  # joints alone change within a chain, which compresses well
        relative = _rounded(
            np.where(chained[:, None], _relative(poses[:, moving], poses[:, parents]), poses[:, moving])
        )
        names = [
            (self._names[parent] if inside else WORLD, self._names[body])
            for body, parent, inside in zip(moving, parents.tolist(), chained.tolist(), strict=True)
        ]
        for frame, rows in enumerate(relative.tolist(), start=first):
            stamp = timestamp(self._times_ns[frame])
            yield {"transforms": [_transform(*each, row, stamp) for each, row in zip(names, rows, strict=True)]}

    def shapes(self) -> Message:
        """The shapes of all bodies, one entity each: a foxglove.SceneUpdate message.

        Those of a body that moves are locked to its frame; the others stand in the world, and need no frame.
        """
        self._poses(0, 1)
        entities = [self._entity(body) for body in range(len(self._names))]
        return {"deletions": [], "entities": [entity for entity in entities if any(entity[key] for key in LISTS)]}

    def _that_move(self) -> frozenset[int]:
        """Bodies that are not in the same place in all frames."""
        bounds = np.empty((2, len(self._names), 7))
        for first in range(0, len(self._recording), BLOCK):
            poses = _rounded(self._poses(first, min(first + BLOCK, len(self._recording))))
            low, high = poses.min(axis=0), poses.max(axis=0)
            bounds = np.stack((np.minimum(bounds[0], low), np.maximum(bounds[1], high)) if first else (low, high))
        return frozenset(np.flatnonzero((bounds[1] > bounds[0]).any(axis=1)).tolist())

    def _poses(self, first: int, last: int) -> Array:
        """Position and wxyz of every body in each frame of a range, (frames, bodies, 7)."""
        rows = rounded(self._recording.qpos[first:last], self._scene)
        return np.array([self._stage.show(State(row)).bodies() for row in rows])

    def _entity(self, body: int) -> Message:
        moves = body in self._moving
        model = self._scene.model
        entity: Message = {
            "timestamp": timestamp(self._times_ns[0]),
            "frame_id": self._names[body] if moves else WORLD,
            "id": self._names[body],
            "lifetime": {"sec": 0, "nsec": 0},
            "frame_locked": True,
            **{key: [] for key in ("metadata", "arrows", *LISTS, "lines", "texts", "models")},
        }
        for geom in np.flatnonzero(model.geom_bodyid == body).tolist():
            if model.geom_group[geom] in DRAWN_GROUPS:
                pose = self._local_pose(geom) if moves else self._stage.geom(geom)
                for kind, primitive in primitives(self._scene, geom, pose):
                    entity[kind].append(primitive)
        return entity

    def _local_pose(self, geom: int) -> Pose:
        model = self._scene.model
        return Pose(np.array(model.geom_pos[geom]), matrix_from_wxyz(model.geom_quat[geom]))


def _transform(parent: str, child: str, pose: list[float], stamp: Message) -> Message:
    """A foxglove.FrameTransform message of a pose, position in metres and wxyz."""
    x, y, z, qw, qx, qy, qz = pose
    return {
        "timestamp": stamp,
        "parent_frame_id": parent,
        "child_frame_id": child,
        "translation": {"x": x, "y": y, "z": z},
        "rotation": {"x": qx, "y": qy, "z": qz, "w": qw},
    }


def timestamp(time_ns: int) -> Message:
    """A time as Foxglove's JSON messages write it."""
    seconds, rest = divmod(int(time_ns), 1_000_000_000)
    return {"sec": seconds, "nsec": rest}


def _relative(poses: Array, parents: Array) -> Array:
    """Poses (..., 7), position and wxyz in the world, in the frames of others, (..., 7)."""
    back = parents[..., 3:] * (1.0, -1.0, -1.0, -1.0)
    positions_m = rotate(back, poses[..., :3] - parents[..., :3])
    return np.concatenate((positions_m, multiply(back, poses[..., 3:])), axis=-1)


def _rounded(poses: Array) -> Array:
    """Poses (..., 7) for the eye, each orientation with its quaternion of w ≥ 0."""
    same_side = np.where(poses[..., 3:4] < 0, -1.0, 1.0)
    poses = np.concatenate((poses[..., :3], same_side * poses[..., 3:]), axis=-1)
    return np.asarray(np.round(poses, DECIMALS) + 0.0)  # no -0.0


def _body_name(recording: Recording, body: int) -> str:
    return str(recording.scene.model.body(body).name) or f"body {body}"
