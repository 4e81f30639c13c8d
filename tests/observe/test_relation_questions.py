"""Relations in set questions, alone and with efforts."""

from __future__ import annotations

import math

import pytest

from taskgist.errors import InputError, UnknownNameError
from taskgist.observe import RELATION_VERBS, Related, looks_at
from taskgist.perspective.queries import Condition, objects_where, parse_question
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.world import Stage
from tests.cli.running import run, run_json
from tests.shipped import PATHS
from tools.rooms import Person, Room, Thing, wall

AHEAD = Thing("ahead", (0.05,), (1.0, 0.0, 1.6), "sphere")
LEFT = Thing("left", (0.05,), (0.0, 0.5, 1.0), "sphere")
HIDDEN = Thing("hidden", (0.05,), (3.0, 0.0, 1.0), "sphere")
PEOPLE = (Person("P1", (0.0, 0.0)), Person("P2", (-2.0, 0.0), math.pi))
STAGE = Room((AHEAD, LEFT, HIDDEN, wall("wall", 2.0)), PEOPLE).stage()
AGENTS = STAGE.scene.agents


@pytest.mark.parametrize(
    ("text", "yes"),
    [
        ("P1 looks_at", {"ahead"}),
        ("P1 has_in_sight", {"ahead", "left"}),
        ("not P1 has_in_sight", {"hidden"}),
        ("P1 has_left or P1 has_right", {"left"}),
        ("P1 faces and not P1 is_near", {"hidden"}),
        ("P1 is_near and P2 has_behind", {"ahead", "left"}),
        ("P1 touches or P1 carries", set()),
        ("P1 sees <= 1 and not P1 looks_at", set()),
        ("P1 reaches <= 1 and P1 has_left", {"left"}),
    ],
)
def test_questions_about_relations(text: str, yes: set[str]) -> None:
    assert set(objects_where(SceneEfforts(STAGE), parse_question(text, AGENTS, RELATION_VERBS)).yes) == yes


def test_a_question_is_a_value_and_unknown_is_unknown() -> None:
    question = Related("P1", "looks_at") & ~Condition("P2", "see")
    assert parse_question("P1 looks_at and not P2 sees", AGENTS, RELATION_VERBS) == question
    lost = Stage(STAGE.scene, STAGE.state.without(["ahead"]))
    assert objects_where(lost, Related("P1", "looks_at")).unknown == ("ahead",)
    assert looks_at(lost, "P1", "left") is False


def test_verbs_that_are_none_are_refused_and_need_to_be_given() -> None:
    for wrong in ("P1 looks_up", "P1 looks_at <= 2"):
        with pytest.raises(InputError, match=r"did you mean 'looks_at'|'<=' is too much"):
            parse_question(wrong, AGENTS, RELATION_VERBS)
    with pytest.raises(UnknownNameError):
        parse_question("P1 looks_at", AGENTS)
    with pytest.raises(UnknownNameError):
        Related("P1", "adores")


def test_the_command_line_asks_them() -> None:
    line = f"query {PATHS['show_a']} --at 6 --where 'P1 carries and P2 looks_at'"
    document = run_json(line)
    assert document["yes"] == ["cup"]
    assert document["efforts"]["cup"] == []
    assert "cup" in run(line)
