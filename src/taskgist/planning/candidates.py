"""Where a thing could be in the end: candidates for a planner, each a state of the scene with the thing elsewhere.

On and in everything that can carry it: tables, shelf boards, tops of other things, floors of bins and drawers; place ×
which side is down × heading. Nothing is drawn on a fixed grid: each level face has a low-discrepancy sequence of points
[Roberts 2018], from coarse to fine, so that a small face is covered as well as a large one, and faces take turns, so
that the first candidates are spread over all of them. Whoever needs more asks on. Floors and seats are last, for a
thing that lies on the floor is out of many people's sight and reach::

    for candidate in candidates(stage, "tape", "PR2", "P2"):
        judge(candidate.state)

A candidate rests: its lowest points touch level ground, its centre of mass is well within what touches, and it comes
near nothing else. Whether anybody can bring it there is not asked here: the inside of a closed drawer is a place.
In the air, held up before somebody's face or handed over, it is where hands would hold it; whose hands is for others.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import Literal, get_args

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.errors import InputError, UnknownNameError
from taskgist.maps.places import Ground
from taskgist.perspective.search import able
from taskgist.planning.resting import LEVEL_RAD, TIP_RAD, Body, Face, Side, firmness_m, level_faces, sides_of, tiers
from taskgist.settings import DEFAULT, Settings
from taskgist.world.contacts import container_of, holding_of, support_of
from taskgist.world.geometry.transforms import about_z, matrix_from_wxyz, multiply
from taskgist.world.stage import Stage
from taskgist.world.state import Hold, State

Means = Literal["put_on", "put_in", "hold_up", "hand_over"]
"""How a thing gets somewhere: onto something, into a container, before a face, into another's hand."""


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


def candidates(
    stage: Stage,
    thing: str,
    performer: str,
    target: str,
    settings: Settings = DEFAULT,
    *,
    allow: Collection[str] | None = None,
    prefer: Collection[str] = (),
    means: Collection[Means] = ("put_on", "put_in"),
    seed: int = 0,
) -> Iterator[Candidate]:
    """Where a thing could be in the end, well spread, the same for the same question.

    Where it is now, or nearly, is none of them. What stands or lies on the thing stays where it is: move that first.

    Args:
        stage: The scene in the state from which to start; it is left as it is.
        thing: The thing.
        performer: Who is to bring it there: what is too high above its shoulders is left aside.
        target: Before whose face it is held up, or to whom it is handed over.
        settings: For what a container is, and what reach.
        allow: The only supports and containers, the floor and seats among them if they are named; None: all.
        prefer: Supports and containers that come first.
        means: How it may get there; those asked for take turns.
        seed: Shifts all sequences.

    Yields:
        Candidates; with supports, without an end that anybody would wait for.

    Raises:
        InputError: There is no such means, or it is not known where the thing is.
        UnknownNameError: There is no such thing, agent, support or container.
    """
    scene = stage.scene
    scene.object_body(thing), scene.agent(performer), scene.agent(target)
    for each in means:
        if each not in get_args(Means):
            raise InputError("no such means", field="means", value=each, hint=f"one of {', '.join(get_args(Means))}")
    if not stage.state.known([thing]):
        raise InputError("nobody knows where it is", field="thing", value=thing, hint="a thing that is tracked")
    asking = _Asking.of(Stage(scene, stage.state), thing, performer, target, settings, seed)
    ways: list[Iterator[Candidate]] = []
    if {"put_on", "put_in"} & set(means):
        faces = [face for face in level_faces(asking.stage, thing) if face.height_m < asking.highest_m]
        for name in (*(allow or ()), *prefer):
            if name not in {face.owner for face in faces}:
                raise UnknownNameError("support", name, {face.owner for face in faces})
        ways.append(
            _on_supports(
                asking, tiers(asking.stage, faces, performer, settings, allow=allow, prefer=prefer), frozenset(means)
            )
        )
    if "hold_up" in means:
        ways.append(_held_up(asking))
    if "hand_over" in means:
        ways.append(_handed_over(asking))
    return _in_turn(ways)


def _in_turn(ways: list[Iterator[Candidate]]) -> Iterator[Candidate]:
    """One of each, again and again, until all have come to their end."""
    while ways:
        for way in list(ways):
            found = next(way, None)
            if found is None:
                ways.remove(way)
            else:
                yield found


