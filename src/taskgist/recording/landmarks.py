"""The names that an import mapping gives to tracked points of a person, and the parts of the body they belong to."""

from __future__ import annotations

SIDES = ("left", "right")
HEAD_POINTS = frozenset({"head", "head_base", "head_top", "nose", "left_eye", "right_eye", "left_ear", "right_ear"})
TORSO_POINTS = frozenset(
    {"neck", "chest", "abdomen", "pelvis", "left_shoulder", "right_shoulder", "left_hip", "right_hip"}
)
LEG_POINTS = frozenset(f"{side}_{name}" for side in SIDES for name in ("knee", "ankle", "heel", "toe"))


def _hand_points(side: str) -> frozenset[str]:
    return frozenset(f"{side}_{name}" for name in ("wrist", "hand", "fingertip", "thumb"))


PARTS: dict[str, frozenset[str]] = {
    "head": HEAD_POINTS,
    "torso": TORSO_POINTS,
    "left_arm": _hand_points("left") | {"left_elbow"},
    "right_arm": _hand_points("right") | {"right_elbow"},
    "left_hand": _hand_points("left"),
    "right_hand": _hand_points("right"),
    "legs": LEG_POINTS,
}
"""Parts that a mapping may declare unknown, with the points that fall with them."""

LANDMARKS: frozenset[str] = frozenset().union(*PARTS.values())
"""Every name of a point; ``docs/import.md`` says where on the body each lies."""

DIRECTIONS: dict[str, dict[str, str]] = {
    "head": {"forward": "face", "up": "head_up"},
    "left_hand": {"forward": "left_hand", "palm": "left_palm", "thumb": "left_thumb"},
    "right_hand": {"forward": "right_hand", "palm": "right_palm", "thumb": "right_thumb"},
    "chest": {"forward": "chest"},
    "pelvis": {"forward": "pelvis", "up": "pelvis_up"},
}
"""What a mapping may say about the axes of parts, and the name under which the fit of a body asks for it."""
