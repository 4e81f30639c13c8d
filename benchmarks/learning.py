"""Watching recordings and learning from them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from benchmarks.figure import Figure
from benchmarks.judging import watched
from benchmarks.timing import in_turn, seconds
from taskgist.learning import Experience, Explanation
from taskgist.pipeline import explain_recording, shipped_recordings
from taskgist.recording import read


def figures() -> Iterator[Figure]:
    """Watching one recording, and adding one explanation."""
    yield watching()
    yield adding()


def watching() -> Figure:
    """Hands, placements and motion of a whole recording, beside its own duration."""
    recording = read(shipped_recordings("hide")[0])
    ours = seconds(lambda: watched(recording), repeats=1)
    beside = {"its duration": recording.duration_s}
    return Figure(
        "learning", "watching a recording", ours, beside, goal="faster than it happens", met=ours < recording.duration_s
    )


def adding() -> Figure:
    """Adding one demonstration to a thousand, beside adding it to one: it should cost about the same."""
    explanation = explain_recording(read(shipped_recordings("show")[0]))
    copies = [_renamed(explanation, number) for number in range(1001)]
    few, many = Experience.of("show", copies[:1]), Experience.of("show", copies[:1000])
    beside = in_turn({"adding it to 1": lambda: few.add(copies[-1]), "ours": lambda: many.add(copies[-1])}, 51)
    return Figure("learning", "adding a demonstration to 1,000", beside.pop("ours"), beside)


def _renamed(explanation: Explanation, number: int) -> Explanation:
    return replace(explanation, demonstration=str(number), source=f"copy {number}")
