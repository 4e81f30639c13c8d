"""taskgist beside its peers, on the very same facts.

Every learner gets the values of the same demonstrations in the same orders and is judged by the same held-out ones.
*Without negatives* it sees the task's own demonstrations alone, as taskgist does; *with negatives* it also sees as
many demonstrations of each other task, which taskgist has no use for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass

import numpy as np

from taskgist.errors import InputError
from taskgist.recording import Progress, silent
from taskgist.study.evaluation.coded import Coded, Codes
from taskgist.study.evaluation.draws import drawn, sizes_within
from taskgist.study.evaluation.holding import Held, HeldOut, Table, table_of
from taskgist.study.evaluation.learned import Learned, learned
from taskgist.study.evaluation.peers.cn2 import Cn2
from taskgist.study.evaluation.peers.decision_tree import DecisionTree
from taskgist.study.evaluation.peers.peer import Peer
from taskgist.study.evaluation.result import Result
from taskgist.study.evaluation.rules import INTERSECTION, PAPER
from taskgist.study.evaluation.transfer import CLAUSE, EFFECTS, SIZES, held_in

MOST_DRAWS = {"decision tree": 50, "CN2": 5}
"""Draws at most of peers that learn each draw anew, one after the other."""


@dataclass(frozen=True)
class Compared:
    """One learner.

    Attributes:
        name: Its name.
        text: What it is.
        negatives: Whether it saw demonstrations of other tasks.
        draws: Over how many orders it was averaged.
        tables: By the demonstrations that were learned from.
    """

    name: str
    text: str
    negatives: bool
    draws: int
    tables: tuple[Table, ...]


@dataclass(frozen=True)
class Comparison(Result):
    """All learners, and those that are not here."""

    learners: tuple[Compared, ...]
    absent: dict[str, str]
    """Why, by name."""


POPPER = "not compared; docs/evaluation.md says why"


def compared(
    coded: Coded,
    *,
    draws: int,
    seed: int,
    peers: Mapping[str, Callable[[], Peer]],
    progress: Progress = silent,
) -> Comparison:
    """Compare taskgist, plain intersection and peers.

    Args:
        coded: A pool.
        draws: Random orders of each task.
        seed: Their seed.
        peers: What makes each peer, by name; one that is not installed is told as absent.
        progress: Told how far it is.

    Raises:
        InputError: The pool has no demonstrations of a task to learn from.
    """
    judges = HeldOut.of(coded)
    orders = {task: drawn(coded, task, draws=draws, seed=seed) for task in coded.pool.tasks}
    sizes = sizes_within(SIZES, orders.values())
    learners = _own(orders, coded, judges, sizes)
    absent = {"Popper": POPPER}
    for name, make in peers.items():
        try:
            peer = make()
        except InputError as error:
            absent[name] = str(error)
            continue
        with closing(peer):
            learners += [_peer(peer, orders, judges, sizes, negatives, progress) for negatives in (False, True)]
    return Comparison(tuple(learners), absent)


def makers(seed: int) -> dict[str, Callable[[], Peer]]:
    """What makes each peer, by name."""
    return {DecisionTree.name: lambda: DecisionTree(seed), Cn2.name: Cn2}


def _own(orders: dict[str, Codes], coded: Coded, judges: HeldOut, sizes: tuple[int, ...]) -> list[Compared]:
    """The learner of taskgist, its whole clauses and their effects; and plain intersection."""
    draws = min(len(order) for order in orders.values())
    ours, plain = (
        {task: learned(order, coded, rule) for task, order in orders.items()} for rule in (PAPER, INTERSECTION)
    )

    def tables(known: Mapping[str, Learned], part: str) -> tuple[Table, ...]:
        held = ({task: held_in(each, judges, after, part) for task, each in known.items()} for after in sizes)
        return tuple(table_of(each, judges, after=after, part=part) for each, after in zip(held, sizes, strict=True))

    return [
        Compared("taskgist", PAPER.text, False, draws, tables(ours, CLAUSE)),
        Compared("taskgist, effects alone", "the same, preconditions left aside", False, draws, tables(ours, EFFECTS)),
        Compared("intersection", INTERSECTION.text, False, draws, tables(plain, CLAUSE)),
    ]


def _peer(
    peer: Peer,
    orders: dict[str, Codes],
    judges: HeldOut,
    sizes: tuple[int, ...],
    negatives: bool,
    progress: Progress,
) -> Compared:
    draws = min(MOST_DRAWS[peer.name], *(len(order) for order in orders.values()))
    tables = []
    for number, after in enumerate(sizes):
        progress(f"{peer.name}, {'with' if negatives else 'without'} negatives", number / len(sizes))
        held = {task: _judged(peer, orders, task, after, draws, judges, negatives) for task in orders}
        tables.append(table_of(held, judges, after=after, part=peer.name))
    return Compared(peer.name, peer.text, negatives, draws, tuple(tables))


def _judged(
    peer: Peer, orders: dict[str, Codes], task: str, after: int, draws: int, judges: HeldOut, negatives: bool
) -> Held:
    """What a peer says of each draw, (draws, demonstrations)."""
    return np.stack(
        [
            peer.judge(
                orders[task][draw, :after],
                _negatives(orders, task, draw, after if negatives else 0),
                judges.codes,
            ).astype(np.int8)
            for draw in range(draws)
        ]
    )


def _negatives(orders: dict[str, Codes], task: str, draw: int, after: int) -> Codes:
    others: Iterator[Codes] = (order[draw, :after] for other, order in orders.items() if other != task)
    return np.concatenate(list(others))
