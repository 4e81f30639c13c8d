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

Whoever walks looks out from elsewhere in each frame, so that all about him is asked anew. Where that takes too long,
``latest`` keeps to a time, and tells of each effort which state it is of.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.perspective.effort import ABILITIES, NO_ACTION, NO_KNOWN_LEVEL, Ability, Effort
from taskgist.perspective.search import able, effort_from, least_effort, level_from
from taskgist.perspective.target import Region, Target, crossed, touched
from taskgist.perspective.viewpoint import Viewpoint
from taskgist.settings import DEFAULT, Settings
from taskgist.world.bodies.hands import GHOST_GROUP
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
        regions: Where all was looked or felt for, metres, (3 + BODIES, 2, 3).
        postures: Whether it mattered which postures the agent can take.
        floor_m: How long the ways are at most over which places mattered that the agent can get to, metres.
    """

    effort: Effort
    regions: Array
    postures: bool
    floor_m: float


class Dated(NamedTuple):
    """An effort, and when it was found or last known to hold.

    Attributes:
        effort: The effort.
        time_s: Time of the state that it is of, seconds.
    """

    effort: Effort
    time_s: float


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
        self._latest: dict[Question, Dated] = {}

    def viewpoint(self, agent: str, actions: Iterable[str] | None = None) -> Viewpoint:
        """An agent's viewpoint, with all the virtual actions that it has, or only some.

        Raises:
            UnknownNameError: There is no such agent, or it has no such action.
        """
        return self._viewpoint((agent, None if actions is None else frozenset(actions)))

    def _viewpoint(self, who: Who) -> Viewpoint:
        if who not in self._viewpoints:
            (agent, actions), targets = who, self._targets
            with self.stage.showing(self.state) as stage:
                self._viewpoints[who] = Viewpoint(stage, agent, self.settings, actions=actions, targets=targets)
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
            noted = here.recorder
            answers[name, ability] = Answer(effort, noted.bounds, noted.postures, noted.floor_m)
            self.asked_count += 1
        return answers[name, ability].effort

    def level(self, agent: str, name: str, ability: Ability, *, up_to: int) -> int | None:
        """The level of an effort, told exactly up to one level; what is greater is told as the next one.

        Raises:
            UnknownNameError: There is no such agent, object or ability.
        """
        who: Who = (agent, None)
        known = self._answers.setdefault(who, {}).get((name, ability))
        if known is None:
            self.asked_count += 1
            return level_from(self._viewpoint(who), name, ability, up_to=up_to)
        level = known.effort.level
        return None if level is None else min(level, up_to + 1)

    def all(self, abilities: Iterable[Ability] = ABILITIES) -> dict[Question, Effort]:
        """The least effort of every agent for every object, by agent, object and ability."""
        scene, chosen = self.stage.scene, tuple(abilities)
        questions = ((agent, name, ability) for agent in scene.agents for name in scene.objects for ability in chosen)
        return {question: self.effort(*question) for question in questions}

    def latest(self, budget_s: float, abilities: Iterable[Ability] = ABILITIES) -> dict[Question, Dated]:
        """As ``all``, as far as a time allows: what may have changed is found anew, the oldest first, until it is up.

        Args:
            budget_s: When no further effort is begun, seconds from now. What was never asked before is asked all the
                same.
            abilities: Of those efforts.

        Returns:
            Each effort with the time of the state that it is of: that of ``state`` where it holds now.
        """
        end_s, scene, chosen = time.perf_counter() + budget_s, self.stage.scene, tuple(abilities)
        questions = [(agent, name, ability) for agent in scene.agents for name in scene.objects for ability in chosen]
        ages = {question: self._latest[question].time_s for question in questions if question in self._latest}
        for question in sorted(questions, key=lambda question: ages.get(question, -math.inf)):
            agent, name, ability = question
            known = (name, ability) in self._answers.get((agent, None), {})
            if known or question not in ages or time.perf_counter() < end_s:
                self._latest[question] = Dated(self.effort(*question), self.state.time_s)
        return {question: self._latest[question] for question in questions}

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

        What stands still but for a tracker's noise is taken to stand exactly where it stood (``world.steadied``,
        ``settings.following``). Efforts that cannot have changed since the last state are kept; the others are found
        anew when they are asked.

        Args:
            state: The next state, of the same scene.
        """
        last, viewpoints, targets, answers = self.state, self._viewpoints, self._targets, self._answers
        # Whatever interrupts this, all is found anew in the next state.
        self.state, self._viewpoints, self._targets, self._answers, self.asked_count = state, {}, {}, {}, 0
        state = self._steadied.follow(state)
        moved = self._moved(last, state)
        self.state = self.stage.state
        if moved is None:
            return
        if not moved.owners:
            self._viewpoints, self._targets, self._answers = viewpoints, targets, answers
            return
        self._targets = {name: each for name, each in targets.items() if not moved.concerns(each)}
        kept = {}
        for who, known in answers.items():
            if who[0] not in moved.owners or who[0] in moved.arms_only:
                kept[who] = self._kept(who, viewpoints[who], known, moved)
        self.stage.show(self.state)
        self._answers = kept

    def _moved(self, last: State, state: State) -> Moved | None:
        """What moved since the last state; None if anything may have. The stage shows the new state afterwards."""
        scene, stage = self.stage.scene, self.stage
        every = np.flatnonzero(scene.model.geom_group != GHOST_GROUP)  # ghosts are in nobody's way
        was = {name: _bearings(stage.show(last), name) for name in scene.agents}
        before, turned_before = (np.array(each) for each in stage.geoms(every))
        after, turned_after = stage.show(state).geoms(every)
        differ = np.zeros(scene.model.ngeom, dtype=np.bool_)
        differ[every] = (before != after).any(axis=1) | (turned_before != turned_after).any(axis=1)
        state, holds = stage.state, (last.holding, stage.state.holding)
        tracked = last.untracked ^ state.untracked
        if (holds[0] is None) != (holds[1] is None) or any(map(stage.is_plane, np.flatnonzero(differ).tolist())):
            return None
        differ[scene.untracked_geoms(tracked)] = True
        changed = {name.partition("/")[0] for name in tracked}
        for hold in (holds[0] or frozenset()) ^ (holds[1] or frozenset()):
            changed |= {hold.agent, hold.object}
        changed |= {name for name in scene.agents if last.eyes.get(name) != state.eyes.get(name)}
        geoms = np.flatnonzero(differ)
        owners = frozenset(scene.owners[geom] for geom in geoms.tolist())
        arms_only = {
            name
            for name in owners.intersection(scene.agents) - changed
            if all(map(np.array_equal, was[name], _bearings(stage, name)))
        }
        boxes = stage.bounds_of_each(geoms)
        earlier = stage.show(last).bounds_of_each(geoms)
        stage.show(state)
        together = np.stack((np.minimum(boxes[:, 0], earlier[:, 0]), np.maximum(boxes[:, 1], earlier[:, 1])), axis=1)
        return Moved(owners | changed, frozenset(arms_only), bool(tracked), geoms, together)

    def _kept(self, who: Who, before: Viewpoint, known: Answers, moved: Moved) -> Answers:
        """Answers that stay, of an agent that stays where it is: neither about what moved, nor found where it did."""
        here = self._viewpoint(who)
        if here.contacts != before.contacts:
            return {}
        is_own = here.is_own[moved.geoms]
        others, own = moved.boxes[~is_own], moved.boxes[is_own]
        asked = {question: answer for question, answer in known.items() if question[0] not in moved.owners}
        if asked:
            regions = np.stack([answer.regions for answer in asked.values()])
            stale = crossed(regions, others)
            if len(own):  # own arms hide things, and are in no other way
                stale |= [ability == "see" for _, ability in asked] & crossed(regions[:, :2].copy(), own)
            asked = {each: asked[each] for each, gone in zip(asked, stale.tolist(), strict=True) if not gone}
        if "candidates" not in before.__dict__:
            return asked
        if not here.candidates.follow(before.candidates, others):
            return {question: answer for question, answer in asked.items() if not answer.postures}
        nearest_m = here.candidates.floor_goes_on(others)
        if nearest_m == math.inf:
            return asked
        return {question: answer for question, answer in asked.items() if answer.floor_m < nearest_m}


