"""The least effort for an ability (5.1.5, Eq. 8 and 9): effort levels from least to most, until one gives the ability.

The levels are nested: what a level gives is not lost at a higher one, for a higher one is only asked when all lower
ones fail.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from taskgist.errors import UnknownNameError
from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.acting.virtual_actions import NO_ACTION, NO_KNOWN_ACTION, SIT, STAND
from taskgist.perspective.effort import ABILITIES, NO_KNOWN_LEVEL, Ability, Effort
from taskgist.perspective.grasping.grasp import Grasp
from taskgist.perspective.judge import Judge, Miss, Why
from taskgist.perspective.reaching.reach import Reach
from taskgist.perspective.search import Found, least
from taskgist.perspective.seeing.see import See
from taskgist.perspective.target import Target
from taskgist.settings import DEFAULT, Settings
from taskgist.world import Posture, Stage, State

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


def effort_from(here: Standpoint, name: str, ability: Ability) -> Effort:
    """As ``least_effort``, from a standpoint.

    Raises:
        UnknownNameError: There is no such object or ability.
    """
    with here.stage.showing(here.state):
        here.consult_anew()
        judge = _judge(here, name, ability)
        if judge is None:
            return _unattained(here, name, ability, None, [partial(Miss, 0.0, f"{name} not tracked")])
        target = here.target(name).middle
        whys: list[Why] = []
        for level in range(NO_KNOWN_LEVEL):
            unknown = judge.unknown(level)
            if unknown is not None:
                return _unattained(here, name, ability, None, [*whys, partial(Miss, 0.0, unknown)])
            answer = least(here, judge, level, target)
            if isinstance(answer, Found):
                return _attained(here, name, ability, level, answer, whys)
            whys.append(answer)
        return _unattained(here, name, ability, NO_KNOWN_LEVEL, whys)


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


def _attained(here: Standpoint, name: str, ability: Ability, level: int, found: Found, whys: list[Why]) -> Effort:
    amount = found.amount

    def told() -> Mapping[str, object]:
        with here.stage.showing(here.state):
            misses = [why() for why in whys]
            nearest = min(misses, default=Miss(0.0, FREE[ability]))
            return _misses(misses, nearest) | {"amount": dict(vars(amount)), **found.outcome.evidence()}

    return Effort(
        ability=ability,
        agent=here.agent.name,
        target=name,
        level=level,
        actions=found.actions or (NO_ACTION,),
        amount=amount,
        joints_rad=_joints_rad(here, found.state),
        posture=_posture(here, found.actions),
        told=told,
    )


def _unattained(here: Standpoint, name: str, ability: Ability, level: int | None, whys: list[Why]) -> Effort:
    """Level 5, or unknown: the agent stays as it is, and the reason says what stands in the way."""

    def told() -> Mapping[str, object]:
        with here.stage.showing(here.state):
            misses = [why() for why in whys]
            return _misses(misses, misses[-1] if level is None else min(misses))

    return Effort(
        ability=ability,
        agent=here.agent.name,
        target=name,
        level=level,
        actions=() if level is None else (NO_KNOWN_ACTION,),
        amount=None,
        joints_rad=_joints_rad(here, here.state),
        posture=here.posture,
        told=told,
    )


def _misses(misses: list[Miss], telling: Miss) -> dict[str, object]:
    """What all evidence begins with: why not with less."""
    return {"reason": telling.why, "not_with_less": [miss.why for miss in misses], "miss": telling.evidence()}


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
