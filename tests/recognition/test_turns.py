"""Who has a thing when, and when it changes hands: laws of turns, whatever hands do."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskgist.recognition import Change, Turn, changes_of_hands, turns_of
from tests.recognition.told import Held, Told

WORLD = Told().scene


def turns(*held: Held, **told: Any) -> tuple[Turn, ...]:
    return turns_of(Told(held, scene=WORLD, **told).observer(), "cup")


def changes(*held: Held, **told: Any) -> tuple[Change, ...]:
    observer = Told(held, scene=WORLD, **told).observer()
    return changes_of_hands(observer, "cup", turns_of(observer, "cup"))


def test_it_changes_hands_in_the_middle_of_the_time_in_which_both_have_it() -> None:
    (change,) = changes(("P1", 1.0, 3.0), ("P2", 2.4, 5.0))
    assert (change.giver, change.taker, change.kept_s) == ("P1", "P2", 5.0)
    assert change.time_s == pytest.approx(2.7)


def test_where_nobody_is_seen_to_have_it_for_a_while_it_changes_hands_when_it_is_seen_again() -> None:
    (change,) = changes(("P1", 1.0, 3.0), ("P2", 3.4, 5.0), unknown=[(3.0, 3.4)])
    assert change.time_s == 3.4


def test_what_is_thrown_changes_hands_and_what_is_put_down_does_not() -> None:
    assert len(changes(("P1", 1.0, 3.0), ("P2", 3.4, 5.0), air=[(3.0, 3.4)])) == 1
    assert changes(("P1", 1.0, 3.0), ("P2", 3.4, 5.0)) == ()


def test_who_only_helps_has_no_turn() -> None:
    """A hand beside that of another all along; a hand that steadies it between two grips of another."""
    assert turns(("P1", 1.0, 5.0), ("P2", 2.0, 3.0)) == (Turn("P1", 1.0, 5.0),)
    assert turns(("P1", 1.0, 2.0), ("P2", 2.0, 2.3), ("P1", 2.3, 5.0)) == (Turn("P1", 1.0, 5.0),)
    assert len(changes(("P1", 1.0, 2.0), ("P2", 2.0, 2.3), ("P1", 2.3, 4.0), ("P2", 3.9, 6.0))) == 1


def test_who_lifts_it_together_gives_nothing() -> None:
    assert changes(("P1", 1.0, 3.0), ("P2", 1.0, 3.0)) == ()


def test_who_has_it_for_longer_in_between_gives_it_back() -> None:
    found = changes(("P1", 1.0, 2.0), ("P2", 2.0, 3.0), ("P1", 3.0, 5.0))
    assert [(each.giver, each.taker) for each in found] == [("P1", "P2"), ("P2", "P1")]


def test_a_turn_lasts_while_it_is_unknown_who_has_it() -> None:
    assert turns(("P1", 1.0, 2.0), ("P1", 2.5, 3.0), unknown=[(2.0, 2.5)]) == (Turn("P1", 1.0, 3.0),)
    assert turns(("P1", 1.0, 2.0), ("P1", 2.5, 3.0)) == (Turn("P1", 1.0, 2.0), Turn("P1", 2.5, 3.0)), "it rested"


HELD = st.tuples(st.sampled_from(["P1", "P2"]), st.integers(0, 80), st.integers(1, 20)).map(
    lambda held: (held[0], held[1] / 10, (held[1] + held[2]) / 10)
)


@settings(max_examples=200, deadline=None)
@given(st.lists(HELD, max_size=6))
def test_turns_begin_and_end_one_after_the_other(held: list[Held]) -> None:
    found = turns(*held)
    assert [turn.start_s for turn in found] == sorted(turn.start_s for turn in found)
    assert bool(found) == bool(held)
    for turn in found:
        grips = [each for each in held if each[0] == turn.agent]
        assert min(start for _, start, _ in grips) <= turn.start_s < turn.end_s <= max(end for *_, end in grips)


@settings(max_examples=100, deadline=None)
@given(st.lists(HELD, max_size=6, unique_by=lambda held: held[1]))
def test_names_do_not_matter(held: list[Held]) -> None:
    """Unless two take it in the very same moment."""
    other = {"P1": "P2", "P2": "P1"}
    renamed = turns(*((other[who], start, end) for who, start, end in held))
    assert {(other[turn.agent], turn.start_s, turn.end_s) for turn in renamed} == {
        (turn.agent, turn.start_s, turn.end_s) for turn in turns(*held)
    }
