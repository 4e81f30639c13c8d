"""Which hand takes a thing: the nearer one; where both are equally near, the right one, as with most people."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest

from taskgist.perspective import Ability, Effort, Viewpoint, effort_from
from taskgist.world import Stage
from taskgist.world.scene_file import AgentEntry
from taskgist_lab.ordinary.furniture import Piece, chair, table
from taskgist_lab.simulator.room import Thing
from tests.bodies import needs
from tests.ordinary import Line, a, ball, block, board, robot, sits, stands

TABLE = table("table", (0.7, 0.0))
DINING = (TABLE, chair("chair", (0.0, 0.0)))

AHEAD: dict[str, tuple[AgentEntry, Sequence[Piece], Thing]] = {
    "at the chest": (stands(), (), a("cup", 0.45, 0.0, 1.2)),
    "on the table": (stands(), (TABLE,), a("cup", 0.45, 0.0, 0.74)),
    "before the diner": (sits(), DINING, a("cup", 0.45, 0.0, 0.74)),
    "leaning": (stands(), (), a("cup", 0.85, 0.0, 1.2)),
    "on the floor": (stands(), (), a("cup", 0.5, 0.0)),
    "a walk away": (stands(), (), a("cup", 2.5, 0.0, 1.0)),
    "over the head": (stands(), (), ball(0.06, 0.2, 0.0, 1.8)),
    "flat": (sits(), DINING, block((0.05, 0.05, 0.01), 0.45, 0.0, 0.74)),
    "behind a box": (sits(), (*DINING, board("box", (0.04, 0.04, 0.3), 0.45, 0.0, 0.89)), a("cup", 0.6, 0.0, 0.74)),
}
"""All of it mirrors itself."""
OFF_M = 0.06
SIDES = ("left", "right")


def effort(body: AgentEntry, pieces: Sequence[Piece], thing: Thing, ability: Ability, without: str = "") -> Effort:
    stage = Stage(Line("", body, tuple(pieces), thing, "?", "?", "?").scene())
    here = Viewpoint(stage, "P")
    if without:
        here = Viewpoint(stage, "P", actions=here.actions - {f"Stretch_Out_Arm({without})"})
    return effort_from(here, "thing", ability)


@pytest.mark.parametrize("ability", ["reach", "grasp"])
@pytest.mark.parametrize("place", AHEAD)
def test_between_two_hands_that_are_equally_near_the_right_one_is_taken(place: str, ability: Ability) -> None:
    found = effort(*AHEAD[place], ability)
    assert found.actions[-1] == "Stretch_Out_Arm(right)"
    assert found.evidence_document["arm"] == "right"
    left = effort(*AHEAD[place], ability, without="right")
    assert (left.level, left.amount and left.amount.key) == (found.level, found.amount and found.amount.key)


@pytest.mark.parametrize("ability", ["reach", "grasp"])
@pytest.mark.parametrize("place", [place for place in AHEAD if place != "a walk away"])
def test_what_is_nearer_to_one_hand_is_taken_with_it(place: str, ability: Ability) -> None:
    """Mirrored rooms have mirrored hands; who walks turns to the thing first."""
    body, pieces, thing = AHEAD[place]
    for side, off_m in zip(SIDES, (OFF_M, -OFF_M), strict=True):
        x, y, z = thing.position_m
        aside = replace(thing, position_m=(x, y + off_m, z))
        assert effort(body, pieces, aside, ability).actions[-1] == f"Stretch_Out_Arm({side})"


@pytest.mark.parametrize("profile", [pytest.param(name, marks=needs(name)) for name in ("pr2", "talos")])
def test_robots_have_a_right_hand_too(profile: str) -> None:
    assert effort(robot(profile), (), a("cup", 0.7, 0.0, 0.9), "reach").actions[-1] == "Stretch_Out_Arm(right)"


def test_why_nothing_is_reached_names_the_right_arm_where_both_miss_alike() -> None:
    found = effort(stands(), (), a("cup", 0.5, 0.0, 2.6), "reach")
    assert found.level == 5
    assert "right shoulder" in found.reason
