"""The paper's symbols, each in its canonical order (Fig. 6, Eq. 10-23)."""

from __future__ import annotations

REACH_EFFORTS = (
    "No_Effort_Required",
    "Arm_Effort",
    "Arm_Torso_Effort",
    "Whole_Body_Effort",
    "Displacement_Effort",
    "No_Possible_Known_Effort",
)
"""Effort types to reach or grasp by level, 0 to 5 (Fig. 6)."""

SEE_EFFORTS = (
    "No_Effort_Required",
    "Head_Effort",
    "Head_Torso_Effort",
    "Whole_Body_Effort",
    "Displacement_Effort",
    "No_Possible_Known_Effort",
)
"""Effort types to see by level, 0 to 5 (Fig. 6)."""

EFFORT_LEVELS = {name: level for ladder in (REACH_EFFORTS, SEE_EFFORTS) for level, name in enumerate(ladder)}
"""Level of each effort type."""

NO_ACTION = "No_Action_Required"
"""The action A_v where the ability holds from the current state (5.1.5)."""

REMAINS_SAME, BECOMES_EASIER, BECOMES_DIFFICULT = "Remains_Same", "Becomes_Easier", "Becomes_Difficult"
EFFORT_CLASSES = (REMAINS_SAME, BECOMES_EASIER, BECOMES_DIFFICULT)
"""Relative effort classes (Eq. 10)."""

ALMOST_SAME, INCREASED, DECREASED = "Almost_Same", "Increased", "Decreased"
SCORE_CLASSES = (ALMOST_SAME, INCREASED, DECREASED)
"""Relative visibility classes (Eq. 12)."""

SUPPORTIVE, NOT_SUPPORTIVE = "Supportive", "Not_Supportive"
NATURES = (SUPPORTIVE, NOT_SUPPORTIVE)
"""Natures of a change in effort or visibility (Eq. 11, 13)."""

STANDING, SITTING = "Standing", "Sitting"
POSTURES = (STANDING, SITTING)
"""Postures (Eq. 14)."""

MAINTAINED, CHANGED = "Maintained", "Changed"
POSTURE_CLASSES = (MAINTAINED, CHANGED)
"""Relative posture classes (Eq. 15)."""

HOLDING_OBJECT, HOLDING_OTHER = "Holding_Object", "Holding_Other_Object"
FREE_OF_OBJECT, RESTING_ON_SUPPORT = "Free_of_Object", "Resting_on_Support"
HAND_STATUSES = (HOLDING_OBJECT, HOLDING_OTHER, FREE_OF_OBJECT, RESTING_ON_SUPPORT)
"""Status of one hand (Eq. 16; ours: whether it is the target object that is held)."""

MANIP_MAINTAINED, MANIP_GAINED, MANIP_LOSS, MANIP_AVOIDED = (
    "Manip_Maintained",
    "Manip_Gained",
    "Manip_Loss",
    "Manip_Avoided",
)
HAND_CLASSES = (MANIP_MAINTAINED, MANIP_GAINED, MANIP_LOSS, MANIP_AVOIDED)
"""Relative hand status classes (Eq. 17)."""

MANIP_DESIRED, MANIP_NOT_DESIRED = "Manip_Desired", "Manip_Not_Desired"
HAND_NATURES = (MANIP_DESIRED, MANIP_NOT_DESIRED)
"""Natures of a change of hand status (Eq. 18)."""

INSIDE_CONTAINER, ON_SUPPORT, IN_HAND, IN_AIR = "Inside_Container", "On_Support", "In_Hand", "In_Air"
ON_AGENT, HANGING = "On_Agent", "Hanging"
"""Ours: on a lap or an arm, in a pocket; on a hook or a rail, at a wall. Eq. 19 has these in the air."""
PLACEMENTS = (INSIDE_CONTAINER, ON_SUPPORT, IN_HAND, ON_AGENT, HANGING, IN_AIR)
"""Object placements (Eq. 19), in the order in which an ambiguity is decided."""

MOVING, STATIC = "Moving", "Static"
MOTIONS = (MOVING, STATIC)
"""Object motion (Eq. 22)."""

MOTION_GAINED, MOTION_LOST, MOTION_MAINTAINED, MOTION_AVOIDED = (
    "motion_gained",
    "motion_lost",
    "motion_maintained",
    "motion_avoided",
)
MOTION_CLASSES = (MOTION_GAINED, MOTION_LOST, MOTION_MAINTAINED, MOTION_AVOIDED)
"""Relative motion classes (Eq. 23)."""


def maintaining(status: str) -> str:
    """Class of a status that stays (Eq. 20)."""
    return f"Maintaining({status})"


def gaining(final: str, *, losing: str) -> str:
    """Class of a status that gives way to another, both facts as one value (Eq. 20)."""
    return f"Gaining({final}) & Losing({losing})"


def supportive_of(status: str) -> str:
    """Nature of a change that keeps or brings this status (Eq. 21)."""
    return f"{SUPPORTIVE}({status})"


TRANSITIONS = {
    (initial, final): maintaining(final) if initial == final else gaining(final, losing=initial)
    for initial in PLACEMENTS
    for final in PLACEMENTS
}
"""Relative placement classes by initial and final placement (Eq. 20)."""
