"""All ways, by task."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from taskgist.demonstrator.generator.dropping import DROP
from taskgist.demonstrator.generator.dumping import DUMP
from taskgist.demonstrator.generator.giving import GIVE
from taskgist.demonstrator.generator.hiding import HIDE
from taskgist.demonstrator.generator.hiding_away import HIDE_AWAY
from taskgist.demonstrator.generator.lifting import LIFT
from taskgist.demonstrator.generator.making_accessible import MAKE_ACCESSIBLE
from taskgist.demonstrator.generator.putting_away import PUT_AWAY
from taskgist.demonstrator.generator.showing import SHOW
from taskgist.demonstrator.generator.tapping import TAP
from taskgist.demonstrator.generator.throwing import THROW
from taskgist.demonstrator.generator.way import Way
from taskgist.errors import UnknownNameError

ALL = (SHOW, HIDE, MAKE_ACCESSIBLE, GIVE, PUT_AWAY, HIDE_AWAY, LIFT, TAP, DROP, DUMP, THROW)
WAYS: Mapping[str, tuple[Way, ...]] = MappingProxyType({ways[0].task: ways for ways in ALL})
"""The ways of each task."""
TASKS = tuple(WAYS)
"""Names of the tasks, in order."""


def ways_of(task: str, means: str | None = None) -> tuple[Way, ...]:
    """The ways of a task; the one of that name, where one is given.

    Raises:
        UnknownNameError: There is no such task, or it has no such means.
    """
    if task not in WAYS:
        raise UnknownNameError("task", task, WAYS)
    if means is None:
        return WAYS[task]
    by_name = {way.name: way for way in WAYS[task]}
    if means not in by_name:
        raise UnknownNameError(f"means to {task}", means, by_name)
    return (by_name[means],)
