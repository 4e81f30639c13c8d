"""Sentences on whole clauses: what speaks for each literal, what it was compared with, what tells two tasks apart."""

from __future__ import annotations

import math

from taskgist.facts.tree import HypothesisTree
from taskgist.facts.values import UNKNOWN, Unknown
from taskgist.language.phrases import listed, phrase_of
from taskgist.learning.background import NEUTRAL
from taskgist.learning.clauses import ClausePosterior, MustNot, Support
from taskgist.learning.contrast import Contrast, Contrasted, Weighed
from taskgist.learning.task_clauses import Odd

SURE_ODDS = 20
"""Below these odds they are told: it may be chance."""


def supported(support: Support) -> str:
    """How often something holds, and how often by chance: ``"in 9 of 10; by chance in 1 of 8"``."""
    return f"in {support.k} of {support.n}; by chance in {by_chance(support.chance)}"


def by_chance(share: float) -> str:
    """A share in words of frequency: ``"1 of 8"``, or ``"7 of 10"`` where it is more than about a half."""
    if share < 0.55:
        return f"1 of {round(1 / share)}"
    tenths = round(10 * share)
    return f"{tenths} of 10" if tenths < 10 else f"{int(100 * share)} of 100"


def compared(learned: ClausePosterior) -> str:
    """What a task was compared with: ``"compared with 5 tasks and 207 neutral manipulations"``."""
    neutral = sum(count for name, count in learned.compared.items() if name.startswith(NEUTRAL))
    tasks = sum(not name.startswith(NEUTRAL) for name in learned.compared)
    parts = [f"{tasks} other task{'s' * (tasks > 1)}"] if tasks else []
    parts += [f"{neutral} neutral manipulations"] if neutral else []
    return f"compared with {listed(parts)}" if parts else "compared with nothing, so that nothing is learned"


def against(each: MustNot) -> str:
    """What speaks for it that something must not hold: ``"in 3 of 3 wrong ones, in 0 of 9 right ones"``."""
    if each.odds is None:
        return "as somebody said"
    (wrong, all_wrong), (right, all_right) = each.in_wrong, each.in_right
    told = f"in {wrong} of {all_wrong} wrong ones, in {right} of {all_right} right ones"
    return f"{told}; odds {each.odds:.2g} to 1" if each.odds < SURE_ODDS else told


def oddness(odd: Odd) -> str:
    """Why a demonstration looks odd."""
    name = odd.explanation.demonstration
    if odd.looks_like:
        return f"{name} looks like {listed([repr(task) for task in odd.looks_like], 'or')}: is its label right?"
    return f"{name} is not like the others: was it done as it should be?"


# --- What tells one task from another.


def truth_of(holds: bool | Unknown) -> str:
    """Whether something holds, in a word."""
    return "is unknown" if holds is UNKNOWN else "holds" if holds else "does not hold"


def contrasted_reason(each: Contrasted, contrast: Contrast) -> str:
    """How often a literal holds in two tasks: ``"(…)   in 9 of 10 of hide, in 0 of 10 of put away"``."""
    counts = ((each.first, contrast.first), (each.second, contrast.second))
    return f"{each.literal}   {', '.join(f'in {hits} of {known} of {task}' for (hits, known), task in counts)}"


def likelier(each: Contrasted, contrast: Contrast) -> tuple[str, str]:
    """What a literal says where it holds, and where it does not: ``"where it holds: hide, 12 times as likely"``."""
    told = []
    for holds, where in ((True, "where it holds"), (False, "where it does not")):
        weight = each.weight(holds)
        told.append(f"{where}: {times(weight)} as likely {contrast.first if weight > 0 else contrast.second}")
    return told[0], told[1]


def weighed_reason(each: Weighed, contrast: Contrast) -> str:
    """What a literal of a contrast says of an episode."""
    told = f"{contrasted_reason(each.contrasted, contrast)}: {truth_of(each.holds)} here"
    if not each.weight:
        return told
    task = contrast.first if each.weight > 0 else contrast.second
    return f"{told}, {times(each.weight)} as likely {task}"


def decided(contrast: Contrast, weighed: tuple[Weighed, ...], tree: HypothesisTree) -> str:
    """Which of two tasks an episode is the more like, in one sentence in plain words."""
    total = math.fsum(each.weight for each in weighed)
    if abs(total) < math.log(2.0):
        return f"it is as much like {contrast.first} as like {contrast.second}"
    like, unlike = (contrast.first, contrast.second) if total > 0 else (contrast.second, contrast.first)
    speaking = [each for each in weighed if each.weight * total > 0]
    because = [
        ("" if each.holds else "it is not so that ") + phrase_of(tree.node(literal.node), literal)
        for each in speaking[:2]
        for literal in (each.contrasted.literal,)
    ]
    return f"it is like {like} rather than {unlike}: {listed(because)}"


def times(weight: float) -> str:
    """A weight as a factor: ``"12 times"``, ``"1.4 times"``."""
    factor = math.exp(abs(weight))
    return f"{factor:.0f} times" if factor >= 10 else f"{factor:.1f} times"
