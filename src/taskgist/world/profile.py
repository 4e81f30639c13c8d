"""Agent profiles: what a body can see, reach, grasp and do, by names of its model.

A profile is a TOML document beside a model. It makes one reasoning serve every body: nothing outside of this file asks
whether an agent is a human or a robot. ``profiles/human.toml`` is the built-in example, with a comment for each field.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any, Literal, get_args

from taskgist.errors import SceneError

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
    """What a body can do. ``text`` is the TOML it came from; ``model`` names its model."""

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
    text: str

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


def parse_profile(text: str, *, where: str | Path, stature_m: float | None = None) -> AgentProfile:
    """Read a profile.

    Args:
        text: The TOML document.
        where: File name for error messages.
        stature_m: Stature of the body, for lengths given as a share of it.

    Raises:
        SceneError: A field is missing or has a value that cannot be.
    """
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"not valid TOML: {error}", where=where) from error
    read = _Reader(table, where)
    legs = read.table("posture", {})
    return AgentProfile(
        name=read.text("name"),
        model=read.text("model"),
        eye=_eye(_Reader(read.table("eye"), where, "eye.")),
        pan=_axis(read.table("head", {}), "pan", where),
        tilt=_axis(read.table("head", {}), "tilt", where),
        turn=_axis(read.table("torso", {}), "turn", where),
        lean=_axis(read.table("torso", {}), "lean", where),
        legs=_legs(legs, where),
        moves=bool(read.table("base", {}).get("moves", False)),
        arms=tuple(_arm(_Reader(arm, where, "arms."), stature_m) for arm in table.get("arms", ())),
        hand=_hand(_Reader(read.table("hand"), where, "hand.")) if "hand" in table else None,
        parts=tuple((name, tuple(bodies)) for name, bodies in read.table("parts", {}).items()),
        text=text,
    )


class _Reader:
    """Typed access to a TOML table, with errors that name the field."""

    def __init__(self, table: Mapping[str, Any], where: str | Path, prefix: str = "") -> None:
        self._table, self._where, self._prefix = table, where, prefix

    def _get(self, key: str) -> Any:
        if key not in self._table:
            raise SceneError(
                "missing from the profile",
                where=self._where,
                field=self._prefix + key,
                hint="profiles/human.toml shows every field",
            )
        return self._table[key]

    def text(self, key: str) -> str:
        return str(self._get(key))

    def number(self, key: str, default: float | None = None) -> float:
        value = self._table.get(key, default) if default is not None else self._get(key)
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise self._wrong(key, value, "a number")
        return float(value)

    def pair(self, key: str) -> tuple[float, float]:
        value = self._get(key)
        if not isinstance(value, list) or len(value) != 2 or not all(isinstance(v, int | float) for v in value):
            raise self._wrong(key, value, "two numbers")
        return float(value[0]), float(value[1])

    def table(self, key: str, default: Mapping[str, Any] | None = None) -> Mapping[str, Any]:
        value = self._table.get(key, default) if default is not None else self._get(key)
        if not isinstance(value, Mapping):
            raise self._wrong(key, value, "a table")
        return value

    def _wrong(self, key: str, value: object, wanted: str) -> SceneError:
        return SceneError(f"must be {wanted}", where=self._where, field=self._prefix + key, value=value)


def _radians(pair: tuple[float, float]) -> tuple[float, float]:
    return math.radians(pair[0]), math.radians(pair[1])


def _eye(read: _Reader) -> Eye:
    width, height = (int(v) for v in read.pair("image_px"))
    fov = _radians(read.pair("fov_deg"))
    if width < 1 or height < 1 or not all(0 < angle < math.pi for angle in fov):
        raise SceneError(
            "an image needs at least one pixel, and a field of view between 0 and 180 degrees",
            field="eye.image_px, eye.fov_deg",
            value=((width, height), tuple(math.degrees(a) for a in fov)),
        )
    return Eye(
        site=read.text("site"),
        exclude=read.text("exclude"),
        fov_rad=fov,
        image_px=(width, height),
        gaze_cone_rad=math.radians(read.number("gaze_cone_deg")),
    )


def _axis(table: Mapping[str, Any], key: str, where: str | Path) -> Axis | None:
    if key not in table:
        return None
    read = _Reader(table[key], where, f"{key}.")
    return Axis(read.text("joint"), _radians(read.pair("range_deg")))


def _legs(table: Mapping[str, Any], where: str | Path) -> Legs:
    if not table:
        return Legs()
    for posture in table.get("can", ()):
        if posture not in POSTURES:
            raise SceneError(
                "no such posture",
                where=where,
                field="posture.can",
                value=posture,
                hint=f"known: {', '.join(POSTURES)}",
            )
    names = {key: tuple(table.get(key, ())) for key in ("can", "hips", "knees", "ankles", "thighs", "feet")}
    return Legs(**names, seat_share=float(table.get("seat_share", 0.0)))


def _arm(read: _Reader, stature_m: float | None) -> Arm:
    share = read.number("length_share", 0.0)
    length = share * stature_m if share and stature_m else read.number("length_m")
    return Arm(
        **{key: read.text(key) for key in ("side", "shoulder", "hand", "palm", "root")},
        length_m=length,
        azimuth_rad=_radians(read.pair("azimuth_deg")),
        elevation_rad=_radians(read.pair("elevation_deg")),
    )


def _hand(read: _Reader) -> Hand:
    return Hand(
        opening_m=read.number("opening_m"),
        finger_length_m=read.number("finger_length_m"),
        finger_thickness_m=read.number("finger_thickness_m"),
        palm_m=read.pair("palm_m"),
    )
