"""A setting: a furnished room, who acts in it for whom, and what the means needs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from taskgist.demonstrator.means import Roles
from taskgist.demonstrator.room import Room


@dataclass(frozen=True)
class Setting:
    """What a demonstration begins with.

    Attributes:
        room: The room with its people and things.
        roles: Who acts with what for whom.
        props: Names of what else the means needs, by the part that it plays ("occluder", "container").
        amounts: Distances in metres and the like, by name.
        places: Places that the means needs, metres, (3,) each, by name ("board").
    """

    room: Room
    roles: Roles
    props: Mapping[str, str] = field(default_factory=dict)
    amounts: Mapping[str, float] = field(default_factory=dict)
    places: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("props", "amounts", "places"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))
