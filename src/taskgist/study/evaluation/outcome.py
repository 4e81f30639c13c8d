"""How well a rule does in a setting, and the score that sums it up."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from taskgist.study.evaluation.sample import CLEAN
from taskgist.study.evaluation.spread import Spread, rounded

SCORED = (CLEAN, "noise", "wrong")
"""How the names of settings begin that count for the score, by group."""


@dataclass(frozen=True)
class After:
    """Scores of clauses learned from so many demonstrations: means over tasks, with their spread over draws."""

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
        understood: Share of draws that have the whole of Table 4 in the end, mean over tasks.
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
