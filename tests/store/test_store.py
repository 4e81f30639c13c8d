"""The store: nothing is lost, nothing foreign is touched, and every refusal says why."""

from __future__ import annotations

import dataclasses
import multiprocessing
import sqlite3
import stat
from collections.abc import Callable
from pathlib import Path

import pytest

from taskgist.errors import KnowledgeError
from taskgist.facts import Episode, Observation
from taskgist.learning import Answer, Context, Explanation, Knowledge, Verdict, explain
from taskgist.store import load, save, tables, update

ANSWER = Answer("show", "see.class", Verdict.RELEVANT, author="ann", time="2024-05-01T12:00:00+00:00", value="x")


def explanation(index: int, task: str = "show", posture: str = "Sitting") -> Explanation:
    start = {"posture": Observation("Sitting", {"thigh_rad": 1.5}), "motion": Observation("Static")}
    end = {"posture": Observation(posture)}
    return explain(Episode(task, f"Vorführung {index}", "P1", "P2", "cup", start, end, source=f"test:{index}"))


KNOWLEDGE = Knowledge().add(explanation(1), explanation(2), explanation(3, "hide")).answer(ANSWER)


def test_what_is_saved_is_loaded(tmp_path: Path) -> None:
    path = tmp_path / "knowledge.db"
    save(KNOWLEDGE, path)
    assert load(path) == KNOWLEDGE
    assert load(path, expected=Context.of()) == KNOWLEDGE
    assert load(f"sqlite:///{path}") == KNOWLEDGE
    assert [each.name for each in tmp_path.iterdir()] == ["knowledge.db"]


def test_saving_replaces(tmp_path: Path) -> None:
    path = tmp_path / "knowledge.db"
    save(KNOWLEDGE, path)
    less = KNOWLEDGE.remove("hide", explanation(3, "hide").digest)
    save(less, path)
    assert load(path) == less


def test_updates_are_unions(tmp_path: Path) -> None:
    path = tmp_path / "knowledge.db"
    assert update(path, [explanation(1)]) == Knowledge().add(explanation(1))
    update(path, [explanation(1), explanation(2)], [ANSWER])
    got = update(path, [explanation(3, "hide")], [ANSWER])
    assert got == load(path) == KNOWLEDGE


def test_a_failed_update_writes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "knowledge.db"
    save(KNOWLEDGE, path)
    contrary = explanation(1, posture="Standing")
    with pytest.raises(KnowledgeError, match="differ at posture"):
        update(path, [explanation(7), contrary])
    with pytest.raises(KnowledgeError, match="under different contexts"):
        update(path, [dataclasses.replace(explanation(7), context=Context("other", "tree"))])
    assert load(path) == KNOWLEDGE

    def failing(_: object) -> dict[str, str]:
        raise RuntimeError("power cut")

    monkeypatch.setattr(tables, "_answer_row", failing)  # after the explanations have been inserted
    other = dataclasses.replace(ANSWER, author="bob")
    with pytest.raises(RuntimeError, match="power cut"):
        update(path, [explanation(8)], [other])
    with pytest.raises(RuntimeError, match="power cut"):
        save(KNOWLEDGE.add(explanation(8)), path)
    with pytest.raises(RuntimeError, match="power cut"):
        save(KNOWLEDGE, tmp_path / "new.db")
    assert load(path) == KNOWLEDGE
    assert [each.name for each in tmp_path.iterdir()] == ["knowledge.db"]


def test_mixing_is_kept_where_it_was_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "knowledge.db"
    other = dataclasses.replace(explanation(2), context=Context("other", "tree"))
    update(path, [explanation(1)])
    update(path, [other], allow_mixed=True)
    assert load(path).contexts == {Context.of(), Context("other", "tree")}


def test_knowledge_of_another_context_is_refused_with_both_named(tmp_path: Path) -> None:
    path = tmp_path / "knowledge.db"
    save(KNOWLEDGE, path)
    with pytest.raises(KnowledgeError) as caught:
        load(path, expected=Context("mine", "tree"))
    text = str(caught.value)
    assert text.startswith(f"{path}: made with {Context.of()}, while settings mine, tree tree is in use; ")
    assert "learn anew" in text


