"""Results as tables of text, for the command line and for the docs alike."""

from __future__ import annotations

from collections.abc import Iterator

from taskgist.study.evaluation.comparison import Comparison
from taskgist.study.evaluation.holding import Table
from taskgist.study.evaluation.needed import ALL, Needed, Needs
from taskgist.study.evaluation.sheet import NONE, Sheet, mean_text, percent, spread_text, truth_text, waiting_text
from taskgist.study.evaluation.transfer import CLAUSE, PARTS, SIZES, Transfer
from taskgist.study.intuition import COLUMNS


def needed_sheet(needs: Needs) -> Sheet:
    """Demonstrations until Table 4 is reached."""
    tasks = tuple(dict.fromkeys(row.task for row in needs.rows))
    rows = []
    for task in tasks:
        whole = needs.row(task)
        by_column = (waiting_text(needs.row(task, column).needed) for column in COLUMNS)
        shares = (percent(whole.ever), percent(whole.curve[-1]))
        rows.append((task, str(whole.paper), waiting_text(whole.needed), *by_column, *shares))
    longest = len(needs.rows[0].curve)
    return Sheet(
        "Demonstrations needed until the intuitive understanding of Table 4",
        (
            "task",
            "paper",
            "all three",
            *(f"to {each}" if each != "object" else each for each in COLUMNS),
            "ever",
            "in the end",
        ),
        tuple(rows),
        "The first demonstration from which on it holds to the end of the draw, as in the paper's table: median over "
        "all draws (10 % and 90 % quantile); never: not in the end. Ever: share of draws that have all three at some "
        f"time, be it lost again; in the end: after {longest} demonstrations.",
    )


def curve_sheet(needs: Needs, after: tuple[int, ...] = (1, 2, 3, 4, 5, 7, 10, 15, 20)) -> Sheet:
    """Share of draws that have all three cells, by demonstrations."""
    whole = [row for row in needs.rows if row.column == ALL]
    shown = [count for count in after if count <= min(len(row.curve) for row in whole)]
    return Sheet(
        "Share of draws that have all three after so many demonstrations",
        ("task", *map(str, shown)),
        tuple((row.task, *(percent(row.curve[count - 1]) for count in shown)) for row in whole),
    )


def single_sheet(needs: Needs) -> Sheet:
    """What single demonstrations show of each cell."""
    tasks = tuple(dict.fromkeys(row.task for row in needs.rows))
    return Sheet(
        "What single demonstrations show of Table 4",
        ("task", *_columns()),
        tuple((task, *(_single(needs.row(task, column)) for column in COLUMNS)) for task in tasks),
        "Share of demonstrations that show what must be learned, by the paper's word for it; then, where a node must "
        "be found to vary, the share of its most frequent value: the nearer to 100 %, the later it is found.",
    )


def scores_sheet(found: Transfer) -> Sheet:
    """Recall and precision by demonstrations."""
    rows = [
        (f"{score}, {part}", *(spread_text(getattr(found.table(after, part).overall, score)) for after in found.sizes))
        for part in PARTS
        for score in ("recall", "precision", "f1")
    ]
    return Sheet(
        "Held-out demonstrations: means over tasks",
        ("after demonstrations", *map(str, found.sizes)),
        tuple(rows),
        "clause: the paper's, effects and preconditions together; effects: preconditions left aside.",
    )


def table_sheet(table: Table) -> Sheet:
    """A table of tasks by tasks."""
    rows = []
    for task, true, unknown in zip(table.tasks, table.true, table.unknown, strict=True):
        scores = table.scores[task]
        cells = (truth_text(*each) for each in zip(true, unknown, strict=True))
        rows.append((task, *cells, spread_text(scores.recall), spread_text(scores.precision)))
    count = f"{table.after} demonstration{'s' * (table.after > 1)}"
    return Sheet(
        f"Which demonstrations fit each task ({table.part}), after {count}",
        ("learned", *table.tasks, "recall", "precision"),
        tuple(rows),
        "Columns: demonstrations that were held out. Mean share in which it holds (?: in which that is unknown). A "
        "clause that holds nowhere has precision 0.",
    )


def misses_sheet(found: Transfer, most: int = 3) -> Sheet:
    """By task: the means whose demonstrations are least recognised, and the predicates that fail."""
    rows = []
    for task, by_means in found.by_means.items():
        means = ", ".join(f"{name} {percent(share)}" for name, share in sorted(by_means.items(), key=_by_share))
        misses = [each for each in found.misses if each.task == task][:most]
        why = ", ".join(f"{each.node} = {each.value} ({percent(each.share)})" for each in misses)
        rows.append((task, means, why or NONE))
    return Sheet(
        f"Recall by means, after {found.sizes[-1]} demonstrations, and why it is not more",
        ("task", "recall by means", "predicates of the clause that fail (share of demonstrations)"),
        tuple(rows),
    )


def peers_sheet(found: Comparison) -> Sheet:
    """F1 of all learners by demonstrations; recall and precision after the most."""
    rows = []
    for each in found.learners:
        f1 = (mean_text(table.overall.f1) for table in each.tables)
        last = (mean_text(getattr(each.tables[-1].overall, score)) for score in ("recall", "precision"))
        rows.append((each.name, "with" if each.negatives else "without", *f1, *last, str(each.draws)))
    sizes = [table.after for table in found.learners[0].tables]
    missing = "".join(f" Not here: {name} ({why})." for name, why in found.absent.items())
    return Sheet(
        "Beside other learners, on the same facts: F1 by demonstrations",
        ("learner", "negatives", *map(str, sizes), f"recall {sizes[-1]}", f"precision {sizes[-1]}", "draws"),
        tuple(rows),
        "Means over tasks. With negatives: as many demonstrations of each of the other tasks." + missing,
    )


def transfer_sheets(found: Transfer, after: tuple[int, ...] = SIZES) -> Iterator[Sheet]:
    """Scores, tables of the whole clause, misses."""
    yield scores_sheet(found)
    for count in (count for count in after if count in found.sizes):
        yield table_sheet(found.table(count, CLAUSE))
    yield misses_sheet(found)


def _columns() -> tuple[str, ...]:
    return tuple(each if each == "object" else f"to {each}" for each in COLUMNS)


def _single(row: Needed) -> str:
    shown = [NONE if row.agreeing is None else percent(row.agreeing)]
    shown += [] if row.alike is None else [f"{percent(row.alike)} alike"]
    return f"{row.wording}: {', '.join(shown)}"


def _by_share(item: tuple[str, float]) -> float:
    return item[1]
