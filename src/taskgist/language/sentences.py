"""Sentences: what a task means, why a node counts or does not, and what there is to ask."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from fractions import Fraction
from typing import cast

from taskgist.facts.tree import HypothesisTree
from taskgist.language.phrases import ABILITIES, AGENTS, listed, phrase, phrase_of, topic
from taskgist.learning.estimate import Verdict
from taskgist.learning.explanation import Explanation
from taskgist.learning.understanding import AnyLiteral, Choice, Clause, Judgement, Question, Understanding, clause_of


def meaning(understanding: Understanding) -> str:
    """What the task means, in one sentence: the effects for the agent whose tree it is, then how it begins.

    Where demonstrations had several target agents or objects, it is said of each of them.
    """
    return clause_meaning(clause_of(understanding), understanding.tree)


def clause_meaning(clause: Clause, tree: HypothesisTree) -> str:
    """What a clause of either rule says, in one sentence; see ``meaning``."""
    told = f"“{clause.task}” means"
    if not clause.literals:
        return f"{told} nothing yet: the demonstrations have nothing in common."
    effects, before = (_spoken(each, tree, clause.each_of) for each in (clause.effects, clause.preconditions))
    target = "each of the target agents" if "target agents" in clause.each_of else AGENTS[clause.tree_of]
    # "…, or more, or is not possible": where a part ends is not to be guessed
    parts = "; and ".join(effects) if any(", or " in each for each in effects) else listed(effects)
    sentence = f"{told} for {target}: {parts}" if effects else f"{told} no effect yet"
    return f"{sentence}; beforehand, {listed(before)}." if before else f"{sentence}."


def indifference(understanding: Understanding) -> str:
    """What does not matter, is not clear yet, or was never observed; empty if there is nothing of the kind."""
    roots = [each for each in understanding.judgements.values() if each.node.parent is None]
    beginnings = {
        Verdict.IRRELEVANT: "It does not matter",
        Verdict.CONFUSING: "Not clear yet is",
        Verdict.UNOBSERVED: "Never observed was",
    }
    sentences = []
    for verdict, beginning in beginnings.items():
        topics = [topic(each.node, understanding.experience.tree_of) for each in roots if each.verdict is verdict]
        if topics:
            conjunction = "or" if verdict is Verdict.IRRELEVANT else "and"
            sentences.append(f"{beginning} {listed(topics, conjunction)}.")
    return " ".join(sentences)


def why(understanding: Understanding, node: str) -> str:
    """Why a node counts or does not: the verdict, the values with their demonstrations, and the figures.

    Args:
        understanding: Of the task.
        node: Name of a node.

    Raises:
        UnknownNameError: There is no such node.
    """
    judgement = understanding.judgements[understanding.tree.node(node).name]
    parts = [_verdict(understanding, judgement)]
    if judgement.counts:
        parts.append(_observed(understanding, judgement))
    parts.extend(_divided(judgement, each) for each in judgement.divided)
    parts.append(_assumed(understanding, judgement))
    parts.append(_answered(judgement) if judgement.answer else _figures(judgement))
    return " ".join(part for part in parts if part)


def asked(question: Question) -> str:
    """A question to a person, with the values in conflict and the demonstrations behind each (6.4 iii)."""
    told = [f"{phrase(question.node, choice.value)} ({_behind(choice)})" for choice in question.choices]
    whose = f" for {AGENTS['performer']}" if question.tree_of == "performer" else ""
    when = f"{whose} at the start" if question.node.instant == 1 else whose
    title = question.node.title
    return f"What does “{question.task}” mean{when}: that {listed(told, 'or that')}; or does {title} not matter?"


def _behind(choice: Choice) -> str:
    """Demonstrations and single targets that showed a value: "in show_1 and show_2; for P2 in show_3"."""
    whole = [f"in {listed(choice.demonstrations)}"] if choice.demonstrations else []
    names = dict.fromkeys(name for _, name in choice.targets)
    single = (f"for {listed([who for who, name in choice.targets if name == each])} in {each}" for each in names)
    return "; ".join([*whole, *single])


ENDS = {1: "at the start", 2: "at the end"}
SPOKEN_ORDER = ("see", "visibility", "reach", "grasp", "hands", "placement", "motion", "posture")
"""What people say first about a task; a user's own predicates come last."""


def _spoken(literals: Iterable[AnyLiteral], tree: HypothesisTree, each_of: Collection[str]) -> list[str]:
    """Phrases of literals in the order in which people would say them; joint angles are left to the clause."""
    said = [literal for literal in literals if ".state." not in literal.node]
    said.sort(key=lambda literal: _place(literal.node))
    phrases = [phrase_of(tree.node(literal.node), literal) for literal in said]
    told = _joined(list(dict.fromkeys(phrases)))
    if "target objects" not in each_of:
        return told
    return [each.replace("the object", "each of the objects") for each in told]


