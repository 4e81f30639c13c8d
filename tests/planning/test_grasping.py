"""Picking up and putting down: free by MuJoCo alone, straight, and told where it fails."""

from __future__ import annotations

import math
from itertools import islice

import numpy as np
import pytest

from taskgist.errors import SceneError, UnknownNameError
from taskgist.planning.grasping import Grasping
from taskgist.planning.hand_ways import Gate, HandWay
from taskgist.planning.performer import Performer
from taskgist.planning.transfer import Picking, Picks, Transfer, Transfers
from taskgist.world import Stage, State, holding_of
from tests.bodies import needs
from tests.planning.rooms import Judge, box, cover, mug, room, table, tape, two_tables
from tools.rooms import Thing

TOO_DEEP_M = 0.002
THINGS = {"box": box(1.5), "mug": mug(1.5, 0.1), "tape": tape(1.5, -0.1)}
CASES = [
    pytest.param((robot, thing), marks=needs(robot), id=f"{robot} {thing}")
    for robot in ("pr2", "jido")
    for thing in THINGS
]


def goal_of(thing: Thing) -> np.ndarray:
    """On the other table."""
    return np.array((-1.1, 0.8, thing.place[2], math.cos(0.3), 0.0, 0.0, math.sin(0.3)))


@pytest.fixture(scope="module", params=CASES)
def found(request: pytest.FixtureRequest) -> tuple[Performer, Grasping, Transfer]:
    robot, name = request.param
    thing = THINGS[name]
    performer = Performer(two_tables(robot, thing), "R")
    grasping = Grasping(performer, performer.start, name, goal_of(thing))
    picking = Picking(Grasping(performer, performer.start, name))
    return performer, grasping, next(iter(Transfers(picking, goal_of(thing))))


def configurations(performer: Performer, transfer: Transfer) -> list[tuple[np.ndarray, str | None]]:
    """Every way point, with what is held."""
    pick, place = transfer.pick, transfer.place
    open_ones = [pick.opened(values) for values in pick.approach] + [place.opened(values) for values in place.retreat]
    held = [performer.carried(pick.closed(values), pick.grip) for values in pick.lift]
    held += [performer.carried(place.closed(values), place.grip) for values in place.lower]
    return [(qpos, None) for qpos in (transfer.start.qpos, *open_ones)] + [(qpos, pick.thing) for qpos in held]


def test_no_way_point_penetrates_by_mujoco_alone(found: tuple[Performer, Grasping, Transfer]) -> None:
    performer, _, transfer = found
    judge = Judge(performer.scene)
    for qpos, held in configurations(performer, transfer):
        depth_m, between = judge.deepest(qpos, held)
        assert depth_m < TOO_DEEP_M, between


@pytest.mark.parametrize("robot", [pytest.param("pr2", marks=needs("pr2")), "jido"])
@pytest.mark.parametrize("name", THINGS)
def test_hands_close_on_the_outside_and_not_through_walls(robot: str, name: str) -> None:
    """The mug is made of boxes that touch one another: faces between them are within it."""
    performer = Performer(two_tables(robot, THINGS[name]), "R")
    grasping = Grasping(performer, performer.start, name)
    near = performer.at(performer.start.qpos, (0.75, 0.0, 0.0))
    stage = Stage(performer.scene)
    shapes, body = performer.scene.solid_geoms_of(name), stage.body(performer.scene.object_body(name))
    picks = list(islice(Picks(grasping, near).by(), 15))
    assert picks
    for pick in picks:
        grasps = grasping.grasps.only(np.array([pick.grasp]))
        for sign in (1.0, -1.0):
            point = body.to_world(grasps.centers + sign * grasps.closings * (grasps.widths_m[:, None] / 2 + 0.0015))[0]
            assert not any(inside(performer, int(shape), point) for shape in shapes), "a finger would be in it"
        shut = pick.closed(pick.line[-1])
        assert performer.body.in_hand_m(shut, name, pick.side) <= 0.001


