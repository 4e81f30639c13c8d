"""Hands: what closes around an object, as boxes in the hand's own frame.

Three kinds are known, told apart by what faces what:

- ``human``: four fingers as one broad pad against a thumb,
- ``parallel``: two equal fingers, as of a gripper,
- ``three_finger``: two fingers side by side against a thumb.

The hand's frame lies half-way between the pads: x along the approach, y from the thumb to the fingers, z across. The
boxes cover the hand where it grasps *and* all that it sweeps on its last way there, a finger's length along the
approach, so that one test of them tells whether the grasp is free and can be come to.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import mujoco

from taskgist.common.toml import TomlTable
from taskgist.errors import UnknownNameError

HandKind = Literal["human", "parallel", "three_finger"]
HAND_KINDS: tuple[HandKind, ...] = get_args(HandKind)
GHOST_GROUP = 5
"""Geom group of the shapes with which virtual grasps are tested: never seen, never touched."""
FINGER_WIDTH_M: dict[HandKind, float] = {"parallel": 0.022, "three_finger": 0.020}
"""Breadth of one finger where a profile does not say (ours: read off the PR2's and Robotiq's finger tips)."""
SPREAD_M = 0.06
"""Distance of the two fingers of a three-finger hand, from middle to middle, where a profile does not say (ours)."""


@dataclass(frozen=True)
class Hand:
    """A hand that closes around things between a thumb and fingers; lengths in metres.

    Attributes:
        opening_m: Widest object between thumb and fingers.
        finger_length_m: From the palm to the tips.
        finger_thickness_m: Along the closing direction; the pads lie that far behind the tips.
        palm_m: Breadth across the fingers, and thickness along them.
        kind: What faces what.
        finger_width_m: Breadth of one finger, or of a human's four fingers together; None for the kind's own.
        spread_m: From middle to middle of the two fingers of a three-finger hand.
    """

    opening_m: float
    finger_length_m: float
    finger_thickness_m: float
    palm_m: tuple[float, float]
    kind: HandKind = "human"
    finger_width_m: float | None = None
    spread_m: float = SPREAD_M

    @property
    def width_m(self) -> float:
        """Breadth of a finger's pad, metres; a human's fingers are as broad as the palm."""
        return self.finger_width_m or FINGER_WIDTH_M.get(self.kind, self.palm_m[0])

    @property
    def one_sided(self) -> bool:
        """Whether it matters on which side of the object the thumb lies."""
        return self.kind == "three_finger"


@dataclass(frozen=True)
class HandBox:
    """One part of a hand, in the hand's frame.

    Attributes:
        name: For people.
        half_m: Half sizes along approach, closing direction and across, swept way included.
        behind_m: How far its middle lies behind the pads, against the approach.
        side: +1 on the fingers' side of the object, -1 on the thumb's, 0 between them.
        across_m: Where its middle lies across the hand.
    """

    name: str
    half_m: tuple[float, float, float]
    behind_m: float
    side: int
    across_m: float = 0.0


def hand_boxes(hand: Hand) -> tuple[HandBox, ...]:
    """The boxes of a hand before it closes, with all that they sweep on the last finger's length; the palm first."""
    breadth, thickness = hand.palm_m
    thick, way = hand.finger_thickness_m, hand.finger_length_m
    length = hand.finger_length_m + way
    half = (length / 2, thick / 2, hand.width_m / 2)
    behind = length / 2 - thick
    palm = HandBox(
        "palm", ((thickness + way) / 2, hand.opening_m / 2, breadth / 2), way - thick + (thickness + way) / 2, 0
    )
    if hand.kind == "three_finger":
        fingers = tuple(
            HandBox(f"{name}_finger", half, behind, 1, across * hand.spread_m / 2)
            for name, across in (("first", -1), ("second", 1))
        )
    else:
        fingers = (HandBox("fingers", half, behind, 1),)
    return (palm, *fingers, HandBox("thumb", half, behind, -1))


def add_ghosts(body: mujoco.MjsBody, side: str, hand: Hand) -> None:
    """Give a hand's body the shapes of a virtual grasp, in the order of ``hand_boxes``."""
    for box in hand_boxes(hand):
        body.add_geom(
            name=f"{side}_grasp_{box.name}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=box.half_m,
            group=GHOST_GROUP,
            contype=0,
            conaffinity=0,
            mass=0,
            rgba=(1, 0, 1, 0),
        )


def parse_hand(table: TomlTable) -> Hand:
    """Read a profile's ``[hand]`` table.

    Raises:
        SceneError: A length is missing, or is none.
        UnknownNameError: There is no such kind of hand.
    """
    lengths = {key: table.number(key) for key in ("opening_m", "finger_length_m", "finger_thickness_m")}
    palm = table.pair("palm_m")
    width = table.number("finger_width_m") if "finger_width_m" in table else None
    spread = table.number("spread_m", SPREAD_M)
    sized = {**lengths, "palm_m": min(palm), "finger_width_m": width, "spread_m": spread}
    for field, value in sized.items():
        if value is not None and not value > 0:
            raise table.error("a hand has no such size", field, value, "give metres above zero")
    if lengths["finger_thickness_m"] >= lengths["finger_length_m"]:
        hint = "fingers are longer than thick"
        raise table.error("a hand has no such fingers", "finger_thickness_m", lengths["finger_thickness_m"], hint)
    return Hand(**lengths, palm_m=palm, kind=_kind(table), finger_width_m=width, spread_m=spread)


def _kind(table: TomlTable) -> HandKind:
    given = table.text("kind", "human")
    for kind in HAND_KINDS:
        if given == kind:
            return kind
    raise UnknownNameError("kind of hand", given, HAND_KINDS, where=f"{table.place}")


def ghosts_of(model: mujoco.MjModel, hand_body: int) -> list[int]:
    """Indices of the shapes of a virtual grasp, in the order of ``hand_boxes``."""
    return [g for g in range(model.ngeom) if model.geom_bodyid[g] == hand_body and model.geom_group[g] == GHOST_GROUP]
