"""Results as tables of text, for the command line and for the docs alike."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from taskgist_lab.evaluation.asking import Asked
from taskgist_lab.evaluation.clause_learning import ClauseScores, learner_text
from taskgist_lab.evaluation.episodes import EpisodeScores
from taskgist_lab.evaluation.experiments import (
    ALL,
    CLAUSE,
    PARTS,
    SETTINGS,
    SIZES,
    Needed,
    Needs,
    Table,
    Transfer,
    Waiting,
)
from taskgist_lab.evaluation.learner import PAPER, RULES
from taskgist_lab.evaluation.odd_ones import OddOnes
from taskgist_lab.evaluation.recognition import BINS, RecognitionScores
from taskgist_lab.evaluation.recognition import SHOWN_AFTER as RECOGNISED_AFTER
from taskgist_lab.evaluation.robustness import Comparison, Robustness, mean_f1
from taskgist_lab.evaluation.under_way import UnderWayScores
from taskgist_lab.evaluation.values import Result, Spread
from taskgist_lab.paper.published import COLUMNS

# --- A table of text, and how numbers stand in it.

NONE = "-"


@dataclass(frozen=True)
class Sheet:
    """A table.

    Args:
        title: What it shows.
        header: Names of the columns.
        rows: Cells, the first of each row names it.
        note: How to read it.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""


def waiting_text(needed: Waiting) -> str:
    """Median, and the quantiles on both sides in brackets."""
    median, low, high = ("never" if each is None else str(each) for each in (needed.median, needed.low, needed.high))
    return median if median == low == high else f"{median} ({low}-{high})"


def spread_text(value: Spread) -> str:
    """Mean, and the quantiles on both sides in brackets, in percent."""
    if value.mean is None or value.low is None or value.high is None:
        return NONE
    return f"{percent(value.mean)} ({value.low:.0%}-{value.high:.0%})"


def mean_text(value: Spread) -> str:
    """The mean alone, in whole percent."""
    return NONE if value.mean is None else percent(value.mean)


def truth_text(true: float, unknown: float) -> str:
    """Share that is true, and the unknown one where there is any."""
    return percent(true) if round(unknown, 2) == 0 else f"{percent(true)} ?{percent(unknown)}"


def percent(share: float) -> str:
    """A share in whole percent."""
    return f"{share:.0%}"


# --- Robustness as tables of text: what worse demonstrations cost, and which rule bears them.

SHOWN_AFTER = (5, 10)
"""Demonstrations after which robustness is shown."""


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
        rows.append((setting.text, facts, percent(outcome.understood), *scores, same))
    shown = (f"{score} {count}" for count in SHOWN_AFTER for score in ("recall", "precision"))
    return Sheet(
        f"What worse demonstrations cost: rule {rule!r}, {RULES[rule].text}",
        ("setting", "facts", "Table 4", *shown, "same tracker"),
        tuple(rows),
        "facts: share of facts that changed; Table 4: share of runs that have all three in the end, mean over tasks; "
        "recall and precision of the clause after so many demonstrations, judged by clean ones; same tracker: recall "
        "after the most, judged by demonstrations watched in the same way.",
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
    same = "noise, same tracker"
    rows = []
    for rule, score in found.scores.items():
        by_group = {name: [found.outcome(each, rule) for each in members] for name, members in groups.items()}
        means = [percent(mean_f1(outcomes)) for outcomes in by_group.values()]
        means += [percent(mean_f1(by_group["noise"], same=True))] if "noise" in groups else []
        understood = percent(found.outcome(settings[0], rule).understood)
        rows.append((rule, RULES[rule].text, *means, f"{score:.1%}", f"{found.questions[rule]:.1f}", understood))
    return Sheet(
        "Rules, by score",
        ("rule", "what it is", *groups, *([same] if "noise" in groups else []), "score", "questions", "Table 4"),
        tuple(rows),
        "F1, mean over settings and over clauses from 3, 5, 10 and 20 demonstrations, judged by clean held-out "
        f"demonstrations ({same}: by those watched in the same way). Score: mean of clean, noise and wrong. Questions: "
        "asked for each task within the longest run. Table 4: share of clean runs that have all three in the end.",
    )


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
        "The first demonstration from which on it holds to the end of the run, as in the paper's table: median over "
        "all runs (10 % and 90 % quantile); never: not in the end. Ever: share of runs that have all three at some "
        f"time, be it lost again; in the end: after {longest} demonstrations.",
    )


