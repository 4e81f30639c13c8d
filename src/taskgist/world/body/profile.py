"""Agent profiles: what a body can see, reach, grasp and do, by names of its model.

A profile is a TOML document beside a model. It makes one reasoning serve every body: nothing outside of this file asks
whether an agent is a human or a robot. ``profiles/human.toml`` and ``profiles/pr2.toml`` comment every field;
``profile_file.py`` reads them. What a profile leaves out, ranges of joints and lengths of arms, is derived from the
model (``derived.py``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Literal, get_args

from taskgist.world.body.frames import Frame
from taskgist.world.body.hands import Hand
from taskgist.world.body.urdf import Shapes

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
    """

    frame: Frame
    exclude: str
    housing: tuple[str, ...]
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
    up). ``carrier`` is the body whose frame that is, x forward and z up: by default what the arm's root hangs on.
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
        return tuple((field, axis) for field, axis in named.items() if axis)


def builtin_profiles() -> tuple[str, ...]:
    """Names of the profiles that come with taskgist."""
    folder = resources.files("taskgist.world") / "profiles"
    return tuple(sorted(Path(entry.name).stem for entry in folder.iterdir() if entry.name.endswith(".toml")))


def builtin_profile_text(name: str) -> str:
    """TOML text of a built-in profile."""
    return (resources.files("taskgist.world") / "profiles" / f"{name}.toml").read_text(encoding="utf-8")
