"""The paper's six clauses, predicate by predicate (Eq. 36-42), its ablations (Eq. 43, 44, 8.4) and Figs. 15-18."""

from __future__ import annotations

import pytest

from taskgist.facts import STANDARD_TREE
from taskgist.learning import Clause, Verdict, clause_of, understand
from tests.learning.learning_samples import STUDY, study

SEATED = {"Initial_Posture": "Sitting", "Final_Posture": "Sitting"}
POSTURE_KEPT = {"Relative_Posture": "Maintained"}
STATIC = {"Object_Initial_Motion_Status": "Static", "Object_Final_Motion_Status": "Static"}
HANDS_FREE = {"Initial_Hand_Status": "Free_of_Object", "Final_Hand_Status": "Free_of_Object"}
ON_SUPPORT = {"Object_Initial_Status": "On_Support", "Object_Final_Status": "On_Support"}

CLAUSES: dict[str, dict[str, str]] = {
    "show": {  # Eq. 37
        **POSTURE_KEPT,
        **STATIC,
        "Object_Relative_Visibility_Score": "Increased",
        "Action_to_See": "No_Action_Required",
        **HANDS_FREE,
    },
    "hide": {  # Eq. 38
        **SEATED,
        **STATIC,
        "Object_Final_Visibility_Score": "≈ 0",
        "Relative_Effort_Class_to_See": "Becomes_Difficult",
        **HANDS_FREE,
        **ON_SUPPORT,
    },
    "make accessible": {  # Eq. 39
        "Relative_Effort_Class_to_Reach": "Becomes_Easier",
        **POSTURE_KEPT,
        **STATIC,
        "Relative_Effort_Class_to_Grasp": "Becomes_Easier",
        "Object_Relative_Visibility_Score": "Increased",
        "Nature_Effort_Class_to_See": "Supportive",
        **HANDS_FREE,
        **ON_SUPPORT,
    },
    "give": {  # Eq. 40
        "Action_to_Reach": "No_Action_Required",
        **POSTURE_KEPT,
        "Action_to_Grasp": "No_Action_Required",
        **STATIC,
        "Object_Relative_Visibility_Score": "Increased",
        "Nature_Effort_Class_to_See": "Supportive",
        "Relative_Hand_Status": "Manip_Gained",
        "Object_Initial_Status": "On_Support",
        "Object_Final_Status": "In_Hand",
    },
    "put away": {  # Eq. 41
        "Relative_Effort_Class_to_Reach": "Becomes_Difficult",
        **POSTURE_KEPT,
        **STATIC,
        "Relative_Effort_Class_to_Grasp": "Becomes_Difficult",
        "Object_Relative_Visibility_Score": "Decreased",
        "Relative_Effort_Class_to_See": "Remains_Same",
        **HANDS_FREE,
        **ON_SUPPORT,
    },
    "hide away": {  # Eq. 42
        "Relative_Effort_Class_to_Reach": "Becomes_Difficult",
        **POSTURE_KEPT,
        **STATIC,
        "Relative_Effort_Class_to_Grasp": "Becomes_Difficult",
        "Object_Final_Visibility_Score": "≈ 0",
        "Relative_Effort_Class_to_See": "Becomes_Difficult",
        **HANDS_FREE,
        **ON_SUPPORT,
    },
}


def predicates(clause: Clause) -> dict[str, str]:
    return {literal.title: str(literal.value) for literal in clause.literals}


@pytest.mark.parametrize("task", CLAUSES)
def test_the_clause_is_the_papers(task: str) -> None:
    clause = clause_of(understand(study(task)))
    assert predicates(clause) == CLAUSES[task]
    initial = {"Initial_Posture", "Object_Initial_Motion_Status", "Initial_Hand_Status", "Object_Initial_Status"}
    assert {literal.title for literal in clause.preconditions} == initial & set(CLAUSES[task])


def test_the_clause_in_the_papers_form() -> None:
    assert str(clause_of(understand(study("show")))) == (
        "Task(show) ← (Relative_Posture = Maintained) ∧ (Object_Initial_Motion_Status = Static)"
        " ∧ (Object_Final_Motion_Status = Static) ∧ (Object_Relative_Visibility_Score = Increased)"
        " ∧ (Action_to_See = No_Action_Required) ∧ (Initial_Hand_Status = Free_of_Object)"
        " ∧ (Final_Hand_Status = Free_of_Object)"
    )
    assert "(Object_Final_Visibility_Score ≈ 0)" in str(clause_of(understand(study("hide"))))


def test_show_after_two_three_and_four_demonstrations() -> None:
    """Figs. 15, 17, 18: reaching is pruned by the third, and the fourth lifts the posture by a level."""
    kept = [{each.node.name for each in understand(study("show", count)).kept} for count in (2, 3, 4)]
    assert "reach.class" in kept[0]
    assert "reach.nature" not in kept[1]
    assert {"posture.value.1", "posture.value.2", "placement.status.2"} <= kept[1]
    assert "posture.class" in kept[2]
    assert not {"posture.value.1", "posture.value.2", "placement.nature"} & kept[2]


def test_table_2_in_the_tree() -> None:
    final = understand(study("show")).judgements["placement.status.2"]
    assert (final.value, final.verdict) == ("In_Hand", Verdict.IRRELEVANT)
    assert list(final.counts.items()) == [("In_Hand", 3), ("On_Support", 1)]


def test_without_abilities_opposite_tasks_become_one() -> None:
    """Eq. 43 and 44 (8.3)."""
    blind = STANDARD_TREE.without(subtrees=["reach", "grasp", "see", "visibility"])
    clauses = [predicates(clause_of(understand(study(task), blind))) for task in ("make accessible", "put away")]
    assert clauses[0] == clauses[1] == {**POSTURE_KEPT, **STATIC, **HANDS_FREE, **ON_SUPPORT}


def test_without_the_action_level_show_loses_that_it_takes_no_effort() -> None:
    """8.4."""
    clause = predicates(clause_of(understand(study("show"), STANDARD_TREE.without(levels=["action"]))))
    assert clause["Relative_Effort_Class_to_See"] == "Becomes_Easier"
    assert not [title for title in clause if title.startswith("Action")]


def test_without_the_nature_level_seeing_does_not_matter_for_making_accessible() -> None:
    """8.4."""
    clause = predicates(clause_of(understand(study("make accessible"), STANDARD_TREE.without(levels=["nature"]))))
    assert not [title for title in clause if title.endswith("_See")]


@pytest.mark.parametrize("task", STUDY)
def test_a_clause_holds_in_its_own_demonstrations(task: str) -> None:
    clause = clause_of(understand(study(task)))
    assert {clause.holds(each.nodes) for each in study(task).explanations.values()} == {True}


OPPOSITES = {"show": "hide", "make accessible": "put away", "give": "hide away"}


@pytest.mark.parametrize(("task", "other"), [*OPPOSITES.items(), *((b, a) for a, b in OPPOSITES.items())])
def test_a_clause_holds_in_no_demonstration_of_the_opposite(task: str, other: str) -> None:
    clause = clause_of(understand(study(task)))
    assert {clause.holds(each.nodes) for each in study(other).explanations.values()} == {False}
