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
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array
from taskgist.perspective.actions import NO_ACTION
from taskgist.perspective.collisions import BODIES, crossed
from taskgist.perspective.effort import ABILITIES, NO_KNOWN_LEVEL, Ability, Effort
from taskgist.perspective.floor import NOTHING, Place
from taskgist.perspective.search import able, effort_from, least_effort
from taskgist.perspective.viewpoint import Standpoint, Target
from taskgist.settings import DEFAULT, Settings
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State

Question = tuple[str, str, Ability]
"""Agent, object and ability."""


def all_efforts(stage: Stage, settings: Settings = DEFAULT) -> dict[Question, Effort]:
    """The least effort of every agent for every object, to see, to reach and to grasp it.

    Args:
        stage: The scene in a state.
        settings: All settings.
    """
    efforts: dict[Question, Effort] = {}
    targets: dict[str, Target] = {}
    for agent in stage.scene.agents:
        here = Standpoint(stage, agent, settings, targets=targets)
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
        self._consulted = np.full((len(self._questions), 2 + BODIES, 2, 3), np.nan)
        self._walked = np.zeros(len(self._questions), dtype=np.bool_)
        self._heres: dict[str, Standpoint] = {}
        self._floors: dict[str, tuple[Place, ...]] = {}
        self._efforts: dict[Question, Effort] = {}
        self._targets: dict[str, Target] = {}
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
        last, self._last = self._last, None  # whatever interrupts this, the next state is looked at afresh
        moved = self._moved(self._stage.show(state), last)
        stale = np.ones(len(self._questions), dtype=np.bool_) if moved is None else self._crossed(moved)
        self._targets = {n: each for n, each in self._targets.items() if moved and n not in moved.owners}
        for agent in self._stage.scene.agents:
            self._renew(agent, state, moved, stale)
        for row in np.flatnonzero(stale).tolist():
            self._ask(row)
        self._floors = {agent: here.floor_places for agent, here in self._heres.items() if self._has_walked(agent)}
        self._last = state
        self.asked_count = int(stale.sum())
        return MappingProxyType(dict(self._efforts))

    def _ask(self, row: int) -> None:
        agent, name, ability = question = self._questions[row]
        here = self._heres[agent]
        self._efforts[question] = effort_from(here, name, ability)
        self._consulted[row], self._walked[row] = here.consulted.bounds, here.walked

    def _renew(self, agent: str, state: State, moved: Moved | None, stale: NDArray[np.bool_]) -> None:
        """Take an agent's standpoint in the new state; if it can now get elsewhere, what made use of that is stale."""
        before = self._heres.get(agent)
        stays = moved is not None and before is not None and agent not in moved.owners
        known = before.floor_after(moved.boxes) if moved and before and stays else NOTHING
        stage = self._stage.show(state)
        here = Standpoint(stage, agent, self._settings, known_floor=known, targets=self._targets)
        self._heres[agent] = here
        if stays and agent in self._floors and self._floors[agent] != here.floor_places:
            stale |= self._rows_of(agent) & self._walked

    def _rows_of(self, agent: str) -> NDArray[np.bool_]:
        return np.array([question[0] == agent for question in self._questions])

    def _has_walked(self, agent: str) -> bool:
        return bool((self._rows_of(agent) & self._walked).any())

    def _moved(self, stage: Stage, last: State | None) -> Moved | None:
        """What moved since the last state; None if anything may have."""
        scene = stage.scene
        before, self._places = self._places, stage.geoms(np.arange(scene.model.ngeom))
        if last is None or last.untracked != stage.state.untracked or last.holding != stage.state.holding:
            return None
        geoms = np.flatnonzero((before[0] != self._places[0]).any(axis=1) | (before[1] != self._places[1]).any(axis=1))
        radii_m = scene.model.geom_rbound[geoms][:, None]
        places = np.stack((before[0][geoms], self._places[0][geoms]))
        boxes = np.stack((places.min(axis=0) - radii_m, places.max(axis=0) + radii_m), axis=1)
        return Moved(frozenset(scene.owners[geom] for geom in geoms.tolist()), boxes)

    def _crossed(self, moved: Moved) -> NDArray[np.bool_]:
        """Questions about what moved, and those in whose region something did."""
        asked = np.array([not moved.owners.isdisjoint(question[:2]) for question in self._questions])
        return np.asarray(asked | crossed(self._consulted, moved.boxes))


@dataclass(frozen=True, eq=False)
class Moved:
    """What moved between two states.

    Attributes:
        owners: Agents and objects.
        boxes: Boxes that hold each moved shape where it was and where it is, metres, (k, 2, 3).
    """

    owners: frozenset[str]
    boxes: Array


# --- Queries (Eq. 7 and 8): which objects, if the agent did this; what must it do, for that object.
#
# Whoever asks much about one state makes a ``Perspectives`` once: each agent's standpoint is made once in it, and
# each effort is found once.


