"""Natures (level 1): what a change means for the target agent.

Each takes the class of level 2 and the final symbol of level 3; both are known when a nature is asked for, but for
the hands, whose class may be known where the status of a hand is not.
"""

from __future__ import annotations

from taskgist.facts import vocabulary as v
from taskgist.facts.values import UNKNOWN, Unknown, Value


def nature_of_effort(relation: str, _final: Value) -> Value:
    """Nature of a relative effort class (Eq. 11)."""
    return v.NOT_SUPPORTIVE if relation == v.BECOMES_DIFFICULT else v.SUPPORTIVE


def nature_of_visibility(relation: str, _final: Value) -> Value:
    """Nature of a relative visibility class (Eq. 13)."""
    return v.NOT_SUPPORTIVE if relation == v.DECREASED else v.SUPPORTIVE


def nature_of_hands(relation: str, _final: Value) -> Value:
    """Nature of a relative hand status class (Eq. 18)."""
    return v.MANIP_DESIRED if relation in (v.MANIP_MAINTAINED, v.MANIP_GAINED) else v.MANIP_NOT_DESIRED


def nature_of_status(_relation: str, final: Value) -> Value:
    """Nature of a status class: supportive of the final status, which it maintains or gains (Eq. 21).

    The equation's *Not_Supportive* belongs to *Losing* alone, which never comes alone here.
    """
    return UNKNOWN if isinstance(final, Unknown) else v.supportive_of(final)
