"""Agent profiles: what a body can see, reach, grasp and do, by names of its model.

A profile is a TOML document beside a model. It makes one reasoning serve every body: nothing outside of this file asks
whether an agent is a human or a robot. ``profiles/human.toml`` and ``profiles/pr2.toml`` comment every field;
``profile_file.py`` reads them. What a profile leaves out, ranges of joints and lengths of arms, is derived from the
model (``derived.py``).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib import resources
from pathlib import Path
from typing import Any, Literal, get_args

import mujoco
import numpy as np

from taskgist.common.toml import UNREADABLE, Attempts, TomlTable
from taskgist.errors import InputError, UnknownNameError
from taskgist.settings import DEFAULT, Limits
from taskgist.world.bodies.hands import Hand, parse_hand
from taskgist.world.bodies.urdf import SHAPES, Shapes
from taskgist.world.geometry.transforms import IDENTITY_WXYZ, multiply

# --- Frames of a body that a profile names: eye, shoulders, palms.
#
# A frame is a site of the model, or one of its bodies, maybe moved and turned: URDF knows links only, and cameras'
# links look along z. A frame on a body becomes a site when the agent is assembled.

OPTICAL_WXYZ = (0.5, 0.5, -0.5, 0.5)
"""The frame that looks along x with z up, in a camera's optical frame: z forward, x to the right, y down (REP 103)."""
SITE_GROUP, SITE_M = 4, 0.01
"""Group and radius of the sites that are added: never seen."""
FRAME_FIELDS = ("offset_m", "rpy_deg", "optical")


@dataclass(frozen=True)
class Frame:
    """A frame fixed to a body.

    Attributes:
        name: Site or body of the model.
        offset_m: Where the frame is, in that body, metres.
        wxyz: How it is turned there.
    """

    name: str
    offset_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    wxyz: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)

    @property
    def is_plain(self) -> bool:
        """Whether the frame is the named one, neither moved nor turned."""
        return self == Frame(self.name)


def read_frame(table: TomlTable, key: str, attempt: Attempts) -> Frame:
    """A frame that a field of a profile gives.

    The field is the name of a site or body, or a table ``{ frame = "camera_link", offset_m = [0, 0, 0.1],
    rpy_deg = [0, 0, 90], optical = true }``: roll, pitch and yaw as in URDF.
    """
    if not isinstance(table.values.get(key), dict):
        return Frame(attempt(lambda: table.text(key), UNREADABLE))
    inner = table.table(key)
    attempt(lambda: inner.only({"frame", *FRAME_FIELDS}), inner)
    return frame_from(inner, "frame", attempt)


def frame_from(table: TomlTable, key: str, attempt: Attempts) -> Frame:
    """A frame whose name stands under ``key``, with its offset and turn beside it in the same table."""
    zero = (0.0, 0.0, 0.0)
    name = attempt(lambda: table.text(key), UNREADABLE)
    offset_m = attempt(lambda: table.triple("offset_m", zero), zero)
    wxyz = _wxyz_from_rpy(attempt(lambda: table.triple("rpy_deg", zero), zero))
    if attempt(lambda: table.flag("optical", False), False):
        wxyz = multiply(wxyz, OPTICAL_WXYZ)
    w, x, y, z = (float(value) for value in wxyz)
    return Frame(name, offset_m, (w, x, y, z))


def _wxyz_from_rpy(rpy_deg: tuple[float, float, float]) -> np.ndarray:
    """URDF's fixed-axis roll, pitch, yaw: about x first, z last."""
    wxyz: np.ndarray = IDENTITY_WXYZ
    for axis, angle in enumerate(rpy_deg):
        half = math.radians(angle) / 2
        turn = np.array([math.cos(half), 0.0, 0.0, 0.0])
        turn[1 + axis] = math.sin(half)
        wxyz = multiply(turn, wxyz)
    return wxyz


def add_frame(spec: mujoco.MjSpec, frame: Frame, label: str) -> None:
    """Make a frame a site of the model, called ``label``; nothing to do where the frame is a site itself."""
    if spec.site(frame.name) is not None:
        return
    size = [SITE_M] * 3
    spec.body(frame.name).add_site(name=label, pos=frame.offset_m, quat=frame.wxyz, group=SITE_GROUP, size=size)


