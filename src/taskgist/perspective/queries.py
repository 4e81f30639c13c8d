"""Queries (Eq. 7 and 8): which objects, if the agent did this; what must it do, for that object."""

from __future__ import annotations

from collections.abc import Iterable

from taskgist.perspective.effort import NO_KNOWN_LEVEL, Ability
from taskgist.perspective.least_effort import effort_from, least_effort
from taskgist.perspective.standpoint import Standpoint
from taskgist.settings import DEFAULT, Settings
from taskgist.world import Stage


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
    here = Standpoint(stage, agent, settings, actions=actions)
    levels = {name: effort_from(here, name, ability).level for name in stage.scene.objects}
    return tuple(name for name, level in levels.items() if level is not None and level < NO_KNOWN_LEVEL)


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
