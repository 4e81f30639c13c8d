"""What carries an object: geometry of one state (5.3.1), remembered while nothing changes.

It rests on something, lies in it, is held by hands, touches somebody's body, or hangs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.settings import Contact
from taskgist.world.bodies.agent import Agent, ArmIndices
from taskgist.world.geometry.shapes import lowest_point
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import Hold

DOWN = np.array([0.0, 0.0, -1.0])
UP = -DOWN
ROUNDING = 1e-6
POINT_SPACING_M = 0.03
"""Spacing of the points of an object's surface under which a support is searched."""
WALL_DIRECTIONS = 36


def object_points(stage: Stage, name: str, spacing_m: float) -> Array:
    """Points on an object's surface in the world, metres, (n, 3).

    Raises:
        UnknownNameError: There is no such object.
    """
    stage.scene.object_body(name)
    parts = []
    for geom in stage.scene.seen_geoms(name):
        points, _ = stage.scene.surface_points(int(geom), spacing_m)
        parts.append(stage.geom(int(geom)).to_world(points))
    return np.concatenate(parts) if parts else np.empty((0, 3))


@dataclass(frozen=True)
class Rest:
    """What an object rests on, and what it lies in; None: nothing."""

    support: str | None
    container: str | None


def rest_of(stage: Stage, name: str, settings: Contact) -> Rest:
    """What an object rests on and lies in, in the state that a stage shows."""
    return Rest(support_of(stage, name, settings), container_of(stage, name, settings))


@dataclass(frozen=True, eq=False)
class Drop:
    """Points of an object's surface, lifted to one height and dropped: what they meet carries it.

    Attributes:
        name: The object.
        starts: The lifted points, lowest first, metres, (n, 3).
        lifts_m: By how much each was lifted, metres, (n,).
    """

    name: str
    starts: Array
    lifts_m: Array

    @classmethod
    def of(cls, stage: Stage, name: str, settings: Contact) -> Drop:
        """Those of an object where it is."""
        samples = object_points(stage, name, POINT_SPACING_M)
        points = _low_points(stage, name, samples)
        if not len(points):
            return cls(name, points, np.empty(0))
        # No higher than its middle, so that what is above the object is not taken for its support: unless its middle
        # is in something, into whose upper face it was tracked.
        lowest_m = float(points[0, 2])
        lift_m = min(settings.lift_m, float(np.ptp(samples[:, 2])) / 2)
        if lift_m < settings.support_m:
            lift_m = max(lift_m, _sunk_m(stage, name, lowest_m, settings))
        low = points[points[:, 2] <= lowest_m + lift_m + ROUNDING]
        lifts_m = lowest_m + lift_m - low[:, 2]
        return cls(name, low + lifts_m[:, None] * UP, lifts_m)

    def around(self, stage: Stage, settings: Contact) -> Indices:
        """Seen shapes that the points may meet, but those of the object's own body, (n,)."""
        if not len(self.starts):
            return np.empty(0, dtype=np.intp)
        (middle, radius_m), body = self._ball, stage.scene.object_body(self.name)
        return stage.between(middle, middle[None], np.array([radius_m + settings.support_m]), but_body=body)

    @cached_property
    def _ball(self) -> tuple[Array, float]:
        """Middle and radius of a ball around the points where they are and where they were lifted from, metres."""
        middle = self.starts.mean(axis=0)
        return middle, float(np.linalg.norm(self.starts - middle, axis=1).max() + self.lifts_m.max())

    def meets(self, stage: Stage, around: Indices, settings: Contact) -> str | None:
        """The owner of the surface on which the lowest point lands that meets a nearly level one, or None."""
        geoms, _ = self._landing(stage, around, settings)
        return stage.scene.owners[int(geoms[0])] if len(geoms) else None

    def seat_m(self, stage: Stage, around: Indices, settings: Contact) -> float | None:
        """How far up the object must be moved to lie on such surfaces, metres; None if it meets none.

        What its points are in deeper than ``support_m`` stands beside it.
        """
        _, gaps_m = self._landing(stage, around, settings)
        carries = gaps_m >= -settings.support_m - ROUNDING
        return -float(gaps_m[carries].min()) if carries.any() else (0.0 if len(gaps_m) else None)

    def _landing(self, stage: Stage, around: Indices, settings: Contact) -> tuple[Indices, Array]:
        """The nearly level surfaces on which points land, lowest point first, and how far beneath the points."""
        geoms, distances, normals = stage.cast_each(around, self.starts, np.tile(DOWN, (len(self.starts), 1)))
        scene = stage.scene
        counts = (geoms >= 0) & (normals[:, 2] >= math.cos(settings.support_slope_rad))
        counts &= distances - self.lifts_m <= settings.support_m
        for geom in np.unique(geoms[counts]).tolist():
            counts[geoms == geom] &= scene.owners[geom] != self.name and scene.owners[geom] not in scene.agents
        rows = np.flatnonzero(counts)
        return geoms[rows], (distances - self.lifts_m)[rows]


