"""One subtree of the hypothesis tree: an attribute, its comparison and its nature, declared as data (Fig. 3)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from taskgist.facts.attributes import Attribute
from taskgist.facts.frozen import Json, freeze
from taskgist.facts.values import NOT_OBSERVED, UNKNOWN, Observation, Raw, Unknown, Value
from taskgist.settings import Settings

Instant: TypeAlias = Literal[1, 2]
"""1: the initial world state (WI); 2: the final one (WF)."""

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
            final = _symbol(self.attribute, end, settings).value
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
        yield f"{self.name}.{leaf.part}.{instant}", _symbol(leaf.attribute, snapshot, settings)
        for child in leaf.children:
            yield from self._leaf_values(child, instant, snapshot, settings)


def _read(attribute: Attribute, snapshot: Snapshot) -> Observation[Raw]:
    observation = snapshot.get(attribute.name, NOT_OBSERVED)
    if observation.value is UNKNOWN:
        return observation
    return Observation(attribute.read(observation.value, field=attribute.name), observation.evidence)


def _symbol(attribute: Attribute, snapshot: Snapshot, settings: Settings) -> Observation[Value]:
    """Symbol of an attribute; a raw value that says more than its symbol joins the evidence."""
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
