"""The hypothesis tree: everything that a demonstration could have been about (5, Fig. 11, Eq. 24-26).

**The problem.** A demonstration changes the world in countless ways, and only some of the changes are what the task
is about. Nobody tells the learner which. So it begins with the whole tree of predicates that it can observe, from
concrete to abstract, and demonstrations prune it.

**The shape.** Each *subtree* speaks of one aspect of the world, from the target agent's point of view. Level 3
holds what the aspect is at the start (¹) and at the end (²); level 2 how the two compare; level 1, where it says
more than level 2, what that change means for the agent. The three abilities have, below each effort, the state in
which the ability holds and the action that leads there. Drawn for *see*::

    see.nature                 Supportive                          level 1, Eq. 11
    └─ see.class               Becomes_Easier                      level 2, Eq. 10
       ├─ see.effort.1         Head_Torso_Effort                   level 3, Fig. 6
       │  ├─ see.state.1       ...
       │  └─ see.action.1      Pan_Head, Turn_Torso
       └─ see.effort.2         No_Effort_Required
          ├─ see.state.2       ...
          └─ see.action.2      No_Action_Required

If the object is hidden at first in some demonstrations and merely out of sight in others, ``see.effort.1`` differs
and will be pruned, while ``see.class`` stays; if in some it was seen from the beginning, only ``see.nature`` stays.
Pruning from below, the learner finds the level of abstraction at which the demonstrations agree.

**A tree is data.** It is a tuple of ``Subtree`` declarations: attributes (which observations fill) with functions
for level 2 and 1. ``instantiate`` turns the observations of one demonstration into the value of each node. Leaving
subtrees or levels out (8.3, 8.4) and adding a user's own (end of 5.3) give new trees; ``version`` tells them apart,
and knowledge carries it.

**Unknown.** What could not be observed is unknown, and so is what follows from it, unless the rest settles it: a
hand that surely holds the object does, whatever the untracked one may do.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeAlias, get_args

from taskgist.common.frozen import FrozenMap, Json, canonical_text, freeze
from taskgist.errors import FactsError, UnknownNameError
from taskgist.facts.values import NOT_OBSERVED, UNKNOWN, Attribute, Observation, Raw, Unknown, Value
from taskgist.settings import DEFAULT, Settings

# One subtree: an attribute, its comparison and its nature, declared as data (Fig. 3).

Instant: TypeAlias = Literal[1, 2]
"""1: the initial world state (WI); 2: the final one (WF)."""

TreeOf: TypeAlias = Literal["target", "performer"]
"""Whose tree it is, all facts from that agent's perspective: the target agent's (what the task does for it), or the
performing agent's own (how it prefers to perform, 7.2)."""
TREES_OF: tuple[TreeOf, ...] = get_args(TreeOf)

Snapshot: TypeAlias = Mapping[str, Observation[Raw]]
"""What was observed at one instant, by attribute. An attribute that is missing is unknown."""

Nodes: TypeAlias = Mapping[str, Observation[Value]]
"""What every node of the tree is for one demonstration."""

Comparison: TypeAlias = Callable[[Any, Any, Settings], Value]
"""Level 2: raw initial value, raw final value (each as its own attribute reads it), settings → class."""

NatureOf: TypeAlias = Callable[[str, Value], Value]
"""Level 1: class, final symbol → nature."""


@dataclass(frozen=True)
class Node:
    """A predicate of the hypothesis tree.

    Args:
        name: Its key everywhere: ``"see.effort.2"``.
        level: 1 nature, 2 comparison, 3 attribute (Fig. 3).
        parent: Name of the node above, if any.
        instant: 1 or 2 for a node of level 3, None above.
        title: Its name in the paper's words: ``"Action_to_See"``.
        values: The values it may take, in canonical order; empty where they are not known beforehand.
    """

    name: str
    level: int
    parent: str | None
    instant: Instant | None
    title: str
    values: tuple[str, ...] = ()


