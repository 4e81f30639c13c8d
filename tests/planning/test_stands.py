"""Where a robot can stand: free, got to, near first, and within reach; and why there is nowhere."""

from __future__ import annotations

import math
from itertools import islice, pairwise

import numpy as np
import pytest

from taskgist.planning.grasping import Grasping
from taskgist.planning.performer import Performer
from taskgist.planning.sliding import why_not_slid
from taskgist.planning.stands import APART_M, APART_RAD, Stand, Stands
from taskgist.planning.transfer import Picking, Picks, Transfers
from taskgist.world.geometry.transforms import wrapped
from tests.bodies import needs
from tests.planning.rooms import Judge, box, cover, room, table, tape, two_tables
from tools.rooms import Thing, wall

ROBOTS = [pytest.param("pr2", marks=needs("pr2")), "jido"]


@pytest.fixture(scope="module", params=ROBOTS)
def grasping(request: pytest.FixtureRequest) -> Grasping:
    performer = Performer(two_tables(request.param, box(1.5)), "R")
    return Grasping(performer, performer.start, "box", np.array((-1.1, 0.8, 0.745, 1, 0, 0, 0)))


@pytest.fixture(scope="module")
def stands(grasping: Grasping) -> list[Stand]:
    return list(islice(Stands(grasping), 12))


def test_stands_are_free_by_mujoco_alone_arms_folded(grasping: Grasping, stands: list[Stand]) -> None:
    performer, judge = grasping.performer, Judge(grasping.performer.scene)
    assert len(stands) > 5
    for stand in stands:
        assert judge.deepest(stand.qpos)[0] < 0.002
        assert performer.base(stand.qpos) == pytest.approx(stand.base)
        np.testing.assert_allclose(stand.qpos[performer.agent.arm_positions], performer.folded)


def test_from_each_stand_some_grasp_is_within_reach(grasping: Grasping, stands: list[Stand]) -> None:
    for stand in stands:
        assert stand.in_reach
        assert {row for _, row in stand.in_reach} <= set(grasping.free.tolist())
        x, y, _ = stand.base
        assert math.hypot(1.5 - x, y) < 1.6


def test_no_two_stands_are_alike(stands: list[Stand]) -> None:
    for number, one in enumerate(stands):
        for other in stands[number + 1 :]:
            away_m = math.hypot(one.base[0] - other.base[0], one.base[1] - other.base[1])
            assert away_m >= APART_M or abs(wrapped(one.base[2] - other.base[2])) >= APART_RAD


def test_near_ones_come_before_far_ones(grasping: Grasping) -> None:
    """In batches of the floor's ways: 0.6, 2 and 4 metres."""
    ways = [stand.way_m for stand in islice(Stands(grasping), 60)]
    batches = [next(index for index, limit in enumerate((0.6, 2.0, 4.0, math.inf)) if way <= limit) for way in ways]
    assert batches == sorted(batches)
    assert len(set(batches)) > 1


def test_stands_for_putting_down_are_around_the_goal(grasping: Grasping) -> None:
    for stand in islice(Stands(grasping, "goal"), 8):
        assert math.hypot(-1.1 - stand.base[0], 0.8 - stand.base[1]) < 1.6


def test_the_same_question_has_the_same_answer(grasping: Grasping, stands: list[Stand]) -> None:
    again = list(islice(Stands(grasping), 12))
    assert [stand.base for stand in again] == [stand.base for stand in stands]


def test_most_stands_are_good_for_a_pick(grasping: Grasping, stands: list[Stand]) -> None:
    able = [next(Picks(grasping, stand.qpos).by(), None) is not None for stand in stands[:6]]
    assert sum(able) >= 2


# --- Why there is none.


@pytest.mark.parametrize("robot", ROBOTS)
def test_beneath_a_cover_the_effort_refuses_first(robot: str) -> None:
    performer = Performer(two_tables(robot, tape(1.5), cover(1.5)), "R")
    stands = Stands(Grasping(performer, performer.start, "tape"))
    assert stands.refusal is not None
    assert "R cannot grasp the tape" in stands.refusal
    assert "cover" in stands.refusal
    assert not Picking(Grasping(performer, performer.start, "tape")).may_slide
    assert list(stands) == []


def test_what_lies_too_flat_to_be_grasped_has_to_be_slid_first() -> None:
    """No finger gets beneath a plate on a table."""
    plate = Thing("plate", (0.06, 0.06, 0.01), (1.5, 0.0, 0.73))
    performer = Performer(two_tables("jido", plate), "R")
    picking = Picking(Grasping(performer, performer.start, "plate"))
    assert picking.refusal == "the plate would have to be slid over the edge before it is grasped"
    assert picking.may_slide


