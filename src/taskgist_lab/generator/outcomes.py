"""What a performer sees to: it goes through nothing and stays within its limits, and its intention is fulfilled."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations
from typing import Literal

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.errors import SceneError
from taskgist.recording.recording import Pair, Recording
from taskgist.world.contacts import object_points, overlaps
from taskgist.world.geometry.transforms import normalized
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist_lab.simulator.demonstration import Script
from taskgist_lab.simulator.means import Means, Roles
from taskgist_lab.simulator.places import SUPPORT_SPACING_M

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
    for thing in label.target_objects:
        for point in _beneath(stage, thing):
            body = scene.object_body(thing)
            (geom,), (distance,) = stage.cast(point, [(0.0, 0.0, -1.0)], exclude_body=body)
            if geom < 0 or distance > 2 * SPACING_M or scene.owners[geom] in scene.agents:
                raise SceneError(
                    f"{thing!r} would fall",
                    where=recording.name,
                    field="end",
                    hint="try another room",
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
            hint="try another room",
        )


# --- Lines of sight: what a performer knows of what another can see, by straight lines from the other's eye.

HEAD_MOVES_M = 0.05 * np.array([(0, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)])
"""Nobody keeps the head quite still: what is hidden is hidden from these places around the eye, too."""
INWARD = 0.03
"""How much nearer to its middle than its surface a thing is looked at: lines to its very edges would miss it."""
SHOWN_SHARE = 0.4
"""What is shown is in view to so much, at least: fingers may cover the rest."""


def share_in_view(stage: Stage, target: str, thing: str) -> float:
    """Share of the lines from somebody's eye to a thing that nothing else is on, as the stage shows them."""
    agent = stage.scene.agent(target)
    eye = stage.eye(agent).position
    points = object_points(stage, thing, SUPPORT_SPACING_M)
    lines = points + INWARD * (points.mean(axis=0) - points) - eye
    geoms, _ = stage.cast(eye, normalized(lines), exclude_body=agent.eye_exclude_body)
    return float(np.isin(geoms, stage.scene.seen_geoms(thing)).mean())


def would_be_hidden(stage: Stage, target: str, thing: str, points: Array, *, but: tuple[str, ...] = ()) -> bool:
    """Whether something is on every line from around somebody's eye to where a thing's points (n, 3) would be.

    Args:
        stage: The scene.
        target: Who looks.
        thing: The thing; where it is now does not count.
        points: Where points of its surface would be.
        but: Owners that do not count, because they will not stay where they are.
    """
    agent, owners = stage.scene.agent(target), stage.scene.owners
    head, passing = stage.eye(agent), {thing, *but}
    for move in HEAD_MOVES_M:
        eye = head.to_world(move)
        lines = points - eye
        geoms, distances = stage.cast(eye, normalized(lines), exclude_body=agent.eye_exclude_body)
        blocked = (geoms >= 0) & (distances < np.linalg.norm(lines, axis=1) - 0.001)
        if not all(blocked) or any(owners[geom] in passing for geom in geoms):
            return False
    return True


def seen_first(roles: Roles, means: Means) -> Means:
    """Means of a performer who takes something out of view, and finds no sense in that if it is not in view."""

    def script(scene: Scene) -> Script:
        share = min(share_in_view(Stage(scene), name, roles.thing) for name in roles.targets)
        if share < SHOWN_SHARE:
            raise SceneError(
                f"{roles.thing!r} is not in view in the beginning",
                where=scene.name,
                value=round(share, 2),
                hint="try another room",
            )
        return means(scene)

    return script


# --- Outcomes: what a performer sees to when all is done. Was it shown, hidden, put farther off? Of several target
# agents and objects, for each of them.

HIDDEN_SHARE = 0.2
"""What comes into view was in view to no more before."""
NEARER_SHARE, NEARER_TO_EACH = 0.6, 0.85
"""What is held before the eyes is at most this share as far from them as it was; before those of several, from each."""
AWAY_M, SAME_DISTANCE_M = 0.25, 0.08
"""What is put away is so much farther off, at least; what is only hidden is no farther off than that."""
LOW_RAD = math.radians(40.0)
"""What is before the eyes is no lower than that, as seen from them: what lies on a table before somebody is lower."""
FACE_GROWS = 2.5
"""A face is turned to somebody if so many times as much of the thing's area faces the eye as before."""
FACE_LINES = 40
"""Lines across a thing, in both directions, by which its area is measured."""
When = Literal["beginning", "end"]
"""Of the labelled task."""


def check_shown(recording: Recording) -> None:
    """Refuse a demonstration at whose end the target agent has no free line of sight to the thing.

    Raises:
        SceneError: It has none.
    """
    _check_in_view(recording, "end")


def check_comes_into_view(recording: Recording) -> None:
    """Refuse a demonstration in which the thing is not hidden, mostly, at first and in view in the end.

    Raises:
        SceneError: So it is.
    """
    for pair, before in _shares_at(recording, "beginning"):
        if before > HIDDEN_SHARE:
            raise _missed(recording, pair, "is in view in the beginning", before)
    check_shown(recording)


def check_hidden(recording: Recording) -> None:
    """Refuse a demonstration at whose end the target agent has a line of sight to the thing.

    Raises:
        SceneError: It has one.
    """
    for pair, share in _shares_at(recording, "end"):
        if share > 0.0:
            raise _missed(recording, pair, "is not hidden in the end", share)


def check_seen_before(recording: Recording) -> None:
    """Refuse a demonstration at whose beginning the target agent has no line of sight to the thing.

    Raises:
        SceneError: It has none.
    """
    _check_in_view(recording, "beginning")


