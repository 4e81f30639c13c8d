"""Comparisons (level 2): how an attribute differs between the start (¹) and the end (²) of a demonstration."""

from __future__ import annotations

from collections.abc import Mapping

from taskgist.facts import vocabulary as v
from taskgist.facts.values import UNKNOWN, Unknown, Value
from taskgist.settings import Settings


def compare_efforts(initial: str, final: str, _settings: Settings) -> Value:
    """Relative effort class (Eq. 10, whose printed signs are reversed: less effort at the end is *easier*)."""
    before, after = v.EFFORT_LEVELS[initial], v.EFFORT_LEVELS[final]
    if after == before:
        return v.REMAINS_SAME
    return v.BECOMES_EASIER if after < before else v.BECOMES_DIFFICULT


def compare_scores(initial: float, final: float, settings: Settings) -> Value:
    """Relative visibility class (Eq. 12).

    The change counts relative to the greater score, so that forth and back are judged alike; scores below the
    negligible one count as that one, so that noise around nothing is no change.
    """
    least = settings.vision.negligible_score
    before, after = max(initial, least), max(final, least)
    if abs(after - before) < settings.vision.change_tolerance * max(before, after) or after == before:
        return v.ALMOST_SAME
    return v.INCREASED if after > before else v.DECREASED


def compare_postures(initial: str, final: str, _settings: Settings) -> Value:
    """Relative posture class (Eq. 15)."""
    return v.MAINTAINED if initial == final else v.CHANGED


def compare_hands(
    initial: Mapping[str, str | None],
    final: Mapping[str, str | None],
    _settings: Settings,
) -> Value:
    """Relative hand status class (Eq. 17): is the target object in any hand of the agent, before and after?"""
    before, after = holds_object(initial), holds_object(final)
    if isinstance(before, Unknown) or isinstance(after, Unknown):
        return UNKNOWN
    if before:
        return v.MANIP_MAINTAINED if after else v.MANIP_LOSS
    return v.MANIP_GAINED if after else v.MANIP_AVOIDED


def holds_object(hands: Mapping[str, str | None]) -> bool | Unknown:
    """Whether any hand holds the target object; one that surely does settles it, whatever the others do."""
    if v.HOLDING_OBJECT in hands.values():
        return True
    return UNKNOWN if None in hands.values() else False


def compare_statuses(initial: str, final: str, _settings: Settings) -> Value:
    """Class of a status: *Maintaining*, or *Gaining* one with *Losing* the other as one value (Eq. 20)."""
    return v.maintaining(final) if initial == final else v.gaining(final, losing=initial)


def compare_motions(initial: str, final: str, _settings: Settings) -> Value:
    """Relative motion class (Eq. 23)."""
    classes = {
        (v.STATIC, v.MOVING): v.MOTION_GAINED,
        (v.MOVING, v.STATIC): v.MOTION_LOST,
        (v.MOVING, v.MOVING): v.MOTION_MAINTAINED,
        (v.STATIC, v.STATIC): v.MOTION_AVOIDED,
    }
    return classes[initial, final]
