"""Put figures of learning and recognising into pages: ``python -m tools.learning_page --pool FILES ...``.

Each pool is one seed of ``taskgist evaluate``, made beforehand (``--pool``, ``--condition``), and beside each stand the
manipulations of the same seed that nobody has taught (``--unfamiliar``). Figures are means over the seeds. The pages'
text stays; tables stand between marks.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import fmean

import numpy as np

from taskgist.learning import ClausePosterior, Evidence, learn_clauses
from taskgist.learning.evidence import Effects, effects_of
from taskgist.learning.task_clauses import LIKELY
from taskgist.pipeline import explain_recording, shipped_recordings
from taskgist.recording import read
from taskgist_lab.evaluation.clause_learning import (
    CLAUSES,
    OF_OTHERS,
    ONE_WRONG,
    PAPER_RULE,
    ClauseScores,
    Judges,
    clause_learning,
    effects,
    learner_text,
    neutral_kinds,
)
from taskgist_lab.evaluation.learner import Coded
from taskgist_lab.evaluation.noise import CONDITIONS
from taskgist_lab.evaluation.odd_ones import odd_ones
from taskgist_lab.evaluation.pool import Pool, read_pool
from taskgist_lab.evaluation.recognition import OURS, SHOWN_AFTER, RecognitionScores, recognition
from taskgist_lab.evaluation.values import CLEAN
from tools.evaluation_page import told
from tools.markdown import filled, header, row

CLAUSES_PAGE, RECOGNITION_PAGE = Path("docs/how/clauses.md"), Path("docs/howto/recognition.md")
RUNS = 20
GIVE, AFTER_REAL = "give", (1, 3, 5)
"""The task of which real demonstrations are shipped, and after how many of them it is judged."""
MEASURES = {
    "right": "right",
    "as_played": "as played",
    "f1": "F1",
    "log_loss": "log loss",
    "brier": "Brier",
    "own_none": "own called none",
    "unknown_none": "unknown called none",
    "unknown_told": "unknown, where 3 % of own are",
}
"""Figures of recognition, and what they are called."""
NO_SHARES = ("log_loss", "brier")


def main() -> None:
    """Measure, and rewrite both pages."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pool", type=Path, nargs="+", required=True)
    parser.add_argument("--unfamiliar", type=Path, nargs="+", required=True)
    parser.add_argument("--runs", type=int, default=RUNS)
    parser.add_argument("--only", choices=("clauses", "recognition"), help="one of the pages alone")
    wishes = parser.parse_args()
    pools, others = ([read_pool(path) for path in paths] for paths in (wishes.pool, wishes.unfamiliar))
    coded = [Coded.of(pool) for pool in pools]
    if wishes.only != "recognition":
        learned = [clause_learning(each, runs=wishes.runs, seed=each.pool.seed, progress=told) for each in coded]
        parts = {"seeds": seeds(pools), "f1": f1(learned), "spoiled": spoiled(learned)}
        write(CLAUSES_PAGE, {**parts, "odd": odd(coded, wishes.runs), "handovers": handovers(coded)})
    if wishes.only != "clauses":
        found = [
            recognition(each, other, runs=wishes.runs, seed=each.pool.seed, progress=told)
            for each, other in zip(coded, others, strict=True)
        ]
        write(RECOGNITION_PAGE, {"seeds": seeds(pools), "recognised": recognised(found), "peers": peers(found)})


def write(page: Path, parts: dict[str, Iterator[str]]) -> None:
    """Fill a page."""
    page.write_text(filled(page.read_text(encoding="utf-8"), parts), encoding="utf-8")


def seeds(pools: Sequence[Pool]) -> Iterator[str]:
    """On what it was measured."""
    counts = [sum(each.condition == CLEAN for each in pool.samples) for pool in pools]
    names = ", ".join(str(pool.seed) for pool in pools)
    held = f"{counts[0]:,} demonstrations each" if len(set(counts)) == 1 else f"{min(counts):,} or more each"
    yield f"Measured on seeds {names}: {held}, a third of them held out; settings {pools[0].context.settings_digest}."


def f1(scores: Sequence[ClauseScores]) -> Iterator[str]:
    """F1 of all learners by demonstrations, clean and with wrong ones: as fulfilled, and as played in brackets."""
    sizes = scores[0].sizes(CLEAN)
    yield from header("learner", *map(str, sizes))
    for setting in (CLEAN, ONE_WRONG):
        for learner, others in scores[0].learners(setting):
            name = learner_text(learner, others)
            first = setting != CLEAN and learner == PAPER_RULE
            cells = (both(scores, learner, others, setting, after) for after in sizes)
            yield row(f"**{setting}:** {name}" if first else name, *cells)


def both(scores: Sequence[ClauseScores], learner: str, others: int | None, setting: str, after: int) -> str:
    """F1 in percent as fulfilled, and as played in brackets."""
    rows = [each.row(learner, others, setting, after) for each in scores]
    fulfilled, played = (fmean(getattr(each, by).mean or 0.0 for each in rows) for by in ("as_fulfilled", "as_played"))
    return f"{100 * fulfilled:.0f} ({100 * played:.0f})"


