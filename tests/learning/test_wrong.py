"""Demonstrations that were done wrong: never counted for the task, kept apart, and what is learned from them."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations

import pytest
from hypothesis import given, settings

from taskgist.errors import KnowledgeError, UnknownNameError
from taskgist.facts import STANDARD_TREE, UNKNOWN
from taskgist.learning import Context, Experience, Explanation, Knowledge, explanation_from_json, learn_task, merged
from taskgist.learning.evidence import effects_of
from taskgist.learning.literals import SetLiteral, vocabularies
from taskgist.learning.must_not import learn_must_not
from taskgist.learning.understanding import understand
from tests.learning.learning_samples import FREE, LEFT_GETS, STUDY, Told, explained, explanations

SEEN = Told("21", "10", "lh")
"""What was to be hidden is seen all the better."""
GRABBED = Told("21", "03", "l0", ends="In_Hand", hands=(FREE, LEFT_GETS))
"""It is hidden; the other has got it."""
RIGHT = [explained("hide", number, told) for number, told in enumerate([*STUDY["hide"]] * 3)]


VOCABULARY = {each.node.name: each for each in vocabularies(STANDARD_TREE)}


def complement(literal: SetLiteral) -> SetLiteral:
    return VOCABULARY[literal.node].complement(literal)


def wrong(number: int, told: Told) -> Explanation:
    return explained("hide", 100 + number, told).marked_wrong()


def test_a_wrong_demonstration_is_another_explanation_that_is_kept_as_such() -> None:
    right = explained("hide", 1, SEEN)
    marked = right.marked_wrong()
    assert marked.wrong
    assert marked.digest != right.digest
    assert explanation_from_json(marked.to_json()) == marked
    assert "wrong" not in right.to_json(), "as those of earlier releases are kept"
    both = replace(right, target_agents=("P3",))
    whole = merged([right, both])
    assert whole.marked_wrong() == merged([right.marked_wrong(), both.marked_wrong()])
    with pytest.raises(KnowledgeError, match="another demonstration"):
        merged([right, both.marked_wrong()])
    with pytest.raises(KnowledgeError, match="true or false"):
        explanation_from_json({**marked.to_json(), "wrong": "yes"})


def test_the_papers_rule_counts_none_of_them() -> None:
    known = Knowledge().add(*RIGHT)
    more = known.add(wrong(1, SEEN), wrong(2, GRABBED))
    assert more.understand("hide") == known.understand("hide")
    assert more.tasks == known.tasks
    assert len(more.explanations) == len(RIGHT) + 2
    with pytest.raises(KnowledgeError, match="done wrong"):
        Experience.of("hide", RIGHT).add(wrong(1, SEEN))
    with pytest.raises(KnowledgeError, match="done wrong"):
        understand(more.wrong["hide", "target"])


def test_merging_takes_them_along_in_any_order_and_removing_takes_them_away() -> None:
    parts = [Knowledge().add(*RIGHT[:4]), Knowledge().add(wrong(1, SEEN)), Knowledge().add(*RIGHT[2:], wrong(1, SEEN))]
    found = {a.merge(b).merge(c).explanations for a, b, c in permutations(parts)}
    (whole,) = {frozenset(each) for each in found}
    assert len(whole) == len(RIGHT) + 1
    known = Knowledge().add(*RIGHT, wrong(1, SEEN))
    assert known.remove("hide", wrong(1, SEEN).digest) == Knowledge().add(*RIGHT)
    with pytest.raises(UnknownNameError):
        known.remove("hide", "0123")


def test_a_recording_is_not_both_right_and_wrong_but_may_be_right_for_another_task() -> None:
    right = explained("hide", 1, SEEN)
    assert right.is_rival_of(right.marked_wrong())
    assert right.marked_wrong().is_rival_of(right)
    shown = replace(right, task="show")
    assert shown.is_rival_of(right)
    assert not shown.is_rival_of(right.marked_wrong())
    assert not shown.marked_wrong().is_rival_of(right.marked_wrong())


def test_wrong_ones_of_other_settings_do_not_stand_beside_right_ones() -> None:
    other = replace(wrong(1, SEEN), context=Context("other", "tree"))
    for first, second in ((RIGHT[0], other), (other, RIGHT[0])):
        with pytest.raises(KnowledgeError, match="different contexts"):
            Knowledge().add(first).add(second)
    assert Knowledge().add(RIGHT[0]).add(other, allow_mixed=True).wrong


def test_who_knows_wrong_ones_alone_is_told_so() -> None:
    known = Knowledge().add(wrong(1, SEEN))
    assert known.tasks == ()
    with pytest.raises(KnowledgeError, match=r"wrong alone.*show how it is done right"):
        known.experience("hide")


def test_what_must_not_hold_is_learned_from_one_with_odds_that_grow() -> None:
    sure = []
    for count in (1, 2, 3):
        known = Knowledge().add(*RIGHT, *(wrong(number, SEEN) for number in range(count)))
        reasons = learn_task(known, "hide").must_not
        first = reasons[0]
        assert first.in_wrong == (count, count)
        assert first.in_right == (0, 9)
        assert all(reasons[0].odds >= each.odds for each in reasons)  # type: ignore[operator]
        assert {each.literal.node.partition(".")[0] for each in reasons} >= {"see", "visibility"}
        assert first.odds is not None
        sure.append(first.odds)
        for each in (reason.literal for reason in reasons):
            assert all(each.holds(one.nodes) is not True for one in RIGHT)
            assert all(complement(each).holds(one.nodes) is not each.holds(one.nodes) for one in RIGHT)
            assert complement(complement(each)) == each
    assert 1 < sure[0] < 10 < sure[1] < 100 < sure[2]


def test_an_undesired_effect_beside_the_meaning_is_found_though_it_is_usual_elsewhere() -> None:
    known = Knowledge().add(*RIGHT, *(wrong(number, GRABBED) for number in range(3)))
    assert "In_Hand" not in str(learn_task(known, "hide").best)
    reasons = {each.literal.node.partition(".")[0] for each in learn_task(known, "hide").must_not}
    assert reasons <= {"hands", "placement"}
    assert reasons


def test_two_mistakes_are_two_reasons() -> None:
    mistakes = [wrong(number, SEEN) for number in range(5)] + [wrong(9, GRABBED), wrong(8, GRABBED)]
    reasons = learn_task(Knowledge().add(*RIGHT, *mistakes), "hide").must_not
    assert {each.literal.node.partition(".")[0] for each in reasons} >= {"see", "hands"}


def test_nothing_must_not_be_where_wrong_ones_do_not_differ_or_there_is_nothing_to_compare_with() -> None:
    assert learn_must_not(map(effects_of, RIGHT), map(effects_of, RIGHT)) == ()
    assert learn_must_not([], map(effects_of, RIGHT)) == learn_must_not(map(effects_of, RIGHT), []) == ()
    assert learn_task(Knowledge().add(*RIGHT), "hide").must_not == ()


@settings(max_examples=20, deadline=None)
@given(explanations("hide", 4), explanations("hide", 4))
def test_the_order_of_demonstrations_does_not_matter(right: list[Explanation], bad: list[Explanation]) -> None:
    found = learn_must_not(map(effects_of, bad), map(effects_of, right))
    assert learn_must_not(map(effects_of, reversed(bad)), map(effects_of, reversed(right))) == found
    for each in found:
        known = [truth for one in right if (truth := each.literal.holds(one.nodes)) is not UNKNOWN]
        assert each.in_right == (sum(map(bool, known)), len(known))
        assert sum(map(bool, known)) <= 0.1 * len(known)
