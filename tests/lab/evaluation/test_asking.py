"""The experiment on questions: the teacher answers by its intention alone, and answers are worth something."""

from __future__ import annotations

import pytest

from taskgist.facts import STANDARD_TREE
from taskgist.learning.answers import Reply
from taskgist.learning.literals import vocabularies
from taskgist_lab.evaluation.asking import Teacher, asking, intention
from taskgist_lab.evaluation.learner import Coded
from tests.lab.evaluation.pools import study_pool

KNOWN = {each.node.name: each for each in vocabularies(STANDARD_TREE)}


@pytest.mark.parametrize(
    ("task", "node", "value", "reply"),
    [
        ("hide", "see.class", "Becomes_Difficult", Reply.YES),
        ("hide", "see.nature", "Not_Supportive", Reply.YES),
        ("hide", "see.nature", "Supportive", Reply.NO),
        ("hide", "see.effort.2", "No_Possible_Known_Effort", Reply.EITHER),
        ("hide", "reach.class", "Becomes_Difficult", Reply.EITHER),
        ("hide away", "reach.class", "Becomes_Difficult", Reply.YES),
        ("give", "hands.nature", "Manip_Desired", Reply.YES),
        ("give", "placement.status.2", "On_Support", Reply.NO),
        ("put away", "placement.status.2", "On_Support", Reply.YES),
        ("show", "posture.value.2", "Sitting", Reply.EITHER),
    ],
)
def test_a_teacher_says_what_follows_from_what_it_means(task: str, node: str, value: str, reply: Reply) -> None:
    assert Teacher(intention(task)).answer(KNOWN[node].literal((value,))) is reply


def test_answers_are_worth_something_on_the_study() -> None:
    found = asking(Coded.of(study_pool(12)), runs=1, seed=3, others=(0,), demonstrations=(1,))
    scores = {(each.demonstrations, each.questions): each.as_fulfilled.mean or 0.0 for each in found.rows}
    assert scores[1, 3] > scores[1, 0]
    assert sum(found.replies.values()) == sum(round(each.asked * 6) for each in found.rows if each.questions == 3)
    assert all(0.0 <= share <= 1.0 for share in found.truth.values())
