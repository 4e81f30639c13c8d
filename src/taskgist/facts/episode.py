"""An episode: what was observed at both ends of one demonstration, for one target agent and object."""

from __future__ import annotations

from dataclasses import dataclass

from taskgist.facts.frozen import FrozenMap
from taskgist.facts.subtree import Snapshot


@dataclass(frozen=True)
class Episode:
    """Observations at start and end, with the operator's label (7.2).

    Args:
        task: Name of the task.
        demonstration: Name of the demonstration, for people.
        performing_agent: Who performs.
        target_agent: For whom it is performed; every fact is from this agent's perspective.
        target_object: With which object.
        start: Observations of the initial world state, by attribute.
        end: Observations of the final world state, by attribute.
        source: Identifies what was observed: digest of a recording with the labelled interval, or of a facts file.
    """

    task: str
    demonstration: str
    performing_agent: str
    target_agent: str
    target_object: str
    start: Snapshot
    end: Snapshot
    source: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", FrozenMap(self.start))
        object.__setattr__(self, "end", FrozenMap(self.end))
