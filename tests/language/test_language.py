"""Sentences: what is said, in full, and that every predicate has its own phrase."""

from __future__ import annotations

import pytest

from taskgist.errors import UnknownNameError
from taskgist.facts import (
    NO_ACTION,
    REACH_EFFORTS,
    SEE_EFFORTS,
    STANDARD_TREE,
    Episode,
    Observation,
    Raw,
    predicate_subtree,
)
from taskgist.language import asked, indifference, listed, meaning, phrase, why
from taskgist.learning import Answer, Experience, Explanation, Understanding, Verdict, explain, questions_of, understand
from taskgist.settings import Learning

FREE = {"left": "Free_of_Object", "right": "Free_of_Object"}
TREE = STANDARD_TREE.extended(predicate_subtree("on_white_box"))


def shown(index: int, score: float, *, ends: str = "In_Hand", posture: str = "Sitting") -> Explanation:
    def snapshot(see: int, placement: str, visible: float) -> dict[str, Observation[Raw]]:
        values: dict[str, Raw] = {
            "see.effort": SEE_EFFORTS[see],
            "see.action": NO_ACTION if see == 0 else "Pan_Head",
            "visibility.score": visible,
            "posture": posture,
            "hands": FREE,
            "placement": placement,
            "motion": "Static",
        }
        return {name: Observation(value) for name, value in values.items()}

    start, end = snapshot(index % 3 + 1, "On_Support", 0.0), snapshot(0, ends, score)
    return explain(Episode("show", f"show {index}", "P1", "P2", "cup", start, end, source=f"test:{index}"))


def understood(band: str = "narrow") -> Understanding:
    demonstrations = [
        shown(1, 0.01),
        shown(2, 0.05),
        shown(3, 0.2),
        shown(4, 0.4, ends="On_Support", posture="Standing"),
    ]
    return understand(Experience.of("show", demonstrations), settings=Learning(band=band))


def test_the_meaning_is_one_sentence() -> None:
    assert meaning(understood()) == (
        "“show” means for the target agent: seeing the object takes no effort afterwards, it sees more of the object"
        " than before, its hands end free of objects, the object ends at rest, and it keeps its posture; beforehand,"
        " it sees next to nothing of the object, its hands are free of objects, and the object is at rest."
    )


def test_reaching_and_grasping_alike_are_said_once() -> None:
    def end(grasp: str) -> dict[str, Observation[Raw]]:
        return {"reach.effort": Observation("Arm_Effort"), "grasp.effort": Observation(grasp)}

    def told(grasp: str) -> str:
        only = explain(Episode("put", "put 1", "P1", "P2", "cup", {}, end(grasp), source="test"))
        answers = [
            Answer("put", f"{ability}.{part}", Verdict.RELEVANT, "ann", "2024-05-01T12:00:00+00:00", value)
            for ability in ("reach", "grasp")
            for part, value in (("nature", "Supportive"), ("class", "Becomes_Easier"))
        ]
        return meaning(understand(Experience.of("put", [only]), answers=answers))

    assert told("Arm_Effort").count("takes stretching out an arm") == 1
    assert "reaching and grasping the object takes" in told("Arm_Effort")
    assert told("Whole_Body_Effort").count("takes") == 2


def test_what_does_not_matter_is_said_apart_from_what_nobody_knows() -> None:
    assert indifference(understood()) == (
        "It does not matter where the object lies. Never observed was how hard the object is to reach and how hard the"
        " object is to grasp."
    )
    assert "Not clear yet is where the object lies." in indifference(understood("wide"))


def test_without_demonstrations_it_means_nothing_yet() -> None:
    nothing = understand(Experience("show"))
    assert meaning(nothing) == "“show” means nothing yet: the demonstrations have nothing in common."


def test_preconditions_alone_are_no_effect() -> None:
    start = {"posture": Observation("Sitting")}
    answer = Answer("wait", "posture.class", Verdict.RELEVANT, "ann", "2024-05-01T12:00:00+00:00", "Maintained")
    only = explain(Episode("wait", "wait 1", "P1", "P2", "cup", start, {}, source="test"))
    understanding = understand(Experience.of("wait", [only]), answers=[answer])
    assert (
        meaning(understanding) == "“wait” means for the target agent: it keeps its posture; beforehand, it is sitting."
    )