def support_of(stage: Stage, name: str, settings: Contact) -> str | None:
    """What an object rests on: the owner of the surface beneath it, or None.

    Points of the object's surface are lifted, no higher than its middle, and dropped: where one meets a nearly level
    surface within ``support_m`` beneath it, that surface carries the object. The lift makes the answer robust to
    interpenetration.
    Agents are never supports (5.3.1).
    """
    drop = Drop.of(stage, name, settings)
    return drop.meets(stage, drop.around(stage, settings), settings)


SUNK_M = 1e-3
"""How far above a surface a point is dropped that was beneath it."""


def _sunk_m(stage: Stage, name: str, lowest_m: float, settings: Contact) -> float:
    """How far an object must be lifted to be on a thing that its middle is in, by no more than ``support_m``; else 0.

    Args:
        stage: The scene in a state.
        name: The object.
        lowest_m: Height of its lowest point.
        settings: Distances.
    """
    scene = stage.scene
    middle = stage.geom_centers(scene.seen_geoms(name)).mean(axis=0)
    around = stage.between(
        middle, middle[None] + UP * settings.support_m, np.full(1, settings.support_m), but_body=scene.object_body(name)
    )
    things = [geom for geom in around.tolist() if scene.owners[geom] not in scene.agents]
    met, above_m, normals = stage.cast_each(things, middle[None], UP[None])
    level = math.cos(settings.support_slope_rad)
    above = [float(above_m[0])] if met[0] >= 0 and normals[0, 2] >= level else []
    planes = [stage.geom(geom) for geom in things if stage.is_plane(geom)]  # rays meet them from above only
    above += [-float(pose.to_local(middle)[2] / pose.matrix[2, 2]) for pose in planes if pose.matrix[2, 2] >= level]
    sunk_m = middle[2] + max(above) - lowest_m if max(above, default=0.0) > 0.0 else 0.0
    return float(sunk_m) + SUNK_M if 0.0 < sunk_m <= settings.support_m + ROUNDING else 0.0


def seat_m(stage: Stage, name: str, settings: Contact) -> float | None:
    """How far up an object must be moved to lie on what carries it, metres: tracked things sink in or float a little.

    None if nothing carries it. Agents' bodies are looked through.
    """
    drop, scene = Drop.of(stage, name, settings), stage.scene
    things = [geom for geom in drop.around(stage, settings).tolist() if scene.owners[geom] not in scene.agents]
    return drop.seat_m(stage, np.array(things, dtype=np.intp), settings)


