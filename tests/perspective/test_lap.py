"""What lies on somebody's lap: at hand as long as he sits, taken up before he gets up, and never hanging in the air."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import pytest

from taskgist.perspective import Effort, Viewpoint, effort_from
from taskgist.perspective.effort import ABILITIES, Ability
from taskgist.world import Stage
from taskgist.world.scene_file import AgentEntry
from taskgist_lab.ordinary.furniture import Piece, bench, chair, sofa, table
from taskgist_lab.ordinary.rooms import scene_of
from taskgist_lab.simulator.room import Thing
from tests.ordinary import a, block, sits, stands

LAP_M = 0.585
"""How high thighs are on a chair."""
CHAIR = chair("chair", (0.0, 0.0))
SEATS: dict[str, tuple[AgentEntry, Sequence[Piece]]] = {
    "chair": (sits(), (CHAIR,)),
    "chair at a table": (sits(), (CHAIR, table("table", (0.85, 0.0)))),
    "bench": (sits(), (bench("bench", (0.0, 0.0)),)),
    "sofa": (sits(0.05), (sofa("sofa", (0.0, 0.0)),)),
}
ON_THE_LAP = {
    "book": a("book", 0.26, 0.0, LAP_M),
    "plate": a("plate", 0.28, 0.0, LAP_M),
    "phone": a("phone", 0.26, 0.08, LAP_M),
    "carton": block((0.22, 0.3, 0.2), 0.26, 0.0, LAP_M),
}
FAR, NEAR = a("cup", 2.5, 0.6, 0.0), a("cup", -0.05, -0.5, 0.0)


def viewpoint(seat: str, *things: Thing) -> Viewpoint:
    body, pieces = SEATS[seat]
    return Viewpoint(Stage(scene_of("lap", pieces, things, [body])), "P")


@cache
def efforts(seat: str, ability: Ability, thing: Thing, *others: Thing) -> Effort:
    return effort_from(viewpoint(seat, thing, *others), "thing", ability)


def named(thing: Thing) -> Thing:
    return replace(thing, name="lap thing")


def same(one: Effort, other: Effort) -> bool:
    return (one.level, one.actions, one.amount and one.amount.key) == (
        other.level,
        other.actions,
        other.amount and other.amount.key,
    )


@pytest.mark.parametrize("ability", ["reach", "grasp"])
@pytest.mark.parametrize("seat", SEATS)
@pytest.mark.parametrize("lap", ON_THE_LAP)
def test_whoever_gets_up_is_not_kept_down_by_what_lies_on_the_lap(lap: str, seat: str, ability: Ability) -> None:
    without = efforts(seat, ability, FAR)
    assert without.level == 4
    assert same(efforts(seat, ability, FAR, named(ON_THE_LAP[lap])), without)


@pytest.mark.parametrize("ability", ABILITIES)
@pytest.mark.parametrize("lap", ON_THE_LAP)
def test_it_takes_no_getting_up_to_see_reach_and_grasp_what_lies_on_the_lap(lap: str, ability: Ability) -> None:
    assert efforts("chair", ability, ON_THE_LAP[lap]).level in {1, 2}


def test_what_lies_on_the_lap_is_known_from_what_lies_beside_or_floats() -> None:
    assert viewpoint("chair", ON_THE_LAP["book"]).on_body == {"thing"}
    for beside in (NEAR, FAR, a("cup", 0.3, 0.0, LAP_M + 0.1), a("book", 0.75, 0.0, 0.74)):
        assert not viewpoint("chair at a table", beside).on_body


def test_nobody_stands_up_to_reach_what_lay_on_the_lap() -> None:
    """Whoever may not stretch out the arms while sitting does not find it in the air when he stands."""
    here = viewpoint("chair", ON_THE_LAP["book"])
    for level in (3, 4):
        assert all(
            "thing" in candidates.torso.start.aside
            for candidates in here.candidates.of_level(level, here.target("thing").middle)
        )
    blind = Viewpoint(viewpoint("chair", ON_THE_LAP["book"]).stage, "P", actions=("Make_Standing", "Move_To"))
    found = effort_from(blind, "thing", "see")
    assert found.level == 5
    assert "rests on P" in [miss.text for miss in found.evidence.misses][3]


def test_what_stands_on_the_floor_beside_stays_an_obstacle() -> None:
    crate = replace(block((0.5, 0.5, 0.9), 0.75, 0.0), name="crate")
    free, blocked = efforts("chair", "reach", FAR), efforts("chair", "reach", FAR, crate)
    assert not same(free, blocked)


def test_nothing_lies_on_who_stands_beside_it() -> None:
    stage = Stage(scene_of("lap", (), [a("cup", 0.5, 0.0)], [stands()]))
    assert not Viewpoint(stage, "P").on_body
