"""The human body as an MJCF model, made to measure.

The body stands at its zero configuration: x forward, y left, z up, arms hanging with the palms towards the thighs.
Its root is the pelvis (a free joint at the mid-hip). Hinges, all in radians: torso turn, lean, side; head pan, tilt,
roll; per arm the girdle (protraction, elevation), shoulder (flexion, abduction, rotation), elbow, forearm rotation
and wrist (flexion, deviation); per leg hip (flexion, abduction), knee and ankle. Positive is turning left, leaning
forward, looking up, flexing, raising outward.

Sites carry the names of landmarks that trackers deliver (``left_elbow``, ``nose``), so that fitting is a matter of
names. Joint ranges follow the norms of the American Academy of Orthopaedic Surgeons [AAOS 1965], rounded; widths of
the shapes are ours, read off [Winter 2009] and clothed bodies.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import SceneError

# --- Sizes of a human body: stature scales every segment, and a measured segment may replace its share.
#
# Shares of stature are those of Drillis & Contini (1966) as printed in [Winter 2009, Fig. 4.1]; joint-centre offsets
# that the figure does not give (hips, waist, heel) are ours and marked so.

SHARES: Mapping[str, float] = {
    "foot_height": 0.039,
    "shank": 0.246,
    "thigh": 0.245,
    "trunk": 0.288,  # mid-hip to the line of the shoulders: 0.818 - 0.530
    "shoulder_breadth": 0.259,
    "neck": 0.052,  # line of the shoulders to chin: 0.870 - 0.818
    "head": 0.130,  # chin to crown
    "upper_arm": 0.186,
    "forearm": 0.146,
    "hand": 0.108,
    "foot": 0.152,
    "hip_breadth": 0.100,  # between the joint centres (ours)
}
SIDES = (("left", 1), ("right", -1))
SHOULDER_JOINTS = 3
"""Flexion, abduction and rotation, the first of the arm's chain."""
STATURE_RANGE_M = (0.6, 2.5)
SEGMENT_TOLERANCE = 2.5


@dataclass(frozen=True)
class HumanSize:
    """Lengths of a human body in metres, each between joint centres."""

    stature_m: float
    foot_height_m: float
    shank_m: float
    thigh_m: float
    trunk_m: float
    shoulder_breadth_m: float
    neck_m: float
    head_m: float
    upper_arm_m: float
    forearm_m: float
    hand_m: float
    foot_m: float
    hip_breadth_m: float

    @property
    def hip_height_m(self) -> float:
        """Height of the hips of a standing body over the floor."""
        return self.foot_height_m + self.shank_m + self.thigh_m

    @classmethod
    def from_stature(cls, stature_m: float = 1.75, **measured_m: float) -> HumanSize:
        """A body of the given stature; measured segments replace their share.

        Args:
            stature_m: Standing height in metres.
            measured_m: Segment lengths in metres, by field name (``upper_arm_m=0.29``).

        Raises:
            SceneError: An unknown segment, or a length that no human body has.
        """
        _check("stature_m", stature_m, STATURE_RANGE_M)
        lengths = {f"{name}_m": share * stature_m for name, share in SHARES.items()}
        known = {f.name for f in fields(cls)}
        for name, value in measured_m.items():
            if name not in known:
                raise SceneError("no such body size", field=name, hint=f"known sizes: {', '.join(sorted(known))}")
            usual = lengths[name]
            _check(name, value, (usual / SEGMENT_TOLERANCE, usual * SEGMENT_TOLERANCE))
            lengths[name] = value
        return cls(stature_m=stature_m, **lengths)


def _check(name: str, value: float, allowed: tuple[float, float]) -> None:
    if not allowed[0] <= value <= allowed[1]:
        raise SceneError(
            f"no human body is between {allowed[0]:.2f} and {allowed[1]:.2f} m there",
            field=name,
            value=value,
            hint="lengths are in metres: check the unit",
        )


# --- The shoulder: a ball-and-socket joint, for which three hinges stand.
#
# Each alone keeps within its norm, but together they would bring the elbow high up behind the back, and twist a hanging
# arm by half a turn (Codman's paradox).