def _low_points(stage: Stage, name: str, samples: Array) -> Array:
    """Surface points within reach of a support, lowest first: exact lowest points, and the lowest of the samples."""
    exact = []
    for geom in stage.scene.seen_geoms(name):
        pose = stage.geom(int(geom))
        lowest = lowest_point(stage.scene.model, int(geom), pose.matrix)
        if lowest is not None:
            exact.append(pose.to_world(lowest))
    if not exact:
        return np.empty((0, 3))
    points = np.concatenate((np.array(exact), samples))
    heights = np.round(points[:, 2], 6)
    low = np.flatnonzero(points[:, 2] < points[heights.argmin(), 2] + 2 * POINT_SPACING_M)
    return points[low[np.argsort(heights[low], kind="stable")]]


def container_of(stage: Stage, name: str, settings: Contact) -> str | None:
    """What an object lies in: one body with a floor beneath it and walls all round (5.3.1), or None.

    From the object's middle, the ray straight down must meet the body, and nearly all horizontal ones must meet it
    within ``container_m``, each on a face that looks towards the object: who has sunk into a table top is not inside
    the table. Whatever else lies in the container is looked through. The room itself, and agents, are no containers.
    """
    middle = stage.geom_centers(stage.scene.seen_geoms(name)).mean(axis=0)
    heading = stage.body_axis(stage.scene.object_body(name), 0)
    rays = _around(math.atan2(heading[1], heading[0]))
    return next(
        (owner for owner in _candidates(stage, name, middle) if _encloses(stage, owner, middle, rays, settings)), None
    )


def _around(start_rad: float) -> Array:
    """Down, and level all round, unit vectors (1 + n, 3)."""
    angles = start_rad + 2 * math.pi * np.arange(WALL_DIRECTIONS) / WALL_DIRECTIONS
    level = np.stack((np.cos(angles), np.sin(angles), np.zeros_like(angles)), axis=1)
    return np.concatenate((DOWN[None], level))


def _candidates(stage: Stage, name: str, middle: Array) -> list[str]:
    """Tracked objects and furniture in whose bounding spheres the middle lies; the room's own walls do not count.

    The box, along the world's axes, around the bounding spheres of all of their shapes must hold it.
    """
    scene = stage.scene
    others = [owner for owner in scene.bodies if owner != name and stage.state.known([owner])]
    if not others:
        return []
    shapes = [scene.geoms_of(owner) for owner in others]
    together, starts = np.concatenate(shapes), np.cumsum([0, *map(len, shapes[:-1])])
    offsets, radii = stage.geom_centers(together) - middle, scene.model.geom_rbound[together][:, None]
    low = np.minimum.reduceat(offsets - radii, starts)
    high = np.maximum.reduceat(offsets + radii, starts)
    holds = ((low <= 0.0) & (high >= 0.0)).all(axis=1)
    return [others[index] for index in np.flatnonzero(holds)]


def _encloses(stage: Stage, owner: str, middle: Array, rays: Array, settings: Contact) -> bool:
    geoms, distances, normals = stage.cast_each(stage.scene.seen_geoms(owner), np.tile(middle, (len(rays), 1)), rays)
    faces = (geoms >= 0) & (np.sum(normals * rays, axis=1) < 0)
    walls = faces[1:] & (distances[1:] <= settings.container_m)
    return bool(faces[0]) and float(walls.mean()) >= settings.container_walls


def overlaps(stage: Stage, *, deeper_than_m: float) -> dict[tuple[str, str], float]:
    """Owners whose shapes overlap, with the depth in metres; furniture among itself, and the floor, are left out."""
    scene = stage.scene
    movable = {*scene.agents, *scene.objects}
    solid = [geom for geom in stage.solid_geoms() if not stage.is_plane(geom)]
    moving = [geom for geom in solid if scene.owners[geom] in movable]
    deepest: dict[tuple[str, str], float] = {}
    for geom, other in stage.near_pairs(moving, solid, limit_m=0.0):
        first, second = sorted((scene.owners[geom], scene.owners[other]))
        if first == second or (other in moving and geom > other):
            continue
        depth = -stage.distance(geom, other, limit_m=0.0)
        if depth > deeper_than_m:
            deepest[first, second] = max(depth, deepest.get((first, second), 0.0))
    return deepest


