"""Phrases of changes: comparisons (level 2) and natures (level 1) in plain English."""

from __future__ import annotations

from taskgist.facts import vocabulary as v

ABILITIES = {"reach": "reaching the object", "grasp": "grasping the object", "see": "seeing the object"}

PLACES = {
    v.INSIDE_CONTAINER: "inside a container",
    v.ON_SUPPORT: "on a support",
    v.IN_HAND: "in a hand",
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
"""What each value of a node of level 1 or 2 says; "it" is the target agent."""
