"""Efforts of a scene: of any agent for any object, found when asked and kept, also while the scene moves.

Whoever asks much about one state makes ``SceneEfforts`` once::

    efforts = SceneEfforts(Stage(scene, state))
    efforts.effort("P2", "cup", "see").level
    efforts.all()

It is shown one state after another, and answers as if each were the first, but it only asks anew what may have changed:
all of an agent that moved, all about an object that moved, and those answers in whose region something moved. The
region of an answer holds all that was looked through, felt for or walked over to find it::

    for state in tracker:
        efforts.update(state)
        efforts.effort("P2", "cup", "see").level
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from taskgist.common.arrays import Array
from taskgist.perspective.constraints import NOTHING
from taskgist.perspective.effort import ABILITIES, NO_ACTION, NO_KNOWN_LEVEL, Ability, Effort
from taskgist.perspective.search import able, effort_from, least_effort
from taskgist.perspective.target import Target, crossed
from taskgist.perspective.viewpoint import Viewpoint
from taskgist.settings import DEFAULT, Settings
from taskgist.world.stage import Stage
from taskgist.world.state import State
from taskgist.world.steadied import Steadied

Question = tuple[str, str, Ability]
"""Agent, object and ability."""
Who = tuple[str, frozenset[str] | None]
"""An agent, and the virtual actions that it may use; None for all that it has."""


class Answer(NamedTuple):
    """An effort, and what it depends on.

    Attributes:
        effort: The effort.
        regions: Where all was looked or felt for, metres, (2 + BODIES, 2, 3).
        floor: Whether the places mattered that the agent can get to.
    """

    effort: Effort
    regions: Array
    floor: bool


class SceneEfforts:
    """Every agent's efforts in one state, or in one state after another.

    Args:
        stage: The scene in a state. It is borrowed: it shows the same state after each question.
        settings: All settings.

    Attributes:
        state: The state that is asked about.
        asked_count: How many efforts were found since this state was shown; the others were known.
    """

    def __init__(self, stage: Stage, settings: Settings = DEFAULT) -> None:
        self.stage, self.settings, self.state = stage, settings, stage.state
        self.asked_count = 0
        self._steadied = Steadied(stage, stage.state, settings.following)
        self._viewpoints: dict[Who, Viewpoint] = {}
        self._targets: dict[str, Target] = {}
        self._answers: dict[Who, dict[tuple[str, Ability], Answer]] = {}

    def viewpoint(self, agent: str, actions: Iterable[str] | None = None) -> Viewpoint:
        """An agent's viewpoint, with all the virtual actions that it has, or only some.

        Raises:
            UnknownNameError: There is no such agent, or it has no such action.
        """
        return self._viewpoint((agent, None if actions is None else frozenset(actions)))

    def _viewpoint(self, who: Who, known_floor: Mapping[tuple[float, float], bool] = NOTHING) -> Viewpoint:
        if who not in self._viewpoints:
            (agent, actions), targets = who, self._targets
            with self.stage.showing(self.state) as stage:
                self._viewpoints[who] = Viewpoint(
                    stage, agent, self.settings, actions=actions, known_floor=known_floor, targets=targets
                )
        return self._viewpoints[who]

    def effort(self, agent: str, name: str, ability: Ability, actions: Iterable[str] | None = None) -> Effort:
        """The least effort for an object (Eq. 8), by any virtual action or by some.

        Raises:
            UnknownNameError: There is no such agent, object, ability or action.
        """
        who = (agent, None if actions is None else frozenset(actions))
        answers = self._answers.setdefault(who, {})
        if (name, ability) not in answers:
            here = self._viewpoint(who)
            effort = effort_from(here, name, ability)
            answers[name, ability] = Answer(effort, here.recorder.bounds, here.recorder.floor)
            self.asked_count += 1
        return answers[name, ability].effort

    def all(self, abilities: Iterable[Ability] = ABILITIES) -> dict[Question, Effort]:
        """The least effort of every agent for every object, by agent, object and ability."""
        scene, chosen = self.stage.scene, tuple(abilities)
        questions = ((agent, name, ability) for agent in scene.agents for name in scene.objects for ability in chosen)
        return {question: self.effort(*question) for question in questions}

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
        with self.stage.showing(self.state) as stage:
            return able(stage, agent, name, ability, max_level=max_level, settings=self.settings)

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

    def update(self, state: State) -> None:
        """Go on to another state of the scene, which the stage shows from now on.

        Efforts that cannot have changed since the last state are kept; the others are found anew when they are asked.

        Args:
            state: The next state, of the same scene.
        """
        state = self._steadied.follow(state)
        last, viewpoints, targets, answers = self.state, self._viewpoints, self._targets, self._answers
        # Whatever interrupts this, all is found anew in the next state.
        self.state, self._viewpoints, self._targets, self._answers, self.asked_count = state, {}, {}, {}, 0
        moved = self._moved(last, state)
        self.state = self.stage.state
        if moved is None:
            return
        self._targets = {name: each for name, each in targets.items() if name not in moved.owners}
        kept = {who: self._kept(known, moved) for who, known in answers.items() if who[0] not in moved.owners}
        for who, known in kept.items():
            if any(answer.floor for answer in known.values()):
                before = viewpoints[who].candidates
                with self.stage.showing(last):
                    places, floor = before.places, before.floor_after(moved.boxes)
                if self._viewpoint(who, floor).candidates.places != places:  # the agent can now get elsewhere
                    kept[who] = {question: answer for question, answer in known.items() if not answer.floor}
        self.stage.show(self.state)
        self._answers = kept

    def _moved(self, last: State, state: State) -> Moved | None:
        """What moved since the last state; None if anything may have. The stage shows the new state afterwards."""
        scene, every = self.stage.scene, np.arange(self.stage.scene.model.ngeom)
        before, turned_before = self.stage.show(last).geoms(every)
        after, turned_after = self.stage.show(state).geoms(every)
        state = self.stage.state
        if last.untracked != state.untracked or last.holding != state.holding:
            return None
        geoms = np.flatnonzero((before != after).any(axis=1) | (turned_before != turned_after).any(axis=1))
        radii_m = scene.model.geom_rbound[geoms][:, None]
        places = np.stack((before[geoms], after[geoms]))
        boxes = np.stack((places.min(axis=0) - radii_m, places.max(axis=0) + radii_m), axis=1)
        return Moved(frozenset(scene.owners[geom] for geom in geoms.tolist()), boxes)

    @staticmethod
    def _kept(known: Mapping[tuple[str, Ability], Answer], moved: Moved) -> dict[tuple[str, Ability], Answer]:
        """Answers neither about what moved, nor found where something moved."""
        asked = {question: answer for question, answer in known.items() if question[0] not in moved.owners}
        if not asked:
            return {}
        stale = crossed(np.stack([answer.regions for answer in asked.values()]), moved.boxes).tolist()
        return {question: answer for (question, answer), gone in zip(asked.items(), stale, strict=True) if not gone}


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
    return able_by(SceneEfforts(stage, settings).efforts_with(agent, ability, tuple(actions))).yes


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
