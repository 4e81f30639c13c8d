"""Perspective: what an agent sees, reaches and grasps, now and after virtual actions, with what effort (5.1)."""

from taskgist.perspective.acting.constraints import Blocking
from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.acting.virtual_actions import NO_ACTION, NO_KNOWN_ACTION, Amount, actions_of
from taskgist.perspective.effort import ABILITIES, EFFORT_NAMES, NO_KNOWN_LEVEL, Ability, Effort
from taskgist.perspective.least_effort import able, effort_from, least_effort
from taskgist.perspective.queries.asking import actions_for, objects_with
from taskgist.perspective.seeing.image import View, view_of
from taskgist.perspective.seeing.visibility import Visibility, visibility, visibility_from

__all__ = [
    "ABILITIES",
    "EFFORT_NAMES",
    "NO_ACTION",
    "NO_KNOWN_ACTION",
    "NO_KNOWN_LEVEL",
    "Ability",
    "Amount",
    "Blocking",
    "Effort",
    "Standpoint",
    "View",
    "Visibility",
    "able",
    "actions_for",
    "actions_of",
    "effort_from",
    "least_effort",
    "objects_with",
    "view_of",
    "visibility",
    "visibility_from",
]
