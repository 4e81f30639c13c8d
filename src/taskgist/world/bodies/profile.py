"""Agent profiles: what a body can see, reach, grasp and do, by names of its model.

A profile is a TOML document beside a model. It makes one reasoning serve every body: nothing outside of this file asks
whether an agent is a human or a robot. ``profiles/human.toml`` and ``profiles/pr2.toml`` comment every field;
``eyes.py`` and ``hands.py`` hold what it says of these. What a profile leaves to its model, cameras and hands
(``from_model.py``), ranges of joints and lengths of arms (``agent.py``), is filled in when that is at hand.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from importlib import resources
from pathlib import Path
from typing import Any, Literal, get_args

from taskgist.common.toml import UNREADABLE, Attempts, TomlTable
from taskgist.errors import InputError, UnknownNameError
from taskgist.settings import DEFAULT, Limits
from taskgist.world.bodies.eyes import NO_EYE, UNREAD_EYE, Eye, Frame, read_eye, read_frame
from taskgist.world.bodies.hands import Hand, OpenHand, read_hand
from taskgist.world.bodies.urdf import SHAPES, Shapes

Posture = Literal["standing", "sitting"]
POSTURES: tuple[Posture, ...] = get_args(Posture)

AS_THE_JOINT = (-math.inf, math.inf)
"""Range of a joint that is as wide as the model's."""
DERIVED_M = 0.0
"""Length of an arm that is derived from the model."""


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
        open_hand: The hand where the model has yet to say what the profile leaves out; ``hand`` is None then.
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
    open_hand: OpenHand | None = None

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
    kept = _sound(text, stature_m, limits)
    if kept is not None:
        return kept
    _, problems = examine_profile(text, where=where, stature_m=stature_m, limits=limits)
    raise problems[0]


@lru_cache(maxsize=64)
def _sound(text: bytes | str, stature_m: float | None, limits: Limits) -> AgentProfile | None:
    """A profile without problems, kept: the same bodies come into many scenes. None of any other."""
    profile, problems = examine_profile(text, where="", stature_m=stature_m, limits=limits)
    return None if problems else profile


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
    eye = attempt(lambda: read_eye(table.table("eye"), attempt, limits), UNREAD_EYE) if "eye" in table else NO_EYE
    fields = {name: attempt(partial(read, table), otherwise) for name, (read, otherwise) in READERS.items()}
    axes: dict[str, Any] = {key: _axis(table, part, key, attempt) for part, keys in AXES.items() for key in keys}
    no_arms: tuple[TomlTable, ...] = ()
    entries = attempt(lambda: table.tables("arms"), no_arms)
    arms = tuple(read_arm(entry, stature_m, attempt) for entry in entries)
    attempt(lambda: check_sides(table, arms), None)
    hand = attempt(lambda: read_hand(table.table("hand")) if "hand" in table else None, None)
    whole, left = (None, hand) if isinstance(hand, OpenHand) else (hand, None)
    profile = AgentProfile(eye=eye, arms=arms, hand=whole, open_hand=left, **axes, **fields)
    return profile, tuple(attempt.problems)


def _axis(table: TomlTable, part: str, key: str, attempt: Attempts) -> Axis | None:
    """A joint of head or torso; fields that neither has are told of once."""

    def read() -> Axis | None:
        joints = table.table(part)
        if key == AXES[part][0]:
            attempt(lambda: joints.only(AXES[part]), joints)
        return read_axis(joints, key, attempt)

    return attempt(read, None)


AXES = {"head": ("pan", "tilt"), "torso": ("turn", "lean")}

READERS: dict[str, tuple[Callable[[TomlTable], Any], Any]] = {
    "name": (lambda table: table.name("name"), UNREADABLE),
    "model": (lambda table: table.text("model"), UNREADABLE),
    "shapes": (read_shapes, "visual"),
    "legs": (lambda table: read_legs(table.table("posture")), Legs()),
    "moves": (lambda table: table.table("base").only({"moves"}).flag("moves", False), False),
    "parts": (read_parts, ()),
    "rest_rad": (read_rest_rad, ()),
    "rest_m": (read_rest_m, ()),
}
"""How the fields of a profile are read from its document, and what stands in for one that cannot be; more apart."""