def check_before_eyes(recording: Recording) -> None:
    """Refuse a demonstration in which the thing is not brought before the target agent's eye.

    There it is in view, much nearer than before, and no more than ``LOW_RAD`` below the eye.

    Raises:
        SceneError: It is not.
    """
    label = recording.label
    assert label is not None
    check_shown(recording)
    share = NEARER_SHARE if len(label.target_agents) == 1 else NEARER_TO_EACH
    for pair in label.pairs:
        before, after = (_from_eye_m(recording, pair, time) for time in (label.start_s, label.end_s))
        if after > share * before:
            raise _missed(recording, pair, "is not brought before the eyes", after / before)
        below = math.asin(-float(_from_eye(recording, pair, label.end_s)[2]) / after)
        if below > LOW_RAD:
            raise _missed(recording, pair, "is below the eyes", below)


def _from_eye_m(recording: Recording, pair: Pair, time_s: float) -> float:
    """Distance of a thing from a target agent's eye."""
    return float(np.linalg.norm(_from_eye(recording, pair, time_s)))


def _from_eye(recording: Recording, pair: Pair, time_s: float) -> Array:
    """Where a thing is from a target agent's eye, metres, (3,)."""
    (agent, thing), scene = pair, recording.scene
    stage = Stage(scene, recording.at(time_s))
    place = stage.body_position(scene.object_body(thing))
    return np.asarray(place - stage.eye(scene.agent(agent)).position)


def check_turned_to_eyes(recording: Recording) -> None:
    """Refuse a demonstration in which the thing does not turn its face to the target agent's eye.

    Of its area ``FACE_GROWS`` times as much faces the eye, unhidden, as before. The area does not depend on how far off
    the eye is: what only comes nearer does not turn.

    Raises:
        SceneError: It does not.
    """
    label = recording.label
    assert label is not None
    check_shown(recording)
    for pair in label.pairs:
        before, after = (_facing_m2(recording, pair, time) for time in (label.start_s, label.end_s))
        if after < FACE_GROWS * before:
            raise _missed(recording, pair, "is not turned to the eyes", after / max(before, 1e-6))


def _facing_m2(recording: Recording, pair: Pair, time_s: float) -> float:
    """Area of a thing that faces a target agent's eye and that nothing hides, across the line of sight."""
    (agent, thing), scene = pair, recording.scene
    stage = Stage(scene, recording.at(time_s))
    eye, exclude = stage.eye(scene.agent(agent)).position, scene.agent(agent).eye_exclude_body
    points = object_points(stage, thing, SUPPORT_SPACING_M)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    radius_m = float(np.linalg.norm(points - middle, axis=1).max())
    ahead = normalized(middle - eye)
    across = normalized(np.cross(ahead, (0.0, 0.0, 1.0)))
    offsets = radius_m * np.linspace(-1.0, 1.0, FACE_LINES)
    grid = (middle + offsets[:, None, None] * across + offsets[None, :, None] * np.cross(across, ahead)).reshape(-1, 3)
    geoms, _ = stage.cast(eye, normalized(grid - eye), exclude_body=exclude)
    return float(np.isin(geoms, scene.seen_geoms(thing)).mean() * (2 * radius_m) ** 2)


def check_farther(recording: Recording) -> None:
    """Refuse a demonstration at whose end the thing is not ``AWAY_M`` farther from the target agent than before.

    Raises:
        SceneError: It is not.
    """
    label = recording.label
    assert label is not None
    for pair in label.pairs:
        farther = _farther_m(recording, pair)
        if farther < AWAY_M:
            raise _missed(recording, pair, "is not farther off in the end", farther)


def check_keeps_distance(recording: Recording) -> None:
    """Refuse a demonstration at whose end the thing is more than ``SAME_DISTANCE_M`` farther from the target agent.

    Raises:
        SceneError: It is.
    """
    label = recording.label
    assert label is not None
    for pair in label.pairs:
        farther = _farther_m(recording, pair)
        if farther > SAME_DISTANCE_M:
            raise _missed(recording, pair, "is farther off in the end", farther)


def _farther_m(recording: Recording, pair: Pair) -> float:
    """How much farther from a target agent's pelvis a thing is in the end than before, over the floor."""
    (agent, thing), label, scene = pair, recording.label, recording.scene
    assert label is not None
    places = [recording.at(time).qpos[scene.object_slice(thing)][:2] for time in (label.start_s, label.end_s)]
    pelvis = scene.initial.qpos[scene.base_slice(agent)][:2]
    before, after = (float(np.linalg.norm(place - pelvis)) for place in places)
    return after - before


def _check_in_view(recording: Recording, when: When) -> None:
    for pair, share in _shares_at(recording, when):
        if share < SHOWN_SHARE:
            raise _missed(recording, pair, f"is not in view in the {when}", share)


def _shares_at(recording: Recording, when: When) -> Iterator[tuple[Pair, float]]:
    """How much of each target object is in each target agent's view."""
    label = recording.label
    assert label is not None
    stage = Stage(recording.scene, recording.at(label.start_s if when == "beginning" else label.end_s))
    for agent, thing in label.pairs:
        yield (agent, thing), share_in_view(stage, agent, thing)


def _missed(recording: Recording, pair: Pair, what: str, share: float) -> SceneError:
    agent, thing = pair
    label = recording.label
    whose = f" for {agent!r}" if label is not None and len(label.target_agents) > 1 else ""
    return SceneError(
        f"{thing!r} {what}{whose}",
        where=recording.name,
        value=round(share, 2),
        hint="try another room",
    )
