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
from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.settings import Grasp
from taskgist.world.bodies.hands import Hand, Palms, hand_boxes
from taskgist.world.geometry.shapes import distances_outside_m, inner_points, spans_m
from taskgist.world.geometry.transforms import Pose
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage

PER_GRASP = ("centers", "closings", "approaches", "widths_m", "gaps_m", "in_itself", "shapes", "touching")


@dataclass(frozen=True, eq=False)
class Grasps:
    """Sampled grasps, in the object's frame or, once placed, in the world.

    Attributes:
        centers: Half-way between the two points that the hand closes on, metres, (n, 3).
        closings: Unit directions from the thumb's point to the fingers', (n, 3).
        approaches: Unit directions in which the palm comes, (n, 3).
        widths_m: How far the two points are apart, (n,).
        gaps_m: How far fingers and thumb each stand off their point before they close, (n,).
        in_itself: Whether the hand would be in the object itself, other than where it closes on it, (n,).
        shapes: The seen shapes that the points lie on, (n, 2).
        solids: The object's solid shapes, (k,).
        touching: Whether a grasp's fingers touch each of these by design, (n, k).
        narrowest_m: Width of the object's narrowest opposite points, whether the hand opens that wide or not; None if
            it has no opposite faces.
    """

    centers: Array
    closings: Array
    approaches: Array
    widths_m: Array
    gaps_m: Array
    in_itself: Mask
    shapes: Indices
    solids: Indices
    touching: Mask
    narrowest_m: float | None

    def __len__(self) -> int:
        return len(self.centers)

    def placed(self, pose: Pose) -> Grasps:
        """The same grasps in the world, of an object that stands there."""
        turn = pose.matrix.T
        return replace(
            self,
            centers=pose.to_world(self.centers),
            closings=self.closings @ turn,
            approaches=self.approaches @ turn,
        )

    def only(self, rows: Indices | Mask) -> Grasps:
        """Some of them."""
        return replace(self, **{field: getattr(self, field)[rows] for field in PER_GRASP})


def hand_frames(grasps: Grasps) -> Array:
    """Axes of the hand in each grasp, (n, 3, 3): columns along the approach, the closing direction, and across."""
    a, c = grasps.approaches.T, grasps.closings.T
    across = (a[1] * c[2] - a[2] * c[1], a[2] * c[0] - a[0] * c[2], a[0] * c[1] - a[1] * c[0])
    return np.stack((grasps.approaches, grasps.closings, np.stack(across, axis=1)), axis=2)


def hand_centers(grasps: Grasps, hand: Hand | Palms) -> Array:
    """Middles of the boxes of ``hand_boxes`` in each grasp before the hand closes, metres, (n, k, 3).

    Fingers and thumb stand off the two points by the grasp's gap; their pads are beside them.
    """
    boxes = hand_boxes(hand)
    behind, side, across = (
        np.array(values) for values in zip(*((b.behind_m, b.side, b.across_m) for b in boxes), strict=True)
    )
    beside = side * (grasps.widths_m / 2 + grasps.gaps_m + hand.finger_thickness_m / 2)[:, None]
    local = np.stack((np.broadcast_to(-behind, beside.shape), beside, np.broadcast_to(across, beside.shape)), axis=2)
    return np.asarray(grasps.centers[:, None] + local @ hand_frames(grasps).transpose(0, 2, 1))


# --- Pairs of opposite points of an object's surface, between which a hand could close (5.1.3).
#
# From each of many points of the surface, a ray goes through the object along the inward normal. Where it leaves the
# object by a face that is opposed to the first, the two points make a pair: those of a wall, and, as far as the hand
# opens, those of what is hollow behind it, as the two sides of a mug. All of it happens in the object's own frame.

INSIDE_M = 1e-5
"""How deep beneath the surface a ray starts."""
SAME_M = 1e-4
THINNING = 4
"""Points that share a cell of this fraction of the spacing count once: small and fine shapes have more than needed."""
MOST = 800
"""A shape with more points is sampled in coarser cells, up to the whole spacing (ours)."""


@dataclass(frozen=True, eq=False)
class Pairs:
    """Opposite points of an object's surface, in the object's frame.

    Attributes:
        centers: Half-way between the two points of each pair, metres, (n, 3).
        closings: Unit directions from one point to the other, (n, 3).
        widths_m: How far they are apart, (n,).
        shapes: The seen shapes that they lie on, (n, 2).
    """

    centers: Array
    closings: Array
    widths_m: Array
    shapes: Indices

    def take(self, rows: Indices | Mask) -> Pairs:
        """Some of them."""
        return Pairs(self.centers[rows], self.closings[rows], self.widths_m[rows], self.shapes[rows])


