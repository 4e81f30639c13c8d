"""A robot takes a thing that is held in the air: its hand gets around it, or the reason is told."""

from __future__ import annotations

from functools import cache

import numpy as np

from taskgist.common.arrays import Array
from taskgist.planning.handing import FULL, Taking
from taskgist.planning.robot_taking import RobotTaker, taker_of
from taskgist.settings import DEFAULT
from taskgist.world import Hold, Scene, Stage, State
from tests.planning.rooms import Judge, box, cover, room, table, two_tables

AHEAD_M = (0.6, 0.0, 1.0)
"""Before a Jido that stands at the origin, in reach of its arm."""


@cache
def scene() -> Scene:
    return two_tables("jido", box(1.7))


def in_air(place: tuple[float, float, float] = AHEAD_M) -> State:
    column = scene().object_slice("box")
    return scene().initial.replace(at=column, to=np.array((*place, 1.0, 0.0, 0.0, 0.0)))


def taker(state: State) -> RobotTaker:
    return RobotTaker(scene(), "R", state, DEFAULT)


def ways(qpos: Array) -> list[Taking | str]:
    return list(taker(scene().initial).takings(qpos, "box"))


def test_its_hand_gets_around_what_is_in_reach_and_pushes_into_nothing() -> None:
    found = taker(scene().initial).holding(in_air(), "box")
    assert isinstance(found, State)
    moved = np.flatnonzero(np.abs(found.qpos - in_air().qpos) > 1e-9)
    own = {*scene().agent("R").joints.values()}
    assert set(moved.tolist()) <= own, "neither its base nor the box"
    stage = Stage(scene(), found)
    palm = stage.site(scene().agent("R").arm("right").palm_site).position
    assert np.linalg.norm(palm - AHEAD_M) < 0.15
    deep_m, what = Judge(scene()).deepest(found.qpos, "box")
    assert deep_m < 0.002, what


def test_the_way_there_begins_where_it_is_and_ends_around_the_thing_which_stays() -> None:
    found = next(each for each in ways(in_air().qpos) if isinstance(each, Taking))
    assert found.side == "right"
    assert np.abs(found.coming[0] - in_air().qpos).max() < 0.05
    assert np.array_equal(found.shared, np.repeat(found.shared[:1], len(found.shared), axis=0)), "both hold still"
    column = scene().object_slice("box")
    assert np.abs(found.coming[:, column] - in_air().qpos[column]).max() < 1e-9
    judge = Judge(scene())
    assert max(judge.deepest(row, "box")[0] for row in found.coming[::5]) < 0.002


def test_what_is_out_of_reach_is_told() -> None:
    far = taker(scene().initial).holding(in_air((2.5, 0.0, 1.0)), "box")
    assert isinstance(far, str)
    assert far.endswith("grasps of the box are out of the arm's reach")
    assert ways(in_air((2.5, 0.0, 1.0)).qpos) == [far]


def test_what_blocks_every_grasp_is_told() -> None:
    shut = room("jido", table("table", 1.0), box(0.85), cover(0.85))
    told = RobotTaker(shut, "R", shut.initial, DEFAULT).holding(shut.initial, "box")
    assert told == "all approaches to the box where it lies are blocked by the table and the cover"


def test_a_hand_that_holds_something_else_takes_nothing() -> None:
    busy = scene().initial.with_holding({Hold("R", "right", "mug")})
    assert taker(busy).holding(in_air(), "box") == FULL


def test_a_robot_is_no_person() -> None:
    assert isinstance(taker_of(scene(), "R", scene().initial, DEFAULT), RobotTaker)
