"""Grasps of an object by a hand that closes between a thumb and fingers: pairs of opposite surface points (5.1.3).

From each of many points of the object's surface, a ray goes through the object along the inward normal, to where it
leaves it. The two points can be grasped if their faces are opposed and the hand opens that wide; the hand may come
from several directions around the line between them. All of it is done in the object's own frame, so it does not
depend on the room.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.settings import Grasp
from taskgist.world import Hand, Pose, Stage

Array = NDArray[np.float64]
INSIDE_M = 1e-5
"""How deep beneath the surface a ray starts."""
SHRINK = 1e-3
"""How far, of the way to the shape's centre, it starts from an edge, so that it does not graze the next face."""
SAME_M = 1e-4
ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Pair:
    """Two opposite points of an object's surface.

    Attributes:
        center: Half-way between them in the world, metres, (3,).
        closing: Unit direction from one to the other, (3,).
        width_m: How far they are apart.
        shapes: The shapes that they lie on.
    """

    center: Array
    closing: Array
    width_m: float
    shapes: tuple[int, int]


@dataclass(frozen=True, eq=False)
class Grasps:
    """Sampled grasps, by index.

    Attributes:
        pairs: What each closes on.
        centers: Half-way between the two points, metres, (n, 3).
        approaches: Unit directions in which the palm comes, (n, 3).
        narrowest_m: Width of the object's narrowest opposite points, whether the hand opens that wide or not; None if
            it has no opposite faces.
    """

    pairs: tuple[Pair, ...]
    centers: Array
    approaches: Array
    narrowest_m: float | None


def sample_grasps(stage: Stage, name: str, hand: Hand, settings: Grasp) -> Grasps:
    """Grasps of an object where it is now.

    Args:
        stage: The scene in a state.
        name: The object.
        hand: How wide it opens.
        settings: How densely to sample.
    """
    pairs = opposite_points(stage, name, settings)
    fitting = [pair for pair in pairs if pair.width_m <= hand.opening_m + ROUNDING]
    closing = np.array([pair.closing for pair in fitting]).reshape(-1, 3)
    frame = stage.body(stage.scene.object_body(name)).matrix
    repeated = tuple(pair for pair in fitting for _ in range(settings.approaches))
    return Grasps(
        pairs=repeated,
        centers=np.array([pair.center for pair in repeated]).reshape(-1, 3),
        approaches=around(closing, frame, settings.approaches).reshape(-1, 3),
        narrowest_m=min((pair.width_m for pair in pairs), default=None),
    )


def opposite_points(stage: Stage, name: str, settings: Grasp) -> list[Pair]:
    """Distinct pairs of opposite points of an object's surface."""
    shapes = stage.scene.object_geoms(name)
    found = [
        pair
        for shape in shapes
        for point, normal in _surface(stage, int(shape), settings.cell_m)
        if (pair := _through(stage, shapes, int(shape), point, normal, settings))
    ]
    if not found:
        return []
    return [found[index] for index in _distinct(_keys(found, stage.body(stage.scene.object_body(name))))]


def around(closing: Array, frame: Array, count: int) -> Array:
    """Directions square to closing directions, evenly around each from an axis of the object.

    Args:
        closing: Unit directions, (n, 3).
        frame: The object's axes in the world, the columns of (3, 3).
        count: How many around each.

    Returns:
        Unit directions, (n, count, 3).
    """
    least_aligned = np.argmin(np.round(np.abs(closing @ frame), 6), axis=1)
    reference = frame.T[least_aligned]
    first = reference - closing * np.sum(closing * reference, axis=1, keepdims=True)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(closing, first)
    angles = 2 * math.pi * np.arange(count)[:, None] / count
    return np.asarray(np.cos(angles) * first[:, None] + np.sin(angles) * second[:, None])


def hand_poses(grasps: Grasps, index: int, hand: Hand, clearance_m: float) -> tuple[Pose, Pose, Pose]:
    """Where palm, fingers and thumb are before they close; x along the approach, y along the closing direction.

    The pads, a finger's thickness behind the tips, are at the two points; the palm is behind the fingers.
    """
    pair, approach = grasps.pairs[index], grasps.approaches[index]
    matrix = np.stack((approach, pair.closing, np.cross(approach, pair.closing)), axis=1)
    fingers_back_m = hand.finger_length_m / 2 - hand.finger_thickness_m
    palm_back_m = hand.finger_length_m - hand.finger_thickness_m + hand.palm_m[1] / 2
    beside = pair.closing * (pair.width_m / 2 + clearance_m + hand.finger_thickness_m / 2)
    fingers = pair.center - approach * fingers_back_m
    return (
        Pose(pair.center - approach * palm_back_m, matrix),
        Pose(fingers + beside, matrix),
        Pose(fingers - beside, matrix),
    )


def _surface(stage: Stage, shape: int, spacing_m: float) -> list[tuple[Array, Array]]:
    """Points and outward normals of a shape in the world, pulled from its edges; a fine mesh is thinned."""
    points, normals = stage.scene.surface_points(shape, spacing_m)
    if not len(points):
        return []
    kept = _distinct(np.concatenate((np.round(points / (spacing_m / 4)), np.round(2 * normals)), axis=1))
    pose = stage.geom(shape)
    inner = points[kept] * (1 - SHRINK)
    return list(zip(pose.to_world(inner), normals[kept] @ pose.matrix.T, strict=True))


def _through(
    stage: Stage, shapes: NDArray[np.intp], shape: int, point: Array, normal: Array, settings: Grasp
) -> Pair | None:
    """The point and where a ray through the object leaves it; None if the two faces are not opposed."""
    exit_normal = np.zeros((1, 3))
    start = point - INSIDE_M * normal
    geoms, distances = stage.cast(start, -normal[None], only=shapes, normals=exit_normal)
    if geoms[0] < 0 or float(exit_normal[0] @ -normal) < math.cos(settings.opposed_rad):
        return None
    back, back_m = stage.cast(start, normal[None], only=shapes[shapes == shape])
    if back[0] < 0:
        return None
    width_m = float(distances[0] + back_m[0])
    center = start + normal * (float(back_m[0]) - width_m / 2)
    return Pair(center, -normal, width_m, (shape, int(geoms[0])))


def _keys(pairs: list[Pair], frame: Pose) -> Array:
    """Centres and undirected closing lines in the object's frame, (n, 6): thumb and fingers may change places."""
    centers = frame.to_local([pair.center for pair in pairs])
    closing = np.round(np.array([pair.closing for pair in pairs]) @ frame.matrix, 4)
    leading = np.argmax(closing != 0.0, axis=1)
    signs = np.sign(closing[np.arange(len(pairs)), leading])
    return np.concatenate((np.round(centers / SAME_M), closing * signs[:, None]), axis=1)


def _distinct(keys: Array) -> NDArray[np.intp]:
    """Indices of the first row of each kind, in order."""
    return np.sort(np.unique(keys + 0.0, axis=0, return_index=True)[1])