def curve_sheet(needs: Needs, after: tuple[int, ...] = (1, 2, 3, 4, 5, 7, 10, 15, 20)) -> Sheet:
    """Share of runs that have all three cells, by demonstrations."""
    whole = [row for row in needs.rows if row.column == ALL]
    shown = [count for count in after if count <= min(len(row.curve) for row in whole)]
    return Sheet(
        "Share of runs that have all three after so many demonstrations",
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
        rows.append((each.name, "with" if each.negatives else "without", *f1, *last, str(each.runs)))
    sizes = [table.after for table in found.learners[0].tables]
    missing = "".join(f" Not here: {name} ({why})." for name, why in found.absent.items())
    return Sheet(
        "Beside other learners, on the same facts: F1 by demonstrations",
        ("learner", "negatives", *map(str, sizes), f"recall {sizes[-1]}", f"precision {sizes[-1]}", "runs"),
        tuple(rows),
        "Means over tasks. With negatives: as many demonstrations of each of the other tasks." + missing,
    )


def clauses_sheet(found: ClauseScores, setting: str) -> Sheet:
    """F1 of both learners by demonstrations in one setting: as played, and as fulfilled."""
    rows = []
    sizes = found.sizes(setting)
    for learner, others in found.learners(setting):
        scores = [found.row(learner, others, setting, after) for after in sizes]
        played, fulfilled = ([mean_text(getattr(each, by)) for each in scores] for by in ("as_played", "as_fulfilled"))
        rows.append((learner_text(learner, others), *played, *fulfilled))
    heads = (f"{by} {after}" for by in ("played", "fulfilled") for after in sizes)
    return Sheet(
        f"Whole clauses beside the paper's rule, {setting}: F1 by demonstrations",
        ("learner", *heads),
        tuple(rows),
        f"Means over tasks and {found.runs} runs. Played: judged by the one task that a held-out demonstration was "
        f"played as; fulfilled: by all that it fulfils. Clauses are compared with {found.neutral} neutral "
        "manipulations, too.",
    )


def recognition_sheets(found: RecognitionScores) -> Iterator[Sheet]:
    """What is recognised, how good probabilities are, what is called none of the tasks, and how reliable that is."""
    runs = f"Means over tasks and {found.runs} runs."
    yield _recognition_sheet(
        found,
        "What is recognised, by demonstrations",
        {"right": "right", "as_played": "as played", "f1": "F1"},
        "Right: the task that is named first is one that the demonstration fulfils; as played: it is the one that it "
        f"was played as; F1: of all tasks that are more probable than not. {runs}",
    )
    yield _recognition_sheet(
        found,
        "How good the probabilities are, by demonstrations",
        {"log_loss": "log loss", "brier": "Brier"},
        f"Of each task in each episode; all unknown kinds together weigh as one task more. {runs}",
    )
    by_kind = ", ".join(f"{kind} {percent(share)}" for kind, share in found.unknown.items())
    yield _recognition_sheet(
        found,
        "What is called none of the tasks, by demonstrations",
        {"own_none": "own", "unknown_none": "unknown", "unknown_told": "at 3 %"},
        "Own: demonstrations of the tasks; unknown: manipulations of kinds that nobody has met, mean over kinds"
        + (f" ({found.recognisers[0]} after {RECOGNISED_AFTER}: {by_kind})" if by_kind else "")
        + f"; at 3 %: of these, if the line is drawn where 3 % of the tasks' demonstrations are called none. {runs}",
    )
    if RECOGNISED_AFTER in found.sizes:
        yield reliability_sheet(found, RECOGNISED_AFTER)


def _recognition_sheet(found: RecognitionScores, title: str, measures: Mapping[str, str], note: str) -> Sheet:
    """All recognisers by some measures, which are called as given, after each number of demonstrations."""
    columns = [(measure, after) for measure in measures for after in found.sizes]
    rows = [
        (name, *(_measured(getattr(found.row(name, after), measure), measure) for measure, after in columns))
        for name in found.recognisers
    ]
    return Sheet(title, ("recogniser", *(f"{measures[key]} {after}" for key, after in columns)), tuple(rows), note)


def _measured(value: Spread, measure: str) -> str:
    """A share in percent, a loss as a number."""
    if measure not in ("log_loss", "brier"):
        return mean_text(value)
    return NONE if value.mean is None else f"{value.mean:.3f}"


def odd_sheet(found: OddOnes) -> Sheet:
    """How well wrong labels are found."""
    called = "-" if found.precision is None else percent(found.precision)
    return Sheet(
        "Wrong labels, one among ten",
        ("called odd and wrong", "wrong and called odd", "wrong ones", "fulfil it all the same"),
        ((called, percent(found.recall), str(found.wrong), str(found.right_all_the_same)),),
        "One demonstration in ten is of another task; ten of each task are known.",
    )


def under_way_sheets(found: UnderWayScores) -> Iterator[Sheet]:
    """What is foreseen at each moment, and how reliable that is at half time."""
    rows = []
    for each in found.rows:
        shares = map(percent, (each.right, each.right_of_known, each.as_played))
        figures = (*shares, f"{each.log_loss:.2f}", f"{each.brier:.2f}")
        rows.append((percent(each.share), each.how, *figures))
    untold = f" At {found.untold} moments too little was tracked." if found.untold else ""
    yield Sheet(
        "Tasks under way, by the share of their time",
        ("of the time", "how", "right", "of known", "as played", "log loss", "Brier"),
        tuple(rows),
        f"{found.demonstrations} demonstrations that were held out. Right: the most probable task is one that it "
        "fulfils in the end; of known: the same where it is taken for granted that it is a known one; as played: it is "
        f"the one that it was played as.{untold}",
    )
    yield Sheet(
        "Reliability at half time, foreseen",
        ("probability", "so in", "of"),
        tuple((percent(mean), percent(share), str(count)) for mean, share, count in found.reliability),
    )


def episodes_sheet(found: EpisodeScores) -> Sheet:
    """How well episodes are found where no label tells of them."""
    within = (*found.start_within, *found.end_within)
    figures = (percent(found.found), *map(percent, within), f"{found.further_per_minute:.1f}")
    return Sheet(
        "Episodes found in recordings without their labels",
        ("recordings", "found", "start 0.5 s", "1 s", "end 0.5 s", "1 s", "further a minute", "task right", "headline"),
        ((str(found.recordings), *figures, percent(found.recognised), percent(found.headline)),),
        "Start and end are held against the thing's own way. Task right: for its target agent and thing; headline: the "
        "likeliest reading of all is that one.",
    )


def reliability_sheet(found: RecognitionScores, after: int) -> Sheet:
    """How often it was so where each recogniser gave a probability."""
    rows = []
    for number in range(BINS):
        low = number / BINS
        cells = []
        for name in found.recognisers:
            mine = next((each for each in found.curve(name, after) if each.low == low), None)
            cells.append(f"{percent(mine.observed)} of {mine.share:.1%}" if mine else NONE)
        rows.append((f"{percent(low)}-{percent(low + 1 / BINS)}", *cells))
    return Sheet(
        f"Reliability after {after} demonstrations: how often it was so",
        ("probability", *found.recognisers),
        tuple(rows),
        "In each cell: the share in which it was so, of the share of all probabilities that were given.",
    )


def asking_sheets(found: Asked) -> Iterator[Sheet]:
    """F1 by demonstrations and questions, and how often the teachers' words hold by the facts."""
    replies = ", ".join(f"{reply} {count}" for reply, count in found.replies.items() if count)
    yield Sheet(
        "What questions are worth: F1 by demonstrations and answers",
        ("other tasks", "demonstrations", "answers", "asked", "played", "fulfilled"),
        tuple(
            (
                str(each.others),
                str(each.demonstrations),
                str(each.questions),
                f"{each.asked:.1f}",
                mean_text(each.as_played),
                mean_text(each.as_fulfilled),
            )
            for each in found.rows
        ),
        f"Means over tasks and {found.runs} runs; asked: questions that were left, mean. Answers: {replies}.",
    )
    yield Sheet(
        "What the teachers mean, and how often it is so by the facts",
        ("task: what must be", "demonstrations"),
        tuple((meant, percent(share)) for meant, share in found.truth.items()),
        "Of all clean demonstrations that fulfil the task by the generator's checks.",
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


# --- Which tables tell a result.


def sheets_of(result: Result) -> Iterable[Sheet]:
    """The tables that tell a result."""
    if isinstance(result, Needs):
        return (needed_sheet(result), single_sheet(result), curve_sheet(result))
    if isinstance(result, Transfer):
        return tuple(transfer_sheets(result, (1, 5, 10)))
    if isinstance(result, Robustness):
        return (robustness_sheet(result, PAPER.name), rules_sheet(result))
    if isinstance(result, RecognitionScores):
        return tuple(recognition_sheets(result))
    if isinstance(result, ClauseScores):
        return tuple(clauses_sheet(result, setting) for setting in result.settings)
    if isinstance(result, OddOnes):
        return (odd_sheet(result),)
    if isinstance(result, UnderWayScores):
        return tuple(under_way_sheets(result))
    if isinstance(result, EpisodeScores):
        return (episodes_sheet(result),)
    if isinstance(result, Asked):
        return tuple(asking_sheets(result))
    assert isinstance(result, Comparison)
    return (peers_sheet(result),)
