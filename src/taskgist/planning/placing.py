"""Placing: whether a thing rests where it is put, and comes near nothing else; what all candidates share.

A candidate rests: its lowest points touch level ground, its centre of mass is well within what touches, and it comes
near nothing else. Whether anybody can bring it there is not asked here: the inside of a closed drawer is a place.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.errors import InputError
from taskgist.maps.places import Ground
from taskgist.planning.resting import LEVEL_RAD, TIP_RAD, Body, Face, Side, firmness_m, sides_of
from taskgist.settings import Settings
from taskgist.world.contacts import container_of, holding_of, support_of
from taskgist.world.geometry.transforms import about_z, matrix_from_wxyz, multiply
from taskgist.world.stage import Stage
from taskgist.world.state import Hold, State

Means = Literal["put_on", "put_in", "put_over", "slide_out", "hold_up", "hand_over"]
"""How a thing gets somewhere: onto something, into a container, over another, out over an edge of its support, before a
face, into another's hand."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """Where a thing could be in the end.

    Attributes:
        means: How it gets there.
        thing: The thing.
        pose: Position in metres and wxyz of its body, (7,), read-only.
        carrier: What carries it: a support, a container, or the agent in whose hand it is.
        state: The start state with the thing there and nothing else moved; in the air, with the hand that holds it.
    """

    means: Means
    thing: str
    pose: Array
    carrier: str
    state: State

    def __post_init__(self) -> None:
        pose = np.array(self.pose, dtype=float)
        pose.flags.writeable = False
        object.__setattr__(self, "pose", pose)


# --- What all candidates of a question share.

NEAR_M = 0.03
"""A thing whose surface is nowhere farther from where it was has stayed there (ours: a few centimetres)."""
RISE_M = 0.5
"""Nobody's shoulders get higher than that above where they are: by standing up, or lifting the torso."""


