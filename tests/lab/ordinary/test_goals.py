"""In ordinary rooms nearly all that an able adult gets at is possible, and nothing that nobody gets at."""

from __future__ import annotations

import pytest

from taskgist.perspective.effort import ABILITIES, Ability
from taskgist_lab.evaluation.ordinary_rooms import RoomsFound, judged_rooms

ROOMS, SEED = 2, 14
MISSED_MOST = 0.04


@pytest.fixture(scope="module")
def found() -> RoomsFound:
    return judged_rooms(count=ROOMS, seed=SEED)


@pytest.mark.parametrize("ability", ABILITIES)
def test_what_an_able_adult_gets_at_is_possible(found: RoomsFound, ability: Ability) -> None:
    assert found.missed(ability).of > 100
    assert found.missed(ability).share <= MISSED_MOST, found.reasons(ability)


@pytest.mark.parametrize("ability", ABILITIES)
def test_what_nobody_gets_at_is_not(found: RoomsFound, ability: Ability) -> None:
    assert found.invented(ability).of > 20
    assert found.invented(ability).wrong == 0
