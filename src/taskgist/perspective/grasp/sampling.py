"""Grasps of an object by a hand that closes between a thumb and fingers (5.1.3).

The two points of a pair can be grasped if the hand opens that wide; it may come from several directions around the
line between them. Before it closes it is open by little more than the width, or, where the object itself is then in
its way (as the curved wall of a bowl in that of straight fingers), as wide as it goes.

Grasps are sampled in the object's own frame, once for each form of object, hand and settings (and, of an object with
joints of its own, each position of these): wherever the object goes, they go with it, into other scenes, too.
"""

from __future__ import annotations

import hashlib
import itertools
import math
from collections.abc import Hashable
from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.perspective.grasp.grasps import Grasps, Pairs, hand_centers, hand_frames, opposite_points
from taskgist.settings import Grasp
from taskgist.world.bodies.agent import ArmIndices
from taskgist.world.bodies.hands import Hand, hand_boxes
from taskgist.world.geometry.shapes import distances_outside_m, spans_m
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage

# --- Forms: what an object's shapes are in its own frame, whatever the scene.
#
# The same mug stands in many scenes, and its grasps are the same in all of them. Two objects of one form have equal
# shapes, equally placed; only the indices of these differ.


def shapes_of(bench: Stage, name: str) -> Indices:
    """Indices of all shapes of an object, seen and solid ones, in order, (n,)."""
    return np.union1d(bench.scene.seen_geoms(name), bench.scene.solid_geoms_of(name))


def form_of(bench: Stage, name: str) -> str:
    """Digest of an object's form.

    Args:
        bench: A stage on which the object's frame is the world's.
        name: The object.
    """
    scene, model = bench.scene, bench.scene.model
    shapes = shapes_of(bench, name)
    digest = hashlib.sha256()
    for array in (
        np.isin(shapes, scene.seen_geoms(name)),
        np.isin(shapes, scene.solid_geoms_of(name)),
        model.geom_type[shapes],
        model.geom_size[shapes],
        *bench.geoms(shapes),
    ):
        digest.update(np.ascontiguousarray(array).tobytes())
    for mesh in model.geom_dataid[shapes].tolist():
        digest.update(_mesh_bytes(bench, mesh) if mesh >= 0 else b"-")
    return digest.hexdigest()


def _mesh_bytes(bench: Stage, mesh: int) -> bytes:
    model = bench.scene.model
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    return bytes(vertices.tobytes() + faces.tobytes())


# --- What a hand touches of the object that it grasps: by design, or because it would be in it (5.1.3).

TOUCH_M = 1e-4
"""Overlaps below this are touches: they do not depend on how the scene is turned."""
TOUCHED_M = 0.005
"""Convex parts of a shape this near to a point of it are touched there: parts and shape agree so well (ours)."""
LATTICE = np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=3)))
"""Points of a box at which it is looked at, in half sizes."""


def touching(bench: Stage, name: str, pairs: Pairs) -> Mask:
    """Which of an object's solid shapes each pair touches by design, (n, k).

    Where what is seen is solid, these are the two shapes of the pair; of a shape that is seen only, those solid parts
    that lie at its points.

    Args:
        bench: A stage on which the object's frame is the world's.
        name: The object.
        pairs: Opposite points of it.
    """
    solids, seen = bench.scene.solid_geoms_of(name), bench.scene.seen_geoms(name)
    touched = np.asarray((pairs.shapes[:, :, None] == solids).any(axis=1))
    half = pairs.closings * pairs.widths_m[:, None] / 2
    for column in np.flatnonzero(~np.isin(solids, seen)):
        pose = bench.geom(int(solids[column]))
        for points in (pairs.centers - half, pairs.centers + half):
            local, model = pose.to_local(points), bench.scene.model
            outside_m = distances_outside_m(model, int(solids[column]), local, within_m=TOUCHED_M)
            touched[:, column] |= outside_m <= TOUCHED_M
    return touched


def in_itself(bench: Stage, grasps: Grasps, hand: Hand) -> Mask:
    """Whether the open hand, or its way, is in the object otherwise than by design, (n,).

    Quick tests for all grasps at once settle most of them; the others are measured.

    Args:
        bench: A stage on which the object's frame is the world's.
        grasps: Grasps in that frame.
        hand: What is to grasp.
    """
    frames, centers = hand_frames(grasps), hand_centers(grasps, hand)
    found, near = _settled(bench, grasps, hand, frames, centers)
    arm = _arm_with(bench.scene, hand)
    boxes = {int(ghost): box for box, ghost in enumerate(arm.ghosts)}
    columns = {int(solid): column for column, solid in enumerate(grasps.solids)}
    for index in np.flatnonzero(near.any(axis=(1, 2)) & ~found):
        bench.place(arm.ghosts, centers[index], frames[index].reshape(9))
        suspects = grasps.solids[near[index].any(axis=0)]
        found[index] = any(
            depth_m > TOUCH_M and near[index, boxes[ghost], columns[other]]
            for ghost, other, depth_m in bench.overlaps(arm.ghosts, suspects)
        )
    return found


