"""The search within one effort level (5.1.5).

Stances come from the least amount to the greatest. The first amount at which the ability holds without a collision is
the level's answer; of several states with equal amounts the best one is taken (most pixels, nearest shoulder).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from taskgist.errors import UnknownNameError
from taskgist.perspective.actions import NO_ACTION, NO_KNOWN_ACTION, SIT, STAND, Amount, Stance
from taskgist.perspective.candidates import Stances
from taskgist.perspective.collisions import Blocking
from taskgist.perspective.effort import (
    ABILITIES,
    NO_KNOWN_LEVEL,
    Ability,
    Among,
    Effort,
    Judge,
    Miss,
    Outcome,
    Told,
    Why,
)
from taskgist.perspective.grasp.judge import Grasp
from taskgist.perspective.reach import Reach
from taskgist.perspective.see import See
from taskgist.perspective.viewpoint import Standpoint, Target
from taskgist.settings import DEFAULT, Settings
from taskgist.world.bodies.profile import Posture
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State

HEAD = "head"
BLOCKED = -10.0
"""Shortfall of what would do but for a collision: nothing is nearer, and nothing more worth telling."""


@dataclass(frozen=True, eq=False)
class Found:
    """Where an ability holds, and how much it takes to get there."""

    stance: Stance
    outcome: Outcome

    @cached_property
    def state(self) -> State:
        """The attained state."""
        angles = self.outcome.angles_rad
        return self.stance.state.replace(angles) if angles else self.stance.state

    @property
    def actions(self) -> tuple[str, ...]:
        """Virtual actions in order."""
        return (*self.stance.actions, *self.outcome.actions)

    @property
    def amount(self) -> Amount:
        """How much of them."""
        return replace(self.stance.amount, head_rad=self.outcome.head_rad)

    @property
    def order(self) -> tuple[object, ...]:
        """Least amount first, then the best."""
        return (self.amount.key, self.outcome.merit)


def least(here: Standpoint, judge: Judge, level: int, target: NDArray[np.float64]) -> Found | Why:
    """The least amount of an effort level that gives an ability, or why none does.

    Args:
        here: Whose ability, and from where.
        judge: The ability towards an object.
        level: Effort level, 0 to 4.
        target: The object's middle, metres, (3,).
    """
    if level == 0:
        result = judge.without_effort()
        return Found(here.here, result) if isinstance(result, Outcome) else result
    whys: list[Why] = []
    looked_at: list[Among] = []
    for stances in here.stances(level, target):
        among = judge.among(stances)
        looked_at.append(among)
        for group in _groups(stances, among):
            found = [each for index in group for each in _free(here, among, index, stances[index], whys)]
            if found:
                return min(found, key=lambda each: each.order)
    return partial(_nearest, here, level, whys, looked_at)


def _groups(stances: Stances, among: Among) -> Iterator[list[int]]:
    """Stances from which the ability may hold, those of equal amount together, the least amount first."""
    count = len(stances)
    first = among.next(0, count)
    while first < count:
        end = int(stances.ends[first])
        group, index = [first], among.next(first + 1, end)
        while index < end:
            group.append(index)
            index = among.next(index + 1, end)
        yield group
        first = among.next(end, count)


def _free(here: Standpoint, among: Among, index: int, stance: Stance, whys: list[Why]) -> Iterator[Found]:
    """The best outcome from a stance that respects the constraints, if any; notes why others do not count."""
    for result in among.outcomes(index):
        if not isinstance(result, Outcome):
            whys.append(result)
            continue
        found = Found(stance, result)
        blocking = here.blocked(found.state)
        if blocking is None:
            yield found
            return
        whys.append(partial(_blocked, found.actions, blocking))
        if blocking.part != HEAD:
            return  # outcomes of one stance differ in the head only


def _blocked(actions: tuple[str, ...], blocking: Blocking) -> Miss:
    return Miss(BLOCKED, f"{' + '.join(actions)} is blocked: {blocking}", blocking.as_miss)


def _nearest(here: Standpoint, level: int, whys: list[Why], looked_at: list[Among]) -> Miss:
    """The nearest of all misses of a level."""
    misses = [why() for why in whys] + [miss for among in looked_at if (miss := among.miss()) is not None]
    return min(misses) if misses else here.no_stance(level)


# --- The least effort for an ability (5.1.5, Eq. 8 and 9): effort levels from least to most, until one gives it.
#
# The levels are nested: what a level gives is not lost at a higher one, for a higher one is only asked when all lower
# ones fail.

JUDGES: Mapping[Ability, Callable[[Standpoint, Target], Judge]] = {"see": See, "reach": Reach, "grasp": Grasp}


def least_effort(stage: Stage, agent: str, name: str, ability: Ability, settings: Settings = DEFAULT) -> Effort:
    """The least effort with which an agent sees, reaches or grasps an object.

    Whoever asks several questions about one agent in one state makes a ``Standpoint`` once and calls ``effort_from``.

    Args:
        stage: The scene in a state.
        agent: Whose ability.
        name: The object.
        ability: ``see``, ``reach`` or ``grasp``.
        settings: All settings.

    Raises:
        UnknownNameError: There is no such agent, object or ability.
    """
    return effort_from(Standpoint(stage, agent, settings), name, ability)


def effort_from(here: Standpoint, name: str, ability: Ability, *, explained: bool = False) -> Effort:
    """As ``least_effort``, from a standpoint.

    Args:
        here: Whose ability, and from where.
        name: The object.
        ability: ``see``, ``reach`` or ``grasp``.
        explained: Whether evidence is told at once. Otherwise whoever asks the effort for it has it found anew, on a
            stage of its own: an effort is a value, whatever becomes of the stage.

    Raises:
        UnknownNameError: There is no such object or ability.
    """
    with here.stage.showing(here.state):
        here.consult_anew()
        answer = _answer(here, name, ability)
        if explained:
            return _effort(here, name, ability, answer, partial(dict, _evidence(ability, answer)))
    asked = (here.stage.scene, here.state, here.agent.name, here.settings, here.actions, name, ability)
    return _effort(here, name, ability, answer, partial(_told, *asked))


@dataclass(frozen=True, eq=False)
class _Answer:
    """The level found, None if unknown; how it is attained, if it is; and why not with less, level by level."""

    level: int | None
    found: Found | None
    whys: list[Why]


def _answer(here: Standpoint, name: str, ability: Ability) -> _Answer:
    judge = _judge(here, name, ability)
    if judge is None:
        why = "has no shape" if name in here.stage.scene.shapeless else "not tracked"
        return _Answer(None, None, [partial(Miss, 0.0, f"{name} {why}")])
    target, whys = here.target(name).middle, list[Why]()
    for level in range(NO_KNOWN_LEVEL):
        unknown = judge.unknown(level)
        if unknown is not None:
            return _Answer(None, None, [*whys, partial(Miss, 0.0, unknown)])
        result = least(here, judge, level, target)
        if isinstance(result, Found):
            return _Answer(level, result, whys)
        whys.append(result)
    return _Answer(NO_KNOWN_LEVEL, None, whys)


def able(
    stage: Stage, agent: str, name: str, ability: Ability, *, max_level: int, settings: Settings = DEFAULT
) -> bool | None:
    """Whether an agent sees, reaches or grasps an object with no more than an effort level.

    Args:
        stage: The scene in a state.
        agent: Whose ability.
        name: The object.
        ability: ``see``, ``reach`` or ``grasp``.
        max_level: The greatest effort level allowed, 0 to 4.
        settings: All settings.

    Returns:
        None where no level is known to give the ability and one of them is unknown.

    Raises:
        UnknownNameError: There is no such agent, object or ability.
    """
    here = Standpoint(stage, agent, settings)
    with stage.showing(here.state):
        judge = _judge(here, name, ability)
        if judge is None:
            return None
        target = here.target(name).middle
        levels = range(min(max_level, NO_KNOWN_LEVEL - 1) + 1)
        known = [level for level in levels if judge.unknown(level) is None]
        if any(isinstance(least(here, judge, level, target), Found) for level in known):
            return True
        return False if len(known) == len(levels) else None


def _judge(here: Standpoint, name: str, ability: Ability) -> Judge | None:
    """The ability's judge; None if the object was not tracked."""
    if ability not in JUDGES:
        raise UnknownNameError("ability", ability, ABILITIES)
    here.stage.scene.object_body(name)
    return JUDGES[ability](here, here.target(name)) if here.state.known([name]) else None


