"""The demonstrations of the paper's study: six tasks, 23 demonstrations (7.3-7.8)."""

from collections.abc import Mapping

from taskgist.demonstrator.studies import HIDE, SHOW, Demonstration
from taskgist.demonstrator.study.accessible import ACCESSIBLE
from taskgist.demonstrator.study.give import GIVE
from taskgist.demonstrator.study.hiding_away import HIDE_AWAY
from taskgist.demonstrator.study.putting_away import PUT_AWAY

STUDY: Mapping[str, tuple[Demonstration, ...]] = {
    "show": SHOW,
    "hide": HIDE,
    "make accessible": ACCESSIBLE,
    "give": GIVE,
    "put away": PUT_AWAY,
    "hide away": HIDE_AWAY,
}
"""By task, in the paper's order."""

__all__ = ["STUDY"]