@dataclass(frozen=True)
class Chosen:
    """The objects of a scene by the answer to a question; every object is in one of the three.

    Attributes:
        yes: Those for which it holds, in the scene's order.
        no: Those for which it does not.
        unknown: Those of which nothing can be said, for want of tracking.
    """

    yes: tuple[str, ...]
    no: tuple[str, ...]
    unknown: tuple[str, ...]

    @classmethod
    def by(cls, answers: Mapping[str, bool | None]) -> Chosen:
        """Objects by their answers, None for unknown."""
        chosen = {value: tuple(name for name, answer in answers.items() if answer is value) for value in VALUES}
        return cls(yes=chosen[True], no=chosen[False], unknown=chosen[None])


VALUES = (True, False, None)


class Perspectives:
    """Every agent's efforts in one state, found when they are asked for and then kept.

    Args:
        stage: The scene in a state. It is borrowed, and must show the same state whenever something is asked.
        settings: All settings.
    """

    def __init__(self, stage: Stage, settings: Settings = DEFAULT) -> None:
        self.stage, self.settings = stage, settings
        self._standpoints: dict[tuple[str, frozenset[str] | None], Standpoint] = {}
        self._efforts: dict[tuple[Standpoint, str, Ability], Effort] = {}

    def standpoint(self, agent: str, actions: Iterable[str] | None = None) -> Standpoint:
        """An agent's standpoint, with all the virtual actions that it has, or only some.

        Raises:
            UnknownNameError: There is no such agent, or it has no such action.
        """
        key = (agent, None if actions is None else frozenset(actions))
        if key not in self._standpoints:
            self._standpoints[key] = Standpoint(self.stage, agent, self.settings, actions=key[1])
        return self._standpoints[key]

    def effort(self, agent: str, name: str, ability: Ability, actions: Iterable[str] | None = None) -> Effort:
        """The least effort for an object (Eq. 8), by any virtual action or by some.

        Raises:
            UnknownNameError: There is no such agent, object, ability or action.
        """
        here = self.standpoint(agent, actions)
        key = (here, name, ability)
        if key not in self._efforts:
            self._efforts[key] = effort_from(here, name, ability)
        return self._efforts[key]

    def able(self, agent: str, name: str, ability: Ability, *, max_level: int) -> bool | None:
        """Whether an agent is able to with no more than an effort level, 0 to 5; None if that is unknown.

        Raises:
            UnknownNameError: There is no such agent, object or ability.
        """
        level = self.effort(agent, name, ability).level
        if level is not None:
            return level <= max_level
        if max_level >= NO_KNOWN_LEVEL:
            return True  # some level it is, whichever
        # What leaves one level unknown may leave others known.
        return able(self.stage, agent, name, ability, max_level=max_level, settings=self.settings)

    def efforts_with(self, agent: str, ability: Ability, actions: Iterable[str] | None = None) -> dict[str, Effort]:
        """Efforts for every object by name, if the agent may use only some virtual actions (Eq. 7).

        Args:
            agent: Whose.
            ability: ``see``, ``reach`` or ``grasp``.
            actions: Virtual actions by name; those that need fewer of them are included, none asks for the current
                state, and None for all that the agent has.

        Raises:
            UnknownNameError: There is no such agent or ability, or the agent has no such action.
        """
        chosen = None if actions is None else tuple(actions)
        return {name: self.effort(agent, name, ability, chosen) for name in self.stage.scene.objects}


def able_by(efforts: Mapping[str, Effort]) -> Chosen:
    """The objects that some efforts bring about, level 5 not among them."""
    levels = {name: effort.level for name, effort in efforts.items()}
    return Chosen.by({name: None if level is None else level < NO_KNOWN_LEVEL for name, level in levels.items()})


def becoming_able_by(efforts: Mapping[str, Effort]) -> tuple[str, ...]:
    """Those of ``able_by(efforts).yes`` that need some action: what it *becomes* able to (Eq. 7)."""
    return tuple(name for name in able_by(efforts).yes if efforts[name].actions != (NO_ACTION,))


def objects_with(
    stage: Stage, agent: str, ability: Ability, actions: Iterable[str], settings: Settings = DEFAULT
) -> tuple[str, ...]:
    """The objects that an agent sees, reaches or grasps if it may use some virtual actions (Eq. 7).

    Args:
        stage: The scene in a state.
        agent: Whose ability.
        ability: ``see``, ``reach`` or ``grasp``.
        actions: Virtual actions by name; those that need fewer of them are included, none asks for the current state.
        settings: All settings.

    Returns:
        Names in the scene's order, without those of which it is unknown.

    Raises:
        UnknownNameError: There is no such agent or ability, or the agent has no such action.
    """
    return able_by(Perspectives(stage, settings).efforts_with(agent, ability, tuple(actions))).yes


def actions_for(
    stage: Stage, agent: str, name: str, ability: Ability, settings: Settings = DEFAULT
) -> tuple[str, ...] | None:
    """The virtual actions with which an agent sees, reaches or grasps an object with the least effort (Eq. 8).

    Returns:
        In order; ``No_Action_Required`` alone, ``No_Possible_Known_Action`` alone, or None if it is unknown.

    Raises:
        UnknownNameError: There is no such agent, object or ability.
    """
    return least_effort(stage, agent, name, ability, settings).actions or None
