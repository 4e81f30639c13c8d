"""Intentions: which tasks a demonstration fulfils, whatever it was played as.

Who hides something away hides it, and who makes accessible what nobody saw shows it. So a demonstration fulfils the
task that it was played as, and with it every task of the paper whose own check it passes: those of the outcomes, by
straight lines and distances alone. Facts have no say, because they are what is judged.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from taskgist.errors import SceneError
from taskgist.recording.recording import Recording
from taskgist_lab.generator.outcomes import check_before_eyes, check_comes_into_view, check_turned_to_eyes
from taskgist_lab.generator.reaching import check_accessible, check_given
from taskgist_lab.generator.tasks_that_remove import (
    check_away_and_hidden,
    check_away_in_view,
    check_from_view_to_hidden,
)
from taskgist_lab.generator.way import Check


def fulfilled(recording: Recording) -> tuple[str, ...]:
    """The tasks of a labelled recording: its own, and each one whose check it passes; sorted."""
    assert recording.label is not None
    return tuple(sorted({recording.label.task} | {task for task, check in CHECKS.items() if _passes(check, recording)}))


def _passes(check: Check, recording: Recording) -> bool:
    try:
        check(recording)
    except SceneError:
        return False
    return True


def check_shows(recording: Recording) -> None:
    """Refuse a demonstration in which the thing neither comes into view, nor before the eyes, nor turns to them.

    Raises:
        SceneError: So it is.
    """
    if not _passes(check_comes_into_view, recording) and not _passes(check_before_eyes, recording):
        check_turned_to_eyes(recording)


CHECKS: Mapping[str, Check] = MappingProxyType(
    {
        "show": check_shows,
        "hide": check_from_view_to_hidden,
        "make accessible": check_accessible,
        "give": check_given,
        "put away": check_away_in_view,
        "hide away": check_away_and_hidden,
    }
)
"""What each task of the paper is, by geometry."""
