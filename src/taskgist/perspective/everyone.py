"""All efforts of a scene: every agent, every object, every ability; from nothing, or following a tracker.

A ``Follower`` is shown one state after another and answers as if each were the first, but it only asks anew what may
have changed: all of an agent that moved, all about an object that moved, and those answers in whose region something
moved. The region of an answer holds all that was looked through, felt for or walked over to find it::

    follower = Follower(scene)
    for state in tracker:
        efforts = follower.update(state)
        efforts["P2", "cup", "see"].level
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.effort import ABILITIES, Ability, Effort
from taskgist.perspective.least_effort import effort_from
from taskgist.perspective.region import touched
from taskgist.perspective.standpoint import Standpoint
from taskgist.settings import DEFAULT, Settings
from taskgist.world import Scene, Stage, State

Array = NDArray[np.float64]
Question = tuple[str, str, Ability]
"""Agent, object and ability."""


def all_efforts(stage: Stage, settings: Settings = DEFAULT) -> dict[Question, Effort]:
    """The least effort of every agent for every object, to see, to reach and to grasp it.

    Args:
        stage: The scene in a state.
        settings: All settings.
    """
    efforts: dict[Question, Effort] = {}
    for agent in stage.scene.agents:
        here = Standpoint(stage, agent, settings)
        for name in stage.scene.objects:
            for ability in ABILITIES:
                efforts[agent, name, ability] = effort_from(here, name, ability)
    return efforts


class Follower:
    """Keeps the efforts of all agents for all objects while a scene moves.

    Args:
        scene: The scene whose states it will be shown.
        settings: All settings.
        abilities: Which abilities to follow.
    """

    def __init__(self, scene: Scene, settings: Settings = DEFAULT, *, abilities: Iterable[Ability] = ABILITIES) -> None:
        self._stage, self._settings = Stage(scene), settings
        self._questions: list[Question] = [
            (agent, name, ability) for agent in scene.agents for name in scene.objects for ability in abilities
        ]
        self._row = {question: row for row, question in enumerate(self._questions)}
        self._regions = np.full((len(self._questions), 2, 3), np.nan)
        self._efforts: dict[Question, Effort] = {}
        self._last: State | None = None
        self._places: tuple[Array, Array] = (np.empty((0, 3)), np.empty((0, 9)))
        self.asked_count = 0

    def update(self, state: State) -> Mapping[Question, Effort]:
        """The efforts in a state; those that cannot have changed since the last one are taken over.

        Args:
            state: The next state, of the same scene.

        Returns:
            Efforts by agent, object and ability: what ``all_efforts`` would give.
        """
        self._stage.show(state)
        stale = self._stale(state)
        for agent in self._stage.scene.agents:
            questions = [question for question in stale if question[0] == agent]
            if questions:
                self._ask(Standpoint(self._stage.show(state), agent, self._settings), questions)
        self._last = state
        self.asked_count = len(stale)
        return MappingProxyType(dict(self._efforts))

    def _ask(self, here: Standpoint, questions: list[Question]) -> None:
        for question in questions:
            self._efforts[question] = effort_from(here, question[1], question[2])
            self._regions[self._row[question]] = here.consulted.bounds

    def _stale(self, state: State) -> list[Question]:
        """Questions whose answers may differ from the last ones."""
        scene = self._stage.scene
        every = np.arange(scene.model.ngeom)
        before, self._places = self._places, self._stage.geoms(every)
        last = self._last
        if last is None or last.untracked != state.untracked or last.holding != state.holding:
            return self._questions
        moved = np.flatnonzero((before[0] != self._places[0]).any(axis=1) | (before[1] != self._places[1]).any(axis=1))
        owners = {scene.owners[geom] for geom in moved.tolist()}
        crossed = touched(self._regions, self._swept(moved, before[0]))
        return [
            question
            for row, question in enumerate(self._questions)
            if crossed[row] or question[0] in owners or question[1] in owners
        ]

    def _swept(self, moved: NDArray[np.intp], before: Array) -> Array:
        """Boxes that hold each moved shape where it was and where it is, (k, 2, 3)."""
        radii_m = self._stage.scene.model.geom_rbound[moved][:, None]
        places = np.stack((before[moved], self._places[0][moved]))
        return np.stack((places.min(axis=0) - radii_m, places.max(axis=0) + radii_m), axis=1)
