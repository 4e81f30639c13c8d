"""How the comparison with the paper is printed: a table for each section, verdicts last."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from rich.table import Table
from rich.text import Text

from taskgist.cli.output import console
from taskgist.cli.paper_numbers import lost_table, table_2, table_3, table_4
from taskgist.cli.paper_words import STYLES, heading, paragraph, plain_table, share_words, show, verdict_text, words
from taskgist.facts import Json
from taskgist.study.paper import Goal, Report, Result, Section, tally

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
    """The clauses with the share of draws in which each predicate survives."""
    draws = report.section("draws")
    survival = {result.name: result for result in draws.results}
    tasks = dict.fromkeys(result.name.partition(":")[0] for result in section.results)
    for task in tasks:
        own = [result for result in section.results if result.name.startswith(f"{task}:") and result.where != SHORT]
        show(_clause_table(task, own, survival, draws.details.get(task)))
        symbols = [result for result in section.results if result.where == SHORT and result.name.startswith(f"{task}:")]
        if symbols:
            equal = tally(symbols)["equal"]
            console.print(f"  {SHORT}, the same in symbols: {equal} of {len(symbols)} predicates are equal")
        console.print()
    _print_explanations(section.results)
    if draws.details:
        paragraph(draws.about)
    _print_explanations(draws.results)


def _clause_table(task: str, own: Iterable[Result], survival: Mapping[str, Result], drawn: Json) -> Table:
    own = list(own)
    count = drawn["draws"] if isinstance(drawn, Mapping) else None
    survives = f"survives {count} draw{'' if count == 1 else 's'}" if count else "survives"
    table = plain_table(f"{task} ({own[0].where})", "the paper prints", "learned", survives, "verdict", numbers=1)
    for result in own:
        printed = Text(str(result.paper)) if result.paper else Text("-", style="dim")
        table.add_row(printed, str(result.ours or "-"), _share(survival.get(result.name), drawn), verdict_text(result))
    if isinstance(drawn, Mapping):
        whole = drawn["whole_clause"]
        assert isinstance(whole, int)
        assert isinstance(count, int)
        table.add_row(Text("the whole clause, no more and no less", style="dim"), "", f"{whole / count:.1%}", "")
    return table


def _share(result: Result | None, drawn: Json) -> Text:
    """The share of draws with its interval, in the colour of whether it meets the goal."""
    told = share_words(result, drawn) if result else ""
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
