"""Covering: where a container goes over a thing that stays where it is, open side down (9.2).

Any thing may be a cover that has room inside, on a side on which it rests: a bin, a mug, a box, a dome. Each side is
looked at from beneath, cell by cell: where rays go up into it farther than the thing is high, there is room, and the
thing's middle belongs where the walls are farthest. Then it is put down as any thing is (``placing``): its rim carried
by what carries the thing, near nothing, the thing among it::

    for candidate in covers(stage, "tape", "bin", "PR2", "P2"):
        judge(candidate.state)

Whether the thing can still be seen, say through the gap beneath a handle, is for the judge.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from taskgist.common.arrays import Array
from taskgist.maps.places import Ground
from taskgist.planning.placing import CLEAR_M, EVEN_M, HEADINGS, Asking, Candidate, carried, free
from taskgist.planning.resting import Face, Side, level_faces
from taskgist.settings import DEFAULT, Settings
from taskgist.world.contacts import support_of
from taskgist.world.geometry.transforms import about_z, matrix_from_wxyz
from taskgist.world.stage import Stage

CELL_M = 0.005
"""Breadth of the cells in which room inside a cover is looked for."""
BENEATH_M = 0.002
"""From how far beneath its rim."""
SPOTS = 3
"""So many places of the thing within a cover are tried: the middle of the room, and others as far from walls."""
UP = np.array([0.0, 0.0, 1.0])
AROUND = np.array([UP, *((math.cos(angle), math.sin(angle), 0.0) for angle in 2 * math.pi * np.arange(36) / 36)])
"""Up, and level all round."""


def covers(
    stage: Stage,
    thing: str,
    cover: str,
    performer: str,
    target: str,
    settings: Settings = DEFAULT,
    *,
    seed: int = 0,
) -> Iterator[Candidate]:
    """Where a thing may be put over another, which stays where it is; the roomiest first.

    Args:
        stage: The scene in the state from which to start; it is left as it is.
        thing: What is covered.
        cover: What covers it.
        performer: Who is to bring it there.
        target: For whom.
        settings: For what rests on what.
        seed: Of the question, as for ``candidates``.

    Yields:
        Candidates of the cover, whose carrier is what carries the thing; none if it has no room for it.

    Raises:
        InputError: The cover has no shape.
        UnknownNameError: There is no such thing or agent.
    """
    carrier = support_of(stage, thing, settings.contact)
    if carrier is None or not stage.state.known([cover]):
        return
    asking = Asking.of(Stage(stage.scene, stage.state), cover, performer, target, settings, seed)
    own = asking.stage.scene.seen_geoms(thing)
    low, high = asking.stage.bounds(own)
    middle, tall_m = (low + high) / 2, float(high[2] - low[2])
    faces = [
        face for face in level_faces(asking.stage, cover) if face.owner == carrier and _is_beneath(face, middle, low[2])
    ]
    ground = Ground(asking.stage.show(asking.start), settings, but=cover)
    rooms = [(side, spot) for side in asking.sides for spot in _room(asking, side, tall_m + CLEAR_M)]
    for face in faces:
        for heading in HEADINGS:
            turned = matrix_from_wxyz(about_z(face.yaw_rad + heading))
            for side, spot in rooms:
                # The point is beneath the cover's centre of mass; the thing's middle is to be at the spot.
                point = middle - turned @ np.array([*(spot - side.center[:2]), 0.0])
                for put in carried(ground, face, np.array([[*point[:2], face.height_m]]), [(side, heading)]):
                    found = free(asking, face, put, ("put_on", "put_in"))
                    if found is not None and _encloses(asking, found, middle):
                        yield replace(found, means="put_over", carrier=carrier)


def _is_beneath(face: Face, middle: Array, lowest_m: float) -> bool:
    """Whether a face is what a thing stands on."""
    inward = np.linalg.solve(face.edges[:, :2].T, (middle - face.corner)[:2])
    return bool((inward >= 0.0).all() and (inward <= 1.0).all() and abs(face.height_m - lowest_m) <= 3 * EVEN_M)


def _room(asking: Asking, side: Side, tall_m: float) -> list[Array]:
    """Where the middle of a thing so tall may be in a cover that lies on a side, from its body's origin, (2,) each."""
    stage, geoms = asking.stage, asking.stage.scene.seen_geoms(asking.thing)
    stage.show(asking.with_thing(np.zeros(3), side.wxyz))
    low, high = stage.bounds(geoms)
    counts = np.maximum(1, np.ceil((high[:2] - low[:2]) / CELL_M)).astype(int)
    x, y = (low[k] + (np.arange(counts[k]) + 0.5) * (high[k] - low[k]) / counts[k] for k in range(2))
    cells = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    starts = np.column_stack((cells, np.full(len(cells), low[2] - BENEATH_M)))
    met, far_m, _ = stage.cast_each(geoms, starts, np.tile(UP, (len(cells), 1)))
    roomy = (met >= 0) & (far_m >= tall_m + BENEATH_M)  # what sees the sky is not beneath anything
    if not roomy.any():
        return []
    inside, walls = cells[roomy], np.concatenate((cells[~roomy], _around(low, high)))
    away_m = np.round(np.linalg.norm(inside[:, None] - walls, axis=2).min(axis=1), 4)
    found: list[Array] = []
    for row in np.argsort(-away_m, kind="stable").tolist():
        if all(np.linalg.norm(inside[row] - other) > 2 * CELL_M for other in found):
            found.append(inside[row])
        if len(found) == SPOTS:
            break
    return found


def _around(low: Array, high: Array) -> Array:
    """Points along the edge of a rectangle, (n, 2)."""
    shares = np.linspace(0.0, 1.0, max(2, math.ceil(float((high - low)[:2].max()) / CELL_M)))
    edges = [(share, end) for share in shares for end in (0.0, 1.0)] + [(e, s) for s in shares for e in (0.0, 1.0)]
    return np.asarray(low[:2] + np.array(edges) * (high - low)[:2])


def _encloses(asking: Asking, candidate: Candidate, middle: Array) -> bool:
    """Whether a cover is above a thing's middle, and its walls all around: a container upside down (5.3.1)."""
    stage, settings = asking.stage.show(candidate.state), asking.settings.contact
    geoms = stage.scene.seen_geoms(candidate.thing)
    met, far_m, normals = stage.cast_each(geoms, np.tile(middle, (len(AROUND), 1)), AROUND)
    faces = (met >= 0) & (np.sum(normals * AROUND, axis=1) < 0)
    walls = faces[1:] & (far_m[1:] <= settings.container_m)
    return bool(faces[0]) and float(walls.mean()) >= settings.container_walls
