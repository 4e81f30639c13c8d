"""Set questions between agents: what A reaches, B sees and C does not, each with a bound on the effort.

Questions are values that are combined with ``&``, ``|`` and ``~``::

    Condition("P1", "reach", max_level=2) & Condition("P2", "see") & ~Condition("P3", "see")

Unknown is a third truth value (Kleene): "and" with something false is false all the same, "not" of unknown is unknown.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass

from taskgist.errors import InputError
from taskgist.perspective.effort import NO_KNOWN_LEVEL, Ability
from taskgist.perspective.queries.asking import Chosen, Perspectives
from taskgist.settings import DEFAULT, Settings
from taskgist.world import Stage


class Question(ABC):
    """Something that an object fulfils or not, in one state."""

    @abstractmethod
    def holds(self, perspectives: Perspectives, name: str) -> bool | None:
        """Whether an object fulfils it; None if that is unknown.

        Raises:
            UnknownNameError: There is no such agent, object or ability.
        """

    @property
    @abstractmethod
    def abilities(self) -> tuple[tuple[str, Ability], ...]:
        """The agents and abilities that it asks about, in order, each once."""

    def __and__(self, other: Question) -> Question:
        return All((self, other))

    def __or__(self, other: Question) -> Question:
        return ~All((~self, ~other))

    def __invert__(self) -> Question:
        return Not(self)


@dataclass(frozen=True)
class Condition(Question):
    """An agent's effort lies between two levels.

    Attributes:
        agent: Whose.
        ability: ``see``, ``reach`` or ``grasp``.
        max_level: The greatest level that fulfils it; by default 4, "by some known action".
        min_level: The least level that fulfils it.
    """

    agent: str
    ability: Ability
    max_level: int = NO_KNOWN_LEVEL - 1
    min_level: int = 0

    def __post_init__(self) -> None:
        if not 0 <= self.min_level <= self.max_level <= NO_KNOWN_LEVEL:
            bounds = (self.min_level, self.max_level)
            raise InputError("no effort level lies there", field="levels", value=bounds, hint="levels are 0 to 5")

    def holds(self, perspectives: Perspectives, name: str) -> bool | None:
        """Able with ``max_level``, and not with less than ``min_level``."""
        within = perspectives.able(self.agent, name, self.ability, max_level=self.max_level)
        if not self.min_level:
            return within
        less = perspectives.able(self.agent, name, self.ability, max_level=self.min_level - 1)
        return _both(within, _negated(less))

    @property
    def abilities(self) -> tuple[tuple[str, Ability], ...]:
        """The one that it asks about."""
        return ((self.agent, self.ability),)


@dataclass(frozen=True)
class All(Question):
    """All parts are fulfilled."""

    parts: tuple[Question, ...]

    def holds(self, perspectives: Perspectives, name: str) -> bool | None:
        """False as soon as one part is; unknown parts are outweighed by false ones."""
        answer: bool | None = True
        for part in self.parts:
            answer = _both(answer, part.holds(perspectives, name))
            if answer is False:
                return False
        return answer

    @property
    def abilities(self) -> tuple[tuple[str, Ability], ...]:
        """Those of the parts."""
        return tuple(dict.fromkeys(each for part in self.parts for each in part.abilities))


@dataclass(frozen=True)
class Not(Question):
    """Its part is not fulfilled."""

    part: Question

    def holds(self, perspectives: Perspectives, name: str) -> bool | None:
        """The opposite; unknown stays unknown."""
        return _negated(self.part.holds(perspectives, name))

    @property
    def abilities(self) -> tuple[tuple[str, Ability], ...]:
        """Those of the part."""
        return self.part.abilities


def objects_where(
    stage: Stage | Perspectives, questions: Question | Iterable[Question], settings: Settings = DEFAULT
) -> Chosen:
    """The objects that fulfil a question, or all of several.

    Args:
        stage: The scene in a state; or its perspectives, for whoever asks several questions.
        questions: Conditions, and what ``&``, ``|`` and ``~`` make of them.
        settings: All settings; those of the perspectives where these are given.

    Raises:
        UnknownNameError: There is no such agent or ability.
    """
    perspectives = stage if isinstance(stage, Perspectives) else Perspectives(stage, settings)
    question = questions if isinstance(questions, Question) else All(tuple(questions))
    for agent, _ in question.abilities:
        perspectives.stage.scene.agent(agent)
    names = perspectives.stage.scene.objects
    return Chosen.by({name: question.holds(perspectives, name) for name in names})


def _both(first: bool | None, second: bool | None) -> bool | None:
    if first is False or second is False:
        return False
    return None if first is None or second is None else True


def _negated(value: bool | None) -> bool | None:
    return None if value is None else not value