def test_why_nothing_is_slid_where_no_edge_is_near() -> None:
    performer = Performer(two_tables("jido", Thing("plate", (0.06, 0.06, 0.01), (0.8, 0.0, 0.01))), "R")
    told = why_not_slid(performer.scene, performer.start, performer, "plate")
    assert told == "no edge of the floor is near enough to the plate, and free"


def test_behind_a_wall_nothing_is_got_to() -> None:
    """A closed room within the room: the way over the floor ends at the wall."""
    around = [
        wall("front", 0.75, half=(0.02, 3.0, 1.25)),
        wall("rear", -1.5, half=(0.02, 3.0, 1.25)),
        *(Thing(f"side{sign}", (1.2, 0.02, 1.25), (-0.4, sign * 1.5, 1.25), free=False) for sign in (1, -1)),
    ]
    performer = Performer(room("jido", table("table", 2.5), box(2.3), *around), "R")
    grasping = Grasping(performer, performer.start, "box")
    assert list(Stands(grasping)) == []
    assert Stands(grasping).refusal is not None


def test_a_torso_that_would_have_to_move_is_named() -> None:
    """A person reaches down to the far side of a table by leaning; arms alone do not."""
    performer = Performer(room("human", table("table", 0.9), box(0.95)), "R")
    stands = Stands(Grasping(performer, performer.start, "box"))
    assert stands.refusal is not None
    assert "torso_turn and torso_lean" in stands.refusal


def test_a_body_that_stays_has_the_stand_where_it_is() -> None:
    high = table("table", 0.62, height=1.0)
    thing = Thing("box", (0.025,) * 3, (0.42, -0.2, 1.025))
    performer = Performer(room("hrp2", high, thing, at=(0.0, 0.0)), "R")
    grasping = Grasping(performer, performer.start, "box")
    found = list(islice(Stands(grasping), 1))
    assert [stand.base for stand in found] == [pytest.approx((0.0, 0.0, 0.0))]


def test_who_stands_on_legs_stays_where_it_is() -> None:
    """Feet do not slide over the floor: what is two steps away is not got hold of, and walking is named."""
    performer = Performer(room("hrp2", table("table", 1.7), box(1.4)), "R")
    assert performer.agent.profile.moves
    assert not performer.drives
    stands = Stands(Grasping(performer, performer.start, "box"))
    assert list(stands) == []
    assert stands.refusal == "R would have to walk to grasp the box, which is not planned"


def test_a_transfer_that_fails_says_why() -> None:
    """The goal is between two boards that leave no room for a hand."""
    slot = [Thing(f"board{z}", (0.35, 0.5, 0.01), (-1.2, 1.0, z), free=False) for z in (0.73, 0.83)]
    performer = Performer(two_tables("jido", box(1.5), *slot), "R")
    picking = Picking(Grasping(performer, performer.start, "box"))
    assert picking.refusal is None
    transfers = Transfers(picking, np.array((-1.2, 1.0, 0.765, 1, 0, 0, 0)))
    assert list(transfers) == []
    assert transfers.refusal == "no grasp of the box does for both ends"
    (told,) = (each for each in picking.text if each.startswith("where it is to be, "))
    assert "board" in told


def test_what_one_goal_finds_about_the_start_another_does_not_find_again() -> None:
    performer = Performer(two_tables("jido", box(1.5)), "R")
    goals = [np.array((-1.1, y, 0.745, 1, 0, 0, 0)) for y in (0.8, 1.2)]
    shared = Picking(Grasping(performer, performer.start, "box"))
    for goal in goals:
        alone = next(iter(Transfers(Picking(Grasping(performer, performer.start, "box")), goal)))
        together = next(iter(Transfers(shared, goal)))
        assert (alone.start.base, alone.pick.grasp) == (together.start.base, together.pick.grasp)
        assert np.array_equal(alone.place.line, together.place.line)


def test_several_transfers_differ() -> None:
    performer = Performer(two_tables("jido", box(1.5)), "R")
    picking = Picking(Grasping(performer, performer.start, "box"))
    found = list(islice(Transfers(picking, np.array((-1.1, 0.8, 0.745, 1, 0, 0, 0))), 3))
    assert len(found) == 3
    for one, other in pairwise(found):
        assert one.pick.grasp != other.pick.grasp or one.start.base != other.start.base
