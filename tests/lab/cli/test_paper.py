"""``taskgist paper``: verdicts, exit codes, documents and files, on values in place of recordings."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from taskgist_lab.paper import Displacements, read_displacements, write_displacements
from tests.cli.running import Result, refusal, run, run_json
from tests.lab.paper.paper_samples import JudgedStudy, judged_study, sample_displacements, undisplaced
from tests.learning.learning_samples import STUDY


@pytest.fixture(autouse=True)
def judged(monkeypatch: pytest.MonkeyPatch) -> JudgedStudy:
    """The study as values; a test may change them. Nothing is shipped."""
    found = judged_study()
    monkeypatch.setattr("taskgist_lab.cli.paper.judge_study", lambda **_: found)
    monkeypatch.setattr("taskgist_lab.cli.paper.shipped_displacements", lambda: None)
    return found


def test_all_results_are_told_and_none_fails() -> None:
    text = run("paper")
    for title in ("The clauses", "Show after 2, 3 and 4", "Table 2", "Table 3", "Table 4", "Smaller trees"):
        assert title in text
    published, goals = text.splitlines()[-2:]
    assert published.endswith("differs, explained; 0 fails")
    assert goals.endswith("0 goal met; 0 not distinguishable; 0 goal not met; 60 not measured")
    assert "Relative_Effort_to_See = Maintained" in text
    assert "Remains_Same" in text
    assert "What does “show” mean: that the object ends in a hand" in text
    assert max(map(len, text.splitlines())) <= 112


def test_the_document_holds_every_result() -> None:
    document = run_json("paper")
    assert [section["name"] for section in document["sections"]] == [
        *("clauses", "draws", "figures", "table_2", "table_3", "table_4", "ablations")
    ]
    assert document["pictures"] == []
    assert document["verdicts"]["fails"] == 0
    (wide,) = (result for result in document["sections"][3]["results"] if result["where"] == "7.3")
    assert wide["ours"] == {"d1": "4/15", "verdict": "confusing"}


def test_a_result_that_fails_gives_exit_code_1(judged: JudgedStudy) -> None:
    judged["hide"] = judged["hide"][:2] + judged["hide"][:1]
    judged["show"] = judged["show"][:3]
    text = run("paper", exit_code=1)
    assert "fails" in text
    assert run_json("paper", exit_code=1)["verdicts"]["fails"] > 0


def test_shipped_draws_are_shown_where_they_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    displacements = sample_displacements(*[(task, undisplaced(task)) for task in STUDY for _ in range(2)])
    monkeypatch.setattr("taskgist_lab.cli.paper.shipped_displacements", lambda: displacements)
    text = run("paper")
    assert "survives 2 displacements" in text
    assert "100.0% (34.2-100.0%)" in text
    assert text.splitlines()[-1].endswith("0 goal met; 60 not distinguishable; 0 goal not met")
    assert "not measured" not in text
    monkeypatch.setattr("taskgist_lab.cli.paper.shipped_displacements", lambda: Displacements("another study"))
    text = run("paper")
    assert "not measured: taskgist paper --displacements 200 (other recordings since the last time)" in text


def test_a_goal_that_is_clearly_missed_gives_exit_code_1(monkeypatch: pytest.MonkeyPatch) -> None:
    show = undisplaced("show")
    unplayed = sample_displacements(*[("show", ("show_a: no way", *show[1:]))] * 9, ("show", show))
    monkeypatch.setattr("taskgist_lab.cli.paper.shipped_displacements", lambda: unplayed)
    assert "goal 95 %: 1 of 10, goal not met; not played: show_a: no way (9 times)" in run("paper", exit_code=1)
    assert run_json("paper", exit_code=1)["verdicts"]["fails"] == 0


def test_displacements_are_measured_and_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def quickly(known: Displacements, count: int, **_: object) -> Iterator[Displacements]:
        for number in range(1, count + 1):
            for task in STUDY:
                if known.count(task) < number:
                    known = known.add(task, undisplaced(task))
                    yield known

    monkeypatch.setattr("taskgist_lab.cli.paper.measure", quickly)
    path = tmp_path / "displacements.json.gz"
    assert "survives 1 displacement " in run(f"paper --displacements 1 --save {path}")
    assert read_displacements(path).count("show") == 1
    assert "survives 3 displacements" in run(f"paper --displacements 3 --save {path}")
    assert read_displacements(path).count("hide away") == 3
    assert "survives 2 displacements" in run("paper --displacements 2")


def test_displacements_of_another_study_are_not_added_to(tmp_path: Path) -> None:
    path = tmp_path / "displacements.json.gz"
    write_displacements(Displacements("another"), path)
    message = refusal(f"paper --displacements 1 --save {path}", tmp_path)
    assert "was measured with other recordings; name another file, or remove this one" in message


def test_pictures_are_saved_where_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("taskgist_lab.cli.paper._pictures", lambda _judged, folder, _progress: (folder / "show_a.png",))
    folder = tmp_path / "pictures"
    assert f"picture: {folder / 'show_a.png'}" in run(f"paper -o {folder}")
    assert run_json(f"paper -o {folder}")["pictures"] == [str(folder / "show_a.png")]


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ("--save {folder}/displacements.json.gz", "--save: there are no new displacements to keep"),
        ("--displacements 1 --save {folder}/no/displacements.json.gz", "there is no folder"),
        ("--displacements 1 --save {folder}", "it is a folder"),
        ("-o {folder}/file/pictures", "--out: cannot be made"),
    ],
)
def test_what_cannot_be_written_is_refused_before_the_work(options: str, told: str, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert told in refusal(f"paper {options.format(folder=tmp_path)}", tmp_path)


@pytest.mark.parametrize("options", ["--displacements 0", "--displacements many", "--displacements 10001"])
def test_misuse_points_to_the_help(options: str) -> None:
    result = Result(f"paper {options}")
    assert (result.exit_code, result.stdout) == (2, "")
    assert "--help" in result.stderr