def _effort(here: Standpoint, name: str, ability: Ability, answer: _Answer, told: Told) -> Effort:
    """An answer as a value; at level 5, and if unknown, the agent stays as it is."""
    found = answer.found
    known = () if answer.level is None else (NO_KNOWN_ACTION,)
    return Effort(
        ability=ability,
        agent=here.agent.name,
        target=name,
        level=answer.level,
        actions=found.actions or (NO_ACTION,) if found else known,
        amount=found.amount if found else None,
        joints_rad=_joints_rad(here, found.state if found else here.state),
        posture=_posture(here, found.actions) if found else here.posture,
        told=told,
    )


def _evidence(ability: Ability, answer: _Answer) -> dict[str, object]:
    """What was found, and why not with less; where nothing was, the reason says what stands in the way."""
    misses = [why() for why in answer.whys]
    telling = misses[-1] if answer.level is None else min(misses, default=Miss(0.0, FREE[ability]))
    told: dict[str, object] = {
        "reason": telling.why,
        "not_with_less": [miss.why for miss in misses],
        "miss": telling.evidence(),
    }
    found = answer.found
    return told | {"amount": dict(vars(found.amount)), **found.outcome.evidence()} if found else told


def _told(
    scene: Scene,
    state: State,
    agent: str,
    settings: Settings,
    actions: frozenset[str],
    name: str,
    ability: Ability,
) -> Mapping[str, object]:
    """The evidence of an effort, found anew."""
    here = Standpoint(Stage(scene, state), agent, settings, actions=actions)
    return effort_from(here, name, ability, explained=True).evidence


FREE: Mapping[Ability, str] = {"see": "in the gaze cone", "reach": "held", "grasp": "held"}
"""Why nothing needs to be done."""


def _joints_rad(here: Standpoint, state: State) -> dict[str, float]:
    profile = here.agent.profile
    axes = (profile.pan, profile.tilt, profile.turn, profile.lean)
    return {axis.joint: float(state.qpos[here.agent.joints[axis.joint]]) for axis in axes if axis}


def _posture(here: Standpoint, actions: tuple[str, ...]) -> Posture | None:
    if STAND in actions:
        return "standing"
    return "sitting" if SIT in actions else here.posture
