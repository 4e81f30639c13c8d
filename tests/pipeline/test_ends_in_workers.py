"""Explaining on several cores: the same explanations in the same order, the same errors, progress from the parent."""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from taskgist.common.workers import cores, in_order
from taskgist.errors import LabelError, RecordingError, WorkerError
from taskgist.facts import Predicate, predicate_subtree
from taskgist.pipeline import explain_all
from taskgist.recording import Recording, read, write
from tests.pipeline.small import small

COUNT = 5
forked = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="processes are forked on Linux only")


@pytest.fixture(scope="module")
def paths(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Files of seconds in which nothing happens, each with a name and a label of its own."""
    still, folder = small(), tmp_path_factory.mktemp("still")
    assert still.label is not None
    for number in range(COUNT):
        label = replace(still.label, end_s=0.5 + number / 10)
        name = f"small_{number}"
        write(replace(still, label=label, name=name), folder / f"{name}.mcap")
    return sorted(folder.iterdir())


@pytest.fixture(scope="module")
def several(paths: list[Path]) -> list[Recording]:
    """What is in these files."""
    return [read(path) for path in paths]


def squared(number: int) -> int:
    if number == 5:
        raise RecordingError("no fives", where="there", field="number", value=number, hint="give another")
    return number * number


@pytest.mark.parametrize("processes", [1, 2, 3])
def test_results_come_in_order(processes: int) -> None:
    assert [*in_order(squared, 5, processes)] == [0, 1, 4, 9, 16]
    assert [*in_order(squared, 0, processes)] == []


@pytest.mark.parametrize("processes", [1, 2])
def test_an_error_comes_in_its_place_and_whole(processes: int) -> None:
    results = in_order(squared, 9, processes)
    assert [next(results) for _ in range(5)] == [0, 1, 4, 9, 16]
    with pytest.raises(RecordingError, match=r"there: number: no fives \(got 5\); give another"):
        next(results)


@forked
def test_a_worker_that_dies_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _process: {0, 1})
    with pytest.raises(WorkerError, match="a worker ended before its work was done; fewer processes"):
        [*in_order(lambda _number: os._exit(1), 3, 2)]


@forked
def test_workers_are_other_processes_and_start_none_of_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _process: {0, 1})
    found = [*in_order(lambda _number: (os.getpid(), cores()), 6, 2)]
    assert cores() == 2
    assert os.getpid() not in {process for process, _ in found}
    assert {count for _, count in found} == {1}


@pytest.mark.parametrize("processes", [1, 2])
def test_explanations_come_in_order_from_recordings_and_from_their_files(
    several: list[Recording], paths: list[Path], processes: int
) -> None:
    told: list[tuple[str, float]] = []
    explained = [*explain_all(several, processes=processes, progress=lambda *news: told.append(news))]
    assert [each.demonstration for each in explained] == [each.name for each in several]
    assert [*explain_all(paths, processes=processes)] == explained == [*explain_all(several)]
    shares = [share for _, share in told]
    assert shares == sorted(shares)
    assert told[-1] == ("done", 1.0)
    assert {what.partition(":")[0] for what, _ in told} == {*(each.name for each in several), "done"}


@pytest.mark.parametrize("processes", [1, 2])
def test_own_predicates_need_not_bear_pickling(several: list[Recording], processes: int) -> None:
    late = Predicate(predicate_subtree("late"), lambda stage, _agent, _name: stage.state.time_s > 0.65)
    explained = explain_all(several, predicates=[late], processes=processes)
    assert [each.nodes["late.value.2"].value for each in explained] == ["False", "False", "True", "True", "True"]


@pytest.mark.parametrize("processes", [1, 2])
def test_a_recording_without_a_label_is_refused_when_it_is_its_turn(several: list[Recording], processes: int) -> None:
    explained = explain_all([*several[:2], replace(several[2], label=None), several[3]], processes=processes)
    assert [next(explained).demonstration for _ in range(2)] == ["small_0", "small_1"]
    with pytest.raises(LabelError, match=r"^small_2: the recording has no label; set one: taskgist label"):
        next(explained)


def test_a_file_without_a_label_is_named(several: list[Recording], tmp_path: Path) -> None:
    path = tmp_path / "unlabelled.mcap"
    write(replace(several[0], label=None), path)
    with pytest.raises(LabelError, match=f"^{path}: the recording has no label"):
        [*explain_all([path])]