EXTENSION_RAD, HORIZONTAL_EXTENSION_RAD = math.radians(50), math.radians(45)
"""How far an upper arm goes back: hanging, with the shoulder girdle at rest [Kapandji 1982: 45 to 50°], and level and
out to the side [AAOS 1965]."""
ROTATION_RAD = math.radians(90)
"""How far it turns about itself, from the shortest way to where it points [AAOS 1965]."""


def shoulder_limits(side: str) -> Array:
    """What the shoulder does not do, as a row of an arm's chain, (1, 9); see ``arm_chain.ArmChain.limits``.

    The directions that an upper arm does not take lie in the cone through three that it just takes: hanging and drawn
    back, level and drawn back, and straight up.
    """
    hanging = (-math.sin(EXTENSION_RAD), 0.0, -math.cos(EXTENSION_RAD))
    level = (-math.sin(HORIZONTAL_EXTENSION_RAD), math.cos(HORIZONTAL_EXTENSION_RAD), 0.0)
    up = np.array((0.0, 0.0, 1.0))
    behind = np.cross(up - level, up - hanging)
    behind /= np.linalg.norm(behind)
    mirror = np.array((1.0, dict(SIDES)[side], 1.0))
    return np.array([[SHOULDER_JOINTS, 0.0, 0.0, -1.0, *(behind * mirror), behind @ up, ROTATION_RAD]])


SKIN, CLOTH, TROUSERS, SHOE = "0.87 0.68 0.55 1", "0.35 0.45 0.62 1", "0.25 0.27 0.32 1", "0.15 0.13 0.12 1"
WAIST_SHARE = 0.22  # of the trunk: the lumbar joint above the mid-hip (ours)
PALM_SHARE = 0.53  # of the hand: wrist to knuckles
GROUP = 1
Vector = tuple[float, float, float]


@lru_cache(maxsize=64)
def human_mjcf(size: HumanSize) -> str:
    """MJCF text of a human body; that of sizes asked for lately is kept.

    Args:
        size: Segment lengths in metres.

    Returns:
        A complete MJCF document whose only top-level body is ``pelvis``.
    """
    s = size
    waist = WAIST_SHARE * s.trunk_m
    model = ET.Element("mujoco", model="human")
    ET.SubElement(model, "compiler", angle="degree", autolimits="true")
    defaults = ET.SubElement(model, "default")
    ET.SubElement(defaults, "geom", group=str(GROUP), density="1000")
    ET.SubElement(defaults, "site", group="4", size="0.01")
    pelvis = ET.SubElement(ET.SubElement(model, "worldbody"), "body", name="pelvis")
    ET.SubElement(pelvis, "freejoint", name="root")
    _geom(pelvis, "pelvis", "ellipsoid", (0.065 * s.stature_m, 0.098 * s.stature_m, 0.065 * s.stature_m), TROUSERS)
    _site(pelvis, "pelvis")
    for side, sign in SIDES:
        _leg(pelvis, s, side, sign)
    torso = _body(pelvis, "torso", (0, 0, waist))
    _hinge(torso, "torso_turn", (0, 0, 1), (-90, 90))
    _hinge(torso, "torso_lean", (0, 1, 0), (-30, 90))
    _hinge(torso, "torso_side", (1, 0, 0), (-35, 35))
    _trunk(torso, s, waist)
    _head(torso, s, s.trunk_m - waist + s.neck_m)
    for side, sign in SIDES:
        _arm(torso, s, side, sign)
    return ET.tostring(model, encoding="unicode")


def _trunk(torso: ET.Element, s: HumanSize, waist_m: float) -> None:
    top = s.trunk_m - waist_m
    half = 0.5 * (top + 0.03 * s.stature_m)
    depth, width = 0.062 * s.stature_m, 0.092 * s.stature_m
    _geom(torso, "trunk", "ellipsoid", (depth, width, half + 0.02 * s.stature_m), CLOTH, (0, 0, half - 0.02))
    _geom(torso, "neck", "capsule", (0.031 * s.stature_m, 0.5 * s.neck_m), SKIN, (0, 0, top + 0.4 * s.neck_m))
    _site(torso, "abdomen", (0, 0, 0))
    _site(torso, "chest", (0, 0, 0.45 * top))
    _site(torso, "neck", (0, 0, top + 0.15 * s.neck_m))


