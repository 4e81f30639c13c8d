"""Facts from a JSON file: what is read, and how wrong files are refused."""

from __future__ import annotations

import copy
import json
import os
from pathlib import Path
from typing import Any

import pytest

from taskgist.errors import FactsError
from taskgist.facts import SCHEMA, STANDARD_TREE, UNKNOWN, facts_schema, parse_facts, predicate_subtree, read_facts
from taskgist.settings import Limits

DOCUMENT: dict[str, Any] = {
    "schema": "taskgist.facts/1",
    "task": "show",
    "demonstration": "show-1",
    "performing_agent": "P1",
    "target_agent": "P2",
    "target_object": "mug",
    "start": {"see.effort": "Head_Effort", "visibility.score": 0, "hands": {"left": "Free_of_Object", "right": None}},
    "end": {"motion": {"value": "Static", "evidence": {"speed_m_s": 0.01}}, "posture": None},
}


def test_a_file_becomes_an_episode(tmp_path: Path) -> None:
    path = tmp_path / "show-1.json"
    path.write_text(json.dumps(DOCUMENT), encoding="utf-8")
    episode = read_facts(path)
    assert (episode.task, episode.demonstration, episode.target_object) == ("show", "show-1", "mug")
    assert episode.start["hands"].value == {"left": "Free_of_Object", "right": None}
    assert episode.end["motion"].evidence == {"speed_m_s": 0.01}
    assert episode.end["posture"].value is UNKNOWN
    nodes = STANDARD_TREE.instantiate(episode.start, episode.end)
    assert nodes["see.effort.1"].value == "Head_Effort"
    assert nodes["grasp.class"].value is UNKNOWN


def test_the_source_follows_the_content() -> None:
    other = copy.deepcopy(DOCUMENT)
    other["start"]["visibility.score"] = 0.5
    sources = {parse_facts(document).source for document in (DOCUMENT, copy.deepcopy(DOCUMENT), other)}
    assert len(sources) == 2


def changed(path: str, value: object) -> dict[str, Any]:
    document = copy.deepcopy(DOCUMENT)
    *parts, last = path.split("/")
    target = document
    for part in parts:
        target = target[part]
    target[last] = value
    return document


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ([], "f.json: not an object"),
        (changed("schema", "taskgist.facts/9"), "f.json: schema: another format (got 'taskgist.facts/9')"),
        (changed("tsak", "show"), "f.json: tsak: no such field; did you mean 'task'?"),
        ({key: DOCUMENT[key] for key in DOCUMENT if key != "end"}, "f.json: end: missing"),
        (
            changed("target_agent", ["P2", "P3"]),
            "f.json: target_agent: not one name (got ['P2', 'P3']); several at once",
        ),
        (changed("task", " "), "f.json: task: is empty"),
        (changed("start", None), "f.json: start: not an object"),
        (changed("start/see.efort", "x"), "f.json: start.see.efort: no such attribute; did you mean 'see.effort'?"),
        (changed("start/see.effort", "Arm_Effort"), "f.json: start.see.effort: no such value (got 'Arm_Effort')"),
        (changed("end/visibility.score", 7), "f.json: end.visibility.score: not a visibility score (got 7)"),
        (changed("start/hands/left", "Fre_of_Object"), "f.json: start.hands.left: no such value (got 'Fre_of_Object')"),
        (
            changed("start/hands/lefft", "Free_of_Object"),
            "f.json: start.hands.lefft: no such side; did you mean 'left'?",
        ),
        (changed("end/motion/evidnce", {}), "f.json: end.motion.evidnce: no such field; did you mean 'evidence'?"),
        (changed("end/motion/evidence", 3), "f.json: end.motion.evidence: not an object (got 3)"),
    ],
)
def test_a_wrong_document_is_refused_with_field_value_and_way_out(document: object, message: str) -> None:
    with pytest.raises(FactsError) as caught:
        parse_facts(document, where="f.json")
    assert str(caught.value).startswith(message)


def test_a_file_that_is_missing_or_no_json_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FactsError, match=r"gone\.json: cannot be read: No such file"):
        read_facts(tmp_path / "gone.json")
    (tmp_path / "bad.json").write_bytes(b"{\xff")
    with pytest.raises(FactsError, match=r"bad\.json: not JSON"):
        read_facts(tmp_path / "bad.json")


def test_files_that_nobody_means(tmp_path: Path) -> None:
    path = tmp_path / "odd.json"
    for text, problem in [
        ("[" * 100_000, "nested deeper than"),
        ('{"task": "show", "task": "hide"}', "'task' is given twice"),
    ]:
        path.write_text(text, encoding="utf-8")
        with pytest.raises(FactsError, match=problem):
            read_facts(path)
    with pytest.raises(FactsError, match=r"is too large .* at most 20 bytes"):
        read_facts(path, limits=Limits(document_bytes=20))
    os.mkfifo(tmp_path / "pipe.json")
    with pytest.raises(FactsError, match="it is a pipe"):
        read_facts(tmp_path / "pipe.json")


def test_one_name_has_one_spelling() -> None:
    spelled = [changed("task", task) for task in ("caf\u00e9", "  cafe\u0301\n")]
    episodes = [parse_facts(document) for document in spelled]
    assert {episode.task for episode in episodes} == {"caf\u00e9"}
    assert len({episode.source for episode in episodes}) == 1


def test_not_a_number_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "nan.json"
    path.write_text(json.dumps(changed("start/visibility.score", float("nan"))), encoding="utf-8")
    with pytest.raises(FactsError, match=r"start\.visibility\.score: not a visibility score"):
        read_facts(path)
    path.write_text(json.dumps(changed("end/motion/evidence", {"gap_m": float("nan")})), encoding="utf-8")
    with pytest.raises(FactsError, match=r"end\.motion\.evidence: not plain data"):
        read_facts(path)


def test_the_schema_knows_every_attribute_and_predicates_too() -> None:
    assert json.loads(json.dumps(SCHEMA)) == SCHEMA
    schema: Any = SCHEMA
    assert set(schema["properties"]["start"]["properties"]) == set(STANDARD_TREE.attributes)
    extended: Any = facts_schema(STANDARD_TREE.extended(predicate_subtree("on_box")))
    assert extended["properties"]["end"]["properties"]["on_box"]["anyOf"][0] == {"enum": ["True", "False", True, False]}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"target_agent": "P1"}, "performing and target agent are the same"),
        ({"start": {}, "end": {}}, "no facts"),
        ({"target_object": "\ud800"}, "no Unicode"),
    ],
)
def test_what_could_teach_nothing_is_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(FactsError, match=message):
        parse_facts(DOCUMENT | change, where="facts.json")