def _settled(bench: Stage, grasps: Grasps, hand: Hand, frames: Array, centers: Array) -> tuple[Mask, Mask]:
    """Which grasps surely are in the object, (n,), and which box of which may be in which solid shape, (n, boxes, k).

    A box is in a shape if one of its points is; it is not if one of its faces keeps the shape apart.
    """
    boxes, model = hand_boxes(hand), bench.scene.model
    half = np.array([box.half_m for box in boxes]) - TOUCH_M
    near = np.zeros((len(grasps), len(boxes), len(grasps.solids)), dtype=bool)
    found = np.zeros(len(grasps), dtype=bool)
    for column, solid in enumerate(grasps.solids.tolist()):
        pose = bench.geom(solid)
        counts = np.repeat(~found[:, None], len(boxes), axis=1)
        counts[:, 1:] &= ~grasps.touching[:, column, None]
        near[:, :, column] = _near(bench, solid, frames, centers, half, counts)
        for row in range(len(boxes)):
            rows = np.flatnonzero(near[:, row, column] & ~found)
            points = centers[rows, row, None] + (LATTICE * half[row]) @ frames[rows].transpose(0, 2, 1)
            outside_m = distances_outside_m(model, solid, pose.to_local(points.reshape(-1, 3)), within_m=0.0)
            found[rows] = (outside_m.reshape(len(rows), len(LATTICE)) < -TOUCH_M).any(axis=1)
    return found, near


def _near(bench: Stage, solid: int, frames: Array, centers: Array, half: Array, counts: Mask) -> Mask:
    """Which of those boxes that count no face keeps apart from a solid shape, (n, boxes)."""
    pose, model = bench.geom(solid), bench.scene.model
    radius_m = float(model.geom_rbound[solid]) or np.inf  # planes have none
    middles = (pose.position - centers) @ frames
    near = counts & (np.abs(middles) < half + radius_m).all(axis=2)
    rows = np.flatnonzero(near.any(axis=1))
    low, high = spans_m(model, solid, frames[rows].transpose(0, 2, 1) @ pose.matrix)
    low, high = middles[rows] + low[:, None], middles[rows] + high[:, None]
    near[rows] &= ((low < half) & (high > -half)).all(axis=2)
    return near


def met_by_all_fingers(bench: Stage, name: str, grasps: Grasps, hand: Hand) -> Mask:
    """Whether both fingers of a three-finger hand, closing, meet the object's nearer half, (n,)."""
    shapes, across = bench.scene.seen_geoms(name), hand_frames(grasps)[:, :, 2]
    tips = grasps.centers + grasps.closings * (grasps.widths_m / 2 + grasps.gaps_m)[:, None]
    aside_m = (hand.spread_m - hand.width_m) / 2  # the inner edge of a finger
    return np.array(
        [
            all(_meets(bench, shapes, tip + sign * aside_m * z, -closing, width / 2 + gap) for sign in (-1, 1))
            for tip, z, closing, width, gap in zip(
                tips, across, grasps.closings, grasps.widths_m, grasps.gaps_m, strict=True
            )
        ],
        dtype=bool,
    )


def _meets(bench: Stage, shapes: NDArray[np.intp], start: Array, direction: Array, within_m: float) -> bool:
    distance_m = float(bench.cast(start, direction[None], only=shapes)[1][0])
    return 0 <= distance_m <= within_m


def _arm_with(scene: Scene, hand: Hand) -> ArmIndices:
    """An arm whose ghosts have the shape of a hand."""
    arms = (arm for name in scene.agents if scene.agent(name).profile.hand == hand for arm in scene.agent(name).arms)
    return next(arms)


ROUNDING = 1e-9
REMEMBERED = 256
"""Sampled objects kept for each scene, and forms kept for all of them."""
IDENTITY = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def sample_grasps(stage: Stage, name: str, hand: Hand, settings: Grasp) -> Grasps:
    """Grasps of an object where it is now, in the world.

    Args:
        stage: The scene in a state.
        name: The object.
        hand: What is to grasp it.
        settings: How densely to sample.
    """
    return grasps_in_object(stage, name, hand, settings).placed(stage.body(stage.scene.object_body(name)))


