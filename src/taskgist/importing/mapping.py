"""What a mapping file says about people, robots, objects, supports, time and label.

All lengths are metres, all times seconds, all axes those of the room (x forward, y left, z up), unless a name says
that something is the *source's*.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from taskgist.recording.recording import Label, Provenance

# --- What a mapping file says about the files with the numbers: how to take them apart, and what the numbers mean.

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
        repeated: Which of several rows with the same time counts, "first" or "last"; None: they are refused.
    """

    column: Name | None = None
    unit_s: float = 1.0
    rate_hz: float | None = None
    offset_s: float = 0.0
    repeated: str | None = None


@dataclass(frozen=True)
class Rotation:
    """How a source writes orientations (of the body, in the source's axes).

    Attributes:
        columns: Columns of the numbers.
        kind: "xyzw", "wxyz", "matrix" (nine numbers by row), "rotation_vector", "euler_intrinsic" or "euler_extrinsic".
        order: Axes of the Euler angles, in the order of their columns, such as "zyx".
        unit_rad: Radians per unit of angle.
        identity_is_lost: Whether samples without any turn are those of a lost tracker; None: nobody said.
        array: Name of the array that holds them, as ``TableFormat.array``; None: that of the positions.
    """

    columns: Columns
    kind: str
    order: str = ""
    unit_rad: float = 1.0
    identity_is_lost: bool | None = None
    array: str | None = None


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
        array: Name of the array in an NPZ or a file of MATLAB, which may hold ``{person}``, ``{point}``.
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
        kind: "csv", "npz", "npy", "mat", or a key of ``readers.READERS``.
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


@dataclass(frozen=True)
class PointRef:
    """One point of a source, shifted by an offset in its own local axes (the source's; 6-DoF points only)."""

    source: str
    point: Name
    offset_m: Vector | None = None


@dataclass(frozen=True)
class Point:
    """A landmark of a person: the mean of one or more points."""

    landmark: str
    refs: tuple[PointRef, ...]


@dataclass(frozen=True)
class LocalAxis:
    """A direction given by a local axis of a 6-DoF landmark, in the source's naming of that body's axes."""

    landmark: str
    axis: Vector


@dataclass(frozen=True)
class Between:
    """A direction from the mean of some landmarks to the mean of others, then raised by an angle."""

    start: tuple[str, ...]
    end: tuple[str, ...]
    raise_rad: float = 0.0


@dataclass(frozen=True)
class Person:
    """One person: which points are which landmarks, which way its parts point, what is not to be believed.

    Attributes:
        token: What ``{person}`` stands for in the source.
        directions: By their names in the fit of a body, such as "face" and "left_palm".
        unknown: Part of the body and why it is unknown.
        skeleton: The name of the skeleton (``skeletons.SKELETONS``) that the mapping gives, or "".
        preset: Landmarks whose points are those of the skeleton.
    """

    name: str
    token: Name
    points: tuple[Point, ...]
    directions: tuple[tuple[str, LocalAxis | Between], ...]
    unknown: tuple[tuple[str, str], ...]
    stature_m: float | None
    skeleton: str = ""
    preset: tuple[str, ...] = ()


@dataclass(frozen=True)
class Shape:
    """One primitive or mesh, in the frame of the object that it belongs to.

    Attributes:
        kind: "box", "cylinder", "sphere" or "mesh".
        size_m: Box: full edges along x, y, z; cylinder: radius, length (along ``axis``); sphere: radius; mesh: none.
        position_m: Centre (mesh: origin) in the object's frame.
        wxyz: Orientation in the object's frame.
        mesh: File of the mesh.
        scale_m: Metres per unit of the mesh.
    """

    kind: str
    size_m: tuple[float, ...]
    position_m: Vector = (0.0, 0.0, 0.0)
    wxyz: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    mesh: Path | None = None
    scale_m: float = 1.0


@dataclass(frozen=True)
class FixedPose:
    """A pose that nobody tracked, because it does not change."""

    position_m: Vector
    yaw_rad: float


@dataclass(frozen=True)
class Markers:
    """Points on a thing that keep their distances, three or more."""

    refs: tuple[PointRef, ...]


@dataclass(frozen=True)
class Thing:
    """An object: where its pose comes from, and its shape.

    Attributes:
        estimated: Whether shape or place are an estimate rather than a measurement.
        note: How they were estimated.
        stays: Whether it stays where it was last seen while it is not tracked.
    """

    name: str
    pose: PointRef | FixedPose | Markers
    shapes: tuple[Shape, ...]
    estimated: bool
    note: str
    stays: bool = False


@dataclass(frozen=True)
class JointColumns:
    """Where the joints of a robot stand.

    Attributes:
        source: The source.
        column: Its columns, of which ``{joint}`` is the joint's name.
        unit_rad: Radians per unit of joints that turn; those that slide are in metres.
    """

    source: str
    column: str
    unit_rad: float


@dataclass(frozen=True)
class Robot:
    """A robot: what it is, where its base is tracked, and where its joints stand.

    Attributes:
        profile: A built-in profile, or a file.
        pose: Of its base.
        joints: None where nobody published them: it stays at rest.
    """

    name: str
    profile: str
    pose: PointRef | FixedPose
    joints: JointColumns | None


@dataclass(frozen=True)
class Support:
    """A box that things rest on (a table, a shelf board, a seat), which was not tracked.

    Attributes:
        size_m: Full edges.
        position_m: Its centre.
    """

    name: str
    size_m: Vector
    position_m: Vector
    yaw_rad: float
    estimated: bool
    note: str


@dataclass(frozen=True)
class Timeline:
    """The frames of the recording to be made.

    Attributes:
        rate_hz: Frames per second.
        max_gap_s: Longest stretch without samples that is interpolated over; beyond it the point is unknown.
        start_s: First moment, in the time of the sources; ``None``: their first sample.
        end_s: Last moment; ``None``: their last sample.
    """

    rate_hz: float
    max_gap_s: float
    start_s: float | None
    end_s: float | None


@dataclass(frozen=True)
class SignalColumn:
    """A column of numbers that are no motion, such as the force of a grip.

    Attributes:
        source: Source that holds it.
        column: Its column.
        scale: What its numbers are multiplied by.
        unit: Unit of the result.
    """

    name: str
    source: str
    column: Name
    scale: float
    unit: str


@dataclass(frozen=True)
class ImportMapping:
    """A whole mapping file.

    Attributes:
        name: What the recording is called.
        file: Where it was read from.
        files: That file and those that it extends.
        data_dir: Folder at which relative file names start.
        about: Origin, licence, citation and the text of this mapping.
    """

    name: str
    file: Path
    files: tuple[Path, ...]
    data_dir: Path
    about: Provenance
    timeline: Timeline
    sources: tuple[Source, ...]
    people: tuple[Person, ...]
    objects: tuple[Thing, ...]
    supports: tuple[Support, ...]
    signals: tuple[SignalColumn, ...]
    label: Label | None
    robots: tuple[Robot, ...] = ()

    @property
    def agents(self) -> tuple[Person | Robot, ...]:
        """People and robots."""
        return (*self.people, *self.robots)

    @property
    def posed(self) -> tuple[Thing | Robot, ...]:
        """What is tracked as one body: objects, and bases of robots."""
        return (*self.objects, *self.robots)

    def source(self, name: str) -> Source:
        """The source of that name, which loading has made sure exists."""
        return next(source for source in self.sources if source.name == name)