def foreign(path: Path) -> None:
    with sqlite3.connect(path) as connection:
        connection.execute("CREATE TABLE birds (name TEXT)")
    connection.close()


def changed(path: Path, statement: str) -> None:
    save(KNOWLEDGE, path)
    with sqlite3.connect(path) as connection:
        connection.execute(statement)
    connection.close()


def truncated(path: Path) -> None:
    save(KNOWLEDGE, path)
    path.write_bytes(path.read_bytes()[:5000])


DAMAGE: dict[str, tuple[Callable[[Path], object], str]] = {
    "missing": (lambda path: path.unlink(missing_ok=True), "no such knowledge file; learn something first"),
    "no database": (lambda path: path.write_text("give me the mug\n" * 99), "cannot be used as knowledge"),
    "empty": (lambda path: path.write_bytes(b""), "a database, but not of taskgist"),
    "foreign": (foreign, "a database, but not of taskgist"),
    "truncated": (truncated, "cannot be used as knowledge"),
    "folder": (lambda path: path.mkdir(), "no such knowledge file"),
    "newer": (
        lambda path: changed(path, "UPDATE taskgist_properties SET value = '99'"),
        "schema: another version of the tables (got '99'); this release reads version 1",
    ),
    "bad text": (lambda path: changed(path, "UPDATE taskgist_explanations SET document = '{'"), "damaged document"),
    "bad digest": (
        lambda path: changed(path, "UPDATE taskgist_explanations SET document = replace(document, 'P2', 'P3')"),
        "digest: damaged explanation",
    ),
    "bad answer": (lambda path: changed(path, "UPDATE taskgist_answers SET document = '{}'"), "not an answer"),
    "lost table": (lambda path: changed(path, "DROP TABLE taskgist_answers"), "cannot be used as knowledge"),
}


@pytest.mark.parametrize("kind", DAMAGE)
def test_what_is_no_knowledge_is_refused_and_left_as_it_is(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "knowledge.db"
    damage, message = DAMAGE[kind]
    damage(path)
    before = path.read_bytes() if path.is_file() else None
    with pytest.raises(KnowledgeError) as caught:
        load(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert message in str(caught.value)
    if before is not None:
        with pytest.raises(KnowledgeError):
            update(path, [explanation(9)])
        assert path.read_bytes() == before
    else:
        assert not path.is_file()


def test_a_foreign_file_is_not_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "birds.db"
    foreign(path)
    before = path.read_bytes()
    with pytest.raises(KnowledgeError, match="not of taskgist"):
        save(KNOWLEDGE, path)
    assert path.read_bytes() == before


def test_a_read_only_file_can_be_read(tmp_path: Path) -> None:
    path = tmp_path / "knowledge.db"
    save(KNOWLEDGE, path)
    path.chmod(stat.S_IRUSR)
    assert load(path) == KNOWLEDGE


def test_unusable_addresses(tmp_path: Path) -> None:
    with pytest.raises(KnowledgeError, match="cannot be written: No such file or directory; choose a folder"):
        save(KNOWLEDGE, tmp_path / "nowhere" / "knowledge.db")
    with pytest.raises(KnowledgeError, match="would not last"):
        save(KNOWLEDGE, "sqlite://")
    with pytest.raises(KnowledgeError, match="no driver"):
        load("nosuchdatabase://user:secret@host/name")
    with pytest.raises(KnowledgeError) as caught:
        load("postgresql://user:secret@localhost:1/name")
    assert "secret" not in str(caught.value)


def _add(path: str, index: int) -> None:
    update(path, [explanation(index)])


def test_many_may_add_at_once(tmp_path: Path) -> None:
    path = tmp_path / "knowledge.db"
    context = multiprocessing.get_context("spawn")
    with context.Pool(3) as pool:
        pool.starmap(_add, [(str(path), index) for index in range(12)])
    assert load(path) == Knowledge().add(*(explanation(index) for index in range(12)))