@dataclass(frozen=True)
class Relation:
    """Level 2 of a subtree: title, function and possible values."""

    title: str
    of: Comparison
    values: tuple[str, ...] = ()


@dataclass(frozen=True)
class Nature:
    """Level 1 of a subtree: title, function and possible values."""

    title: str
    of: NatureOf
    values: tuple[str, ...] = ()


@dataclass(frozen=True)
class Leaf:
    """Level 3 of a subtree: an attribute, as a node at the start and one at the end.

    Args:
        attribute: What is observed.
        part: Middle of the nodes' names: ``"effort"`` in ``"see.effort.1"``.
        titles: Titles of the initial and the final node.
        children: Attributes below (state and action below the effort).
    """

    attribute: Attribute
    part: str
    titles: tuple[str, str]
    children: tuple[Leaf, ...] = ()


@dataclass(frozen=True)
class Subtree:
    """Attribute, comparison and nature of one aspect of the world.

    Args:
        name: First part of the nodes' names.
        attribute: What the comparison compares.
        relation: Level 2.
        leaf: Level 3; None leaves its nodes out, while the attribute is still compared.
        nature: Level 1, if this subtree has one.
        action_level: Whether its level 3 is the paper's *action level* (8.4).
        version: Raised by its author when a function changes its meaning; no digest can see that.
    """

    name: str
    attribute: Attribute
    relation: Relation
    leaf: Leaf | None
    nature: Nature | None = None
    action_level: bool = False
    version: str = "1"

    def nodes(self) -> Iterator[Node]:
        """Its nodes, parents before children, initial before final."""
        top = None
        if self.nature:
            top = f"{self.name}.nature"
            yield Node(top, 1, None, None, self.nature.title, self.nature.values)
        middle = f"{self.name}.class"
        yield Node(middle, 2, top, None, self.relation.title, self.relation.values)
        if self.leaf:
            yield from self._leaf_nodes(self.leaf, 1, middle)
            yield from self._leaf_nodes(self.leaf, 2, middle)

    def attributes(self) -> Iterator[Attribute]:
        """The attributes that it reads."""
        yield self.attribute
        leaves = [self.leaf] if self.leaf else []
        while leaves:
            leaf = leaves.pop(0)
            if leaf.attribute != self.attribute:
                yield leaf.attribute
            leaves.extend(leaf.children)

    def instantiate(self, start: Snapshot, end: Snapshot, settings: Settings) -> dict[str, Observation[Value]]:
        """Value and evidence of each of its nodes, for one demonstration."""
        relation = self._relation(start, end, settings)
        nodes = {f"{self.name}.class": relation}
        if self.nature:
            final = symbol_of(self.attribute, end, settings).value
            nodes[f"{self.name}.nature"] = _nature(self.nature, relation.value, final)
        if self.leaf:
            nodes.update(self._leaf_values(self.leaf, 1, start, settings))
            nodes.update(self._leaf_values(self.leaf, 2, end, settings))
        return nodes

    def _relation(self, start: Snapshot, end: Snapshot, settings: Settings) -> Observation[Value]:
        initial, final = (_read(self.attribute, snapshot).value for snapshot in (start, end))
        evidence: dict[str, Json] = {"initial": _plain(initial), "final": _plain(final)}
        if initial is UNKNOWN or final is UNKNOWN:
            return Observation(UNKNOWN, evidence)
        return Observation(self.relation.of(initial, final, settings), evidence)

    def _leaf_nodes(self, leaf: Leaf, instant: Instant, parent: str) -> Iterator[Node]:
        name = f"{self.name}.{leaf.part}.{instant}"
        yield Node(name, 3, parent, instant, leaf.titles[instant - 1], leaf.attribute.values)
        for child in leaf.children:
            yield from self._leaf_nodes(child, instant, name)

    def _leaf_values(
        self, leaf: Leaf, instant: Instant, snapshot: Snapshot, settings: Settings
    ) -> Iterator[tuple[str, Observation[Value]]]:
        yield f"{self.name}.{leaf.part}.{instant}", symbol_of(leaf.attribute, snapshot, settings)
        for child in leaf.children:
            yield from self._leaf_values(child, instant, snapshot, settings)