# --- What all candidates of a question share.

NEAR_M = 0.03
"""A thing whose surface is nowhere farther from where it was has stayed there (ours: a few centimetres)."""
RISE_M = 0.5
"""Nobody's shoulders get higher than that above where they are: by standing up, or lifting the torso."""


@dataclass(frozen=True, eq=False)
class _Asking:
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
    def of(cls, stage: Stage, thing: str, performer: str, target: str, settings: Settings, seed: int) -> _Asking:
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


# --- Candidates on faces.

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
PLASTIC = 1.324717957244746
R2 = np.array([1 / PLASTIC, 1 / PLASTIC**2])
"""Steps of a sequence of points that covers a square evenly [Roberts 2018]."""
SPACING_M, LEAST_SPOTS = 0.02, 64
"""Points of a face are so dense in the end, and so many at least."""
BATCH, TRIES = 32, 64
"""Places that are tried at once; a face on which so many in a row were carried, but nowhere free, has no room."""
BURSTS = (1000, 1000, 200, 200)
"""After so many that are preferred, and of others, come some on seats and floors, then others again."""


def _on_supports(asking: _Asking, tiers: list[list[Face]], means: frozenset[str]) -> Iterator[Candidate]:
    """Candidates on faces, tier after tier; on demand again, where there are more."""
    ground = Ground(asking.stage.show(asking.start), asking.settings, but=asking.thing)
    streams = [_spread(asking, ground, faces, means) for faces in tiers]
    going = [True] * len(streams)
    while any(going):
        for number, (stream, most) in enumerate(zip(streams, BURSTS, strict=True)):
            found = 0
            for candidate in islice(stream, most):
                found += 1
                yield candidate
            going[number] = found == most


def _spread(asking: _Asking, ground: Ground, faces: list[Face], means: frozenset[str]) -> Iterator[Candidate]:
    """Candidates on some faces, which take turns: all once, then large ones more often.

    What has four times the area gets twice the turns, shared by its faces as they share the area.
    """
    places = [_Places(asking, ground, face, means) for face in faces]
    areas_m2: dict[str, float] = {}
    for face in faces:
        areas_m2[face.owner] = areas_m2.get(face.owner, 0.0) + face.area_m2
    waits = [math.sqrt(areas_m2[face.owner]) / face.area_m2 for face in faces]
    due, met = np.zeros(len(faces)), [False] * len(faces)
    while len(due) and np.isfinite(due.min()):
        turn = int(due.argmin())
        found = places[turn].one()
        met[turn] |= found is not None
        # Small faces wait long for their turns, but not for their first candidate.
        wait = waits[turn] if met[turn] else min(waits)
        due[turn] = math.inf if places[turn].exhausted else due[turn] + wait
        if found is not None:
            yield found