def opposite_points(bench: Stage, name: str, settings: Grasp, within_m: float) -> Pairs:
    """Distinct pairs of opposite points of an object.

    Args:
        bench: A stage on which the object's frame is the world's.
        name: The object.
        settings: How densely to sample, and how opposed the faces must be.
        within_m: Behind the first face that a ray leaves by, others count up to this far from where it began.
    """
    shapes = bench.scene.seen_geoms(name)
    points, normals, of_shape = _surface(bench, shapes, settings.cell_m)
    starts = points - INSIDE_M * normals
    back_m = np.full(len(starts), np.inf)
    for shape in np.unique(of_shape):
        rows = of_shape == shape
        back_m[rows] = bench.cast_each([shape], starts[rows], normals[rows])[1]
    found = np.isfinite(back_m)
    starts, normals, of_shape, back_m = starts[found], normals[found], of_shape[found], back_m[found]
    rows, exits, through_m = _exits(bench, shapes, starts, -normals, within_m, math.cos(settings.opposed_rad))
    pairs = Pairs(
        centers=starts[rows] + normals[rows] * ((back_m[rows] - through_m) / 2)[:, None],
        closings=-normals[rows],
        widths_m=through_m + back_m[rows],
        shapes=np.stack((of_shape[rows], exits), axis=1),
    )
    return pairs.take(_distinct(_keys(pairs)))


def _exits(
    bench: Stage, shapes: Indices, starts: Array, rays: Array, within_m: float, opposed: float
) -> tuple[Indices, Indices, Array]:
    """Where rays leave some shapes by a face opposed to the ray: which ray, the shape, and how far it is, (n,) each.

    Every ray has its first face looked at; from there it goes on while it is within the bound.
    """
    rows, passed_m = np.arange(len(starts)), np.zeros(len(starts))
    found = [(np.empty(0, np.intp), np.empty(0, np.intp), np.empty(0))]
    first = True
    while len(rows):
        met, on_m, outward = bench.cast_each(shapes, starts[rows] + rays[rows] * passed_m[:, None], rays[rows])
        through_m = passed_m + on_m
        counts = (met >= 0) & (first | (through_m <= within_m))
        leaves = counts & (np.einsum("ij,ij->i", outward, rays[rows]) >= opposed)
        found.append((rows[leaves], met[leaves].astype(np.intp), through_m[leaves]))
        goes_on = counts & (through_m < within_m)
        rows, passed_m, first = rows[goes_on], through_m[goes_on] + INSIDE_M, False
    each, exits, through = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return each, exits, through


def _surface(bench: Stage, shapes: Indices, spacing_m: float) -> tuple[Array, Array, Indices]:
    """Points and outward normals of shapes, and the shape of each; a fine mesh is thinned."""
    points, normals, of_shape = [np.empty((0, 3))], [np.empty((0, 3))], [np.empty(0, dtype=np.intp)]
    for shape in shapes:
        inner, outward = inner_points(bench.scene.model, int(shape), spacing_m)
        if not len(inner):
            continue
        kept = _thinned(inner, outward, spacing_m)
        pose = bench.geom(int(shape))
        points.append(pose.to_world(inner[kept]))
        normals.append(outward[kept] @ pose.matrix.T)
        of_shape.append(np.full(len(kept), shape))
    return np.concatenate(points), np.concatenate(normals), np.concatenate(of_shape)


def _thinned(points: Array, normals: Array, spacing_m: float) -> Indices:
    """Points of which none share a cell and a side of the surface: in fine cells, or in coarser ones if they are many.

    Small parts of a large shape, as its handle, keep a point on each of their sides; and the sides of a thin shape
    theirs at both edges and amid: whichever way up it lies, fingers come to the upper one.
    """
    cell_m = spacing_m / THINNING
    thin_m = np.maximum(np.ptp(points, axis=0) / 2, SAME_M)
    while True:
        cells = np.round(points / np.minimum(cell_m, thin_m))
        kept = _distinct(np.concatenate((cells, np.round(2 * normals)), axis=1))
        if len(kept) <= MOST or cell_m >= spacing_m:
            return kept
        cell_m *= 2


def _keys(pairs: Pairs) -> Array:
    """Centres and undirected closing lines, (n, 6): thumb and fingers may change places."""
    closing = np.round(pairs.closings, 4)
    leading = np.argmax(closing != 0.0, axis=1)
    signs = np.sign(closing[np.arange(len(closing)), leading])
    return np.concatenate((np.round(pairs.centers / SAME_M), closing * signs[:, None]), axis=1)


def _distinct(keys: Array) -> Indices:
    """Indices of the first row of each kind, in order."""
    return np.sort(np.unique(keys + 0.0, axis=0, return_index=True)[1])


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


BESIDE_M, INSIDE_SHAPE_M = 1.5e-3, 5e-4
"""How far beside a point of a grasp the finger is that closes on it, and how deep in a shape that counts (ours)."""


def on_outside(stage: Stage, name: str, grasps: Grasps) -> Mask:
    """Whether both points that the hand closes on are on the object's outside, (n,).

    An object that is made of pieces has faces between them, on which rays from the other side of a piece end as on any;
    fingers get to none of these.

    Args:
        stage: The scene in a state.
        name: The object.
        grasps: Grasps in its frame.
    """
    model, pose = stage.scene.model, stage.body(stage.scene.object_body(name))
    buried = np.zeros(len(grasps), dtype=bool)
    beside = grasps.closings * (grasps.widths_m / 2 + BESIDE_M)[:, None]
    for points in (grasps.centers - beside, grasps.centers + beside):
        placed = pose.to_world(points)
        for solid in grasps.solids.tolist():
            outside_m = distances_outside_m(model, solid, stage.geom(solid).to_local(placed), within_m=0.0)
            buried |= outside_m < -INSIDE_SHAPE_M
    return ~buried


