"""``taskgist ask``: a dialogue as a robot leads it, and what it refuses."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from taskgist.learning import Explanation, Knowledge
from taskgist.store.database import load, save, update
from tests.cli.running import Result, run, run_json
from tests.learning.learning_samples import study
from tests.schemas import hold_to_schema
from tests.shipped import PATHS


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
        ("--list --answer yes", "--list: only lists; leave one of --list and --answer out"),
        ("--list --withdraw --question see.class=Becomes_Difficult", "leave one of --list and --withdraw out"),
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
        ("--withdraw --question see.class=Becomes_Easier --author bob", "no answer of bob to"),
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


@pytest.mark.parametrize("count", [1, 3])
def test_an_answer_against_all_demonstrations_is_told_and_makes_none_of_them_odd(tmp_path: Path, count: int) -> None:
    kept = tmp_path / "kept.db"
    examples = [*study("hide", count).explanations.values(), *study("show", 3).explanations.values()]
    save(Knowledge().add(*examples), kept)
    told = f"your answer stands against {'all 3 demonstrations' if count > 1 else 'the one demonstration'}\n"
    assert told not in run(f"ask hide -k {kept} --answer yes --question see.class=Becomes_Difficult")
    assert document(f"ask hide -k {kept}")["against_all"] == []
    run(f"ask hide -k {kept} --withdraw --question see.class=Becomes_Difficult")
    assert told in run(f"ask hide -k {kept} --answer no --question see.class=Becomes_Difficult")
    (against,) = document(f"ask hide -k {kept}")["against_all"]
    assert (against["question"], against["answer"]) == ("see.class=Becomes_Difficult", "no")
    text = run(f"explain hide -k {kept}")
    assert text.count("stands against") == 1
    assert "stands against all 3 demonstrations:\n  no: seeing the object becomes harder   (" in text or count == 1
    assert "odd demonstrations" not in text
    explained = run_json(f"explain hide -k {kept}")
    assert (explained["odd"], explained["against_all"]) == ([], [against])
    assert run_json(f"explain show -k {kept}")["against_all"] == []


def test_where_nothing_can_be_compared_nothing_is_asked(tmp_path: Path) -> None:
    """The shipped neutral manipulations are explained for target agents; here somebody does it for nobody else."""
    kept = tmp_path / "kept.db"

    def alone(task: str) -> list[Explanation]:
        return [replace(each, target_agents=("P1",)) for each in study(task, 3).explanations.values()]

    save(Knowledge().add(*alone("hide")), kept)
    assert run(f"ask hide -k {kept}") == "nothing can be compared yet: learn another task, then ask again\n"
    told = document(f"ask hide -k {kept}")
    assert (told["question"], told["further"], told["lessons"]) == (None, [], [])
    assert told["compared"] == {"tasks": {}, "neutral": {}}
    refused = Result(f"ask hide -k {kept} --answer yes")
    assert (refused.exit_code, "nothing can be compared yet" in refused.stderr) == (2, True)
    run(f"ask hide -k {kept} --answer yes --question see.class=Becomes_Difficult")  # what is said by itself is kept
    update(kept, alone("show"))
    assert document(f"ask hide -k {kept}")["question"] is not None
    assert document(f"ask hide -k {kept}")["compared"] == {"tasks": {"show": 3}, "neutral": {}}


@pytest.fixture
def contradicted(path: Path) -> Path:
    """Knowledge in which Ann has said the opposite of what Bob has said, and both are kept."""
    other = path.with_name("other.db")
    other.write_bytes(path.read_bytes())
    for reply, author, kept in (("yes", "ann", path), ("no", "bob", other)):
        run(f"ask hide -k {kept} --answer {reply} --author {author} --question see.class=Becomes_Difficult")
    update(path, answers=load(other).answers)
    return path


def test_answers_that_contradict_each_other_after_a_merge_are_listed(contradicted: Path) -> None:
    assert "contradict each other" in Result(f"ask hide -k {contradicted}").stderr
    text = run(f"ask hide -k {contradicted} --list")
    assert ("yes: " in text, "no: " in text, "(ann, " in text, "(bob, " in text) == (True,) * 4
    assert not re.search(r":\d\d\.\d", text), "seconds are enough"


@pytest.mark.parametrize(("author", "left"), [("ann", {"bob"}), ("bob", {"ann"}), (None, set())])
def test_with_an_author_only_that_ones_answer_is_withdrawn(
    contradicted: Path, author: str | None, left: set[str]
) -> None:
    whose = f" --author {author}" if author else ""
    told = document(f"ask hide -k {contradicted} --withdraw --question see.class=Becomes_Difficult{whose}")
    assert {each["author"] for each in told["answers"]} == left


def test_the_way_out_of_a_contradiction_that_is_told_is_one(contradicted: Path) -> None:
    refused = Result(f"explain hide -k {contradicted}")
    assert refused.exit_code == 2
    _, _, command = refused.stderr.strip().partition("taskgist ")
    run(f"{command} -k {contradicted}")
    run(f"explain hide -k {contradicted}")


def test_only_the_task_of_the_contradiction_is_refused(contradicted: Path) -> None:
    told = f"left out: hide (answers contradict each other: taskgist ask hide --list -k {contradicted})"
    recording = PATHS["show_a"]
    for line in (
        f"recognise {recording}",
        f"recognise {recording} --at 90%",
        f"recognise {recording} {recording.parent}/*b*",
    ):
        result = Result(f"{line} -k {contradicted}")
        assert result.exit_code < 2, result.stderr
        assert told in result.stdout
        documents = run_json(f"{line} -k {contradicted}", exit_code=result.exit_code)
        for each in documents if isinstance(documents, list) else [documents]:
            assert each["left_out"] == ["hide"]
    run(f"explain show -k {contradicted}")
    run(f"explain show -k {contradicted} --contrast hide")
    room = f"offer {recording} --at 0 --for P2 --object cup -k {contradicted}"
    offered = Result(room)
    assert offered.exit_code < 2, offered.stderr
    assert told in offered.stdout
    assert run_json(room, exit_code=offered.exit_code)["left_out"] == ["hide"]
    by_paper = Result(f"{room} --rule paper")
    assert "left out" not in by_paper.stdout, "the paper's rule knows no such contradiction"
    refused = Result(f"explain hide -k {contradicted}")
    assert (refused.exit_code, "contradict each other" in refused.stderr) == (2, True)


def test_where_all_tasks_are_contradicted_nothing_is_left_to_ask_for(contradicted: Path) -> None:
    answers = (replace(each, task="show") for each in load(contradicted).answers)
    update(contradicted, answers=answers)
    for line in (f"recognise {PATHS['show_a']}", f"offer {PATHS['show_a']} --for P2 --object cup"):
        refused = Result(f"{line} -k {contradicted}")
        assert (refused.exit_code, "contradict each other" in refused.stderr) == (2, True)


def test_both_rules_respect_an_answer(path: Path) -> None:
    run(f"ask hide -k {path} --answer either --question see.class=Becomes_Difficult")
    assert "Becomes_Difficult" not in run_json(f"explain hide -k {path} --rule bayes")["clause"]["text"]
    assert run_json(f"explain hide -k {path} --rule paper")["nodes"]["see.class"]["verdict"] == "irrelevant"
