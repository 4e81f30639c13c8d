"""Agent profiles: what a body can see, reach, grasp and do, by names of its model.

A profile is a TOML document beside a model. It makes one reasoning serve every body: nothing outside of this file asks
whether an agent is a human or a robot. ``profiles/human.toml`` is the built-in example, with a comment for each field.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Literal, get_args

from taskgist.errors import UnknownNameError
from taskgist.world.toml_table import TomlTable

Posture = Literal["standing", "sitting"]
POSTURES: tuple[Posture, ...] = get_args(Posture)


@dataclass(frozen=True)
class Eye:
    """A pinhole eye: a site that looks along its x axis, z up."""

    site: str
    exclude: str
    fov_rad: tuple[float, float]
    image_px: tuple[int, int]
    gaze_cone_rad: float


@dataclass(frozen=True)
class Axis:
    """A joint that a virtual action may move, within a range in radians."""

    joint: str
    range_rad: tuple[float, float]


@dataclass(frozen=True)
class Legs:
    """How a body stands and sits; all empty for a body that only stands."""

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
    up).
    """

    side: str
    shoulder: str
    hand: str
    palm: str
    root: str
    length_m: float
    azimuth_rad: tuple[float, float]
    elevation_rad: tuple[float, float]


@dataclass(frozen=True)
class Hand:
    """A hand that closes around things between a thumb and fingers; lengths in metres."""

    opening_m: float
    finger_length_m: float
    finger_thickness_m: float
    palm_m: tuple[float, float]


@dataclass(frozen=True)
class AgentProfile:
    """What a body can do; ``model`` names its model."""

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

    @property
    def part_names(self) -> tuple[str, ...]:
        """Names of the parts that a tracker may lose one by one."""
        return tuple(name for name, _ in self.parts)


def builtin_profiles() -> tuple[str, ...]:
    """Names of the profiles that come with taskgist."""
    folder = resources.files("taskgist.world") / "profiles"
    return tuple(sorted(Path(entry.name).stem for entry in folder.iterdir() if entry.name.endswith(".toml")))


def builtin_profile_text(name: str) -> str:
    """TOML text of a built-in profile."""
    return (resources.files("taskgist.world") / "profiles" / f"{name}.toml").read_text(encoding="utf-8")


def parse_profile(text: bytes | str, *, where: str | Path, stature_m: float | None = None) -> AgentProfile:
    """Read a profile.

    Args:
        text: The TOML document.
        where: File name for error messages.
        stature_m: Stature of the body, for lengths given as a share of it.

    Raises:
        SceneError: A field is missing or has a value that cannot be.
    """
    table = TomlTable.parse(text, where)
    parts = table.table("parts")
    head, torso = table.table("head"), table.table("torso")
    return AgentProfile(
        name=table.text("name"),
        model=table.text("model"),
        eye=_eye(table.table("eye")),
        pan=_axis(head, "pan"),
        tilt=_axis(head, "tilt"),
        turn=_axis(torso, "turn"),
        lean=_axis(torso, "lean"),
        legs=_legs(table.table("posture")),
        moves=table.table("base").flag("moves", default=False),
        arms=tuple(_arm(arm, stature_m) for arm in table.tables("arms")),
        hand=_hand(table.table("hand")) if "hand" in table else None,
        parts=tuple((name, parts.names(name)) for name in parts),
    )


def _radians(pair: tuple[float, float]) -> tuple[float, float]:
    return math.radians(pair[0]), math.radians(pair[1])


def _eye(table: TomlTable) -> Eye:
    pixels, fov = table.pair("image_px"), table.pair("fov_deg")
    if not all(value >= 1 and value == int(value) for value in pixels):
        raise table.error("an image needs at least one pixel each way", "image_px", pixels, "as [320, 240]")
    if not all(0 < angle < 180 for angle in fov):
        raise table.error("a pinhole sees between 0 and 180 degrees", "fov_deg", fov, "as [120, 105]")
    return Eye(
        site=table.text("site"),
        exclude=table.text("exclude"),
        fov_rad=_radians(fov),
        image_px=(int(pixels[0]), int(pixels[1])),
        gaze_cone_rad=math.radians(table.number("gaze_cone_deg")),
    )


def _axis(table: TomlTable, key: str) -> Axis | None:
    if key not in table:
        return None
    axis = table.table(key)
    return Axis(axis.text("joint"), _radians(axis.pair("range_deg")))


def _legs(table: TomlTable) -> Legs:
    if not list(table):
        return Legs()
    names = {key: table.names(key) for key in ("hips", "knees", "ankles", "thighs", "feet")}
    can = tuple(read_posture(name, where=f"{table.where}: {table.path}") for name in table.names("can"))
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


def _arm(table: TomlTable, stature_m: float | None) -> Arm:
    by_share = stature_m is not None and "length_share" in table
    return Arm(
        **{key: table.text(key) for key in ("side", "shoulder", "hand", "palm", "root")},
        length_m=table.number("length_share") * stature_m if by_share and stature_m else table.number("length_m"),
        azimuth_rad=_radians(table.pair("azimuth_deg")),
        elevation_rad=_radians(table.pair("elevation_deg")),
    )


def _hand(table: TomlTable) -> Hand:
    return Hand(
        opening_m=table.number("opening_m"),
        finger_length_m=table.number("finger_length_m"),
        finger_thickness_m=table.number("finger_thickness_m"),
        palm_m=table.pair("palm_m"),
    )
