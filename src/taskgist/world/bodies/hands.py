"""Hands: what closes around an object, as boxes in the hand's own frame.

Three kinds are known, told apart by what faces what:

- ``human``: four fingers as one broad pad against a thumb,
- ``parallel``: two equal fingers, as of a gripper,
- ``three_finger``: two fingers side by side against a thumb.

The hand's frame lies half-way between the pads: x along the approach, y from the thumb to the fingers, z across. The
boxes cover the hand where it grasps *and* all that it sweeps on its last way there, about a finger's length along the
approach, so that one test of them tells whether the grasp is free and can be come to. Fingers close with their tips,
so that what lies flat on a table can be taken.

Two hands together grasp as one that closes between its two palms: each lies along its side of the thing, with the
finger tips at the point that it presses on.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import Field, dataclass, fields
from typing import Any, Literal, get_args

import mujoco
import numpy as np

from taskgist.common.toml import TomlTable
from taskgist.errors import SceneError, UnknownNameError

HandKind = Literal["human", "parallel", "three_finger"]
HAND_KINDS: tuple[HandKind, ...] = get_args(HandKind)
GHOST_GROUP = 5
"""Geom group of the shapes with which virtual grasps are tested: never seen, never touched."""
FINGER_WIDTH_M: dict[HandKind, float] = {"parallel": 0.022, "three_finger": 0.020}
"""Breadth of one finger where a profile does not say (ours: read off the PR2's and Robotiq's finger tips)."""
SPREAD_M = 0.06
"""Distance of the two fingers of a three-finger hand, from middle to middle, where a profile does not say (ours)."""
TIP_M: dict[HandKind, float] = {"human": 0.001, "parallel": 0.002, "three_finger": 0.006}
"""How far the tips reach past the point that they close on, where a profile does not say.

