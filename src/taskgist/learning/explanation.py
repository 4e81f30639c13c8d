"""An explanation: every node of the tree for one demonstration, target agent and target object (6, step 1)."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from taskgist.common.frozen import FrozenMap, Json, canonical_text
from taskgist.errors import KnowledgeError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import Episode, HypothesisTree, Nodes
from taskgist.facts.values import UNKNOWN, Observation, Value
from taskgist.settings import DEFAULT, Settings


@dataclass(frozen=True)
class Context:
    """Under what facts were inferred. Only explanations of one context may be counted together."""

    settings_digest: str
    """Digest of the settings that shape facts."""
    tree_version: str
    """Version of the hypothesis tree."""

    def __str__(self) -> str:
        return f"settings {self.settings_digest}, tree {self.tree_version}"

    @staticmethod
    def of(settings: Settings = DEFAULT, tree: HypothesisTree = STANDARD_TREE) -> Context:
        """The context of these settings and this tree."""
        return Context(settings.digest, tree.version)


@dataclass(frozen=True)
class Explanation:
    """All that was inferred about one demonstration.

    Its ``digest`` says *which* demonstration it explains, and under what: source, label and context. The values of the
    nodes follow from these and stay out of it, so that a demonstration cannot be counted twice.
    """

    task: str
    demonstration: str
    """Name of the demonstration, for people; not part of the digest."""
    performing_agent: str
    target_agent: str
    target_object: str
    source: str
    """Identifies what was observed, with the labelled interval; see ``facts.Episode``."""
    context: Context
    nodes: Nodes
    """Value and evidence of each node."""
    digest: str = field(init=False)
    """16 hexadecimal digits."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "nodes", FrozenMap(self.nodes))
        identity: list[Json] = [
            self.task,
            self.performing_agent,
            self.target_agent,
            self.target_object,
            self.source,
            self.context.settings_digest,
            self.context.tree_version,
        ]
        object.__setattr__(self, "digest", hashlib.sha256(canonical_text(identity).encode()).hexdigest()[:16])

    @property
    def recording(self) -> tuple[str, ...]:
        """Which recording it explains, for which agent and object; the label's words and times stay out of it.

        A source begins with the digest of what was recorded; the labelled interval follows. Facts from elsewhere
        (``facts:``) are told by task and name of their demonstration.
        """
        elsewhere = self.source.startswith("facts:")
        observed = ("facts", self.task, self.demonstration) if elsewhere else (self.source.partition(" ")[0],)
        return (*observed, self.target_agent, self.target_object)

    @property
    def content(self) -> str:
        """Digest of the nodes with their evidence, 16 hexadecimal digits: a changed copy is noticed by it."""
        nodes: dict[str, Json] = {name: node.to_json() for name, node in self.nodes.items()}
        return hashlib.sha256(canonical_text(nodes).encode()).hexdigest()[:16]

    @property
    def values(self) -> dict[str, Value]:
        """Value of each node, without its evidence."""
        return {name: node.value for name, node in self.nodes.items()}

    def to_json(self) -> dict[str, Json]:
        """Plain data; ``explanation_from_json`` reads it back."""
        texts = {name: getattr(self, name) for name in (*TEXTS, "digest", "content")}
        context = {name.name: getattr(self.context, name.name) for name in fields(Context)}
        return {**texts, **context, "nodes": {name: node.to_json() for name, node in self.nodes.items()}}


TEXTS = ("task", "demonstration", "performing_agent", "target_agent", "target_object", "source")


def explain(episode: Episode, tree: HypothesisTree = STANDARD_TREE, settings: Settings = DEFAULT) -> Explanation:
    """Instantiate the tree for one demonstration (Eq. 24, 25).

    Args:
        episode: Observations at start and end, with the label.
        tree: The hypothesis space.
        settings: Thresholds; those that shape facts must be the ones that the observations were made with.

    Raises:
        UnknownNameError: An observation fills no attribute of the tree.
        FactsError: An attribute cannot take the observed value.
    """
    return Explanation(
        task=episode.task,
        demonstration=episode.demonstration,
        performing_agent=episode.performing_agent,
        target_agent=episode.target_agent,
        target_object=episode.target_object,
        source=episode.source,
        context=Context.of(settings, tree),
        nodes=tree.instantiate(episode.start, episode.end, settings),
    )


def explanation_from_json(document: object, *, where: str | Path | None = None) -> Explanation:
    """Read back what ``Explanation.to_json`` gave.

    Raises:
        KnowledgeError: Something is missing or of another kind, or the digest does not fit the content.
    """
    hint = "restore the file from a copy, or learn anew from the recordings"
    try:
        data: Mapping[str, Any] = document  # type: ignore[assignment] # what does not fit is caught below
        explanation = Explanation(
            **{name: _text(data[name]) for name in TEXTS},
            context=Context(_text(data["settings_digest"]), _text(data["tree_version"])),
            nodes={_text(name): _observation(node) for name, node in data["nodes"].items()},
        )
        stored = {name: _text(data[name]) for name in ("digest", "content")}
        found = {name: getattr(explanation, name) for name in stored}
    except (KeyError, TypeError, AttributeError, ValueError, RecursionError) as error:
        raise KnowledgeError(f"not an explanation: {error!r}", where=where, hint=hint) from error
    for name, value in stored.items():
        if value != found[name]:
            raise KnowledgeError("damaged explanation", where=where, field=name, value=value, hint=hint)
    return explanation


def _observation(data: Mapping[str, Any]) -> Observation[Value]:
    value = UNKNOWN if data["value"] is None else _text(data["value"])
    if not isinstance(data["evidence"], dict):
        raise TypeError("evidence that is no object")
    return Observation(value, data["evidence"])


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f"a {type(value).__name__} where a text is wanted")
    return value