def _read(attribute: Attribute, snapshot: Snapshot) -> Observation[Raw]:
    observation = snapshot.get(attribute.name, NOT_OBSERVED)
    if observation.value is UNKNOWN:
        return observation
    return Observation(attribute.read(observation.value, field=attribute.name), observation.evidence)


def symbol_of(attribute: Attribute, snapshot: Snapshot, settings: Settings) -> Observation[Value]:
    """Symbol of an attribute in a snapshot; a raw value that says more than its symbol joins the evidence."""
    observation = _read(attribute, snapshot)
    if observation.value is UNKNOWN:
        return Observation(UNKNOWN, observation.evidence)
    symbol = attribute.symbol(observation.value, settings)
    if symbol == observation.value:
        return Observation(symbol, observation.evidence)
    return Observation(symbol, {**observation.evidence, "raw": _plain(observation.value)})


def _nature(nature: Nature, relation: Value, final: Value) -> Observation[Value]:
    if isinstance(relation, Unknown):
        return Observation(UNKNOWN, {"class": None})
    return Observation(nature.of(relation, final), {"class": relation})


def _plain(raw: Raw) -> Json:
    return None if isinstance(raw, Unknown) else freeze(raw)


# An episode: what was observed at both ends of one demonstration, for one target agent and object.


@dataclass(frozen=True)
class Episode:
    """Observations at start and end, with the operator's label (7.2).

    Args:
        task: Name of the task.
        demonstration: Name of the demonstration, for people.
        performing_agent: Who performs.
        target_agent: For whom it is performed; every fact is from this agent's perspective.
        target_object: With which object.
        start: Observations of the initial world state, by attribute.
        end: Observations of the final world state, by attribute.
        source: Identifies what was observed: digest of a recording with the labelled interval, or of a facts file.
    """

    task: str
    demonstration: str
    performing_agent: str
    target_agent: str
    target_object: str
    start: Snapshot
    end: Snapshot
    source: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", FrozenMap(self.start))
        object.__setattr__(self, "end", FrozenMap(self.end))


def tree_of(name: str) -> TreeOf:
    """Whose tree a name asks for.

    Raises:
        UnknownNameError: It is no such name.
    """
    for known in TREES_OF:
        if name == known:
            return known
    raise UnknownNameError("tree of", name, TREES_OF)


LEVELS = ("nature", "action")
"""Levels that ``HypothesisTree.without`` can leave out (8.4): level 1, and level 3 of the abilities."""