@dataclass(frozen=True, eq=False)
class Asking:
    """A question for candidates.

    Attributes:
        stage: A stage of its own, which shows other states between candidates.
        start: Where everything is.
        thing: The thing.
        performer: Who brings it.
        target: For whom.
        settings: Settings.
        sides: The sides on which it can lie.
        body: It.
        own: Its solid shapes, (k,).
        others: All other solid shapes, (m,).
        shift: Where sequences start: a number from 0 to 1 each, (3,).
        highest_m: What is higher nobody reaches.
    """

    stage: Stage
    start: State
    thing: str
    performer: str
    target: str
    settings: Settings
    sides: tuple[Side, ...]
    body: Body
    own: Indices
    others: Indices
    shift: Array
    highest_m: float

    @classmethod
    def of(cls, stage: Stage, thing: str, performer: str, target: str, settings: Settings, seed: int) -> Asking:
        """A question, asked in the state that a stage shows."""
        own = stage.scene.solid_geoms_of(thing)
        if not len(own):
            raise InputError("it has no shape", field="thing", value=thing, hint="give it one, such as a box")
        arms = stage.scene.agent(performer).arms
        reaches = [float(stage.shoulder(arm).position[2]) + arm.profile.length_m + RISE_M for arm in arms]
        return cls(
            stage,
            stage.state,
            thing,
            performer,
            target,
            settings,
            sides_of(stage, thing, settings.contact),
            Body.of(stage, thing),
            own,
            np.setdiff1d(stage.solid_geoms(), own),
            np.random.default_rng(seed).random(3),
            max(reaches, default=-math.inf),
        )

    def with_thing(self, position: Array, wxyz: Array, holder: Hold | None = None) -> State:
        """The start state with the thing elsewhere: in a hand, or in none."""
        state = self.start.replace(at=self.stage.scene.object_slice(self.thing), to=(*position, *wxyz))
        if holder is not None:
            return state.with_holding({holder, *self.held_by_others})
        return state if state.holding is None else state.with_holding(self.held_by_others)

    @cached_property
    def held_by_others(self) -> frozenset[Hold]:
        """Who holds which other things at the start."""
        if self.start.holding is not None:
            return frozenset(hold for hold in self.start.holding if hold.object != self.thing)
        stage, holds = self.stage.show(self.start), set[Hold]()
        for other in stage.scene.objects:
            found = holding_of(stage, other, self.settings.contact) if other != self.thing else None
            holds |= {Hold(agent, side, other) for agent, side in found.hands} if found else set()
        return frozenset(holds)

    def deep_m(self, others: Indices) -> float:
        """How deep the thing is in some shapes, in the state that the stage shows, metres."""
        return max((depth for *_, depth in self.stage.overlaps(self.own, others)), default=0.0)

    @cached_property
    def vessels(self) -> Array:
        """Boxes, along the world's axes, around all that could be a container at the start, metres, (k, 2, 3)."""
        stage, scene = self.stage.show(self.start), self.stage.scene
        shapes = [scene.seen_geoms(owner) for owner in scene.bodies if owner != self.thing]
        return np.array([stage.bounds(geoms) for geoms in shapes if len(geoms)]).reshape(-1, 2, 3)

    def container(self) -> str | None:
        """What the thing lies in, in the state that the stage shows."""
        middle = self.stage.geom_centers(self.stage.scene.seen_geoms(self.thing)).mean(axis=0)
        within = ((self.vessels[:, 0] <= middle) & (middle <= self.vessels[:, 1])).all(axis=1)
        return container_of(self.stage, self.thing, self.settings.contact) if within.any() else None

    def is_moved(self, position: Array, wxyz: Array) -> bool:
        """Whether the thing is not where it is at the start; what looks the same after a turn is not moved by it."""
        before = self.start.qpos[self.stage.scene.object_slice(self.thing)]
        if np.linalg.norm(position - before[:3]) > NEAR_M + 2 * float(np.abs(self.body.points).max()):
            return True
        points = self.body.points[:: max(1, len(self.body.points) // 50)]
        there = points @ matrix_from_wxyz(wxyz).T + position
        here = self.body.points @ matrix_from_wxyz(before[3:]).T + before[:3]
        away_m = np.linalg.norm(there[:, None] - here, axis=2).min(axis=1)
        return bool(away_m.max() > NEAR_M)


# --- Where it rests.

EVEN_M = 0.002
"""What touches a thing's base is no lower than its highest such point by more (ours: set down, it stays as it is)."""
FROM_ABOVE_M = 0.007
"""From how far above a face it is asked what is beneath: what covers the face by more is met from within, or first."""
SHARE = 0.5
"""A thing over an edge stands no less firmly than by that share of how it would in the middle of open ground, or of a
face that is smaller than the thing."""
SHOVED_M = 0.015
"""And what is large enough may be put down, or shoved, so far aside before it falls (ours: places are met to 1 cm)."""
DEEP_M, CLEAR_M = 2e-4, 0.002
"""How deep it may be in what carries it, by rounding; and how far it is from all else at least."""
HULL_M = 0.005
"""By so much solid parts of a concave mesh may be above the mesh itself; see ``geometry.convex``."""
HEADINGS = tuple(math.pi / 4 * k for k in (0, 4, 2, 6, 1, 5, 3, 7))
"""Headings along a face's edges and between, from coarse to fine."""


class Put(NamedTuple):
    """Where a thing is carried: its body's place and turn, the shapes beneath, and whether they carry only a part."""

    position: Array
    wxyz: Array
    under: Indices
    partly: bool


def carried(ground: Ground, face: Face, points: Array, turns: Sequence[tuple[Side, float]]) -> list[Put]:
    """Of some points of a face, (n, 3), and turns (a side that is down, a heading), those where a thing is carried."""
    sides = [side for side, _ in turns]
    headings = [about_z(face.yaw_rad + heading) for _, heading in turns]
    turned = matrix_from_wxyz(np.array(headings).reshape(-1, 4))
    # The centre of mass is over the point, whichever side is down.
    base = np.array([side.base - side.center for side in sides]).reshape(len(sides), -1, 3)
    base = np.einsum("nij,nkj->nki", turned, base)[:, :, :2]
    origins = np.concatenate((points[:, None, :2] + base, np.full((*base.shape[:2], 1), face.height_m)), axis=2)
    origins[:, :, 2] += FROM_ABOVE_M
    geoms, drops_m, upward = (each.reshape(base.shape[:2]) for each in ground.beneath(origins.reshape(-1, 3)))
    heights = np.where(upward >= math.cos(LEVEL_RAD), face.height_m + FROM_ABOVE_M - drops_m, -np.inf)
    highest = heights.max(axis=1)
    touching = (heights >= highest[:, None] - EVEN_M) & (np.abs(highest - face.height_m) <= EVEN_M)[:, None]
    firm_m = firmness_m(base, touching)
    least_m = np.array([_least_m(side, face) for side in sides])
    found = []
    for row in np.flatnonzero(firm_m >= least_m).tolist():
        wxyz = multiply(headings[row], sides[row].wxyz)
        position = points[row] - turned[row] @ sides[row].center
        position[2] = highest[row] - sides[row].lowest_m
        found.append(Put(position, wxyz, np.unique(geoms[row][touching[row]]), not touching[row].all()))
    return found


def free(asking: Asking, face: Face, put: Put, means: Collection[str]) -> Candidate | None:
    """The candidate at a place at which the thing is carried, if nothing else is in its way.

    Args:
        asking: The question.
        face: The face.
        put: The place.
        means: What it may be.
    """
    position, wxyz, under, partly = put
    if not asking.is_moved(position, wxyz):
        return None
    state = asking.with_thing(position, wxyz)
    stage, scene = asking.stage.show(state), asking.stage.scene
    carries = np.isin(asking.others, under)
    meshes = {scene.owners[geom] for geom in under.tolist() if stage.shapes.formless[geom]}
    for owner in sorted(meshes):
        carries |= np.isin(asking.others, scene.solid_geoms_of(owner))
    if stage.closest(asking.own, asking.others[~carries], limit_m=CLEAR_M)[0] < CLEAR_M:
        return None
    deep_m = asking.deep_m(asking.others[carries])
    if deep_m > DEEP_M:
        if not meshes or deep_m > HULL_M:
            return None
        position = position + (0.0, 0.0, deep_m)
        state = asking.with_thing(position, wxyz)
        stage.show(state)
        if asking.deep_m(asking.others[carries]) > DEEP_M:
            return None
    container = asking.container()
    how: Means = "put_on" if container is None else "put_in"
    if how not in means:
        return None
    carrier = container or _owner(asking, face, under)
    if not container and partly and support_of(stage, asking.thing, asking.settings.contact) != carrier:
        return None  # it lies across something thin, and facts say that it is on what is beneath
    return Candidate(how, asking.thing, np.concatenate((position, wxyz)), carrier, state)


def _owner(asking: Asking, face: Face, under: Indices) -> str:
    owners = [asking.stage.scene.owners[geom] for geom in under.tolist()]
    return face.owner if face.owner in owners else owners[0]


def _least_m(side: Side, face: Face) -> float:
    """How far a centre of mass must be from the edge of what carries a thing."""
    firm = side.tip_rad >= TIP_RAD
    tips_m = math.tan(TIP_RAD) * (float(side.center[2]) - side.lowest_m) if firm else 0.0
    half_m = float(face.sides_m.min()) / 2
    return max(SHARE * min(side.firm_m, half_m), min(SHARE * side.firm_m, SHOVED_M), tips_m)
