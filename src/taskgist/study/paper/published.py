"""The clauses as the paper prints them, and how each predicate is read (Eq. 36-44).

The print calls one thing by several names (*Increase*, *Increasing*, *Increased*; *Object_Free* for Eq. 16's
*Free_of_object*; *Relative_Effort_to_Reach* for the class of Eq. 10): these are spellings. Where it says something that
its own definitions do not allow, or cannot be read, the reading has a reason beside it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from taskgist.facts import NEGLIGIBLE, NO_ACTION
from taskgist.facts import vocabulary as v


@dataclass(frozen=True)
class Published:
    """One predicate of a published clause.

    Args:
        node: The node of the tree that it speaks of.
        printed: What the paper prints; empty where it prints nothing.
        value: How that is read: a value of the node.
        reason: Why it is read so, where the print says something else.
    """

    node: str
    printed: str
    value: str
    reason: str = ""


@dataclass(frozen=True)
class PublishedClause:
    """A clause of the paper.

    Args:
        task: The task.
        where: Its equation.
        predicates: In the order of the print.
    """

    task: str
    where: str
    predicates: tuple[Published, ...]


EFFORT_MAINTAINED = "Maintained is a value of postures (Eq. 15); of an effort it is Remains_Same (Eq. 10)"
RUN_TOGETHER = (
    "the last lines run together in the text that was read (“Final_Initial_Status = On_Support”, no final hands); "
    "they are those of Eq. 38 and 39"
)
GARBLED = "this line cannot be read in the text that we have; Table 4 says Supportive"
NOT_PRINTED = (
    "not in the text that we have; initial and final motion hang below one class, so that the final one cannot be "
    "dropped while the initial one stays"
)

_MAINTAINED = Published("posture.class", "Relative_Posture = Maintained", v.MAINTAINED)
_STATIC_1 = Published("motion.status.1", "Object_Initial_Motion_Status = Static", v.STATIC)
_STATIC_2 = Published("motion.status.2", "Object_Final_Motion_Status = Static", v.STATIC)
_FREE_1 = Published("hands.status.1", "Initial_Hand_Status = Object_Free", v.FREE_OF_OBJECT)
_FREE_2 = Published("hands.status.2", "Final_Hand_Status = Object_Free", v.FREE_OF_OBJECT)
_ON_SUPPORT_1 = Published("placement.status.1", "Object_Initial_Status = On_Support", v.ON_SUPPORT)
_ON_SUPPORT_2 = Published("placement.status.2", "Object_Final_Status = On_Support", v.ON_SUPPORT)
_INCREASED = Published("visibility.class", "Object_Relative_Visibility_Score = Increase", v.INCREASED)
_HARDER_TO_REACH = Published("reach.class", "Relative_Effort_to_Reach = Becomes_Difficult", v.BECOMES_DIFFICULT)
_HARDER_TO_GRASP = Published("grasp.class", "Relative_Effort_to_Grasp = Becomes_Difficult", v.BECOMES_DIFFICULT)
_ENDS_RUN_TOGETHER = (
    _FREE_1,
    Published("hands.status.2", "", v.FREE_OF_OBJECT, RUN_TOGETHER),
    Published("placement.status.1", "Final_Initial_Status = On_Support", v.ON_SUPPORT, RUN_TOGETHER),
    _ON_SUPPORT_2,
)
_WITHOUT_ABILITIES = (_MAINTAINED, _STATIC_1, _STATIC_2, _FREE_1, _FREE_2, _ON_SUPPORT_1, _ON_SUPPORT_2)

_PRINTED = (
    PublishedClause(
        "show",
        "Eq. 37",
        (
            _MAINTAINED,
            _STATIC_1,
            _STATIC_2,
            _INCREASED,
            Published("see.action.2", "Action_to_See = No_Action_Required", NO_ACTION),
            _FREE_1,
            _FREE_2,
        ),
    ),
    PublishedClause(
        "hide",
        "Eq. 38",
        (
            Published("posture.value.1", "Human_Initial_Posture = Sitting", v.SITTING),
            Published("posture.value.2", "Human_Final_Posture = Sitting", v.SITTING),
            _STATIC_1,
            _STATIC_2,
            Published("visibility.score.2", "Object_Final_Visibility_Score ≈ 0", NEGLIGIBLE),
            Published("see.class", "Relative_Effort_Class_to_See = Becomes_Difficult", v.BECOMES_DIFFICULT),
            _FREE_1,
            _FREE_2,
            _ON_SUPPORT_1,
            _ON_SUPPORT_2,
        ),
    ),
    PublishedClause(
        "make accessible",
        "Eq. 39",
        (
            Published("reach.class", "Relative_Effort_to_Reach = Becomes_Easier", v.BECOMES_EASIER),
            _MAINTAINED,
            _STATIC_1,
            _STATIC_2,
            Published("grasp.class", "Relative_Effort_to_Grasp = Becomes_Easier", v.BECOMES_EASIER),
            Published("visibility.class", "Object_Relative_Visibility_Score = Increased", v.INCREASED),
            Published("see.nature", "Nature_Effort_Class_to_See = Supportive", v.SUPPORTIVE),
            _FREE_1,
            _FREE_2,
            _ON_SUPPORT_1,
            _ON_SUPPORT_2,
        ),
    ),
    PublishedClause(
        "give",
        "Eq. 40",
        (
            Published("reach.action.2", "Action_to_Reach = No_Action_Required", NO_ACTION),
            _MAINTAINED,
            Published("grasp.action.2", "Action_to_Grasp = No_Action_Required", NO_ACTION),
            _STATIC_1,
            Published("motion.status.2", "", v.STATIC, NOT_PRINTED),
            _INCREASED,
            Published("see.nature", "Native_Hand_Status = Manipulability_Gained", v.SUPPORTIVE, GARBLED),
            Published("hands.class", "Relative_Hand_Status = Manipulability_Gained", v.MANIP_GAINED),
            _ON_SUPPORT_1,
            Published("placement.status.2", "Object_Final_Status = In_Hand", v.IN_HAND),
        ),
    ),
    PublishedClause(
        "put away",
        "Eq. 41",
        (
            _HARDER_TO_REACH,
            _MAINTAINED,
            _STATIC_1,
            _STATIC_2,
            _HARDER_TO_GRASP,
            Published("visibility.class", "Relative_Visibility_Score = Decreased", v.DECREASED),
            Published("see.class", "Relative_Effort_to_See = Maintained", v.REMAINS_SAME, EFFORT_MAINTAINED),
            *_ENDS_RUN_TOGETHER,
        ),
    ),
    PublishedClause(
        "hide away",
        "Eq. 42",
        (
            _HARDER_TO_REACH,
            _MAINTAINED,
            _STATIC_1,
            _STATIC_2,
            _HARDER_TO_GRASP,
            Published("visibility.score.2", "Object_Final_Visibility_Score ≈ 0.0", NEGLIGIBLE),
            Published("see.class", "Relative_Effort_to_See = Becomes_Difficult", v.BECOMES_DIFFICULT),
            *_ENDS_RUN_TOGETHER,
        ),
    ),
)
CLAUSES: Mapping[str, PublishedClause] = MappingProxyType({clause.task: clause for clause in _PRINTED})
"""Eq. 37 to 42 by task, in the paper's order."""

SHORT_SHOW = PublishedClause(
    "show",
    "Eq. 36",
    (
        Published("posture.class", "C_RPost = Maintained", v.MAINTAINED),
        Published("motion.status.1", "O_ms¹ = Static", v.STATIC),
        Published("motion.status.2", "O_ms² = Static", v.STATIC),
        Published("visibility.class", "C_RVis = Increasing", v.INCREASED),
        Published("see.action.2", "A_v²(see) = No_Action_Required", NO_ACTION),
        Published("hands.status.1", "H_s¹ = Object_Free", v.FREE_OF_OBJECT),
        Published("hands.status.2", "H_s² = Object_Free", v.FREE_OF_OBJECT),
    ),
)
"""Eq. 36: the clause of Eq. 37 in the notation of Fig. 11."""

WITHOUT_ABILITIES = (
    PublishedClause("make accessible", "Eq. 43", _WITHOUT_ABILITIES),
    PublishedClause("put away", "Eq. 44", _WITHOUT_ABILITIES),
)
"""What is left of two opposite tasks without any ability of the target agent (8.3)."""