@dataclass(frozen=True)
class HypothesisTree:
    """A forest of subtrees: the hypothesis space of every task.

    Args:
        subtrees: The declarations, in canonical order.
        edition: The human half of the version.

    Raises:
        FactsError: Two subtrees share a name, or two attributes of different kinds do.
    """

    subtrees: tuple[Subtree, ...]
    edition: str = "1"
    nodes: tuple[Node, ...] = field(init=False, compare=False, repr=False)
    """All nodes, subtree by subtree, parents before children, initial before final."""
    attributes: FrozenMap[str, Attribute] = field(init=False, compare=False, repr=False)
    """The attributes that observations may fill, by name."""
    version: str = field(init=False, compare=False)
    """Edition and digest of the structure, such as ``"1-3f9a01bc"``."""
    _by_name: FrozenMap[str, Node] = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        nodes = tuple(node for subtree in self.subtrees for node in subtree.nodes())
        object.__setattr__(self, "nodes", nodes)
        object.__setattr__(self, "attributes", _attributes(self.subtrees))
        object.__setattr__(self, "_by_name", FrozenMap({node.name: node for node in nodes}))
        object.__setattr__(self, "version", f"{self.edition}-{_structure_digest(self)}")
        if len(self._by_name) < len(nodes):
            names = ", ".join(subtree.name for subtree in self.subtrees)
            raise FactsError("two nodes of one name", field=names, hint="give each subtree its own name")

    def node(self, name: str) -> Node:
        """The node of this name.

        Raises:
            UnknownNameError: There is none.
        """
        _refuse_unknown("node", [name], self._by_name)
        return self._by_name[name]

    def children(self, node: str) -> tuple[Node, ...]:
        """The nodes directly below, in canonical order."""
        self.node(node)
        return tuple(other for other in self.nodes if other.parent == node)

    def ancestors(self, node: str) -> tuple[Node, ...]:
        """The nodes above, from the nearest to the root."""
        parent = self.node(node).parent
        return () if parent is None else (self.node(parent), *self.ancestors(parent))

    def without(self, *, subtrees: Collection[str] = (), levels: Collection[str] = ()) -> HypothesisTree:
        """This tree less some subtrees or levels, for ablations (8.3, 8.4).

        Args:
            subtrees: Names of subtrees to leave out.
            levels: Of ``LEVELS``: ``"nature"`` leaves level 1 out, ``"action"`` effort, state and action.

        Raises:
            UnknownNameError: There is no such subtree or level.
        """
        _refuse_unknown("subtree", subtrees, [subtree.name for subtree in self.subtrees])
        _refuse_unknown("level", levels, LEVELS)
        kept = (subtree for subtree in self.subtrees if subtree.name not in subtrees)
        return replace(self, subtrees=tuple(_pruned(subtree, levels) for subtree in kept))

    def extended(self, *subtrees: Subtree) -> HypothesisTree:
        """This tree with further subtrees behind its own.

        Raises:
            FactsError: A name is taken.
        """
        return replace(self, subtrees=(*self.subtrees, *subtrees))

    def instantiate(
        self, start: Snapshot, end: Snapshot, settings: Settings = DEFAULT
    ) -> dict[str, Observation[Value]]:
        """Value and evidence of each node for one demonstration, in canonical order.

        Args:
            start: Observations of the initial world state, by attribute; what is missing is unknown.
            end: Observations of the final world state.
            settings: Bins and tolerances of the scores.

        Raises:
            UnknownNameError: There is no such attribute.
            FactsError: An attribute cannot take such a value.
        """
        _refuse_unknown("attribute", [*start, *end], self.attributes)
        values: dict[str, Observation[Value]] = {}
        for subtree in self.subtrees:
            values.update(subtree.instantiate(start, end, settings))
        return {node.name: values[node.name] for node in self.nodes}


def _attributes(subtrees: Iterable[Subtree]) -> FrozenMap[str, Attribute]:
    attributes: dict[str, Attribute] = {}
    for attribute in (attribute for subtree in subtrees for attribute in subtree.attributes()):
        if attributes.setdefault(attribute.name, attribute) != attribute:
            raise FactsError("two attributes of one name", field=attribute.name, hint="rename one of them")
    return FrozenMap(attributes)


def _structure_digest(tree: HypothesisTree) -> str:
    nodes = [[node.name, node.level, node.parent, node.instant, list(node.values)] for node in tree.nodes]
    versions = [[subtree.name, subtree.attribute.name, subtree.version] for subtree in tree.subtrees]
    return hashlib.sha256(canonical_text([nodes, versions]).encode()).hexdigest()[:8]


def _pruned(subtree: Subtree, levels: Collection[str]) -> Subtree:
    nature = None if "nature" in levels else subtree.nature
    leaf = None if "action" in levels and subtree.action_level else subtree.leaf
    return replace(subtree, nature=nature, leaf=leaf)


def _refuse_unknown(kind: str, names: Iterable[str], known: Collection[str]) -> None:
    for name in names:
        if name not in known:
            raise UnknownNameError(kind, name, known)
