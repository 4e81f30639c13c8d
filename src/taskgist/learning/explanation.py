"""An explanation: every node of the tree for one demonstration (6, step 1).

**Several targets.** What is hidden from two people, or given as pen and paper, is explained for each pair of target
agent and target object alone (9.6, 9.7), and these explanations are merged to one: it counts as one demonstration. A
node has a value there if it has that value for every pair, because the task was meant for each of them. Where pairs
differ the merged node is unknown, so that it is evidence for neither value, and ``differing`` tells who had which: it
becomes a question (``understanding``). Where nothing differs but a pair is unknown, so is the merged node.
"""

from __future__ import annotations

import hashlib
import math
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Any, Literal

from taskgist.common.frozen import FrozenMap, Json, canonical_text, plain_text
from taskgist.common.text import one_or_list
from taskgist.errors import KnowledgeError, UnknownNameError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import Episode, HypothesisTree, Nodes, TreeOf
from taskgist.facts.values import UNKNOWN, Observation, Unknown, Value
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
class SymbolicAction:
    """One thing that was done with a target object between the start and the end (A of ⟨WI, A, WF⟩, 10).

    Agents are told by their role: "performer", "target", or "other".

    Args:
        kind: What: "grasp", "carry", "hand over".
        by: Who.
        start_s: When it began, seconds of its recording.
        end_s: When it was over; the same, where it is a moment.
        to: To whom it was handed over.
    """

    kind: str
    by: str
    start_s: float
    end_s: float
    to: str | None = None

    @property
    def name(self) -> str:
        """What it is called whenever it is done: ``"hand over by performer to target"``."""
        return f"{self.kind} by {self.by}{f' to {self.to}' if self.to else ''}"

    def to_json(self) -> dict[str, Json]:
        """Plain data."""
        return {each.name: getattr(self, each.name) for each in fields(self)}


@dataclass(frozen=True)
class Explanation:
    """All that was inferred about one demonstration.

    Its ``digest`` says *which* demonstration it explains, and under what: source, label, whether it was done wrong, and
    context. The values of the nodes follow from these and stay out of it: so no demonstration is counted twice.
    """

    task: str
    demonstration: str
    """Name of the demonstration, for people; not part of the digest."""
    performing_agent: str
    target_agents: tuple[str, ...]
    """For whom; sorted."""
    target_objects: tuple[str, ...]
    """With what; sorted."""
    source: str
    """Identifies what was observed, with the labelled interval; see ``facts.Episode``."""
    context: Context
    nodes: Nodes
    """Value and evidence of each node."""
    parts: tuple[Explanation, ...] = ()
    """Of several targets: the explanation of each pair, agent by agent; empty where there is one pair."""
    wrong: bool = False
    """Whether it shows how the task must not be done. It is evidence against then, and never counted for the task."""
    actions: tuple[SymbolicAction, ...] | None = None
    """What was done, by the time at which it began; None: nobody looked. It says nothing of what the task means."""
    bare: bool = field(default=False, compare=False)
    """Whether its evidence was left aside: it takes a tenth of the memory, says the same, and cannot be saved."""
    digest: str = field(init=False)
    """16 hexadecimal digits."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "nodes", FrozenMap(self.nodes))
        for name in TARGETS:
            object.__setattr__(self, name, tuple(sorted(getattr(self, name))))
        identity: list[Json] = [
            self.task,
            self.performing_agent,
            one_or_list(self.target_agents),
            one_or_list(self.target_objects),
            self.source,
            self.context.settings_digest,
            self.context.tree_version,
            *(["wrong"] if self.wrong else []),  # so that the digests of all others are what they always were
        ]
        object.__setattr__(self, "digest", hashlib.sha256(canonical_text(identity).encode()).hexdigest()[:16])

    @property
    def tree_of(self) -> TreeOf:
        """Whose tree it is: the performing agent's own where it is explained as done for nobody else."""
        return "performer" if self.target_agents == (self.performing_agent,) else "target"

    @property
    def recording(self) -> tuple[str, ...]:
        """Which recording it explains; the label's words and times stay out of it.

        A source begins with the digest of what was recorded; the labelled interval follows. Facts from elsewhere
        (``facts:``) are told by task and name of their demonstration.
        """
        if self.source.startswith("facts:"):
            return ("facts", self.task, self.demonstration)
        return (self.source.partition(" ")[0],)

    def is_rival_of(self, other: Explanation) -> bool:
        """Whether both explain one recording for an agent and an object that they share, but not the same label.

        What is done right is not done wrong. But a wrong *hide* may be a right *show*, or a wrong one as well.

        A target agent's tree and a performing agent's own are no rivals: nothing is counted in both.
        """
        return (
            self.digest != other.digest
            and (self.task == other.task or not (self.wrong or other.wrong))
            and self.tree_of == other.tree_of
            and self.recording == other.recording
            and not set(self.target_agents).isdisjoint(other.target_agents)
            and not set(self.target_objects).isdisjoint(other.target_objects)
        )

    def marked_wrong(self) -> Explanation:
        """The same as a demonstration of how the task must not be done."""
        return replace(self, wrong=True, parts=tuple(replace(part, wrong=True) for part in self.parts))

    def part(self, agent: str, name: str) -> Explanation:
        """The explanation of one pair of target agent and target object; itself, where it has no other.

        Raises:
            UnknownNameError: It is about no such agent or object.
        """
        for kind, asked, known in (("agent", agent, self.target_agents), ("object", name, self.target_objects)):
            if asked not in known:
                raise UnknownNameError(kind, asked, known)
        pairs = self.parts or (self,)
        return next(each for each in pairs if (each.target_agents, each.target_objects) == ((agent,), (name,)))

    def called(self, part: Explanation) -> str:
        """What tells one of its parts from the others: the agent, the object, or both ("P2 and pen")."""
        agents = part.target_agents if len(self.target_agents) > 1 else ()
        objects = part.target_objects if len(self.target_objects) > 1 else ()
        return " and ".join((*agents, *objects))

    def differing(self, node: str) -> FrozenMap[str, tuple[Explanation, ...]]:
        """The parts behind each value of a node in which they differ; empty where they do not."""
        found: dict[str, tuple[Explanation, ...]] = {}
        for part in self.parts:
            if node in part.nodes and not isinstance(value := part.nodes[node].value, Unknown):
                found[value] = (*found.get(value, ()), part)
        return FrozenMap(found if len(found) > 1 else {})

    @property
    def content(self) -> str:
        """Digest of the nodes with their evidence, 16 hexadecimal digits: a changed copy is noticed by it.

        Raises:
            KnowledgeError: Its evidence was left aside.
        """
        if self.bare:
            hint = "load it with its evidence (evidence=True)"
            raise KnowledgeError("its evidence was left aside", where=self.demonstration, hint=hint)
        return _content({name: node.to_json() for name, node in self.nodes.items()})

    @property
    def values(self) -> dict[str, Value]:
        """Value of each node, without its evidence."""
        return {name: node.value for name, node in self.nodes.items()}

    def without_evidence(self) -> Explanation:
        """The same, its evidence left aside."""
        nodes = {name: _bare(node.value) for name, node in self.nodes.items()}
        return replace(self, nodes=nodes, parts=tuple(part.without_evidence() for part in self.parts), bare=True)

    def to_json(self) -> dict[str, Json]:
        """Plain data; ``explanation_from_json`` reads it back.

        Raises:
            KnowledgeError: Its evidence was left aside.
        """
        texts: dict[str, Json] = {name: getattr(self, name) for name in (*TEXTS, "digest", "content")}
        targets: dict[str, Json] = {TARGETS[name]: one_or_list(getattr(self, name)) for name in TARGETS}
        context = {name.name: getattr(self.context, name.name) for name in fields(Context)}
        nodes: dict[str, Json] = {name: node.to_json() for name, node in self.nodes.items()}
        parts: dict[str, Json] = {"parts": [part.to_json() for part in self.parts]} if self.parts else {}
        wrong: dict[str, Json] = {"wrong": True} if self.wrong else {}
        done: dict[str, Json] = {} if self.actions is None else {"actions": [each.to_json() for each in self.actions]}
        return {**texts, **targets, **context, **wrong, "nodes": nodes, **done, **parts}


