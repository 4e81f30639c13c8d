"""How things can rest: the sides that they can lie on, and the level faces that can carry them, in order.

A rigid thing rests on a face of its convex hull if its centre of mass is above that face's polygon. How firmly it rests
is the angle by which it may be tipped before it falls over an edge: a cup stands on its foot (20°), no pen on its tip
(4°). What is round has no such face, or only at its ends; it keeps the side that it rests on, else the one on which its
centre of mass is lowest. Mass is spread as MuJoCo says. Example::

    for side in sides_of(stage, "book"):
        side.wxyz, side.lowest_m  # how its body is turned, and how far its lowest point is beneath the body's origin
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
from scipy.spatial import ConvexHull

from taskgist.common.arrays import Array, Mask
from taskgist.settings import Contact, Settings
from taskgist.world.bodies.agent import standing_height_m, subtree
from taskgist.world.contacts import support_of
from taskgist.world.geometry.shapes import hull_triangles, surface_points
from taskgist.world.geometry.transforms import conjugate, matrix_from_wxyz, multiply, rotate
from taskgist.world.stage import Stage

TIP_RAD = math.radians(5.0)
"""A thing that may be tipped by less before it falls is not put down so (ours: the error with which it is put down)."""
AROUND = 72
"""Points around what is round: what lies on a facet between two of them, 2.5° to both sides, does not count as firm."""
IN_FACE_M, TOUCHING_M = 2e-6, 5e-4
"""Points of the hull no farther above a face's plane belong to it; and such of the surface touch what it lies on."""
ALIKE_RAD = math.radians(2.0)
"""Faces that are less inclined to each other are one."""
AS_NOW_RAD = math.radians(15.0)
"""A side that would be down after a lesser turn is the one that is down now: tracked things are a little inclined."""
BASE_POINTS, BASE_SPACING_M = 24, 0.01
"""How many points stand for all that touches a support, and as many again for the middle; they are of a sampling so
dense."""
INNER = 0.6
"""The middle is what is nearer to the centre of mass than this share of how far its edge is."""
DIRECTIONS = np.stack([(math.cos(angle), math.sin(angle)) for angle in 2 * math.pi * np.arange(48) / 48])
"""In which it is asked how far a centre of mass is from the edge of what is beneath, (48, 2)."""


@dataclass(frozen=True, eq=False)
class Side:
    """A side that a thing can lie on.

    Attributes:
        wxyz: How its body is turned, (4,), but for turns about the vertical.
        base: Points that touch the support, metres from the body's origin, turned so, (48, 3); some may be equal.
        center: The centre of mass, metres from the body's origin, turned so, (3,).
        extent_m: Lowest and highest point, metres from the body's origin.
        firm_m: How far the centre of mass is from the edge of the base, seen from above.
        tip_rad: By how much it may be tipped before it falls; 0 if it may roll.
    """

    wxyz: Array
    base: Array
    center: Array
    extent_m: tuple[float, float]
    firm_m: float
    tip_rad: float

    @property
    def lowest_m(self) -> float:
        """Where the support is, from the body's origin upwards, metres; mostly negative."""
        return self.extent_m[0]


