"""Scripts: what a demonstrator does, step by step.

A script is plain data; each step (``steps``) knows how to play itself on an ``Acting``::

    Script("show", "P1", "P2", "cup", (Take("cup", "right"), HoldUp((0.1, 0.0, 1.1), 1.0)), means="held up")

Places are chosen beforehand, by the demonstrator's own geometry (``places``, ``hiding``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from taskgist.demonstrator.acting import Acting


class Step(Protocol):
    """One step of a script."""

    def play(self, acting: Acting) -> None:
        """Work the step out, from the acting's present state on."""


@dataclass(frozen=True)
class Script:
    """A demonstration to be played.

    Attributes:
        task: Name of the task.
        performer: Who performs it.
        target: For whom.
        thing: With what.
        steps: What the performer does.
        target_watches: What the target agent looks at in the beginning, as a subject of ``gaze``; None: the performer.
        means: How the performer reaches its intention, in words.
        target_returns_to: What the target agent is busy with: it looks there again when the thing rests; None: nothing.
    """

    task: str
    performer: str
    target: str
    thing: str
    steps: tuple[Step, ...]
    target_watches: str | None = None
    means: str = ""
    target_returns_to: str | None = None
