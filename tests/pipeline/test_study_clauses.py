"""What the demonstrations of the paper's study teach; they are shipped, and watched like any other recordings."""

from __future__ import annotations

import numpy as np
import pytest

from taskgist.learning import Knowledge, clause_of
from taskgist.pipeline import shipped_recordings, shipped_study
from taskgist.pipeline.shipped import TASKS
from taskgist_lab.paper import STUDY
from tests import shipped
from tests.learning.test_paper_clauses import CLAUSES, predicates

COUNTS = {"show": 4, "hide": 3, "make accessible": 5, "give": 3, "put away": 4, "hide away": 4}
"""As many as in the paper."""
ROUNDING = 1e-4
"""Files keep tenths of a millimetre."""


def test_the_study_has_as_many_demonstrations_as_the_papers() -> None:
    assert {task: len(demonstrations) for task, demonstrations in STUDY.items()} == COUNTS
    names = [each.name for demonstrations in STUDY.values() for each in demonstrations]
    assert len(set(names)) == sum(COUNTS.values()) == 23


def test_all_of_it_is_shipped_in_order() -> None:
    assert tuple(STUDY) == TASKS
    names = {task: tuple(each.name for each in demonstrations) for task, demonstrations in STUDY.items()}
    assert names == shipped.STUDY
    for task, paths in shipped_study().items():
        labels = [shipped.label(path.stem) for path in paths]
        assert {label.task for label in labels} == {task}
        assert all(shipped.recording(path.stem).provenance.simulated for path in paths)
        if task != "give":
            assert shipped_recordings(task) == paths


@pytest.mark.parametrize(("task", "index"), [("show", 0), ("give", 2), ("put away", 1)])
def test_the_files_are_what_the_demonstrators_do(task: str, index: int) -> None:
    again = STUDY[task][index].record(0)
    file = shipped.recording(again.name)
    assert again.label == file.label
    assert again.times_s == pytest.approx(file.times_s)
    assert np.abs(again.qpos - file.qpos).max() < ROUNDING


@pytest.mark.parametrize("task", COUNTS)
def test_each_task_teaches_the_papers_clause(task: str) -> None:
    """Eq. 37 to 42, predicate by predicate."""
    known = Knowledge().add(*(shipped.explanation(name) for name in shipped.STUDY[task]))
    assert predicates(clause_of(known.understand(task))) == CLAUSES[task]
