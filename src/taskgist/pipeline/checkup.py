"""Is a recording fit to learn from? Findings, each with what to do about it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from taskgist.common.workers import Progress, silent
from taskgist.observe.observer import Observer
from taskgist.pipeline.check_label import label_findings
from taskgist.pipeline.check_trackers import tracker_findings
from taskgist.pipeline.findings import Checkup, Finding, Severity
from taskgist.recording.recording import Recording
from taskgist.settings import DEFAULT, Checks, Settings
from taskgist.world.contacts import overlaps
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage

GAP_FACTOR = 3.0
"""A step of time longer than this many usual ones is a gap."""
SLOWEST_S = 0.1
"""Frames farther apart than this are fewer than the windows of motion and holding ask for."""
OVERLAP_M = 0.03
"""Bodies that overlap deeper than this were tracked or shaped wrongly; fitted hands do so by 1-2 cm while they hold."""
SOFT_M = 0.05
"""Bodies and furniture: flesh and cushions give by as much."""
OVERLAP_EVERY_S = 0.2
POOR_FIT_CM = 5.0
"""Median error of a fitted landmark above which facts of contact are doubtful."""
SPINE = ("chest", "abdomen", "neck", "pelvis")
"""Landmarks that lie elsewhere for each tracker; no fact hangs on them."""


def check(recording: Recording, settings: Settings = DEFAULT, progress: Progress = silent) -> Checkup:
    """Examine a recording.

    Args:
        recording: The recording, with or without a label.
        settings: All settings.
        progress: Told how far it is.
    """
    observer = Observer(recording.scene, recording, settings)
    findings = [
        *_time_gaps(recording),
        *_untracked(recording),
        *_poor_fits(recording),
        *_jumps(recording, settings.checks),
        *_sizes(recording.scene, settings.checks),
        *_overlaps(recording, progress),
        *tracker_findings(recording, observer, settings),
        *label_findings(recording, observer, settings),
        *_estimated(recording),
    ]
    order: dict[Severity, int] = {"unfit": 0, "warning": 1, "note": 2}
    return Checkup(tuple(sorted(findings, key=lambda finding: order[finding.severity])))


def _time_gaps(recording: Recording) -> Iterator[Finding]:
    steps = np.diff(recording.times_s)
    usual = float(np.median(steps))
    if usual > SLOWEST_S:
        rate = f"only {1 / usual:.0f} frames per second"
        yield Finding("warning", "time", f"{rate}: short holds and stops are missed", "record faster")
    for index in np.flatnonzero(steps > GAP_FACTOR * usual):
        start = recording.times_s[index]
        yield Finding(
            "warning",
            "time",
            f"no frames for {steps[index]:.2f} s after {start:.2f} s (usually every {usual:.3f} s)",
            "label around the gap, or record anew",
        )


def _untracked(recording: Recording) -> Iterator[Finding]:
    for name, known in recording.tracked.items():
        share = float(np.mean(known))
        if share == 0.0:
            yield Finding("warning", name, "never tracked: facts that need it are unknown", "track it, or map it")
        elif share < 1.0:
            lost = recording.times_s[~np.asarray(known)]
            span = f"between {lost[0]:.2f} and {lost[-1]:.2f} s"
            stays = 'if it stays where it was last seen, say outside = "stays" in the mapping that imports it'
            remedy = stays if name in recording.scene.objects else ""
            yield Finding("warning", name, f"untracked in {100 * (1 - share):.0f} % of the frames, {span}", remedy)


def _poor_fits(recording: Recording) -> Iterator[Finding]:
    for agent, report in recording.provenance.fit.items():
        for point, error in _by_name(_by_name(report).get("points_cm")).items():
            median_cm = _by_name(error).get("median")
            if point not in SPINE and isinstance(median_cm, int | float) and median_cm > POOR_FIT_CM:
                yield Finding(
                    "note",
                    f"{agent}'s {point}",
                    f"the fitted body is {median_cm:.1f} cm away from it (median)",
                    "check the mapping's landmark, or give body sizes",
                )


def _by_name(value: object) -> Mapping[str, Any]:
    """A part of a report, which anybody may have written."""
    return value if isinstance(value, Mapping) else {}


def _jumps(recording: Recording, limits: Checks) -> Iterator[Finding]:
    """Objects and bodies that are elsewhere from one tracked frame to the next."""
    scene = recording.scene
    columns = {name: scene.base_slice(name) for name in scene.agents} | {
        name: scene.object_slice(name) for name in scene.objects
    }
    for name, free in columns.items():
        known = np.flatnonzero(recording.tracked.get(name, np.ones(len(recording), dtype=np.bool_)))
        times_s, places = recording.times_s[known], recording.qpos[:, slice(free.start, free.start + 3)][known]
        steps_s, steps_m = np.diff(times_s), np.linalg.norm(np.diff(places, axis=0), axis=1)
        jumps = np.flatnonzero(steps_m > limits.fastest_m_s * steps_s)
        if not len(jumps):
            continue
        farthest = int(jumps[np.argmax(steps_m[jumps])])
        more = f", and {len(jumps) - 1} times more" if len(jumps) > 1 else ""
        speed = f"{steps_m[farthest] / steps_s[farthest]:.0f} m/s"
        yield Finding(
            "warning",
            name,
            f"jumps by {steps_m[farthest]:.2f} m at {times_s[farthest + 1]:.2f} s ({speed}){more}",
            "say where it was not tracked, or label beside it",
        )


def _sizes(scene: Scene, limits: Checks) -> Iterator[Finding]:
    """Objects of a size that nobody handles: mostly the unit was another."""
    for name in scene.objects:
        geoms = scene.geoms_of(name)
        if not len(geoms):
            continue
        longest_m = float(2.0 * scene.model.geom_aabb[geoms, 3:].max())
        remedy = "check the unit of its model: metres are expected"
        if longest_m > limits.largest_m:
            yield Finding("warning", name, f"is {longest_m:.3g} m long: in millimetres?", remedy)
        elif longest_m < limits.smallest_m:
            yield Finding("warning", name, f"is {1000 * longest_m:.2g} mm long: shrunk a thousandfold?", remedy)


def _overlaps(recording: Recording, progress: Progress) -> Iterator[Finding]:
    stage = Stage(recording.scene)
    worst: dict[tuple[str, str], tuple[float, float]] = {}
    times = np.arange(recording.times_s[0], recording.times_s[-1], OVERLAP_EVERY_S)
    for number, time_s in enumerate(times):
        state = recording.at(float(time_s))
        stage.show(state)
        for pair, depth in overlaps(stage, deeper_than_m=OVERLAP_M).items():
            if state.known(pair) and depth > worst.get(pair, (0.0, 0.0))[0]:
                worst[pair] = (depth, float(time_s))
        progress("looking for overlaps", (number + 1) / len(times))
    for (a, b), (depth, time_s) in worst.items():
        held = {a, b} & set(recording.scene.agents) and {a, b} & set(recording.scene.objects)
        if not held and depth < SOFT_M and not {a, b} <= {*recording.scene.agents, *recording.scene.objects}:
            continue  # a body gives where it sits or leans
        yield Finding(
            "note" if held else "warning",
            f"{a} and {b}",
            f"overlap by up to {100 * depth:.1f} cm (at {time_s:.2f} s)",
            "usual where a hand closes around it" if held else "check shapes and poses",
        )


def _estimated(recording: Recording) -> Iterator[Finding]:
    for name in sorted(recording.scene.estimated):
        yield Finding("note", name, "its place or shape is an estimate", "")
