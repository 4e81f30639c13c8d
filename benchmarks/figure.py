"""One measured figure, beside its peers from the same run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field


@dataclass(frozen=True)
class Bound:
    """What no implementation on the same parts would beat: the work that must be done, at the speed of those parts.

    Attributes:
        by: What the work is, and how fast the part does it.
        seconds: How long that takes.
    """

    by: str
    seconds: float


@dataclass(frozen=True)
class Figure:
    """A duration, and what it stands beside.

    Attributes:
        topic: Which group it belongs to.
        what: What was measured.
        ours_s: Our duration in seconds.
        peers_s: Durations of others, or of the slow twin, for the same, by name.
        goal: What was asked, in words.
        met: Whether it is met; None where nothing was asked.
        counts: Work that was done: rays, states, pairs of shapes.
        bound: What bounds it.
        note: What else should be known.
    """

    topic: str
    what: str
    ours_s: float
    peers_s: Mapping[str, float] = field(default_factory=dict)
    goal: str = ""
    met: bool | None = None
    counts: Mapping[str, float] = field(default_factory=dict)
    bound: Bound | None = None
    note: str = ""

    @property
    def plain(self) -> dict[str, object]:
        """Plain data, fit for JSON."""
        return asdict(self)


def seconds_text(seconds: float) -> str:
    """A duration with three digits, in the unit that suits it."""
    for unit, name in ((1.0, "s"), (1e-3, "ms")):
        if seconds >= unit:
            return f"{seconds / unit:.3g} {name}"
    return f"{seconds / 1e-6:.3g} µs"