def spoiled(scores: Sequence[ClauseScores]) -> Iterator[str]:
    """F1 as fulfilled under each condition, of the paper's rule and of clauses compared with all other tasks."""
    conditions = [name for name in CONDITIONS if all(name in each.settings for each in scores)]
    sizes = [size for size in scores[0].sizes(CLEAN) if all(size in scores[0].sizes(name) for name in conditions)]
    most = max(others for learner, others in scores[0].learners(CLEAN) if learner == CLAUSES and others is not None)
    yield from header("watched with", *(f"clauses {size}" for size in sizes), *(f"paper {size}" for size in sizes))
    for name in conditions:
        cells = [
            f"{100 * fmean(each.row(learner, others, name, after).as_fulfilled.mean or 0.0 for each in scores):.0f}"
            for learner, others in ((CLAUSES, most), (PAPER_RULE, None))
            for after in sizes
        ]
        yield row(CONDITIONS[name].text, *cells)


def recognised(found: Sequence[RecognitionScores]) -> Iterator[str]:
    """What ours recognises, by demonstrations."""
    yield from header("after", *MEASURES.values())
    for after in found[0].sizes:
        yield row(after, *(measure(found, OURS, after, name) for name in MEASURES))


def peers(found: Sequence[RecognitionScores]) -> Iterator[str]:
    """All recognisers after ``SHOWN_AFTER`` demonstrations, and unknown kinds one by one."""
    yield from header("recogniser", *MEASURES.values())
    for recogniser in found[0].recognisers:
        yield row(recogniser, *(measure(found, recogniser, SHOWN_AFTER, name) for name in MEASURES))
    kinds = {kind: fmean(each.unknown[kind] for each in found) for kind in found[0].unknown}
    yield ""
    yield f"*Called none by ours: {', '.join(f'{kind} {100 * share:.0f} %' for kind, share in kinds.items())}.*"


def odd(coded: Sequence[Coded], runs: int) -> Iterator[str]:
    """How well wrong labels are found, seed by seed."""
    yield from header("seed", "called odd and wrong", "wrong and called odd", "wrong ones", "fulfil it all the same")
    for each in coded:
        found = odd_ones(each, runs=runs, seed=each.pool.seed, progress=told)
        shares = (f"{100 * share:.0f} %" for share in (found.precision or 0.0, found.recall))
        yield row(each.pool.seed, *shares, found.wrong, found.right_all_the_same)


def handovers(coded: Sequence[Coded]) -> Iterator[str]:
    """*Give* learned from real handovers, in generated demonstrations; and learned from those, in real ones."""
    real = [explain_recording(read(path)) for path in shipped_recordings(GIVE)]
    rows = [effects_of(each) for each in real]
    yield from header("learned from", "compared with", "recall", "precision", "F1")
    for after in AFTER_REAL:
        for others in (0, OF_OTHERS):
            scores = np.mean([of_give(each, rows[:after], others) for each in coded], axis=0)
            compared = f"five other tasks, {others} demonstrations each" if others else "no other task"
            cells = (f"{100 * share:.0f} %" for share in scores)
            yield row(f"{after} real handover{'s' * (after > 1)}", compared, *cells)
    known = [clauses_of_give(each, effects(each, each.of_task(GIVE, held_out=False)[:OF_OTHERS])) for each in coded]
    held = [sum(posterior.probability(each.nodes) > LIKELY for each in real) for posterior in known]
    yield ""
    yield (
        f"*Learned from {OF_OTHERS} generated demonstrations, it holds in {' / '.join(map(str, held))} of the "
        f"{len(real)} real handovers, by seed.*"
    )


def of_give(coded: Coded, rows: Sequence[Effects], others: int) -> tuple[float, float, float]:
    """Recall, precision and F1 of *give* in held-out demonstrations of all tasks, which weigh the same."""
    judges = Judges.of(coded)
    held = judges.holds(clauses_of_give(coded, rows, others))
    task_of = judges.held_out.task_of
    weights = 1.0 / np.bincount(task_of)[task_of]
    true = judges.fulfilled[coded.pool.tasks.index(GIVE)]
    hits, said, are = (float(mask @ weights) for mask in (held & true, held, true))
    return hits / are, hits / said if said else 0.0, 2 * hits / (said + are)


def clauses_of_give(coded: Coded, rows: Sequence[Effects], others: int = OF_OTHERS) -> ClausePosterior:
    """What *give* means by these demonstrations, compared with so many of each of the pool's other tasks."""
    tasks = [task for task in coded.pool.tasks if task != GIVE] if others else []
    kinds = {task: effects(coded, coded.of_task(task, held_out=False)[:others]) for task in tasks}
    return learn_clauses(Evidence.of({**neutral_kinds(coded), **kinds, GIVE: rows}), GIVE)


def measure(found: Sequence[RecognitionScores], recogniser: str, after: int, name: str) -> str:
    """The mean of one figure over seeds."""
    mean = fmean(getattr(each.row(recogniser, after), name).mean or 0.0 for each in found)
    return f"{mean:.2f}" if name in NO_SHARES else f"{100 * mean:.0f} %"


if __name__ == "__main__":
    main()
