"""``taskgist recognise`` and ``taskgist explain --contrast``: what is told, as text and as documents, and refusals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from taskgist.learning import Knowledge
from taskgist.recording import Label, write
from taskgist.store.database import save
from tests.cli.running import Result, refusal, run, run_json
from tests.learning.learning_samples import STUDY, study
from tests.shipped import excerpt


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Knowledge of the study, a real handover with its label and without, and a file that is none."""
    path = tmp_path_factory.mktemp("recognised")
    known = Knowledge().add(*(each for task in STUDY for each in study(task).explanations.values()))
    save(known, path / "knowledge.db")
    save(Knowledge(), path / "empty.db")
    handover = excerpt("handover_1", 1.2, 4.2)
    assert isinstance(handover.label, Label)
    write(handover, path / "given.mcap")
    (path / "many").mkdir()
    write(handover.with_label(None), path / "many" / "bare.mcap")
    (path / "many" / "broken.mcap").write_bytes(b"\x89MCAP0\r\n")
    return path


@pytest.fixture(autouse=True)
def _inside(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)


def test_a_real_handover_is_recognised_by_what_simulated_ones_taught() -> None:
    document = run_json("recognise given.mcap --contrast give,show")
    (episode,) = document["episodes"]
    assert (episode["best"], episode["labelled"], episode["proposed"]) == ("give", "give", False)
    assert (episode["performing_agent"], episode["target_agent"], episode["target_object"]) == ("P1", "P2", "baton")
    assert not episode["learned_from"]
    probabilities = {each["task"]: each["probability"] for each in episode["tasks"]}
    assert set(probabilities) == set(STUDY)
    assert episode["none"] <= 1.0 - probabilities["give"]
    given = episode["tasks"][0]
    assert given["holds"] is True
    assert any(each["holds"] and each["weight"] > 0 for each in given["literals"])
    assert episode["contrast"]["decided"].startswith("it is like give rather than show: ")
    assert episode["contrast"]["literals"][0]["weight"] > 0


def test_why_tells_what_speaks_for_and_against() -> None:
    text = run("recognise given.mcap --why")
    assert text.startswith("P1, for P2, with baton, 1.60 s to 3.35 s   (labelled give)\n")
    for words in (
        "%  give\n",
        "none of these",
        "what it is about holds",
        "as often in this task as elsewhere",
        "least typical:",
    ):
        assert words in text, words


def test_of_several_a_table_is_printed_and_what_cannot_be_read_stands_there() -> None:
    result = Result("recognise many given.mcap")
    assert result.exit_code == 2
    lines = result.stdout.splitlines()
    assert lines[0].split() == ["file", "for", "with", "start", "end", "recognised", "labelled"]
    assert any("bare.mcap" in line and "give (" in line and "no label" in line for line in lines)
    assert "2 looked at, 1 refused" in lines[-1]
    documents = run_json("recognise many given.mcap", exit_code=2)
    assert [("error" in each) for each in documents] == [False, True, False]
    assert documents[0]["episodes"][0]["proposed"]
    assert documents[0]["episodes"][0]["labelled"] is None


def test_what_cannot_be_compared_for_who_performs_keeps_nobody_from_the_other_tasks(folder: Path) -> None:
    alone = [replace(each, target_agents=("P1",)) for each in study("hide").explanations.values()]
    known = Knowledge().add(*(each for task in STUDY for each in study(task).explanations.values()), *alone)
    save(known, folder / "both.db")
    assert run_json("recognise given.mcap -k both.db") == run_json("recognise given.mcap")
    told = "there is nothing to compare it with; learn another task as well"
    assert told in refusal("recognise given.mcap -k both.db --of performer", folder)
    save(Knowledge().add(*alone), folder / "alone.db")
    assert told in refusal("recognise given.mcap -k alone.db", folder)


def test_what_is_not_there_stands_in_the_table_as_what_cannot_be_read_does() -> None:
    result = Result("recognise given.mcap lost.mcap")
    assert (result.exit_code, result.stderr) == (2, "")
    assert "1 looked at, 1 refused" in result.stdout
    assert "refused: lost.mcap: " in result.stdout
    given, lost = run_json("recognise given.mcap lost.mcap", exit_code=2)
    assert given["episodes"][0]["best"] == "give"
    assert lost["recording"] == "lost.mcap"
    assert "error" in lost


def test_a_contrast_of_two_tasks_is_told_in_words_and_figures() -> None:
    text = run('explain hide --contrast "put away"')
    assert text.startswith(
        "hide or put away?\n  (Nature_Effort_Class_to_See = Not_Supportive)   in 3 of 3 of hide, in 0 of 4"
    )
    assert "seeing the object becomes harder" in text
    assert "where it holds: 8.8 times as likely hide" in text
    document = run_json('explain hide --contrast "put away"')
    assert (document["first"], document["second"], document["of"]) == ("hide", "put away", "target")
    first = document["literals"][0]
    assert (first["in_first"], first["in_second"]) == ({"k": 3, "n": 3}, {"k": 0, "n": 4})
    assert first["weight_if_holds"] > 0 > first["weight_if_fails"]


REFUSED = {
    "recognise given.mcap -k absent.db": "absent.db",
    "recognise given.mcap -k empty.db": "nothing has been learned yet",
    "recognise given.mcap --of performer": "no task is known for who performs",
    "recognise given.mcap --of nobody": "nobody",
    "recognise given.mcap --contrast hide": "not two tasks",
    "recognise given.mcap --contrast hide,hide": "a task has no contrast with itself",
    "recognise given.mcap --contrast hide,hid": "did you mean 'hide'?",
    "recognise given.mcap --at 50% --why": "does not go with --at",
    "recognise given.mcap --at 50% --of performer": "leave out --of, or --at",
    "recognise many given.mcap --why": "tells of one recording",
    "explain hide --contrast give --rule paper": "makes no difference here",
    "explain hide --actions --band wide": "makes no difference here",
    "explain --contrast hide": "of which task?",
    "explain hide --contrast hide": "--contrast",
    "explain hide --contrast give --why see.class": "leave out one of --why and --contrast",
}


@pytest.mark.parametrize("line", REFUSED)
def test_refusals(line: str, folder: Path) -> None:
    assert REFUSED[line] in " ".join(refusal(line, folder).split())
