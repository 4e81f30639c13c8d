"""Demonstrations that were done wrong last as such, and contradict right ones of the same recording."""

from __future__ import annotations

from dataclasses import replace

import pytest

from taskgist.errors import KnowledgeError
from taskgist.learning import Context, Knowledge, SymbolicAction
from taskgist.store import load, save, update
from tests.store.test_store import KNOWLEDGE, explanation

WRONG = explanation(9).marked_wrong()


def test_they_last_and_load_with_their_task(address: str) -> None:
    save(KNOWLEDGE.add(WRONG), address)
    assert load(address) == KNOWLEDGE.add(WRONG)
    assert load(address, tasks=["show"]).wrong
    assert not load(address, tasks=["hide"]).wrong
    update(address, [WRONG])
    assert load(address) == KNOWLEDGE.add(WRONG), "the same again changes nothing"
    update(address, forget=[WRONG.digest])
    assert load(address) == KNOWLEDGE


def test_a_recording_is_right_or_wrong(address: str) -> None:
    right = explanation(9)
    update(address, [right], relabelled="refuse")
    with pytest.raises(KnowledgeError, match=r"as a 'show' done right, and not wrong.*--replace") as refused:
        update(address, [WRONG], relabelled="refuse")
    assert right.demonstration in str(refused.value)
    assert load(address) == Knowledge().add(right), "nothing is lost"
    update(address, [WRONG], relabelled="replace")
    assert load(address) == Knowledge().add(WRONG)
    with pytest.raises(KnowledgeError, match="done wrong, and not right"):
        update(address, [right], relabelled="refuse")
    with pytest.raises(KnowledgeError, match=r"the same recording as .* done right and done wrong"):
        update(address, [right, WRONG], relabelled="refuse")
    update(address, [replace(right, task="give")], relabelled="refuse")
    assert load(address).tasks == ("give",), "what is a wrong show may be a right give"


def test_wrong_ones_of_other_settings_are_refused_beside_right_ones(address: str) -> None:
    update(address, [explanation(1)])
    with pytest.raises(KnowledgeError, match="different contexts"):
        update(address, [replace(WRONG, context=Context("other", "tree"))])
    assert load(address) == Knowledge().add(explanation(1))


def test_what_was_done_can_be_added_later_and_is_not_lost_again(address: str) -> None:
    bare = explanation(1)
    told = replace(bare, actions=(SymbolicAction("grasp", "performer", 1.0, 1.0),))
    for each in (bare, told, bare):
        update(address, [each], relabelled="refuse")
    (found,) = load(address).explanations
    assert found == told
