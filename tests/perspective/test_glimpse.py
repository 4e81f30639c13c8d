"""A glimpse is never too little: whatever an aimed head sees was not passed over, and shadows hide all that is in them.

The slow, obvious twin is ``look``, in the state shown. What is looked at is put where rounding decides: flush with
what hides it, along its edges, in the same place, and around the eye.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from taskgist.errors import UnknownNameError
from taskgist.perspective import Viewpoint, effort_from, visibility
from taskgist.perspective.candidates import Candidates, UsableHead
from taskgist.perspective.gaze import aimed, turned_heads
from taskgist.perspective.image import look
from taskgist.perspective.lens import lens_of
from taskgist.perspective.occlusion import from_eye, in_shadow
from taskgist.perspective.see import See, next_glimpse
from taskgist.perspective.viewpoint import Screening
from taskgist.world import Scene, Stage, State
from taskgist.world.geometry.rays import NO_GEOM
from tests.perspective.random_rooms import OCTAHEDRON, WEDGE, random_case
from tools.rooms import COARSE, Person, Room, Shape, Thing

Array = NDArray[np.float64]
Generator = np.random.Generator
SEEDS = range(800, 806)
LEVELS = (1, 2, 4)
MOST = 8
"""Candidates of a batch that are looked at, picked at random."""


@dataclass(eq=False)
class Head:
    """An agent that aims its head at an object."""

    here: Viewpoint
    see: See

    @classmethod
    def of(cls, here: Viewpoint, name: str) -> Head:
        return cls(here, See(here, here.target(name)))

    def usable(self, candidates: Candidates) -> UsableHead:
        return candidates.torso.frames.usable(self.here.actions)

    def batches(self) -> Iterator[tuple[int, Candidates]]:
        for level in LEVELS:
            for candidates in self.here.candidates.of_level(level, self.see.target.middle):
                if len(candidates):  # not every body bends
                    yield level, candidates

    def aimed(self, candidates: Candidates, index: int) -> Array:
        return aimed(candidates.frames(index), self.usable(candidates).neck, self.see.target.middle)

    def state(self, candidates: Candidates, index: int, angles: Array) -> State:
        return candidates[index].state.replace(self.usable(candidates).changes(angles))

    def sees(self, state: State, *, in_cone: bool = True) -> bool:
        here, target = self.here, self.see.target
        cone_rad = here.agent.profile.eye.gaze_cone_rad if in_cone else math.pi
        seen = bool(look(here.stage.show(state), here.agent, target, cone_rad=cone_rad).visible.any())
        here.stage.show(here.state)
        return seen

    def in_shadow(self, state: State) -> bool:
        stage, target = self.here.stage.show(state), self.see.target
        eye = stage.eye_row(self.here.agent)
        hidden = in_shadow(from_eye(stage.shapes, self.see.others, eye, False), target.corners, eye) != NO_GEOM
        stage.show(self.here.state)
        return hidden


@dataclass
class Tally:
    """How many candidates were looked at, by what became of them."""

    seen: int = 0
    passed: int = 0
    shaded: int = 0


def heads(here: Viewpoint) -> Iterator[Head]:
    for name in here.stage.scene.objects:
        yield Head.of(here, name)


def glimpsed(screening: Screening, count: int) -> set[int]:
    found, index = set(), screening.next(0, count)
    while index < count:
        found.add(index)
        index = screening.next(index + 1, count)
    return found


def some(count: int, rng: Generator) -> list[int]:
    return sorted(rng.choice(count, min(MOST, count), replace=False).tolist())


def check_aimed(head: Head, rng: Generator, tally: Tally) -> None:
    """Nothing that the aimed head sees was passed over, and nothing in a shadow is seen."""
    for level, candidates in head.batches():
        hopeful = glimpsed(head.see.screen(candidates), len(candidates))
        for index in some(len(candidates), rng):
            state = head.state(candidates, index, head.aimed(candidates, index))
            seen, shaded = head.sees(state), head.in_shadow(state)
            where = (
                f"{head.here.agent.name}, {head.see.target.name}, level {level}, candidate {index} of {len(candidates)}"
            )
            assert not seen or index in hopeful, f"passed over: {where}"
            assert not shaded or not head.sees(state, in_cone=False), f"seen in a shadow: {where}"
            tally.seen, tally.passed = tally.seen + seen, tally.passed + (index not in hopeful)
            tally.shaded += shaded


def check_on_the_way(head: Head, rng: Generator) -> int:
    """The same for heads on the way to where they are aimed, and for heads that look anywhere."""
    lens, seen = lens_of(head.here.agent.profile.eye), 0
    sought = (head.here.stage.shapes, head.see.others, head.see.target.sought, lens)
    for level, candidates in head.batches():
        neck, index = head.usable(candidates).neck, int(rng.integers(len(candidates)))
        shares = np.linspace(0.0, 1.0, 4)[:, None]
        way = neck.now + (head.aimed(candidates, index) - neck.now) * shares
        angles = np.vstack((way, rng.uniform(neck.ranges[:, 0], neck.ranges[:, 1], (2, len(neck.now)))))
        eyes = turned_heads(candidates.frames(index), neck, angles)
        hopeful, step = set(), next_glimpse(*sought, eyes, 0)
        while step < len(eyes):
            hopeful.add(step)
            step = next_glimpse(*sought, eyes, step + 1)
        for step in range(len(eyes)):
            sees = head.sees(head.state(candidates, index, angles[step]))
            assert not sees or step in hopeful, f"{head.see.target.name}, level {level}, candidate {index}, step {step}"
            seen += sees
    return seen


# random rooms ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", SEEDS)
def test_what_the_aimed_head_sees_was_not_passed_over(seed: int) -> None:
    case, rng, tally = random_case(seed), np.random.default_rng(seed), Tally()
    for agent in case.scene.agents:
        for head in heads(Viewpoint(case.stage(), agent, COARSE)):
            check_aimed(head, rng, tally)
    assert tally.seen
    assert tally.passed


@pytest.mark.parametrize("seed", SEEDS)
def test_what_a_head_on_the_way_sees_was_not_passed_over(seed: int) -> None:
    case, rng = random_case(seed), np.random.default_rng(seed)
    seen = [
        check_on_the_way(head, rng)
        for agent in case.scene.agents
        for head in heads(Viewpoint(case.stage(), agent, COARSE))
    ]
    assert sum(seen)


# where rounding decides ---------------------------------------------------------------------------------------


def hull(corners: Sequence[Sequence[float]], half_m: float) -> Shape:
    return Shape("mesh", vertices=tuple((half_m * x, half_m * y, half_m * z) for x, y, z in corners))


BRICK = np.array((0.05, 0.07, 0.06))
"""Half sizes of what is looked at, and of its twin."""
FREE = (
    Thing("brick", tuple(BRICK), (0.0, 50.0, 1.0)),
    Thing("twin", tuple(BRICK), (0.0, 53.0, 1.0)),
    Thing("screen", (0.02, 0.2, 0.2), (0.0, 56.0, 1.0)),
    Thing("hall", (1.0, 1.5, 1.2), (0.0, 60.0, 1.0)),
    Thing("gem", (), (0.0, 64.0, 1.0), shapes=(hull(OCTAHEDRON, 0.1),)),
    Thing("dome", (), (0.0, 68.0, 1.0), shapes=(hull(WEDGE, 1.2),)),
)
SCENE = Room(FREE, (Person("P1", (0.0, 0.0)),), (48, 36)).scene()
EYE_M = Stage(SCENE).eye(SCENE.agent("P1")).position
SOUGHT = {"brick", "gem", "dome"}
OFFSETS_M = (0.0, 1e-12, 1e-9, 1e-8, 1e-6, 1e-3)
"""How far from flush, to either side."""


def put(scene: Scene, places: dict[str, Array]) -> State:
    """Things elsewhere, upright."""
    state = scene.initial
    for name, place in places.items():
        state = state.replace(at=scene.object_slice(name), to=(*place, 1.0, 0.0, 0.0, 0.0))
    return state


def off(rng: Generator) -> float:
    return float(rng.choice((-1, 1)) * rng.choice(OFFSETS_M))


def ahead(rng: Generator) -> Array:
    return np.array((rng.uniform(0.6, 0.9), rng.uniform(-0.4, 0.4), rng.uniform(1.2, 1.8)))


def flush(rng: Generator) -> dict[str, Array]:
    """A screen against the face that is looked at, covering it; or an equal brick in the same place."""
    brick = ahead(rng)
    if rng.random() < 0.3:
        return {"brick": brick, "twin": brick + (off(rng), off(rng), off(rng))}
    return {"brick": brick, "screen": brick - (BRICK[0] + 0.02 + off(rng), 0.0, 0.0)}


def along_an_edge(rng: Generator) -> dict[str, Array]:
    """A screen whose upright edge lies in the line of sight along the brick's side."""
    brick, eye = ahead(rng), EYE_M
    side, share = rng.choice((-1, 1)), rng.uniform(0.3, 0.8)
    edge = eye + share * (brick + (BRICK[0], side * BRICK[1], 0.0) * np.array((-1, 1, 1)) - eye)
    return {"brick": brick, "screen": edge - (-0.02, side * (0.2 + off(rng)), 0.0)}


