"""Phrases of states (level 3) in plain English, at the start and at the end."""

from __future__ import annotations

from collections.abc import Callable

from taskgist.facts import NEGLIGIBLE, Instant
from taskgist.facts import vocabulary as v
from taskgist.language.changes import ABILITIES, PLACES

Phrase = Callable[[str, Instant], str]
"""Says the value of a node at the start (1) or the end (2)."""

EFFORTS = {
    "No_Effort_Required": "takes no effort",
    "Arm_Effort": "takes stretching out an arm",
    "Arm_Torso_Effort": "takes an arm and the torso",
    "Head_Effort": "takes turning the head",
    "Head_Torso_Effort": "takes turning head and torso",
    "Whole_Body_Effort": "takes standing up or sitting down",
    "Displacement_Effort": "takes going elsewhere",
    "No_Possible_Known_Effort": "is not possible by any known effort",
}

ACTIONS = {
    "Pan_Head": "turning the head",
    "Tilt_Head": "tilting the head",
    "Stretch_Out_Arm(left)": "stretching out the left arm",
    "Stretch_Out_Arm(right)": "stretching out the right arm",
    "Turn_Torso": "turning the torso",
    "Lean_Torso": "leaning",
    "Make_Standing": "standing up",
    "Make_Sitting": "sitting down",
    "Move_To": "going elsewhere",
    "No_Possible_Known_Action": "more than any known action",
}

HANDS = {
    v.HOLDING_OBJECT: "holding the object",
    v.HOLDING_OTHER: "holding something else",
    v.FREE_OF_OBJECT: "free of objects",
    v.RESTING_ON_SUPPORT: "resting on a support",
}


def plain(symbol: str) -> str:
    """A symbol in plain letters: ``On_White_Box`` becomes "on white box"."""
    return symbol.replace("_", " ").lower()


def effort(doing: str) -> Phrase:
    """Phrase of the effort that an ability takes."""
    return lambda value, instant: f"{doing} {EFFORTS.get(value, plain(value))}{_after(instant)}"


def action(doing: str) -> Phrase:
    """Phrase of the actions that an ability takes."""

    def told(value: str, instant: Instant) -> str:
        steps = (ACTIONS.get(step, plain(step)) for step in value.split(" + "))
        what = "no effort" if value == v.NO_ACTION else " and ".join(dict.fromkeys(steps))
        return f"{doing} takes {what}{_after(instant)}"

    return told


def state(doing: str) -> Phrase:
    """Phrase of the state of the body in which an ability holds."""
    return lambda value, instant: f"{doing} takes the state of the body {value!r}{_after(instant)}"


def visibility(value: str, instant: Instant) -> str:
    """Phrase of a visibility score."""
    if value == NEGLIGIBLE:
        return f"it sees next to nothing of the object{_after(instant)}"
    return f"the object fills {value} of its view{_after(instant)}"


def posture(value: str, instant: Instant) -> str:
    """Phrase of a posture."""
    return f"it {_is(instant)} {plain(value)}"


def hands(value: str, instant: Instant) -> str:
    """Phrase of a hand status, common to the hands or by side."""
    if value in HANDS:
        return f"its hands {'are' if instant == 1 else 'end'} {HANDS[value]}"
    sides = (side.partition(": ") for side in value.split(", "))
    return " and ".join(f"its {side} hand {_is(instant)} {HANDS.get(told, plain(told))}" for side, _, told in sides)


def placement(value: str, instant: Instant) -> str:
    """Phrase of a placement."""
    return f"the object {_is(instant)} {PLACES.get(value, plain(value))}"


def motion(value: str, instant: Instant) -> str:
    """Phrase of a motion status."""
    return f"the object {_is(instant)} {'at rest' if value == v.STATIC else plain(value)}"


def _is(instant: Instant) -> str:
    return "is" if instant == 1 else "ends"


def _after(instant: Instant) -> str:
    return "" if instant == 1 else " afterwards"


STATES: dict[str, Phrase] = {
    **{f"{ability}.effort": effort(doing) for ability, doing in ABILITIES.items()},
    **{f"{ability}.action": action(doing) for ability, doing in ABILITIES.items()},
    **{f"{ability}.state": state(doing) for ability, doing in ABILITIES.items()},
    "visibility.score": visibility,
    "posture.value": posture,
    "hands.status": hands,
    "placement.status": placement,
    "motion.status": motion,
}
"""Phrases by subtree and part."""
