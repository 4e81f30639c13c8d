"""Sweeps against configurations looked at one by one, by MuJoCo alone."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from taskgist.common.arrays import Array
from taskgist.planning.performer import Performer, with_values
from taskgist.planning.sweeps import CLEARANCE_M, NOWHERE, Sweep, line_is_free, points_are_free
from taskgist.world import Stage, State
from tests.bodies import needs
from tests.planning.rooms import Judge, box, room, two_tables
from tools.rooms import Thing

WITH_PR2 = [pytest.param("pr2", marks=needs("pr2")), "jido"]
DENSE = 60


@pytest.fixture(scope="module", params=WITH_PR2)
def performer(request: pytest.FixtureRequest) -> Performer:
    return Performer(two_tables(request.param, box(1.5)), "R")


def near_table(performer: Performer, rng: np.random.Generator) -> Array:
    """The robot somewhere before the table, its arm drawn."""
    chain = performer.chain(performer.sides[-1])
    values = rng.uniform(np.maximum(chain.low, -math.pi), np.minimum(chain.high, math.pi))
    base = (float(rng.uniform(0.2, 0.8)), float(rng.uniform(-0.5, 0.5)), float(rng.uniform(-1.0, 1.0)))
    return performer.at(with_values(performer.start.qpos, chain.positions, values), base)


def gap_m(performer: Performer, qpos: Array) -> float:
    """The smallest gap between the robot and all else but the floor."""
    stage = Stage(performer.scene, State(qpos))
    others = [g for g in np.setdiff1d(stage.solid_geoms(), performer.body.own) if not stage.is_plane(int(g))]
    return stage.closest(performer.body.own, others, limit_m=1.0)[0]


@pytest.mark.parametrize("what", ["arm", "base"])
def test_what_is_free_by_a_look_is_free_wherever_that_says_so(performer: Performer, what: str) -> None:
    rng, judge, side = np.random.default_rng(1), Judge(performer.scene), performer.sides[-1]
    positions, certain = performer.chain(side).positions, 0
    for _ in range(40):
        qpos = near_table(performer, rng)
        if what == "arm":
            sweep, values, half = (
                performer.arm_sweep(qpos, side),
                qpos[positions],
                rng.uniform(0.0, 0.2, len(positions)),
            )
        else:
            sweep, values, half = performer.base_sweep(qpos), np.array(performer.base(qpos)), rng.uniform(0.0, 0.2, 3)
        share = sweep.look(values, half)
        if judge.deepest(qpos)[0] > 0.002:
            if what == "arm":  # as the base moves, nothing changes of how the robot's links are to one another
                assert share == NOWHERE
            continue
        if share <= 0.0:
            continue
        certain += 1
        for _ in range(12):
            beside = values + share * half * rng.choice((-1.0, 1.0, 0.5), len(half))
            moved = with_values(qpos, positions, beside) if what == "arm" else performer.at(qpos, tuple(beside))
            assert judge.deepest(moved)[0] < 0.002
    assert certain > 5


def test_lines_are_free_as_their_steps_are_and_nothing_of_a_board_is_missed(performer: Performer) -> None:
    """A thin board stands in the robot's way, thinner than any step."""
    start = np.array(performer.base(performer.start.qpos))
    ahead = float(Stage(performer.scene).bounds(performer.body.own)[1, 0])
    thin = Thing("board", (0.0005, 0.5, 0.5), (ahead + 0.2, 0.0, 0.5), free=False)
    blocked = Performer(room(performer.agent.profile.name, thin), "R")
    sweep = blocked.base_sweep(blocked.start.qpos)
    assert line_is_free(sweep.look, start, start + (0.19, 0.0, 0.0))
    assert not line_is_free(sweep.look, start, start + (0.4, 0.0, 0.0))
    assert not line_is_free(sweep.look, start, start + (2.5, 0.0, 0.0))
    assert sweep.blocked is not None
    assert sweep.blocked.other == "board"


def test_ways_keep_clear_and_need_not_be_farther_from_things_than_at_their_ends() -> None:
    alone = room("jido")
    ahead = float(Stage(alone).bounds(Performer(alone, "R").body.own)[1, 0])
    beside = Thing("wall", (0.02, 0.5, 0.5), (ahead + 0.02 + CLEARANCE_M / 2, 0.0, 0.5), free=False)
    performer = Performer(room("jido", beside), "R")
    start = np.array(performer.base(performer.start.qpos))
    away = start - (0.5, 0.0, 0.0)
    along = start + (0.0, 0.05, 0.0)
    assert gap_m(performer, performer.start.qpos) == pytest.approx(CLEARANCE_M / 2, abs=1e-4)
    strict, ending = (
        performer.base_sweep(performer.start.qpos),
        performer.base_sweep(performer.start.qpos, ends=(start,)),
    )
    both = performer.base_sweep(performer.start.qpos, ends=(away,))
    assert strict.look_closely(start, np.zeros(3)) >= 0.0
    assert not both.is_free(start), "a way that neither begins nor ends there keeps clear of the wall"
    assert ending.is_free(start)
    assert line_is_free(ending.look, start, away)
    assert line_is_free(ending.look, start, along)
    assert not ending.is_free(start + (CLEARANCE_M / 4, 0.0, 0.0)), "but gets no nearer to it than it was"


def test_what_is_held_is_swept_as_well(performer: Performer) -> None:
    """A box in the hand before a wall: the robot alone has room, what it holds has none."""
    side = performer.sides[-1]
    qpos = performer.start.qpos
    palm = performer.palm(qpos, side)
    thing = performer.scene.object_slice("box")
    ahead = performer.ahead_in_palm(side)
    where = palm.to_world(0.1 * ahead)
    held = with_values(qpos, thing, np.array((*where, 1.0, 0.0, 0.0, 0.0)))
    grip = performer.grip(held, "box", side)
    start = np.array(performer.base(qpos))
    judge = Judge(performer.scene)
    for share in np.linspace(0.0, 1.0, 8):
        base = start + share * np.array([1.0, 0.2, 0.3])
        sweep = performer.base_sweep(held, grip)
        moved = performer.carried(performer.at(held, tuple(base)), grip)
        deep = judge.deepest(moved, held="box")[0]
        free = sweep.look_closely(base, np.zeros(3)) >= 0.0
        assert free == (deep <= 0.001) or abs(deep - 0.001) < 2e-4


def test_points_are_free_as_all_their_lines_are() -> None:
    """A way around a corner among points: halving misses nothing that one line after the other finds."""
    performer = Performer(two_tables("jido", box(1.5)), "R")
    rng, found = np.random.default_rng(4), {True: 0, False: 0}
    for _ in range(12):
        turns = rng.uniform((-0.6, -0.8, -1.0), (2.0, 0.8, 1.0), (4, 3))
        points = np.concatenate([np.linspace(a, b, 15) for a, b in itertools.pairwise(turns)])
        sweep = performer.base_sweep(performer.start.qpos)
        slow = all(line_is_free(sweep.look_closely, a, b) for a, b in itertools.pairwise(points))
        assert points_are_free(sweep.look_closely, points) == slow
        found[slow] += 1
    assert min(found.values()) > 0


def test_a_look_in_an_empty_room_is_enough_for_a_long_line() -> None:
    performer = Performer(room("jido"), "R")
    sweep: Sweep = performer.base_sweep(performer.start.qpos)
    start = np.array(performer.base(performer.start.qpos))
    assert line_is_free(sweep.look, start, start + (3.0, 1.0, 0.5))
    assert sweep.looks < DENSE
