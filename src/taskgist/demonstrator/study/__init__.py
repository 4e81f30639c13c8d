"""The demonstrations of the paper's study: six tasks, 23 demonstrations (7.3-7.8).

The paper tells who sits, what is shown, how each demonstration ends, and that arrangements differ; sizes and places are
ours. What differs between the demonstrations is staged by geometry: how far from the target agent the object begins
and ends, what stands in the line of sight, whether a table over the thighs keeps somebody from standing up, what the
target agent looks at before.
"""

from collections.abc import Mapping

from taskgist.demonstrator.study.demonstration import Demonstration
from taskgist.demonstrator.study.giving import GIVE
from taskgist.demonstrator.study.hiding import HIDE
from taskgist.demonstrator.study.hiding_away import HIDE_AWAY
from taskgist.demonstrator.study.making_accessible import ACCESSIBLE
from taskgist.demonstrator.study.putting_away import PUT_AWAY
from taskgist.demonstrator.study.showing import SHOW

STUDY: Mapping[str, tuple[Demonstration, ...]] = {
    "show": SHOW,
    "hide": HIDE,
    "make accessible": ACCESSIBLE,
    "give": GIVE,
    "put away": PUT_AWAY,
    "hide away": HIDE_AWAY,
}
"""By task, in the paper's order."""

__all__ = ["STUDY", "Demonstration"]
