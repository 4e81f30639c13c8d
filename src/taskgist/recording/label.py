"""The operator's label: which task, by whom, for whom, on what, from when to when (7.2)."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

from taskgist.errors import LabelError, UnknownNameError

_TOLERANCE_S = 1e-6  # times on disk are whole nanoseconds


@dataclass(frozen=True)
class Label:
    """What a recording demonstrates.

    Attributes:
        task: Name of the task, such as "give".
        performing_agent: Who performs it.
        target_agent: For whom.
        target_object: With what.
        start_s: Start, seconds since the recording's origin.
        end_s: End.
        how: How the label was set: by hand, from which events.

    Raises:
        LabelError: A field is empty, a list, or not a time; the end is not after the start; both agents are the same.
    """

    task: str
    performing_agent: str
    target_agent: str
    target_object: str
    start_s: float
    end_s: float
    how: str = ""

    def __post_init__(self) -> None:
        for name in ("task", "performing_agent", "target_agent", "target_object"):
            _check_name(name, getattr(self, name))
        for name in ("start_s", "end_s"):
            _check_time(name, getattr(self, name))
        if self.end_s <= self.start_s:
            raise LabelError(
                "the label ends before it starts",
                field="end_s",
                value=self.end_s,
                hint=f"give an end after start_s = {self.start_s:g}",
            )
        if self.performing_agent == self.target_agent:
            raise LabelError(
                "performing and target agent are the same",
                field="target_agent",
                value=self.target_agent,
                hint="name the other agent, for whom the task is performed",
            )

    def check(
        self,
        *,
        agents: Collection[str],
        objects: Collection[str],
        first_s: float = -math.inf,
        last_s: float = math.inf,
    ) -> None:
        """Refuse a label that does not fit a recording.

        Args:
            agents: Names of the recording's agents.
            objects: Names of its objects.
            first_s: Time of its first frame.
            last_s: Time of its last frame.

        Raises:
            UnknownNameError: An agent or the object is not in it.
            LabelError: The label reaches outside of it.
        """
        for agent in (self.performing_agent, self.target_agent):
            if agent not in agents:
                raise UnknownNameError("agent", agent, agents)
        if self.target_object not in objects:
            raise UnknownNameError("object", self.target_object, objects)
        for name, time_s in (("start_s", self.start_s), ("end_s", self.end_s)):
            if not first_s - _TOLERANCE_S <= time_s <= last_s + _TOLERANCE_S:
                raise LabelError(
                    "the label reaches outside of the recording",
                    field=name,
                    value=time_s,
                    hint=f"give a time between {first_s:g} and {last_s:g} s",
                )


def _check_name(field: str, value: object) -> None:
    if isinstance(value, list | tuple | set | frozenset):
        noun = field.replace("_", " ")
        raise LabelError(
            f"several values of one {noun} are not supported yet",
            field=field,
            value=value,
            hint=f"label one {noun}; make a copy of the recording with its own label for each other one",
        )
    if not isinstance(value, str) or not value.strip():
        raise LabelError("must be a name", field=field, value=value, hint="give a text that is not empty")


def _check_time(field: str, value: object) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise LabelError("must be a time", field=field, value=value, hint="give seconds, such as 1.5")
