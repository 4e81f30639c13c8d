"""Demonstrations marked wrong, and contradictions, through the command line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from taskgist.cli.app import app
from taskgist.store import load
from tests.schemas import hold_to_schema


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
    before = run("explain", "hide")
    seen = [told(f"seen_{number}", "hide", "No_Effort_Required", "On_Support") for number in range(3)]
    output = run("learn", "--wrong", *seen)
    assert "hide: 3 demonstrations done wrong; what must not hold: taskgist explain hide --rule bayes" in output
    assert run("explain", "hide") == before
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


@pytest.mark.usefixtures("hidden")
def test_a_demonstration_is_right_or_wrong() -> None:
    output = run("learn", "--wrong", "hide_1.json", code=2)
    assert "hide_1: source: was learned from already, as a 'hide' done right, and not wrong" in output
    assert "add --replace to forget that" in output
    known = load("knowledge.db")
    assert (len(known.explanations), known.wrong) == (8, {}), "nothing is lost, nothing is added"
    assert "1 demonstration done wrong" in run("learn", "--wrong", "hide_1.json", "--replace")
    assert len(load("knowledge.db").experience("hide").explanations) == 7
    assert "done wrong, and not right" in run("learn", "hide_1.json", code=2)


def test_wrong_ones_alone_are_kept_and_say_what_is_missing() -> None:
    output = run("learn", "--wrong", told("seen", "hide", "No_Effort_Required", "On_Support"))
    assert "none that was done right is known yet" in output
    refused = run("explain", "hide", code=2)
    assert "known by demonstrations that were done wrong alone; show how it is done right" in refused
    assert run("explain", "hide", "--rule", "bayes", code=2) == refused
    other = run("learn", "--wrong", "knowledge.db", "-k", "other.db", code=2)
    assert "a knowledge file says itself which of its demonstrations were done wrong" in other
    assert "1 demonstration done wrong" in run("learn", "knowledge.db", "-k", "other.db")
