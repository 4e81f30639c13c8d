"""``taskgist offer``: what is told, as text and as documents, and refusals."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from taskgist.learning import Knowledge
from taskgist.pipeline import shipped_room
from taskgist.recording import write
from taskgist.store.database import save
from tests.cli.running import refusal, run, run_json
from tests.learning.learning_samples import STUDY, study
from tests.shipped import excerpt


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Knowledge of the study, a room, and the part of a real handover in which the taker reaches for the baton."""
    path = tmp_path_factory.mktemp("offered")
    known = Knowledge().add(*(each for task in STUDY for each in study(task).explanations.values()))
    save(known, path / "knowledge.db")
    save(Knowledge(), path / "empty.db")
    for file in ("living_room.toml", "living_room.xml"):
        shutil.copy(shipped_room().parent / file, path / file)
    write(excerpt("handover_2", 0.2, 3.4), path / "handover.mcap")
    return path


@pytest.fixture(autouse=True)
def _inside(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)


def test_what_would_help_is_told_in_sentences() -> None:
    text = run("offer living_room.toml --for P2 --object cup")
    assert text.startswith(
        "P2 wants to reach the cup, which takes leaning forward 29° and stretching out the right arm"
    )
    for words in (
        "  give: would lower that to no effort (level 0), with it in hand\n",
        "  make accessible: would lower that to stretching out an arm at most (level 1)\n",
        "  who could do it: Jido, who grasps it by going ",
    ):
        assert words in text
    assert "hide" not in text


def test_what_the_own_next_act_does_is_told_with_exit_code_1() -> None:
    document = run_json("offer living_room.toml --for P2 --object cup --ability see", exit_code=1)
    (told,) = document["offers"]
    assert (told["level"], told["offered"], told["declined"]) == (0, False, "own act")
    assert (told["tasks"], told["helpers"]) == ([], [])
    assert told["why_not"] == "nothing is offered: P2's own next act does it"


def test_a_taker_who_reaches_out_of_reach_may_be_given_it_by_who_has_it() -> None:
    document = run_json("offer handover.mcap --at 2.25")
    (told,) = document["offers"]
    assert (told["agent"], told["object"], told["behaviour"], told["level"]) == ("P2", "baton", "reaching", 2)
    assert told["tasks"][0]["task"] == "give"
    assert [(each["agent"], each["has_it"]) for each in told["helpers"]] == [("P1", True)]
    label = excerpt("handover_2", 0.2, 3.4).label
    assert label is not None
    share = 100 * (2.25 - label.start_s) / (label.end_s - label.start_s)
    assert run_json(f"offer handover.mcap --at {share}%")["offers"] == [told]
    of_two = "--for P2 --object baton"
    assert run_json(f"offer handover.mcap --at {share}% {of_two}") == run_json(
        f"offer handover.mcap --at 2.25 {of_two}"
    )
    assert run_json("offer handover.mcap --at 2.25 --for P1", exit_code=1)["offers"] == []
    told = run("offer handover.mcap --at 2.25 --for P1", exit_code=1)
    assert told == "P1 is not seen to reach for or walk to a thing\n", "P2 is"


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("living_room.toml --for P2", ("nobody moves in a scene", "--object", "--for P2 --object cup")),
        ("living_room.toml --object cup", ("nobody moves in a scene", "--for")),
        ("living_room.toml --for P7 --object cup", ("no agent 'P7'", "P2")),
        ("living_room.toml --for P2 --object cap", ("no object 'cap'", "cup")),
        ("living_room.toml --for P2 --object cup --ability touch", ("no ability 'touch'", "--ability")),
        ("living_room.toml --for P2 --object cup --rule guess", ("no rule 'guess'", "--rule")),
        ("living_room.toml --for P2 --object cup --at 2", ("a scene has no time", "--at")),
        ("living_room.toml --for P2 --object cup -k empty.db", ("empty.db", "no task is known that is done for")),
        ("handover.mcap", ("--at", "in seconds")),
        ("handover.mcap --at soon", ("handover.mcap: --at: is no time (got 'soon')", "percent from 0% to 100%")),
        ("handover.mcap --at soon --for P2 --object baton", ("--at: is no time (got 'soon')",)),
        ("handover.mcap --at 99", ("--at", "outside of the recording")),
        ("handover.mcap --at 2 --for P9", ("no agent 'P9'",)),
    ],
)
def test_bad_input_is_refused(line: str, words: tuple[str, ...], folder: Path) -> None:
    said = refusal(f"offer {line}", folder)
    for each in words:
        assert each in said