def inside(performer: Performer, geom: int, point: np.ndarray) -> bool:
    """Whether a point is in a box of the scene as it is at the start."""
    pose, half = Stage(performer.scene).geom(geom), performer.scene.model.geom_size[geom]
    return bool((np.abs(pose.to_local(point)) < half - 5e-4).all())


def palms(performer: Performer, way: HandWay, line: np.ndarray) -> np.ndarray:
    return np.array([performer.palm(way.opened(values), way.side).position for values in line])


def test_the_hand_comes_straight_and_rises_straight(found: tuple[Performer, Grasping, Transfer]) -> None:
    performer, _, transfer = found
    for way in (transfer.pick, transfer.place):
        line, rise = palms(performer, way, way.line), palms(performer, way, way.rise)
        assert np.linalg.norm(line[-1] - line[0]) == pytest.approx(0.10, abs=0.003)
        along = (line[-1] - line[0]) / np.linalg.norm(line[-1] - line[0])
        approach = performer.palm(way.opened(way.line[-1]), way.side)
        assert approach.matrix[:, 0] @ along > 0.999
        strays = (line - line[0]) - np.outer((line - line[0]) @ along, along)
        assert np.abs(strays).max() < 0.001
        np.testing.assert_allclose(np.diff(line @ along), 0.005, atol=0.001)
        assert np.ptp(rise[:, :2], axis=0).max() < 0.002
        assert 0.048 < rise[-1, 2] - rise[0, 2] < 0.082
        for each in (way.line, way.rise):
            assert np.abs(np.diff(each, axis=0)).max() < 0.31
            chain = performer.chain(way.side)
            assert (each >= chain.low).all()
            assert (each <= chain.high).all()


def test_the_thing_ends_where_it_is_to_lie(found: tuple[Performer, Grasping, Transfer]) -> None:
    performer, grasping, transfer = found
    end = performer.carried(transfer.place.closed(transfer.place.lower[-1]), transfer.place.grip)[grasping.thing_slice]
    assert grasping.goal is not None
    wanted = grasping.goal.qpos[grasping.thing_slice]
    assert np.linalg.norm(end[:3] - wanted[:3]) < 0.001
    assert abs(float(end[3:] @ wanted[3:])) > math.cos(math.radians(0.5))


def test_the_thing_is_between_the_fingers(found: tuple[Performer, Grasping, Transfer]) -> None:
    """The engine's own word on who holds what, once it is lifted."""
    performer, grasping, transfer = found
    pick = transfer.pick
    lifted = performer.carried(pick.closed(pick.lift[-1]), pick.grip)
    holding = holding_of(Stage(performer.scene, State(lifted)), grasping.thing, performer.settings.contact)
    assert holding is not None
    assert holding.hands == (("R", pick.side),)


def test_nothing_but_the_arm_and_the_hand_differs_from_the_stand(found: tuple[Performer, Grasping, Transfer]) -> None:
    performer, _, transfer = found
    pick, chain = transfer.pick, performer.chain(transfer.pick.side)
    moved = np.flatnonzero(pick.opened(pick.line[0]) != transfer.start.qpos)
    assert set(moved) <= {*chain.positions.tolist(), *pick.hand_positions.tolist()}


def test_the_same_question_has_the_same_answer() -> None:
    answers = []
    for _ in range(2):
        performer = Performer(two_tables("jido", THINGS["tape"]), "R")
        transfer = next(iter(Transfers(Picking(Grasping(performer, performer.start, "tape")), goal_of(THINGS["tape"]))))
        answers.append(np.concatenate((transfer.start.base, transfer.pick.line.ravel(), transfer.place.rise.ravel())))
    np.testing.assert_array_equal(answers[0], answers[1])


# --- Where it fails.


