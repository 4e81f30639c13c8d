"""What trackers, operators and teachers spoil, and which rule bears it best.

Demonstrations are watched under a condition, or some of them are wrong: demonstrations of another task that somebody
labelled as this one. What is learned from them is judged twice: by held-out demonstrations that are as good as the
demonstrator made them (was the meaning learned?), and by held-out ones watched under the same condition (does the
clause recognise the task with this tracker?).

**The score of a rule** is the mean of F1 over clauses learned from 3, 5, 10 and 20 demonstrations, each task weighing
the same, whole clauses judged by clean held-out demonstrations. Three groups of settings have a third of it each: clean
demonstrations, tracker noise, wrong demonstrations; others hardly differ from clean ones and do not count. Questions
stand beside it: they cost a person's time. They are answered by the clauses that the paper printed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass

import numpy as np

from taskgist.common.workers import Progress, silent
from taskgist.errors import InputError
from taskgist_lab.evaluation.experiments import (
    ALL,
    CLAUSE,
    EFFECTS,
    SETTINGS,
    SIZES,
    Held,
    HeldOut,
    Needed,
    Setting,
    Table,
    held_in,
    rows_of,
    table_of,
)
from taskgist_lab.evaluation.learner import (
    INTERSECTION,
    PAPER,
    RULES,
    Coded,
    Codes,
    Judging,
    Learned,
    Oracle,
    Tally,
    from_tally,
    in_random_order,
    learned,
    published_oracle,
    sizes_within,
    tally,
)
from taskgist_lab.evaluation.peers import Cn2, DecisionTree, Peer
from taskgist_lab.evaluation.pool import Pool
from taskgist_lab.evaluation.values import CLEAN, Result, Spread, rounded

# --- How well a rule does in a setting, and the score that sums it up.

SCORED = (CLEAN, "noise", "wrong")
"""How the names of settings begin that count for the score, by group."""


@dataclass(frozen=True)
class After:
    """Scores of clauses learned from so many demonstrations: means over tasks, with their spread over runs."""

    demonstrations: int
    recall: Spread
    precision: Spread
    f1: Spread
    recall_same: Spread
    """Recall in held-out demonstrations watched under the same condition."""
    f1_same: Spread
    """F1 in these."""
    questions: float
    """Questions asked for each task so far."""


@dataclass(frozen=True)
class Outcome:
    """One rule in one setting.

    Attributes:
        setting: Name of the setting.
        rule: Name of the rule.
        understood: Share of runs that have the whole of Table 4 in the end, mean over tasks.
        after: Scores by demonstrations.
    """

    setting: str
    rule: str
    understood: float
    after: tuple[After, ...]


def mean_f1(outcomes: Iterable[Outcome], *, same: bool = False) -> float:
    """Mean over outcomes and numbers of demonstrations, judged by clean ones or by those of the same tracker."""
    after = [each for outcome in outcomes for each in outcome.after]
    return float(np.mean([(each.f1_same if same else each.f1).mean or 0.0 for each in after]))


def scores_by_rule(outcomes: Sequence[Outcome]) -> dict[str, float]:
    """Score of each rule, the best first: its groups of settings weigh the same."""
    scores = {rule: _score([each for each in outcomes if each.rule == rule]) for rule in _rules(outcomes)}
    return dict(sorted(scores.items(), key=lambda item: -item[1]))


def _score(outcomes: Sequence[Outcome]) -> float:
    groups = ([each for each in outcomes if each.setting.startswith(prefix)] for prefix in SCORED)
    return rounded(np.mean([mean_f1(group) for group in groups if group]))


def _rules(outcomes: Sequence[Outcome]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(each.rule for each in outcomes))


# --- Learning in every setting, by every rule.

JUDGED_AFTER = (3, 5, 10, 20)
"""Demonstrations after which clauses are judged."""


@dataclass(frozen=True)
class Robustness(Result):
    """All outcomes, and the score of each rule."""

    outcomes: tuple[Outcome, ...]
    scores: dict[str, float]
    """By rule, the best first."""
    questions: dict[str, float]
    """Questions of each rule for each task within the longest run, mean over settings."""

    changed: dict[str, float]
    """By condition, the share of facts that are others than in the same demonstration watched cleanly."""

    def outcome(self, setting: str, rule: str) -> Outcome:
        """One rule in one setting."""
        return next(each for each in self.outcomes if (each.setting, each.rule) == (setting, rule))


def robustness(
    coded: Coded,
    *,
    runs: int,
    seed: int,
    rules: Iterable[Judging] = tuple(RULES.values()),
    progress: Progress = silent,
) -> Robustness:
    """Learn in every setting of which the pool has demonstrations, by every rule.

    Raises:
        InputError: The pool has no demonstrations of a task to learn from.
    """
    rules = tuple(rules)
    settings = [each for each in SETTINGS if each.condition in coded.pool.conditions]
    oracles = {task: published_oracle(task, coded) for task in coded.pool.tasks}
    outcomes: list[Outcome] = []
    for number, setting in enumerate(settings, start=1):
        orders = _orders(coded, setting, runs, seed)
        tallies = {task: tally(order) for task, order in orders.items()}
        sizes = sizes_within(JUDGED_AFTER, orders.values())
        judges = (HeldOut.of(coded), HeldOut.of(coded, setting.condition))
        outcomes += [_outcome(coded, setting, rule, tallies, oracles, judges, sizes) for rule in rules]
        progress(f"learning: {setting.text}", number / len(settings))
    return Robustness(tuple(outcomes), scores_by_rule(outcomes), _questions(outcomes), _changed(coded.pool))


def _orders(coded: Coded, setting: Setting, runs: int, seed: int) -> dict[str, Codes]:
    how = {"runs": runs, "seed": seed}
    return {
        task: in_random_order(coded, task, **how, condition=setting.condition, wrong_share=setting.wrong_share)
        for task in coded.pool.tasks
    }


def _outcome(
    coded: Coded,
    setting: Setting,
    rule: Judging,
    tallies: dict[str, Tally],
    oracles: dict[str, Oracle],
    judges: tuple[HeldOut, HeldOut],
    sizes: tuple[int, ...],
) -> Outcome:
    known = {task: from_tally(counted, coded, rule, oracles[task]) for task, counted in tallies.items()}
    rows = [_all_columns(task, each, coded) for task, each in known.items()]
    return Outcome(
        setting=setting.name,
        rule=rule.name,
        understood=rounded(np.mean([row.curve[-1] for row in rows])),
        after=tuple(_after(known, judges, count) for count in sizes),
    )


def _all_columns(task: str, known: Learned, coded: Coded) -> Needed:
    return next(row for row in rows_of(task, known, coded) if row.column == ALL)


def _after(known: dict[str, Learned], judges: tuple[HeldOut, HeldOut], count: int) -> After:
    clean, same = (_table(known, each, count) for each in judges)
    asked = [each.asked[:, count - 1].mean() for each in known.values()]
    return After(
        demonstrations=count,
        recall=clean.overall.recall,
        precision=clean.overall.precision,
        f1=clean.overall.f1,
        recall_same=same.overall.recall,
        f1_same=same.overall.f1,
        questions=rounded(np.mean(asked)),
    )


def _table(known: dict[str, Learned], judges: HeldOut, count: int) -> Table:
    held = {task: held_in(each, judges, count, CLAUSE) for task, each in known.items()}
    return table_of(held, judges, after=count, part=CLAUSE)


def _questions(outcomes: list[Outcome]) -> dict[str, float]:
    by_rule: dict[str, list[float]] = {}
    for each in outcomes:
        by_rule.setdefault(each.rule, []).append(each.after[-1].questions)
    return {rule: rounded(np.mean(values)) for rule, values in by_rule.items()}


def _changed(pool: Pool) -> dict[str, float]:
    clean = {(each.task, each.number): each.values for each in pool.samples if each.condition == CLEAN}
    changed: dict[str, list[float]] = {}
    for each in pool.samples:
        if (true := clean.get((each.task, each.number))) is not None:
            other = [a != b for a, b in zip(each.values, true, strict=True)]
            changed.setdefault(each.condition, []).append(sum(other) / len(other))
    return {condition: rounded(np.mean(shares)) for condition, shares in changed.items()}


# --- taskgist beside its peers, on the very same facts.
#
# Every learner gets the values of the same demonstrations in the same orders and is judged by the same held-out ones.
# *Without negatives* it sees the task's own demonstrations alone, as taskgist does; *with negatives* it also sees as
# many demonstrations of each other task, which taskgist has no use for.

MOST_RUNS = {"decision tree": 50, "CN2": 5}
"""Runs at most of peers that learn each run anew, one after the other."""


@dataclass(frozen=True)
class Compared:
    """One learner.

    Attributes:
        name: Its name.
        text: What it is.
        negatives: Whether it saw demonstrations of other tasks.
        runs: Over how many orders it was averaged.
        tables: By the demonstrations that were learned from.
    """

    name: str
    text: str
    negatives: bool
    runs: int
    tables: tuple[Table, ...]


@dataclass(frozen=True)
class Comparison(Result):
    """All learners, and those that are not here."""

    learners: tuple[Compared, ...]
    absent: dict[str, str]
    """Why, by name."""


POPPER = "not compared; docs/research/evaluation.md says why"


def compared(
    coded: Coded,
    *,
    runs: int,
    seed: int,
    peers: Mapping[str, Callable[[], Peer]],
    progress: Progress = silent,
) -> Comparison:
    """Compare taskgist, plain intersection and peers.

    Args:
        coded: A pool.
        runs: Random orders of each task.
        seed: Their seed.
        peers: What makes each peer, by name; one that is not installed is told as absent.
        progress: Told how far it is.

    Raises:
        InputError: The pool has no demonstrations of a task to learn from.
    """
    judges = HeldOut.of(coded)
    orders = {task: in_random_order(coded, task, runs=runs, seed=seed) for task in coded.pool.tasks}
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
    runs = min(len(order) for order in orders.values())
    ours, plain = (
        {task: learned(order, coded, rule) for task, order in orders.items()} for rule in (PAPER, INTERSECTION)
    )

    def tables(known: Mapping[str, Learned], part: str) -> tuple[Table, ...]:
        held = ({task: held_in(each, judges, after, part) for task, each in known.items()} for after in sizes)
        return tuple(table_of(each, judges, after=after, part=part) for each, after in zip(held, sizes, strict=True))

    return [
        Compared("taskgist", PAPER.text, False, runs, tables(ours, CLAUSE)),
        Compared("taskgist, effects alone", "the same, preconditions left aside", False, runs, tables(ours, EFFECTS)),
        Compared("intersection", INTERSECTION.text, False, runs, tables(plain, CLAUSE)),
    ]


def _peer(
    peer: Peer,
    orders: dict[str, Codes],
    judges: HeldOut,
    sizes: tuple[int, ...],
    negatives: bool,
    progress: Progress,
) -> Compared:
    runs = min(MOST_RUNS[peer.name], *(len(order) for order in orders.values()))
    tables = []
    for number, after in enumerate(sizes):
        progress(f"{peer.name}, {'with' if negatives else 'without'} negatives", number / len(sizes))
        held = {task: _judged(peer, orders, task, after, runs, judges, negatives) for task in orders}
        tables.append(table_of(held, judges, after=after, part=peer.name))
    return Compared(peer.name, peer.text, negatives, runs, tuple(tables))


def _judged(
    peer: Peer, orders: dict[str, Codes], task: str, after: int, runs: int, judges: HeldOut, negatives: bool
) -> Held:
    """What a peer says of each run, (runs, demonstrations)."""
    return np.stack(
        [
            peer.judge(
                orders[task][run, :after],
                _negatives(orders, task, run, after if negatives else 0),
                judges.codes,
            ).astype(np.int8)
            for run in range(runs)
        ]
    )


def _negatives(orders: dict[str, Codes], task: str, run: int, after: int) -> Codes:
    others: Iterator[Codes] = (order[run, :after] for other, order in orders.items() if other != task)
    return np.concatenate(list(others))