Answers = dict[tuple[str, Ability], Answer]


def _bearings(stage: Stage, name: str) -> tuple[Array, ...]:
    """Where all of an agent is that its arms do not move, and where these begin."""
    agent, qpos = stage.scene.agent(name), stage.state.qpos
    others = np.setdiff1d(list(agent.joints.values()), agent.arm_positions).astype(np.intp)
    shoulders = [stage.shoulder(arm) for arm in agent.arms]
    return (qpos[agent.base], qpos[others], *(part for each in shoulders for part in (each.position, each.matrix)))


@dataclass(frozen=True, eq=False)
class Moved:
    """What moved, or of which other parts are tracked or held, between two states.

    Attributes:
        owners: Agents and objects.
        arms_only: Those of the agents of which only the arms moved.
        tracked: Whether other things are tracked now.
        geoms: Their shapes, (k,).
        boxes: Boxes that hold each shape where it was and where it is, metres, (k, 2, 3).
    """

    owners: frozenset[str]
    arms_only: frozenset[str]
    tracked: bool
    geoms: Indices
    boxes: Array

    def concerns(self, target: Target) -> bool:
        """Whether an object may be another, or lie on something else."""
        if self.tracked or target.name in self.owners:
            return True
        region = Region()
        region.add_balls(target.centers, target.radii_m + BENEATH_M)
        return bool(touched(region.bounds[None], self.boxes)[0])


BENEATH_M = 0.1
"""How far around an object that is looked for which it lies on, at most."""


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
