"""Comparisons and natures: Eq. 10-13, 15, 17, 18, 20, 21, 23, with the corrections of the design."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskgist.facts import EFFORT_LEVELS, REACH_EFFORTS, STANDARD_TREE, UNKNOWN, Observation
from taskgist.settings import DEFAULT

SEEDED = settings(derandomize=True)
SCORES = st.floats(0.0, 1.0)


def change(attribute: str, initial: Any, final: Any) -> tuple[object, object]:
    """Class and nature (None where there is none) of the subtree that compares an attribute."""
    nodes = STANDARD_TREE.instantiate(
        {attribute: Observation(initial)}, {attribute: Observation(final)}, settings=DEFAULT
    )
    subtree = attribute.split(".")[0]
    nature = nodes.get(f"{subtree}.nature")
    return nodes[f"{subtree}.class"].value, nature.value if nature else None


@pytest.mark.parametrize("ability", ["reach", "grasp"])
@pytest.mark.parametrize(
    ("initial", "final", "expected"),
    [
        (0, 0, ("Remains_Same", "Supportive")),
        (4, 3, ("Becomes_Easier", "Supportive")),
        (1, 5, ("Becomes_Difficult", "Not_Supportive")),
    ],
)
def test_eq_10_and_11(ability: str, initial: int, final: int, expected: tuple[str, str]) -> None:
    assert change(f"{ability}.effort", REACH_EFFORTS[initial], REACH_EFFORTS[final]) == expected


def test_efforts_to_see_compare_by_level() -> None:
    assert change("see.effort", "Head_Torso_Effort", "Head_Effort") == ("Becomes_Easier", "Supportive")
    assert EFFORT_LEVELS["Head_Torso_Effort"] == EFFORT_LEVELS["Arm_Torso_Effort"] == 2


@pytest.mark.parametrize(
    ("initial", "final", "expected"),
    [
        (0.010, 0.012, ("Almost_Same", "Supportive")),
        (0.010, 0.020, ("Increased", "Supportive")),
        (0.020, 0.010, ("Decreased", "Not_Supportive")),
        (0.0, 0.0, ("Almost_Same", "Supportive")),
        (0.0, 0.00000004, ("Almost_Same", "Supportive")),
        (0.0, 0.00009, ("Increased", "Supportive")),
        (0.0, 0.01, ("Increased", "Supportive")),
    ],
)
def test_eq_12_and_13(initial: float, final: float, expected: tuple[str, str]) -> None:
    assert change("visibility.score", initial, final) == expected


@SEEDED
@given(SCORES, SCORES)
def test_a_change_of_visibility_is_the_opposite_of_its_reversal(one: float, other: float) -> None:
    opposite = {"Almost_Same": "Almost_Same", "Increased": "Decreased", "Decreased": "Increased"}
    forth, back = change("visibility.score", one, other)[0], change("visibility.score", other, one)[0]
    assert back == opposite[str(forth)]


def test_eq_15() -> None:
    assert change("posture", "Sitting", "Sitting") == ("Maintained", None)
    assert change("posture", "Sitting", "Standing") == ("Changed", None)


FREE: dict[str, str | None] = {"left": "Free_of_Object", "right": "Free_of_Object"}


@pytest.mark.parametrize(
    ("initial", "final", "expected"),
    [
        (FREE, FREE, ("Manip_Avoided", "Manip_Not_Desired")),
        (FREE, {**FREE, "left": "Holding_Object"}, ("Manip_Gained", "Manip_Desired")),
        (FREE, {**FREE, "left": "Holding_Other_Object"}, ("Manip_Avoided", "Manip_Not_Desired")),
        ({**FREE, "right": "Holding_Object"}, FREE, ("Manip_Loss", "Manip_Not_Desired")),
        ({"right": "Holding_Object"}, {"right": "Holding_Object"}, ("Manip_Maintained", "Manip_Desired")),
        # From hand to hand the object stays in the agent's power.
        (
            {**FREE, "left": "Holding_Object"},
            {**FREE, "right": "Holding_Object"},
            ("Manip_Maintained", "Manip_Desired"),
        ),
        # An unknown hand leaves the comparison open, unless another surely holds the object.
        (FREE, {"left": None, "right": "Free_of_Object"}, (UNKNOWN, UNKNOWN)),
        (FREE, {"left": None, "right": "Holding_Object"}, ("Manip_Gained", "Manip_Desired")),
        ({"left": None, "right": "Holding_Object"}, FREE, ("Manip_Loss", "Manip_Not_Desired")),
    ],
)
def test_eq_17_and_18(initial: object, final: object, expected: tuple[object, object]) -> None:
    assert change("hands", initial, final) == expected


def test_eq_20_and_21() -> None:
    assert change("placement", "On_Support", "On_Support") == ("Maintaining(On_Support)", "Supportive(On_Support)")
    moved = ("Gaining(In_Hand) & Losing(On_Support)", "Supportive(In_Hand)")
    assert change("placement", "On_Support", "In_Hand") == moved


@pytest.mark.parametrize(
    ("initial", "final", "expected"),
    [
        ("Static", "Moving", "motion_gained"),
        ("Moving", "Static", "motion_lost"),
        ("Moving", "Moving", "motion_maintained"),
        ("Static", "Static", "motion_avoided"),
    ],
)
def test_eq_23(initial: str, final: str, expected: str) -> None:
    assert change("motion", initial, final) == (expected, None)


@pytest.mark.parametrize("attribute", ["reach.effort", "visibility.score", "posture", "hands", "placement", "motion"])
def test_what_follows_from_the_unknown_is_unknown(attribute: str) -> None:
    assert change(attribute, UNKNOWN, UNKNOWN) in ((UNKNOWN, UNKNOWN), (UNKNOWN, None))
