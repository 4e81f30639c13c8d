"""``taskgist paper``: every published result beside ours."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table
from rich.text import Text

from taskgist.cli.common import (
    FAILED,
    OK,
    JsonOption,
    ReplaceOption,
    check_target,
    command,
    console,
    make_folder,
    print_json,
    progress_bar,
)
from taskgist.common.frozen import Json
from taskgist.common.workers import Progress
from taskgist.errors import InputError, KnowledgeError
from taskgist.pipeline.shipped import shipped_study
from taskgist_lab.paper.displacements import (
    Displacements,
    digest_of,
    measure,
    outdated,
    read_displacements,
    shipped_displacements,
    wilson,
    write_displacements,
)
from taskgist_lab.paper.judging import Judged, judge_study
from taskgist_lab.paper.published import Goal, Result, Section, Verdict, tally
from taskgist_lab.paper.results import Report, report

MOST_DISPLACEMENTS = 10_000


@command
def paper(
    displacements: Annotated[
        int | None,
        typer.Option(
            "--displacements",
            min=1,
            max=MOST_DISPLACEMENTS,
            help="Displace everything so often, now: it takes long.",
        ),
    ] = None,
    save: Annotated[
        Path | None, typer.Option("--save", help="Keep these displacements in a file, and go on from what it holds.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Folder for pictures of scenes and trees; made if new.")
    ] = None,
    replace: ReplaceOption = False,
    as_json: JsonOption = False,
) -> int:
    """Compare every published result with ours.

    Judges the 23 recreated demonstrations of the paper's study, learns its six tasks, and puts clauses, figures and
    tables beside the printed ones. Each result is equal, or differs and is explained, or fails; if one fails, the exit
    code is 1.

    How well the clauses bear that people and things are moved was measured beforehand, and is held to a goal of 95 %:
    one that is clearly missed gives exit code 1, too. --displacements 200 measures it anew, on all cores, which takes
    two of them a quarter of an hour; with --save it can be stopped and taken up again.

    Example: taskgist paper

    Example: taskgist paper --displacements 200 --save displacements.json.gz

    Example: taskgist paper -o pictures --json
    """
    _check(displacements, save, out, replace=replace)
    with progress_bar(quiet=as_json) as progress:
        judged = judge_study(progress=progress)
        displaced = (
            shipped_displacements() if displacements is None else _measured(judged, displacements, save, progress)
        )
        found = report(judged, displaced)
        pictures = _pictures(judged, out, progress) if out else ()
    if as_json:
        print_json({**found.to_json(), "pictures": [str(path) for path in pictures]})
    else:
        print_report(found, pictures)
    return FAILED if found.failed else OK


def _check(displacements: int | None, save: Path | None, out: Path | None, *, replace: bool) -> None:
    """Refuse what could not be written, before any long work."""
    if save is not None:
        if displacements is None:
            hint = "add --displacements 200"
            raise InputError("there are no new displacements to keep", field="--save", value=str(save), hint=hint)
        check_target(save, "--save", replace=True)
    if out is not None:
        make_folder(out, "--out", replace=replace)


def _measured(
    judged: Mapping[str, tuple[Judged, ...]], count: int, save: Path | None, progress: Progress
) -> Displacements:
    study = digest_of(judged)
    known = read_displacements(save) if save and save.exists() else Displacements(study)
    problem = outdated(known, study)
    if problem:
        hint = "name another file, or remove this one"
        raise KnowledgeError(f"was measured with {problem}", where=save, field="--save", hint=hint)
    for more in measure(known, count, progress=progress):
        known = more
        if save:
            write_displacements(known, save)
    return known


def _pictures(judged: Mapping[str, tuple[Judged, ...]], folder: Path, progress: Progress) -> tuple[Path, ...]:
    from taskgist_lab.view import study_pictures  # with matplotlib, which only pictures should wait for

    return tuple(study_pictures(shipped_study(), judged, folder, progress))


# --- Tables, headings and verdicts in the style of the comparison with the paper.

WIDTH = 112
"""Columns of the widest table, and of paragraphs."""
STYLES: Mapping[Verdict | Goal, str] = {
    Verdict.EQUAL: "green",
    Verdict.DIFFERS_EXPLAINED: "yellow",
    Verdict.FAILS: "bold red",
    Goal.MET: "green",
    Goal.OPEN: "yellow",
    Goal.NOT_MET: "bold red",
}


def heading(section: Section) -> None:
    """Print a section's title, and what was done."""
    console.print(Text(section.title, style="bold"))
    paragraph(section.about)


def paragraph(text: str, *, indent: str = "", style: str = "dim") -> None:
    """Print running text, in lines of readable length."""
    for line in textwrap.wrap(text, WIDTH, initial_indent=indent, subsequent_indent=indent):
        console.print(Text(line, style=style))


def plain_table(title: str, *columns: str, numbers: int = 0) -> Table:
    """An empty table without lines; its last ``numbers`` columns before the verdict are aligned to the right."""
    table = Table(title=title or None, title_justify="left", title_style="bold", box=None, padding=(0, 2, 0, 0))
    for place, column in enumerate(columns):
        right = len(columns) - 1 - numbers <= place < len(columns) - 1
        table.add_column(column, justify="right" if right else "left", header_style="dim", no_wrap=True)
    return table


