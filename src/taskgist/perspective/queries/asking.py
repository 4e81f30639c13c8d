"""Queries (Eq. 7 and 8): which objects, if the agent did this; what must it do, for that object.

Whoever asks much about one state makes a ``Perspectives`` once: each agent's standpoint is made once in it, and each
effort is found once.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.acting.virtual_actions import NO_ACTION
from taskgist.perspective.effort import NO_KNOWN_LEVEL, Ability, Effort
from taskgist.perspective.least_effort import able, effort_from, least_effort
from taskgist.settings import DEFAULT, Settings
from taskgist.world import Stage


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
