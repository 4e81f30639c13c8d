"""Somebody who stands and reaches out, as programs of motion capture write it: small files of each format."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from taskgist.importing.skeletons import SKELETONS
from taskgist.world.geometry.transforms import about_z, matrix_from_wxyz
from tests.importing.skeletons import Array
from tests.importing.test_skeletons import FRAMES, body, seen_as

RATE_HZ = 30.0
TIMES_S = np.arange(FRAMES) / RATE_HZ
Y_UP = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
"""Rows are the axes of a source with y up, in those of the room: its x is our y, its y our z, its z our x."""


def points_of(skeleton: str) -> dict[str, Array]:
    """Points of that person, metres, z up, (frames, 3) by name."""
    return seen_as(SKELETONS[skeleton], *body())


def cup() -> tuple[Array, Array]:
    """Places (frames, 3), metres, z up, and orientations (frames, 4), wxyz, of a cup that is turned and pushed."""
    position = np.array([(-0.4 + 0.01 * k, 0.1, 0.8) for k in range(FRAMES)])
    return position, np.array([about_z(0.3 + 0.05 * k) for k in range(FRAMES)])


def in_y_up(position: Array) -> Array:
    """The same places in a source with y up."""
    return np.asarray(position @ Y_UP.T)


def matrices(wxyz: Array) -> Array:
    """Rotation matrices (frames, 3, 3)."""
    return matrix_from_wxyz(wxyz)


def text(value: float) -> str:
    """A cell: empty where lost."""
    return "" if np.isnan(value) else f"{value:.6f}"


def write_rows(path: Path, header: Iterable[str], rows: Iterable[Sequence[object]], delimiter: str) -> Path:
    lines = [*header, *(delimiter.join(text(c) if isinstance(c, float) else str(c) for c in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def cells(points: Mapping[str, Array], frame: int, scale: float) -> list[float]:
    return [float(scale * value) for position in points.values() for value in position[frame]]


def write_trc(path: Path, points: Mapping[str, Array]) -> Path:
    """Millimetres, y up."""
    points = {name: in_y_up(position) for name, position in points.items()}
    header = [
        f"PathFileType\t4\t(X/Y/Z)\t{path.name}",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        f"{RATE_HZ:.2f}\t{RATE_HZ:.2f}\t{FRAMES}\t{len(points)}\tmm\t{RATE_HZ:.2f}\t1\t{FRAMES}",
        "Frame#\tTime\t" + "\t\t\t".join(points) + "\t\t",
        "\t\t" + "\t".join(f"{axis}{k}" for k in range(1, len(points) + 1) for axis in "XYZ"),
        "",
    ]
    rows = ([k + 1, float(TIMES_S[k]), *cells(points, k, 1000.0)] for k in range(FRAMES))
    return write_rows(path, header, rows, "\t")


def write_nexus(path: Path, points: Mapping[str, Array], *, angles: bool = True) -> Path:
    """Millimetres, z up, with a section of joint angles and the poses of a cup."""

    def section(title: str, columns: Sequence[tuple[str, str, str]], values: Array) -> list[str]:
        names = ["" if k and columns[k - 1][0] == name else name for k, (name, _, _) in enumerate(columns)]
        header = [title, f"{RATE_HZ:.0f}", ",".join(["", "", *names])]
        header += [",".join(["Frame", "Sub Frame", *(axis for _, axis, _ in columns)])]
        header += [",".join(["", "", *(unit for _, _, unit in columns)])]
        return header + [",".join([str(k + 1), "0", *map(text, row)]) for k, row in enumerate(values)] + [""]

    flat = np.array([cells(points, k, 1000.0) for k in range(FRAMES)])
    lines = section("Trajectories", [(name, axis, "mm") for name in points for axis in "XYZ"], flat)
    if angles:
        three = [("Anna:LKneeAngles", axis, "deg") for axis in "XYZ"]
        lines += section("Model Outputs", three, np.full((FRAMES, 3), 12.5))
        position, wxyz = cup()
        columns = [("Global Angle cup:cup", axis, "") for axis in ("RX", "RY", "RZ", "RW")]
        columns += [("Global Angle cup:cup", axis, "mm") for axis in ("TX", "TY", "TZ")]
        lines += section("Objects", columns, np.hstack([wxyz[:, [1, 2, 3, 0]], 1000.0 * position]))
    path.write_text("\r\n".join(lines), encoding="utf-8")
    return path


def write_qualisys(path: Path, points: Mapping[str, Array], *, columns: bool = False) -> Path:
    """3D: millimetres, z up."""
    header = [
        f"NO_OF_FRAMES\t{FRAMES}",
        "NO_OF_CAMERAS\t8",
        f"NO_OF_MARKERS\t{len(points)}",
        f"FREQUENCY\t{RATE_HZ:.0f}",
        "NO_OF_ANALOG\t0",
        "ANALOG_FREQUENCY\t0",
        "DESCRIPTION\t--",
        "TIME_STAMP\t2026-01-22, 17:47:17\t22107.99",
        "DATA_INCLUDED\t3D",
        "MARKER_NAMES\t" + "\t".join(points),
    ]
    header += ["Frame\tTime\t" + "\t".join(f"{name} {a}" for name in points for a in "XYZ")] if columns else []
    first = ([[k + 1, float(TIMES_S[k])] for k in range(FRAMES)]) if columns else [[]] * FRAMES
    return write_rows(path, header, ([*first[k], *cells(points, k, 1000.0)] for k in range(FRAMES)), "\t")


def write_qualisys_6d(path: Path, position: Array, wxyz: Array, *, lost: Sequence[int] = ()) -> Path:
    """6D of a cup, its rotation matrix by columns."""
    header = [f"NO_OF_FRAMES\t{FRAMES}", "NO_OF_BODIES\t1", f"FREQUENCY\t{RATE_HZ:.0f}", "DATA_INCLUDED\t6D"]
    header += ["BODY_NAMES\tcup", "Frame\tTime\tcup X\tY\tZ\tRoll\tPitch\tYaw\tResidual" + "\tRot[]" * 9]
    by_column = matrices(wxyz).transpose(0, 2, 1).reshape(FRAMES, 9)
    poses = np.hstack([1000.0 * position, np.zeros((FRAMES, 3)), np.ones((FRAMES, 1)), by_column])
    poses[list(lost)] = 0.0
    return write_rows(path, header, ([k + 1, float(TIMES_S[k]), *map(float, poses[k])] for k in range(FRAMES)), "\t")


Column = tuple[str, str, str, str, Array]
"""Type, name, kind and axis of a column of Motive, and its values (frames,)."""


def motive_columns(kind: str, name: str, position: Array, xyzw: Array | None = None) -> list[Column]:
    turn = [] if xyzw is None else [(kind, name, "Rotation", axis, xyzw[:, k]) for k, axis in enumerate("XYZW")]
    return [*turn, *((kind, name, "Position", axis, position[:, k]) for k, axis in enumerate("XYZ"))]


def write_motive(path: Path, columns: Sequence[Column], *, timecode: bool = False) -> Path:
    """Metres, y up."""
    extra = [""] if timecode else []
    rows = zip(*(column[:4] for column in columns), strict=True)
    types, names, kinds, axes = ([*row] for row in rows)
    header = [
        f"Format Version,1.23,Take Name,{path.stem},Take Notes,,Capture Frame Rate,{RATE_HZ:.6f},Rotation Type,"
        "Quaternion,Length Units,Meters,Coordinate Space,Global",
        "",
        ",".join(["", "Type", *extra, *types]),
        ",".join(["", "Name", *extra, *(f'"{name}"' for name in names)]),
        ",".join(["", "ID", *extra, *(f'"{len(name)}"' for name in names)]),
        ",".join(["", "", *extra, *kinds]),
        ",".join(["Frame", "Time (Seconds)", *(["TimeCode"] if timecode else []), *axes]),
    ]
    data = np.stack([column[4] for column in columns], axis=1)
    stamps = ["15:26:46:12.02"] if timecode else []
    return write_rows(path, header, ([k, float(TIMES_S[k]), *stamps, *map(float, data[k])] for k in range(FRAMES)), ",")


def write_c3d(
    path: Path,
    points: Mapping[str, Array],
    *,
    processor: int = 84,
    as_integers: bool = False,
    analog: int = 0,
    angles: Sequence[str] = (),
    y_screen: str = "+Z",
) -> Path:
    """Millimetres, z up; lost points have a negative residual."""
    order = ">" if processor == 86 else "<"

    def floats(values: Array) -> bytes:
        if processor != 85:
            return np.asarray(values, f"{order}f4").tobytes()
        ieee = np.ascontiguousarray(np.asarray(values, "<f4") * np.float32(4.0)).view("<u2").reshape(-1, 2)
        return ieee[:, ::-1].tobytes()

    def record(group: int, name: str, kind: int, shape: Sequence[int], data: bytes) -> bytes:
        body_ = struct.pack("bB", kind, len(shape)) + bytes(shape) + data + b"\0"
        return struct.pack("bb", len(name), group) + name.encode() + struct.pack(f"{order}H", len(body_) + 2) + body_

    def texts(name: str, values: Sequence[str]) -> bytes:
        width = max(map(len, values))
        data = "".join(value.ljust(width) for value in values).encode()
        return record(1, name, -1, (width, len(values)), data)

    scale = 0.1 if as_integers else -1.0
    section = struct.pack("bb", -5, -1) + b"POINT" + struct.pack(f"{order}H", 3) + b"\0"
    section += texts("LABELS", list(points)) + texts("UNITS", ["mm"]) + texts("Y_SCREEN", [y_screen])
    section += record(1, "RATE", 4, (), floats(np.array([RATE_HZ]))) + record(
        1, "SCALE", 4, (), floats(np.array([scale]))
    )
    for name, value in (("USED", len(points)), ("FRAMES", FRAMES)):
        section += record(1, name, 2, (), struct.pack(f"{order}H", value))
    section += texts("ANGLES", angles) if angles else b""
    section += bytes(2)
    blocks = -(-(len(section) + 4) // 512)
    section = (struct.pack("bbBB", 1, 80, blocks, processor) + section).ljust(512 * blocks, b"\0")
    words = struct.pack(f"{order}BBHHHHH", 2, 80, len(points), analog, 1, FRAMES, 0)
    header = words + floats(np.array([scale])) + struct.pack(f"{order}HH", 2 + blocks, 1) + floats(np.array([RATE_HZ]))
    frames = b""
    for k in range(FRAMES):
        place = np.array([position[k] for position in points.values()]) * 1000.0
        word = np.where(np.isnan(place).any(axis=1), -1.0, 0.0)
        flat = np.nan_to_num(np.column_stack([place / (scale if as_integers else 1.0), word])).ravel()
        flat = np.concatenate([flat, np.full(analog, 7.0)])
        frames += np.round(flat).astype(f"{order}i2").tobytes() if as_integers else floats(flat)
    path.write_bytes(header.ljust(512, b"\0") + section + frames)
    return path
