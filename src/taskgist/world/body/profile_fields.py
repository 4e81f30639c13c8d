"""The fields of an agent profile, one reader each."""

from __future__ import annotations

import math
from pathlib import Path

from taskgist.errors import UnknownNameError
from taskgist.world.body.attempts import UNREADABLE, Attempts
from taskgist.world.body.frames import FIELDS as FRAME_FIELDS
from taskgist.world.body.frames import frame_from, read_frame
from taskgist.world.body.profile import AS_THE_JOINT, DERIVED_M, POSTURES, Arm, Axis, Eye, Legs, Posture
from taskgist.world.body.urdf import SHAPES, Shapes
from taskgist.world.toml_table import TomlTable

SIDES = ("left", "right")


def _radians(pair: tuple[float, float]) -> tuple[float, float]:
    return math.radians(pair[0]), math.radians(pair[1])


def _range(table: TomlTable, key: str) -> tuple[float, float]:
    """A range of angles, lowest first."""
    low, high = table.pair(key)
    if low > high:
        raise table.error("a range is from its low to its high end", key, [low, high], f"as [{high:g}, {low:g}]")
    return _radians((low, high))


def read_eye(table: TomlTable, attempt: Attempts) -> Eye:
    """The ``[eye]`` table."""
    name = "site" if "site" in table else "frame"
    attempt(lambda: table.only({name, *FRAME_FIELDS, "exclude", "fov_deg", "image_px", "gaze_cone_deg"}), table)
    fov_rad = attempt(lambda: _fov_rad(table), (1.0, 1.0))
    frame = frame_from(table, name, attempt)
    nothing: tuple[str, ...] = (UNREADABLE,)
    exclude = attempt(lambda: _excluded(table), nothing)
    return Eye(
        frame=frame,
        exclude=exclude[0],
        housing=exclude[1:],
        fov_rad=fov_rad,
        image_px=attempt(lambda: _image_px(table), (1, 1)),
        gaze_cone_rad=attempt(lambda: _gaze_cone_rad(table, fov_rad), 1.0),
    )


def _fov_rad(table: TomlTable) -> tuple[float, float]:
    fov = table.pair("fov_deg")
    if not all(0 < angle < 180 for angle in fov):
        raise table.error("a pinhole sees between 0 and 180 degrees", "fov_deg", fov, "as [120, 105]")
    return _radians(fov)


def _image_px(table: TomlTable) -> tuple[int, int]:
    pixels = table.pair("image_px")
    if not all(value >= 1 and value == int(value) for value in pixels):
        raise table.error("an image needs at least one pixel each way", "image_px", pixels, "as [320, 240]")
    return int(pixels[0]), int(pixels[1])


def _excluded(table: TomlTable) -> tuple[str, ...]:
    """The body that the eye sits in, and more of them around it."""
    names = table.names("exclude") if isinstance(table.values.get("exclude"), list) else (table.text("exclude"),)
    if not names:
        raise table.error("an eye sits in a body", "exclude", [], 'as "head"')
    return names


def _gaze_cone_rad(table: TomlTable, fov_rad: tuple[float, float]) -> float:
    """Half-angle of the gaze cone; where none is given, the one that holds the whole image."""
    if "gaze_cone_deg" not in table:
        return math.atan(math.hypot(*(math.tan(angle / 2) for angle in fov_rad)))
    cone = table.number("gaze_cone_deg")
    if not 0 < cone <= 180:
        raise table.error("a gaze cone is a half-angle between 0 and 180 degrees", "gaze_cone_deg", cone, "as 30")
    return math.radians(cone)


def read_axis(table: TomlTable, key: str, attempt: Attempts) -> Axis | None:
    """A joint of head or torso; None where the body has none."""
    if key not in table:
        return None
    axis = table.table(key)
    attempt(lambda: axis.only({"joint", "range_deg"}), axis)
    joint = attempt(lambda: axis.text("joint"), UNREADABLE)
    if "range_deg" not in axis:
        return Axis(joint, AS_THE_JOINT)
    return Axis(joint, attempt(lambda: _range(axis, "range_deg"), AS_THE_JOINT))