def _head(torso: ET.Element, s: HumanSize, height_m: float) -> None:
    deep, wide, tall = 0.42 * s.head_m, 0.33 * s.head_m, 0.5 * s.head_m
    eye = (deep, 0.0, 0.508 * s.head_m)  # eyes 0.936 of stature: 0.066 above the chin
    head = _body(torso, "head", (0, 0, height_m))
    _hinge(head, "head_pan", (0, 0, 1), (-80, 80))
    _hinge(head, "head_tilt", (0, -1, 0), (-60, 60))
    _hinge(head, "head_roll", (1, 0, 0), (-45, 45))
    _geom(head, "head", "ellipsoid", (deep, wide, tall), SKIN, (0, 0, tall))
    _site(head, "head_base")
    _site(head, "head", (0, 0, tall))
    _site(head, "head_top", (0, 0, s.head_m))
    _site(head, "eye", eye)
    _site(head, "nose", (1.15 * deep, 0, 0.40 * s.head_m))
    for side, sign in SIDES:
        _site(head, f"{side}_eye", (0.9 * deep, sign * 0.14 * s.head_m, eye[2]))
        _geom(
            head,
            f"{side}_eye",
            "sphere",
            (0.06 * s.head_m,),
            "0.1 0.1 0.1 1",
            (0.86 * deep, sign * 0.14 * s.head_m, eye[2]),
        )
        _site(head, f"{side}_ear", (0, sign * wide, 0.45 * s.head_m))


def _arm(torso: ET.Element, s: HumanSize, side: str, sign: int) -> None:
    shoulder_z = (1 - WAIST_SHARE) * s.trunk_m
    sternum_y = 0.02 * s.stature_m
    y = 0.5 * s.shoulder_breadth_m - sternum_y
    clavicle = _body(torso, f"{side}_clavicle", (0, sign * sternum_y, shoulder_z))
    _hinge(clavicle, f"{side}_girdle_protraction", (0, 0, -sign), (-20, 35))
    _hinge(clavicle, f"{side}_girdle_elevation", (sign, 0, 0), (-10, 35))
    _link(clavicle, f"{side}_clavicle", (0, sign * y, 0), 0.022 * s.stature_m, CLOTH)
    upper_arm = _body(clavicle, f"{side}_upper_arm", (0, sign * y, 0))
    _hinge(upper_arm, f"{side}_shoulder_flexion", (0, -1, 0), (-60, 180))
    _hinge(upper_arm, f"{side}_shoulder_abduction", (sign, 0, 0), (-50, 180))
    _hinge(upper_arm, f"{side}_shoulder_rotation", (0, 0, sign), (-90, 90))
    _link(upper_arm, f"{side}_upper_arm", (0, 0, -s.upper_arm_m), 0.027 * s.stature_m, CLOTH)
    _site(upper_arm, f"{side}_shoulder")
    forearm = _body(upper_arm, f"{side}_forearm", (0, 0, -s.upper_arm_m))
    _hinge(forearm, f"{side}_elbow", (0, -1, 0), (0, 150))
    _hinge(forearm, f"{side}_forearm_rotation", (0, 0, sign), (-90, 90))
    _link(forearm, f"{side}_forearm", (0, 0, -s.forearm_m), 0.021 * s.stature_m, SKIN)
    _site(forearm, f"{side}_elbow")
    _hand(forearm, s, side, sign)


