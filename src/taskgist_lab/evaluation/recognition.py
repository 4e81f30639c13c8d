"""How well known tasks are recognised, in demonstrations that were held out, and in what nobody has taught.

All recognisers learn each task from the same demonstrations, one label for each as an operator gives it, and know the
same neutral manipulations. They are then asked for held-out demonstrations of all tasks, which may fulfil several tasks
(judged by the generator's own lines of sight and distances), and for manipulations of kinds that none of them has met,
which are none of the tasks: those of the source ``unfamiliar`` that fulfil none.

Each task weighs the same, and all unknown kinds together weigh as one task more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.workers import Progress, silent
from taskgist.errors import InputError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.values import Observation
from taskgist.learning.evidence import Effects, Evidence
from taskgist.learning.literals import vocabularies
from taskgist.recognition.tasks import Recogniser
from taskgist_lab.evaluation.clause_learning import SIZES, Judges, effects, neutral_kinds
from taskgist_lab.evaluation.learner import Coded, in_random_order, sizes_within
from taskgist_lab.evaluation.peers import door
from taskgist_lab.evaluation.pool import Pool
from taskgist_lab.evaluation.values import CLEAN, Result, Spread, rounded

OURS = "clauses"
MOST_RUNS = 10
"""Random orders, at most: a forest learns for a second in each."""
SHOWN_AFTER = 10
"""Demonstrations after which unknown kinds are told one by one, and reliability is drawn."""
BINS = 10
"""Of the reliability curve, of equal width."""
OWN_NONE = 0.03
"""Share of held-out demonstrations that are called none of the tasks where recognisers are compared in that."""
CERTAIN = 1e-4
"""Probabilities are kept so far from 0 and 1 where their logarithm is taken."""

Kinds = Mapping[str, Sequence[Effects]]
"""Demonstrations by kind: a task, or a manipulation that is none."""


@dataclass(frozen=True)
class Probabilities:
    """What a recogniser says of some episodes.

    Args:
        of_task: Probability of each task, (episodes, tasks).
        none: That it is none of them, (episodes,).
        named: Index of the task that is named first, (episodes,); None: of the most probable one.
    """

    of_task: Array
    none: Array
    named: Indices | None = None

    def part(self, start: int, stop: int) -> Probabilities:
        """Those of some of the episodes."""
        return Probabilities(self.of_task[start:stop], self.none[start:stop], self.best[start:stop])

    @property
    def best(self) -> Indices:
        """Index of the task that is named first, (episodes,)."""
        return self.of_task.argmax(axis=1) if self.named is None else self.named

    @property
    def none_is_best(self) -> Mask:
        """Whether it is more probably none of the tasks than the most probable one, (episodes,)."""
        return np.asarray(self.none >= self.of_task.max(axis=1))


Recognising = Callable[[Kinds, tuple[str, ...], Sequence[Effects]], Probabilities]
"""Learns from demonstrations by kind what these tasks are, and says what episodes are."""


def ours(kinds: Kinds, tasks: tuple[str, ...], episodes: Sequence[Effects]) -> Probabilities:
    """The recogniser of ``recognition.tasks``."""
    evidence = Evidence.of(kinds)
    recogniser = Recogniser.by_evidence(dict.fromkeys(tasks, evidence))
    found = [recogniser.recognise({name: Observation(value) for name, value in each.items()}) for each in episodes]
    by_task = [{one.task: one.probability for one in each.tasks} for each in found]
    return Probabilities(
        np.array([[each[task] for task in tasks] for each in by_task]).reshape(len(found), len(tasks)),
        np.array([each.none for each in found]),
        np.array([tasks.index((each.best or each.tasks[0]).task) for each in found], dtype=int),
    )


# --- Peers: classifiers of scikit-learn, one yes or no for each task, of the very same facts.

FEATURES = tuple((each.node.name, value) for each in vocabularies(STANDARD_TREE) for value in each.values)
"""Values of nodes that literals are about."""


def _rows(demonstrations: Sequence[Effects]) -> Array:
    """One column for each value of each node that literals are about; what is unknown has none."""
    rows = [[float(each.get(node) == value) for node, value in FEATURES] for each in demonstrations]
    return np.array(rows).reshape(len(rows), len(FEATURES))


def _peer(make: Callable[[], Any], *, weighed: bool = True) -> Recognising:
    """A classifier that says yes or no for each task; none has what the most probable task leaves.

    All kinds of demonstrations weigh the same, as they do for ours, where the classifier is able to weigh.
    """

    def recognise(kinds: Kinds, tasks: tuple[str, ...], episodes: Sequence[Effects]) -> Probabilities:
        rows = _rows([each for name in kinds for each in kinds[name]])
        names = np.array([name for name in kinds for _ in kinds[name]])
        labels = np.stack([names == task for task in tasks], axis=1)
        whole = max(len(kinds[task]) for task in tasks)  # a demonstration of a task weighs 1
        weights = np.array([whole / len(each) for each in kinds.values() for _ in each])
        classifier = make().fit(rows, labels, **({"sample_weight": weights} if weighed else {}))
        by_task = classifier.predict_proba(_rows(episodes))  # (episodes, [no,] yes) of each task
        found = np.stack([each[:, -1] for each in by_task], axis=1)
        return Probabilities(found, 1.0 - found.max(axis=1))

    return recognise


def peers(seed: int) -> dict[str, Recognising]:
    """The recognisers that are compared with, by name; none where scikit-learn is not installed.

    Args:
        seed: Of the forest.
    """
    try:
        ensemble, neighbours, bayes, several = (
            door(f"sklearn.{name}", name) for name in ("ensemble", "neighbors", "naive_bayes", "multioutput")
        )
    except InputError:
        return {}
    return {
        "random forest": _peer(lambda: ensemble.RandomForestClassifier(100, random_state=seed)),
        "5 nearest": _peer(lambda: neighbours.KNeighborsClassifier(5), weighed=False),
        "naive Bayes": _peer(lambda: several.MultiOutputClassifier(bayes.BernoulliNB())),
    }


# --- Scores.


@dataclass(frozen=True)
class RecognitionScore:
    """One recogniser after so many demonstrations of each task; means with their spread over runs.

    Attributes:
        recogniser: Its name.
        after: Demonstrations of each task.
        right: Share of held-out demonstrations of which the task that is named first is one that they fulfil.
        as_played: Of which it is the one that they were played as.
        f1: F1 of all tasks that are more probable than not, mean over tasks.
        log_loss: Natural logarithm, mean over tasks and episodes.
        brier: Mean squared difference of probability and truth.
        own_none: Share of held-out demonstrations that are called none of the tasks.
        unknown_none: Share of manipulations of unknown kinds that are, mean over kinds; None without any.
        unknown_told: The same where "none" is said from such a probability on that ``OWN_NONE`` of the held-out
            demonstrations are called none: how well both are told apart, wherever the line is drawn.
    """

    recogniser: str
    after: int
    right: Spread
    as_played: Spread
    f1: Spread
    log_loss: Spread
    brier: Spread
    own_none: Spread
    unknown_none: Spread
    unknown_told: Spread


@dataclass(frozen=True)
class Reliable:
    """How often it was so where a recogniser gave probabilities of one bin.

    Attributes:
        recogniser: Its name.
        after: Demonstrations of each task.
        low: Least probability of the bin.
        predicted: Mean probability.
        observed: Share in which it was so.
        share: Of all probabilities that were given.
    """

    recogniser: str
    after: int
    low: float
    predicted: float
    observed: float
    share: float


@dataclass(frozen=True)
class RecognitionScores(Result):
    """All recognisers."""

    rows: tuple[RecognitionScore, ...]
    reliability: tuple[Reliable, ...]
    unknown: Mapping[str, float]
    """By unknown kind: the share that ours calls none of the tasks, after ``SHOWN_AFTER``."""
    runs: int

    @property
    def sizes(self) -> tuple[int, ...]:
        """Demonstrations after which there are scores."""
        return tuple(dict.fromkeys(each.after for each in self.rows))

    @property
    def recognisers(self) -> tuple[str, ...]:
        """Names of the recognisers, ours first."""
        return tuple(dict.fromkeys(each.recogniser for each in self.rows))

    def row(self, recogniser: str, after: int) -> RecognitionScore:
        """The scores of a recogniser after so many demonstrations."""
        return next(each for each in self.rows if (each.recogniser, each.after) == (recogniser, after))

    def curve(self, recogniser: str, after: int) -> tuple[Reliable, ...]:
        """The reliability of a recogniser."""
        return tuple(each for each in self.reliability if (each.recogniser, each.after) == (recogniser, after))


def recognition(
    coded: Coded, unfamiliar: Pool, *, runs: int, seed: int, progress: Progress = silent
) -> RecognitionScores:
    """Learn all tasks in many random orders, and recognise what was held out and what nobody has taught.

    Args:
        coded: A pool.
        unfamiliar: Manipulations of kinds that nothing is compared with; those that fulfil a task of the pool are left
            aside.
        runs: Random orders; ``MOST_RUNS`` at most.
        seed: Their seed.
        progress: Told how far it is.

    Raises:
        InputError: The pool has no demonstrations of a task to learn from, or none held out.
    """
    asked = Asked.of(coded, unfamiliar)
    runs = min(runs, MOST_RUNS)
    orders = {task: in_random_order(coded, task, runs=runs, seed=seed) for task in asked.tasks}
    sizes = sizes_within(SIZES, orders.values())
    recognisers = {OURS: ours, **peers(seed)}
    rows: list[RecognitionScore] = []
    reliability: list[Reliable] = []
    by_kind: dict[str, float] = {}
    for number, (name, after) in enumerate((name, after) for name in recognisers for after in sizes):
        progress(f"recognising: {name} after {after}", number / (len(recognisers) * len(sizes)))
        found = []
        for run in range(runs):
            kinds = {task: effects(coded, orders[task][run, :after]) for task in asked.tasks}
            found.append(asked.answers(recognisers[name], kinds))
        if (name, after) == (OURS, SHOWN_AFTER):
            for kind in asked.unknown:
                by_kind[kind] = rounded(np.mean([each.unknown[kind].none_is_best.mean() for each in found]))
        rows.append(asked.score(name, after, found))
        reliability += asked.reliability(name, after, found)
    return RecognitionScores(tuple(rows), tuple(reliability), by_kind, runs)


@dataclass(frozen=True)
class Answers:
    """What a recogniser said in one run.

    Args:
        own: Of held-out demonstrations.
        unknown: Of manipulations that nobody has taught, by kind.
    """

    own: Probabilities
    unknown: Mapping[str, Probabilities]


@dataclass(frozen=True, eq=False)
class Asked:
    """What recognisers are asked for.

    Args:
        tasks: Names of the tasks.
        own: Held-out demonstrations.
        played: Index of the task that each was played as, (demonstrations,).
        fulfilled: Whether each fulfils each task, (demonstrations, tasks).
        neutral: Neutral manipulations by kind, which are known.
        unknown: Manipulations that fulfil no task, by kind, which are not.
    """

    tasks: tuple[str, ...]
    own: Sequence[Effects]
    played: Indices
    fulfilled: Mask
    neutral: Kinds
    unknown: Kinds

    @staticmethod
    def of(coded: Coded, unfamiliar: Pool) -> Asked:
        """All clean held-out demonstrations of a pool, the shipped manipulations, and the unfamiliar ones.

        Raises:
            InputError: None of a task were held out.
        """
        judges = Judges.of(coded)
        own = judges.held_out
        unknown: dict[str, list[Effects]] = {}
        for each in unfamiliar.samples:
            if each.condition == CLEAN and not set(each.fulfilled) & set(own.tasks):
                pairs = zip(unfamiliar.nodes, each.values, strict=True)
                unknown.setdefault(each.task, []).append({name: value for name, value in pairs if value is not None})
        known = neutral_kinds(coded)
        return Asked(own.tasks, effects(coded, own.codes), own.task_of, judges.fulfilled.T, known, unknown)

    def answers(self, recognise: Recognising, known: Kinds) -> Answers:
        """What a recogniser says of everything, after it has learned from demonstrations of each task."""
        episodes = [*self.own, *(each for kind in self.unknown.values() for each in kind)]
        found = recognise({**self.neutral, **known}, self.tasks, episodes)
        unknown, start = {}, len(self.own)
        for kind, manipulations in self.unknown.items():
            unknown[kind] = found.part(start, start + len(manipulations))
            start += len(manipulations)
        return Answers(found.part(0, len(self.own)), unknown)

    def score(self, name: str, after: int, found: Sequence[Answers]) -> RecognitionScore:
        """The scores of all runs."""
        runs = [self._scores(each) for each in found]
        spreads = {key: Spread.of([each[key] for each in runs]) for key in runs[0]}
        return RecognitionScore(name, after, **spreads)

    def _scores(self, answers: Answers) -> dict[str, float]:
        own, weights = answers.own, self._weights
        best = own.best
        said = own.of_task > 0.5
        hits = (said & self.fulfilled).T @ weights
        f1 = 2 * hits / np.maximum(said.T @ weights + self.fulfilled.T @ weights, CERTAIN)
        given, true, share = self._all(answers)
        kept = given.clip(CERTAIN, 1 - CERTAIN)
        loss = -np.where(true, np.log(kept), np.log1p(-kept))
        unknown = [each.none_is_best.mean() for each in answers.unknown.values()]
        order = np.argsort(-own.none, kind="stable")
        line = own.none[order][np.searchsorted(np.cumsum(weights[order]), OWN_NONE)]
        told = [(each.none > line).mean() for each in answers.unknown.values()]
        return {
            "right": float(self.fulfilled[np.arange(len(best)), best] @ weights),
            "as_played": float((best == self.played) @ weights),
            "f1": float(f1.mean()),
            "log_loss": float((loss.mean(axis=1) * share).sum()),
            "brier": float((((given - true) ** 2).mean(axis=1) * share).sum()),
            "own_none": float(own.none_is_best @ weights),
            "unknown_none": float(np.mean(unknown)) if unknown else float("nan"),
            "unknown_told": float(np.mean(told)) if told else float("nan"),
        }

    @property
    def _weights(self) -> Array:
        """Weights of held-out demonstrations: those of each task weigh the same, all together 1."""
        return np.asarray(1.0 / np.bincount(self.played)[self.played] / len(self.tasks))

    def _all(self, answers: Answers) -> tuple[Array, Mask, Array]:
        """Probabilities and truth of everything that was asked for, (episodes, tasks), and weights, (episodes,).

        All that is unknown weighs as one task more.
        """
        given, true, weights = [answers.own.of_task], [self.fulfilled], [self._weights * len(self.tasks)]
        for each in answers.unknown.values():
            given.append(each.of_task)
            true.append(np.zeros(each.of_task.shape, dtype=bool))
            weights.append(np.full(len(each.none), 1.0 / len(each.none) / len(answers.unknown)))
        share = np.concatenate(weights)
        return np.concatenate(given), np.concatenate(true), share / share.sum()

    def reliability(self, name: str, after: int, found: Sequence[Answers]) -> Iterator[Reliable]:
        """How often it was so, by bins of probability; bins that nothing fell into are left out."""
        given, true, share = (np.concatenate(each) for each in zip(*map(self._all, found), strict=True))
        weights = np.repeat(share[:, None] / share.sum() / given.shape[1], given.shape[1], axis=1)
        bins = np.minimum((given * BINS).astype(int), BINS - 1)
        for number in range(BINS):
            mine = bins == number
            if mine.any():
                mass = weights[mine].sum()
                predicted = float((given[mine] * weights[mine]).sum() / mass)
                observed = float((true[mine] * weights[mine]).sum() / mass)
                yield Reliable(name, after, number / BINS, *map(rounded, (predicted, observed, mass)))
