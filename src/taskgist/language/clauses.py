"""Sentences on whole clauses: what speaks for each literal, and what it was compared with."""

from __future__ import annotations

from taskgist.language.phrases import listed
from taskgist.learning.background import NEUTRAL
from taskgist.learning.clauses import ClausePosterior, MustNot, Support
from taskgist.learning.task_clauses import Odd

SURE_ODDS = 20
"""Below these odds they are told: it may be chance."""


def supported(support: Support) -> str:
    """How often something holds, and how often by chance: ``"in 9 of 10; by chance in 1 of 8"``."""
    return f"in {support.k} of {support.n}; by chance in {by_chance(support.chance)}"


def by_chance(share: float) -> str:
    """A share in words of frequency: ``"1 of 8"``, or ``"7 of 10"`` where it is more than a half."""
    if share <= 0.5:
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
