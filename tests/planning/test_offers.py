"""What is offered to somebody who is after a thing: laws of whole rooms, and rooms that witness them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import pytest

from taskgist.errors import InputError, UnknownNameError
from taskgist.facts import REACH_EFFORTS, SEE_EFFORTS, STANDARD_TREE, Observation, Raw
from taskgist.learning import Clause, Knowledge, Literal
from taskgist.perspective.effort import ABILITIES, Ability
from taskgist.pipeline import known_clauses, shipped_room
from taskgist.planning import Offers, offers_for
from taskgist.planning.offers import OWN_ACT_LEVEL, lowering
from taskgist.world import Scene
from taskgist.world.stage import Stage
from tests.learning.learning_samples import STUDY, study
from tests.scenes import CHAIR, TABLE, agent, box, cylinder, scene

TAKE_AWAY = {"hide", "hide away", "put away"}
LADDERS: dict[Ability, tuple[str, ...]] = {"see": SEE_EFFORTS, "reach": REACH_EFFORTS, "grasp": REACH_EFFORTS}


@cache
def clauses() -> tuple[Clause, ...]:
    known = Knowledge().add(*(each for task in STUDY for each in study(task).explanations.values()))
    return known_clauses(known)


@cache
def room() -> Stage:
    return Stage(Scene.load(shipped_room()))


@cache
def offered(agent: str, name: str, ability: Ability) -> Offers:
    return offers_for(room(), agent, name, ability, clauses())


def all_of_the_room() -> Iterator[Offers]:
    for name in ("cup", "box", "bottle"):
        for ability in ABILITIES:
            yield offered("P2", name, ability)


def test_who_must_lean_for_the_cup_may_be_given_it() -> None:
    found = offered("P2", "cup", "reach")
    tasks = {each.task: each for each in found.tasks}
    assert (found.effort.level, found.declined) == (2, None)
    assert (tasks["give"].level, tasks["give"].in_hand) == (0, True)
    assert (tasks["make accessible"].least, tasks["make accessible"].in_hand) == (1, False)
    assert [(each.name, each.robot, each.has_it) for each in found.helpers] == [("Jido", True, False)]


def test_what_the_next_act_does_is_never_offered() -> None:
    levels = set()
    for found in all_of_the_room():
        levels.add(found.effort.level)
        if found.effort.level in range(OWN_ACT_LEVEL + 1):
            assert (found.declined, found.tasks, found.helpers) == ("own act", (), ())
        else:
            assert found.declined != "own act"
    assert {0, 1, 2} <= levels


def test_what_is_offered_lowers_the_effort() -> None:
    for found in all_of_the_room():
        for each in found.tasks:
            assert found.effort.level is not None
            assert each.least < found.effort.level
            assert each.task not in TAKE_AWAY
        assert [each.least for each in found.tasks] == sorted(each.least for each in found.tasks)
        for helper in found.helpers:
            assert helper.name != found.effort.agent
            assert helper.grasping.is_known_to_do


def test_a_task_that_wants_no_effort_lower_is_not_offered() -> None:
    away = [each for each in clauses() if each.task in TAKE_AWAY]
    assert {each.task for each in away} == TAKE_AWAY
    found = offers_for(room(), "P2", "cup", "reach", away)
    assert (found.tasks, found.helpers, found.declined) == ((), (), "no task")


def test_the_stage_shows_the_same_state_afterwards() -> None:
    before = room().state
    offered("P2", "bottle", "reach")
    assert room().state is before


# --- One clause, from every level.


def literal(node: str, value: str) -> Literal:
    found = STANDARD_TREE.node(node)
    return Literal(node, found.title, value, found.instant)


def start(ability: Ability, level: int) -> dict[str, Observation[Raw]]:
    return {f"{ability}.effort": Observation(LADDERS[ability][level])}


def clause(*literals: Literal, always: tuple[Literal, ...] = (), usual: tuple[Literal, ...] = ()) -> Clause:
    return Clause("help", literals, always=always, usual=usual)


@pytest.mark.parametrize("ability", ABILITIES)
@pytest.mark.parametrize("level", range(6))
def test_what_becomes_easier_falls_below_the_level_now(ability: Ability, level: int) -> None:
    easier = clause(literal(f"{ability}.class", "Becomes_Easier"))
    found = lowering(easier, start(ability, level), ability, level, STANDARD_TREE)
    assert (found and found.level) == (level - 1 if level else None)
    for value in ("Becomes_Difficult", "Remains_Same"):
        other = clause(literal(f"{ability}.class", value))
        assert lowering(other, start(ability, level), ability, level, STANDARD_TREE) is None


@pytest.mark.parametrize("level", range(6))
def test_what_becomes_no_harder_need_not_fall(level: int) -> None:
    supportive = clause(literal("reach.nature", "Supportive"))
    assert lowering(supportive, start("reach", level), "reach", level, STANDARD_TREE) is None


@pytest.mark.parametrize("level", range(6))
@pytest.mark.parametrize("final", range(6))
def test_a_final_level_is_offered_where_it_is_less(level: int, final: int) -> None:
    ends = clause(literal("reach.effort.2", REACH_EFFORTS[final]))
    found = lowering(ends, start("reach", level), "reach", level, STANDARD_TREE)
    assert (found and found.level) == (final if final < level else None)


def test_what_was_always_so_stands_apart_and_what_is_usual_promises_nothing() -> None:
    easier, arm = literal("reach.class", "Becomes_Easier"), literal("reach.effort.2", "Arm_Effort")
    begin = start("reach", 4)
    both = lowering(clause(easier, always=(arm,)), begin, "reach", 4, STANDARD_TREE)
    assert both is not None
    assert (both.level, both.level_in_all, both.least) == (3, 1, 1)
    usual = lowering(clause(easier, usual=(arm,)), begin, "reach", 4, STANDARD_TREE)
    assert usual is not None
    assert (usual.level, usual.level_in_all) == (3, None)
    alone = lowering(clause(literal("reach.nature", "Supportive"), always=(arm,)), begin, "reach", 4, STANDARD_TREE)
    assert alone is not None
    assert (alone.level, alone.level_in_all) == (None, 1)


def test_a_task_that_cannot_be_done_from_here_is_not_offered() -> None:
    begin = start("reach", 3) | start("see", 0)
    easier = clause(literal("reach.class", "Becomes_Easier"), literal("see.class", "Becomes_Easier"))
    assert lowering(easier, begin, "reach", 3, STANDARD_TREE) is None
    assert lowering(easier, begin | start("see", 1), "reach", 3, STANDARD_TREE) is not None


# --- Rooms: a cup behind a wall, a cup in somebody's hand, people who would have as far to go.

WALL = box("wall", 0.0, 0.0, 0.87, (0.02, 0.3, 0.15))
SITTER = agent("P2", -0.85, 0.0, posture="sitting")


def test_behind_a_wall_who_stands_on_the_other_side_could_show_it() -> None:
    opposite = agent("P1", 0.75, 0.0, yaw_deg=180)
    stage = Stage(scene(TABLE, CHAIR, WALL, cylinder("cup", 0.2, 0.0, 0.77), agents=SITTER + opposite))
    found = offers_for(stage, "P2", "cup", "see", clauses())
    assert found.effort.level is not None
    assert found.effort.level >= 2
    assert "show" in {each.task for each in found.tasks}
    assert [(each.name, each.robot) for each in found.helpers] == [("P1", False)]
    assert offers_for(stage, "P1", "cup", "see", clauses()).declined == "own act"


def test_whose_hand_is_on_its_way_leans_along() -> None:
    found = offers_for(room(), "P2", "cup", "reach", clauses(), under_way=True)
    assert (found.effort.level, found.declined, found.tasks) == (2, "own act", ())


def test_people_who_would_have_as_far_to_go_are_not_named() -> None:
    far = agent("P1", -3.5, 0.0, yaw_deg=180)
    stage = Stage(scene(TABLE, CHAIR, cylinder("cup", 0.35, 0.0, 0.77), agents=SITTER + far))
    found = offers_for(stage, "P2", "cup", "reach", clauses())
    assert found.tasks
    assert (found.helpers, found.unknown_helpers, found.declined) == ((), (), "nobody")


def test_of_whom_it_is_unknown_is_told_as_such() -> None:
    opposite = agent("P1", 0.75, 0.0, yaw_deg=180)
    stage = Stage(scene(TABLE, CHAIR, cylinder("cup", 0.35, 0.0, 0.77), agents=SITTER + opposite))
    state = stage.state
    stage.show(replace(state, untracked=state.untracked | {"P1"}))
    found = offers_for(stage, "P2", "cup", "reach", clauses())
    assert (found.helpers, found.unknown_helpers) == ((), ("P1",))
    stage.show(replace(state, untracked=state.untracked | {"cup"}))
    assert offers_for(stage, "P2", "cup", "reach", clauses()).declined == "unknown effort"


def test_bad_input_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="P9"):
        offers_for(room(), "P9", "cup", "reach", clauses())
    with pytest.raises(UnknownNameError, match="mug"):
        offers_for(room(), "P2", "mug", "reach", clauses())
    own = replace(clauses()[0], tree_of="performer")
    with pytest.raises(InputError, match="helps nobody else"):
        offers_for(room(), "P2", "cup", "reach", [own])