def read_legs(table: TomlTable) -> Legs:
    """The ``[posture]`` table."""
    if not list(table):
        return Legs()
    joints = ("hips", "knees", "ankles", "thighs", "feet")
    table.only({"can", "seat_share", *joints})
    names = {key: table.names(key) for key in joints}
    can = tuple(read_posture(name, where=f"{table.where}: {table.path}") for name in table.names("can"))
    if "sitting" in can and not all(names.values()):
        missing = next(key for key, found in names.items() if not found)
        raise table.error("whoever sits has legs", missing, hint="name hips, knees, ankles, thighs and feet")
    return Legs(can=can, **names, seat_share=table.number("seat_share", 0.0))


def read_posture(name: str, *, where: str | Path) -> Posture:
    """A posture by its name.

    Raises:
        UnknownNameError: There is no such posture.
    """
    for posture in POSTURES:
        if name == posture:
            return posture
    raise UnknownNameError("posture", name, POSTURES, where=where)


def read_arm(table: TomlTable, stature_m: float | None, attempt: Attempts) -> Arm:
    """One ``[[arms]]`` table; the stature is for lengths given as a share of it."""
    sectors = {"azimuth_deg", "elevation_deg"}
    known = {"side", "shoulder", "hand", "palm", "root", "carrier", "length_m", "length_share", *sectors}
    attempt(lambda: table.only(known), table)

    def named(key: str) -> str:
        return attempt(lambda: table.text(key), UNREADABLE)

    return Arm(
        side=named("side"),
        shoulder=read_frame(table, "shoulder", attempt),
        hand=named("hand"),
        palm=read_frame(table, "palm", attempt),
        root=named("root"),
        length_m=attempt(lambda: _length_m(table, stature_m), DERIVED_M),
        azimuth_rad=attempt(lambda: _range(table, "azimuth_deg"), AS_THE_JOINT),
        elevation_rad=attempt(lambda: _range(table, "elevation_deg"), AS_THE_JOINT),
        carrier=named("carrier") if "carrier" in table else None,
    )


def _length_m(table: TomlTable, stature_m: float | None) -> float:
    key = "length_share" if stature_m and "length_share" in table else "length_m"
    if key not in table:
        return DERIVED_M
    length = table.number(key)
    if not length > 0:
        raise table.error("no arm is that long", key, length, "leave it out to derive it from the model")
    return length * stature_m if key == "length_share" and stature_m else length


def check_sides(table: TomlTable, arms: tuple[Arm, ...]) -> None:
    """Refuse sides that are none, and two arms on one side."""
    sides = [arm.side for arm in arms if arm.side != UNREADABLE]
    for side in sides:
        if side not in SIDES:
            raise UnknownNameError("side", side, SIDES, where=f"{table.where}: arms")
    if len(set(sides)) < len(sides):
        raise table.error("one arm on each side", "arms", sides, "leave the others out")


def read_rest_rad(table: TomlTable) -> tuple[tuple[str, float], ...]:
    """The ``[rest_deg]`` table, in radians."""
    angles = table.table("rest_deg")
    return tuple((joint, math.radians(angles.number(joint))) for joint in angles)


def read_rest_m(table: TomlTable) -> tuple[tuple[str, float], ...]:
    """The ``[rest_m]`` table."""
    ways = table.table("rest_m")
    return tuple((joint, ways.number(joint)) for joint in ways)


def read_shapes(table: TomlTable) -> Shapes:
    """Which shapes of a URDF are seen."""
    given = table.text("shapes", "visual")
    for shapes in SHAPES:
        if given == shapes:
            return shapes
    raise UnknownNameError("kind of shapes", given, SHAPES, where=f"{table.where}: shapes")


def read_parts(table: TomlTable) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """The ``[parts]`` table; empty where the parts are to be derived."""
    parts = table.table("parts")
    return tuple((name, parts.names(name)) for name in parts)
