"""Goals of sets of values, and usual circumstances: a set will do where one of its values does."""

from __future__ import annotations

import pytest

from taskgist.facts import STANDARD_TREE, Observation, Raw
from taskgist.facts import vocabulary as v
from taskgist.facts.values import score_bins
from taskgist.learning import AnyLiteral, Clause, Literal, SetLiteral
from taskgist.learning.literals import vocabularies
from taskgist.planning import Goal, Span
from taskgist.planning.aims import Aim, goal_of_all
from taskgist.planning.wanted import Final
from taskgist.settings import DEFAULT
from tests.planning.test_goal import START, literal

VOCABULARIES = {each.node.name: each for each in vocabularies(STANDARD_TREE)}
LITERALS = {
    name: tuple(each.literals({*each.values} if len(each.values) < 12 else {*each.values[:3], *each.values[-2:]}))
    for name, each in VOCABULARIES.items()
}
"""All sets of each node; of scores, which have many bins, those that begin and end at some."""
STARTS: tuple[dict[str, Raw], ...] = (
    {},
    {
        "placement": "In_Hand",
        "visibility.score": 0.0,
        "see.effort": v.SEE_EFFORTS[4],
        "reach.effort": v.REACH_EFFORTS[0],
    },
    {"hands": {"left": v.HOLDING_OBJECT, "right": v.RESTING_ON_SUPPORT}, "posture": "Standing"},
)
SCORES = (0.0, *(0.9 * 2.0**-octave for octave in range(21)), 1.0)


def goal_of(*literals: AnyLiteral, usual: tuple[AnyLiteral, ...] = (), start: dict[str, Raw] | None = None) -> Goal:
    known = {name: Observation(raw) for name, raw in (dict(START) | (start or {})).items()}
    return Goal.of(Clause("test", literals, usual=usual), known, STANDARD_TREE)


def among(node: str, *values: str, but: bool = False) -> SetLiteral:
    found = STANDARD_TREE.node(node)
    return SetLiteral(found.name, found.title, values, but=but, instant=found.instant)


def accepted(goal: Goal) -> set[Final | float]:
    """The final values that will do, of a score those of ``SCORES``; none where nothing can be brought about."""
    found: set[Final | float] = {final for each in goal.wanted for final in each.values or ()}
    spans = {final for final in found if isinstance(final, Span)}
    return (found - spans) | {score for score in SCORES if any(score in span for span in spans)}


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("node", LITERALS)
def test_a_set_of_one_value_is_that_value(node: str, start: dict[str, Raw]) -> None:
    for each in LITERALS[node]:
        if each.value is None:
            continue
        one, other = goal_of(each, start=start), goal_of(literal(node, each.value), start=start)
        assert [wanted.truths for wanted in one.wanted] == [wanted.truths for wanted in other.wanted]
        assert [wanted.decisive_level for wanted in one.wanted] == [wanted.decisive_level for wanted in other.wanted]
        assert [(given.holds, given.found) for given in one.given] == [(told.holds, told.found) for told in other.given]
        assert [told.why for told in one.impossible] == [told.why for told in other.impossible]
        assert [told.why for told in one.unjudged] == [told.why for told in other.unjudged]


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("node", LITERALS)
def test_a_set_will_do_where_one_of_its_values_does(node: str, start: dict[str, Raw]) -> None:
    """Hands that differ have a value that nobody declares: it is among all but one, and no value by itself."""
    every = VOCABULARIES[node].values
    named = {value for each in LITERALS[node] for value in (every if each.but else each.values)}
    of = {value: accepted(goal_of(literal(node, value), start=start)) for value in named}
    for each in LITERALS[node]:
        meant = [value for value in every if (value in each.values) != each.but]
        union = set[Final | float]().union(*(of[value] for value in meant))
        found = accepted(goal_of(each, start=start))
        assert found == union or (node == "hands.status.2" and each.but and found > union), each