People's soft pads end some 3 mm before the tip, but what is rigid they take with the nail: it needs 1 mm beneath the
point, as a coin of 2 mm has, or the upper edge of a card of 1 mm (ours). The flat pads of grippers end where the tips
do, but for a rounded edge; three-finger hands have rounder tips (ours).
"""
THUMB_WIDTH_M = 0.022
"""Breadth of a human thumb at its last joint, where a profile does not say [Garrett 1971: about 23 mm men, 19 mm
women]."""
BETWEEN_M = 0.60
"""Widest thing that people carry between both hands, where a profile does not say (ours: the largest removal cartons;
NIOSH advises 0.40 m [Waters 1993])."""
PALM_LENGTH_M = 0.10
"""From a human wrist to where the fingers begin [Garrett 1971: hands are 0.18 to 0.20 m long, less the fingers]."""


@dataclass(frozen=True)
class Hand:
    """A hand that closes around things between a thumb and fingers; lengths in metres.

    Attributes:
        opening_m: Widest object between thumb and fingers.
        finger_length_m: From the palm to the tips.
        finger_thickness_m: Along the closing direction.
        palm_m: Breadth across the fingers, and thickness along them.
        kind: What faces what.
        finger_width_m: Breadth of one finger, or of a human's four fingers together; None for the kind's own.
        spread_m: From middle to middle of the two fingers of a three-finger hand.
        tip_m: How far the tips reach past the point that they close on; None for the kind's own.
        thumb_width_m: Breadth of the thumb; None for the kind's own: a human's, else that of a finger.
        between_m: Widest object between both hands of an agent, 0 if it grasps with one hand only; None for the
            kind's own.
    """

    opening_m: float
    finger_length_m: float
    finger_thickness_m: float
    palm_m: tuple[float, float]
    kind: HandKind = "human"
    finger_width_m: float | None = None
    spread_m: float = SPREAD_M
    tip_m: float | None = None
    thumb_width_m: float | None = None
    between_m: float | None = None

    @property
    def width_m(self) -> float:
        """Breadth of a finger's pad, metres; a human's fingers are as broad as the palm."""
        return self.finger_width_m or FINGER_WIDTH_M.get(self.kind, self.palm_m[0])

    @property
    def thumb_m(self) -> float:
        """Breadth of the thumb, metres."""
        own = min(THUMB_WIDTH_M, self.width_m) if self.kind == "human" else self.width_m
        return self.thumb_width_m or own

    @property
    def tips_m(self) -> float:
        """How far the tips reach past the point that they close on, metres."""
        return min(TIP_M[self.kind], self.finger_thickness_m) if self.tip_m is None else self.tip_m

    @property
    def one_sided(self) -> bool:
        """Whether it matters on which side of the object the thumb lies."""
        return self.kind == "three_finger" or self.thumb_m != self.width_m

    @property
    def palms(self) -> Palms | None:
        """Two such hands together; None if they do not grasp together.

        A human's hand lies flat, a gripper on its flat side.
        """
        between_m = (BETWEEN_M if self.kind == "human" else 0.0) if self.between_m is None else self.between_m
        if not between_m:
            return None
        flat = self.palm_m[::-1] if self.kind == "human" else (min(self.palm_m), self.opening_m)
        behind_m = PALM_LENGTH_M if self.kind == "human" else self.palm_m[1]
        return Palms(
            between_m, self.opening_m, self.finger_length_m + behind_m, *flat, self.finger_length_m, self.tips_m
        )


@dataclass(frozen=True)
class Palms:
    """Two hands that press on a thing from both sides; lengths in metres.

    Attributes:
        opening_m: Widest object between them.
        least_m: Width of what one hand takes alone.
        length_m: Of a hand, from the wrist to the tips.
        finger_thickness_m: Of a hand, along the closing direction.
        width_m: Of a hand, across.
        way_m: Length of the last way, along the approach.
        tips_m: How far the tips reach past the point that they press on.
    """

    opening_m: float
    least_m: float
    length_m: float
    finger_thickness_m: float
    width_m: float
    way_m: float
    tips_m: float

    one_sided = True
    """It matters which hand is on which side."""


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


def hand_boxes(hand: Hand | Palms) -> tuple[HandBox, ...]:
    """The boxes of a hand before it closes, with all that they sweep on their last way; the palm first.

    Of two hands, the left one, which is where a thumb would be, and the right one.
    """
    if isinstance(hand, Palms):
        length = hand.length_m + hand.way_m
        half = (length / 2, hand.finger_thickness_m / 2, hand.width_m / 2)
        return tuple(HandBox(name, half, length / 2 - hand.tips_m, side) for name, side in (("left", -1), ("right", 1)))
    breadth, thickness = hand.palm_m
    thick, way = hand.finger_thickness_m, hand.finger_length_m - hand.finger_thickness_m + hand.tips_m
    length = hand.finger_length_m + way
    behind = length / 2 - hand.tips_m
    palm_behind = hand.finger_length_m - hand.tips_m + (thickness + way) / 2
    palm = HandBox("palm", ((thickness + way) / 2, hand.opening_m / 2, breadth / 2), palm_behind, 0)
    half = (length / 2, thick / 2, hand.width_m / 2)
    if hand.kind == "three_finger":
        fingers = tuple(
            HandBox(f"{name}_finger", half, behind, 1, across * hand.spread_m / 2)
            for name, across in (("first", -1), ("second", 1))
        )
    else:
        fingers = (HandBox("fingers", half, behind, 1),)
    return (palm, *fingers, HandBox("thumb", (length / 2, thick / 2, hand.thumb_m / 2), behind, -1))


FLAT = "flat"
"""Name of the ghost of a whole hand that lies flat on a thing."""


def add_ghosts(body: mujoco.MjsBody, side: str, hand: Hand) -> None:
    """Give a hand's body the shapes of a virtual grasp, in the order of ``hand_boxes``, and that of it lying flat."""
    sizes = {box.name: box.half_m for box in hand_boxes(hand)}
    if hand.palms is not None:
        sizes[FLAT] = hand_boxes(hand.palms)[0].half_m
    for name, half_m in sizes.items():
        body.add_geom(
            name=f"{side}_grasp_{name}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=half_m,
            group=GHOST_GROUP,
            contype=0,
            conaffinity=0,
            mass=0,
            rgba=(1, 0, 1, 0),
        )


