"""Sentences that explain efforts: true to the evidence, and one for every answer."""

from __future__ import annotations

import math
import re

import pytest

from taskgist.language.efforts import gerunds, listed, why
from taskgist.perspective import ABILITIES, Ability
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.world import Hold, Stage, State
from tools.rooms import COARSE, Person, Room, Thing, chair, random_room, table, wall

CUP = Thing("cup", (0.03, 0.05), (0.5, 0.0, 1.1), "cylinder")
SITTER = Person("P1", (0, 0), 0.0, "sitting")


def sentence(room: Room, ability: Ability, name: str = "cup", untracked: tuple[str, ...] = ()) -> str:
    stage = room.stage()
    asked = SceneEfforts(Stage(stage.scene, State(stage.state.qpos, untracked=frozenset(untracked))), COARSE)
    return why(asked.effort("P1", name, ability))


def at(x: float, y: float, z: float) -> Thing:
    return Thing("cup", (0.03, 0.05), (x, y, z), "cylinder")


@pytest.mark.parametrize(
    ("place", "ability", "pattern"),
    [
        ((0.5, 0.0, 1.1), "reach", r"P1 reaches the cup by stretching out the (left|right) arm; P1 does not hold it"),
        ((0.9, 0.0, 1.0), "reach", r".* by leaning forward \d+° and stretching out .*; with less: .* beyond the arm"),
        ((0.5, 0.2, 1.8), "reach", r".* by standing up and stretching out the left arm; with less: .*"),
        ((2.0, 0.0, 1.1), "reach", r".* by standing up, going \d\.\d\d m .* and stretching out .*; with less: .*"),
        ((6.0, 0.0, 1.1), "reach", r"P1 cannot reach the cup: \d\.\d\d m from the .* beyond the arm.*"),
        ((0.8, 0.0, 1.2), "see", r"P1 sees the cup without effort: it is in the gaze cone, and all of its \d+ .*"),
        ((0.5, 1.0, 1.2), "see", r"P1 sees the cup by turning the head \d+°.*; with less: .* beside the gaze .*"),
        ((0.5, 0.0, 1.1), "grasp", r"P1 grasps the cup by stretching out the (left|right) arm; P1 does not hold it"),
    ],
)
def test_sentences(place: tuple[float, float, float], ability: Ability, pattern: str) -> None:
    assert re.fullmatch(pattern, sentence(Room((chair(0.0), at(*place)), (SITTER,)), ability))


def test_what_hides_is_named_with_its_pixels() -> None:
    room = Room((wall("screen", 0.6, half=(0.02, 9.0, 3.0)), at(1.5, 0.0, 1.5)), (Person("P1", (0, 0)),))
    told = sentence(room, "see")
    assert re.fullmatch(r"P1 cannot see the cup: the screen hides all of its [\d.]+ pixels, from every place .*", told)


def test_a_blocked_way_is_told_where_nothing_nearer_is() -> None:
    shelf = Thing("shelf", (0.3, 0.3, 0.02), (0.5, 0.0, 0.85), free=False)
    behind = wall("wall", -0.26, half=(0.02, 3.0, 1.2))
    room = Room((chair(0.0), behind, shelf, table(0.6, height=0.70), at(4.0, 0.0, 1.0)), (SITTER,))
    assert "elsewhere: Make_Standing is blocked: " in sentence(room, "reach")


def test_unknown() -> None:
    room = Room((chair(0.0), CUP), (SITTER,))
    assert sentence(room, "see", untracked=("cup",)) == "it is unknown whether P1 sees the cup: cup not tracked"


def test_held() -> None:
    stage = Room((chair(0.0), CUP), (SITTER,)).stage()
    state = stage.state.with_holding([Hold("P1", "left", "cup")])
    asked = SceneEfforts(Stage(stage.scene, state), COARSE)
    told = why(asked.effort("P1", "cup", "grasp"))
    assert told == "P1 grasps the cup without effort: it is in P1's left hand"


@pytest.mark.parametrize("seed", range(8))
def test_every_answer_has_its_sentence_with_every_action(seed: int) -> None:
    stage = random_room(seed).stage()
    asked = SceneEfforts(stage, COARSE)
    shown = stage.state
    for agent, name, ability in ((a, n, b) for a in stage.scene.agents for n in stage.scene.objects for b in ABILITIES):
        effort = asked.effort(agent, name, ability)
        told = why(effort)
        assert agent in told
        assert name in told
        assert "\n" not in told
        if effort.level in (1, 2, 3, 4):
            assert len(gerunds(effort)) == len(effort.actions)
            assert all(part in told for part in gerunds(effort))
    assert stage.state is shown


def test_amounts_are_those_of_the_attained_state() -> None:
    room = Room((chair(0.0), at(0.9, 0.0, 1.0)), (SITTER,))
    asked = SceneEfforts(room.stage(), COARSE)
    effort = asked.effort("P1", "cup", "reach")
    assert effort.amount is not None
    assert f"leaning forward {math.degrees(effort.amount.torso_rad):.0f}°" in gerunds(effort)


def test_enumerations() -> None:
    assert [listed(parts) for parts in (["a"], ["a", "b"], ["a", "b", "c"])] == ["a", "a and b", "a, b and c"]
