"""What a published format of motion capture holds, whatever the format: named points and bodies over time.

Every reader in ``formats`` returns a ``Take``. To the rest of the import it is one more table: the rows of one point
are a part with the columns ``t``, ``x``, ``y``, ``z``, ``qw``, ``qx``, ``qy``, ``qz`` and ``confidence``, which are
read as the columns of a text are.

Names are those of the file. Programs that track several people write ``person:point``; so does every reader whose
format keeps people apart by other means.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import MappingError, UnknownNameError
from taskgist.importing.mapping import Columns, Name, Rotation

POSITION = Columns(("x", "y", "z"))
ROTATION = Rotation(Columns(("qw", "qx", "qy", "qz")), "wxyz", identity_is_lost=False)
"""How a take's own readers write orientations; what is lost is NaN there already."""
TIME, CONFIDENCE = "t", "confidence"
OWNER = ":"
"""Between the name of a person, or of another owner, and that of a point."""


@dataclass(frozen=True, eq=False)
class TakeTrack:
    """One point or body of a take.

    Attributes:
        times_s: Times of its samples, (n,), seconds.
        position: In the file's own unit and axes, (n, 3); NaN where lost.
        wxyz: Orientation in the file's own axes, (n, 4), NaN where lost; ``None`` for a bare point.
        confidence: The tracker's own word, (n,); ``None`` if it gives none.
    """

    times_s: Array
    position: Array
    wxyz: Array | None = None
    confidence: Array | None = None


@dataclass(frozen=True, eq=False)
class Series:
    """Numbers over time that are no place: the angle of a joint.

    Attributes:
        times_s: Times of its samples, (n,), seconds.
        values: (n,).
    """

    times_s: Array
    values: Array


@dataclass(frozen=True, eq=False)
class Take:
    """What a file of motion capture holds.

    Attributes:
        kind: The format, as a mapping names it.
        tracks: Points and bodies by name, in the order of the file.
        things: Those of the names that the file calls rigid bodies or objects.
        unit: "m", "cm", "mm" or "inch" if the format says so.
        up: The file's axis that points up, such as "y" or "-y", if the format says so.
        notes: What a user should know of the file.
        series: Numbers over time by name; of bags, the joints of robots in radians and metres.
    """

    kind: str
    tracks: Mapping[str, TakeTrack]
    things: frozenset[str] = frozenset()
    unit: str | None = None
    up: str | None = None
    notes: tuple[str, ...] = ()
    series: Mapping[str, Series] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class TakePart:
    """The samples of one point of a take, as a table.

    Attributes:
        track: The samples.
        where: Mapping, source and file, for messages.
    """

    track: TakeTrack
    where: str

    @property
    def oriented(self) -> bool:
        """Whether it is a body, which has orientations."""
        return self.track.wxyz is not None

    def numbers(self, columns: Sequence[Name]) -> Array:
        """Columns by name, (samples, columns).

        Raises:
            MappingError: A confidence is asked of a point without one.
            UnknownNameError: There is no such column.
        """
        found = [self._column(str(column)) for column in columns]
        return np.column_stack(found)

    def place(self, row: int) -> str:
        """Index and time of the sample."""
        return f"frame {row} ({self.track.times_s[row]:.3f} s)"

    def _column(self, name: str) -> Array:
        track = self.track
        if name == TIME:
            return track.times_s
        if name in POSITION.items:
            return np.asarray(track.position[:, POSITION.items.index(name)])
        if name in ROTATION.columns.items and track.wxyz is not None:
            return np.asarray(track.wxyz[:, ROTATION.columns.items.index(name)])
        if name != CONFIDENCE:
            raise UnknownNameError("column", name, (TIME, CONFIDENCE, *map(str, POSITION.items)), where=self.where)
        if track.confidence is None:
            hint = "leave confidence out: this file has none"
            raise MappingError("the point has no confidence", where=self.where, field="confidence", hint=hint)
        return track.confidence


def part_of(take: Take, person: Name, point: Name, where: str) -> TakePart:
    """The samples of a point: ``person:point`` if there is such a name, else ``point``.

    Args:
        take: The take.
        person: What the mapping's ``person`` says.
        point: The point's name, or its index in the order of the file.
        where: Mapping, source and file, for messages.

    Raises:
        UnknownNameError: There is no such point.
    """
    if isinstance(point, int) and point < len(take.tracks):
        return TakePart(list(take.tracks.values())[point], where)
    for name in (f"{person}{OWNER}{point}", str(point)):
        if name in take.tracks:
            return TakePart(take.tracks[name], where)
    raise UnknownNameError("point", str(point), take.tracks, where=where)


def series_of(take: Take, name: str, where: str) -> Series:
    """Numbers over time by name.

    Raises:
        UnknownNameError: There are none of that name.
    """
    if name not in take.series:
        raise UnknownNameError("series of numbers", name, take.series, where=where)
    return take.series[name]
