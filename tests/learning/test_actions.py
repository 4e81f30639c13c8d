"""What is done in a task: kept with explanations, apart from what the task means, and learned by the same learner."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations

import pytest

from taskgist.errors import KnowledgeError
from taskgist.learning import Explanation, Knowledge, SymbolicAction, explanation_from_json, learn_task, merged
from taskgist.learning.actions import learn_actions
from tests.learning.learning_samples import STUDY, explained

MOVED = ("reach by performer", "grasp by performer", "lift by performer", "carry by performer")
PUT = (*MOVED, "place by performer", "release by performer")
GIVEN = (*MOVED, "grasp by target", "hand over by performer to target", "release by performer")


def acted(task: str, index: int, *names: str) -> Explanation:
    """A demonstration in which these were done, one after the other."""
    actions = []
    for time_s, name in enumerate(names):
        kind, _, who = name.partition(" by ")
        by, _, to = who.partition(" to ")
        actions.append(SymbolicAction(kind, by, float(time_s), time_s + 0.5, to or None))
    return replace(explained(task, index, STUDY[task][index % 3]), actions=tuple(actions))


KNOWN = Knowledge().add(
    *(acted("give", number, *GIVEN) for number in range(3)), *(acted("hide", number, *PUT) for number in range(3))
)


def test_actions_are_kept_and_change_neither_which_demonstration_it_is_nor_what_it_means() -> None:
    own = acted("give", 1, *GIVEN)
    bare = replace(own, actions=None)
    assert (own.digest, own.content) == (bare.digest, bare.content)
    assert explanation_from_json(own.to_json()) == own
    assert "actions" not in bare.to_json(), "as those of earlier releases are kept"
    none = replace(own, actions=())
    assert explanation_from_json(none.to_json()).actions == (), "nothing done is not unknown"
    assert Knowledge().add(bare).add(own) == Knowledge().add(own).add(bare) == Knowledge().add(own)
    plain = Knowledge().add(*(replace(each, actions=None) for each in KNOWN.explanations))
    assert learn_task(plain, "give") == learn_task(KNOWN, "give")
    assert plain.understand("give").kept == KNOWN.understand("give").kept


def test_actions_of_several_targets_are_those_of_the_whole() -> None:
    part = explained("give", 1, STUDY["give"][0])
    whole = replace(merged([part, replace(part, target_agents=("P3",))]), actions=acted("give", 1, *GIVEN).actions)
    assert explanation_from_json(whole.to_json()) == whole


@pytest.mark.parametrize("damage", [{"start_s": "now"}, {"end_s": float("nan")}, {"kind": 3}, {"to": 1}, {"by": None}])
def test_damaged_actions_are_refused(damage: dict[str, object]) -> None:
    document = acted("give", 1, *GIVEN).to_json()
    action = {**document["actions"][0], **damage}  # type: ignore[index,dict-item]
    with pytest.raises(KnowledgeError, match="not an explanation"):
        explanation_from_json({**document, "actions": [action]})


def test_the_sequence_is_told_with_how_often_it_is_so_and_what_others_have_not() -> None:
    learned = learn_actions(KNOWN, "give")
    assert learned.sequence == GIVEN
    assert learned.support == (3, 3)
    assert learned.chance == pytest.approx(0.5 / 4)
    assert {each.node for each in learned.posterior.best.literals} <= {
        name for name in learned_names(learned.posterior.clauses) if "target" in name
    }
    assert learned.posterior.best.literals
    usual = {each.literal.node for each in learned.posterior.usual}
    assert set(MOVED) <= usual


def learned_names(clauses: tuple[object, ...]) -> set[str]:
    return {each.node for clause in clauses for each in clause.literals}  # type: ignore[attr-defined]


def test_one_that_is_done_otherwise_is_counted_and_the_order_of_demonstrations_does_not_matter() -> None:
    odd = acted("give", 7, *PUT)
    found = [learn_actions(Knowledge().add(*order), "give") for order in permutations([*KNOWN.explanations[:3], odd])]
    assert all(each == found[0] for each in found)
    assert found[0].support == (3, 4)


def test_another_order_is_told_apart_where_the_same_is_done() -> None:
    crossed = [acted("hide", number, *PUT[:4], PUT[5], PUT[4]) for number in range(3)]
    known = Knowledge().add(*(acted("put away", number, *PUT) for number in range(3)), *crossed)
    best = learn_actions(known, "put away").posterior.best
    assert "(place by performer before release by performer = yes)" in str(best)


def test_what_nobody_looked_at_is_unknown() -> None:
    bare = explained("give", 9, STUDY["give"][0])
    assert learn_actions(KNOWN.add(bare), "give") == learn_actions(KNOWN, "give")
    with pytest.raises(KnowledgeError, match=r"known what was done.*--actions"):
        learn_actions(Knowledge().add(bare), "give")
    alone = learn_actions(Knowledge().add(acted("give", 1, *GIVEN)), "give")
    assert (alone.sequence, alone.support, alone.chance) == (GIVEN, (1, 1), None)
    assert alone.posterior.best.literals == ()
