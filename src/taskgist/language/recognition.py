"""Sentences on what was recognised: which tasks, how probably, and what speaks for and against each."""

from __future__ import annotations

from collections.abc import Sequence

from taskgist.language.clauses import times, truth_of
from taskgist.language.phrases import listed
from taskgist.recognition.completion import Foreseen
from taskgist.recognition.tasks import Circumstance, LiteralWeight, Recognised

SURELY = 0.5
"""What is more probable is told as what will be; what is less, as what may be."""
CERTAIN = 0.995
"""From this probability on, percent are told as more than 99."""


def percent(probability: float) -> str:
    """A probability in whole percent; what is not certain is never told as 0 or 100: ``"> 99 %"``."""
    if probability > CERTAIN:
        return "> 99 %"
    if probability < 1 - CERTAIN:
        return "< 1 %"
    return f"{round(100 * probability)} %"


def named(recognised: Recognised) -> str:
    """What an episode is: ``"hide away (97 %), hide (95 %)"``, or ``"none of the known tasks (88 %)"``."""
    if recognised.best is None:
        return f"none of the known tasks ({percent(recognised.none)})"
    chosen = recognised.likely or (recognised.best,)
    return ", ".join(f"{each.task} ({percent(each.probability)})" for each in chosen)


def nothing_handled(untracked: Sequence[tuple[str, str]]) -> str:
    """That nothing is handled, as far as hands are tracked.

    Args:
        untracked: Agents and sides of those that are not.
    """
    told = "nothing is handled here"
    hands = listed([f"{agent}'s {side} hand" for agent, side in untracked])
    return f"{told} by hands that are tracked; {hands} {'is' if len(untracked) == 1 else 'are'} not" if hands else told


def literal_reason(each: LiteralWeight) -> str:
    """What a literal of a task's clause says: ``"(…) holds: 6 times as often in this task as elsewhere"``."""
    return f"{each.literal} {truth_of(each.holds)}{_likelihood(each.weight)}"


def circumstance_reason(each: Circumstance) -> str:
    """What is least typical of a task: ``"(Final_Posture = Standing), where Sitting is usual: 3 times …"``."""
    usual = f", where {each.usual} is usual" if each.usual != each.value else ""
    return f"({each.title} = {each.value}){usual}{_likelihood(each.weight)}"


def _likelihood(weight: float) -> str:
    """What a weight says in words; nothing where it says nothing."""
    if not weight:
        return ""
    more, less = ("in this task", "elsewhere") if weight > 0 else ("elsewhere", "in this task")
    return f": {times(weight)} as often {more} as {less}"


def foreseen_sentence(foreseen: Foreseen | None) -> str:
    """What a task under way will be, and what of it does not hold yet.

    ``"it will be 'give' (83 %), once (Nature_Hand_Status = Manip_Desired) holds"``.
    """
    if foreseen is None:
        return "too little is tracked to tell what it will be"
    task, probability = foreseen.tasks[0]
    surely = "will be" if max(probability, foreseen.none) > SURELY else "may be"
    if foreseen.best is None:
        return f"it {surely} none of the known tasks ({percent(foreseen.none)})"
    if not foreseen.missing:
        return f"it {surely} {task!r} ({percent(probability)}); nothing that it is about is missing"
    literals = listed([str(each) for each in foreseen.missing])
    return f"it {surely} {task!r} ({percent(probability)}), once {literals} hold{'s' * (len(foreseen.missing) == 1)}"
