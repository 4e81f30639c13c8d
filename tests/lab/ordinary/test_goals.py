"""In ordinary rooms nearly all that an able adult gets at is possible, and nothing that nobody gets at."""

from __future__ import annotations

import pytest

from taskgist.perspective.effort import ABILITIES, Ability
from tests.lab.ordinary.judged import found

MISSED_MOST = 0.04


@pytest.mark.parametrize("ability", ABILITIES)
def test_what_an_able_adult_gets_at_is_possible(ability: Ability) -> None:
    assert found().missed(ability).of > 100
    assert found().missed(ability).share <= MISSED_MOST, found().reasons(ability)


@pytest.mark.parametrize("ability", ABILITIES)
def test_what_nobody_gets_at_is_not(ability: Ability) -> None:
    assert found().invented(ability).of > 20
    assert found().invented(ability).wrong == 0
