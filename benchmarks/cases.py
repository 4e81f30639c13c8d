"""What is measured, and beside what."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from statistics import median

import numpy as np

from benchmarks.timing import ratio, seconds
from taskgist.learning import Experience, Explanation
from taskgist.observe import ability_observations
from taskgist.perspective import view_of, visibility
from taskgist.recording import Recording, read
from taskgist.settings import DEFAULT
from taskgist.study import explain_recording, label_of, observe_recording, shipped_recordings
from taskgist.world import Stage

PAPER_S = {"give": 0.59, "show": 0.63, "hide": 0.81}
"""Table 3: seconds per demonstration as printed (2014, other hardware: not like for like)."""


@dataclass(frozen=True)
class Result:
    """One figure beside another from the same run; ``ratio`` above 1 means that taskgist is faster."""

    what: str
    ours_s: float
    peer_s: float | None
    peer: str
    ratio: float | None


def _first(task: str) -> Recording:
    return read(shipped_recordings(task)[0])


def visible_pixels() -> Result:
    """Counting one object's pixels in its bounding cone, beside casting the whole image."""
    recording = _first("hide")
    label = label_of(recording)
    stage = Stage(recording.scene, recording.at(label.start_s))
    geoms = recording.scene.object_geoms(label.target_object)
    counted = visibility(stage, label.target_agent, label.target_object)
    whole = int(np.isin(view_of(stage, label.target_agent).geoms, geoms).sum())
    assert counted is not None
    assert counted.visible_px == whole
    slow, fast, times = ratio(
        lambda: view_of(stage, label.target_agent),
        lambda: visibility(stage, label.target_agent, label.target_object),
    )
    return Result("visible pixels of one object, 320 × 240", fast, slow, "whole image by one mj_multiRay", times)


def attributes(task: str) -> Callable[[], Result]:
    """All level-3 attributes of a demonstration's start and end, beside the paper's Table 3."""

    def measure() -> Result:
        times = []
        for path in shipped_recordings(task):
            recording = read(path)
            label = label_of(recording)
            stage = Stage(recording.scene)

            def both_ends(recording: Recording = recording, stage: Stage = stage) -> None:
                label = label_of(recording)
                for time_s in (label.start_s, label.end_s):
                    stage.show(recording.at(time_s))
                    ability_observations(stage, label.target_agent, label.target_object, DEFAULT)

            assert label.end_s > label.start_s
            times.append(seconds(both_ends, repeats=5))
        ours = median(times)
        return Result(
            f"abilities at start and end, {task} (median)", ours, PAPER_S[task], "paper, Table 3", PAPER_S[task] / ours
        )

    return measure


def watching() -> Result:
    """Hands, placements and motion of a whole recording, beside its own duration."""
    recording = _first("hide")
    ours = seconds(lambda: observe_recording(recording), repeats=3)
    return Result("watching a recording", ours, recording.duration_s, "its duration", recording.duration_s / ours)


def adding() -> Result:
    """Adding one demonstration to many, beside adding it to one: it should cost about the same."""
    explanation = explain_recording(_first("show"))
    copies = [_renamed(explanation, number) for number in range(1001)]
    few, many = Experience.of("show", copies[:1]), Experience.of("show", copies[:1000])
    small, large, times = ratio(lambda: few.add(copies[-1]), lambda: many.add(copies[-1]))
    return Result("adding a demonstration to 1,000", large, small, "adding it to 1", times)


def _renamed(explanation: Explanation, number: int) -> Explanation:
    fields = {
        name: getattr(explanation, name) for name in ("task", "performing_agent", "target_agent", "target_object")
    }
    return Explanation(
        **fields,
        demonstration=str(number),
        source=f"copy {number}",
        context=explanation.context,
        nodes=explanation.nodes,
    )


CASES: tuple[Callable[[], Result], ...] = (
    visible_pixels,
    attributes("give"),
    attributes("show"),
    attributes("hide"),
    watching,
    adding,
)
