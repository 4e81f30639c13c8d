"""What a check says of a recording, and how it counts frames.

All checks speak in findings: what is wrong, by how much, and what to do about it. Each kind of check stands in a file
of its own: ``check_trackers`` (what trackers bring), ``check_label`` (what happens, and what the label says of it).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.recording.recording import Recording

Severity = Literal["unfit", "warning", "note"]


@dataclass(frozen=True)
class Finding:
    """One thing that a recording's user should know.

    Attributes:
        severity: "unfit" if nothing sensible can be learned while it stands.
        about: What it concerns: an object, an agent's part, the label.
        problem: What is wrong, in one clause.
        remedy: What to do about it.
    """

    severity: Severity
    about: str
    problem: str
    remedy: str = ""


@dataclass(frozen=True)
class Checkup:
    """All findings on one recording."""

    findings: tuple[Finding, ...]

    @property
    def fit(self) -> bool:
        """Whether the recording can be learned from."""
        return not any(finding.severity == "unfit" for finding in self.findings)


def known_in(recording: Recording, *names: str) -> Mask:
    """Frames in which all of these, objects, agents or parts, were tracked, (N,)."""
    known = np.ones(len(recording), dtype=np.bool_)
    for name in names:
        known &= recording.tracked.get(name, True)
    return known


TRAVELS_M = 0.05
"""What stays within so much is not carried about."""


def travels(recording: Recording, name: str) -> bool:
    """Whether an object gets anywhere while it is tracked: a quick look, before its facts are inferred."""
    places = np.asarray(recording.qpos[:, recording.scene.object_slice(name)])[known_in(recording, name), :3]
    return bool(len(places)) and float(np.ptp(places, axis=0).max()) > TRAVELS_M


def runs(holds: Mask) -> Iterator[tuple[int, int]]:
    """First and last frame of each run of frames in which something holds.

    Args:
        holds: Whether it does, (N,).
    """
    edges = np.flatnonzero(np.diff(np.concatenate(([False], holds, [False])).astype(np.int8)))
    yield from ((int(first), int(end) - 1) for first, end in edges.reshape(-1, 2))


def some(frames: Indices, most: int) -> Indices:
    """At most so many of these frames, evenly spread."""
    return frames[:: max(-(-len(frames) // most), 1)]


def vector_text(values_m: Array) -> str:
    """Metres as a mapping file has them: "[0.12, -0.05, 0]"."""
    return "[" + ", ".join(f"{round(float(value), 3) + 0.0:g}" for value in values_m) + "]"
