"""Set questions as text: ``P1 reaches <= 2 and P2 sees and not P3 sees``.

The grammar, loosest first::

    question = both { "or" both }
    both     = term { "and" term }
    term     = "not" term | "(" question ")" | AGENT ABILITY [ BOUND LEVEL ]
    ABILITY  = "see" | "sees" | "reach" | "reaches" | "grasp" | "grasps"
    BOUND    = "<=" | "<" | "=" | ">=" | ">"
    LEVEL    = 0 to 5

Without a bound an agent is able to by some known action, which is ``<= 4``. A name of an agent that holds blanks or
brackets, or is a word of the grammar, stands between double quotes.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping

from taskgist.errors import InputError, UnknownNameError
from taskgist.perspective.effort import NO_KNOWN_LEVEL, Ability
from taskgist.perspective.queries.sets import Condition, Question

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
WORDS = ("and", "or", "not", "(", ")", *BOUNDS)


def parse_question(text: str, agents: Collection[str]) -> Question:
    """Read a set question.

    Args:
        text: The question.
        agents: Names of the scene's agents.

    Raises:
        InputError: The text does not follow the grammar, or a bound leaves no level.
        UnknownNameError: There is no such agent or ability.
    """
    reader = _Reader(text, agents)
    question = reader.question()
    if reader.next is not None:
        raise reader.error(f"{reader.next!r} is too much", hint='join conditions with "and" or "or"')
    return question


class _Reader:
    """Reads tokens from left to right: one method per rule of the grammar."""

    def __init__(self, text: str, agents: Collection[str]) -> None:
        self._text, self._agents = text, agents
        self._tokens = TOKEN.findall(text)

    @property
    def next(self) -> str | None:
        return self._tokens[0] if self._tokens else None

    def question(self) -> Question:
        found = self.both()
        while self._took("or"):
            found |= self.both()
        return found

    def both(self) -> Question:
        found = self.term()
        while self._took("and"):
            found &= self.term()
        return found

    def term(self) -> Question:
        if self._took("not"):
            return ~self.term()
        if self._took("("):
            inside = self.question()
            if not self._took(")"):
                raise self.error("a bracket is not closed", hint='add ")"')
            return inside
        return self.condition()

    def condition(self) -> Condition:
        agent, ability = self._agent(), self._ability()
        if self.next not in BOUNDS:
            return Condition(agent, ability)
        low, high = BOUNDS[self._tokens.pop(0)](self._level())
        if low > high or high < 0:
            raise self.error("a bound leaves no effort level", hint="levels are 0 to 5")
        return Condition(agent, ability, max_level=high, min_level=low)

    def error(self, problem: str, *, hint: str) -> InputError:
        return InputError(problem, field="where", value=self._text, hint=hint)

    def _took(self, word: str) -> bool:
        if self.next != word:
            return False
        self._tokens.pop(0)
        return True

    def _agent(self) -> str:
        if self.next is None or self.next in WORDS:
            found = "it ends" if self.next is None else f"{self.next!r} stands there"
            raise self.error(f"an agent is expected where {found}", hint=EXAMPLE)
        name = str(self._tokens.pop(0)).strip('"')
        if name not in self._agents:
            raise UnknownNameError("agent", name, self._agents)
        return name

    def _ability(self) -> Ability:
        if self.next is None or self.next in WORDS:
            raise self.error("an agent without a verb", hint=EXAMPLE)
        verb = self._tokens.pop(0)
        if verb not in VERBS:
            raise UnknownNameError("ability", verb, VERBS)
        return VERBS[verb]

    def _level(self) -> int:
        level = self._tokens.pop(0) if self._tokens else ""
        if level not in map(str, range(NO_KNOWN_LEVEL + 1)):
            raise self.error(f"{level or 'nothing'!r} is no effort level", hint="levels are 0 to 5")
        return int(level)


EXAMPLE = 'as in "P1 reaches <= 2 and not P2 sees"'
