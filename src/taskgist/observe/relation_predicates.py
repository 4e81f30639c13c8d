"""Line of sight and distance as subtrees: what the tree of hypotheses can be extended by, and is not by itself.

    learn(recordings, predicates=[SIGHT, DISTANCE])

They are observed with the default settings, which name their versions: what was learned with other thresholds is
another tree, and is never counted together with this one.
"""

from __future__ import annotations

from taskgist.facts.predicates import Predicate, predicate_subtree
from taskgist.facts.values import UNKNOWN, Observation, Unknown
from taskgist.observe.attention import sight
from taskgist.observe.relations import distance
from taskgist.settings import DEFAULT, Settings
from taskgist.world.stage import Stage

DISTANCES = ("near", "far")
"""From the nearest class to the farthest."""


def observe_sight(stage: Stage, agent: str, name: str) -> Observation[str | Unknown]:
    """The line of sight from an agent to an object, and what is before it."""
    found = sight(stage, agent, name)
    if found is None:
        return Observation(UNKNOWN)
    return Observation(found.value, {"share": found.share, "blockers": dict(found.blockers)})


def observe_distance(stage: Stage, agent: str, name: str) -> Observation[str | Unknown]:
    """The class of the distance between an agent and an object, and the metres."""
    found = distance(stage, agent, name)
    return Observation(UNKNOWN) if found is None else Observation(found.value, {"metres": found.metres})


def compare_distances(initial: str, final: str, _settings: Settings) -> str:
    """Whether the class of a distance became a nearer or a farther one."""
    if initial == final:
        return "same"
    return "nearer" if DISTANCES.index(final) < DISTANCES.index(initial) else "farther"


_LIMITS = DEFAULT.relations
SIGHT = Predicate(
    predicate_subtree("sight", ("free", "partly", "blocked"), version=f"1 ({_LIMITS.free_share:g} free)"),
    observe_sight,
)
"""Line of sight from the target agent to the target object, whatever its gaze."""
DISTANCE = Predicate(
    predicate_subtree("distance", DISTANCES, compare=compare_distances, version=f"1 ({_LIMITS.near_m:g} m near)"),
    observe_distance,
)
"""Distance class of the target object to the target agent."""
