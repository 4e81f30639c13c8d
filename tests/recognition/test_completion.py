"""How tasks that are under way are foreseen: likeness of cases, what goes on as it did, and what that would be."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from taskgist.errors import KnowledgeError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.values import UNKNOWN, Observation, Value
from taskgist.learning.explanation import Context
from taskgist.observe.under_way import Cues
from taskgist.recognition.completion import (
    FACTS,
    SCALES,
    WORDS,
    Case,
    cases_document,
    cases_from,
    foresee,
    likeness,
    shipped_cases,
)
from taskgist.recognition.tasks import Recogniser
from tests.shipped import knowledge

CUES = Cues(
    stage="carried",
    handled=True,
    other_gap_m=0.0,
    other_nearing_m=0.0,
    reach_m=0.0,
    reach_m_s=0.0,
    distance_m=1.0,
    nearing_m=0.2,
    nearing_m_s=0.3,
    own_nearing_m=-0.2,
    own_nearing_m_s=-0.3,
    rise_m=0.1,
    rise_m_s=0.0,
    target_hand_m=0.3,
    target_hand_m_s=-0.5,
    blocked=False,
    blocked_ahead=False,
    hidden_ahead=0.0,
    performer_regards="thing",
    target_regards="thing",
)
NOW = {"hands.nature": "Manip_Not_Desired", "see.class": "Remains_Same", "placement.status.2": "In_Hand"}


def case(end: dict[str, str], **cues: Any) -> Case:
    own = CUES.as_dict() | cues
    return Case({name: own[name] for name in (*WORDS, *SCALES)}, NOW, {**NOW, **end})


def nodes(**values: str) -> dict[str, Observation[Value]]:
    return {name: Observation(value) for name, value in (NOW | values).items()}


@pytest.fixture(scope="module")
def recogniser() -> Recogniser:
    return Recogniser.of(knowledge("give", "show", "hide"))


def test_nothing_is_more_like_a_moment_than_itself() -> None:
    facts = {name: value for name, value in NOW.items() if name in FACTS}
    assert likeness(CUES.as_dict(), facts, case({})) == 0.0
    for name in SCALES:
        assert likeness(CUES.as_dict(), facts, case({}, **{name: getattr(CUES, name) + 0.1})) < 0.0, name
    for name in WORDS:
        assert likeness(CUES.as_dict(), facts, case({}, **{name: "other"})) < 0.0, name
    assert likeness(CUES.as_dict(), {"see.class": "Becomes_Easier"}, case({})) < 0.0


def test_what_a_case_changed_changes_and_what_it_left_stays() -> None:
    given = case({"hands.nature": "Manip_Desired"})
    end = given.ends(nodes(**{"see.class": "Becomes_Easier"}))
    assert {name: each.value for name, each in end.items()} == {
        "hands.nature": "Manip_Desired",
        "see.class": "Becomes_Easier",
        "placement.status.2": "In_Hand",
    }
    unknown = Case(given.cues, NOW, {"see.class": "Remains_Same"})
    assert unknown.ends(nodes())["hands.nature"].value is UNKNOWN


def test_a_task_is_as_probable_as_the_ends_that_would_be_it(recogniser: Recogniser) -> None:
    given, kept = case({"hands.nature": "Manip_Desired"}), case({})
    sure, never = (dict(foresee(recogniser, CUES, nodes(), [one]).tasks)["give"] for one in (given, kept))
    assert sure > never
    both = foresee(recogniser, CUES, nodes(), [given, kept])
    assert dict(both.tasks)["give"] == pytest.approx((sure + never) / 2)
    far = replace(given, cues={**given.cues, "stage": "untouched", "handled": None})
    assert never < dict(foresee(recogniser, CUES, nodes(), [far, kept]).tasks)["give"] < 0.1 * sure + never
    assert foresee(recogniser, CUES, nodes(), [given, kept]) == foresee(recogniser, CUES, nodes(), [kept, given])


def test_what_does_not_hold_yet_is_told(recogniser: Recogniser) -> None:
    foreseen = foresee(recogniser, CUES, nodes(), [case({"hands.nature": "Manip_Desired"})])
    assert foreseen.best == "give"
    assert {each.node for each in foreseen.missing} <= {*NOW}
    assert all(each.holds(nodes()) is False for each in foreseen.missing)


def test_without_cases_it_is_what_it_would_be_if_it_ended_now(recogniser: Recogniser) -> None:
    foreseen, now = foresee(recogniser, CUES, nodes(), []), recogniser.recognise(nodes())
    assert dict(foreseen.tasks) == pytest.approx({each.task: each.probability for each in now.tasks})
    assert foreseen.none == pytest.approx(now.none)


def test_the_shipped_cases_are_of_today_and_know_no_task() -> None:
    cases = shipped_cases()
    assert len(cases) > 500
    told = {node.name for node in STANDARD_TREE.nodes}
    assert {name for each in cases for name in (*each.now, *each.end)} <= told
    assert Context.of().settings_digest == document_of_shipped()["settings_digest"]
    assert {each.cues["stage"] for each in cases} == {"untouched", "grasped", "carried", "let go", "taken"}


def document_of_shipped() -> dict[str, Any]:
    import gzip
    import json

    from taskgist.recognition.completion import SHIPPED

    document: dict[str, Any] = json.loads(gzip.decompress(SHIPPED.read_bytes()))
    return document


def test_cases_survive_being_written() -> None:
    cases = (case({"hands.nature": "Manip_Desired"}), case({}, stage="untouched", handled=None))
    assert cases_from(cases_document(cases, Context.of())) == cases


@pytest.mark.parametrize("wrong", [{"format": "else"}, {"cues": ["stage"]}, {"cases": [[[], [], []]]}, {"nodes": None}])
def test_what_is_no_cases_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(KnowledgeError, match=r"no cases: .*tools\.under_way_cases"):
        cases_from(cases_document((case({}),), Context.of()) | wrong)