# --- Resting, remembered: what objects rest on and lie in is found anew only where something may have changed it.
#
# In most frames of a demonstration people move and things do not. What an object lies in follows from where the
# things of the room are; what it rests on, too, unless a part of somebody's body is where its points are dropped.


NEARBY_M = 0.1
"""Things farther apart than this, and their sizes, neither carry each other nor stand in each other's way."""


@dataclass(eq=False)
class _Found:
    """What was found for an object while the things of the room were somewhere; kept up to date while all stays so.

    Attributes:
        things: Where they were, by their part of ``qpos``.
        untracked: What was not tracked.
        container: What it lay in.
        drop: Its points.
        support: What these met.
        alone: Whether nobody's body was there that they might have met.
    """

    things: Array
    untracked: frozenset[str]
    container: str | None
    drop: Drop
    support: str | None = None
    alone: bool = False


class RestingMemory:
    """Says what objects of a scene rest on and lie in: the same as ``rest_of``, mostly sooner.

    What one thing does changes nothing for those that are far from it, before and after.

    Args:
        scene: The scene.
        settings: Distances.
    """

    def __init__(self, scene: Scene, settings: Contact) -> None:
        self._settings = settings
        bodies = [np.r_[scene.base_slice(name), scene.joint_indices(name)] for name in scene.agents]
        self._things = np.setdiff1d(np.arange(scene.nq), np.concatenate([*bodies, np.empty(0, dtype=np.intp)]))
        self._of_agents = np.isin(scene.owners, scene.agents)
        self._rows = {name: row for row, name in enumerate(scene.objects)}
        columns = [np.arange(scene.nq)[scene.object_slice(name)] for name in scene.objects]
        self._columns = np.searchsorted(self._things, np.array(columns, dtype=np.intp).reshape(-1, 7))
        self._others = np.setdiff1d(np.arange(len(self._things)), self._columns)
        self._radii_m = np.array([_radius_m(scene, name) for name in scene.objects])
        self._found: dict[str, _Found] = {}

    def __call__(self, stage: Stage, name: str) -> Rest:
        """What an object rests on and lies in, in the state that a stage shows."""
        things, untracked = stage.state.qpos[self._things], stage.state.untracked
        found = self._found.get(name)
        if found is None or found.untracked != untracked or not self._as_before(name, found.things, things):
            container = container_of(stage, name, self._settings)
            found = self._found[name] = _Found(things, untracked, container, Drop.of(stage, name, self._settings))
        around = found.drop.around(stage, self._settings)
        alone = not self._of_agents[around].any()
        if not (alone and found.alone):
            found.support, found.alone = found.drop.meets(stage, around, self._settings), alone
        found.things = things
        return Rest(found.support, found.container)

    def _as_before(self, name: str, before: Array, now: Array) -> bool:
        """Whether an object, and all that is near to it or was, is where it was."""
        moved = before != now
        if not moved.any():
            return True
        row, moved_things = self._rows[name], moved[self._columns].any(axis=1)
        if moved_things[row] or moved[self._others].any():
            return False
        here, near_m = now[self._columns[row, :3]], self._radii_m + self._radii_m[row] + NEARBY_M
        return not any(
            (np.linalg.norm(there[self._columns[:, :3]] - here, axis=1) < near_m)[moved_things].any()
            for there in (before, now)
        )


def _radius_m(scene: Scene, name: str) -> float:
    """Radius of a ball about the frame of an object that holds all of its shapes, however its own joints are turned."""
    model, root = scene.model, scene.object_body(name)
    reach_m = 0.0
    for geom in scene.geoms_of(name).tolist():
        if model.geom_rbound[geom] == 0.0:
            return math.inf  # endless
        body, far_m = (
            int(model.geom_bodyid[geom]),
            float(np.linalg.norm(model.geom_pos[geom]) + model.geom_rbound[geom]),
        )
        while body != root:
            far_m += float(np.linalg.norm(model.body_pos[body]))
            body = int(model.body_parentid[body])
        reach_m = max(reach_m, far_m)
    return reach_m


