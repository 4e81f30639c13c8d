"""``taskgist ask``: a dialogue as a robot leads it, and what it refuses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from taskgist.learning import Knowledge
from taskgist.store.database import load, save, update
from tests.cli.running import Result, run, run_json
from tests.learning.learning_samples import study
from tests.schemas import hold_to_schema


@pytest.fixture
def path(tmp_path: Path) -> Path:
    file = tmp_path / "knowledge.db"
    save(Knowledge().add(*(each for task in ("hide", "show") for each in study(task, 2).explanations.values())), file)
    return file


def document(words: str) -> Any:
    found = run_json(words)
    hold_to_schema("ask", found)
    return found


def test_a_dialogue(path: Path) -> None:
    first = document(f"ask hide -k {path}")
    question = first["question"]
    assert question["text"] == "In “hide”, must it always be that seeing the object becomes harder?"
    assert question["holds_in"] == ["hide 1", "hide 2"]
    assert [each["answer"] for each in question["answers"]] == ["yes", "no", "either"]
    assert first["lessons"]
    Draft202012Validator.check_schema(question["answer_schema"])
    validator = Draft202012Validator(question["answer_schema"])
    assert validator.is_valid({"question": question["id"], "answer": "unknown"})
    assert not validator.is_valid({"question": question["id"], "answer": "maybe"})

    said = '{"question":"' + question["id"] + '","answer":"yes"}'
    second = document(f"ask hide -k {path} --author ann --answer '{said}'")
    assert (second["noted"]["question"], second["noted"]["answer"], second["noted"]["author"]) == (
        question["id"],
        "yes",
        "ann",
    )
    assert second["clause"] == question["answers"][0]["clause"]
    assert second["question"]["id"] != question["id"]
    assert second["answers"] == [second["noted"]]
    assert question["id"] in run(f"ask hide -k {path} --list")

    third = document(f"ask hide -k {path} --withdraw --question {question['id']}")
    assert third["answers"] == []
    assert third["question"] == question
    assert len(load(path).answers) == 2, "nothing is thrown away"


def test_in_words(path: Path) -> None:
    text = run(f"ask hide -k {path}")
    for told in (
        "must it always be that",
        "It was so in hide 1 and hide 2.",
        "either  it may be so or not",
        "what a demonstration would tell:",
        "the target agent is standing",
    ):
        assert told in text
    assert run(f"ask hide -k {path} --answer unknown").startswith("noted: unknown   see.nature=Not_Supportive")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("--answer maybe", "no answer to a question"),
        ("--answer '{\"answer\": 1}'", "not an answer"),
        ('--answer \'{"answer": "yes"}\'', "not an answer"),
        ("--answer '{'", "no JSON"),
        ("--answer yes --question foo=bar", "no question about 'foo'"),
        ("--answer yes --question see.class=Harder", "no value of see.class 'Harder'"),
        ("--answer yes --question see.nature=Supportive|Not_Supportive", "asks about all values"),
        ("--answer yes --question see.nature", "names no value"),
        ("--question see.class=Becomes_Difficult", "what is the answer?"),
        ("--withdraw", "which answer?"),
        ("--withdraw --question see.class=Becomes_Easier", "no answer to"),
        ("--answer yes --withdraw --question see.class=Becomes_Easier", "at once"),
        ('--answer \'{"answer":"no","question":"a=b"}\' --question c=d', "answers another question"),
        ("--of performer", "known of target agents alone"),
    ],
)
def test_misuse_is_told_and_changes_nothing(path: Path, words: str, told: str) -> None:
    before = path.read_bytes()
    result = Result(f"ask hide -k {path} {words}")
    assert (result.exit_code, result.stdout) == (2, "")
    assert told in result.stderr
    assert path.read_bytes() == before


def test_a_contradiction_is_refused_with_both_named_and_is_not_kept(path: Path) -> None:
    run(f"ask hide -k {path} --answer yes --author ann --question see.class=Becomes_Difficult")
    result = Result(f"ask hide -k {path} --answer yes --author bob --question see.nature=Supportive")
    assert result.exit_code == 2
    for told in ("ann", "bob", "see.class=Becomes_Difficult", "see.nature=Supportive"):
        assert told in result.stderr
    assert "--withdraw --question 'see.class=Becomes_Difficult'" in result.stderr  # the one that is kept
    assert {each.author for each in load(path).answers} == {"ann"}


def test_answers_that_contradict_each_other_after_a_merge_are_listed(path: Path) -> None:
    other = path.with_name("other.db")
    other.write_bytes(path.read_bytes())
    for reply, author, kept in (("yes", "ann", path), ("no", "bob", other)):
        run(f"ask hide -k {kept} --answer {reply} --author {author} --question see.class=Becomes_Difficult")
    update(path, answers=load(other).answers)
    assert "contradict each other" in Result(f"ask hide -k {path}").stderr
    text = run(f"ask hide -k {path} --list")
    assert ("yes: " in text, "no: " in text, "(ann, " in text, "(bob, " in text) == (True,) * 4


def test_both_rules_respect_an_answer(path: Path) -> None:
    run(f"ask hide -k {path} --answer either --question see.class=Becomes_Difficult")
    assert "Becomes_Difficult" not in run_json(f"explain hide -k {path} --rule bayes")["clause"]["text"]
    assert run_json(f"explain hide -k {path} --rule paper")["nodes"]["see.class"]["verdict"] == "irrelevant"