@pytest.mark.parametrize("robot", [pytest.param("pr2", marks=needs("pr2")), "jido"])
def test_a_thing_that_is_too_wide_is_refused_with_its_width(robot: str) -> None:
    performer = Performer(two_tables(robot, box(1.5, half=(0.08, 0.08, 0.08))), "R")
    grasping = Grasping(performer, performer.start, "box")
    opening = 0.086 if robot == "pr2" else 0.080
    assert grasping.miss is not None
    assert grasping.miss.text == f"the box is too wide for the hand (0.160 m > {opening:.3f} m)"


@pytest.mark.parametrize("robot", [pytest.param("pr2", marks=needs("pr2")), "jido"])
def test_beneath_a_cover_no_grasp_is_free_and_the_cover_is_named(robot: str) -> None:
    performer = Performer(two_tables(robot, tape(1.5), cover(1.5)), "R")
    grasping = Grasping(performer, performer.start, "tape")
    assert not len(grasping.free)
    assert set(grasping.tally.counts) == {Gate.HAND_AT_START}
    assert grasping.tally.counts[Gate.HAND_AT_START] == len(grasping.grasps)
    text = grasping.tally.text("tape")
    assert text.startswith("all approaches to the tape where it lies are blocked by")
    assert "the cover" in text


def test_each_grasp_that_fails_before_the_arm_is_counted_once() -> None:
    performer = Performer(two_tables("jido", THINGS["box"]), "R")
    grasping = Grasping(performer, performer.start, "box", goal_of(THINGS["box"]))
    free = len(grasping.free)
    assert 0 < free < len(grasping.grasps)
    failed = sum(grasping.tally.counts.values()) + sum(grasping.place_tally.counts.values())
    assert failed + free == len(grasping.grasps)


def test_from_too_far_away_all_is_out_of_reach() -> None:
    performer = Performer(two_tables("jido", THINGS["box"]), "R")
    grasping = Grasping(performer, performer.start, "box")
    assert list(Picks(grasping, performer.at(performer.start.qpos, (-0.5, 0.0, 0.0))).by()) == []
    assert grasping.tally.counts[Gate.REACH] == len(grasping.free)
    assert "out of the arm's reach" in grasping.tally.text("box")


def test_a_lid_above_leaves_no_way_up() -> None:
    """A shelf board so low that the box is taken from the side, and not lifted five centimetres."""
    board = Thing("board", (0.3, 0.5, 0.01), (1.7, 0.0, 0.72 + 0.05 + 0.035), free=False)
    performer = Performer(two_tables("jido", box(1.4), board), "R")
    grasping = Grasping(performer, performer.start, "box")
    stand = performer.at(performer.start.qpos, (0.65, 0.0, 0.0))
    assert list(Picks(grasping, stand).by()) == []
    assert "the board" in grasping.tally.text("box")


def test_a_hand_whose_fingers_stay_is_told() -> None:
    """HRP-2's fingers are 6 cm apart in its model, for good; its profile says 8."""
    performer = Performer(room("hrp2", table("table", 0.75), Thing("box", (0.035,) * 3, (0.5, -0.2, 0.755))), "R")
    grasping = Grasping(performer, performer.start, "box")
    assert list(Picks(grasping, performer.start.qpos).by()) == []
    assert grasping.tally.counts[Gate.OPENING] > 0
    assert "no joint of it opens it" in grasping.tally.text("box")


# --- Bad input.


def test_an_unknown_thing_is_refused() -> None:
    performer = Performer(two_tables("jido", THINGS["box"]), "R")
    with pytest.raises(UnknownNameError, match="no object 'cup'"):
        Grasping(performer, performer.start, "cup")


def test_a_thing_without_a_goal_is_put_down_nowhere() -> None:
    performer = Performer(two_tables("jido", THINGS["box"]), "R")
    grasping = Grasping(performer, performer.start, "box")
    pick = next(Picks(grasping, performer.at(performer.start.qpos, (0.75, 0.0, 0.0))).by())
    with pytest.raises(SceneError, match="box is to be put down nowhere"):
        next(grasping.places(performer.start.qpos, pick))
