"""The study as values in place of recordings: judged in no time, and changed at will."""

from __future__ import annotations

from functools import cache

from taskgist.facts import STANDARD_TREE
from taskgist_lab.paper import Displacements, Judged, digest_of
from taskgist_lab.paper.displacements import Displacement
from tests.learning.learning_samples import STUDY, study

JudgedStudy = dict[str, tuple[Judged, ...]]


@cache
def _judged(task: str) -> tuple[Judged, ...]:
    explanations = study(task).explanations.values()
    return tuple(
        Judged(explanation, f"{task} {number}", length_s=6.0, seconds=0.1, perspective_seconds=0.02)
        for number, explanation in enumerate(explanations)
    )


def judged_study() -> JudgedStudy:
    """All six tasks as the paper would have them."""
    return {task: _judged(task) for task in STUDY}


def undisplaced(task: str) -> Displacement:
    """What the demonstrations of a task would give if nothing had been moved."""
    return tuple(
        tuple(each.explanation.nodes[node.name].value for node in STANDARD_TREE.nodes) for each in _judged(task)
    )


def sample_displacements(*displacements: tuple[str, Displacement]) -> Displacements:
    """These displacements, of the study above."""
    gathered = Displacements(digest_of(judged_study()))
    for task, displacement in displacements:
        gathered = gathered.add(task, displacement)
    return gathered
