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

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from taskgist.recording import Progress, silent
from taskgist.study.evaluation.coded import Coded, Codes
from taskgist.study.evaluation.draws import drawn, sizes_within
from taskgist.study.evaluation.holding import HeldOut, Table, table_of
from taskgist.study.evaluation.learned import Learned, from_tally
from taskgist.study.evaluation.needed import ALL, Needed, rows_of
from taskgist.study.evaluation.oracle import Oracle, published_oracle
from taskgist.study.evaluation.outcome import After, Outcome, scores_by_rule
from taskgist.study.evaluation.pool import Pool
from taskgist.study.evaluation.result import Result
from taskgist.study.evaluation.rules import RULES, Judging
from taskgist.study.evaluation.sample import CLEAN
from taskgist.study.evaluation.setting import SETTINGS, Setting
from taskgist.study.evaluation.spread import rounded
from taskgist.study.evaluation.tally import Tally, tally
from taskgist.study.evaluation.transfer import CLAUSE, held_in

JUDGED_AFTER = (3, 5, 10, 20)
"""Demonstrations after which clauses are judged."""


@dataclass(frozen=True)
class Robustness(Result):
    """All outcomes, and the score of each rule."""

    outcomes: tuple[Outcome, ...]
    scores: dict[str, float]
    """By rule, the best first."""
    questions: dict[str, float]
    """Questions of each rule for each task within the longest draw, mean over settings."""

    changed: dict[str, float]
    """By condition, the share of facts that are others than in the same demonstration watched cleanly."""

    def outcome(self, setting: str, rule: str) -> Outcome:
        """One rule in one setting."""
        return next(each for each in self.outcomes if (each.setting, each.rule) == (setting, rule))


def robustness(
    coded: Coded,
    *,
    draws: int,
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
        orders = _orders(coded, setting, draws, seed)
        tallies = {task: tally(order) for task, order in orders.items()}
        sizes = sizes_within(JUDGED_AFTER, orders.values())
        judges = (HeldOut.of(coded), HeldOut.of(coded, setting.condition))
        outcomes += [_outcome(coded, setting, rule, tallies, oracles, judges, sizes) for rule in rules]
        progress(f"learning: {setting.text}", number / len(settings))
    return Robustness(tuple(outcomes), scores_by_rule(outcomes), _questions(outcomes), _changed(coded.pool))


def _orders(coded: Coded, setting: Setting, draws: int, seed: int) -> dict[str, Codes]:
    how = {"draws": draws, "seed": seed}
    return {
        task: drawn(coded, task, **how, condition=setting.condition, wrong_share=setting.wrong_share)
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