def around_the_eye(rng: Generator) -> dict[str, Array]:
    """The eye in a hall or in the box of a mesh, or at its face; the brick within or without."""
    hider, half = (("hall", (1.0, 1.5, 1.2)), ("dome", (1.2, 1.2, 1.2)))[rng.integers(2)]
    at = EYE_M + rng.uniform(-1, 1, 3) * half
    if rng.random() < 0.3:
        at[0] = EYE_M[0] + rng.choice((-1, 1)) * half[0] + off(rng)
    return {"brick": ahead(rng) * (rng.choice((1.0, 3.0)), 1.0, 1.0), hider: at}


def within(rng: Generator) -> dict[str, Array]:
    """The brick in the hall, their near faces flush."""
    brick = ahead(rng)
    return {"brick": brick, "hall": brick + (1.0 - BRICK[0] + off(rng), 0.0, 0.0)}


def gems(rng: Generator) -> dict[str, Array]:
    """A mesh before, behind or upon the brick; meshes hide nothing from a glimpse."""
    brick = ahead(rng)
    return {"brick": brick, "gem": brick + (rng.uniform(-0.3, 0.3), rng.uniform(-0.1, 0.1), off(rng))}


@pytest.mark.parametrize("places", [flush, along_an_edge, around_the_eye, within, gems])
def test_grazing_things_are_not_passed_over(places: Callable[[Generator], dict[str, Array]]) -> None:
    rng, tally = np.random.default_rng(7), Tally()
    for _ in range(24):
        put_at = places(rng)
        here = Viewpoint(Stage(SCENE, put(SCENE, put_at)), "P1", COARSE)
        for name in sorted(SOUGHT & put_at.keys()):
            check_aimed(Head.of(here, name), rng, tally)
    assert tally.seen