TEXTS = ("task", "demonstration", "performing_agent", "source")
Role = Literal["target agents", "target objects"]
ROLES: Mapping[Role, str] = {"target agents": "target_agents", "target objects": "target_objects"}
"""Fields of those of which there may be several."""
TARGETS = {"target_agents": "target_agent", "target_objects": "target_object"}
"""Fields of targets, and what documents call them: one name stands there as it is, several as a list."""


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
        target_agents=(episode.target_agent,),
        target_objects=(episode.target_object,),
        source=episode.source,
        context=Context.of(settings, tree),
        nodes=tree.instantiate(episode.start, episode.end, settings),
    )


def merged(parts: Iterable[Explanation]) -> Explanation:
    """One explanation of a demonstration that was meant for several agents, or with several objects (9.6, 9.7).

    Args:
        parts: The explanation of each pair of target agent and target object, in any order; one is returned as it is.

    Raises:
        KnowledgeError: They explain different demonstrations, or pairs are missing or stand there twice.
    """
    pairs = sorted(parts, key=lambda part: (part.target_agents, part.target_objects))
    if len(pairs) == 1:
        return pairs[0]
    if not pairs:
        raise KnowledgeError("no pair of target agent and object", hint="explain one at least")
    first = pairs[0]
    for part in pairs[1:]:
        for name in (*TEXTS, "context", "wrong"):
            if getattr(part, name) != getattr(first, name):
                hint = "merge explanations of one demonstration"
                raise KnowledgeError("is another demonstration", field=name, value=getattr(part, name), hint=hint)
    agents, objects = (tuple(sorted({target for part in pairs for target in getattr(part, name)})) for name in TARGETS)
    wanted = [((agent,), (name,)) for agent, name in product(agents, objects)]
    if [(part.target_agents, part.target_objects) for part in pairs] != wanted:
        hint = "give each target agent with each target object, once"
        raise KnowledgeError("not one explanation for each pair", field="parts", value=len(pairs), hint=hint)
    whole = replace(first, target_agents=agents, target_objects=objects, nodes={}, parts=tuple(pairs))
    return replace(whole, nodes={name: _merged_node(whole, name) for name in first.nodes})


