"""The lines of docs/research/study.md: what the comparison with the paper says, as tables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from taskgist.common.frozen import Json
from taskgist.facts import EFFORT_LEVELS, Unknown
from taskgist.language import meaning
from taskgist_lab.cli.paper import share_words, words
from taskgist_lab.paper import Goal, Judged, Report, Result, Section, tally, understanding_of
from taskgist_lab.paper.tables import TABLE_2_PRINTED
from tools.markdown import header, row

COLUMNS = ("see", "reach", "object", "all")

JudgedStudy = Mapping[str, tuple[Judged, ...]]


def verdicts(found: Report) -> Iterator[str]:
    """How many published results have which verdict, and how many predicates meet the goal of displacement."""
    yield f"Of {len(found.results)} published results: {counted(tally(found.results))}."
    yield f"Of {len(found.goals)} predicates that shall survive displacement: {counted(tally(found.goals, Goal))}."


def counted(counts: Mapping[str, int]) -> str:
    """How often each verdict was met."""
    return ", ".join(f"**{count}** {verdict}" for verdict, count in counts.items())


def demonstrations(judged: JudgedStudy) -> Iterator[str]:
    """What changes for the target agent in each."""
    yield from header(
        "demonstration", "effort to reach", "effort to see", "visibility, of the image", "posture", "ends"
    )
    for of_task in judged.values():
        for each in of_task:
            nodes = {name: node.value for name, node in each.explanation.nodes.items()}
            reach, see = (
                " → ".join(level(nodes[f"{ability}.effort.{instant}"]) for instant in (1, 2))
                for ability in ("reach", "see")
            )
            score = " → ".join(str(nodes[f"visibility.score.{instant}"]) for instant in (1, 2))
            name = each.explanation.demonstration
            yield row(name, reach, see, score, nodes["posture.value.1"], nodes["placement.status.2"])


def level(effort: object) -> str:
    """The level of an effort, from 0 for none to 5 for none known."""
    return "unknown" if isinstance(effort, Unknown) else str(EFFORT_LEVELS[str(effort)])


def meanings(judged: JudgedStudy) -> Iterator[str]:
    """One sentence for each task."""
    for task, of_task in judged.items():
        yield f"- {meaning(understanding_of(task, of_task))}"


def clauses(section: Section, displacements: Section) -> Iterator[str]:
    """Each clause: what the paper prints, what is learned, and how well it bears displacement."""
    survival = {result.name: result for result in displacements.results}
    for task, displaced in ((task, displacements.details.get(task)) for task in tasks(section)):
        own = [each for each in section.results if each.name.startswith(f"{task}:") and each.where != "Eq. 36"]
        yield f"**{task}** ({own[0].where})"
        yield ""
        yield from header("the paper prints", "learned", "survives", "verdict")
        for result in own:
            printed = f"`{result.paper}`" if result.paper else "-"
            yield row(
                printed,
                f"`{result.ours}`",
                share_words(survival[result.name], displaced) or "not measured",
                mark(result),
            )
        yield ""


def displacement(section: Section) -> Iterator[str]:
    """The whole clauses, what is lost where something is, and how the goal is met."""
    if not section.details:
        yield "Not measured yet: `taskgist paper --displacements 200`."
        return
    yield from header(
        "task", "displacements", "whole clause", "least predicate", "lost, and what is learned instead", "not played"
    )
    for task, displaced in section.details.items():
        counts = mapping(displaced)
        displacements, whole = (float(str(counts[key])) for key in ("draws", "whole_clause"))
        least = min(float(str(each)) for each in mapping(counts["survived"]).values())
        instead = (f"`{node}`: {often(found)}" for node, found in mapping(counts["instead"]).items())
        cells = ("; ".join(instead), often(counts["unplayed"]))
        yield row(task, f"{displacements:.0f}", f"{whole / displacements:.1%}", f"{least / displacements:.1%}", *cells)
    yield ""
    yield f"Of {len(section.results)} predicates: {counted(tally(section.results, Goal))}."
    yield ""
    for result in section.results:
        if result.explanation:
            yield f"- **{result.name}**: {result.explanation}."


def often(counts: Json) -> str:
    """What happened, and how often."""
    return "; ".join(f"{what} ({count})" for what, count in mapping(counts).items())


def table_2(section: Section) -> Iterator[str]:
    """Each row as printed, and ours below."""
    columns = [column for column in TABLE_2_PRINTED[0] if column != "value"]
    yield from header("after demonstration", "", *columns, "verdict")
    for result in section.results[: len(TABLE_2_PRINTED)]:
        name = result.name.removeprefix("demonstration ")
        yield row(name, "paper", *(mapping(result.paper)[column] for column in columns), "")
        yield row("", "ours", *(mapping(result.ours)[column] for column in columns), mark(result))


def table_3(section: Section) -> Iterator[str]:
    """Seconds per demonstration."""
    named = {result.name: result for result in section.results}
    yield from header("task", "demonstrations", "paper, s", "ours, s", "")
    for task in section.details:
        time = named[f"{task}: seconds"]
        yield row(task, named[f"{task}: demonstrations"].ours, time.paper, f"{time.ours:.3f}", time.explanation)
    yield ""
    yield section.about
    yield ""
    order = section.results[2 * len(section.details) :]  # after a count and a time of each task
    yield from plain(order)
    yield ""
    yield from (f"- **{result.name}**: {result.explanation}." for result in order if result.explanation)


def table_4(section: Section) -> Iterator[str]:
    """Demonstrations needed: paper / ours, and over all orders."""
    named = {result.name: result for result in section.results}
    yield from header("paper / ours (fewest-most)", *COLUMNS)
    for task, spans in section.details.items():
        cells = []
        for column in COLUMNS:
            span, result = mapping(mapping(spans)[column]), named.get(f"{task}: {column}")
            orders = "" if span["fewest"] == span["most"] else f" ({span['fewest']}-{span['most']})"
            cells.append(f"{result.paper if result else '-'} / {span['ours']}{orders}")
        yield row(task, *cells)


def lost(section: Section) -> Iterator[str]:
    """What each task loses in each smaller tree."""
    yield from header("tree", "task", "loses", "has instead")
    for tree, changes in section.details.items():
        for task, change in mapping(changes).items():
            texts = [
                ", ".join(f"`{str(each).strip('()')}`" for each in listed(mapping(change)[key]))
                for key in ("lost", "instead")
            ]
            if any(texts):
                yield row(tree, task, *texts)


def plain(results: Iterable[Result]) -> Iterator[str]:
    """A row for each result."""
    yield from header("what", "where", "the paper", "ours", "verdict")
    for result in results:
        yield row(result.name, result.where, words(result.paper), words(result.ours), mark(result))


def differences(found: Report) -> Iterator[str]:
    """Every difference that has an explanation, once, apart from times."""
    told: dict[str, list[str]] = {}
    times = set(found.section("table_3").results)
    for result in found.results:
        if result.explanation and result not in times:
            told.setdefault(result.explanation, []).append(f"{result.name} ({result.where})")
    for explanation, names in told.items():
        yield f"- **{'; '.join(names)}**: {explanation}."


def tasks(section: Section) -> list[str]:
    """The tasks of a section whose results begin with theirs."""
    return list(dict.fromkeys(result.name.partition(":")[0] for result in section.results))


def mark(result: Result) -> str:
    """The verdict; a failure stands out."""
    told = result.verdict.value if result.verdict else "not measured"
    return f"**{told}**" if told == "fails" else told


def mapping(value: Json) -> Mapping[str, Json]:
    """A value that is known to be a mapping."""
    assert isinstance(value, Mapping), value
    return value


def listed(value: Json) -> Sequence[Json]:
    """A value that is known to be a list."""
    assert isinstance(value, Sequence), value
    return value
