"""Explanations as JSON, and damaged ones."""

from __future__ import annotations

import copy
import json
from typing import Any

import pytest
from hypothesis import given, settings

from taskgist.errors import KnowledgeError
from taskgist.learning import Explanation, explanation_from_json
from tests.learning.learning_samples import STUDY, explained, explanations


@settings(max_examples=25, deadline=None, derandomize=True)
@given(explanations(most=2))
def test_json_keeps_everything(demonstrations: list[Explanation]) -> None:
    for each in demonstrations:
        back = explanation_from_json(json.loads(json.dumps(each.to_json())))
        assert back == each
        assert back.digest == each.digest


def damaged(change: str) -> object:
    document: Any = copy.deepcopy(explained("show", 1, STUDY["show"][0]).to_json())
    if change == "no object":
        return [document]
    if change == "task missing":
        del document["task"]
    if change == "nodes are text":
        document["nodes"] = "none"
    if change == "value is a number":
        document["nodes"]["see.class"]["value"] = 3
    if change == "source changed":
        document["source"] = "another"
    return document


@pytest.mark.parametrize(
    "change", ["no object", "task missing", "nodes are text", "value is a number", "source changed"]
)
def test_damage_is_seen(change: str) -> None:
    with pytest.raises(KnowledgeError, match=r"k\.db: .*restore the file from a copy"):
        explanation_from_json(damaged(change), where="k.db")