@dataclass(frozen=True, eq=False)
class Body:
    """A thing as a rigid body, in its own frame.

    Attributes:
        points: Its convex hull's corners, metres, (n, 3).
        surface: Points all over its solid surface, metres, (m, 3).
        center: Its centre of mass, (3,).
    """

    points: Array
    surface: Array
    center: Array

    @classmethod
    def of(cls, stage: Stage, thing: str) -> Body:
        """A thing as it is in the state that a stage shows: its lids stay where they are.

        Raises:
            UnknownNameError: There is no such object.
        """
        scene = stage.scene
        model, root = scene.model, scene.object_body(thing)
        frame = stage.body(root)
        corners, surface = [], []
        for geom in scene.solid_geoms_of(thing).tolist():
            pose = stage.geom(geom)
            corners.append(frame.to_local(pose.to_world(_corners(model, geom))))
            surface.append(frame.to_local(pose.to_world(surface_points(model, geom, BASE_SPACING_M)[0])))
        center = frame.to_local(stage.center_of_mass(np.array(subtree(model, root), dtype=np.intp)))
        points = np.concatenate(corners)
        return cls(points[ConvexHull(points).vertices], np.concatenate((points, *surface)), center)

    @cached_property
    def faces(self) -> tuple[Array, Array]:
        """Outward unit normals of the hull's triangles, (k, 3), and their corners, metres, (k, 3, 3)."""
        hull = ConvexHull(self.points)
        return hull.equations[:, :3], self.points[hull.simplices]

    @cached_property
    def firm_normals(self) -> Array:
        """Outward unit normals of the hull's faces that may carry it firmly, each once, (k, 3)."""
        normals, corners = self.faces
        offsets = corners - self.center
        heights_m = np.einsum("kij,kj->ki", offsets, normals)
        across_m = np.sqrt(np.maximum((offsets**2).sum(axis=2) - heights_m**2, 0.0)).max(axis=1)
        wide = across_m >= math.tan(TIP_RAD) * heights_m.mean(axis=1)  # most facets of round things are not
        return np.unique(np.round(normals[wide], 6), axis=0)

    def tip_rad(self, normal: Array) -> float:
        """By how much it may be tipped, lying on the face of a normal, before it falls."""
        along = self.points @ normal
        face = self.points[along >= along.max() - IN_FACE_M]
        first = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
        first /= np.linalg.norm(first)
        flat = (face - self.center) @ np.stack((first, np.cross(normal, first)), axis=1)
        firm_m = float(firmness_m(flat[None], np.ones((1, len(flat)), dtype=bool))[0])
        return math.atan2(firm_m, float(along.max() - normal @ self.center))

    def side(self, wxyz: Array) -> Side:
        """The side that is down when the body is turned so."""
        turn = matrix_from_wxyz(wxyz)
        points, center = self.points @ turn.T, turn @ self.center
        lowest_m, highest_m = float(points[:, 2].min()), float(points[:, 2].max())
        touching = np.concatenate((points, self.surface @ turn.T))
        touching = touching[touching[:, 2] <= lowest_m + TOUCHING_M]
        firm_m = float(firmness_m(touching[None, :, :2] - center[:2], np.ones((1, len(touching)), dtype=bool))[0])
        near = np.linalg.norm(touching[:, :2] - center[:2], axis=1) <= INNER * firm_m
        base = np.concatenate((_spread(touching), _spread(touching[near] if near.any() else touching)))
        return Side(wxyz, base, center, (lowest_m, highest_m), firm_m, self.tip_rad(-turn[2]))


def _corners(model: mujoco.MjModel, geom: int) -> Array:
    """Points whose hull is a shape, in its frame, metres, (n, 3); round shapes by points all around."""
    kind, size = int(model.geom_type[geom]), np.array(model.geom_size[geom])
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        return np.unique(hull_triangles(model, int(model.geom_dataid[geom])).reshape(-1, 3), axis=0)
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return surface_points(model, geom, math.inf)[0]
    radius_m = size.max() if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID else size[0]
    return surface_points(model, geom, 2 * math.pi * float(radius_m) / AROUND)[0]


def _spread(points: Array) -> Array:
    """So many of some points, those at the rim first, each as far from the others as can be, (24, 3)."""
    away = np.linalg.norm(points - points.mean(axis=0), axis=1)
    chosen = []
    for _ in range(BASE_POINTS):
        chosen.append(int(np.argmax(np.round(away, 6))))
        gaps = np.linalg.norm(points - points[chosen[-1]], axis=1)
        away = gaps if len(chosen) == 1 else np.minimum(away, gaps)
    return np.asarray(points[chosen])


def firmness_m(offsets: Array, touching: Mask) -> Array:
    """How far centres of mass are from the edges of what is beneath them, metres, (n,); negative: they fall.

    Args:
        offsets: Points of each base from above, from the centre of mass, metres, (n, k, 2).
        touching: Which of them touch a support, (n, k).
    """
    reach = np.where(touching[:, :, None], offsets @ DIRECTIONS.T, -np.inf)
    return np.asarray(reach.max(axis=1).min(axis=1))


