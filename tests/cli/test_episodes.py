"""``taskgist recognise`` of recordings without a label, and of tasks that are under way (``--at``)."""

from __future__ import annotations

from pathlib import Path

import pytest

from taskgist.cli.common import moment_s
from taskgist.errors import InputError
from taskgist.learning import Knowledge
from taskgist.recording import write
from taskgist.store.database import save
from tests.cli.running import refusal, run, run_json
from tests.learning.learning_samples import STUDY, study
from tests.pipeline.small import small
from tests.shipped import excerpt, recording


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Knowledge of the study, a handover with its label and without, and a recording in which nothing happens."""
    path = tmp_path_factory.mktemp("episodes")
    save(
        Knowledge().add(*(each for task in STUDY for each in study(task).explanations.values())), path / "knowledge.db"
    )
    write(excerpt("handover_1", 1.2, 4.2), path / "given.mcap")
    write(recording("handover_1").with_label(None), path / "bare.mcap")
    write(small(label=None), path / "still.mcap")
    return path


@pytest.fixture(autouse=True)
def _inside(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)


def test_a_recording_without_a_label_becomes_a_list() -> None:
    lines = run("recognise bare.mcap").splitlines()
    assert lines[0].split()[:7] == ["1.6-3.3", "s", "P1", "for", "P2", "with", "baton"]
    assert "give (" in lines[0]
    assert lines[1].split()[:7] == ["3.3-5.9", "s", "P2", "for", "P1", "with", "baton"]
    given, _ = run_json("recognise bare.mcap")["episodes"]
    assert (given["best"], given["proposed"], given["labelled"]) == ("give", True, None)


def test_with_episodes_a_label_is_left_aside() -> None:
    found = run_json("recognise given.mcap --episodes")["episodes"]
    assert {each["proposed"] for each in found} == {True}
    assert found[0]["best"] == "give"


def test_where_nothing_happens_nothing_is_recognised() -> None:
    assert run("recognise still.mcap", exit_code=1) == "nothing is handled here\n"
    document = run_json("recognise still.mcap", exit_code=1)
    assert (document["episodes"], document["untracked_hands"]) == ([], [])


def test_where_hands_are_not_tracked_that_is_told() -> None:
    write(recording("handover_5").with_label(None), Path("unseen.mcap"))
    told = "nothing is handled here by hands that are tracked; P1's right hand and P2's right hand are not"
    assert run("recognise unseen.mcap", exit_code=1) == f"{told}\n"
    assert told in run("recognise unseen.mcap still.mcap", exit_code=1)
    document = run_json("recognise unseen.mcap", exit_code=1)
    assert document["episodes"] == []
    assert document["untracked_hands"] == [{"agent": agent, "side": "right"} for agent in ("P1", "P2")]


def test_what_is_under_way_is_told_with_what_is_missing() -> None:
    early = run_json("recognise given.mcap --at 60%", exit_code=1)
    late = run_json("recognise given.mcap --at 100%")
    assert early["at_s"] < late["at_s"]
    (before,), (after,) = early["under_way"], late["under_way"]
    assert (before["performing_agent"], before["target_agent"], before["target_object"]) == ("P1", "P2", "baton")
    given = [{each["task"]: each["probability"] for each in one["tasks"]}["give"] for one in (before, after)]
    assert given[0] < given[1]
    assert before["best"] is None, "people hand over faster than the cases do"
    assert [each["text"] for each in before["missing"]] == ["(Nature_Hand_Status = Manip_Desired)"]
    assert after["best"] == "give"
    text = run("recognise given.mcap --at 100%")
    assert "it will be 'give' (" in text


REFUSED = {
    "given.mcap --at soon": "--at: is no time (got 'soon'); give seconds, such as 4.5, or percent from 0% to 100%",
    "given.mcap --at 120%": "--at: is no time (got '120%')",
    "given.mcap --at 1.3": "--at: nothing has begun yet (got 1.3); ask for a time after",
    "given.mcap --at 1.2": "--at: nothing has begun yet (got 1.2); ask for a time after",
    "given.mcap --at 99": "--at: the time is outside of the recording (got 99",
    "given.mcap bare.mcap --at 1": "--at: asks about one recording (got 2); name one",
    "still.mcap --at 50%": "--at: nothing is handled yet",
}


@pytest.mark.parametrize("line", REFUSED)
def test_refusals(line: str, folder: Path) -> None:
    assert REFUSED[line] in refusal(f"recognise {line}", folder)


def test_percent_are_those_of_the_label_or_else_of_the_recording() -> None:
    labelled = small()
    assert moment_s(labelled, "50%") == pytest.approx(0.5)
    assert moment_s(labelled, "25 %") == pytest.approx(0.35)
    assert moment_s(labelled.with_label(None), "50%") == pytest.approx(0.5)
    assert moment_s(labelled, "0.7") == 0.7
    with pytest.raises(InputError, match="is no time"):
        moment_s(labelled, "nan")
