"""Sentences of a dialogue about whole clauses: what is asked, what was seen, what an answer changes, what to show."""

from __future__ import annotations

import re
from dataclasses import replace

from taskgist.facts.tree import HypothesisTree, TreeOf
from taskgist.language.phrases import AGENTS, listed, phrase, phrase_of
from taskgist.learning.answers import Answer, Reply
from taskgist.learning.asking import SetQuestion
from taskgist.learning.lessons import OtherEnd, OtherStart
from taskgist.learning.literals import SetLiteral, vocabulary_by_node
from taskgist.learning.task_clauses import Sides

MOST_NAMES = 6
"""Demonstrations of one side that are named; of more it is said how many there are."""
MEANINGS = {
    Reply.YES: "it must be so",
    Reply.NO: "it must not be so",
    Reply.EITHER: "it may be so or not: it does not matter",
    Reply.UNKNOWN: "don't know: nothing changes, and it is not asked again",
}
"""What each answer says."""


def claim(literal: SetLiteral, tree: HypothesisTree, of: TreeOf = "target") -> str:
    """What a literal says, whatever it leaves out, as a clause of a sentence: "the object ends on a support".

    Args:
        literal: The literal; of one that is all values but some, these are told.
        tree: The tree of its node.
        of: Whose tree it is.
    """
    return about_agent(phrase_of(tree.node(literal.node), replace(literal, but=False)), of)


def about_agent(text: str, of: TreeOf) -> str:
    """A phrase in which the agent is named, in place of "it" and "its", at its begin."""
    text = re.sub(r"^it\b", AGENTS[of], text)
    return re.sub(r"^its\b", f"{AGENTS[of]}'s", text)


def question_text(question: SetQuestion, tree: HypothesisTree, of: TreeOf = "target") -> str:
    """A question to a person: "In “hide”, must it always be that the object ends on a support?"."""
    how = "never" if question.literal.but else "always"
    return f"In “{question.task}”, must it {how} be that {claim(question.literal, tree, of)}?"


def sides_text(found: Sides, *, but: bool = False) -> str:
    """The demonstrations on both sides: "It was so in show_a and show_b, and not so in show_c.".

    Args:
        found: Where the literal holds and fails.
        but: Whether it is asked if something must never be: then it was so where the literal fails.
    """
    so, not_so = (found.fails, found.holds) if but else (found.holds, found.fails)
    parts = [f"so in {_names(so)}"] if so else []
    parts += [f"not so in {_names(not_so)}"] if not_so else []
    parts += [f"unknown in {_names(found.unknown)}"] if found.unknown else []
    return f"It was {listed(parts)}." if parts else "No demonstration shows it."


def _names(names: tuple[str, ...]) -> str:
    if len(names) <= MOST_NAMES:
        return listed(names)
    return f"{len(names)} demonstrations ({', '.join(names[:2])}, ...)"


def lesson_text(lesson: OtherStart | OtherEnd, tree: HypothesisTree, of: TreeOf = "target") -> str:
    """What to show: "Show it where the target agent is standing at the start; so far, the target agent is sitting"."""
    if isinstance(lesson, OtherStart):
        wanted, always = (about_agent(phrase(lesson.node, value), of) for value in (lesson.value, lesson.always[0]))
        return f"Show it from another start: {wanted} (in all demonstrations so far, {always})."
    fails = claim(lesson.fails, tree, of)
    said = f"Show one in which it is not so that {fails}"
    if lesson.holds is None:
        return f"{said}; or say that there is none."
    still = "not" if lesson.holds.but else "still"
    return f"{said}, and {still} that {claim(lesson.holds, tree, of)}; or say that there is none."


def against_all(count: int) -> str:
    """What is said of an answer by which no demonstration is right: "stands against all 3 demonstrations"."""
    return f"stands against all {count} demonstrations" if count > 1 else "stands against the one demonstration"


def answer_text(answer: Answer, tree: HypothesisTree) -> str:
    """An answer that is in force: "yes: the object ends on a support (ann, 2026-01-01T12:00:00+00:00)"."""
    vocabulary = vocabulary_by_node(tree).get(answer.node)
    if vocabulary is None or answer.reply is None:
        verdict = answer.verdict.value if answer.verdict else "withdrawn"
        said = f"{verdict}: {answer.node}{f' = {answer.value}' if answer.value else ''}"
    else:
        literal = vocabulary.literal(answer.among, but=answer.but)
        asked = claim(literal, tree, answer.tree_of)
        said = f"{answer.reply.value}: {f'never that {asked}' if literal.but else asked}"
    return f"{said}   ({answer.author}, {answer.second})"
