"""Competence: what a performer sees to, whatever it does. It goes through nothing, and stays within its limits."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from taskgist.errors import SceneError
from taskgist.recording import Recording
from taskgist.world import Scene, Stage, object_points, overlaps

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

TOUCHING_M = 0.002
"""Things and people that overlap by no more touch."""
SEATED_M = 0.055
"""How deep people sink into what they sit on."""
LOOK_EVERY = 4
"""Frames between two that are looked at: 7.5 a second."""
DEEPEST_M = 0.01
"""How deep an arm may go into something: skin and cushions yield."""
DEEPEST_THING_M = 0.001
SPACING_M = 0.02
STEADY_SHARE = 0.5
"""What stands on this share of its breadth does not fall."""


def check_room(scene: Scene) -> None:
    """Refuse a room in which somebody or something is where something else is.

    Raises:
        SceneError: Two things overlap.
    """
    stage = Stage(scene)
    for (first, second), depth in {**overlaps(stage, deeper_than_m=TOUCHING_M), **_furniture(stage)}.items():
        seat = {first, second} & {f"{kind}_{name}" for name in scene.agents for kind in ("chair", "sofa")}
        if not seat or depth > SEATED_M:
            raise SceneError(
                f"{first!r} and {second!r} overlap", where=scene.name, value=round(depth, 3), hint="move one of them"
            )


def _furniture(stage: Stage) -> dict[tuple[str, str], float]:
    """Pieces of furniture that overlap, with the depth in metres."""
    scene = stage.scene
    pieces = [scene.solid_geoms_of(name) for name in scene.bodies if name not in scene.objects]
    found = {}
    for own, others in combinations(pieces, 2):
        for shape, other, depth in stage.overlaps(own, others, deeper_than_m=TOUCHING_M):
            found[scene.owners[shape], scene.owners[other]] = depth
    return found


def check_motion(recording: Recording) -> None:
    """Refuse a demonstration in which the performer, or what it carries, goes through something.

    Raises:
        SceneError: It does.
    """
    scene, label = recording.scene, recording.label
    assert label is not None
    performer, stage = scene.agent(label.performing_agent), Stage(scene)
    moved = [name for name in scene.objects if np.ptp(recording.qpos[:, scene.object_slice(name)], axis=0).max() > 0]
    around = np.array([g for g in stage.solid_geoms() if scene.owners[g] not in (performer.name, *moved)])
    arms = np.concatenate([arm.geoms for arm in performer.arms])
    core = np.array(
        [g for g in around if scene.owners[g] not in (f"chair_{performer.name}", f"sofa_{performer.name}", "floor")]
    )
    for index in range(0, len(recording), LOOK_EVERY):
        stage.show(recording.state(index))
        _check(stage, arms, around, DEEPEST_M)
        _check(stage, performer.core_geoms, core, DEEPEST_M)
        for name in moved:
            others = [g for g in around if g not in set(scene.solid_geoms_of(name))]
            _check(stage, scene.solid_geoms_of(name), np.array(others), DEEPEST_THING_M)


def check_stands(recording: Recording) -> None:
    """Refuse a demonstration that leaves the thing where it would fall: beyond the edge of what it stands on.

    Raises:
        SceneError: It does.
    """
    label, scene = recording.label, recording.scene
    assert label is not None
    stage = Stage(scene, recording.at(label.end_s))
    for point in _beneath(stage, label.target_object):
        body = scene.object_body(label.target_object)
        (geom,), (distance,) = stage.cast(point, [(0.0, 0.0, -1.0)], exclude_body=body)
        if geom < 0 or distance > 2 * SPACING_M or scene.owners[geom] in scene.agents:
            raise SceneError(
                f"{label.target_object!r} would fall", where=recording.name, field="end", hint="draw another room"
            )


def _beneath(stage: Stage, thing: str) -> Array:
    """Four points a little above a thing's underside, around its middle, (4, 3)."""
    points = object_points(stage, thing, SPACING_M)
    low, high = points.min(axis=0), points.max(axis=0)
    middle = np.array([*((low + high) / 2)[:2], low[2] + SPACING_M])
    corners = np.array([(x, y, 0.0) for x in (-1, 1) for y in (-1, 1)])
    return np.asarray(middle + corners * STEADY_SHARE * (high - low) / 2)


def _check(stage: Stage, shapes: Indices, around: Indices, deepest_m: float) -> None:
    gap, shape, other = stage.closest(shapes, around, limit_m=0.0)
    if gap < -deepest_m:
        owners = stage.scene.owners
        raise SceneError(
            f"{owners[shape]!r} would go through {owners[other]!r}",
            where=stage.scene.name,
            value=round(-gap, 3),
            hint="draw another room",
        )