# --- Who holds an object in one state: decided here for hand status, placement and effort 0 alike.
#
# A hand holds an object when it is close to it and the object rests on nothing ("the object is not on a support and
# the hand is close to the object", 8.5). Nothing that rests on a support is held. Where states follow each other,
# ``observe/carrying.py`` tells hands that hold from those that only pass, and writes it into the states.


@dataclass(frozen=True)
class Holding:
    """Who holds an object in one state.

    Attributes:
        hands: The holding hands as (agent, side), in the scene's order.
        support: What the object rests on, or None.
        container: What the object lies in, or None.
        complete: False when an untracked hand might hold it, or an untracked object might carry it: then empty
            ``hands`` or a missing ``support`` say nothing.
    """

    hands: tuple[tuple[str, str], ...]
    support: str | None
    container: str | None
    complete: bool


def holding_of(stage: Stage, name: str, settings: Contact) -> Holding | None:
    """Who holds an object, and what it rests on or lies in; None if the object was not tracked.

    Args:
        stage: The scene in a state. What was decided over time to be held does not rest, as near as it may be.
        name: The object.
        settings: Distances.
    """
    state = stage.state
    if not state.known([name]):
        return None
    if not any(hold.object == name for hold in state.holding or ()):
        rest = rest_of(stage, name, settings)
        if rest.container or rest.support:
            return Holding((), rest.support, rest.container, complete=True)
    hands, complete = [], all(state.known([other]) for other in stage.scene.objects)
    for agent_name in stage.scene.agents:
        agent = stage.scene.agent(agent_name)
        for arm in agent.arms:
            if not hand_known(stage, agent, arm):
                complete = False
            elif _holds(stage, Hold(agent_name, arm.profile.side, name), arm, settings):
                hands.append((agent_name, arm.profile.side))
    return Holding(tuple(hands), None, None, complete)


def _holds(stage: Stage, hold: Hold, arm: ArmIndices, settings: Contact) -> bool:
    if stage.state.holding is not None:
        return hold in stage.state.holding
    return is_near(stage, arm, hold.object, settings)


def is_near(stage: Stage, arm: ArmIndices, name: str, settings: Contact) -> bool:
    """Whether a hand is close enough to an object to hold it."""
    return hand_gap_m(stage, arm, name, limit_m=settings.grip_m) < settings.grip_m


def objects_near(stage: Stage, agent: Agent, settings: Contact) -> tuple[str, ...]:
    """Objects that a hand of an agent is close enough to, to hold them."""
    near = {name for arm in agent.arms for name in _near(stage, arm, settings)}
    return tuple(name for name in stage.scene.objects if name in near)


def possible_holds(stage: Stage, settings: Contact) -> frozenset[Hold]:
    """Which tracked hands of all agents are close enough to which tracked objects, to hold them."""
    scene, near = stage.scene, set[Hold]()
    for name in scene.agents:
        agent = scene.agent(name)
        for arm in agent.arms:
            if hand_known(stage, agent, arm):
                near.update(Hold(name, arm.profile.side, each) for each in _near(stage, arm, settings))
    return frozenset(hold for hold in near if stage.state.known([hold.object]))


def _near(stage: Stage, arm: ArmIndices, settings: Contact) -> list[str]:
    """Objects that a hand is close to; few are looked at closely, for few are anywhere near."""
    pairs = stage.near_pairs(arm.hand_geoms, stage.scene.objects_geoms, limit_m=settings.grip_m)
    candidates = {stage.scene.owners[geom] for _, geom in pairs}
    return [name for name in candidates if is_near(stage, arm, name, settings)]


def hand_known(stage: Stage, agent: Agent, arm: ArmIndices) -> bool:
    """Whether the hand was tracked."""
    return stage.state.known([f"{agent.name}/{arm.profile.side}_arm", agent.name])