def _hand(forearm: ET.Element, s: HumanSize, side: str, sign: int) -> None:
    palm, fingers = PALM_SHARE * s.hand_m, (1 - PALM_SHARE) * s.hand_m
    hand = _body(forearm, f"{side}_hand", (0, 0, -s.forearm_m))
    _hinge(hand, f"{side}_wrist_flexion", (-sign, 0, 0), (-70, 80))
    _hinge(hand, f"{side}_wrist_deviation", (0, -1, 0), (-30, 30))
    _geom(hand, f"{side}_palm", "box", (0.042, 0.014, palm / 2), SKIN, (0, 0, -palm / 2))
    _geom(hand, f"{side}_fingers", "box", (0.038, 0.010, fingers / 2), SKIN, (0, 0, -palm - fingers / 2))
    _geom(hand, f"{side}_thumb", "capsule", (0.010, 0.025), SKIN, (0.045, -sign * 0.02, -0.55 * palm))
    _site(hand, f"{side}_wrist")
    _site(hand, f"{side}_hand", (0, 0, -palm))
    _site(hand, f"{side}_palm", (0, -sign * 0.03, -0.9 * palm))
    _site(hand, f"{side}_thumb", (0.045, -sign * 0.02, -0.9 * palm))
    _site(hand, f"{side}_fingertip", (0, 0, -s.hand_m))


def _leg(pelvis: ET.Element, s: HumanSize, side: str, sign: int) -> None:
    sole = s.foot_height_m
    thigh = _body(pelvis, f"{side}_thigh", (0, sign * s.hip_breadth_m / 2, 0))
    _hinge(thigh, f"{side}_hip_flexion", (0, -1, 0), (-30, 125))
    _hinge(thigh, f"{side}_hip_abduction", (sign, 0, 0), (-30, 45))
    _link(thigh, f"{side}_thigh", (0, 0, -s.thigh_m), 0.040 * s.stature_m, TROUSERS)
    _site(thigh, f"{side}_hip")
    shank = _body(thigh, f"{side}_shank", (0, 0, -s.thigh_m))
    _hinge(shank, f"{side}_knee", (0, 1, 0), (0, 140))
    _link(shank, f"{side}_shank", (0, 0, -s.shank_m), 0.028 * s.stature_m, TROUSERS)
    _site(shank, f"{side}_knee")
    foot = _body(shank, f"{side}_foot", (0, 0, -s.shank_m))
    _hinge(foot, f"{side}_ankle", (0, -1, 0), (-50, 40))
    _geom(foot, f"{side}_foot", "box", (s.foot_m / 2, 0.045, sole / 2), SHOE, (0.27 * s.foot_m, 0, -sole / 2))
    _site(foot, f"{side}_ankle")
    _site(foot, f"{side}_toe", (0.75 * s.foot_m, 0, -sole / 2))
    _site(foot, f"{side}_heel", (-0.23 * s.foot_m, 0, -sole / 2))


def _body(carrier: ET.Element, name: str, pos: Vector) -> ET.Element:
    return ET.SubElement(carrier, "body", name=name, pos=_numbers(pos))


def _hinge(body: ET.Element, name: str, axis: tuple[int, int, int], range_deg: tuple[int, int]) -> None:
    ET.SubElement(
        body, "joint", name=name, type="hinge", axis=" ".join(map(str, axis)), range=" ".join(map(str, range_deg))
    )


def _geom(
    body: ET.Element, name: str, kind: str, size: tuple[float, ...], rgba: str, pos: Vector = (0.0, 0.0, 0.0)
) -> None:
    ET.SubElement(body, "geom", name=name, type=kind, size=_numbers(size), pos=_numbers(pos), rgba=rgba)


def _link(body: ET.Element, name: str, end: Vector, radius: float, rgba: str) -> None:
    """A capsule along a segment, its round ends inside the joints."""
    ends = _numbers((*(0.12 * x for x in end), *(0.88 * x for x in end)))
    ET.SubElement(body, "geom", name=name, type="capsule", size=_numbers((radius,)), fromto=ends, rgba=rgba)


def _site(body: ET.Element, name: str, pos: Vector = (0.0, 0.0, 0.0)) -> None:
    ET.SubElement(body, "site", name=name, pos=_numbers(pos))


def _numbers(values: Iterable[float]) -> str:
    return " ".join(f"{value:.5f}" for value in values)
