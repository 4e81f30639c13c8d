"""Demonstrations marked wrong, what was done, and contradictions, through the command line."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from taskgist.cli.app import app
from taskgist.learning import Explanation, SymbolicAction
from taskgist.store import load, update
from tests.learning.learning_samples import STUDY, explained, study
from tests.schemas import hold_to_schema
from tests.shipped import PATHS, explanation


def run(*words: str, code: int = 0) -> str:
    result = CliRunner().invoke(app, list(words))
    assert result.exit_code == code, result.output
    return " ".join(result.output.split())


def told(name: str, task: str, effort: str, placement: str) -> str:
    document: dict[str, Any] = {
        "schema": "taskgist.facts/1",
        "task": task,
        "demonstration": name,
        "performing_agent": "P1",
        "target_agent": "P2",
        "target_object": "cup",
        "start": {"see.effort": "Head_Effort", "placement": "On_Support", "motion": "Static"},
        "end": {"see.effort": effort, "placement": placement, "motion": "Static"},
    }
    Path(f"{name}.json").write_text(json.dumps(document), encoding="utf-8")
    return f"{name}.json"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def hidden() -> None:
    run("learn", *(told(f"hide_{number}", "hide", "No_Possible_Known_Effort", "On_Support") for number in range(8)))


@pytest.mark.usefixtures("hidden")
def test_what_must_not_hold_is_told_and_wrong_ones_count_for_nothing() -> None:
    before = run("explain", "hide", "--rule", "paper")
    seen = [told(f"seen_{number}", "hide", "No_Effort_Required", "On_Support") for number in range(3)]
    output = run("learn", "--wrong", *seen)
    assert "hide: 3 demonstrations done wrong; what must not hold: taskgist explain hide --rule bayes" in output
    assert run("explain", "hide", "--rule", "paper") == before
    explained = run("explain", "hide", "--rule", "bayes")
    assert "must not:" in explained
    assert "in 3 of 3 wrong ones, in 0 of 8 right ones" in explained
    document = json.loads(CliRunner().invoke(app, ["explain", "hide", "--rule", "bayes", "--json"]).output)
    hold_to_schema("explain", document)
    (first, *_) = document["must_not"]
    assert first["wrong"] == {"k": 3, "n": 3}
    assert first["right"] == {"k": 0, "n": 8}
    assert first["node"].startswith("see.")
    learned = json.loads(CliRunner().invoke(app, ["learn", "--wrong", seen[0], "--json"]).output)
    hold_to_schema("learn", learned)
    assert learned["wrong"] == {"hide": 3}


@pytest.mark.usefixtures("hidden")
def test_one_wrong_demonstration_is_told_with_its_odds() -> None:
    run("learn", "--wrong", told("seen", "hide", "No_Effort_Required", "On_Support"))
    assert "in 1 of 1 wrong ones, in 0 of 8 right ones; odds" in run("explain", "hide", "--rule", "bayes")


def test_what_may_still_be_chance_is_not_told_and_not_denied() -> None:
    """It was seen in the wrong one alone; beside two right ones that is as likely chance."""
    run("learn", *(told(f"hide_{number}", "hide", "No_Possible_Known_Effort", "On_Support") for number in range(2)))
    run("learn", "--wrong", told("seen", "hide", "No_Effort_Required", "On_Support"))
    output = run("explain", "hide", "--rule", "bayes")
    assert "must not:" not in output
    assert "1 demonstration done wrong: what sets it apart from right ones may still be chance" in output


@pytest.mark.usefixtures("hidden")
def test_a_demonstration_is_right_or_wrong() -> None:
    output = run("learn", "--wrong", "hide_1.json", code=2)
    assert "error: hide_1.json: was learned from already, as a 'hide' done right, and not wrong" in output
    assert "add --replace to forget what knowledge.db holds of it" in output
    assert not list(Path().glob("*explained*")), "it was known beforehand"
    known = load("knowledge.db")
    assert (len(known.explanations), len(known.wrong)) == (8, 0), "nothing is lost, nothing is added"
    assert "1 demonstration done wrong" in run("learn", "--wrong", "hide_1.json", "--replace")
    assert len(load("knowledge.db").experience("hide").explanations) == 7
    assert "done wrong, and not right" in run("learn", "hide_1.json", code=2)


def test_a_recording_that_cannot_be_added_is_refused_before_it_is_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    path = str(PATHS["hide_a"])
    update("knowledge.db", [explanation("hide_a")])
    monkeypatch.setattr("taskgist.pipeline.explain.explain_all", None)
    before = sorted(Path().iterdir())
    output = run("learn", "--wrong", path, code=2)
    assert f"error: {path}: was learned from already, as a 'hide' done right, and not wrong" in output
    assert "; add --replace to forget what knowledge.db holds of it" in output
    assert "knowledge.db holds of it" in run(
        "learn", "--wrong", path, told("seen", "hide", "Head_Effort", "In_Hand"), code=2
    )
    Path("seen.json").unlink()
    assert sorted(Path().iterdir()) == before
    update("wrong.db", [explanation("hide_a").marked_wrong()])
    assert "error: wrong.db: was learned from already, as a 'hide' done right" in run("learn", "wrong.db", code=2)
    both = run("learn", "wrong.db", path, "-k", "new.db", code=2)
    assert "the same recording as" in both
    assert "done right and done wrong; learn from one of them" in both
    assert not Path("new.db").exists()


def test_wrong_ones_alone_are_kept_and_say_what_is_missing() -> None:
    output = run("learn", "--wrong", told("seen", "hide", "No_Effort_Required", "On_Support"))
    assert "none that was done right is known yet" in output
    assert "only demonstrations that were done wrong are known, of hide" in run("explain")
    refused = run("explain", "hide", code=2)
    assert "known by demonstrations that were done wrong alone; show how it is done right" in refused
    assert run("explain", "hide", "--rule", "bayes", code=2) == refused
    other = run("learn", "--wrong", "knowledge.db", "-k", "other.db", code=2)
    assert "a knowledge file says itself which of its demonstrations were done wrong" in other
    assert "1 demonstration done wrong" in run("learn", "knowledge.db", "-k", "other.db")


def test_a_task_that_nothing_can_be_compared_with_says_what_would_help() -> None:
    """The shipped neutral manipulations are explained for target agents; here somebody does it for nobody else."""

    def alone(task: str) -> list[Explanation]:
        return [replace(each, target_agents=("P1",)) for each in study(task).explanations.values()]

    update("knowledge.db", alone("hide"))
    output = run("explain", "hide", "--rule", "bayes")
    assert "compared with nothing, so that nothing is learned" in output
    assert "learn another task, to compare it with; or let the paper's rule speak" in output
    assert "by chance" not in output
    other = [
        replace(explained("give", number, each), target_agents=("P1",)) for number, each in enumerate(STUDY["give"])
    ]
    update("knowledge.db", other)
    assert "compared with 1 other task" in run("explain", "hide", "--rule", "bayes")


def test_actions_of_a_task_are_told_and_where_nobody_looked_that_is_said() -> None:
    bare = explained("give", 1, STUDY["give"][0])
    update("knowledge.db", [bare])
    refused = run("explain", "give", "--actions", code=2)
    assert "of none of its demonstrations is known what was done; learn it with --actions" in refused
    assert "taskgist explain TASK --actions" in run("explain", "--actions", code=2)
    done = (
        SymbolicAction("grasp", "performer", 1.0, 1.0),
        SymbolicAction("hand over", "performer", 2.0, 2.5, "target"),
    )
    update(
        "knowledge.db", [replace(bare, actions=done), replace(explained("hide", 1, STUDY["hide"][0]), actions=done[:1])]
    )
    output = run("explain", "give", "--actions")
    assert "in this order, in 1 of 1; by chance in 1 of 4: 1. grasp by performer" in output
    assert "2. hand over by performer to target" in output
    document = json.loads(CliRunner().invoke(app, ["explain", "give", "--actions", "--json"]).output)
    hold_to_schema("explain", document)
    assert document["actions"]["sequence"] == [each.name for each in done]
    assert document["compared"] == {"tasks": {"hide": 1}, "neutral": {}}


def test_what_is_done_in_most_other_tasks_is_not_said_to_be_done_in_none() -> None:
    done = (SymbolicAction("grasp", "performer", 1.0, 1.0), SymbolicAction("place", "performer", 2.0, 2.0))
    for task, actions in (("hide", done), ("put away", done), ("show", done[:1])):
        examples = [explained(task, number, each) for number, each in enumerate(STUDY[task][:3])]
        update("knowledge.db", [replace(each, actions=actions) for each in examples])
    output = run("explain", "hide", "--actions")
    assert "what other tasks have not:" not in output
    assert "what other tasks have less often, which may be chance: (place by performer = yes)" in output


def test_actions_of_a_recording_are_told_and_hold_to_the_schema() -> None:
    path = str(PATHS["handover_1"])
    document = json.loads(CliRunner().invoke(app, ["facts", path, "--actions", "--agent", "P1", "--json"]).output)
    hold_to_schema("facts", document)
    assert document["recording"] == path
    (over,) = [each for each in document["actions"] if each["kind"] == "hand over"]
    assert (over["agent"], over["thing"], over["to"]) == ("P1", "baton", "P2")
    assert "leave one of both out" in run("facts", path, "--actions", "--at", "1", code=2)
    assert "no agent 'P3'" in run("facts", path, "--actions", "--agent", "P3", code=2)
