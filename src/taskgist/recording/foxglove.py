"""What viewers see of a recording: the frames of all bodies that move (``/tf``), and all shapes once (``/scene``).

All of it is derived from the states, which are the data; reading a recording ignores it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskgist.recording.foxglove_shapes import LISTS, Message, primitives
from taskgist.recording.recording import Recording
from taskgist.recording.rounding import nanoseconds
from taskgist.world import Pose, Stage
from taskgist.world.geometry.rotations import matrix_from_wxyz, multiply, rotate

Array = NDArray[np.float64]

WORLD = "world"
DECIMALS = 3  # of metres and quaternions: for the eye; the states keep more
DRAWN_GROUPS = range(3)  # those that rays meet, and that MuJoCo draws by default


class Viewer:
    """The messages for viewers of one recording.

    Args:
        recording: The recording.
    """

    def __init__(self, recording: Recording) -> None:
        self._scene = recording.scene
        self._times_ns = nanoseconds(recording.times_s)
        self._stage = Stage(recording.scene)
        self._names = [_body_name(recording, body) for body in range(recording.scene.model.nbody)]
        poses = np.array([self._stage.show(recording.state(frame)).bodies() for frame in range(len(recording))])
        self._in_world = _rounded(poses)
        self._in_parent = _rounded(_relative(poses, poses[:, self._scene.model.body_parentid]))
        self._moving = frozenset(np.flatnonzero(np.ptp(self._in_world, axis=0).any(axis=1)).tolist())
        self._stage.show(recording.state(0))

    def transforms(self, frame: int) -> Message:
        """Where the bodies that ever move are in a frame: a foxglove.FrameTransforms message."""
        stamp = timestamp(self._times_ns[frame])
        return {"transforms": [self._transform(frame, body, stamp) for body in sorted(self._moving)]}

    def shapes(self) -> Message:
        """The shapes of all bodies, one entity each: a foxglove.SceneUpdate message.

        Those of a body that moves are locked to its frame; the others stand in the world, and need no frame.
        """
        entities = [self._entity(body) for body in range(len(self._names))]
        return {"deletions": [], "entities": [entity for entity in entities if any(entity[key] for key in LISTS)]}

    def _transform(self, frame: int, body: int, stamp: Message) -> Message:
        parent = int(self._scene.model.body_parentid[body])
        chained = parent in self._moving  # joints alone change within a chain, which compresses well
        pose = (self._in_parent if chained else self._in_world)[frame, body]
        x, y, z, qw, qx, qy, qz = pose.tolist()
        return {
            "timestamp": stamp,
            "parent_frame_id": self._names[parent] if chained else WORLD,
            "child_frame_id": self._names[body],
            "translation": {"x": x, "y": y, "z": z},
            "rotation": {"x": qx, "y": qy, "z": qz, "w": qw},
        }

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
