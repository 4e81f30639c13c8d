"""Questions: what the learner has to ask, because the demonstrations neither agree nor contradict enough (6.4 iii)."""

from __future__ import annotations

from dataclasses import dataclass

from taskgist.facts.tree import Node
from taskgist.learning.estimate import Verdict
from taskgist.learning.understanding import Answer, Judgement, Understanding


@dataclass(frozen=True)
class Choice:
    """A value in conflict with others, and the demonstrations that showed it."""

    value: str
    demonstrations: tuple[str, ...]
    """Names of the demonstrations."""


@dataclass(frozen=True)
class Question:
    """Does this node matter for the task, and with which value?"""

    task: str
    node: Node
    choices: tuple[Choice, ...]
    """The values observed, most frequent first."""

    def answer(self, verdict: Verdict, *, author: str, time: str, value: str | None = None) -> Answer:
        """An answer to this question; see ``Answer``.

        Args:
            verdict: Relevant or irrelevant.
            author: Who answers.
            time: ISO 8601 with the offset from UTC.
            value: Desired value where relevant; the most frequent one by default.

        Raises:
            KnowledgeError: As ``Answer``.
        """
        return Answer(self.task, self.node.name, verdict, author=author, time=time, value=value)


def questions_of(understanding: Understanding) -> tuple[Question, ...]:
    """The questions whose answers can change the understanding, from abstract to concrete.

    A confusing node below an irrelevant one is not asked about: no answer could bring it back. Once the node above is
    settled otherwise, it will be.
    """
    return tuple(
        _question(understanding, judgement)
        for judgement in understanding.judgements.values()
        if judgement.verdict is Verdict.CONFUSING and _can_be_kept(understanding, judgement)
    )


def _can_be_kept(understanding: Understanding, judgement: Judgement) -> bool:
    above = (understanding.judgements[node.name] for node in understanding.tree.ancestors(judgement.node.name))
    return all(each.verdict in (Verdict.RELEVANT, Verdict.CONFUSING) for each in above)


def _question(understanding: Understanding, judgement: Judgement) -> Question:
    name = judgement.node.name
    choices = (
        Choice(value, tuple(each.demonstration for each in understanding.demonstrations(name, value)))
        for value in judgement.counts
    )
    return Question(understanding.task, judgement.node, tuple(choices))
