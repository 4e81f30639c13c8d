"""Results as tables of text, for the command line and for the docs alike."""

from __future__ import annotations

from collections.abc import Iterator

from taskgist.study.evaluation.comparison import Comparison
from taskgist.study.evaluation.holding import Table
from taskgist.study.evaluation.needed import ALL, Needed, Needs
from taskgist.study.evaluation.robustness import Robustness
from taskgist.study.evaluation.rules import RULES
from taskgist.study.evaluation.setting import SETTINGS
from taskgist.study.evaluation.sheet import NONE, Sheet, mean_text, percent, spread_text, truth_text, until
from taskgist.study.evaluation.transfer import CLAUSE, PARTS, SIZES, Transfer
from taskgist.study.intuition import COLUMNS

SHOWN_AFTER = (5, 10)
"""Demonstrations after which robustness is shown."""


def needed_sheet(needs: Needs) -> Sheet:
    """Demonstrations until Table 4 is reached."""
    tasks = tuple(dict.fromkeys(row.task for row in needs.rows))
    rows = []
    for task in tasks:
        whole = needs.row(task)
        by_column = (until(needs.row(task, column).needed, needs.row(task, column).reached) for column in COLUMNS)
        paper = str(whole.paper)
        rows.append((task, paper, until(whole.needed, whole.reached), *by_column, percent(whole.curve[-1])))
    longest = len(needs.rows[0].curve)
    return Sheet(
        "Demonstrations needed until the intuitive understanding of Table 4",
        ("task", "paper", "all three", *(f"to {each}" if each != "object" else each for each in COLUMNS), "kept"),
        tuple(rows),
        "Mean over draws (10 % to 90 % of the draws); in brackets the share of draws that reached it at all, where it "
        f"is not all; kept: share of draws that have it after {longest} demonstrations.",
    )


def curve_sheet(needs: Needs, after: tuple[int, ...] = (1, 2, 3, 4, 5, 7, 10, 15, 20)) -> Sheet:
    """Share of draws that have all three cells, by demonstrations."""
    whole = [row for row in needs.rows if row.column == ALL]
    shown = [count for count in after if count <= min(len(row.curve) for row in whole)]
    return Sheet(
        "Share of draws that have reached it",
        ("task", *map(str, shown)),
        tuple((row.task, *(percent(row.curve[count - 1]) for count in shown)) for row in whole),
    )


def single_sheet(needs: Needs) -> Sheet:
    """What single demonstrations show of each cell."""
    tasks = tuple(dict.fromkeys(row.task for row in needs.rows))
    return Sheet(
        "What single demonstrations show of Table 4",
        ("task", *(f"to {each}" if each != "object" else each for each in COLUMNS)),
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
        "Columns: demonstrations that were held out. Mean share in which it holds (?: in which that is unknown).",
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


def robustness_sheet(found: Robustness, rule: str) -> Sheet:
    """All settings under one rule."""
    rows = []
    for setting in (each for each in SETTINGS if any(each.name == one.setting for one in found.outcomes)):
        outcome = found.outcome(setting.name, rule)
        after = {each.demonstrations: each for each in outcome.after}
        scores = [
            mean_text(getattr(after[count], score)) if count in after else NONE
            for count in SHOWN_AFTER
            for score in ("recall", "precision")
        ]
        same = mean_text(outcome.after[-1].recall_same)
        facts = NONE if setting.wrong_share else f"{found.changed[setting.condition]:.1%}"
        rows.append((setting.text, facts, until(outcome.needed, outcome.reached, spread=False), *scores, same))
    shown = (f"{score} {count}" for count in SHOWN_AFTER for score in ("recall", "precision"))
    return Sheet(
        f"What worse demonstrations cost: rule {rule!r}, {RULES[rule].text}",
        ("setting", "facts", "needed", *shown, "same tracker"),
        tuple(rows),
        "facts: share of facts that changed; needed: mean over tasks, in brackets the share of draws that reach "
        "Table 4; recall and precision of the clause after so many demonstrations, judged by clean ones; same tracker: "
        "recall after the most, judged by demonstrations watched in the same way.",
    )


def rules_sheet(found: Robustness) -> Sheet:
    """All rules: F1 in each setting, score, questions."""
    settings = tuple(dict.fromkeys(each.setting for each in found.outcomes))
    groups = {
        "clean": ["clean"],
        "noise": [each for each in settings if each.startswith("noise")],
        "lost, gap, label": [each for each in settings if each.startswith(("lost", "gap", "label"))],
        "wrong": [each for each in settings if each.startswith("wrong")],
    }
    groups = {name: members for name, members in groups.items() if members}
    rows = []
    for rule, score in found.scores.items():
        means = (percent(_mean_f1(found, members, rule)) for members in groups.values())
        reached = percent(found.outcome(settings[0], rule).reached)
        rows.append((rule, RULES[rule].text, *means, percent(score), f"{found.questions[rule]:.1f}", reached))
    return Sheet(
        "Rules, by score",
        ("rule", "what it is", *groups, "score", "questions", "Table 4"),
        tuple(rows),
        "Score: mean F1 over settings and over clauses from 3, 5, 10 and 20 demonstrations; questions: asked for each "
        "task within the longest draw; Table 4: share of clean draws that reach it.",
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


def _mean_f1(found: Robustness, settings: list[str], rule: str) -> float:
    values = [after.f1.mean or 0.0 for name in settings for after in found.outcome(name, rule).after]
    return sum(values) / len(values)


def _single(row: Needed) -> str:
    shown = [NONE if row.agreeing is None else percent(row.agreeing)]
    shown += [] if row.alike is None else [f"{percent(row.alike)} alike"]
    return f"{row.wording}: {', '.join(shown)}"


def _by_share(item: tuple[str, float]) -> float:
    return item[1]
