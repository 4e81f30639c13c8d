"""A recording whose label was moved is not counted twice, and knowledge notices when it was changed."""

import shutil
import sqlite3
from pathlib import Path

import pytest
from typer.testing import CliRunner

from taskgist.cli.app import app
from taskgist.pipeline import shipped_recordings
from taskgist.store import load


def run(*words: str) -> tuple[int, str]:
    result = CliRunner().invoke(app, list(words))
    return result.exit_code, result.output


@pytest.fixture
def learned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    shutil.copy(shipped_recordings("give")[0], tmp_path / "a.mcap")
    assert run("learn", "a.mcap")[0] == 0
    return tmp_path


@pytest.mark.usefixtures("learned")
def test_a_moved_label_is_refused_and_can_replace() -> None:
    assert run("label", "a.mcap", "--start", "1.5")[0] == 0
    code, output = run("learn", "a.mcap")
    assert code == 2
    assert "--replace" in output
    assert len(load("knowledge.db").explanations) == 1
    assert run("learn", "a.mcap", "--replace")[0] == 0
    (explanation,) = load("knowledge.db").explanations
    assert "1.5000-" in explanation.source
    assert run("learn", "a.mcap")[0] == 0, "the same again changes nothing"


def test_changed_knowledge_is_noticed(learned: Path) -> None:
    with sqlite3.connect(learned / "knowledge.db") as connection:
        connection.execute(
            "UPDATE taskgist_explanations SET document = replace(document, 'Becomes_Easier', 'Becomes_Harder')"
        )
    connection.close()
    code, output = run("explain", "give")
    assert code == 2
    assert "damaged explanation" in output


def test_halves_of_characters_are_refused(learned: Path) -> None:
    text = '{"schema": "taskgist.facts/1", "task": "give", "demonstration": "\\ud800", "performing_agent": "P1"}'
    (learned / "facts.json").write_text(text)
    code, output = run("learn", "facts.json")
    assert code == 2
    assert "no Unicode" in output
    (learned / "deep.json").write_text("[" * 100_000)
    assert run("learn", "deep.json")[0] == 2


def test_corrected_facts_replace_the_old_ones(learned: Path) -> None:
    facts = Path(__file__).parent.parent.parent / "docs" / "howto" / "extending.md"
    text = facts.read_text(encoding="utf-8")
    start = text.index('    {\n      "schema"')
    document = text[start : text.index("\n    }\n", start) + 7]
    (learned / "one.json").write_text(document)
    (learned / "two.json").write_text(document.replace("0.012", "0.013"))
    assert run("learn", "one.json")[0] == 0
    assert run("learn", "two.json")[0] == 2
    assert run("learn", "two.json", "--replace")[0] == 0
    assert len(load("knowledge.db").experience("show").explanations) == 1


def test_nothing_is_added_to_what_cannot_be_shown_afterwards(learned: Path) -> None:
    """An answer has nothing to do with the addition, but is told with it."""
    document = '{"schema": "taskgist.facts/1", "task": "give", "demonstration": "d", "performing_agent": "P1"'
    document += ', "target_agent": "P2", "target_object": "cup", "start": {"posture": "Standing"}, "end": {}}'
    (learned / "one.json").write_text(document)
    with sqlite3.connect(learned / "knowledge.db") as connection:
        connection.execute("INSERT INTO taskgist_answers (digest, task, document) VALUES ('x', 'give', '{}')")
    connection.close()
    before = (learned / "knowledge.db").read_bytes()
    code, output = run("learn", "one.json")
    assert code == 2, output
    assert "not an answer" in output
    assert (learned / "knowledge.db").read_bytes() == before
