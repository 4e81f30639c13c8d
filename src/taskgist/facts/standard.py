"""The standard tree: the eight subtrees of Fig. 11, in its order."""

from __future__ import annotations

from taskgist.facts import comparisons, natures
from taskgist.facts import vocabulary as v
from taskgist.facts.attributes import ScoreAttribute, SidedAttribute, SymbolAttribute
from taskgist.facts.subtree import Leaf, Nature, Relation, Subtree
from taskgist.facts.tree import HypothesisTree


def ability_subtree(ability: str, efforts: tuple[str, ...]) -> Subtree:
    """Subtree of an ability: nature, class, effort type T_E with state S and action A_v (Fig. 8).

    Args:
        ability: ``"reach"``, ``"grasp"`` or ``"see"``.
        efforts: Its effort types by level (Fig. 6).
    """
    suffix = f"to_{ability.capitalize()}"
    effort = SymbolAttribute(f"{ability}.effort", efforts)
    leaf = Leaf(
        effort,
        "effort",
        (f"Initial_Effort_{suffix}", f"Effort_{suffix}"),
        children=(
            Leaf(SymbolAttribute(f"{ability}.state"), "state", (f"Initial_State_{suffix}", f"State_{suffix}")),
            Leaf(SymbolAttribute(f"{ability}.action"), "action", (f"Initial_Action_{suffix}", f"Action_{suffix}")),
        ),
    )
    return Subtree(
        name=ability,
        attribute=effort,
        relation=Relation(f"Relative_Effort_Class_{suffix}", comparisons.compare_efforts, v.EFFORT_CLASSES),
        leaf=leaf,
        nature=Nature(f"Nature_Effort_Class_{suffix}", natures.nature_of_effort, v.NATURES),
        action_level=True,
    )


def visibility_subtree() -> Subtree:
    """Subtree of the visibility score (Fig. 9)."""
    score = ScoreAttribute("visibility.score")
    return Subtree(
        name="visibility",
        attribute=score,
        relation=Relation("Object_Relative_Visibility_Score", comparisons.compare_scores, v.SCORE_CLASSES),
        leaf=Leaf(score, "score", ("Object_Initial_Visibility_Score", "Object_Final_Visibility_Score")),
        nature=Nature("Nature_Visibility_Score", natures.nature_of_visibility, v.NATURES),
    )


def posture_subtree() -> Subtree:
    """Subtree of the target agent's posture (5.2.1)."""
    posture = SymbolAttribute("posture", v.POSTURES)
    return Subtree(
        name="posture",
        attribute=posture,
        relation=Relation("Relative_Posture", comparisons.compare_postures, v.POSTURE_CLASSES),
        leaf=Leaf(posture, "value", ("Initial_Posture", "Final_Posture")),
    )


def hands_subtree() -> Subtree:
    """Subtree of the target agent's hands (5.2.2)."""
    hands = SidedAttribute("hands", v.HAND_STATUSES)
    return Subtree(
        name="hands",
        attribute=hands,
        relation=Relation("Relative_Hand_Status", comparisons.compare_hands, v.HAND_CLASSES),
        leaf=Leaf(hands, "status", ("Initial_Hand_Status", "Final_Hand_Status")),
        nature=Nature("Nature_Hand_Status", natures.nature_of_hands, v.HAND_NATURES),
    )


def placement_subtree() -> Subtree:
    """Subtree of the target object's placement (Fig. 10)."""
    placement = SymbolAttribute("placement", v.PLACEMENTS)
    classes = tuple(v.TRANSITIONS.values())
    kinds = tuple(v.supportive_of(status) for status in v.PLACEMENTS)
    return Subtree(
        name="placement",
        attribute=placement,
        relation=Relation("Object_Relative_Status", comparisons.compare_statuses, classes),
        leaf=Leaf(placement, "status", ("Object_Initial_Status", "Object_Final_Status")),
        nature=Nature("Nature_Object_Status", natures.nature_of_status, kinds),
    )


def motion_subtree() -> Subtree:
    """Subtree of the target object's motion (5.3.2)."""
    motion = SymbolAttribute("motion", v.MOTIONS)
    return Subtree(
        name="motion",
        attribute=motion,
        relation=Relation("Object_Relative_Motion_Status", comparisons.compare_motions, v.MOTION_CLASSES),
        leaf=Leaf(motion, "status", ("Object_Initial_Motion_Status", "Object_Final_Motion_Status")),
    )


STANDARD_TREE = HypothesisTree(
    (
        ability_subtree("reach", v.REACH_EFFORTS),
        posture_subtree(),
        ability_subtree("grasp", v.REACH_EFFORTS),
        motion_subtree(),
        visibility_subtree(),
        ability_subtree("see", v.SEE_EFFORTS),
        hands_subtree(),
        placement_subtree(),
    )
)
"""The hypothesis space of Fig. 11."""
