"""The background that is shipped, and what a task is compared with."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from taskgist.errors import KnowledgeError
from taskgist.facts import STANDARD_TREE
from taskgist.learning import Answer, Context, Knowledge, Verdict
from taskgist.learning.background import NEUTRAL, SHIPPED, Background, learn_task, shipped_background
from taskgist.learning.evidence import effects_of
from taskgist.learning.literals import vocabularies
from tests.learning.learning_samples import STUDY, explained, study


def knowledge(*tasks: str) -> Knowledge:
    return Knowledge().add(*(each for task in tasks for each in study(task).explanations.values()))


def test_the_shipped_background_was_explained_as_demonstrations_are_today() -> None:
    shipped = shipped_background()
    assert shipped.context == Context.of(), "make it again: python -m tools.neutral_background"
    assert len(shipped.effects) >= 200
    assert SHIPPED.stat().st_size < 200_000


def test_it_says_something_of_the_nodes_that_literals_are_about_and_of_no_other() -> None:
    names = {name for each in shipped_background().effects for name in each}
    assert names == {vocabulary.node.name for vocabulary in vocabularies(STANDARD_TREE)}


def test_a_background_comes_back_from_its_document() -> None:
    rows = [effects_of(explained("hide", i % 2, STUDY["hide"][i % 2])) for i in range(5)] + [{}]
    background = Background.of(Context.of(), rows)
    document = json.loads(json.dumps(background.to_json()))
    assert Background.from_json(document) == background
    assert sorted(count for count, *_ in document["rows"]) == [1, 2, 3]
    assert Background.of(Context.of(), rows[::-1]) == background


@pytest.mark.parametrize("damage", [{"format": "another"}, {"rows": [[1, 99]]}, {"rows": None}, {"values": []}])
def test_what_is_no_background_is_refused(damage: dict[str, object]) -> None:
    document = Background.of(Context.of(), [{"see.class": "Remains_Same"}]).to_json() | damage
    with pytest.raises(KnowledgeError, match="not a background"):
        Background.from_json(document)


def test_a_first_task_is_compared_with_neutral_manipulations_and_a_second_with_the_first() -> None:
    first = learn_task(knowledge("hide"), "hide")
    assert first.compared == {NEUTRAL: len(shipped_background().effects)}
    assert first.best.literals
    second = learn_task(knowledge("hide", "give"), "hide")
    assert second.compared == {**first.compared, "give": 3}


def test_a_background_of_another_context_is_left_aside() -> None:
    other = replace(shipped_background(), context=Context("other", "tree"))
    assert learn_task(knowledge("hide", "give"), "hide", background=other).compared == {"give": 3}


def test_answers_fix_literals_until_they_are_withdrawn() -> None:
    known = knowledge("hide", "give")
    node = learn_task(known, "hide").best.literals[0].node

    def answered(verdict: Verdict | None, hour: int) -> Answer:
        return Answer("hide", node, verdict, "Ann", f"2026-01-01T{hour:02}:00:00+00:00")

    irrelevant = known.answer(answered(Verdict.IRRELEVANT, 1))
    assert node not in {each.node for each in learn_task(irrelevant, "hide").best.literals}
    relevant = irrelevant.answer(answered(Verdict.RELEVANT, 2))
    assert all(node in {each.node for each in one.literals} for one in learn_task(relevant, "hide").clauses)
    assert learn_task(relevant.answer(answered(None, 3)), "hide") == learn_task(known, "hide")