def grasps_in_object(stage: Stage, name: str, hand: Hand, settings: Grasp) -> Grasps:
    """Grasps of an object in its own frame, sampled once; only the object's own joints are read off the stage."""
    scene = stage.scene
    joints = {int(index): round(float(stage.state.qpos[index]), 6) for index in scene.inner_joints(name)}
    known = _SAMPLED.setdefault(scene, {})
    key = (name, hand, settings, tuple(joints.values()))
    if key not in known:
        if len(known) >= REMEMBERED:
            known.pop(next(iter(known)))
        at_origin = scene.initial.replace(joints, at=scene.object_slice(name), to=IDENTITY)
        known[key] = _of_its_form(Stage(scene, at_origin), name, hand, settings)
    return known[key]


_SAMPLED: WeakKeyDictionary[Scene, dict[Hashable, Grasps]] = WeakKeyDictionary()
_BY_FORM: dict[Hashable, Grasps] = {}
"""Grasps whose shapes are counted among those of their object."""


def _of_its_form(bench: Stage, name: str, hand: Hand, settings: Grasp) -> Grasps:
    """Grasps of an object; one of the same form may have been sampled in another scene."""
    shapes = shapes_of(bench, name)
    key = (form_of(bench, name), hand, settings)
    if key not in _BY_FORM:
        if len(_BY_FORM) >= REMEMBERED:
            _BY_FORM.pop(next(iter(_BY_FORM)))
        grasps = _sampled(bench, name, hand, settings)
        counted = {field: np.searchsorted(shapes, getattr(grasps, field)) for field in ("shapes", "solids")}
        _BY_FORM[key] = replace(grasps, **counted)
    known = _BY_FORM[key]
    return _frozen(replace(known, shapes=shapes[known.shapes], solids=shapes[known.solids]))


def _sampled(bench: Stage, name: str, hand: Hand, settings: Grasp) -> Grasps:
    pairs = opposite_points(bench, name, settings, hand.opening_m + ROUNDING)
    narrowest_m = float(pairs.widths_m.min()) if len(pairs.widths_m) else None
    pairs = pairs.take(pairs.widths_m <= hand.opening_m + ROUNDING)
    grasps = _around(bench, name, _both_ways(pairs) if hand.one_sided else pairs, narrowest_m, settings)
    if hand.one_sided:
        grasps = grasps.only(met_by_all_fingers(bench, name, grasps, hand))
    return _frozen(_opened(bench, grasps, hand))


def _around(bench: Stage, name: str, pairs: Pairs, narrowest_m: float | None, settings: Grasp) -> Grasps:
    """Grasps of each pair from all directions, the hand opened little more than wide enough."""
    rows = np.repeat(np.arange(len(pairs.centers)), settings.approaches)
    return Grasps(
        centers=pairs.centers[rows],
        closings=pairs.closings[rows],
        approaches=around(pairs.closings, settings.approaches).reshape(-1, 3),
        widths_m=pairs.widths_m[rows],
        gaps_m=np.full(len(rows), settings.clearance_m),
        in_itself=np.zeros(len(rows), dtype=bool),
        shapes=pairs.shapes[rows],
        solids=bench.scene.solid_geoms_of(name),
        touching=touching(bench, name, pairs)[rows],
        narrowest_m=narrowest_m,
    )


def _opened(bench: Stage, grasps: Grasps, hand: Hand) -> Grasps:
    """Grasps opened as wide as the hand goes where they would be in the object otherwise."""
    tight = in_itself(bench, grasps, hand)
    widest = np.maximum((hand.opening_m - grasps.widths_m) / 2, grasps.gaps_m)
    wide = replace(grasps, gaps_m=np.where(tight, widest, grasps.gaps_m))
    blocked = np.zeros(len(grasps), dtype=bool)
    blocked[tight] = in_itself(bench, wide.only(tight), hand)
    return replace(wide, gaps_m=np.where(blocked, grasps.gaps_m, wide.gaps_m), in_itself=blocked)


def around(closings: Array, count: int) -> Array:
    """Directions square to closing directions, evenly around each, beginning near an axis of the frame.

    Args:
        closings: Unit directions, (n, 3).
        count: How many around each.

    Returns:
        Unit directions, (n, count, 3).
    """
    reference = np.eye(3)[np.argmin(np.round(np.abs(closings), 6), axis=1)]
    first = reference - closings * np.sum(closings * reference, axis=1, keepdims=True)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(closings, first)
    angles = 2 * math.pi * np.arange(count)[:, None] / count
    return np.asarray(np.cos(angles) * first[:, None] + np.sin(angles) * second[:, None])


def _both_ways(pairs: Pairs) -> Pairs:
    """Each pair, and with thumb and fingers changed over."""
    return Pairs(
        np.concatenate((pairs.centers, pairs.centers)),
        np.concatenate((pairs.closings, -pairs.closings)),
        np.concatenate((pairs.widths_m, pairs.widths_m)),
        np.concatenate((pairs.shapes, pairs.shapes[:, ::-1])),
    )


def _frozen(grasps: Grasps) -> Grasps:
    for value in vars(grasps).values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
    return grasps
