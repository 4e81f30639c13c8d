"""What was measured before, in yardsticks, so that machines compare: the next run is held to it.

    python -m benchmarks.record      # keep the last run (benchmarks.json) as the record

A yardstick is one whole image by mj_multiRay of a fixed room: work of the same kind as ours, by code that is not ours,
on the same core, right before and after what is measured. The record keeps how many yardsticks each figure takes.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from benchmarks.figure import Figure
from benchmarks.peers.eye_view import EyeView
from benchmarks.peers.multi_ray import MultiRay
from benchmarks.rooms import furnished
from benchmarks.timing import seconds

MEASURED, RECORD = Path("benchmarks.json"), Path(__file__).with_name("record.json")
SLOWER = 1.25
"""Times the recorded yardsticks above which a figure is called slower."""

Record = Mapping[str, Mapping[str, float]]
"""Yardsticks by topic and figure."""


def main() -> None:
    """Keep the last run's yardsticks; topics that it did not measure stay as they are."""
    document = json.loads(MEASURED.read_text(encoding="utf-8"))
    kept = {**recorded(), **by_topic(document["figures"])}
    RECORD.write_text(json.dumps(kept, indent=2, ensure_ascii=False, sort_keys=True) + "\n", encoding="utf-8")
    print(f"{RECORD}: {sum(map(len, kept.values()))} figures")


def yardstick() -> float:
    """Seconds of the yardstick, now."""
    scene = furnished(2, 6)
    peer = MultiRay(EyeView.of(scene, scene.initial, scene.agents[0]))
    return seconds(peer.image)


def recorded() -> Record:
    """What was kept; nothing if there is no record yet."""
    found: Record = json.loads(RECORD.read_text(encoding="utf-8")) if RECORD.exists() else {}
    return found


def by_topic(figures: list[dict[str, Any]]) -> Record:
    """The yardsticks of figures, for those that have any."""
    found: dict[str, dict[str, float]] = {}
    for each in figures:
        if "yardsticks" in each:
            found.setdefault(each["topic"], {})[each["what"]] = float(f"{each['yardsticks']:.4g}")
    return found


def compared(figure: Figure, yardsticks: float, record: Record) -> str:
    """A figure beside its record: "1.02 × recorded", or that it is slower, or that nothing was recorded."""
    before = record.get(figure.topic, {}).get(figure.what)
    if before is None:
        return "not recorded"
    times = yardsticks / before
    return f"{'SLOWER: ' if times > SLOWER else ''}{times:.3g} × recorded"


if __name__ == "__main__":
    main()