def sides_of(stage: Stage, thing: str, settings: Contact) -> tuple[Side, ...]:
    """The sides on which a thing rests firmly: the one that is down now first, then by how firmly it rests.

    What is round keeps the side on which it rests, firm or not. A thing with joints of its own, such as a box with a
    lid, keeps it as well, for it would open.

    Args:
        stage: The scene in a state.
        thing: An object.
        settings: For what supports it now.

    Raises:
        UnknownNameError: There is no such object.
    """
    body = Body.of(stage, thing)
    now = np.array(stage.state.qpos[stage.scene.object_slice(thing)][3:])
    down = rotate(conjugate(now), (0.0, 0.0, -1.0))
    firm = sorted(_firm(body, now), key=lambda side: -round(side.tip_rad, 6))
    as_now = next((side for side in firm if _inclined_rad(side.wxyz, now) <= AS_NOW_RAD), None)
    if as_now is None and support_of(stage, thing, settings) is not None:
        normals, corners = body.faces
        near = normals @ down >= math.cos(AS_NOW_RAD)
        as_now = _lowest(body, now, normals[near], corners[near]) if near.any() else None
    if as_now is None:
        return tuple(firm) or (_lowest(body, now, *body.faces),)
    return (
        (as_now,) if len(stage.scene.inner_joints(thing)) else (as_now, *(each for each in firm if each is not as_now))
    )


def _firm(body: Body, now: Array) -> list[Side]:
    """Sides on which a body rests firmly; each with the least turn from how it is turned now."""
    kept: list[Side] = []
    for normal in body.firm_normals:
        if body.tip_rad(normal) >= TIP_RAD:
            side = body.side(_down(normal, now))
            if all(_inclined_rad(side.wxyz, other.wxyz) > ALIKE_RAD for other in kept):
                kept.append(side)
    return kept


def _lowest(body: Body, now: Array, normals: Array, corners: Array) -> Side:
    """Of the sides on some faces, that with the lowest centre of mass: there a body comes to rest that may roll."""
    heights_m = np.einsum("kj,kj->k", corners[:, 0] - body.center, normals)
    inclined = -normals @ rotate(conjugate(now), (0.0, 0.0, -1.0))
    first = np.lexsort((np.round(inclined, 6), np.round(heights_m, 4)))[0]
    return body.side(_down(normals[first], now))


def _down(normal: Array, now: Array) -> Array:
    """How to turn a body, turned somehow, by the least angle so that a direction of its own points down, (4,)."""
    x, y, z = rotate(now, normal / np.linalg.norm(normal))
    if z > 1.0 - 1e-9:
        return multiply((0.0, 1.0, 0.0, 0.0), now)
    turn = np.array([1.0 - z, -y, x, 0.0])
    return multiply(turn / np.linalg.norm(turn), now)


def _inclined_rad(wxyz: Array, other: Array) -> float:
    """The angle between what is down for two turns of a body."""
    down = (0.0, 0.0, -1.0)
    cosine = rotate(conjugate(wxyz), down) @ rotate(conjugate(other), down)
    return math.acos(float(np.clip(cosine, -1.0, 1.0)))


# --- Level faces that can carry something.

LEVEL_RAD = math.radians(2.0)
"""Faces that are steeper carry nothing: a thing must rest as it was put."""
LEAST_M2 = 1e-4
"""Smaller faces carry nothing."""
MERGED_M = 0.002
"""Level triangles of a mesh whose heights differ by no more are one face."""
BEYOND_M = 0.5
"""How far an endless floor goes on beyond everything that stands on it."""