Posture = Literal["standing", "sitting"]
POSTURES: tuple[Posture, ...] = get_args(Posture)

AS_THE_JOINT = (-math.inf, math.inf)
"""Range of a joint that is as wide as the model's."""
DERIVED_M = 0.0
"""Length of an arm that is derived from the model."""


@dataclass(frozen=True)
class Eye:
    """A pinhole eye: a frame that looks along its x axis, z up.

    Attributes:
        exclude: The body that the eye sits in, which hides nothing from it.
        housing: More bodies around the eye, such as a camera's case; nobody sees them.
        turn_rad: How far the eye turns in the head; None: as people's eyes do (setting ``gaze.range_rad``).
    """

    frame: Frame
    exclude: str
    housing: tuple[str, ...]
    fov_rad: tuple[float, float]
    image_px: tuple[int, int]
    gaze_cone_rad: float
    turn_rad: float | None = 0.0


@dataclass(frozen=True)
class Axis:
    """A joint that a virtual action may move, within a range in radians."""

    joint: str
    range_rad: tuple[float, float]


@dataclass(frozen=True)
class Legs:
    """How a body stands, sits and bends; all empty for a body that only stands straight.

    Hips, knees and ankles, one of each leg in the same order, bend it; thighs and feet are for sitting, too.
    """

    can: tuple[Posture, ...] = ("standing",)
    hips: tuple[str, ...] = ()
    knees: tuple[str, ...] = ()
    ankles: tuple[str, ...] = ()
    thighs: tuple[str, ...] = ()
    feet: tuple[str, ...] = ()
    seat_share: float = 0.0


@dataclass(frozen=True)
class Arm:
    """One arm: where it hangs, how far and where it reaches.

    ``azimuth_rad`` is (across the body, outward) about the vertical of the shoulder's frame, ``elevation_rad`` (down,
    up). ``carrier`` is the body whose frame that is, x forward and z up: by default what the arm's root hangs on.
    ``thrust`` is the joint of the shoulder girdle that brings the shoulder forward, as far as its range goes; None if
    there is none.
    """

    side: str
    shoulder: Frame
    hand: str
    palm: Frame
    root: str
    length_m: float
    azimuth_rad: tuple[float, float]
    elevation_rad: tuple[float, float]
    carrier: str | None = None
    thrust: Axis | None = None


@dataclass(frozen=True)
class AgentProfile:
    """What a body can do; ``model`` names its model.

    Attributes:
        rest_rad: Angles of joints that turn, where nothing else is said.
        rest_m: Ways of joints that slide, where nothing else is said.
        shapes: Which shapes of a URDF are seen.
    """

    name: str
    model: str
    eye: Eye
    pan: Axis | None
    tilt: Axis | None
    turn: Axis | None
    lean: Axis | None
    legs: Legs
    moves: bool
    arms: tuple[Arm, ...]
    hand: Hand | None
    parts: tuple[tuple[str, tuple[str, ...]], ...]
    rest_rad: tuple[tuple[str, float], ...] = ()
    rest_m: tuple[tuple[str, float], ...] = ()
    shapes: Shapes = "visual"

    @property
    def frames(self) -> tuple[tuple[str, str, Frame], ...]:
        """Every frame: the label of the site that it becomes, the field that gives it, the frame."""
        arms = [
            (f"{arm.side}_{name}_frame", f"arms.{arm.side}.{name}", frame)
            for arm in self.arms
            for name, frame in (("shoulder", arm.shoulder), ("palm", arm.palm))
        ]
        return (("eye_frame", "eye.frame", self.eye.frame), *arms)

    @property
    def axes(self) -> tuple[tuple[str, Axis], ...]:
        """The joints of virtual actions, each by its field."""
        named = {"head.pan": self.pan, "head.tilt": self.tilt, "torso.turn": self.turn, "torso.lean": self.lean}
        named |= {f"arms.{arm.side}.thrust": arm.thrust for arm in self.arms}
        return tuple((field, axis) for field, axis in named.items() if axis)