def _merged_node(whole: Explanation, name: str) -> Observation[Value]:
    """The value that all parts have, whose evidence stands there; else unknown, and why."""
    values = [part.nodes[name].value if name in part.nodes else UNKNOWN for part in whole.parts]
    differing = whole.differing(name)
    if differing:
        who = {value: [whole.called(part) for part in parts] for value, parts in differing.items()}
        told = "; ".join(f"{value} for {', '.join(names)}" for value, names in who.items())
        return Observation(UNKNOWN, {"reason": f"differs: {told}", "differs": dict(who)})
    if UNKNOWN in values:
        unknown = [whole.called(part) for part, value in zip(whole.parts, values, strict=True) if value is UNKNOWN]
        return Observation(UNKNOWN, {"reason": f"unknown for {', '.join(unknown)}"})
    return Observation(values[0])


def explanation_from_json(document: object, *, where: str | Path | None = None, evidence: bool = True) -> Explanation:
    """Read back what ``Explanation.to_json`` gave.

    Args:
        document: Plain data.
        where: For errors.
        evidence: Whether to keep the evidence; see ``Explanation.bare``.

    Raises:
        KnowledgeError: Something is missing or of another kind, or the digest does not fit the content.
    """
    hint = "restore the file from a copy, or learn anew from the recordings"
    try:
        data: Mapping[str, Any] = document  # type: ignore[assignment] # what does not fit is caught below
        left = not evidence and "parts" not in data  # what is said of several follows from the evidence, too
        explanation = Explanation(
            **{name: _text(data[name]) for name in TEXTS},
            target_agents=_names(data["target_agent"]),
            target_objects=_names(data["target_object"]),
            context=Context(_text(data["settings_digest"]), _text(data["tree_version"])),
            nodes={sys.intern(name): _observation(node, bare=left) for name, node in data["nodes"].items()},
            parts=tuple(_part(part, where) for part in data.get("parts", ())),
            wrong=_flag(data.get("wrong", False)),
            actions=tuple(map(_action, data["actions"])) if "actions" in data else None,
            bare=left,
        )
        stored = {name: _text(data[name]) for name in ("digest", "content")}
        found = {"digest": explanation.digest, "content": _content(data["nodes"])}
    except (KeyError, TypeError, AttributeError, ValueError, RecursionError) as error:
        raise KnowledgeError(f"not an explanation: {error!r}", where=where, hint=hint) from error
    for name, value in stored.items():
        if value != found[name]:
            raise KnowledgeError("damaged explanation", where=where, field=name, value=value, hint=hint)
    several = len(explanation.target_agents) * len(explanation.target_objects) > 1
    if (several or explanation.parts) and not _follows(explanation):
        raise KnowledgeError("damaged explanation", where=where, field="parts", hint=hint)
    return explanation if evidence or explanation.bare else explanation.without_evidence()


def _content(nodes: Mapping[str, Any]) -> str:
    """Digest of the plain data of nodes, 16 hexadecimal digits."""
    return hashlib.sha256(plain_text(nodes).encode()).hexdigest()[:16]


def _follows(explanation: Explanation) -> bool:
    """Whether an explanation of several targets is what its parts give."""
    try:
        return (
            bool(explanation.parts) and replace(merged(explanation.parts), actions=explanation.actions) == explanation
        )
    except KnowledgeError:
        return False


def _part(document: Mapping[str, Any], where: str | Path | None) -> Explanation:
    if "parts" in document:
        raise TypeError("parts of a part")
    return explanation_from_json(document, where=where)


def _names(value: object) -> tuple[str, ...]:
    if not isinstance(value, list):
        return (_text(value),)
    if len(value) < 2:
        raise TypeError("a list of less than two names")
    return tuple(map(_text, value))


def _observation(data: Mapping[str, Any], *, bare: bool) -> Observation[Value]:
    value = UNKNOWN if data["value"] is None else _text(data["value"])
    if not isinstance(data["evidence"], dict):
        raise TypeError("evidence that is no object")
    return _bare(value) if bare else Observation(value, data["evidence"])


@lru_cache(maxsize=4096)
def _bare(value: Value) -> Observation[Value]:
    """A value without evidence: one for all that have it."""
    return Observation(value)


def _action(data: Mapping[str, Any]) -> SymbolicAction:
    times = [data["start_s"], data["end_s"]]
    if any(isinstance(each, bool) or not isinstance(each, (int, float)) or not math.isfinite(each) for each in times):
        raise TypeError("a time that is no number")
    to = None if data["to"] is None else _text(data["to"])
    return SymbolicAction(_text(data["kind"]), _text(data["by"]), float(times[0]), float(times[1]), to)


def _flag(value: object) -> bool:
    if not isinstance(value, bool):
        raise TypeError(f"a {type(value).__name__} where true or false is wanted")
    return value


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f"a {type(value).__name__} where a text is wanted")
    return value
