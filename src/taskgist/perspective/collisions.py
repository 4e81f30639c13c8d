"""What a virtual action must respect besides the joints' ranges: head, torso and base push into nothing (5.1.4).

Tracked bodies touch and interpenetrate a little, as a sitter does with the chair. Therefore only a contact blocks
that is deeper than the same two shapes' contact in the current state, by more than ``collision_m``.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.common.arrays import Array
from taskgist.common.compiled import compiled
from taskgist.settings import Contact, Settings
from taskgist.world.bodies.agent import Agent
from taskgist.world.geometry.distances import any_near, ball_around, near_ball
from taskgist.world.holding import holding_of
from taskgist.world.stage import Stage

# --- Regions: boxes along the world's axes, in which something was looked at or felt for.
#
# An answer of perspective keeps to the regions in which it was found: what moves elsewhere does not change it.

BODIES = 8
"""How many places of an agent are kept apart; further ones are taken together."""
NOWHERE: Array = np.array(((np.inf,) * 3, (-np.inf,) * 3))
SLACK = 1e-9
"""For rounding: rather asked once too often."""


class Region:
    """A box that grows, along the world's axes; empty at first.

    ``bounds`` are its lowest and highest corners in metres, (2, 3).
    """

    def __init__(self) -> None:
        self.bounds: Array = NOWHERE.copy()

    def add_balls(self, centers: Array, radii_m: Array) -> None:
        """Let it hold balls: centres in metres, (n, 3), and radii, (n,)."""
        _add_balls(self.bounds, centers, radii_m)

    def add_points(self, points: Array, margin_m: float = 0.0) -> None:
        """Let it hold points, metres, (n, 3), and what is within a margin of them."""
        _add_balls(self.bounds, points, np.full(len(points), margin_m))

    def add(self, other: Region) -> None:
        """Let it hold another region."""
        np.minimum(self.bounds[0], other.bounds[0], out=self.bounds[0])
        np.maximum(self.bounds[1], other.bounds[1], out=self.bounds[1])

    def grow(self, by_m: ArrayLike) -> None:
        """Let it reach farther on all sides."""
        self.bounds[0] -= by_m
        self.bounds[1] += by_m


class Consulted:
    """All that was looked at or felt for, to find an answer.

    Attributes:
        target: Where the object is, and what is near to it.
        eyes: From where it was looked at: all lines from there to the object were.

    Args:
        own: Where the agent is, and what is near to it.
    """

    def __init__(self, own: Region) -> None:
        self.target, self.eyes = Region(), Region()
        self._bodies = [own]

    def add_body(self, region: Region) -> None:
        """Note where the agent might have been, and what is near to it there."""
        if len(self._bodies) == BODIES:
            region.add(self._bodies.pop())
        self._bodies.append(region)

    @property
    def bounds(self) -> Array:
        """Lowest and highest corners of object, eyes and bodies, metres, (2 + BODIES, 2, 3); empty ones at last."""
        regions = [self.target, self.eyes, *self._bodies]
        return np.stack([region.bounds for region in regions] + [NOWHERE] * (2 + BODIES - len(regions)))


@compiled
def _add_balls(bounds: Array, centers: Array, radii_m: Array) -> None:
    for i in range(len(centers)):
        for axis in range(3):
            bounds[0, axis] = min(bounds[0, axis], centers[i, axis] - radii_m[i])
            bounds[1, axis] = max(bounds[1, axis], centers[i, axis] + radii_m[i])


@compiled
def touched(regions: Array, boxes: Array) -> NDArray[np.bool_]:
    """Whether each region, (n, 2, 3), touches any of some boxes, (k, 2, 3); (n,)."""
    found = np.zeros(len(regions), dtype=np.bool_)
    for i in range(len(regions)):
        for k in range(len(boxes)):
            found[i] |= not _apart(regions[i], boxes[k])
    return found


@compiled
def crossed(consulted: Array, boxes: Array) -> NDArray[np.bool_]:
    """Whether what was consulted for each answer, (n, 2 + BODIES, 2, 3), touches any of some boxes, (k, 2, 3); (n,)."""
    found = np.zeros(len(consulted), dtype=np.bool_)
    for i in range(len(consulted)):
        target, eyes, bodies = consulted[i, 0], consulted[i, 1], consulted[i, 2:]
        start = target if _empty(eyes) else eyes
        for k in range(len(boxes)):
            found[i] |= not _empty(target) and _between(start, target, boxes[k])
            for body in range(len(bodies)):
                if found[i] or _empty(bodies[body]):
                    break
                found[i] = not _apart(bodies[body], boxes[k])
    return found


@compiled
def _empty(box: Array) -> bool:
    return bool(box[0, 0] > box[1, 0])


@compiled
def _apart(one: Array, other: Array) -> bool:
    """Whether two boxes, (2, 3), do not touch."""
    apart = False
    for axis in range(3):
        apart |= one[0, axis] > other[1, axis] or other[0, axis] > one[1, axis]
    return apart


@compiled
def _between(start: Array, end: Array, box: Array) -> bool:
    """Whether a box touches the convex hull of two others, all (2, 3): a box on the way from one to the other.

    Each face of those moves evenly with the share of the way, which bounds the shares at which they may touch.
    """
    least, most = 0.0, 1.0
    for axis in range(3):
        for side, bound in ((0, box[1, axis]), (1, box[0, axis])):
            sign = 1.0 - 2.0 * side  # the lower face must not be above the box, nor the upper one below it
            at, by = sign * (start[side, axis] - bound), sign * (end[side, axis] - start[side, axis])
            if by == 0.0:
                if at > 0.0:
                    return False
            elif by > 0.0:
                most = min(most, -at / by)
            else:
                least = max(least, -at / by)
    return least <= most + SLACK


@dataclass(frozen=True)
class Blocking:
    """A contact that blocks.

    Attributes:
        part: The agent's own part.
        other: What it meets: an object, a piece of furniture or another agent.
        depth_m: How deep.
    """

    part: str
    other: str
    depth_m: float

    def __str__(self) -> str:
        return f"{self.part} against {self.other}, {self.depth_m:.2f} m deep"

    def as_miss(self) -> dict[str, object]:
        """What shows that only this is in the way."""
        return {"blocking": self.evidence}

    @property
    def evidence(self) -> dict[str, object]:
        """Plain data, fit for JSON."""
        return {"part": self.part, "other": self.other, "depth_m": self.depth_m}


class Collisions:
    """Judges states of an agent by what its head, torso and base would push into.

    ``obstacles`` are the shapes that are in the way of it, (n,); they stay where they are, whatever the agent does.

    Args:
        stage: The scene in the agent's current state, with whose contacts others are compared.
        agent: The agent.
        settings: Tolerance.
        held: Objects that the agent holds: they are in nobody's way.
    """

    def __init__(self, stage: Stage, agent: Agent, settings: Settings, held: Collection[str]) -> None:
        self._stage, self._agent = stage, agent
        self.obstacles = _obstacles(stage, agent, held)
        self._tolerance_m = settings.efforts.collision_m
        self._farthest_m = settings.efforts.move_radius_m + settings.efforts.move_step_m
        self._usual_m = {
            (geom, other): depth for geom, other, depth in stage.overlaps(agent.core_geoms, self.obstacles)
        }

    @cached_property
    def boxes(self) -> Array:
        """Boxes around the obstacles, (n, 18); see ``geometry.boxes``."""
        return self._stage.boxes(self.obstacles)

    def find(self) -> Blocking | None:
        """The first contact that blocks in the state that the stage shows; None where it is free."""
        first = self._first()
        if first is None:
            return None
        geom, other, depth_m = first
        return Blocking(part_of(self._stage, self._agent, geom), self._stage.scene.owners[other], depth_m)

    def _first(self) -> tuple[int, int, float] | None:
        """Its two shapes, and how deep they overlap."""
        tolerance_m, usual_m = self._tolerance_m, self._usual_m
        contacts = self._stage.overlaps(self._agent.core_geoms, self.obstacles, deeper_than_m=tolerance_m)
        return next((each for each in contacts if each[2] > usual_m.get(each[:2], 0.0) + tolerance_m), None)

    def add_to(self, region: Region) -> None:
        """Let a region hold the agent's head, torso and base as the stage shows them."""
        core = self._agent.core_geoms
        region.add_balls(self._stage.geom_centers(core), self._stage.scene.model.geom_rbound[core])

    def footprint(self) -> Callable[[tuple[float, float]], bool]:
        """Tells whether the agent, as the stage shows it now, would be free when moved over the floor, by offset."""
        core = self._agent.core_geoms
        positions, matrices = self._stage.geoms(core)
        own = self._stage.boxes(core)
        x, y, z, radius_m = ball_around(own)
        around = self.boxes[near_ball(self.boxes, x, y, z, radius_m + self._farthest_m)]

        def free(offset_m: tuple[float, float]) -> bool:
            if not any_near(own, offset_m, around, -self._tolerance_m / 2):
                return True
            self._stage.place(core, positions + (*offset_m, 0.0), matrices)
            return self._first() is None

        return free