def builtin_profiles() -> tuple[str, ...]:
    """Names of the profiles that come with taskgist."""
    folder = resources.files("taskgist.world") / "profiles"
    return tuple(sorted(Path(entry.name).stem for entry in folder.iterdir() if entry.name.endswith(".toml")))


def builtin_profile_text(name: str) -> str:
    """TOML text of a built-in profile."""
    return (resources.files("taskgist.world") / "profiles" / f"{name}.toml").read_text(encoding="utf-8")


# --- The fields of an agent profile, one reader each.

SIDES = ("left", "right")


def _radians(pair: tuple[float, float]) -> tuple[float, float]:
    return math.radians(pair[0]), math.radians(pair[1])


def _range(table: TomlTable, key: str) -> tuple[float, float]:
    """A range of angles, lowest first."""
    low, high = table.pair(key)
    if low > high:
        raise table.error("a range is from its low to its high end", key, [low, high], f"as [{high:g}, {low:g}]")
    return _radians((low, high))


def read_eye(table: TomlTable, attempt: Attempts, limits: Limits = DEFAULT.limits) -> Eye:
    """The ``[eye]`` table; the limits are those of its image."""
    name = "site" if "site" in table else "frame"
    attempt(
        lambda: table.only({name, *FRAME_FIELDS, "exclude", "fov_deg", "image_px", "gaze_cone_deg", "turn_deg"}), table
    )
    fov_rad = attempt(lambda: _fov_rad(table), (1.0, 1.0))
    frame = frame_from(table, name, attempt)
    nothing: tuple[str, ...] = (UNREADABLE,)
    exclude = attempt(lambda: _excluded(table), nothing)
    return Eye(
        frame=frame,
        exclude=exclude[0],
        housing=exclude[1:],
        fov_rad=fov_rad,
        image_px=attempt(lambda: _image_px(table, limits), (1, 1)),
        gaze_cone_rad=attempt(lambda: _gaze_cone_rad(table, fov_rad), 1.0),
        turn_rad=attempt(lambda: _turn_rad(table), None),
    )


def _fov_rad(table: TomlTable) -> tuple[float, float]:
    fov = table.pair("fov_deg")
    if not all(0 < angle < 180 for angle in fov):
        raise table.error("a pinhole sees between 0 and 180 degrees", "fov_deg", fov, "as [120, 105]")
    return _radians(fov)


def _image_px(table: TomlTable, limits: Limits) -> tuple[int, int]:
    pixels = table.pair("image_px")
    if not all(value >= 1 and value == int(value) for value in pixels):
        raise table.error("an image needs at least one pixel each way", "image_px", pixels, "as [320, 240]")
    if pixels[0] * pixels[1] > limits.image_pixels:
        hint = f"at most {limits.image_pixels:,} pixels are cast (setting limits.image_pixels): give fewer each way"
        raise table.error("an image too large", "image_px", pixels, hint)
    return int(pixels[0]), int(pixels[1])


def _excluded(table: TomlTable) -> tuple[str, ...]:
    """The body that the eye sits in, and more of them around it."""
    names = table.texts("exclude") if isinstance(table.values.get("exclude"), list) else (table.text("exclude"),)
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


def _turn_rad(table: TomlTable) -> float | None:
    """How far the eye turns in the head; unless it is said, who attends to a cone has eyes, and others have cameras."""
    if "turn_deg" not in table:
        return None if "gaze_cone_deg" in table else 0.0
    turn = table.number("turn_deg")
    if not 0 <= turn < 90:
        raise table.error("eyes turn by less than 90 degrees", "turn_deg", turn, "as 35, or 0 for a camera")
    return math.radians(turn)


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
    names = {key: table.texts(key) for key in joints}
    if not len(names["hips"]) == len(names["knees"]) == len(names["ankles"]):
        raise table.error("hips, knees and ankles, as many of each as there are legs", hint="name them leg by leg")
    can = tuple(read_posture(name, where=f"{table.place}") for name in table.texts("can"))
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
    known = {"side", "shoulder", "hand", "palm", "root", "carrier", "thrust", "length_m", "length_share", *sectors}
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
        thrust=attempt(lambda: read_axis(table, "thrust", attempt), None),
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
            raise UnknownNameError("side", side, SIDES, where=f"{table.place}: arms")
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
    raise UnknownNameError("kind of shapes", given, SHAPES, where=f"{table.place}: shapes")


