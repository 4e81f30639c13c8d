"""``taskgist learn`` and ``explain`` on files and servers: what was computed is kept, what is secret is not shown."""

from __future__ import annotations

import json
import os
import shutil
import sqlite3
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from taskgist.cli.app import app
from taskgist.errors import KnowledgeError
from taskgist.learning import Answer, Context, Explanation, Knowledge, Verdict
from taskgist.pipeline import shipped_recordings
from taskgist.store import create, database, load, save
from taskgist.store.address import Address
from tests.store.test_store import explanation
from tools.kill import FACTS

ANSWER = Answer("show", "see.class", Verdict.RELEVANT, author="ann", time="2024-05-01T12:00:00+00:00", value="x")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name in ("one", "two", "three"):
        facts(name, demonstration=name)
    return tmp_path


def facts(name: str, **changes: object) -> None:
    Path(f"{name}.json").write_text(json.dumps({**FACTS, **changes}), encoding="utf-8")


def run(*words: str) -> tuple[int, str]:
    result = CliRunner().invoke(app, list(words))
    assert result.exception is None or isinstance(result.exception, SystemExit), repr(result.exception)
    return result.exit_code, result.output


def names(address: Address) -> set[str]:
    return {each.demonstration for each in load(address).explanations}


def failing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every addition is refused, as if the disk were full."""

    def full(*_: object, **__: object) -> None:
        raise KnowledgeError("the disk is full", where="knowledge.db", hint="free some space")

    monkeypatch.setattr(database, "update", full)


def going_on(output: str) -> list[str]:
    """The command that a refusal proposes."""
    return output.partition("; what was explained is kept, to go on from: taskgist ")[2].split()


@pytest.mark.usefixtures("folder")
def test_what_was_explained_is_kept_when_it_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copy(shipped_recordings("give")[0], "handed.mcap")
    with pytest.MonkeyPatch.context() as patch:
        failing(patch)
        code, output = run("learn", "one.json", "handed.mcap", "two.json")
        assert code == 2
        assert "error: knowledge.db: the disk is full; free some space; what was explained is kept" in output
        assert not Path("knowledge.db").exists()
        again = going_on(output)
        assert again == ["learn", "knowledge.explained.db", "-k", "knowledge.db"]
        assert going_on(run("learn", "three.json")[1])[1] == "knowledge.explained-2.db", "nothing is written over"
    monkeypatch.setattr("taskgist.pipeline.explain.explain_all", None)  # nothing is computed again
    assert run(*again)[0] == 0
    assert names("knowledge.db") == names("knowledge.explained.db") == {"one", "two", "handover_1"}
    assert run("learn", "knowledge.explained-2.db", "-k", "knowledge.db")[0] == 0
    assert names("knowledge.db") == {"one", "two", "three", "handover_1"}


@pytest.mark.usefixtures("folder")
def test_what_was_explained_before_a_recording_failed_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    def half(*_: object, **__: object) -> Iterator[Explanation]:
        yield explanation(1)
        raise KnowledgeError("a recording that cannot be explained", where="second.mcap")

    monkeypatch.setattr("taskgist.pipeline.explain.explain_all", half)
    shutil.copy(shipped_recordings("give")[0], "handed.mcap")
    output = run("learn", "handed.mcap")[1]
    assert "error: second.mcap: a recording that cannot be explained; what was explained is kept" in output
    assert names("knowledge.explained.db") == {explanation(1).demonstration}


@pytest.mark.usefixtures("folder")
def test_another_label_is_refused_beforehand_and_can_replace() -> None:
    assert run("learn", "one.json")[0] == 0
    facts("corrected", demonstration="one", end={"posture": "Standing"})
    code, output = run("learn", "corrected.json", "two.json")
    assert code == 2
    assert "was learned from already, with another label" in output
    assert "corrected.json: " in output
    assert "forget what knowledge.db holds" in output
    assert not Path("knowledge.explained.db").exists()
    assert names("knowledge.db") == {"one"}, "all or nothing"
    assert run("learn", "corrected.json", "two.json", "--replace")[0] == 0
    assert names("knowledge.db") == {"one", "two"}


def test_where_nothing_can_be_kept_beside_it_is_kept_elsewhere(
    folder: Path, monkeypatch: pytest.MonkeyPatch, server: str
) -> None:
    monkeypatch.setattr(database, "check", lambda *_, **__: None)
    failing(monkeypatch)
    inside = folder / "full"
    inside.mkdir()

    def elsewhere(path: Path, knowledge: Knowledge) -> bool:
        if path.parent == inside:
            raise KnowledgeError("the disk is full", where=path)
        return create(path, knowledge)

    monkeypatch.setattr(database, "create", elsewhere)
    assert going_on(run("learn", "one.json", "-k", str(inside / "k.db"))[1])[1] == "k.explained.db"
    assert names("k.explained.db") == {"one"}
    assert going_on(run("learn", "one.json", "-k", server)[1])[1] == "knowledge.explained.db"


@pytest.mark.usefixtures("folder")
def test_nothing_is_explained_for_knowledge_that_cannot_be_added_to(monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copy(shipped_recordings("give")[0], "handed.mcap")
    monkeypatch.setattr("taskgist.pipeline.explain.explain_all", None)
    os.mkfifo("pipe")
    Path("folder").mkdir()
    Path("birds.db").touch()
    for name, message in {
        "pipe": "pipe: cannot be knowledge: it is a pipe; name a file",
        "folder": "folder: cannot be knowledge: it is a folder; name a file",
        "/dev/null": "/dev/null: cannot be knowledge: it is a device; name a file",
        "nowhere/k.db": "nowhere/k.db: cannot be written: there is no folder 'nowhere'; name a file",
        "birds.db": "birds.db: a database, but not of taskgist",
        "postgresql://localhost:1/x": "the server cannot be reached",
    }.items():
        code, output = run("learn", "handed.mcap", "-k", name)
        assert code == 2
        assert message in output
        code, output = run("explain", "show", "-k", name)
        assert code == 2
        assert message in output or "no such knowledge file" in output
    assert sorted(path.name for path in Path().iterdir() if "explained" in path.name) == []


@pytest.mark.usefixtures("folder")
def test_knowledge_files_are_learned_from() -> None:
    save(Knowledge().add(explanation(1)).answer(ANSWER), "ann.db")
    save(Knowledge().add(explanation(1), explanation(2, "hide")), "bob.db")
    assert run("learn", "ann.db", "bob.db", "one.json")[0] == 0
    assert load("knowledge.db").answers == {ANSWER}
    assert len(load("knowledge.db").explanations) == 3
    other = replace(explanation(3), context=Context("other", "tree"))
    save(Knowledge().add(other), "other.db")
    with pytest.MonkeyPatch.context() as patch:
        failing(patch)
        assert going_on(run("learn", "ann.db", "two.json")[1])[1] == "knowledge.explained.db"
        assert "explained" not in run("learn", "ann.db", "bob.db")[1], "they are files already"
    assert len(load("knowledge.explained.db").explanations) == 2
    code, output = run("learn", "other.db")
    assert code == 2
    assert "other.db: made with settings other, tree tree, while " in output
    with sqlite3.connect("birds.db") as connection:
        connection.execute("CREATE TABLE birds (name TEXT)")
    connection.close()
    assert "birds.db: a database, but not of taskgist" in run("learn", "birds.db")[1]


@pytest.mark.usefixtures("folder")
def test_blanks_around_a_task_and_its_spelling_do_not_matter() -> None:
    facts("party", task="fête", demonstration="party")
    assert run("learn", "party.json", "one.json")[0] == 0
    assert run("explain", " show ")[1] == run("explain", "show")[1]
    assert run("explain", "fe\u0302te")[0] == 0


SECRET = "Geheim7"


@pytest.mark.parametrize("place", ["user", "query"])
@pytest.mark.usefixtures("folder")
def test_no_command_shows_a_password(database: str, place: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The server takes any."""
    secret = (
        database.replace("postgres@", f"postgres:{SECRET}@") if place == "user" else f"{database}&password={SECRET}"
    )
    facts("corrected", demonstration="one", end={"posture": "Standing"})
    said = [
        run("learn", "one.json", "-k", secret),
        run("learn", "two.json", "-k", secret, "--json"),
        run("explain", "-k", secret),
        run("explain", "show", "-k", secret, "--json"),
        run("explain", "show", "-k", secret, "--why", "see.class"),
    ]
    assert [code for code, _ in said] == [0] * 5
    assert "kept in postgresql://postgres" in said[0][1]
    assert "***" in json.loads(said[1][1])["knowledge"]
    refused = [
        run("learn", "corrected.json", "-k", secret),
        run("explain", "shw", "-k", secret),
        run("explain", "show", "-k", secret, "--why", "birds"),
        run("explain", "show", "-k", secret.replace("/test_", "/nothing_")),
        run("learn", "one.json", "-k", secret.replace("/test_", "/nothing_")),
        run("learn", "one.json", "-k", secret.replace("postgres", "bob", 2)),
    ]
    failing(monkeypatch)
    refused.append(run("learn", "three.json", "-k", secret))
    assert [code for code, _ in refused] == [2] * 7
    told = [output for _, output in (*said, *refused)]
    assert not any(SECRET in output for output in told)
