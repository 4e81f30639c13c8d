"""Put the figures of benchmarks.json into the tables of docs/research/speed.md: ``python -m tools.speed_page``."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from tools.markdown import filled

SOURCE, PAGE = Path("benchmarks.json"), Path("docs/research/speed.md")
MARKS = {True: "met", False: "not met", None: ""}


def main() -> None:
    """Rewrite the page."""
    document = json.loads(SOURCE.read_text(encoding="utf-8"))
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), measured(document)), encoding="utf-8")


def measured(document: dict[str, Any]) -> dict[str, Iterable[str]]:
    """The parts of the page that are measured, by name."""
    topics = dict.fromkeys(figure["topic"] for figure in document["figures"])
    parts: dict[str, Iterable[str]] = {
        topic: figures([each for each in document["figures"] if each["topic"] == topic]) for topic in topics
    }
    parts |= {name: show(document[name]) for name, show in OTHERS.items()}
    return parts | {f"profile of {name}": profile(rows) for name, rows in document["profile"].items()}


def machine(facts: dict[str, Any]) -> Iterator[str]:
    """One sentence."""
    packages = ", ".join(f"{name} {version}" for name, version in facts["packages"].items() if name != "taskgist")
    system = f"{facts['system']}, Python {facts['python']}"
    load = f"; {facts['load']:.1f} processes wanted a core meanwhile" if facts.get("load") else ""
    yield f"{facts['processor']}, one of {facts['cores']} cores; {system}; {packages}{load}."


def figures(measured: Iterable[dict[str, Any]]) -> Iterator[str]:
    """A row for each figure, and one for each peer."""
    yield "| what | time | × ours | goal | work, bound |"
    yield "| --- | ---: | ---: | --- | --- |"
    for each in measured:
        mark = MARKS[each["met"]]
        goal = f"{each['goal']}: **{mark}**" if mark else each["goal"]
        yield f"| **{each['what']}** | **{duration(each['ours_s'])}** | | {goal} | {'; '.join(remarks(each))} |"
        for name, seconds in sorted(each["peers_s"].items(), key=lambda item: item[1]):
            yield f"| {name} | {duration(seconds)} | {ratio(seconds / each['ours_s'])} | | |"


def remarks(figure: dict[str, Any]) -> Iterator[str]:
    """Work, bound and note."""
    if figure["counts"]:
        yield ", ".join(f"{count:,.0f} {name}" for name, count in figure["counts"].items())
    bound = figure["bound"]
    if bound:
        yield f"bound {duration(bound['seconds'])} ({bound['by']}), {figure['ours_s'] / bound['seconds']:.2g} × that"
    if figure["note"]:
        yield figure["note"]


def growth(points: Iterable[dict[str, Any]]) -> Iterator[str]:
    """A row for each size."""
    yield "| agents | objects | pixels | scene loaded | all efforts, first | again | per agent and object | memory |"
    yield "| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"
    for point in points:
        size = point["size"]
        width, height = size["image_px"]
        times = " | ".join(duration(point[key]) for key in ("load_s", "first_s", "seconds"))
        each = duration(point["per_pair_ms"] / 1000)
        yield (
            f"| {size['agents']} | {size['objects']} | {width} × {height} | {times} | {each} "
            f"| {point['memory_mib']:.0f} MiB |"
        )


def profile(rows: Iterable[dict[str, Any]]) -> Iterator[str]:
    """A row for each function."""
    yield "| function | calls | alone | with all it calls |"
    yield "| --- | ---: | ---: | ---: |"
    for row in rows:
        yield f"| `{row['function']}` | {row['calls']} | {row['own']:.1%} | {row['with_calls']:.1%} |"


def ratio(times: float) -> str:
    """Three digits, never a power of ten."""
    return f"{times:,.0f}" if times >= 100 else f"{times:.3g}"


def duration(seconds: float) -> str:
    """Three digits, in the unit that suits it."""
    if seconds >= 100:
        return f"{seconds:,.0f} s"
    if seconds >= 1:
        return f"{seconds:.3g} s"
    return f"{1000 * seconds:.3g} ms" if seconds >= 1e-3 else f"{1e6 * seconds:.3g} µs"


OTHERS: dict[str, Callable[[Any], Iterator[str]]] = {"machine": machine, "growth": growth}

if __name__ == "__main__":
    main()
