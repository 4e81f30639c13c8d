"""The background that is shipped, and what a task is compared with."""

from __future__ import annotations

import json

import pytest

from taskgist.errors import KnowledgeError
from taskgist.facts import STANDARD_TREE
from taskgist.learning import Context
from taskgist.learning.background import SHIPPED, Background, shipped_background
from taskgist.learning.evidence import effects_of
from taskgist.learning.literals import vocabularies
from tests.learning.learning_samples import STUDY, explained


def test_the_shipped_background_was_explained_as_demonstrations_are_today() -> None:
    shipped = shipped_background()
    assert shipped.context == Context.of(), "make it again: python -m tools.neutral_background"
    assert sum(map(len, shipped.manipulations.values())) >= 200
    assert min(map(len, shipped.manipulations.values())) >= 20
    assert SHIPPED.stat().st_size < 200_000


def test_it_says_something_of_the_nodes_that_literals_are_about_and_of_no_other() -> None:
    names = {name for rows in shipped_background().manipulations.values() for each in rows for name in each}
    assert names == {vocabulary.node.name for vocabulary in vocabularies(STANDARD_TREE)}


def test_a_background_comes_back_from_its_document() -> None:
    rows = [effects_of(explained("hide", i % 2, STUDY["hide"][i % 2])) for i in range(5)] + [{}]
    background = Background.of(Context.of(), {"wipe": rows, "fold": rows[:1]})
    document = json.loads(json.dumps(background.to_json()))
    assert Background.from_json(document) == background
    assert sorted(count for count, *_ in document["manipulations"]["wipe"]) == [1, 2, 3]
    assert Background.of(Context.of(), {"fold": rows[:1], "wipe": rows[::-1]}) == background


@pytest.mark.parametrize(
    "damage",
    [
        {"format": "another"},
        {"manipulations": {"wipe": [[1, 99]]}},
        {"manipulations": None},
        {"values": []},
    ],
)
def test_what_is_no_background_is_refused(damage: dict[str, object]) -> None:
    document = Background.of(Context.of(), {"wipe": [{"see.class": "Remains_Same"}]}).to_json() | damage
    with pytest.raises(KnowledgeError, match="not a background"):
        Background.from_json(document)
