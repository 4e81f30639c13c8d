"""An effort is a value: its evidence is the same whenever, and wherever, it is asked for."""

import json
import pickle

import numpy as np
import pytest

from taskgist.perspective import ABILITIES, Viewpoint, effort_from
from taskgist.settings import DEFAULT
from tests.perspective.random_rooms import random_case
from tools.rooms import COARSE

SEEDS = range(800, 803)


@pytest.mark.parametrize("seed", SEEDS)
def test_evidence_told_late_is_evidence_told_at_once(seed: int) -> None:
    case = random_case(seed)
    stage = case.stage()
    agent = case.scene.agents[0]
    here = Viewpoint(stage, agent, COARSE)
    questions = [(name, ability) for name in case.scene.objects for ability in ABILITIES]
    late = {question: effort_from(here, *question) for question in questions}
    at_once = {question: effort_from(here, *question, explained=True) for question in questions}
    stage.show(case.scene.initial)
    stage.place(case.scene.agent(agent).geoms, np.zeros(3), np.eye(3).ravel())
    before = stage.geom_centers(case.scene.agent(agent).geoms)
    for question in questions:
        assert late[question] == at_once[question]
        assert late[question].evidence == at_once[question].evidence
        assert late[question].reason == at_once[question].evidence_document["reason"]
    assert (stage.geom_centers(case.scene.agent(agent).geoms) == before).all()


def test_it_respects_the_actions_that_were_allowed() -> None:
    case = random_case(804, untracked=False)
    here = Viewpoint(case.stage(), case.scene.agents[0], DEFAULT, actions=("Pan_Head",))
    for name in case.scene.objects:
        effort = effort_from(here, name, "see")
        assert effort.evidence == effort_from(here, name, "see", explained=True).evidence


def test_pickled_and_as_a_document_it_says_the_same() -> None:
    case = random_case(805)
    here = Viewpoint(case.stage(), case.scene.agents[0], COARSE)
    for ability in ABILITIES:
        effort = effort_from(here, case.scene.objects[0], ability)
        copied = pickle.loads(pickle.dumps(effort))
        assert copied == effort
        assert copied.evidence == effort.evidence
        document = json.loads(json.dumps(effort.document))
        assert (document["level"], document["effort"], document["reason"]) == (effort.level, effort.name, effort.reason)
        assert document["evidence"]["reason"] == effort.reason
        assert "find_evidence" not in document