NEEDED = ("kind", "opening_m", "finger_length_m", "finger_thickness_m", "palm_m")
"""Fields of a hand that the model is asked for where the profile leaves them out."""


@dataclass(frozen=True)
class OpenHand:
    """A profile's hand as far as the profile gives it; the rest is measured on the model (``from_model.py``).

    Attributes:
        given: Fields of ``Hand`` by name.
    """

    given: tuple[tuple[str, Any], ...]

    @property
    def missing(self) -> tuple[str, ...]:
        """The needed fields that are left out."""
        return tuple(field for field in NEEDED if field not in dict(self.given))

    def completed(self, measured: Mapping[str, Any], where: str) -> Hand:
        """The whole hand, where what the profile gives wins.

        Args:
            measured: Fields of ``Hand``, with all that are missing.
            where: The profile's file, for messages.

        Raises:
            SceneError: Given and measured sizes are none of one hand.
        """
        hand = Hand(**{**measured, **dict(self.given)})
        for field, value, problem, hint in _faults(hand):
            raise SceneError(problem, where=where, field=f"hand.{field}", value=value, hint=hint)
        return hand


def read_hand(table: TomlTable) -> Hand | OpenHand:
    """Read a profile's ``[hand]`` table; open where it leaves the kind or a size to the model.

    Raises:
        SceneError: A length is none.
        UnknownNameError: There is no such kind of hand, or no such field.
    """
    table.only({field.name for field in fields(Hand)})
    given: dict[str, Any] = {field.name: table.number(field.name) for field in _lengths() if field.name in table}
    if "palm_m" in table:
        given["palm_m"] = table.pair("palm_m")
    if "kind" in table:
        given["kind"] = _kind(table)
    for field, value in given.items():
        least = min(value) if field == "palm_m" else value
        if field not in ("kind", "between_m") and not least > 0:
            raise table.error("a hand has no such size", field, least, "give metres above zero")
    if not set(NEEDED) <= given.keys():
        return OpenHand(tuple(given.items()))
    hand = Hand(**given)
    for field, value, problem, hint in _faults(hand):
        raise table.error(problem, field, value, hint)
    return hand


def _lengths() -> Iterator[Field[Any]]:
    """Fields that are one length."""
    return (field for field in fields(Hand) if field.name not in ("kind", "palm_m"))


def _faults(hand: Hand) -> Iterator[tuple[str, float, str, str]]:
    """Sizes that do not go together: field, value, what is wrong, the way out."""
    if hand.finger_thickness_m >= hand.finger_length_m:
        yield (
            "finger_thickness_m",
            hand.finger_thickness_m,
            "a hand has no such fingers",
            "fingers are longer than thick",
        )
    if hand.tip_m is not None and hand.tip_m > hand.finger_thickness_m:
        hint = "tips reach no farther past what they close on than a finger is thick"
        yield "tip_m", hand.tip_m, "a hand has no such fingers", hint
    if hand.between_m is not None and hand.between_m != 0.0 and not hand.between_m > hand.opening_m:
        hint = "more than one hand opens, or 0 for one hand only"
        yield "between_m", hand.between_m, "two hands hold no less than one", hint


def _kind(table: TomlTable) -> HandKind:
    given = table.text("kind")
    for kind in HAND_KINDS:
        if given == kind:
            return kind
    raise UnknownNameError("kind of hand", given, HAND_KINDS, where=f"{table.place}")


def ghosts_of(model: mujoco.MjModel, hand_body: int) -> tuple[list[int], int]:
    """Indices of the shapes of a virtual grasp, in the order of ``hand_boxes``; and of the flat hand, −1 if none."""
    ghosts = np.flatnonzero((model.geom_bodyid == hand_body) & (model.geom_group == GHOST_GROUP)).tolist()
    flat = [ghost for ghost in ghosts if model.geom(ghost).name.endswith(f"_grasp_{FLAT}")]
    return [ghost for ghost in ghosts if ghost not in flat], flat[0] if flat else -1
