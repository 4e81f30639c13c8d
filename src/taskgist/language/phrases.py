"""A phrase for any predicate and value; "it" is the agent whose tree it is."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from taskgist.facts import vocabulary as v
from taskgist.facts.tree import Instant, Node, TreeOf
from taskgist.facts.values import NEGLIGIBLE
from taskgist.learning.understanding import AnyLiteral

# Phrases of changes: comparisons (level 2) and natures (level 1) in plain English.

ABILITIES = {"reach": "reaching the object", "grasp": "grasping the object", "see": "seeing the object"}

PLACES = {
    v.INSIDE_CONTAINER: "inside a container",
    v.ON_SUPPORT: "on a support",
    v.IN_HAND: "in a hand",
    v.ON_AGENT: "on somebody's body",
    v.HANGING: "hanging",
    v.IN_AIR: "in the air",
}

_ABILITY_CHANGES = {
    "nature": {v.SUPPORTIVE: "becomes no harder", v.NOT_SUPPORTIVE: "becomes harder"},
    "class": {
        v.REMAINS_SAME: "takes as much effort as before",
        v.BECOMES_EASIER: "becomes easier",
        v.BECOMES_DIFFICULT: "becomes harder",
    },
}


def _moved(initial: str, final: str) -> str:
    if initial == final:
        return f"the object stays {PLACES[final]}"
    return f"the object, {PLACES[initial]} at first, ends {PLACES[final]}"


CHANGES: dict[str, dict[str, str]] = {
    **{
        f"{ability}.{part}": {value: f"{doing} {change}" for value, change in changes.items()}
        for ability, doing in ABILITIES.items()
        for part, changes in _ABILITY_CHANGES.items()
    },
    "visibility.nature": {
        v.SUPPORTIVE: "it sees no less of the object than before",
        v.NOT_SUPPORTIVE: "it sees less of the object than before",
    },
    "visibility.class": {
        v.ALMOST_SAME: "it sees about as much of the object as before",
        v.INCREASED: "it sees more of the object than before",
        v.DECREASED: "it sees less of the object than before",
    },
    "posture.class": {v.MAINTAINED: "it keeps its posture", v.CHANGED: "it changes its posture"},
    "hands.nature": {
        v.MANIP_DESIRED: "it has the object in hand at the end",
        v.MANIP_NOT_DESIRED: "it does not have the object in hand at the end",
    },
    "hands.class": {
        v.MANIP_MAINTAINED: "it keeps the object in hand",
        v.MANIP_GAINED: "it gets the object into its hand",
        v.MANIP_LOSS: "the object leaves its hand",
        v.MANIP_AVOIDED: "it has the object in hand neither before nor after",
    },
    "placement.nature": {v.supportive_of(place): f"the object ends {told}" for place, told in PLACES.items()},
    "placement.class": {change: _moved(*states) for states, change in v.TRANSITIONS.items()},
    "motion.class": {
        v.MOTION_GAINED: "the object starts to move",
        v.MOTION_LOST: "the object comes to rest",
        v.MOTION_MAINTAINED: "the object keeps moving",
        v.MOTION_AVOIDED: "the object is at rest before and after",
    },
}
"""What each value of a node of level 1 or 2 says; "it" is the agent whose tree it is."""


# Phrases of states (level 3) in plain English, at the start and at the end.

Phrase = Callable[[str, Instant], str]
"""Says the value of a node at the start (1) or the end (2)."""

EFFORTS = {
    "No_Effort_Required": "takes no effort",
    "Arm_Effort": "takes stretching out an arm",
    "Arm_Torso_Effort": "takes an arm and the torso",
    "Head_Effort": "takes turning the head",
    "Head_Torso_Effort": "takes turning head and torso",
    "Whole_Body_Effort": "takes standing up, sitting down or bending",
    "Displacement_Effort": "takes going elsewhere",
    "No_Possible_Known_Effort": "is not possible by any known effort",
}

NEVER = (v.REACH_EFFORTS[-1], v.SEE_EFFORTS[-1])
"""The end of each effort ladder: more than any known effort."""

ACTIONS = {
    "Pan_Head": "turning the head",
    "Tilt_Head": "tilting the head",
    "Stretch_Out_Arm(left)": "stretching out the left arm",
    "Stretch_Out_Arm(right)": "stretching out the right arm",
    "Turn_Torso": "turning the torso",
    "Lean_Torso": "leaning",
    "Make_Standing": "standing up",
    "Make_Sitting": "sitting down",
    "Bend_Hips": "bending at the hips",
    "Crouch": "crouching",
    "Lift_Torso": "moving the torso up or down",
    "Push_Seat_Back": "pushing the seat back",
    "Move_Along_Seat": "moving along the seat",
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

AGENTS: dict[TreeOf, str] = {"target": "the target agent", "performer": "the performing agent"}
"""Whose tree it is."""

TOPICS = {
    "reach": "how hard the object is to reach",
    "grasp": "how hard the object is to grasp",
    "see": "how hard the object is to see",
    "visibility": "how much of the object is in view",
    "posture": "whether {agent} sits or stands",
    "hands": "what {agent}'s hands do",
    "placement": "where the object lies",
    "motion": "whether the object moves",
}
"""What each subtree is about, of the agent whose tree it is."""


def phrase(node: Node, value: str) -> str:
    """What it means that a node has a value, without a full stop: "it keeps its posture".

    Args:
        node: A node of any tree; one of a user's own is told by its title.
        value: The value. Initial states are told in the present tense, to follow "beforehand".
    """
    subtree, part = node.name.split(".")[:2]
    state = STATES.get(f"{subtree}.{part}")
    if node.instant is not None and state:
        return state(value, node.instant)
    return CHANGES.get(f"{subtree}.{part}", {}).get(value) or f"{plain(node.title)} is {plain(value)}"


def phrase_of(node: Node, literal: AnyLiteral) -> str:
    """What it means that a literal holds, without a full stop, also where its node may have several values.

    Args:
        node: Its node, of any tree.
        literal: The literal: "it is not so that the object ends in a hand".
    """
    first, last = literal.values[0], literal.values[-1]
    match literal.bound:
        case "≥":
            told = f"{phrase(node, first)}, or more{', or is not possible' if last in NEVER else ''}"
        case "≤":
            told = f"{phrase(node, last)}, or less"
        case "to":
            told = f"{plain(node.title)} is {plain(first)}, {plain(last)}, or between"
        case _:
            told = listed(list(dict.fromkeys(phrase(node, value) for value in literal.values)), "or")
    return f"it is not so that {told}" if literal.but else told


def topic(node: Node, of: TreeOf) -> str:
    """What the subtree of a node is about: "where the object lies"."""
    name = node.name.split(".")[0]
    return TOPICS[name].format(agent=AGENTS[of]) if name in TOPICS else plain(name)


def listed(parts: Sequence[str], conjunction: str = "and") -> str:
    """The parts as one enumeration: "a, b, and c"."""
    if len(parts) < 3:
        return f" {conjunction} ".join(parts)
    return f"{', '.join(parts[:-1])}, {conjunction} {parts[-1]}"