# shadows ------------------------------------------------------------------------------------------------------

EDGE_M = 1e-7
"""Nearer than this to a box, rounding may decide."""


def meets(half: Array, start: Array, ends: Array) -> NDArray[np.bool_]:
    """Whether lines from a point, (3,), to others, (k, 3), run through a box about the origin."""
    with np.errstate(divide="ignore"):
        sides = np.stack([(sign * half - start) / (ends - start) for sign in (-1, 1)])
    enter, leave = sides.min(axis=0).max(axis=1), sides.max(axis=0).min(axis=1)
    return np.asarray(np.maximum(enter, 0.0) <= np.minimum(leave, 1.0))


@pytest.mark.parametrize("seed", range(4))
def test_shadows_hold_all_and_only_what_a_box_hides(seed: int) -> None:
    """Told by the lines of sight to corners, and to points between them."""
    rng, found = np.random.default_rng(seed), {True: 0, False: 0}
    half = rng.uniform(0.05, 0.4, 3)
    box = Thing("box", tuple(half), (0.5, 0.2, 1.0), yaw=rng.uniform(-3, 3), roll=rng.uniform(-3, 3))
    stage = Room((box,), (Person("P1", (0.0, 0.0)),)).stage()
    shapes = stage.scene.seen_geoms("box")
    pose = stage.geom(int(shapes[0]))
    for _ in range(300):
        start, middle = rng.uniform(-3, 3, 3) * half, rng.uniform(-2, 2, 3) * half
        corners = middle + rng.uniform(-0.1, 0.1, (8, 3))
        between = rng.dirichlet(np.ones(8), 30) @ corners
        eye = np.concatenate((pose.to_world(start), np.eye(3).ravel()))
        hider = in_shadow(from_eye(stage.shapes, shapes, eye, False), pose.to_world(corners), eye)
        inside = bool((np.abs(start) < half).all())
        if hider != NO_GEOM:
            assert not inside
            assert meets(half + EDGE_M, start, np.vstack((corners, between))).all()
        elif not inside:
            assert not meets(half - EDGE_M, start, corners).all()
        found[hider != NO_GEOM] += 1
    assert min(found.values()) > 20


# visibility ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", SEEDS)
def test_visibility_from_a_viewpoint_is_that_of_the_stage(seed: int) -> None:
    """Before and after the viewpoint was asked other things."""
    case = random_case(seed)
    for agent in case.scene.agents:
        here = Viewpoint(case.stage(), agent, COARSE)
        for name in case.scene.objects:
            plain = visibility(case.stage(), agent, name, COARSE)
            known = case.state.known([name, f"{agent}/head"])
            assert (plain is not None) == known
            assert here.visibility(name) == plain
            effort_from(here, name, "see")
            assert here.visibility(name) == plain


@pytest.mark.parametrize("lost", ["cup", "P1", "P1/head"])
def test_visibility_of_the_untracked_is_unknown(lost: str) -> None:
    room = Room((Thing("cup", (0.03, 0.05), (0.6, 0.0, 1.4), "cylinder"),), (Person("P1", (0.0, 0.0)),), (48, 36))
    scene = room.scene()
    here = Viewpoint(Stage(scene, State(scene.initial.qpos, untracked=frozenset({lost}))), "P1", COARSE)
    assert here.visibility("cup") is None
    assert visibility(here.stage, "P1", "cup", COARSE) is None
    assert Viewpoint(Stage(scene), "P1", COARSE).visibility("cup") is not None


def test_visibility_of_what_is_not_there_is_refused() -> None:
    here = Viewpoint(Stage(SCENE), "P1", COARSE)
    with pytest.raises(UnknownNameError, match="cup"):
        here.visibility("cup")
