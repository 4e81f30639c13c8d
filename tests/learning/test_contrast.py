"""What tells one task from another: which literals decide, how much each says, and what does not."""

from __future__ import annotations

import math

import pytest

from taskgist.errors import KnowledgeError, UnknownNameError
from taskgist.facts import UNKNOWN, Observation
from taskgist.learning import Knowledge, contrast_of
from tests.learning.learning_samples import STUDY, Told, explained, study

BOTH = Knowledge().add(*(each for task in STUDY for each in study(task).explanations.values()))


def test_a_hide_is_told_from_a_put_away_by_what_is_seen() -> None:
    found = contrast_of(BOTH, "hide", "put away")
    assert (found.first, found.second) == ("hide", "put away")
    best = found.literals[0]
    assert str(best.literal) == "(Nature_Effort_Class_to_See = Not_Supportive)"
    assert (best.first, best.second) == ((3, 3), (0, 4))
    assert best.weight(True) == pytest.approx(math.log((3.5 / 4) / (0.5 / 5)))
    assert best.weight(False) == pytest.approx(math.log((0.5 / 4) / (4.5 / 5)))
    assert best.weight(UNKNOWN) == 0.0


def test_the_best_comes_first_and_no_subtree_comes_twice() -> None:
    for first in STUDY:
        for second in set(STUDY) - {first}:
            literals = contrast_of(BOTH, first, second).literals
            decides = [each.decides for each in literals]
            assert decides == sorted(decides, reverse=True)
            subtrees = [each.literal.node.partition(".")[0] for each in literals]
            assert len(set(subtrees)) == len(subtrees)


def test_what_holds_in_the_very_same_demonstrations_is_told_once() -> None:
    told = [each.literal.node.partition(".")[0] for each in contrast_of(BOTH, "hide", "hide away").literals]
    assert len({"reach", "grasp"} & set(told)) == 1  # grasping is as hard as reaching in all of them


def test_turning_it_round_turns_the_weights_round() -> None:
    there, back = contrast_of(BOTH, "show", "give"), contrast_of(BOTH, "give", "show")
    for nodes in (each.nodes for each in BOTH.explanations):
        total = [math.fsum(one.weight for one in found.weigh(nodes)) for found in (there, back)]
        assert total[0] == pytest.approx(-total[1])


def test_each_task_is_on_its_own_side() -> None:
    for first in STUDY:
        for second in set(STUDY) - {first, "hide" if first == "hide away" else ""}:
            found = contrast_of(BOTH, first, second)
            mean = {
                task: sum(
                    math.fsum(one.weight for one in found.weigh(each.nodes))
                    for each in study(task).explanations.values()
                )
                for task in (first, second)
            }
            assert mean[first] > 0 > mean[second]


def test_what_is_unknown_says_nothing() -> None:
    found = contrast_of(BOTH, "hide", "put away")
    weighed = found.weigh({each.literal.node: Observation(UNKNOWN) for each in found.literals})
    assert [(each.holds, each.weight) for each in weighed] == [(UNKNOWN, 0.0)] * len(found.literals)


def test_tasks_whose_demonstrations_do_not_differ_have_no_contrast() -> None:
    told = Told("21", "03", "l0")
    same = Knowledge().add(*(explained(task, n, told) for task in ("hide", "conceal") for n in range(3)))
    assert contrast_of(same, "hide", "conceal").literals == ()


def test_order_of_demonstrations_does_not_matter() -> None:
    turned = Knowledge()
    for task in reversed(STUDY):
        turned = turned.add(*reversed(list(study(task).explanations.values())))
    assert contrast_of(turned, "show", "make accessible") == contrast_of(BOTH, "show", "make accessible")


def test_misuse_says_what_to_do() -> None:
    with pytest.raises(KnowledgeError, match=r"no contrast with itself.*known: give, hide"):
        contrast_of(BOTH, "hide", "hide")
    with pytest.raises(UnknownNameError, match="did you mean 'hide'"):
        contrast_of(BOTH, "give", "hid")
