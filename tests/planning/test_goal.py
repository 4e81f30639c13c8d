"""Clauses turned round: which final values will do, from every start, for every value of the tree."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

import numpy as np
import pytest

from taskgist.facts import (
    NEGLIGIBLE,
    NO_ACTION,
    REACH_EFFORTS,
    SEE_EFFORTS,
    STANDARD_TREE,
    UNKNOWN,
    HypothesisTree,
    Node,
    Observation,
    Raw,
    predicate_subtree,
    score_bin,
)
from taskgist.facts import vocabulary as v
from taskgist.learning import AnyLiteral, Clause, Literal, clause_of, understand
from taskgist.perspective.effort import NO_KNOWN_ACTION
from taskgist.planning import Goal, Span, Wanted
from taskgist.planning.aims import Aim, goal_of_all
from taskgist.settings import DEFAULT
from tests.learning.learning_samples import STUDY, study

FREE, RESTS, HOLDS, OTHER = "Free_of_Object", "Resting_on_Support", "Holding_Object", "Holding_Other_Object"
START: Mapping[str, Raw] = {
    "posture": "Sitting",
    "hands": {"left": FREE, "right": FREE},
    "placement": "On_Support",
    "motion": "Static",
    "visibility.score": 0.01,
    **{f"{each}.effort": REACH_EFFORTS[2] for each in ("reach", "grasp")},
    "see.effort": SEE_EFFORTS[1],
    **{f"{each}.{part}": f"some {part}" for each in ("reach", "grasp", "see") for part in ("state", "action")},
}
ABILITIES = {"reach": REACH_EFFORTS, "grasp": REACH_EFFORTS, "see": SEE_EFFORTS}


def literal(node: str, value: str, tree: HypothesisTree = STANDARD_TREE) -> Literal:
    found = tree.node(node)
    return Literal(node, found.title, value, found.instant)


def goal_of(
    *literals: AnyLiteral | tuple[str, str],
    tree: HypothesisTree = STANDARD_TREE,
    without: str = "",
    start: Mapping[str, Raw] | None = None,
    **changes: Raw,
) -> Goal:
    """The goal of some literals; the start differs by what is named, with ``__`` for the dot."""
    values = dict(START) | dict(start or {}) | {name.replace("__", "."): raw for name, raw in changes.items()}
    values.pop(without, None)
    clause = Clause("test", tuple(literal(*each, tree) if isinstance(each, tuple) else each for each in literals))
    return Goal.of(clause, {name: Observation(raw) for name, raw in values.items()}, tree)


def kinds(goal: Goal) -> tuple[int, int, int, int]:
    return len(goal.given), len(goal.wanted), len(goal.impossible), len(goal.unjudged)


def only(goal: Goal) -> Wanted:
    (wanted,) = goal.wanted
    return wanted


# --- Every value of every node of the tree, from every start: against the equations, said once more by hand.

EFFORT_CLASS: Mapping[str, Callable[[int, int], bool]] = {
    v.BECOMES_EASIER: lambda before, after: after < before,
    v.REMAINS_SAME: lambda before, after: after == before,
    v.BECOMES_DIFFICULT: lambda before, after: after > before,
    v.SUPPORTIVE: lambda before, after: after <= before,
    v.NOT_SUPPORTIVE: lambda before, after: after > before,
}


def effort_cases() -> Iterator[tuple[Node, str, int]]:
    for node in STANDARD_TREE.nodes:
        if node.name.split(".")[0] in ABILITIES and node.instant != 1:
            yield from ((node, value, before) for value in node.values for before in range(6))


@pytest.mark.parametrize(("node", "value", "before"), list(effort_cases()))
def test_efforts(node: Node, value: str, before: int) -> None:
    ability = node.name.split(".")[0]
    ladder = ABILITIES[ability]
    goal = goal_of((node.name, value), start={f"{ability}.effort": ladder[before]})
    expected = tuple(
        after
        for after in range(6)
        if (ladder[after] == value if node.instant == 2 else EFFORT_CLASS[value](before, after))
    )
    if expected:
        assert kinds(goal) == (0, 1, 0, 0)
        assert only(goal).levels == expected
        assert only(goal).values == tuple(ladder[level] for level in expected)
    else:
        assert kinds(goal) == (0, 0, 1, 0)
        assert f"{ability} is at level {before} already" in goal.impossible[0].why


@pytest.mark.parametrize("before", v.PLACEMENTS)
@pytest.mark.parametrize(
    ("node", "value"),
    [
        (node, value)
        for node in STANDARD_TREE.nodes
        if node.name.startswith("placement") and node.instant != 1
        for value in node.values
    ],
)
def test_placements(node: Node, value: str, before: str) -> None:
    goal = goal_of((node.name, value), placement=before)

    def text(after: str) -> str:
        if node.name == "placement.class":
            return f"Maintaining({after})" if after == before else f"Gaining({after}) & Losing({before})"
        return after if node.instant == 2 else f"Supportive({after})"

    expected = tuple(after for after in v.PLACEMENTS if text(after) == value)
    assert kinds(goal) == ((0, 1, 0, 0) if expected else (0, 0, 1, 0))
    assert expected == (only(goal).values if expected else ())


@pytest.mark.parametrize("node", [node for node in STANDARD_TREE.nodes if node.name.startswith("motion")])
@pytest.mark.parametrize("before", v.MOTIONS)
def test_what_is_performed_ends_at_rest(node: Node, before: str) -> None:
    for value in node.values:
        goal = goal_of((node.name, value), motion=before)
        if node.instant == 1:
            assert [each.holds for each in goal.given] == [value == before]
        elif value in ("Static", "motion_avoided" if before == "Static" else "motion_lost"):
            assert only(goal).values == ("Static",)
        else:
            assert "ends at rest" in goal.impossible[0].why


def test_whether_the_thing_moves_in_anothers_hand_is_up_to_that_one() -> None:
    """Handovers of people end in motion, and a robot that hands something over does all that it can."""
    moving, given = ("motion.status.2", v.MOVING), ("hands.class", v.MANIP_GAINED)
    assert kinds(goal_of(moving)) == (0, 0, 1, 0)
    goal = goal_of(moving, given)
    assert kinds(goal) == (1, 1, 0, 0)
    assert (goal.given[0].holds, goal.given[0].found) == (False, v.STATIC)
    assert kinds(goal_of(moving, ("hands.class", v.MANIP_AVOIDED))) == (0, 1, 1, 0)


@pytest.mark.parametrize("node", [node for node in STANDARD_TREE.nodes if node.name.startswith("posture")])
@pytest.mark.parametrize("before", v.POSTURES)
def test_postures_are_given(node: Node, before: str) -> None:
    for value in node.values:
        goal = goal_of((node.name, value), posture=before)
        assert kinds(goal) == (1, 0, 0, 0)
        assert goal.given[0].holds is (value in (before, "Maintained"))
        assert goal.given[0].found == ("Maintained" if node.name == "posture.class" else before)


def test_initial_literals_are_given_with_their_truth() -> None:
    for node in STANDARD_TREE.nodes:
        for value in node.values if node.instant == 1 else ():
            goal = goal_of((node.name, value))
            assert kinds(goal) == (1, 0, 0, 0)
            assert goal.given[0].holds is (goal.given[0].found == value)


HANDS_CLASS = {
    v.MANIP_GAINED: (False, True),
    v.MANIP_LOSS: (True, False),
    v.MANIP_MAINTAINED: (True, True),
    v.MANIP_AVOIDED: (False, False),
}


CHANGES = {
    **{("hands.class", value): [change] for value, change in HANDS_CLASS.items()},
    ("hands.nature", v.MANIP_DESIRED): [(False, True), (True, True)],
    ("hands.nature", v.MANIP_NOT_DESIRED): [(True, False), (False, False)],
}
"""Whether the thing is in a hand before and after, by node and value (Eq. 17, 18)."""
ENDS = {FREE: (FREE, HOLDS), RESTS: (RESTS, HOLDS), HOLDS: (HOLDS, FREE), OTHER: (OTHER,)}
"""What a performer can make of a hand."""


@pytest.mark.parametrize(("left", "right"), list(itertools.product(v.HAND_STATUSES, repeat=2)))
def test_changes_of_hands(left: str, right: str) -> None:
    before = HOLDS in (left, right)
    for (node, value), changes in CHANGES.items():
        goal = goal_of((node, value), hands={"left": left, "right": right})
        expected = [pair for pair in itertools.product(ENDS[left], ENDS[right]) if (before, HOLDS in pair) in changes]
        if expected:
            assert kinds(goal) == (0, 1, 0, 0)
            assert finals_of_hands(goal) == set(expected)
        elif any(was == before for was, _ in changes):  # the agent itself would have to do something
            assert [each.holds for each in goal.given] == [False]
        else:
            assert kinds(goal) == (0, 0, 1, 0)


@pytest.mark.parametrize(("left", "right"), list(itertools.product(v.HAND_STATUSES, repeat=2)))
def test_final_statuses_of_hands(left: str, right: str) -> None:
    for status in v.HAND_STATUSES:
        goal = goal_of(("hands.status.2", status), hands={"left": left, "right": right})
        if status in ENDS[left] and status in ENDS[right]:
            assert finals_of_hands(goal) == {(status, status)}
        else:
            assert [each.holds for each in goal.given] == [False]
            assert goal.given[0].found == (left if left == right else f"left: {left}, right: {right}")


def finals_of_hands(goal: Goal) -> set[tuple[object, object]]:
    return {(each["left"], each["right"]) for each in only(goal).values or () if isinstance(each, Mapping)}


# --- Scores: spans, against the forward functions at random scores.


VISIBILITY = STANDARD_TREE.without(subtrees=[each.name for each in STANDARD_TREE.subtrees if each.name != "visibility"])


@pytest.mark.parametrize("before", [0.0, 3e-8, 1e-6, 0.01, 0.3, 0.9, 1.0])
def test_scores_in_the_spans_are_those_that_hold(before: float) -> None:
    rng = np.random.default_rng(round(before * 1e9))
    vision = DEFAULT.vision
    scores = [0.0, 1.0, *(2.0 ** rng.uniform(math.log2(vision.negligible_score) - 1, 0.0, 60)), *rng.uniform(0, 1, 20)]
    values = {
        "visibility.class": v.SCORE_CLASSES,
        "visibility.nature": v.NATURES,
        "visibility.score.2": tuple(dict.fromkeys(score_bin(score, vision) for score in scores)),
    }
    for node, value in ((node, value) for node, each in values.items() for value in each):
        goal = goal_of((node, value), visibility__score=before)
        spans = goal.wanted[0].spans if goal.wanted else ()
        for score in [*scores, *(edge for span in spans for edge in (span.low, span.high))]:
            start, end = ({"visibility.score": Observation(each)} for each in (before, score))
            holds = VISIBILITY.instantiate(start, end)[node].value == value
            assert any(score in span for span in spans) is holds
        assert bool(goal.impossible) is not bool(spans)


def test_spans_end_where_the_literal_does() -> None:
    wanted = only(goal_of(("visibility.class", v.INCREASED), ("visibility.score.2", score_bin(0.013, DEFAULT.vision))))
    (span,) = wanted.spans
    assert span.low == pytest.approx(0.01 / (1 - DEFAULT.vision.change_tolerance))
    assert score_bin(span.high, DEFAULT.vision) != score_bin(math.nextafter(span.high, 1.0), DEFAULT.vision)
    assert wanted.missed_by(span.low - 0.001) == pytest.approx(0.001)
    assert wanted.missed_by((span.low + span.high) / 2) == 0.0


def test_negligible_is_from_nothing_to_the_first_bin() -> None:
    (span,) = only(goal_of(("visibility.score.2", NEGLIGIBLE))).spans
    assert span == Span(0.0, math.nextafter(DEFAULT.vision.negligible_score, 0.0))


# --- Actions, and what else is no matter of a list.


@pytest.mark.parametrize("ability", ABILITIES)
def test_actions_say_their_level_at_the_ends_of_the_ladder(ability: str) -> None:
    action = f"{ability}.action.2"
    assert only(goal_of((action, NO_ACTION))).levels == (0,)
    assert only(goal_of((action, NO_ACTION))).decisive_level == 0
    assert only(goal_of((action, NO_KNOWN_ACTION))).levels == (5,)
    between = only(goal_of((action, "Pan_Head + Turn_Torso")))
    assert between.levels == (1, 2, 3, 4)
    assert between.truths_of(ABILITIES[ability][1]) == (UNKNOWN,)


def test_states_leave_all_levels_open() -> None:
    wanted = only(goal_of(("see.state.2", "sitting")))
    assert wanted.levels == (0, 1, 2, 3, 4, 5)
    assert wanted.decisive_level == -1


def test_levels_that_matter() -> None:
    def decisive(*literals: tuple[str, str]) -> int | None:
        return only(goal_of(*literals)).decisive_level

    assert decisive(("reach.class", v.BECOMES_EASIER)) == 1
    assert decisive(("reach.class", v.REMAINS_SAME)) == 2
    assert decisive(("reach.class", v.BECOMES_DIFFICULT)) == 2
    assert decisive(("reach.effort.2", REACH_EFFORTS[4])) == 4
    assert decisive(("reach.effort.2", REACH_EFFORTS[5])) == 4
    assert decisive(("placement.status.2", "In_Hand")) is None
    assert only(goal_of(("reach.class", v.BECOMES_DIFFICULT))).missed_by(REACH_EFFORTS[1]) == 2.0


def test_literals_that_exclude_each_other_are_told_together() -> None:
    goal = goal_of(("see.class", v.BECOMES_EASIER), ("see.effort.2", SEE_EFFORTS[4]))
    assert kinds(goal) == (0, 0, 1, 0)
    assert len(goal.impossible[0].literals) == 2


def test_one_impossible_literal_leaves_the_others_wanted() -> None:
    goal = goal_of(("see.class", v.BECOMES_EASIER), ("see.effort.2", SEE_EFFORTS[4]), see__effort="No_Effort_Required")
    assert only(goal).levels == (4,)
    assert goal.impossible[0].why == "see is at level 0 already: it cannot become easier"


def test_what_was_unknown_at_the_start_is_told() -> None:
    classes = goal_of(("see.class", v.REMAINS_SAME), ("visibility.class", v.INCREASED), see__effort=UNKNOWN)
    assert [each.literal.node for each in classes.unjudged] == ["see.class"]
    assert "not known" in classes.unjudged[0].why
    assert only(goal_of(("see.effort.2", SEE_EFFORTS[0]), see__effort=UNKNOWN)).levels == (0,)
    assert goal_of(("posture.class", "Maintained"), posture=UNKNOWN).given[0].holds is UNKNOWN
    hands = goal_of(("hands.class", v.MANIP_GAINED), hands={"left": None, "right": FREE})
    assert kinds(hands) == (0, 0, 0, 1)
    lost = goal_of(("hands.class", v.MANIP_GAINED), ("hands.status.2", HOLDS), hands=UNKNOWN)
    assert [each.literal.node for each in lost.unjudged] == ["hands.class"]
    assert only(lost).truths_of({"left": HOLDS, "right": HOLDS}) == (True,)


def test_what_nobody_observes_or_no_tree_has_is_told() -> None:
    assert "nobody observes" in goal_of(("placement.status.2", "In_Hand"), without="placement").unjudged[0].why
    strange = Literal("on_box.class", "Relative_On_Box", "Maintaining(True)", None)
    assert goal_of(strange).unjudged[0].why == "the tree has no node on_box.class"


def test_a_predicate_of_ones_own_is_turned_round_as_well() -> None:
    tree = STANDARD_TREE.extended(predicate_subtree("on_box"), predicate_subtree("near", ("near", "far")))
    goal = goal_of(
        ("on_box.class", "Gaining(True) & Losing(False)"), ("near.value.2", "far"), tree=tree, on_box=False, near="near"
    )
    assert {each.attribute: each.values for each in goal.wanted} == {"on_box": ("True",), "near": ("far",)}
    already = goal_of(("on_box.class", "Gaining(True) & Losing(False)"), tree=tree, on_box=True, near="near")
    assert "on_box is True already" in already.impossible[0].why


def test_smaller_trees_do() -> None:
    tree = STANDARD_TREE.without(levels=["action", "nature"])
    assert only(goal_of(("see.class", v.BECOMES_DIFFICULT), tree=tree)).levels == (2, 3, 4, 5)


# --- Learned clauses.


@pytest.mark.parametrize("task", STUDY)
def test_each_literal_of_a_learned_clause_has_one_fate(task: str) -> None:
    clause = clause_of(understand(study(task)))
    goal = goal_of(*clause.literals)
    told = [
        *(each.literal for each in goal.given),
        *(one for each in goal.wanted for one in each.literals),
        *(one for each in goal.impossible for one in each.literals),
        *(each.literal for each in goal.unjudged),
    ]
    assert sorted(map(str, told)) == sorted(map(str, clause.literals))
    order = ["placement", "motion", "hands", "visibility.score", "see.effort", "reach.effort", "grasp.effort"]
    places = [order.index(each.attribute) for each in goal.wanted]
    assert places == sorted(places)


def test_hide_as_it_was_learned() -> None:
    goal = goal_of(*clause_of(understand(study("hide"))).literals)
    wanted = {each.attribute: each for each in goal.wanted}
    assert wanted["placement"].values == ("On_Support",)
    assert wanted["see.effort"].levels == (2, 3, 4, 5)
    assert wanted["visibility.score"].spans[0].low == 0.0
    assert all(each.holds is True for each in goal.given)
    assert not goal.impossible
    assert not goal.unjudged


# --- Several.


def test_what_is_wanted_of_any_is_wanted_of_all() -> None:
    """What the first sees at the start is not known, and so not judged; of the other it is wanted."""
    harder = ("see.class", v.BECOMES_DIFFICULT)
    first, second = goal_of(harder, see__effort=UNKNOWN), goal_of(harder)
    assert (kinds(first), kinds(second)) == ((0, 0, 0, 1), (0, 1, 0, 0))
    both = goal_of_all([Aim("P2", "cup", first), Aim("P3", "cup", second)])
    assert kinds(both) == (0, 1, 0, 1)
    assert both == replace(second, unjudged=first.unjudged)
    same = goal_of_all([Aim("P2", "cup", second), Aim("P2", "pen", second)])
    assert same == second
    impossible = goal_of(harder, see__effort=SEE_EFFORTS[5])
    assert goal_of_all([Aim("P2", "cup", second), Aim("P2", "pen", impossible)]).impossible == impossible.impossible


def test_a_thing_is_in_one_hand_and_two_things_in_two() -> None:
    taken = goal_of(("hands.class", v.MANIP_GAINED))
    one = goal_of_all([Aim("P2", "cup", taken), Aim("P3", "cup", taken)])
    assert [each.why for each in one.impossible] == ["the cup cannot be in the hands of P2 and of P3 at once"]
    assert not goal_of_all([Aim("P2", "cup", taken), Aim("P2", "pen", taken)]).impossible
