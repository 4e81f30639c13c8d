"""Sizes of a human body: stature scales every segment, and a measured segment may replace its share.

Shares of stature are those of Drillis & Contini (1966) as printed in [Winter 2009, Fig. 4.1]; joint-centre offsets
that the figure does not give (hips, waist, heel) are ours and marked so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

from taskgist.errors import SceneError

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