def hand_gap_m(stage: Stage, arm: ArmIndices, name: str, *, limit_m: float) -> float:
    """Signed gap in metres between a hand and an object, at most ``limit_m``."""
    return stage.closest(arm.hand_geoms, stage.scene.solid_geoms_of(name), limit_m=limit_m)[0]


def rests_on(stage: Stage, arm: ArmIndices, settings: Contact) -> str | None:
    """The support that a hand lies on: something beneath it, neither agent nor object in the hand; None otherwise."""
    scene = stage.scene
    pairs = stage.near_pairs(arm.hand_geoms, stage.solid_geoms(), limit_m=settings.support_m)
    others = sorted({other for _, other in pairs if scene.owners[other] not in scene.agents})
    gap, hand_geom, other = stage.closest(arm.hand_geoms, others, limit_m=settings.support_m)
    if gap >= settings.support_m or other < 0:
        return None
    above = stage.geom_centers([hand_geom])[0]
    hits, _ = stage.cast(above, [(0.0, 0.0, -1.0)], exclude_body=arm.hand_body)
    owner = scene.owners[other]
    if hits[0] < 0 or scene.owners[hits[0]] != owner:
        return None
    if owner not in scene.objects:
        return owner
    # What fingers are around is gripped; a hand rests on a thing that is all beneath it.
    top_m = stage.bounds(scene.solid_geoms_of(owner))[1, 2]
    return owner if stage.bounds(arm.hand_geoms)[0, 2] >= top_m - settings.support_m else None


# --- What carries an object that rests on nothing, and that no hand holds.


def wearer_of(stage: Stage, name: str, settings: Contact) -> tuple[str | None, bool]:
    """The agent on whose body an object is: on a lap or an arm, in a pocket; or nobody.

    Returns:
        The agent or None; and whether that is sure: a part that was not tracked might carry it.
    """
    scene, thing = stage.scene, stage.scene.solid_geoms_of(name)
    lost = scene.untracked_geoms(stage.state.untracked)
    bodies = {agent: _but_hands(scene, agent) for agent in scene.agents}

    def touches(geoms: Indices) -> bool:
        return bool(len(geoms)) and stage.closest(geoms, thing, limit_m=settings.support_m)[0] < settings.support_m

    wearer = next((agent for agent, geoms in bodies.items() if touches(np.setdiff1d(geoms, lost))), None)
    return wearer, wearer is not None or not any(touches(np.intersect1d(geoms, lost)) for geoms in bodies.values())


def _but_hands(scene: Scene, agent: str) -> Indices:
    hands = [arm.hand_geoms for arm in scene.agent(agent).arms]
    return np.setdiff1d(scene.solid_geoms_of(agent), np.concatenate([*hands, np.empty(0, dtype=np.intp)]))


def hook_of(stage: Stage, name: str, settings: Contact) -> str | None:
    """What an object hangs on: a hook or a rail, a wall, whatever touches it and is not wholly above it; or None."""
    scene, thing = stage.scene, stage.scene.solid_geoms_of(name)
    top_m = stage.bounds(thing)[1, 2]
    others = [geom for geom in stage.solid_geoms().tolist() if scene.owners[geom] not in (name, *scene.agents)]
    touching = {other for _, other in stage.near_pairs(thing, others, limit_m=settings.support_m)}
    beside = [geom for geom in sorted(touching) if _lowest_m(stage, geom) < top_m]
    gap_m, _, hook = stage.closest(thing, beside, limit_m=settings.support_m)
    return scene.owners[hook] if hook >= 0 and gap_m < settings.support_m else None


def _lowest_m(stage: Stage, geom: int) -> float:
    pose = stage.geom(geom)
    lowest = lowest_point(stage.scene.model, geom, pose.matrix)
    if lowest is not None:
        return float(pose.to_world(lowest)[2])
    return -math.inf if pose.matrix[2, 2] > -math.cos(math.pi / 4) else float(pose.position[2])