@pytest.mark.parametrize(
    ("node", "sentence"),
    [
        (
            "see.action.2",
            "Action_to_See counts: seeing the object takes no effort afterwards. Observed: No_Action_Required in 4 of 4"
            " (show 1, show 2, show 3, show 4). Its consistency factor 0.833 − 0 = 0.833 lies above d2 (d1 = 0.583,"
            " d2 = 0.75).",
        ),
        (
            "motion.status.1",
            "Object_Initial_Motion_Status counts: beforehand, the object is at rest. Observed: Static in 4 of 4"
            " (show 1, show 2, show 3, show 4). Its consistency factor 0.833 − 0 = 0.833 lies above d2 (d1 = 0.583,"
            " d2 = 0.75).",
        ),
        (
            "placement.status.2",
            "Object_Final_Status does not matter. Observed: In_Hand in 3 of 4 (show 1, show 2, show 3); On_Support in 1"
            " of 4 (show 4). Its consistency factor 0.667 − 0.333 = 0.333 does not exceed d1 (d1 = 0.467, d2 = 0.6).",
        ),
        (
            "placement.status.1",
            "Object_Initial_Status agrees, but does not count, because Object_Relative_Status above it does not."
            " Observed: On_Support in 4 of 4 (show 1, show 2, show 3, show 4). Its consistency factor 0.833 − 0 = 0.833"
            " lies above d2 (d1 = 0.583, d2 = 0.75).",
        ),
        ("reach.class", "Relative_Effort_Class_to_Reach was never observed."),
    ],
)
def test_reasons(node: str, sentence: str) -> None:
    assert why(understood(), node) == sentence


def test_an_answer_is_the_reason_where_there_is_one() -> None:
    answer = Answer("show", "motion.class", Verdict.IRRELEVANT, "ann", "2024-05-01T12:00:00+00:00")
    understanding = understand(understood().experience, answers=[answer])
    assert why(understanding, "motion.class") == (
        "Object_Relative_Motion_Status does not matter. Observed: motion_avoided in 4 of 4 (show 1, show 2, show 3,"
        " show 4). So said ann at 2024-05-01T12:00:00+00:00."
    )


def test_no_reason_for_a_node_that_does_not_exist() -> None:
    with pytest.raises(UnknownNameError, match=r"did you mean 'see\.class'"):
        why(understood(), "see.clas")


def test_a_question_names_the_values_and_who_showed_them() -> None:
    questions = {question.node.name: question for question in questions_of(understood("wide"))}
    assert asked(questions["placement.status.2"]) == (
        "What does “show” mean: that the object ends in a hand (in show 1, show 2, and show 3) or that the object ends"
        " on a support (in show 4); or does Object_Final_Status not matter?"
    )


def test_each_value_of_a_node_has_a_phrase_of_its_own() -> None:
    for node in TREE.nodes:
        phrases = [phrase(node, value) for value in node.values]
        assert len(set(phrases)) == len(phrases), node.name
        assert not [told for told in phrases if "_" in told], node.name


def test_no_standard_node_falls_back_to_its_title() -> None:
    for node in STANDARD_TREE.nodes:
        for value in node.values or ("something",):
            assert node.title.replace("_", " ").lower() not in phrase(node, value)


@pytest.mark.parametrize(
    ("node", "value", "told"),
    [
        (
            "reach.effort.1",
            REACH_EFFORTS[3],
            "reaching the object takes standing up, sitting down or bending",
        ),
        ("reach.effort.2", REACH_EFFORTS[5], "reaching the object is not possible by any known effort afterwards"),
        ("grasp.action.2", "Lean_Torso", "grasping the object takes leaning afterwards"),
        ("visibility.score.2", "≈ 0", "it sees next to nothing of the object afterwards"),
        ("visibility.score.1", "1.3-2.6 %", "the object fills 1.3-2.6 % of its view"),
        (
            "hands.status.2",
            "left: Holding_Object, right: Free_of_Object",
            "its left hand ends holding the object and its right hand ends free of objects",
        ),
        (
            "placement.class",
            "Gaining(In_Hand) & Losing(On_Support)",
            "the object, on a support at first, ends in a hand",
        ),
        ("placement.class", "Maintaining(On_Support)", "the object stays on a support"),
        ("on_white_box.value.2", "True", "final on white box is true"),
    ],
)
def test_phrases(node: str, value: str, told: str) -> None:
    assert phrase(TREE.node(node), value) == told


def test_lists() -> None:
    assert [listed("abc"[:count], "or") for count in range(4)] == ["", "a", "a or b", "a, b, or c"]
