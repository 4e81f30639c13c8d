"""Where a recording comes from, and what was done to it."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any


@dataclass(frozen=True)
class Provenance:
    """Origin of a recording.

    Attributes:
        source: Who recorded it, where it was published.
        licence: Licence under which it may be used.
        citation: What to cite.
        simulated: Whether a scripted demonstrator made it, rather than people.
        notes: What a user should know about it: estimates, parts that are unknown and why.
        mapping: Text of the mapping file that brought it in.
        fit: Report on how well the body fits the tracked points, as plain JSON values.
    """

    source: str = ""
    licence: str = ""
    citation: str = ""
    simulated: bool = False
    notes: tuple[str, ...] = ()
    mapping: str = ""
    fit: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "notes", tuple(self.notes))
        object.__setattr__(self, "fit", MappingProxyType(copy.deepcopy(dict(self.fit))))

    def __reduce__(self) -> tuple[object, ...]:
        """Rebuild through the constructor: a read-only mapping cannot be pickled."""
        return (Provenance, tuple(self.as_dict().values()))

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values, in order."""
        return {
            "source": self.source,
            "licence": self.licence,
            "citation": self.citation,
            "simulated": self.simulated,
            "notes": list(self.notes),
            "mapping": self.mapping,
            "fit": copy.deepcopy(dict(self.fit)),
        }
