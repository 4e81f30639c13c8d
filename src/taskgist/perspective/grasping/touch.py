"""What a hand touches of the object that it grasps: by design, or because it would be in it (5.1.3)."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.grasping.grasps import Array, Grasps
from taskgist.perspective.grasping.hand import hand_centers, hand_frames
from taskgist.perspective.grasping.pairs import Pairs
from taskgist.world import ArmIndices, Hand, Scene, Stage, distances_outside_m, hand_boxes, spans_m

TOUCH_M = 1e-4
"""Overlaps below this are touches: they do not depend on how the scene is turned."""
TOUCHED_M = 0.005
"""Convex parts of a shape this near to a point of it are touched there: parts and shape agree so well (ours)."""
LATTICE = np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=3)))
"""Points of a box at which it is looked at, in half sizes."""
Mask = NDArray[np.bool_]


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