@dataclass(frozen=True, eq=False)
class Face:
    """A level face of a shape: a parallelogram that holds it.

    Attributes:
        owner: Whose it is.
        geom: The shape.
        corner: Metres, (3,).
        edges: Metres, both level, (2, 3).
    """

    owner: str
    geom: int
    corner: Array
    edges: Array

    @property
    def height_m(self) -> float:
        """Its height."""
        return float(self.corner[2])

    @property
    def sides_m(self) -> Array:
        """Lengths of its edges, (2,)."""
        return np.asarray(np.linalg.norm(self.edges, axis=1))

    @property
    def area_m2(self) -> float:
        """Its area."""
        return float(self.sides_m.prod())

    @property
    def yaw_rad(self) -> float:
        """Direction of its first edge."""
        return math.atan2(self.edges[0, 1], self.edges[0, 0])

    def points(self, shares: Array) -> Array:
        """Points at shares of its edges, (n, 2); metres, (n, 3)."""
        return np.asarray(self.corner + shares @ self.edges)


def level_faces(stage: Stage, thing: str) -> list[Face]:
    """All level faces that could carry a thing, in the order of the shapes; some may be covered.

    Args:
        stage: The scene in a state. Nobody's body carries anything.
        thing: What is to be carried; its own faces are left out.
    """
    scene = stage.scene
    out = {*scene.agents, thing}
    shapes = [g for g in np.flatnonzero(stage.seen).tolist() if scene.owners[g] not in out]
    ends = [stage.bounds_of_each(np.array([geom], dtype=np.intp))[0] for geom in shapes if not stage.is_plane(geom)]
    around = np.array([[end[0] for end in ends], [end[1] for end in ends]]) if ends else np.zeros((2, 1, 3))
    bounds = np.stack((around[0].min(axis=0) - BEYOND_M, around[1].max(axis=0) + BEYOND_M))
    found = [
        Face(scene.owners[geom], geom, corner, edges)
        for geom in shapes
        for corner, edges in _level_parts(stage, geom, bounds)
    ]
    return [face for face in found if face.area_m2 >= LEAST_M2]


def _level_parts(stage: Stage, geom: int, bounds: Array) -> Iterator[tuple[Array, Array]]:
    """Corner and edges of the level faces of a shape; of a floor, what lies within some bounds, (2, 3)."""
    model, pose = stage.scene.model, stage.geom(geom)
    kind, size = int(model.geom_type[geom]), np.array(model.geom_size[geom])
    level = math.cos(LEVEL_RAD)
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        yield from _level_parts_of_mesh(model, int(model.geom_dataid[geom]), pose.matrix, pose.position)
        return
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        half, axes = size, range(3)
    elif kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        half, axes = np.array([size[0], size[0], size[1]]), range(2, 3)
    elif kind == mujoco.mjtGeom.mjGEOM_PLANE and pose.matrix[2, 2] >= level:
        corners = pose.to_local([(bounds[i, 0], bounds[j, 1], 0.0) for i in (0, 1) for j in (0, 1)])
        low, high = corners.min(axis=0)[:2], corners.max(axis=0)[:2]
        limit = np.where(size[:2] > 0, size[:2], np.inf)
        low, high = np.maximum(low, -limit), np.minimum(high, limit)
        corner = pose.to_world((*low, 0.0))
        yield corner, np.stack([(high - low)[k] * pose.matrix[:, k] for k in range(2)])
        return
    else:
        return
    for axis in axes:
        if abs(pose.matrix[2, axis]) >= level:
            up = math.copysign(half[axis], pose.matrix[2, axis])
            first, second = (k for k in range(3) if k != axis)
            edges = np.stack([2 * half[k] * pose.matrix[:, k] for k in (first, second)])
            yield pose.position + up * pose.matrix[:, axis] - edges.sum(axis=0) / 2, edges


