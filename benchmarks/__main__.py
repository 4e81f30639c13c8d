"""Measure; print a table beside peers and the record, and write benchmarks.json.

python -m benchmarks [TOPIC ...]
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from benchmarks import (
    demonstrations,
    growth,
    judging,
    learning,
    maps,
    memory,
    profiled,
    recognising,
    recordings,
    rooms,
    scenes,
    sight,
    start,
    store,
    tracking,
)
from benchmarks.figure import Figure, seconds_text
from benchmarks.machine import machine
from benchmarks.record import compared, recorded, yardstick
from benchmarks.timing import use_one_core

OUT = Path("benchmarks.json")
TOPICS: Mapping[str, Callable[[], Iterator[Figure]]] = {
    "start": start.figures,
    "sight": sight.figures,
    "demonstrations": demonstrations.figures,
    "scenes": scenes.figures,
    "tracking": tracking.figures,
    "recordings": recordings.figures,
    "maps": maps.figures,
    "learning": learning.figures,
    "recognising": recognising.figures,
    "judging": judging.figures,
    "store": store.figures,
    "memory": memory.figures,
}
GROWTH, PROFILE = "growth", "profile"


def main() -> None:
    """Measure the chosen topics, all by default; what was measured before of others stays in the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("topics", nargs="*", choices=[[], *TOPICS, PROFILE, GROWTH], help="default: all")
    chosen = parser.parse_args().topics or [*TOPICS, PROFILE, GROWTH]
    use_one_core()
    warm_up()
    console, document = Console(), measured_before()
    record = recorded()
    for topic in (each for each in TOPICS if each in chosen):
        before_s = yardstick()
        measured = list(TOPICS[topic]())
        yardstick_s = (before_s + yardstick()) / 2
        beside = [compared(figure, figure.ours_s / yardstick_s, record) for figure in measured]
        console.print(table(topic, measured, beside))
        document["figures"] = [figure for figure in document["figures"] if figure["topic"] != topic]
        document["figures"] += [figure.plain | {"yardsticks": figure.ours_s / yardstick_s} for figure in measured]
    if PROFILE in chosen:
        document[PROFILE] = profiled.profiles()
        for name, rows in document[PROFILE].items():
            console.print(profile_table(name, rows))
    if GROWTH in chosen:
        document[GROWTH] = [point.plain for point in growth.points()]
        console.print(growth_table(document[GROWTH]))
    document["machine"] = machine()
    OUT.write_text(json.dumps(document, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")


def measured_before() -> dict[str, Any]:
    """The file as it is, or an empty one."""
    found = json.loads(OUT.read_text(encoding="utf-8")) if OUT.exists() else {}
    return {"machine": {}, "figures": [], PROFILE: {}, GROWTH: [], **(found if isinstance(found, dict) else {})}


def warm_up() -> None:
    """Have the inner loops compiled, once and for all, before anything is measured."""
    scene = rooms.furnished(2, 6)
    scenes.everything(scene, scene.initial)


def table(topic: str, figures: list[Figure], beside: list[str]) -> Table:
    """Figures of one topic, each beside its record, with its peers beneath."""
    made = Table(title=topic, box=None, title_justify="left", title_style="bold")
    for column in ("what", "time", "ratio", "goal, work, bound"):
        made.add_column(column, overflow="fold")
    for each, record in zip(figures, beside, strict=True):
        mark = {True: "met: ", False: "NOT MET: ", None: ""}[each.met]
        made.add_row(each.what, seconds_text(each.ours_s), "", f"{mark}{each.goal}")
        made.add_row("", "", "", record)
        for name, seconds in sorted(each.peers_s.items(), key=lambda item: item[1]):
            made.add_row(f"  {name}", seconds_text(seconds), f"{seconds / each.ours_s:.3g}", "")
        for line in remarks(each):
            made.add_row("", "", "", line)
    return made


def remarks(figure: Figure) -> Iterator[str]:
    """Work, bound and note, a line each."""
    if figure.counts:
        yield ", ".join(f"{count:,.0f} {name}" for name, count in figure.counts.items())
    if figure.bound:
        bound = figure.bound
        yield f"bound {seconds_text(bound.seconds)} ({bound.by}): {figure.ours_s / bound.seconds:.2g} times that"
    if figure.note:
        yield figure.note


def profile_table(name: str, rows: list[dict[str, Any]]) -> Table:
    """Functions by the time that they take themselves."""
    made = Table(title=f"{PROFILE} of {name}", box=None, title_justify="left", title_style="bold")
    for column in ("function", "calls", "alone", "with all it calls"):
        made.add_column(column)
    for row in rows:
        made.add_row(row["function"], row["calls"], f"{row['own']:.1%}", f"{row['with_calls']:.1%}")
    return made


def growth_table(points: list[dict[str, Any]]) -> Table:
    """Every size that was measured."""
    made = Table(title=GROWTH, box=None, title_justify="left", title_style="bold")
    for column in ("agents", "objects", "pixels", "first", "again", "per agent and object", "memory"):
        made.add_column(column)
    for point in points:
        size = point["size"]
        first, again, each, memory = (point[key] for key in ("first_s", "seconds", "per_pair_ms", "memory_mib"))
        made.add_row(
            str(size["agents"]),
            str(size["objects"]),
            "{} × {}".format(*size["image_px"]),
            seconds_text(first),
            seconds_text(again),
            f"{each:.3g} ms",
            f"{memory:.0f} MiB",
        )
    return made


if __name__ == "__main__":
    main()
