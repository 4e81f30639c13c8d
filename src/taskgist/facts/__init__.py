"""Facts: attributes, their values and evidence, comparisons, natures, and the hypothesis tree (sections 4 and 5)."""

from taskgist.facts.attributes import (
    NEGLIGIBLE,
    Attribute,
    ScoreAttribute,
    SidedAttribute,
    SymbolAttribute,
    score_bin,
)
from taskgist.facts.elsewhere import FACTS_FORMAT, SCHEMA, facts_schema, parse_facts, read_facts
from taskgist.facts.episode import Episode
from taskgist.facts.frozen import FrozenMap, Json, canonical_text, freeze, thaw
from taskgist.facts.predicates import Predicate, known_predicates, predicate_subtree, register, with_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.subtree import (
    Comparison,
    Instant,
    Leaf,
    Nature,
    NatureOf,
    Node,
    Nodes,
    Relation,
    Snapshot,
    Subtree,
)
from taskgist.facts.tree import LEVELS, HypothesisTree
from taskgist.facts.values import NOT_OBSERVED, UNKNOWN, Observation, Raw, Unknown, Value
from taskgist.facts.vocabulary import EFFORT_LEVELS, NO_ACTION, REACH_EFFORTS, SEE_EFFORTS

__all__ = [
    "EFFORT_LEVELS",
    "FACTS_FORMAT",
    "LEVELS",
    "NEGLIGIBLE",
    "NOT_OBSERVED",
    "NO_ACTION",
    "REACH_EFFORTS",
    "SCHEMA",
    "SEE_EFFORTS",
    "STANDARD_TREE",
    "UNKNOWN",
    "Attribute",
    "Comparison",
    "Episode",
    "FrozenMap",
    "HypothesisTree",
    "Instant",
    "Json",
    "Leaf",
    "Nature",
    "NatureOf",
    "Node",
    "Nodes",
    "Observation",
    "Predicate",
    "Raw",
    "Relation",
    "ScoreAttribute",
    "SidedAttribute",
    "Snapshot",
    "Subtree",
    "SymbolAttribute",
    "Unknown",
    "Value",
    "canonical_text",
    "facts_schema",
    "freeze",
    "known_predicates",
    "parse_facts",
    "predicate_subtree",
    "read_facts",
    "register",
    "score_bin",
    "thaw",
    "with_predicates",
]
