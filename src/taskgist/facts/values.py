"""Values: symbols, raw attribute values, and *unknown*, a third value beside true and false."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Final, Generic, Literal, NoReturn, TypeAlias, TypeVar, cast

from taskgist.facts.frozen import FrozenMap, Json, freeze, thaw


class Unknown(Enum):
    """The type of ``UNKNOWN``. An enumeration, so that it stays one object through pickle and copy."""

    UNKNOWN = "unknown"

    def __bool__(self) -> NoReturn:
        raise TypeError("UNKNOWN is neither true nor false; compare it with `is UNKNOWN`")

    def __repr__(self) -> str:
        return "UNKNOWN"


UNKNOWN: Final[Literal[Unknown.UNKNOWN]] = Unknown.UNKNOWN
"""What could not be observed. It is never counted, and its truth value is an error."""

Value: TypeAlias = str | Unknown
"""What a node of the tree can be: a symbol, or unknown."""

Raw: TypeAlias = str | bool | float | Mapping[str, str | None] | Unknown
"""What an attribute is observed as: a symbol, truth, score, status by side (None: unknown), or unknown."""

V = TypeVar("V", bound=Raw)
V_co = TypeVar("V_co", bound=Raw, covariant=True)


@dataclass(frozen=True)
class Observation(Generic[V_co]):
    """What one attribute or node is, and what shows it.

    Args:
        value: ``Raw`` for an attribute at one instant, ``Value`` for a node of the tree.
        evidence: Plain JSON data behind the value: who occludes, which joint angles, which contact.
    """

    value: V_co
    evidence: Mapping[str, Json] = field(default_factory=FrozenMap)

    def __post_init__(self) -> None:
        object.__setattr__(self, "evidence", freeze(self.evidence))
        if isinstance(self.value, Mapping):
            object.__setattr__(self, "value", freeze(self.value))

    def and_also(self, value: V) -> Observation[V]:
        """Another value that the same evidence shows."""
        other = cast(Observation[V], copy.copy(self))
        object.__setattr__(other, "value", freeze(value) if isinstance(value, Mapping) else value)
        return other

    def to_json(self) -> dict[str, Json]:
        """Plain data with the keys ``value`` (null when unknown) and ``evidence``."""
        value = None if self.value is UNKNOWN else thaw(cast(Json, self.value))
        return {"value": value, "evidence": thaw(self.evidence)}


NOT_OBSERVED: Final[Observation[Unknown]] = Observation(UNKNOWN)
"""An attribute of which nothing is known."""
