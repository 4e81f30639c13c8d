"""Queries in both directions (Eq. 7 and 8), and what an answer carries."""

import json
import pickle
from dataclasses import replace

import pytest

from taskgist.errors import UnknownNameError
from taskgist.perspective import (
    EFFORT_NAMES,
    Amount,
    Viewpoint,
    actions_for,
    effort_from,
    least_effort,
    objects_with,
    visibility,
)
from taskgist.perspective.effort import evidence_document
from tools.rooms import COARSE, Person, Room, Thing, chair, wall

HIGH = Thing("high", (0.03, 0.05), (0.5, 0.2, 1.75), "cylinder")
NEAR = Thing("near", (0.03, 0.05), (0.5, -0.2, 1.1), "cylinder")
FAR = Thing("far", (0.1,), (5.0, 4.0, 3.0), "sphere")
ROOM = Room((chair(0.0), HIGH, NEAR, FAR), (Person("P1", (0, 0), 0.0, "sitting"),))


@pytest.mark.parametrize(
    ("actions", "objects"),
    [
        ((), ()),
        (("Stretch_Out_Arm(left)",), ("near",)),
        (("Stretch_Out_Arm(right)",), ("near",)),
        (("Make_Standing",), ()),
        (("Make_Standing", "Stretch_Out_Arm(left)"), ("high", "near")),
    ],
)
def test_objects_that_given_actions_bring_within_reach(actions: tuple[str, ...], objects: tuple[str, ...]) -> None:
    assert objects_with(ROOM.stage(), "P1", "reach", actions, COARSE) == objects


def test_objects_seen_by_head_alone() -> None:
    stage = ROOM.stage()
    assert set(objects_with(stage, "P1", "see", (), COARSE)) <= set(
        objects_with(stage, "P1", "see", ["Tilt_Head"], COARSE)
    )
    assert "high" in objects_with(stage, "P1", "see", ["Pan_Head", "Tilt_Head"], COARSE)


def test_actions_for_an_object_are_in_order() -> None:
    stage = ROOM.stage()
    assert actions_for(stage, "P1", "high", "reach", COARSE) == ("Make_Standing", "Stretch_Out_Arm(left)")
    assert actions_for(stage, "P1", "far", "reach", COARSE) == ("No_Possible_Known_Action",)


def test_an_action_that_the_agent_does_not_have_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'Pan_Head'"):
        objects_with(ROOM.stage(), "P1", "see", ["Pan_Heads"])


def test_one_viewpoint_answers_like_many() -> None:
    stage = ROOM.stage()
    here = Viewpoint(stage, "P1", COARSE)
    for name in stage.scene.objects:
        shared, alone = effort_from(here, name, "grasp"), least_effort(stage, "P1", name, "grasp", COARSE)
        assert shared == alone


def test_names_are_those_of_figure_6() -> None:
    assert EFFORT_NAMES["see"][1:3] == ("Head_Effort", "Head_Torso_Effort")
    assert EFFORT_NAMES["grasp"][1:3] == ("Arm_Effort", "Arm_Torso_Effort")
    assert least_effort(ROOM.stage(), "P1", "high", "reach", COARSE).name == "Whole_Body_Effort"


def test_a_step_weighs_more_than_any_turn() -> None:
    assert Amount(0.0, 3.0, 3.0, 3.0) < Amount(0.25) < Amount(0.25, 0.1) < Amount(0.25, 0.1, 0.1)


@pytest.mark.parametrize("name", ["high", "near", "far"])
@pytest.mark.parametrize("ability", ["see", "reach", "grasp"])
def test_answers_are_plain_data_and_survive_a_process_pool(name: str, ability: str) -> None:
    stage = ROOM.stage()
    found = least_effort(stage, "P1", name, ability, COARSE)  # type: ignore[arg-type]
    assert json.loads(json.dumps(found.evidence_document)) == found.evidence_document
    assert pickle.loads(pickle.dumps(found)) == found
    assert found.reason
    assert set(found.joints_rad) == {"head_pan", "head_tilt", "torso_turn", "torso_lean"}
    seen = visibility(stage, "P1", name)
    assert seen is not None
    assert json.loads(json.dumps(evidence_document(seen))) == evidence_document(seen)


def test_sight_says_what_hides_the_object() -> None:
    hidden = replace(NEAR, name="cup", place=(1.5, 0.0, 1.0))
    stage = Room((wall("wall", 0.6, half=(0.02, 6.0, 3.0)), hidden), (Person("P1", (0, 0)),)).stage()
    seen = visibility(stage, "P1", "cup")
    assert seen is not None
    assert (seen.score, seen.visible_share, seen.in_gaze_cone) == (0.0, 0.0, False)
    assert seen.occluders[0][0] == "wall"
    assert "occluded by wall" in least_effort(stage, "P1", "cup", "see", COARSE).evidence_document["not_with_less"]  # type: ignore[operator]