def in_itself(bench: Stage, grasps: Grasps, hand: Hand | Palms) -> Mask:
    """Whether the open hand, or its way, is in the object otherwise than by design, (n,).

    Quick tests for all grasps at once settle most of them; the others are measured.

    Args:
        bench: A stage on which the object's frame is the world's.
        grasps: Grasps in that frame.
        hand: What is to grasp.
    """
    frames, centers = hand_frames(grasps), hand_centers(grasps, hand)
    found, near = _settled(bench, grasps, hand, frames, centers)
    ghosts = ghosts_with(bench.scene, hand)
    boxes = {int(ghost): box for box, ghost in enumerate(ghosts)}
    columns = {int(solid): column for column, solid in enumerate(grasps.solids)}
    for index in np.flatnonzero(near.any(axis=(1, 2)) & ~found):
        bench.place(ghosts, centers[index], frames[index].reshape(9))
        suspects = grasps.solids[near[index].any(axis=0)]
        found[index] = any(
            depth_m > TOUCH_M and near[index, boxes[ghost], columns[other]]
            for ghost, other, depth_m in bench.overlaps(ghosts, suspects)
        )
    return found


def _settled(bench: Stage, grasps: Grasps, hand: Hand | Palms, frames: Array, centers: Array) -> tuple[Mask, Mask]:
    """Which grasps surely are in the object, (n,), and which box of which may be in which solid shape, (n, boxes, k).

    A box is in a shape if one of its points is; it is not if one of its faces keeps the shape apart.
    """
    boxes, model = hand_boxes(hand), bench.scene.model
    half = np.array([box.half_m for box in boxes]) - TOUCH_M
    closing = [row for row, box in enumerate(boxes) if box.side]
    near = np.zeros((len(grasps), len(boxes), len(grasps.solids)), dtype=bool)
    found = np.zeros(len(grasps), dtype=bool)
    for column, solid in enumerate(grasps.solids.tolist()):
        pose = bench.geom(solid)
        counts = np.repeat(~found[:, None], len(boxes), axis=1)
        counts[:, closing] &= ~grasps.touching[:, column, None]
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


def _meets(bench: Stage, shapes: Indices, start: Array, direction: Array, within_m: float) -> bool:
    distance_m = float(bench.cast(start, direction[None], only=shapes)[1][0])
    return 0 <= distance_m <= within_m


def ghosts_with(scene: Scene, hand: Hand | Palms) -> Indices:
    """Shapes of a virtual grasp by such a hand, or by two, of some agent that has it; in the order of its boxes."""
    for agent in map(scene.agent, scene.agents):
        own = agent.profile.hand
        if own == hand:
            return agent.arms[0].ghosts
        if own is not None and own.palms == hand and len(agent.arms) > 1:
            return np.array([agent.arm(side).flat_ghost for side in SIDES])
    raise AssertionError("grasps are asked for a hand of the scene")


SIDES = ("left", "right")
"""Whose hand is on the thumb's side and on the fingers' side of what two hands hold."""


# --- Sampling, once for each form.

ROUNDING = 1e-9
REMEMBERED = 256
"""Sampled objects kept for each scene, and forms kept for all of them."""
IDENTITY = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def sample_grasps(stage: Stage, name: str, hand: Hand | Palms, settings: Grasp) -> Grasps:
    """Grasps of an object where it is now, in the world.

    Args:
        stage: The scene in a state.
        name: The object.
        hand: What is to grasp it.
        settings: How densely to sample.
    """
    return grasps_in_object(stage, name, hand, settings).placed(stage.body(stage.scene.object_body(name)))


def grasps_in_object(stage: Stage, name: str, hand: Hand | Palms, settings: Grasp) -> Grasps:
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


def _of_its_form(bench: Stage, name: str, hand: Hand | Palms, settings: Grasp) -> Grasps:
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


def _sampled(bench: Stage, name: str, hand: Hand | Palms, settings: Grasp) -> Grasps:
    pairs = opposite_points(bench, name, settings, hand.opening_m + ROUNDING)
    narrowest_m = float(pairs.widths_m.min()) if len(pairs.widths_m) else None
    least_m = hand.least_m if isinstance(hand, Palms) else 0.0
    pairs = pairs.take((pairs.widths_m <= hand.opening_m + ROUNDING) & (pairs.widths_m > least_m - ROUNDING))
    grasps = _around(bench, name, _both_ways(pairs) if hand.one_sided else pairs, narrowest_m, settings)
    if isinstance(hand, Hand) and hand.kind == "three_finger":
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


def _opened(bench: Stage, grasps: Grasps, hand: Hand | Palms) -> Grasps:
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
