"""The store: nothing is lost, nothing foreign is touched, and every refusal says why."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest
from sqlalchemy import StaticPool, create_engine

from taskgist.errors import KnowledgeError
from taskgist.facts import Episode, Observation
from taskgist.learning import Answer, Context, Explanation, Knowledge, Verdict, explain, merged
from taskgist.store import load, save, tables, update

ANSWER = Answer("show", "see.class", Verdict.RELEVANT, author="ann", time="2024-05-01T12:00:00+00:00", value="x")


def explanation(index: int, task: str = "show", posture: str = "Sitting") -> Explanation:
    start = {"posture": Observation("Sitting", {"thigh_rad": 1.5}), "motion": Observation("Static")}
    end = {"posture": Observation(posture)}
    return explain(Episode(task, f"Vorführung {index}", "P1", "P2", "cup", start, end, source=f"test:{index}"))


KNOWLEDGE = Knowledge().add(explanation(1), explanation(2), explanation(3, "hide")).answer(ANSWER)


def test_what_is_saved_is_loaded(address: str) -> None:
    save(KNOWLEDGE, address)
    assert load(address) == KNOWLEDGE
    assert load(address, expected=Context.of()) == KNOWLEDGE
    less = KNOWLEDGE.remove("hide", explanation(3, "hide").digest)
    save(less, address)
    assert load(address) == less, "saving replaces"


def test_a_file_is_alone_in_its_folder_and_has_a_url(tmp_path: Path) -> None:
    path = tmp_path / "knowledge.db"
    save(KNOWLEDGE, path)
    update(path, [explanation(7)])
    assert [each.name for each in tmp_path.iterdir()] == ["knowledge.db"]
    assert load(f"sqlite:///{path}") == load(path)


def test_one_task_can_be_loaded_alone(address: str) -> None:
    save(KNOWLEDGE, address)
    assert load(address, tasks=["hide"]).tasks == ("hide",)
    assert load(address, tasks=["hide", "give"]).experience("hide") == KNOWLEDGE.experience("hide")
    assert load(address, tasks=[]).tasks == ()
    assert load(address, tasks=["hide"]).answers == {ANSWER}


def test_without_evidence_all_facts_are_there_and_nothing_can_be_saved(address: str, tmp_path: Path) -> None:
    two = replace_target(explanation(5, "give"), "P3")
    whole = merged([explanation(5, "give"), two])
    save(KNOWLEDGE.add(whole), address)
    bare = load(address, evidence=False)
    assert [each.values for each in bare.explanations] == [each.values for each in load(address).explanations]
    assert [each.digest for each in bare.explanations] == [each.digest for each in load(address).explanations]
    assert bare.answers == {ANSWER}
    assert not [node for each in bare.explanations for node in each.nodes.values() if node.evidence]
    assert not [
        node for each in bare.explanations for one in each.parts for node in one.nodes.values() if node.evidence
    ]
    with pytest.raises(KnowledgeError, match=r"its evidence was left aside; load it with its evidence"):
        save(bare, tmp_path / "bare.db")
    with pytest.raises(KnowledgeError, match="its evidence was left aside"):
        update(address, [dataclasses.replace(each, source="another") for each in bare.explanations])
    assert load(address) == KNOWLEDGE.add(whole)


def replace_target(each: Explanation, agent: str) -> Explanation:
    return dataclasses.replace(each, target_agents=(agent,))


def test_updates_are_unions(address: str) -> None:
    update(address, [explanation(1)])
    assert load(address) == Knowledge().add(explanation(1))
    update(address, [explanation(1), explanation(2)], [ANSWER])
    update(address, [explanation(3, "hide")], [ANSWER])
    assert load(address) == KNOWLEDGE
    update(address, forget=[explanation(2).digest])
    assert load(address) == KNOWLEDGE.remove("show", explanation(2).digest)


def test_which_of_two_copies_stays_does_not_depend_on_the_order(address: str, tmp_path: Path) -> None:
    one = explanation(1)
    other = dataclasses.replace(one, demonstration="another name")
    update(address, [one])
    update(address, [other])
    update(tmp_path / "turned.db", [other])
    update(tmp_path / "turned.db", [one])
    assert load(address) == load(tmp_path / "turned.db") == Knowledge().add(one, other)


def relabelled(index: int, end_s: float, task: str = "show", object_: str = "cup") -> Explanation:
    source = f"recording{index} 0.0000-{end_s:.4f} s"
    return dataclasses.replace(explanation(index), task=task, source=source, target_objects=(object_,))


def told(source: str, task: str = "show") -> Explanation:
    return dataclasses.replace(explanation(4), task=task, source=f"facts:{source}")


def of_two(index: int, end_s: float) -> Explanation:
    """A recording that is about two things at once."""
    return merged([relabelled(index, end_s), relabelled(index, end_s, object_="box")])


KNOWN = [
    relabelled(1, 2.0),
    relabelled(2, 2.0),
    relabelled(2, 2.0, object_="box"),
    explanation(1),
    told("a"),
    of_two(5, 2.0),
]
CANDIDATES = {
    "known": (relabelled(1, 2.0), 0),
    "other times": (relabelled(1, 2.5), 1),
    "another task": (relabelled(1, 2.0, "hide"), 1),
    "one of two objects": (relabelled(2, 2.5), 1),
    "another object": (relabelled(1, 2.5, object_="box"), 0),
    "another recording": (relabelled(3, 2.0), 0),
    "one of several": (relabelled(5, 2.0, object_="box"), 1),
    "several, one of them known": (of_two(1, 2.0), 1),
    "several, both known": (of_two(2, 2.0), 2),
    "several again": (of_two(5, 2.0), 0),
    "none of several": (relabelled(5, 2.0, object_="book"), 0),
    "corrected facts": (told("b"), 1),
    "facts of another task": (told("b", "hide"), 0),
}


@pytest.mark.parametrize("kind", CANDIDATES)
def test_a_recording_under_another_label_is_told_from_others(address: str, kind: str) -> None:
    """The store's question to its index is that of ``Knowledge.rivals``, which looks at everything."""
    added, count = CANDIDATES[kind]
    save(Knowledge().add(*KNOWN), address)
    rivals = Knowledge().add(*KNOWN).rivals(added)
    assert len(rivals) == count
    if count:
        with pytest.raises(KnowledgeError, match="learned from already, with another label"):
            update(address, [explanation(9), added], relabelled="refuse")
        assert load(address) == Knowledge().add(*KNOWN)
    else:
        update(address, [added], relabelled="refuse")
    update(address, [added], relabelled="replace")
    assert set(load(address).explanations) == {*KNOWN, added} - set(rivals)
    update(address, KNOWN)
    assert set(load(address).explanations) == {*KNOWN, added}, "who does not ask counts both"


