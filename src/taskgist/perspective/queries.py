"""Set questions between agents: what A reaches, B sees and C does not, each with a bound on the effort.

Questions are values that are combined with ``&``, ``|`` and ``~``::

    Condition("P1", "reach", max_level=2) & Condition("P2", "see") & ~Condition("P3", "see")

Unknown is a third truth value (Kleene): "and" with something false is false all the same, "not" of unknown is unknown.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from taskgist.errors import InputError, UnknownNameError
from taskgist.perspective.effort import NO_KNOWN_LEVEL, Ability
from taskgist.perspective.scene_efforts import Chosen, SceneEfforts
from taskgist.settings import DEFAULT, Settings
from taskgist.world.stage import Stage


class Question(ABC):
    """Something that an object fulfils or not, in one state."""

    @abstractmethod
    def holds(self, efforts: SceneEfforts, name: str) -> bool | None:
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

    def holds(self, efforts: SceneEfforts, name: str) -> bool | None:
        """Able with ``max_level``, and not with less than ``min_level``."""
        within = efforts.able(self.agent, name, self.ability, max_level=self.max_level)
        if not self.min_level:
            return within
        less = efforts.able(self.agent, name, self.ability, max_level=self.min_level - 1)
        return both(within, _negated(less))

    @property
    def abilities(self) -> tuple[tuple[str, Ability], ...]:
        """The one that it asks about."""
        return ((self.agent, self.ability),)


@dataclass(frozen=True)
class All(Question):
    """All parts are fulfilled."""

    parts: tuple[Question, ...]

    def holds(self, efforts: SceneEfforts, name: str) -> bool | None:
        """False as soon as one part is; unknown parts are outweighed by false ones."""
        answer: bool | None = True
        for part in self.parts:
            answer = both(answer, part.holds(efforts, name))
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

    def __invert__(self) -> Question:
        return self.part

    def holds(self, efforts: SceneEfforts, name: str) -> bool | None:
        """The opposite; unknown stays unknown."""
        return _negated(self.part.holds(efforts, name))

    @property
    def abilities(self) -> tuple[tuple[str, Ability], ...]:
        """Those of the part."""
        return self.part.abilities


def objects_where(
    stage: Stage | SceneEfforts, questions: Question | Iterable[Question], settings: Settings = DEFAULT
) -> Chosen:
    """The objects that fulfil a question, or all of several.

    Args:
        stage: The scene in a state; or its efforts, for whoever asks several questions.
        questions: Conditions, and what ``&``, ``|`` and ``~`` make of them.
        settings: All settings; those of the efforts where these are given.

    Raises:
        UnknownNameError: There is no such agent or ability.
    """
    efforts = stage if isinstance(stage, SceneEfforts) else SceneEfforts(stage, settings)
    question = questions if isinstance(questions, Question) else All(tuple(questions))
    for agent, _ in question.abilities:
        efforts.stage.scene.agent(agent)
    names = efforts.stage.scene.objects
    return Chosen.by({name: question.holds(efforts, name) for name in names})


def both(first: bool | None, second: bool | None) -> bool | None:
    """And, where None is unknown."""
    if first is False or second is False:
        return False
    return None if first is None or second is None else True


def _negated(value: bool | None) -> bool | None:
    return None if value is None else not value


# --- Set questions as text: ``P1 reaches <= 2 and P2 sees and not P3 sees``.
#
# The grammar, loosest first::
#
#     question = both { "or" both }
#     both     = term { "and" term }
#     term     = "not" term | "(" question ")" | AGENT ABILITY [ BOUND LEVEL ] | AGENT VERB
#     ABILITY  = "see" | "sees" | "reach" | "reaches" | "grasp" | "grasps"
#     BOUND    = "<=" | "<" | "=" | ">=" | ">"
#     LEVEL    = 0 to 5
#
# Without a bound an agent is able to by some known action, which is ``<= 4``. A name of an agent that holds blanks or
# brackets, or is a word of the grammar, stands between double quotes. Further verbs are given to the reader, by rooms
# that know more than efforts.

TOKEN = re.compile(r'"[^"]*"|<=|>=|[<>=()]|[^\s<>=()"]+|"')
VERBS: Mapping[str, Ability] = {
    "see": "see",
    "sees": "see",
    "reach": "reach",
    "reaches": "reach",
    "grasp": "grasp",
    "grasps": "grasp",
}
NONE = NO_KNOWN_LEVEL
BOUNDS: Mapping[str, Callable[[int], tuple[int, int]]] = {
    "<=": lambda level: (0, level),
    "<": lambda level: (0, level - 1),
    "=": lambda level: (level, level),
    ">=": lambda level: (level, NONE),
    ">": lambda level: (level + 1, NONE),
}
"""Least and greatest level that a bound allows."""
MOST_BRACKETS = 50
WORDS = ("and", "or", "not", "(", ")", *BOUNDS)


MoreVerbs = Mapping[str, Callable[[str], Question]]
"""Verbs that ask for something else than an effort: each makes a question about an agent."""
NO_VERBS: MoreVerbs = MappingProxyType({})


def parse_question(text: str, agents: Collection[str], verbs: MoreVerbs = NO_VERBS) -> Question:
    """Read a set question.

    Args:
        text: The question.
        agents: Names of the scene's agents.
        verbs: Further verbs.

    Raises:
        InputError: The text does not follow the grammar, or a bound leaves no level.
        UnknownNameError: There is no such agent or ability.
    """
    reader = _Reader(text, agents, verbs)
    question = reader.question()
    if reader.next is not None:
        raise reader.error(f"{reader.next!r} is too much", hint='join conditions with "and" or "or"')
    return question


class _Reader:
    """Reads tokens from left to right: one method per rule of the grammar."""

    def __init__(self, text: str, agents: Collection[str], verbs: MoreVerbs) -> None:
        self._text, self._agents, self._verbs = text, agents, verbs
        self._tokens = deque(TOKEN.findall(text))
        self._open = 0

    @property
    def next(self) -> str | None:
        return self._tokens[0] if self._tokens else None

    def question(self) -> Question:
        parts = [self.both()]
        while self._took("or"):
            parts.append(self.both())
        return parts[0] if len(parts) == 1 else ~All(tuple(~part for part in parts))

    def both(self) -> Question:
        parts = [self.term()]
        while self._took("and"):
            parts.append(self.term())
        return parts[0] if len(parts) == 1 else All(tuple(parts))

    def term(self) -> Question:
        if self._took("not"):
            negated = True
            while self._took("not"):  # a loop: people write none or one, programs any number
                negated = not negated
            found = self.term()
            return ~found if negated else found
        if self._took("("):
            return self.bracket()
        return self.condition()

    def bracket(self) -> Question:
        self._open += 1
        if self._open > MOST_BRACKETS:
            raise self.error("brackets in brackets", hint=f"at most {MOST_BRACKETS} are read, one in the other")
        inside = self.question()
        if not self._took(")"):
            raise self.error("a bracket is not closed", hint='add ")"')
        self._open -= 1
        return inside

    def condition(self) -> Question:
        agent = self._agent()
        if self.next in self._verbs:
            return self._verbs[self._tokens.popleft()](agent)
        ability = self._ability()
        if self.next not in BOUNDS:
            return Condition(agent, ability)
        low, high = BOUNDS[self._tokens.popleft()](self._level())
        if low > high or high < 0:
            raise self.error("a bound leaves no effort level", hint="levels are 0 to 5")
        return Condition(agent, ability, max_level=high, min_level=low)

    def error(self, problem: str, *, hint: str) -> InputError:
        return InputError(problem, field="where", value=self._text, hint=hint)

    def _took(self, word: str) -> bool:
        if self.next != word:
            return False
        self._tokens.popleft()
        return True

    def _agent(self) -> str:
        if self.next is None or self.next in WORDS:
            found = "it ends" if self.next is None else f"{self.next!r} stands there"
            raise self.error(f"an agent is expected where {found}", hint=EXAMPLE)
        name = str(self._tokens.popleft()).strip('"')
        if name not in self._agents:
            raise UnknownNameError("agent", name, self._agents)
        return name

    def _ability(self) -> Ability:
        if self.next is None or self.next in WORDS:
            raise self.error("an agent without a verb", hint=EXAMPLE)
        verb = self._tokens.popleft()
        if verb not in VERBS:
            raise UnknownNameError("ability", verb, (*VERBS, *self._verbs))
        return VERBS[verb]

    def _level(self) -> int:
        level = self._tokens.popleft() if self._tokens else ""
        if level not in map(str, range(NO_KNOWN_LEVEL + 1)):
            raise self.error(f"{level or 'nothing'!r} is no effort level", hint="levels are 0 to 5")
        return int(level)


EXAMPLE = 'as in "P1 reaches <= 2 and not P2 sees"'