def show(table: Table) -> None:
    """Print a table as wide as it wants to be, also where the output is no terminal."""
    table.width = console.measure(table, options=console.options.update(max_width=WIDTH)).maximum
    console.print(table)


def verdict_text(result: Result) -> Text:
    """The verdict in its colour."""
    if result.verdict is None:
        return Text("not measured", style="dim")
    return Text(result.verdict.value, style=STYLES[result.verdict])


def share_words(result: Result, displaced: Json) -> str:
    """The share of displacements with its 95 % interval, whose ends are rounded outwards; nothing if none was measured.

    Args:
        result: What is held to the goal.
        displaced: What else is known of the displacements of its task.
    """
    if not isinstance(result.ours, float) or not isinstance(displaced, Mapping):
        return ""
    count = displaced["draws"]
    assert isinstance(count, int)
    low, high = wilson(round(result.ours * count), count)
    return f"{result.ours:.1%} ({math.floor(1000 * low) / 10:.1f}-{math.ceil(1000 * high) / 10:.1f}%)"


def words(value: Json) -> str:
    """A value in a cell: a list by its parts; a mapping by its size, as its names are told elsewhere."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Mapping):
        return f"{len(value)} predicates"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(map(str, value)) or "nothing"
    return "nothing" if value is None else str(value)


# --- The paper's tables of numbers, with ours in the same cells.

COLUMNS = ("see", "reach", "object", "all")


def table_2(section: Section) -> Table:
    """Table 2: each row as printed, and below it our exact fractions."""
    columns = [column for column in _map(section.results[0].paper) if column != "value"]
    table = plain_table("", "demonstration", "", *columns, "verdict")
    for result in section.results:
        for who, row in (("paper", _map(result.paper)), ("ours", _map(result.ours))):
            name = result.name.removeprefix("demonstration ") if who == "paper" else ""
            cells = [_cell(row, column) for column in columns]
            if "verdict" in row:  # what the wide band makes of the last row
                cells[0] = _cell(row, "verdict")
            table.add_row(name, who, *cells, verdict_text(result) if who == "ours" else "")
    return table


def table_3(section: Section) -> Table:
    """Table 3: seconds per demonstration, theirs and ours."""
    header = ("task", "demonstrations", "paper, s", "ours, s", "perspective, s", "ours is", "verdict")
    table = plain_table("", *header, numbers=5)
    named = {result.name: result for result in section.results}
    for task, figures in section.details.items():
        count, time = named[f"{task}: demonstrations"], named[f"{task}: seconds"]
        counts = f"{count.paper}" if count.paper == count.ours else f"{count.paper}, ours {count.ours}"
        perspective = _map(figures)["perspective_s"]
        factor = time.explanation.partition(",")[0]
        table.add_row(
            task, counts, f"{time.paper}", f"{time.ours:.3f}", f"{perspective:.3f}", factor, verdict_text(time)
        )
    return table


def table_4(section: Section) -> Table:
    """Table 4: demonstrations needed, paper / ours (fewest-most over all orders)."""
    table = plain_table("", "paper / ours", *COLUMNS, "verdict")
    named = {result.name: result for result in section.results}
    for task, spans in section.details.items():
        own = {column: named.get(f"{task}: {column}") for column in COLUMNS}
        cells = [_needed(own[column], _map(_map(spans)[column])) for column in COLUMNS]
        table.add_row(task, *cells, _worst([result for result in own.values() if result]))
    return table


def lost_table(tasks: Json) -> Table:
    """What each clause loses in a smaller tree, and what it says instead; tasks that lose nothing are left out."""
    rows = []
    for task, change in _map(tasks).items():
        lost, instead = (_texts(_map(change)[key]) for key in ("lost", "instead"))
        pairs = zip_longest(lost, instead, fillvalue="")
        rows += [("" if number else task, *pair) for number, pair in enumerate(pairs)]
    columns = 3 if any(after for _, _, after in rows) else 2
    table = plain_table("", *("task", "loses", "has instead")[:columns])
    for row in rows:
        table.add_row(*row[:columns])
    return table


def _map(value: Json) -> Mapping[str, Json]:
    assert isinstance(value, Mapping), value
    return value


def _texts(value: Json) -> list[str]:
    assert not isinstance(value, int | float | Mapping | None), value
    return [str(each).strip("()") for each in value]


def _cell(row: Mapping[str, Json], column: str) -> str:
    return str(row.get(column, ""))


def _needed(result: Result | None, span: Mapping[str, Json]) -> str:
    theirs = result.paper if result else "-"
    ours, fewest, most = (span[key] if span[key] is not None else "never" for key in ("ours", "fewest", "most"))
    return f"{theirs} / {ours}" + ("" if fewest == most else f" ({fewest}-{most})")


def _worst(results: list[Result]) -> Text:
    order = ("fails", "differs, explained", "equal")
    texts = [verdict_text(result) for result in results]
    return min(texts, key=lambda text: order.index(text.plain))


# --- How the comparison with the paper is printed: a table for each section, verdicts last.

SHORT = "Eq. 36"
"""The clause of Eq. 37 in symbols: told in one line."""


def print_report(report: Report, pictures: Sequence[Path] = ()) -> None:
    """Print every section, the explanations below each table, and how many results have which verdict."""
    for section in report.sections:
        if section.name != "draws":
            heading(section)
            PRINTERS.get(section.name, _print_plain)(section, report)
            console.print()
    _print_verdicts(report)
    for path in pictures:
        console.print(f"picture: {path}")


def _print_clauses(section: Section, report: Report) -> None:
    """The clauses with the share of displacements in which each predicate survives."""
    displacements = report.section("draws")
    survival = {result.name: result for result in displacements.results}
    tasks = dict.fromkeys(result.name.partition(":")[0] for result in section.results)
    for task in tasks:
        own = [result for result in section.results if result.name.startswith(f"{task}:") and result.where != SHORT]
        show(_clause_table(task, own, survival, displacements.details.get(task)))
        symbols = [result for result in section.results if result.where == SHORT and result.name.startswith(f"{task}:")]
        if symbols:
            equal = tally(symbols)["equal"]
            console.print(f"  {SHORT}, the same in symbols: {equal} of {len(symbols)} predicates are equal")
        console.print()
    _print_explanations(section.results)
    if displacements.details:
        paragraph(displacements.about)
    _print_explanations(displacements.results)


def _clause_table(task: str, own: Iterable[Result], survival: Mapping[str, Result], displaced: Json) -> Table:
    own = list(own)
    count = displaced["draws"] if isinstance(displaced, Mapping) else None
    survives = f"survives {count} displacement{'' if count == 1 else 's'}" if count else "survives"
    table = plain_table(f"{task} ({own[0].where})", "the paper prints", "learned", survives, "verdict", numbers=1)
    for result in own:
        printed = Text(str(result.paper)) if result.paper else Text("-", style="dim")
        table.add_row(
            printed, str(result.ours or "-"), _share(survival.get(result.name), displaced), verdict_text(result)
        )
    if isinstance(displaced, Mapping):
        whole = displaced["whole_clause"]
        assert isinstance(whole, int)
        assert isinstance(count, int)
        table.add_row(Text("the whole clause, no more and no less", style="dim"), "", f"{whole / count:.1%}", "")
    return table


def _share(result: Result | None, displaced: Json) -> Text:
    """The share of displacements with its interval, in the colour of whether it meets the goal."""
    told = share_words(result, displaced) if result else ""
    if result is None or result.verdict is None or not told:
        return Text("-", style="dim")
    return Text(told, STYLES[result.verdict])


def _print_plain(section: Section, _report: Report) -> None:
    table = plain_table("", "what", "where", "the paper", "ours", "verdict")
    for result in section.results:
        table.add_row(result.name, result.where, words(result.paper), words(result.ours), verdict_text(result))
    show(table)
    _print_explanations(section.results)


def _print_table_2(section: Section, _report: Report) -> None:
    show(table_2(section))
    _print_explanations(section.results)
    paragraph(f"The wide band asks: {section.details['question']}", indent="  ", style="yellow")


def _print_table_3(section: Section, _report: Report) -> None:
    show(table_3(section))
    for result in section.results[2 * len(section.details) :]:  # after a count and a time of each task
        console.print(Text(f"  {result.name}: ") + verdict_text(result))
        paragraph(f"the paper: {words(result.paper)}; ours: {words(result.ours)}", indent="    ", style="")
        if result.explanation:
            paragraph(result.explanation, indent="    ")


def _print_table_4(section: Section, _report: Report) -> None:
    show(table_4(section))
    _print_explanations(section.results)


def _print_ablations(section: Section, report: Report) -> None:
    _print_plain(section, report)
    for tree, tasks in section.details.items():
        console.print()
        console.print(Text(tree, style="bold"))
        show(lost_table(tasks))


PRINTERS: Mapping[str, Callable[[Section, Report], None]] = {
    "clauses": _print_clauses,
    "table_2": _print_table_2,
    "table_3": _print_table_3,
    "table_4": _print_table_4,
    "ablations": _print_ablations,
}


def _print_explanations(results: Iterable[Result]) -> None:
    """Each explanation once, with the results that it explains."""
    told: dict[str, list[str]] = {}
    for result in results:
        if result.explanation:
            told.setdefault(result.explanation, []).append(result.name)
    for explanation, names in told.items():
        told_names = ", ".join(names) if len(names) < 5 else f"{len(names)} results"
        paragraph(f"{told_names}: {explanation}", indent="  ")


def _print_verdicts(report: Report) -> None:
    published, goals = tally(report.results), tally(report.goals, Goal)
    for told, counts in (("published results", published), ("survival of displacement, goal 95 %", goals)):
        console.print(Text(f"{told}: " + "; ".join(f"{n} {verdict}" for verdict, n in counts.items()), style="bold"))