def test_two_labels_of_one_recording_at_once_are_refused_as_one_after_the_other(tmp_path: Path) -> None:
    path = tmp_path / "knowledge.db"
    both = [relabelled(1, 2.0), relabelled(1, 2.5)]
    ways: tuple[tables.Relabelled, ...] = ("refuse", "replace")
    for way in ways:
        with pytest.raises(KnowledgeError, match="the same recording as 'Vorführung 1', with another label"):
            update(path, both, relabelled=way)
    assert not path.exists()
    update(path, both)
    assert len(load(path).explanations) == 2, "who does not ask counts both"


@pytest.mark.parametrize("many", [10, 300])
def test_an_addition_reads_only_what_it_needs(address: str, many: int) -> None:
    """The same few rows, whatever else is there."""
    save(Knowledge().add(*(relabelled(index, 1.0) for index in range(many))), address)
    looked_at: list[str] = []
    found = tables.explanation_of

    def counted(row: tables.Fetched, where: str) -> Explanation:
        looked_at.append(row["digest"])
        return found(row, where)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tables, "explanation_of", counted)
        update(address, [relabelled(0, 1.0), relabelled(1, 2.0)], relabelled="replace")
    assert len(looked_at) == 4, "those of the same recordings, the same demonstration again, one for the context"
    assert len(load(address).explanations) == many


def test_databases_of_other_kinds_get_plain_sql(monkeypatch: pytest.MonkeyPatch) -> None:
    engine = create_engine("sqlite://", poolclass=StaticPool)
    monkeypatch.setattr(engine.dialect, "name", "birds")
    with engine.begin() as connection:
        tables.create(connection)
        tables.write(connection, Knowledge().add(explanation(1)).answer(ANSWER))
        tables.add(connection, KNOWLEDGE, "here")
        tables.add(connection, KNOWLEDGE, "here")
        assert tables.knowledge(*tables.rows(connection, "here"), "here") == KNOWLEDGE


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

    monkeypatch.setattr(tables, "answer_row", failing)  # after the explanations have been inserted
    other = dataclasses.replace(ANSWER, author="bob")
    with pytest.raises(RuntimeError, match="power cut"):
        update(path, [explanation(8)], [other])
    with pytest.raises(RuntimeError, match="power cut"):
        save(KNOWLEDGE.add(explanation(8)), path)
    with pytest.raises(RuntimeError, match="power cut"):
        save(KNOWLEDGE, tmp_path / "new.db")
    monkeypatch.undo()
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
