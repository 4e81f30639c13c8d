"""Moving: whose body makes which motion."""

from __future__ import annotations

from dataclasses import dataclass

from taskgist.demonstrator.motion import Motion


@dataclass(frozen=True, eq=False)
class Moving:
    """A motion of somebody's body.

    Attributes:
        agent: Whose.
        motion: The motion; its postures are those of that agent's ``Body``.
    """

    agent: str
    motion: Motion

    @property
    def start_s(self) -> float:
        """When it begins."""
        return self.motion.start_s

    @property
    def end_s(self) -> float:
        """When it ends."""
        return self.motion.end_s