def test_an_interval_of_efforts_is_its_levels() -> None:
    (wanted,) = goal_of(among("see.effort.2", *v.SEE_EFFORTS[2:])).wanted
    assert (wanted.levels, wanted.decisive_level) == ((2, 3, 4, 5), 1)
    both = goal_of(among("see.effort.2", *v.SEE_EFFORTS[2:5]), literal("see.class", v.BECOMES_DIFFICULT))
    assert both.wanted[0].levels == (2, 3, 4)


def test_an_interval_of_scores_is_one_span_and_what_lies_beside_it_misses() -> None:
    bins = score_bins(DEFAULT.vision)
    (wanted,) = goal_of(among("visibility.score.2", *bins[3:9])).wanted
    low, high = wanted.spans[0].low, wanted.spans[-1].high
    assert all(before.high < after.low for before, after in zip(wanted.spans, wanted.spans[1:], strict=False))
    assert wanted.missed_by((low + high) / 2) == 0.0
    assert wanted.missed_by(high + 0.1) == pytest.approx(0.1)
    assert goal_of(among("visibility.score.2", *bins)).wanted[0].missed_by(1.0) == 0.0


def test_what_no_value_of_a_set_can_be_is_told() -> None:
    goal = goal_of(among("see.class", v.BECOMES_DIFFICULT), start={"see.effort": v.SEE_EFFORTS[5]})
    assert goal.impossible[0].why == "see is at level 5 already: it cannot become more difficult"
    goal = goal_of(among("see.class", v.BECOMES_DIFFICULT, but=True), literal("see.effort.2", v.SEE_EFFORTS[5]))
    assert "(Relative_Effort_Class_to_See ≠ Becomes_Difficult) and" in goal.impossible[0].why


# --- Usual circumstances.

HARDER = literal("see.class", v.BECOMES_DIFFICULT)
ON_SUPPORT, STATIC = literal("placement.status.2", v.ON_SUPPORT), literal("motion.status.2", v.STATIC)


def test_usual_circumstances_are_wanted_and_no_part_of_the_clause() -> None:
    goal = goal_of(HARDER, usual=(ON_SUPPORT, STATIC))
    assert goal.circumstances == (ON_SUPPORT, STATIC)
    assert {each.attribute: each.values for each in goal.wanted if each.attribute != "see.effort"} == {
        "placement": (v.ON_SUPPORT,),
        "motion": (v.STATIC,),
    }
    assert goal.controllable == (HARDER,)
    assert goal_of_all([Aim("P2", "cup", goal), Aim("P3", "cup", goal)]).circumstances == goal.circumstances


def test_what_the_start_or_the_clause_rules_out_is_dropped_alone() -> None:
    moving = literal("motion.status.2", v.MOVING)
    gets = literal("hands.class", v.MANIP_GAINED)
    empty = literal("hands.status.2", v.FREE_OF_OBJECT)
    goal = goal_of(gets, usual=(moving, empty, STATIC))
    assert [each.literal for each in goal.dropped] == [empty]
    assert "(Relative_Hand_Status = Manip_Gained) and (Final_Hand_Status = Free_of_Object)" in goal.dropped[0].why
    assert goal.circumstances == (STATIC,), "that it moves is up to whoever has it in hand"
    assert not goal.impossible
    lost = goal_of(HARDER, usual=(moving, ON_SUPPORT))
    assert [each.literal for each in lost.dropped] == [moving]
    assert lost.dropped[0].why == "what is performed ends at rest: (Object_Final_Motion_Status = Moving) cannot be"
    assert lost.circumstances == (ON_SUPPORT,)


def test_two_that_exclude_each_other_are_not_both_wanted() -> None:
    goal = goal_of(HARDER, usual=(ON_SUPPORT, literal("placement.status.2", v.INSIDE_CONTAINER)))
    assert goal.circumstances == (ON_SUPPORT,)
    assert len(goal.dropped) == 1


def test_what_is_not_up_to_the_performer_is_not_asked_for() -> None:
    stands = Literal("posture.value.2", "Final_Posture", "Standing", 2)
    goal = goal_of(HARDER, usual=(stands,))
    assert (goal.circumstances, goal.dropped, goal.given) == ((), (), ())
    assert goal.wanted == goal_of(HARDER).wanted
