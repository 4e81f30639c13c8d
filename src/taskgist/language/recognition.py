"""Sentences on what was recognised, and on what tells one task from another."""

from __future__ import annotations

import math

from taskgist.facts.values import UNKNOWN, Unknown
from taskgist.language.phrases import listed
from taskgist.learning.contrast import Contrast, Contrasted, Weighed
from taskgist.recognition.tasks import LiteralWeight, NodeWeight, Recognised

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


def truth_of(holds: bool | Unknown) -> str:
    """Whether something holds, in a word."""
    return "is unknown" if holds is UNKNOWN else "holds" if holds else "does not hold"


def literal_reason(each: LiteralWeight) -> str:
    """What a literal of a task's clause says: ``"(…) holds: 6 times as likely here as elsewhere"``."""
    return f"{each.literal} {truth_of(each.holds)}{_likelihood(each.weight, 'in this task', 'elsewhere')}"


def unlike_reason(each: NodeWeight) -> str:
    """What is unlike a task's demonstrations: ``"(Final_Motion = Moving), usually Static"``."""
    usual = "" if each.usual == each.value else f", where {each.usual} is usual"
    return f"({each.title} = {each.value}){usual}{_likelihood(each.weight, 'in this task', 'elsewhere')}"


def contrasted_reason(each: Contrasted, contrast: Contrast) -> str:
    """How often a literal holds in two tasks: ``"(…)   in 9 of 10 of hide, in 0 of 10 of put away"``."""
    counts = ((each.first, contrast.first), (each.second, contrast.second))
    return f"{each.literal}   {', '.join(f'in {hits} of {known} of {task}' for (hits, known), task in counts)}"


def weighed_reason(each: Weighed, contrast: Contrast) -> str:
    """What a literal of a contrast says of an episode."""
    told = f"{contrasted_reason(each.contrasted, contrast)}: {truth_of(each.holds)} here"
    if not each.weight:
        return told
    task = contrast.first if each.weight > 0 else contrast.second
    return f"{told}, which speaks for {task} {times(each.weight)}"


def decided(contrast: Contrast, weighed: tuple[Weighed, ...]) -> str:
    """Which of two tasks an episode is the more like, in one sentence."""
    total = math.fsum(each.weight for each in weighed)
    if abs(total) < math.log(2.0):
        return f"it is as much like {contrast.first} as like {contrast.second}"
    like, unlike = (contrast.first, contrast.second) if total > 0 else (contrast.second, contrast.first)
    speaking = [each for each in weighed if each.weight * total > 0]
    because = listed([f"{each.contrasted.literal} {truth_of(each.holds)}" for each in speaking[:2]])
    return f"it is like {like} rather than {unlike}, because {because}"


def times(weight: float) -> str:
    """A weight as a factor: ``"12 times"``, ``"1.4 times"``."""
    factor = math.exp(abs(weight))
    return f"{factor:.0f} times" if factor >= 10 else f"{factor:.1f} times"


def _likelihood(weight: float, here: str, elsewhere: str) -> str:
    if not weight:
        return ""
    more, less = (here, elsewhere) if weight > 0 else (elsewhere, here)
    return f", {times(weight)} as likely {more} as {less}"
