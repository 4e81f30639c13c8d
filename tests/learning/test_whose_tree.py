"""The tree of who performs (7.2) and those of target agents: one knowledge, and nothing of one counts in the other."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from taskgist.errors import InputError, KnowledgeError, UnknownNameError
from taskgist.facts import STANDARD_TREE
from taskgist.language import asked, meaning
from taskgist.language.phrases import topic
from taskgist.learning import (
    Answer,
    Context,
    Experience,
    Explanation,
    Knowledge,
    Verdict,
    answer_from_json,
    clause_of,
    explanation_from_json,
    questions_of,
    understand,
)
from taskgist.planning import Request
from taskgist.store import load, update
from tests.learning.learning_samples import STUDY, explained

NOON = "2024-05-01T12:00:00+00:00"
TARGETS = tuple(
    replace(explained("show", index, told), source=f"recording{index} 0.0000-1.0000 s")
    for index, told in enumerate(STUDY["show"], start=1)
)


def own(explanation: Explanation) -> Explanation:
    """The same, told of who performs."""
    return replace(explanation, target_agents=(explanation.performing_agent,))


PERFORMERS = tuple(own(each) for each in TARGETS[1:3])
BOTH = Knowledge().add(*TARGETS, *PERFORMERS)


def test_each_tree_is_understood_by_itself() -> None:
    assert BOTH.tasks == ("show",)
    assert BOTH.trees_of("show") == ("target", "performer")
    assert BOTH.understand("show") == understand(Experience.of("show", TARGETS))
    assert BOTH.understand("show", of="performer").experience == Experience.of("show", PERFORMERS)
    assert set(BOTH.explanations) == {*TARGETS, *PERFORMERS}
    assert BOTH.rivals(PERFORMERS[0]) == (), "one recording may teach both"
    assert Knowledge().add(*PERFORMERS).merge(Knowledge().add(*TARGETS)) == BOTH


def test_trees_of_different_agents_are_not_merged() -> None:
    for first, second in ((TARGETS[0], PERFORMERS[0]), (PERFORMERS[0], TARGETS[0])):
        with pytest.raises(KnowledgeError, match=r"'s tree beside the .*'s: they tell of different agents"):
            Experience.of("show", [first]).add(second, allow_mixed=True)


def test_what_is_removed_leaves_the_other_tree_as_it_was() -> None:
    left = BOTH
    for each in PERFORMERS:
        left = left.remove("show", each.digest)
    assert left == Knowledge().add(*TARGETS)
    with pytest.raises(UnknownNameError, match="no explanation"):
        left.remove("show", PERFORMERS[0].digest)


def test_a_tree_that_was_not_learned_is_asked_for() -> None:
    with pytest.raises(KnowledgeError, match=r"task show: of: known of target agents alone .*--of performer"):
        Knowledge().add(*TARGETS).understand("show", of="performer")
    alone = Knowledge().add(*PERFORMERS)
    assert alone.understand("show") == alone.understand("show", of="performer"), "it is performed for nobody else"


def test_sentences_and_clauses_say_whose_tree_it_is() -> None:
    assert meaning(BOTH.understand("show")).startswith("“show” means for the target agent: ")
    assert meaning(BOTH.understand("show", of="performer")).startswith("“show” means for the performing agent: ")
    assert topic(STANDARD_TREE.node("posture.class"), "performer") == "whether the performing agent sits or stands"
    assert str(clause_of(BOTH.understand("show"))).startswith("Task(show) ←")
    assert str(clause_of(BOTH.understand("show", of="performer"))).startswith("Task(show, for the performing agent) ←")


def test_answers_are_on_one_tree() -> None:
    many = [replace(own(explained("show", 1, STUDY["show"][0])), source=f"test:{index} ") for index in range(9)]
    sitting = [*many[1:], replace(many[0], nodes=own(TARGETS[3]).nodes)]
    known = Knowledge().add(*sitting, *TARGETS)
    questions = questions_of(known.understand("show", of="performer"))
    question = next(each for each in questions if each.node.name.startswith("posture"))
    assert "mean for the performing agent" in asked(question)
    answer = question.answer(Verdict.IRRELEVANT, author="ann", time=NOON)
    answered = known.answer(answer)
    assert answered.understand("show", of="performer").judgements[question.node.name].answer == answer
    assert answered.understand("show") == known.understand("show")
    assert answer_from_json(json.loads(json.dumps(answer.to_json()))) == answer
    assert "tree_of" not in replace(answer, tree_of="target").to_json(), "as answers of earlier releases are kept"
    with pytest.raises(KnowledgeError, match=r"not an answer: .*nobody"):
        answer_from_json({**answer.to_json(), "tree_of": "nobody"})


def test_a_store_keeps_both_and_their_contexts(tmp_path: Path) -> None:
    path = tmp_path / "knowledge.db"
    answer = Answer("show", "posture.class", Verdict.RELEVANT, "ann", NOON, tree_of="performer")
    update(path, [*TARGETS, *PERFORMERS], [answer], relabelled="refuse")
    assert load(path) == BOTH.answer(answer)
    assert explanation_from_json(PERFORMERS[0].to_json()) == PERFORMERS[0]
    # Explanations of the targets under both contexts must not hide that those of the performer are under one.
    other = Context("another", "tree")
    update(path, [replace(each, context=other) for each in TARGETS], allow_mixed=True)
    with pytest.raises(KnowledgeError, match="made under different contexts"):
        update(path, [replace(own(TARGETS[0]), context=other)])


def test_what_tells_of_the_performer_is_not_performed_for_others() -> None:
    with pytest.raises(InputError, match=r"its clause tells of who performs it.*learn it without --of performer"):
        Request(clause_of(BOTH.understand("show", of="performer")), "PR2", "P2", "cup")
