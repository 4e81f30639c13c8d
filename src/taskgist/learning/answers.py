"""Answers: what a person said about a predicate that the demonstrations left open (6.4).

Answers are kept as evidence with author and time, and none is ever thrown away: who changes their mind gives a
later answer, and withdrawing is such a statement, too. So the answers of two knowledge files merge by union.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from datetime import datetime
from pathlib import Path

from taskgist.errors import KnowledgeError
from taskgist.facts import Json
from taskgist.learning.estimate import Verdict

DECISIONS = (Verdict.RELEVANT, Verdict.IRRELEVANT)


@dataclass(frozen=True)
class Answer:
    """One statement about a node. It fixes the node's verdict until a later one replaces it.

    Args:
        task: Name of the task.
        node: Name of the node.
        verdict: Relevant or irrelevant; None withdraws what was said before.
        value: Desired value where relevant; None takes the one observed most often.
        author: Who said so.
        time: When, in ISO 8601 with the offset from UTC: ``"2024-05-01T12:00:00+00:00"``.

    Raises:
        KnowledgeError: The verdict is none that a person can give, a value comes without relevance, or the time
            cannot be read.
    """

    task: str
    node: str
    verdict: Verdict | None
    author: str
    time: str
    value: str | None = None

    def __post_init__(self) -> None:
        where = f"answer on {self.task}"
        if self.verdict is not None and self.verdict not in DECISIONS:
            hint = "say relevant or irrelevant, or withdraw with None"
            raise KnowledgeError("no decision", where=where, field=self.node, value=self.verdict.value, hint=hint)
        if self.value is not None and self.verdict is not Verdict.RELEVANT:
            hint = "only a relevant node has a desired value"
            raise KnowledgeError("value without relevance", where=where, field=self.node, value=self.value, hint=hint)
        _instant(self.time, where)

    def to_json(self) -> dict[str, Json]:
        """Plain data; ``answer_from_json`` reads it back."""
        plain = {each.name: getattr(self, each.name) for each in fields(self)}
        return {**plain, "verdict": self.verdict.value if self.verdict else None}


def answer_from_json(document: object, *, where: str | Path | None = None) -> Answer:
    """Read back what ``Answer.to_json`` gave.

    Raises:
        KnowledgeError: Something is missing, further, or of another kind.
    """
    hint = "restore the file from a copy"
    try:
        data = dict(document)  # type: ignore[call-overload] # what does not fit is caught below
        verdict = data.pop("verdict")
        return Answer(verdict=None if verdict is None else Verdict(verdict), **data)
    except (KeyError, TypeError, ValueError) as error:
        raise KnowledgeError(f"not an answer: {error!r}", where=where, hint=hint) from error


def in_force(answers: Iterable[Answer]) -> dict[str, Answer]:
    """The answer that holds for each node: the latest one, unless it withdraws."""
    latest = {answer.node: answer for answer in sorted(answers, key=_order)}
    return {node: answer for node, answer in latest.items() if answer.verdict is not None}


def _order(answer: Answer) -> tuple[datetime, str, str, str]:
    """Time decides; what was said at the same instant has an order all the same."""
    verdict = answer.verdict.value if answer.verdict else ""
    return (_instant(answer.time, answer.node), answer.author, verdict, answer.value or "")


def _instant(time: str, where: str) -> datetime:
    hint = "write it like 2024-05-01T12:00:00+00:00"
    try:
        instant = datetime.fromisoformat(time)
    except (TypeError, ValueError) as error:
        raise KnowledgeError("not a time", where=where, field="time", value=time, hint=hint) from error
    if instant.tzinfo is None:
        raise KnowledgeError("no offset from UTC", where=where, field="time", value=time, hint=hint)
    return instant
