"""Fig. 15, 17, 18: what is understood of *show* after two, three and four demonstrations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from taskgist.learning import Understanding
from taskgist.study.paper.demonstrations import Judged, understanding_of
from taskgist.study.paper.result import Section, compared

TASK = "show"
KEPT = (
    ("reach", 2, "Fig. 15, 16", True),
    ("reach", 3, "Fig. 17, Table 4", False),
    ("placement", 3, "Table 2", True),
    ("placement", 4, "Fig. 18, Table 2", False),
)
"""Subtrees, after how many demonstrations, where the paper says it, and whether they still are understood to matter."""
DEEPEST = (
    ("posture", 3, "Fig. 17, 18", ("value.1", "value.2")),
    ("posture", 4, "Fig. 18", ("class",)),
)
"""The same for the deepest nodes that are kept of a subtree."""
ABOUT = (
    "The third demonstration prunes the subtree of reaching; the fourth, the first one of people who stand, lifts the "
    "posture by a level and prunes where the object ends. So much does the paper's text tell of its figures."
)


def figures_section(judged: Mapping[str, tuple[Judged, ...]]) -> Section:
    """Compare the understanding of *show* while it grows.

    Args:
        judged: The judged demonstrations by task.
    """
    grown = {count: understanding_of(TASK, judged[TASK][:count]) for count in (2, 3, 4)}
    kept = (
        compared(f"{subtree} is kept after {count}", where, paper, bool(nodes_kept(grown[count], subtree)))
        for subtree, count, where, paper in KEPT
    )
    deepest = (
        compared(f"deepest of {subtree} after {count}", where, paper, deepest_kept(grown[count], subtree))
        for subtree, count, where, paper in DEEPEST
    )
    nodes = {str(count): [each.node.name for each in understood.kept] for count, understood in grown.items()}
    return Section("figures", "Show after 2, 3 and 4 demonstrations", (*kept, *deepest), ABOUT, {"kept": nodes})


def nodes_kept(understanding: Understanding, subtree: str) -> list[str]:
    """Names of the nodes of a subtree that are kept, in canonical order."""
    return [each.node.name for each in understanding.kept if each.node.name.partition(".")[0] == subtree]


def deepest_kept(understanding: Understanding, subtree: str) -> Sequence[str]:
    """Those of them that have no kept node below, without the subtree's name."""
    names = nodes_kept(understanding, subtree)
    above = {understanding.tree.node(name).parent for name in names}
    return [name.partition(".")[2] for name in names if name not in above]