def _place(node: str) -> int:
    subtree = node.partition(".")[0]
    return SPOKEN_ORDER.index(subtree) if subtree in SPOKEN_ORDER else len(SPOKEN_ORDER)


def _joined(phrases: list[str]) -> list[str]:
    """What is said alike of reaching and of grasping is said once."""
    reaching, grasping = (f"{ABILITIES[ability]} " for ability in ("reach", "grasp"))
    both = {p.removeprefix(reaching) for p in phrases if p.startswith(reaching)}
    both &= {p.removeprefix(grasping) for p in phrases if p.startswith(grasping)}
    told = []
    for said in phrases:
        rest = said.removeprefix(reaching).removeprefix(grasping)
        if rest == said or rest not in both:
            told.append(said)
        elif said.startswith(reaching):
            told.append(f"reaching and grasping the object {rest}")
    return told


def _verdict(understanding: Understanding, judgement: Judgement) -> str:
    title = judgement.node.title
    if judgement.kept and judgement.value is not None:
        beforehand = "beforehand, " if judgement.node.instant == 1 else ""
        return f"{title} counts: {beforehand}{phrase(judgement.node, judgement.value)}."
    if judgement.verdict is Verdict.RELEVANT:
        above = next(
            node.title
            for node in understanding.tree.ancestors(judgement.node.name)
            if understanding.judgements[node.name].verdict is not Verdict.RELEVANT
        )
        return f"{title} agrees, but does not count, because {above} above it does not."
    reasons = {
        Verdict.IRRELEVANT: "does not matter",
        Verdict.CONFUSING: "is not clear yet",
        Verdict.UNOBSERVED: "was never observed",
    }
    return f"{title} {reasons[judgement.verdict]}."


def _observed(understanding: Understanding, judgement: Judgement) -> str:
    name = judgement.node.name
    told = []
    for value, n in judgement.counts.items():
        names = [each.demonstration for each in understanding.demonstrations(name, value)]
        told.append(f"{value} in {n} of {judgement.estimate.N} ({', '.join(names)})")
    return f"Observed: {'; '.join(told)}."


def _assumed(understanding: Understanding, judgement: Judgement) -> str:
    """Where the gaze behind the values was inferred, and towards what."""
    subtree, instant = judgement.node.name.partition(".")[0], judgement.node.instant
    told = dict[str, None]()
    for explanation in sorted(understanding.experience.explanations.values(), key=lambda each: each.demonstration):
        for node in understanding.tree.nodes:
            if node.name.partition(".")[0] != subtree or node.instant is None or instant not in (None, node.instant):
                continue
            evidence = explanation.nodes[node.name].evidence if node.name in explanation.nodes else {}
            if (thing := evidence.get("eyes_towards")) is not None:
                when, turned_rad = ENDS[node.instant], cast(float, evidence["eyes_rad"])
                turned = f"{math.degrees(turned_rad):.0f}° towards the {thing}"
                told[f"{turned} in {explanation.demonstration} {when}"] = None
    return f"The gaze was inferred, the eyes turned {', '.join(told)}." if told else ""


def _divided(judgement: Judgement, explanation: Explanation) -> str:
    """How the several targets of one demonstration differ."""
    values = explanation.differing(judgement.node.name).items()
    told = (f"{value} for {listed([explanation.called(part) for part in parts])}" for value, parts in values)
    return f"In {explanation.demonstration} targets differ, which speaks against each value: {', '.join(told)}."


def _figures(judgement: Judgement) -> str:
    estimate = judgement.estimate
    limits = f"d1 = {_number(estimate.d1)}, d2 = {_number(estimate.d2)}"
    relation = {
        Verdict.RELEVANT: "lies above d2",
        Verdict.IRRELEVANT: "does not exceed d1",
        Verdict.CONFUSING: "lies between d1 and d2",
    }
    if estimate.verdict not in relation:
        return ""
    evidence = f"{_number(estimate.Q)} − {_number(estimate.NRE)} = {_number(estimate.CF)}"
    return f"Its consistency factor {evidence} {relation[estimate.verdict]} ({limits})."


def _answered(judgement: Judgement) -> str:
    assert judgement.answer is not None
    return f"So said {judgement.answer.author} at {judgement.answer.time}."


def _number(fraction: Fraction) -> str:
    return f"{float(fraction):.3g}"
