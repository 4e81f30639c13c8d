"""In ordinary rooms nearly all that an able adult gets at is possible, and nothing that nobody gets at.

A mark stands on what is not so today; whoever mends it takes the mark away.
"""

from __future__ import annotations

import pytest

from taskgist.perspective.effort import Ability
from taskgist_lab.evaluation.ordinary_rooms import RoomsFound, judged_rooms

ROOMS, SEED = 3, 14
MISSED_MOST = 0.04
today = pytest.mark.xfail(reason="bodies cannot do yet what people can", raises=AssertionError)


@pytest.fixture(scope="module")
def found() -> RoomsFound:
    return judged_rooms(count=ROOMS, seed=SEED)


@pytest.mark.parametrize(
    "ability",
    ["see", pytest.param("reach", marks=today), pytest.param("grasp", marks=today)],
)
def test_what_an_able_adult_gets_at_is_possible(found: RoomsFound, ability: Ability) -> None:
    assert found.missed(ability).of > 100
    assert found.missed(ability).share <= MISSED_MOST, found.reasons(ability)


@pytest.mark.parametrize("ability", ["see", pytest.param("reach", marks=today), pytest.param("grasp", marks=today)])
def test_what_nobody_gets_at_is_not(found: RoomsFound, ability: Ability) -> None:
    assert found.invented(ability).of > 20
    assert found.invented(ability).wrong == 0
