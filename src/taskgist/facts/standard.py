"""The standard tree: the eight subtrees of Fig. 11, in its order."""

from __future__ import annotations

from collections.abc import Mapping

from taskgist.facts import vocabulary as v
from taskgist.facts.tree import HypothesisTree, Leaf, Nature, Relation, Subtree
from taskgist.facts.values import UNKNOWN, ScoreAttribute, SidedAttribute, SymbolAttribute, Unknown, Value
from taskgist.settings import Settings

# Comparisons (level 2): how an attribute differs between the start (¹) and the end (²) of a demonstration.


def compare_efforts(initial: str, final: str, _settings: Settings) -> Value:
    """Relative effort class (Eq. 10, whose printed signs are reversed: less effort at the end is *easier*)."""
    before, after = v.EFFORT_LEVELS[initial], v.EFFORT_LEVELS[final]
    if after == before:
        return v.REMAINS_SAME
    return v.BECOMES_EASIER if after < before else v.BECOMES_DIFFICULT


def compare_scores(initial: float, final: float, settings: Settings) -> Value:
    """Relative visibility class (Eq. 12).

    The change counts relative to the greater score, so that forth and back are judged alike; scores below the
    negligible one count as that one, so that noise around nothing is no change.
    """
    least = settings.vision.negligible_score
    before, after = max(initial, least), max(final, least)
    if abs(after - before) < settings.vision.change_tolerance * max(before, after) or after == before:
        return v.ALMOST_SAME
    return v.INCREASED if after > before else v.DECREASED


def compare_postures(initial: str, final: str, _settings: Settings) -> Value:
    """Relative posture class (Eq. 15)."""
    return v.MAINTAINED if initial == final else v.CHANGED


def compare_hands(
    initial: Mapping[str, str | None],
    final: Mapping[str, str | None],
    _settings: Settings,
) -> Value:
    """Relative hand status class (Eq. 17): is the target object in any hand of the agent, before and after?"""
    before, after = holds_object(initial), holds_object(final)
    if isinstance(before, Unknown) or isinstance(after, Unknown):
        return UNKNOWN
    if before:
        return v.MANIP_MAINTAINED if after else v.MANIP_LOSS
    return v.MANIP_GAINED if after else v.MANIP_AVOIDED


def holds_object(hands: Mapping[str, str | None]) -> bool | Unknown:
    """Whether any hand holds the target object; one that surely does settles it, whatever the others do."""
    if v.HOLDING_OBJECT in hands.values():
        return True
    return UNKNOWN if None in hands.values() else False


def compare_statuses(initial: str, final: str, _settings: Settings) -> Value:
    """Class of a status: *Maintaining*, or *Gaining* one with *Losing* the other as one value (Eq. 20)."""
    return v.maintaining(final) if initial == final else v.gaining(final, losing=initial)


def compare_motions(initial: str, final: str, _settings: Settings) -> Value:
    """Relative motion class (Eq. 23)."""
    classes = {
        (v.STATIC, v.MOVING): v.MOTION_GAINED,
        (v.MOVING, v.STATIC): v.MOTION_LOST,
        (v.MOVING, v.MOVING): v.MOTION_MAINTAINED,
        (v.STATIC, v.STATIC): v.MOTION_AVOIDED,
    }
    return classes[initial, final]


# Natures (level 1): what a change means for the target agent.
#
# Each takes the class of level 2 and the final symbol of level 3; both are known when a nature is asked for, but for
# the hands, whose class may be known where the status of a hand is not.


def nature_of_effort(relation: str, _final: Value) -> Value:
    """Nature of a relative effort class (Eq. 11)."""
    return v.NOT_SUPPORTIVE if relation == v.BECOMES_DIFFICULT else v.SUPPORTIVE


def nature_of_visibility(relation: str, _final: Value) -> Value:
    """Nature of a relative visibility class (Eq. 13)."""
    return v.NOT_SUPPORTIVE if relation == v.DECREASED else v.SUPPORTIVE


def nature_of_hands(relation: str, _final: Value) -> Value:
    """Nature of a relative hand status class (Eq. 18)."""
    return v.MANIP_DESIRED if relation in (v.MANIP_MAINTAINED, v.MANIP_GAINED) else v.MANIP_NOT_DESIRED


def nature_of_status(_relation: str, final: Value) -> Value:
    """Nature of a status class: supportive of the final status, which it maintains or gains (Eq. 21).

    The equation's *Not_Supportive* belongs to *Losing* alone, which never comes alone here.
    """
    return UNKNOWN if isinstance(final, Unknown) else v.supportive_of(final)


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
        relation=Relation(f"Relative_Effort_Class_{suffix}", compare_efforts, v.EFFORT_CLASSES),
        leaf=leaf,
        nature=Nature(f"Nature_Effort_Class_{suffix}", nature_of_effort, v.NATURES),
        action_level=True,
    )


def visibility_subtree() -> Subtree:
    """Subtree of the visibility score (Fig. 9)."""
    score = ScoreAttribute("visibility.score")
    return Subtree(
        name="visibility",
        attribute=score,
        relation=Relation("Object_Relative_Visibility_Score", compare_scores, v.SCORE_CLASSES),
        leaf=Leaf(score, "score", ("Object_Initial_Visibility_Score", "Object_Final_Visibility_Score")),
        nature=Nature("Nature_Visibility_Score", nature_of_visibility, v.NATURES),
    )


def posture_subtree() -> Subtree:
    """Subtree of the target agent's posture (5.2.1)."""
    posture = SymbolAttribute("posture", v.POSTURES)
    return Subtree(
        name="posture",
        attribute=posture,
        relation=Relation("Relative_Posture", compare_postures, v.POSTURE_CLASSES),
        leaf=Leaf(posture, "value", ("Initial_Posture", "Final_Posture")),
    )


def hands_subtree() -> Subtree:
    """Subtree of the target agent's hands (5.2.2)."""
    hands = SidedAttribute("hands", v.HAND_STATUSES)
    return Subtree(
        name="hands",
        attribute=hands,
        relation=Relation("Relative_Hand_Status", compare_hands, v.HAND_CLASSES),
        leaf=Leaf(hands, "status", ("Initial_Hand_Status", "Final_Hand_Status")),
        nature=Nature("Nature_Hand_Status", nature_of_hands, v.HAND_NATURES),
    )


def placement_subtree() -> Subtree:
    """Subtree of the target object's placement (Fig. 10)."""
    placement = SymbolAttribute("placement", v.PLACEMENTS)
    classes = tuple(v.TRANSITIONS.values())
    kinds = tuple(v.supportive_of(status) for status in v.PLACEMENTS)
    return Subtree(
        name="placement",
        attribute=placement,
        relation=Relation("Object_Relative_Status", compare_statuses, classes),
        leaf=Leaf(placement, "status", ("Object_Initial_Status", "Object_Final_Status")),
        nature=Nature("Nature_Object_Status", nature_of_status, kinds),
    )


def motion_subtree() -> Subtree:
    """Subtree of the target object's motion (5.3.2)."""
    motion = SymbolAttribute("motion", v.MOTIONS)
    return Subtree(
        name="motion",
        attribute=motion,
        relation=Relation("Object_Relative_Motion_Status", compare_motions, v.MOTION_CLASSES),
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
    ),
    edition="2",
)
"""The hypothesis space of Fig. 11; in its second edition things may also be on an agent, or hang."""
