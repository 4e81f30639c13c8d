"""A phrase for any predicate and value; "it" is the target agent."""

from __future__ import annotations

from collections.abc import Sequence

from taskgist.facts import Node
from taskgist.language.changes import CHANGES
from taskgist.language.states import STATES, plain

TOPICS = {
    "reach": "how hard the object is to reach",
    "grasp": "how hard the object is to grasp",
    "see": "how hard the object is to see",
    "visibility": "how much of the object is in view",
    "posture": "whether the target agent sits or stands",
    "hands": "what the target agent's hands do",
    "placement": "where the object lies",
    "motion": "whether the object moves",
}
"""What each subtree is about."""


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


def topic(node: Node) -> str:
    """What the subtree of a node is about: "where the object lies"."""
    name = node.name.split(".")[0]
    return TOPICS.get(name, plain(name))


def listed(parts: Sequence[str], conjunction: str = "and") -> str:
    """The parts as one enumeration: "a, b, and c"."""
    if len(parts) < 3:
        return f" {conjunction} ".join(parts)
    return f"{', '.join(parts[:-1])}, {conjunction} {parts[-1]}"