def _level_parts_of_mesh(
    model: mujoco.MjModel, mesh: int, matrix: Array, position: Array
) -> Iterator[tuple[Array, Array]]:
    """The boxes, seen from above, around level triangles of one height that look upwards."""
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]] @ matrix.T + position
    corners = vertices[model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    level = (normals[:, 2] >= math.cos(LEVEL_RAD) * lengths) & (lengths > 0)
    corners = corners[level]
    heights = corners[:, :, 2].mean(axis=1)
    order = np.argsort(heights, kind="stable")
    for group in np.split(order, np.flatnonzero(np.diff(heights[order]) > MERGED_M) + 1):
        if len(group):
            points = corners[group].reshape(-1, 3)
            low, high = points.min(axis=0), points.max(axis=0)
            corner = np.array([low[0], low[1], heights[group].mean()])
            yield corner, np.array([[high[0] - low[0], 0.0, 0.0], [0.0, high[1] - low[1], 0.0]])


# --- The order of supports.

LOW_M = 0.05
"""What is no higher above where the performer stands is the floor: carpets, thresholds."""
SEAT_HEIGHT_M, SEAT_M, UNDER_HEAD_M = (0.3, 0.55), 0.25, 0.8
"""Seats are so high and so wide, with nothing of their own that far above (ours: people sit on low tables, too)."""
LEDGE_M = 0.06
"""What is narrower is a ledge (ours): tops of doors, of chairs' backs, of bins' walls; narrow shelves are wider."""
WALLS, ABOVE_M = 36, 0.03
"""In how many directions, and how far above a face, its owner's walls are looked for: all round, it is a container."""


def tiers(
    stage: Stage,
    faces: list[Face],
    performer: str,
    settings: Settings,
    *,
    allow: Collection[str] | None,
    prefer: Collection[str],
) -> list[list[Face]]:
    """Faces in the order in which they are tried: preferred ones, others, seats and ledges, floors.

    Args:
        stage: The scene in a state.
        faces: All level faces.
        performer: Who stands on the floor, with its feet, or its wheels.
        settings: For what a container is, which is no seat.
        allow: Whose faces are tried at all, seats and floors as others are; None: everybody's.
        prefer: Whose faces come first.

    Returns:
        Four lists.
    """
    agent = stage.scene.agent(performer)
    qpos = stage.state.qpos
    floor_m = float(qpos[agent.base][2]) - standing_height_m(stage.scene.model, agent, qpos)
    found: list[list[Face]] = [[], [], [], []]
    for face in faces:
        if face.owner in prefer:
            found[0].append(face)
        elif allow is not None:
            found[1] += [face] if face.owner in allow else []
        elif face.height_m <= floor_m + LOW_M and not _walled(stage, face, settings.contact):
            found[3].append(face)
        else:
            last = _is_ledge(face) or _is_seat(stage, face, face.height_m - floor_m, settings.contact)
            found[2 if last else 1].append(face)
    return found


def _is_ledge(face: Face) -> bool:
    """Whether it is so narrow that people put things there only for want of better: backs of chairs, rims of bins."""
    return bool(face.sides_m.min() < LEDGE_M)


def _is_seat(stage: Stage, face: Face, height_m: float, settings: Contact) -> bool:
    """Whether somebody could sit there: a seat's height and size, nothing of its own above, nor all round."""
    if not SEAT_HEIGHT_M[0] <= height_m <= SEAT_HEIGHT_M[1] or face.sides_m.min() < SEAT_M:
        return False
    above_m = _own_away_m(stage, face, np.array([(0.0, 0.0, 1.0)]))[0]
    return bool(above_m > UNDER_HEAD_M) and not _walled(stage, face, settings)


def _walled(stage: Stage, face: Face, settings: Contact) -> bool:
    """Whether its owner's walls are all round it, as around the bottom of a bin."""
    angles = 2 * math.pi * np.arange(WALLS) / WALLS
    away_m = _own_away_m(stage, face, np.stack((np.cos(angles), np.sin(angles), np.zeros(WALLS)), axis=1))
    return bool((away_m <= settings.container_m).mean() >= settings.container_walls)


def _own_away_m(stage: Stage, face: Face, ways: Array) -> Array:
    """How far its owner's other shapes are from a face's middle, along some directions (n, 3): metres, (n,)."""
    own = np.setdiff1d(stage.scene.geoms_of(face.owner), [face.geom])
    middle = face.points(np.full((1, 2), 0.5)) + (0.0, 0.0, ABOVE_M)
    _, away_m, _ = stage.cast_each(own, np.tile(middle, (len(ways), 1)), ways)
    return np.asarray(away_m)