def read_parts(table: TomlTable) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """The ``[parts]`` table; empty where the parts are to be derived."""
    parts = table.table("parts")
    return tuple((name, parts.texts(name)) for name in parts)


# --- Reading agent profiles: each field by name, every problem found.

TABLES = {"name", "model", "shapes", "eye", "head", "torso", "posture", "base", "arms", "hand", "parts"}
RESTS = {"rest_deg", "rest_m"}


def parse_profile(
    text: bytes | str, *, where: str | Path, stature_m: float | None = None, limits: Limits = DEFAULT.limits
) -> AgentProfile:
    """Read a profile.

    Args:
        text: The TOML document.
        where: File name for error messages.
        stature_m: Stature of the body, for lengths given as a share of it.
        limits: The largest image of an eye.

    Raises:
        SceneError: A field is missing or has a value that cannot be.
        UnknownNameError: There is no such field.
    """
    profile, problems = examine_profile(text, where=where, stature_m=stature_m, limits=limits)
    if problems:
        raise problems[0]
    assert profile is not None
    return profile


def examine_profile(
    text: bytes | str, *, where: str | Path, stature_m: float | None = None, limits: Limits = DEFAULT.limits
) -> tuple[AgentProfile | None, tuple[InputError, ...]]:
    """As ``parse_profile``, with every problem instead of the first one.

    Beside problems, what could not be read is left open in the profile: names are ``UNREADABLE``. None if nothing can
    be read at all.
    """
    attempt = Attempts()
    try:
        table = TomlTable.parse(text, where, most_bytes=limits.toml_bytes)
    except InputError as error:
        return None, (error,)
    attempt(lambda: table.only(TABLES | RESTS), table)
    eye = attempt(lambda: read_eye(table.table("eye"), attempt, limits), NO_EYE)
    fields = {name: attempt(partial(read, table), otherwise) for name, (read, otherwise) in READERS.items()}
    axes: dict[str, Any] = {key: _axis(table, part, key, attempt) for part, keys in AXES.items() for key in keys}
    no_arms: tuple[TomlTable, ...] = ()
    entries = attempt(lambda: table.tables("arms"), no_arms)
    arms = tuple(read_arm(entry, stature_m, attempt) for entry in entries)
    attempt(lambda: check_sides(table, arms), None)
    return AgentProfile(eye=eye, arms=arms, **axes, **fields), tuple(attempt.problems)


def _axis(table: TomlTable, part: str, key: str, attempt: Attempts) -> Axis | None:
    """A joint of head or torso; fields that neither has are told of once."""

    def read() -> Axis | None:
        joints = table.table(part)
        if key == AXES[part][0]:
            attempt(lambda: joints.only(AXES[part]), joints)
        return read_axis(joints, key, attempt)

    return attempt(read, None)


AXES = {"head": ("pan", "tilt"), "torso": ("turn", "lean")}
NO_EYE = Eye(Frame(UNREADABLE), UNREADABLE, (), (1.0, 1.0), (1, 1), 1.0)

READERS: dict[str, tuple[Callable[[TomlTable], Any], Any]] = {
    "name": (lambda table: table.name("name"), UNREADABLE),
    "model": (lambda table: table.text("model"), UNREADABLE),
    "shapes": (read_shapes, "visual"),
    "legs": (lambda table: read_legs(table.table("posture")), Legs()),
    "moves": (lambda table: table.table("base").only({"moves"}).flag("moves", False), False),
    "hand": (lambda table: parse_hand(table.table("hand")) if "hand" in table else None, None),
    "parts": (read_parts, ()),
    "rest_rad": (read_rest_rad, ()),
    "rest_m": (read_rest_m, ()),
}
"""How the fields of a profile are read from its document, and what stands in for one that cannot be; more apart."""