class _Places:
    """Candidates on one face, from coarse to fine, first with one heading and side at each point, then with others.

    Attributes:
        exhausted: Whether there are no more.
    """

    def __init__(self, asking: _Asking, ground: Ground, face: Face, means: frozenset[str]) -> None:
        self._asking, self._ground, self._face, self._means = asking, ground, face, means
        self._turns = [(side, heading) for heading in HEADINGS for side in range(len(asking.sides))]
        self._spots = max(LEAST_SPOTS, math.ceil(face.area_m2 / SPACING_M**2))
        self._next, self._ready, self._in_vain, self._uncarried = 0, list[tuple[Array, Array, Indices, bool]](), 0, 0
        self.exhausted = False

    def one(self) -> Candidate | None:
        """The next candidate; None if there is none among the next places, though later ones may have one."""
        if not self._ready:
            self._ready = self._carried()
        while self._ready:
            found = self._free(*self._ready.pop(0))
            if found is not None:
                self._in_vain = 0
                return found
            self._in_vain += 1
        self.exhausted = (
            self._next >= self._spots * len(self._turns) or self._in_vain >= TRIES or self._uncarried >= self._spots
        )
        return None

    def _carried(self) -> list[tuple[Array, Array, Indices, bool]]:
        """Of the next places those at which the thing is carried: pose, what carries it, and whether that is a part."""
        asking, face = self._asking, self._face
        numbers = np.arange(self._next, min(self._next + BATCH, self._spots * len(self._turns)))
        self._next += len(numbers)
        spots = numbers % self._spots
        points = face.points((asking.shift[:2] + np.outer(spots, R2)) % 1.0)
        turns = [self._turns[k] for k in (spots + numbers // self._spots) % len(self._turns)]
        sides = [asking.sides[side] for side, _ in turns]
        headings = [about_z(face.yaw_rad + heading) for _, heading in turns]
        turned = matrix_from_wxyz(np.array(headings).reshape(-1, 4))
        # The centre of mass is over the point, whichever side is down.
        base = np.array([side.base - side.center for side in sides]).reshape(len(sides), -1, 3)
        base = np.einsum("nij,nkj->nki", turned, base)[:, :, :2]
        origins = np.concatenate((points[:, None, :2] + base, np.full((*base.shape[:2], 1), face.height_m)), axis=2)
        origins[:, :, 2] += FROM_ABOVE_M
        geoms, drops_m, upward = (each.reshape(base.shape[:2]) for each in self._ground.beneath(origins.reshape(-1, 3)))
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
            found.append((position, wxyz, np.unique(geoms[row][touching[row]]), not touching[row].all()))
        self._uncarried = 0 if found else self._uncarried + len(numbers)
        return found

    def _free(self, position: Array, wxyz: Array, under: Indices, partly: bool) -> Candidate | None:
        """The candidate at a place at which the thing is carried, if nothing else is in its way."""
        asking = self._asking
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
        means: Means = "put_on" if container is None else "put_in"
        if means not in self._means:
            return None
        carrier = container or self._owner(under)
        if not container and partly and support_of(stage, asking.thing, asking.settings.contact) != carrier:
            return None  # it lies across something thin, and facts say that it is on what is beneath
        return Candidate(means, asking.thing, np.concatenate((position, wxyz)), carrier, state)

    def _owner(self, under: Indices) -> str:
        owners = [self._asking.stage.scene.owners[geom] for geom in under.tolist()]
        return self._face.owner if self._face.owner in owners else owners[0]


def _least_m(side: Side, face: Face) -> float:
    """How far a centre of mass must be from the edge of what carries a thing."""
    firm = side.tip_rad >= TIP_RAD
    tips_m = math.tan(TIP_RAD) * (float(side.center[2]) - side.lowest_m) if firm else 0.0
    half_m = float(face.sides_m.min()) / 2
    return max(SHARE * min(side.firm_m, half_m), min(SHARE * side.firm_m, SHOVED_M), tips_m)


# --- Candidates in the air, in a hand.

R3 = 1.2207440846057596 ** -np.arange(1.0, 4.0)
"""Steps of a sequence of points that covers a cube evenly [Roberts 2018]."""
VIEW_M, BELOW_EYES_M = (0.35, 1.0), 0.12
"""How far from the eye a thing is held to be looked at (about half a metre is comfortable), and how far below the line
between two faces, so that neither hides the other."""
VIEW_RAD, BELOW_RAD = math.radians(35.0), math.radians(35.0)
"""How far aside, and how far beneath that line."""
TAKING, TAKING_RAD = (0.45, 0.9), math.radians(45.0)
"""From which shares of the taker's arm a thing is handed over, and how far aside of where the taker faces."""
TAKING_BELOW_RAD = (0.0, math.radians(50.0))
"""How far below the shoulder."""
LOW_LEVEL = 2
"""Who takes a thing needs no more effort to reach it than turning or leaning the torso."""
AIR_M = 0.02
"""How far a thing in a hand is from all but the arms at least."""
POINTS = 512
"""So many points are tried with each way of turning the thing."""


def _held_up(asking: _Asking) -> Iterator[Candidate]:
    """Held up before the target's face, on the way to the performer's, at the height of the faces and below."""
    stage = asking.stage.show(asking.start)
    scene = stage.scene
    eye = stage.eye(scene.agent(asking.target)).position
    sight = stage.eye(scene.agent(asking.performer)).position - eye
    yaw, pitch = math.atan2(sight[1], sight[0]), math.atan2(sight[2], math.hypot(sight[0], sight[1]))
    far_m = max(VIEW_M[0], min(VIEW_M[1], float(np.linalg.norm(sight)) - VIEW_M[0]))
    arms = np.concatenate([arm.geoms for arm in scene.agent(asking.performer).arms])

    def place(share: Array) -> Array:
        distance = VIEW_M[0] + share[0] * (far_m - VIEW_M[0])
        aside, below = (2 * share[1] - 1) * VIEW_RAD, share[2] * BELOW_RAD
        ahead = _direction(yaw + aside, pitch - below)
        return np.asarray(eye + distance * ahead - (0.0, 0.0, BELOW_EYES_M))

    yield from _in_air(asking, "hold_up", asking.performer, place, np.setdiff1d(asking.others, arms), lambda _: True)


def _handed_over(asking: _Asking) -> Iterator[Candidate]:
    """Before the target, where it reaches the thing with little effort, and then in its hand."""
    stage = asking.stage.show(asking.start)
    agents = [stage.scene.agent(name) for name in (asking.performer, asking.target)]
    taking = agents[1].arms
    shoulders = [stage.shoulder(arm) for arm in taking]
    arms = np.concatenate([arm.geoms for agent in agents for arm in agent.arms])

    def place(share: Array) -> Array:
        which = int(share[1] * 997) % len(taking)
        shoulder, length_m = shoulders[which], taking[which].profile.length_m
        yaw = math.atan2(shoulder.matrix[1, 0], shoulder.matrix[0, 0]) + (2 * share[1] - 1) * TAKING_RAD
        below = TAKING_BELOW_RAD[0] + share[2] * (TAKING_BELOW_RAD[1] - TAKING_BELOW_RAD[0])
        distance = (TAKING[0] + share[0] * (TAKING[1] - TAKING[0])) * length_m
        return np.asarray(shoulder.position + distance * _direction(yaw, -below))

    def suits(free: State) -> bool:
        reached = able(
            asking.stage, asking.target, asking.thing, "reach", max_level=LOW_LEVEL, settings=asking.settings
        )
        asking.stage.show(free)
        return reached is True

    if len(taking):
        yield from _in_air(asking, "hand_over", asking.target, place, np.setdiff1d(asking.others, arms), suits)


def _in_air(
    asking: _Asking,
    means: Means,
    holder: str,
    place: Callable[[Array], Array],
    others: Indices,
    suits: Callable[[State], bool],
) -> Iterator[Candidate]:
    """Candidates in somebody's hand, where they come near nothing.

    Args:
        asking: The question.
        means: How it gets there.
        holder: In whose hand.
        place: The place of the thing's middle for three numbers from 0 to 1.
        others: What it may not come near.
        suits: Whether a state, in which nobody holds it yet, serves the purpose.
    """
    turns = [(side, heading) for heading in HEADINGS for side in range(len(asking.sides))]
    for number in range(POINTS * len(turns)):
        point, turn = number % POINTS, number // POINTS
        middle = place((asking.shift + 0.5 + point * R3) % 1.0)
        side, heading = turns[(point + turn) % len(turns)]
        wxyz = multiply(about_z(heading), asking.sides[side].wxyz)
        position = middle - matrix_from_wxyz(wxyz) @ asking.body.center
        free = asking.with_thing(position, wxyz)
        stage = asking.stage.show(free.with_holding(asking.held_by_others))
        if stage.closest(asking.own, others, limit_m=AIR_M)[0] < AIR_M or not suits(stage.state):
            continue
        hand = _nearest_hand(stage, holder, middle)
        state = asking.with_thing(position, wxyz, Hold(holder, hand, asking.thing))
        yield Candidate(means, asking.thing, np.concatenate((position, wxyz)), holder, state)


def _direction(yaw_rad: float, pitch_rad: float) -> Array:
    level = math.cos(pitch_rad)
    return np.array([level * math.cos(yaw_rad), level * math.sin(yaw_rad), math.sin(pitch_rad)])


def _nearest_hand(stage: Stage, agent: str, point: Array) -> str:
    """The side of the arm whose shoulder is nearest."""
    arms = stage.scene.agent(agent).arms
    away = [round(float(np.linalg.norm(stage.shoulder(arm).position - point)), 6) for arm in arms]
    return arms[int(np.argmin(away))].profile.side
