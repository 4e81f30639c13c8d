"""What a mapping file says about the files with the numbers: how to take them apart, and what the numbers mean."""

from __future__ import annotations

from dataclasses import dataclass

Vector = tuple[float, float, float]
Name = str | int
"""What a source calls a point: a name, or an index."""


@dataclass(frozen=True)
class Columns:
    """Columns of a table, by name or 0-based index. In an NPZ, a name is that of an array without a "value" axis.

    Attributes:
        items: Names, which may hold ``{person}``, ``{point}``, or indices.
        step: Columns from one point to the next, added to indices as often as the point's index says.
    """

    items: tuple[Name, ...]
    step: int = 0


@dataclass(frozen=True)
class Clock:
    """Where the time of each row comes from: a column, or a fixed rate.

    Attributes:
        column: Column with the time.
        unit_s: Seconds per unit of that column.
        rate_hz: Rows per second, if there is no column.
        offset_s: Added to every time, to bring sources together.
    """

    column: Name | None = None
    unit_s: float = 1.0
    rate_hz: float | None = None
    offset_s: float = 0.0


@dataclass(frozen=True)
class Rotation:
    """How a source writes orientations (of the body, in the source's axes).

    Attributes:
        columns: Columns of the numbers.
        kind: "xyzw", "wxyz", "matrix" (nine numbers by row), "rotation_vector", "euler_intrinsic" or "euler_extrinsic".
        order: Axes of the Euler angles, in the order of their columns, such as "zyx".
        unit_rad: Radians per unit of angle.
    """

    columns: Columns
    kind: str
    order: str = ""
    unit_rad: float = 1.0


@dataclass(frozen=True)
class Confidence:
    """The tracker's own word on each point.

    Attributes:
        column: Column with the confidence.
        least: Points below this are unknown.
    """

    column: Name
    least: float


@dataclass(frozen=True)
class Frame:
    """From the source's axes to the room's: ``room = turn · axes · (scale · source) + position``.

    Attributes:
        scale_m: Metres per unit of the source.
        axes: Rows are our x, y and z in the source's axes; left-handed sources give a reflection.
        turn: Rotation that follows.
        position_m: Translation that follows.
    """

    scale_m: float
    axes: tuple[Vector, Vector, Vector]
    turn: tuple[Vector, Vector, Vector]
    position_m: Vector


@dataclass(frozen=True)
class TableFormat:
    """How to take apart a source's file; ``None`` leaves it to be found out.

    Attributes:
        delimiter: Between columns; "whitespace" for runs of blanks.
        header: Whether the first row names the columns.
        skip_rows: Lines before it.
        comment: Lines that start with this are skipped.
        decimal: Decimal mark.
        where: Column and text that a row must have to count; both may hold ``{person}``, ``{point}``.
        array: Name of the array in an NPZ, which may hold ``{person}``, ``{point}``.
        layout: What each axis of the array is: "time", "value", "{person}", "{point}" or a fixed index.
    """

    delimiter: str | None = None
    header: bool | None = None
    skip_rows: int = 0
    comment: str = "#"
    decimal: str = "."
    where: tuple[tuple[Name, str], ...] = ()
    array: str | None = None
    layout: tuple[Name, ...] = ()


@dataclass(frozen=True)
class Source:
    """One file, or family of files, with poses or points.

    Attributes:
        file: Path, which may hold ``{person}`` and ``{point}``; relative ones start at the data folder.
        kind: "csv", "npz" or "npy".
        names: The source's points in their order, where columns or arrays know them by index only.
        missing: Values that stand for "not tracked"; a point all of whose coordinates are the same one is unknown.
            ``None`` if the mapping does not say.
        smooth_s: Window in seconds over which jitter is smoothed; 0 for none.
    """

    name: str
    file: str
    kind: str
    table: TableFormat
    clock: Clock
    position: Columns
    rotation: Rotation | None
    confidence: Confidence | None
    frame: Frame
    names: tuple[str, ...]
    missing: tuple[float, ...] | None
    smooth_s: float = 0.0