def _obstacles(stage: Stage, agent: Agent, held: Collection[str]) -> NDArray[np.intp]:
    """Solid shapes that are neither the agent's own nor of anything that it holds."""
    counted = np.zeros(stage.scene.model.ngeom, dtype=np.bool_)
    counted[stage.solid_geoms()] = True
    for name in (agent.name, *held):
        counted[stage.scene.geoms_of(name)] = False
    return np.flatnonzero(counted)


def held_by(stage: Stage, agent: Agent, near: Iterable[str], settings: Contact) -> dict[str, str]:
    """Objects that an agent holds, with the side of the hand (the first in the profile's order).

    Only those near to its hands can be, unless it was decided over time who holds what.
    """
    decided = stage.state.holding
    candidates = near if decided is None else sorted({hold.object for hold in decided if hold.agent == agent.name})
    held = {}
    for name in candidates:
        holding = holding_of(stage, name, settings)
        sides = [side for holder, side in (holding.hands if holding else ()) if holder == agent.name]
        if sides:
            held[name] = sides[0]
    return held


def part_of(stage: Stage, agent: Agent, geom: int) -> str:
    """Name of the part of an agent that a shape belongs to."""
    body = int(stage.scene.model.geom_bodyid[geom])
    return next((part for part, bodies in agent.parts.items() if body in bodies), "body")
