"""In furnished rooms: more effort never loses an ability, and nothing moves that an effort level leaves alone."""

import math
from functools import cache

import pytest

from taskgist.perspective import ABILITIES, Effort, Viewpoint, able, effort_from, least_effort
from taskgist.world import Agent, posture_of
from tests.perspective.random_rooms import Case, random_case
from tools.rooms import COARSE, Person, Room, Thing

SEEDS = range(40, 52)
HEAD, TORSO = {"head_pan", "head_tilt"}, {"torso_turn", "torso_lean"}
MOVES: dict[str, tuple[set[str], ...]] = {
    "see": (set(), HEAD, HEAD | TORSO, HEAD | TORSO, HEAD | {"torso_lean"}, set()),
    "reach": (set(), set(), TORSO, TORSO, {"torso_lean"}, set()),
}


@cache
def efforts(seed: int) -> tuple[Case, tuple[Effort, ...]]:
    case = random_case(seed)
    stage = case.stage()
    here = Viewpoint(stage, "P1", COARSE)
    return case, tuple(effort_from(here, name, ability) for name in case.scene.objects for ability in ABILITIES)


def now_rad(case: Case, agent: Agent) -> dict[str, float]:
    return {name: float(case.state.qpos[index]) for name, index in agent.joints.items()}


@pytest.mark.parametrize("seed", SEEDS)
def test_no_joint_moves_but_those_of_the_level(seed: int) -> None:
    case, found = efforts(seed)
    now = now_rad(case, case.scene.agent("P1"))
    for effort in found:
        moved = {name for name, angle in effort.joints_rad.items() if abs(angle - now[name]) > 1e-9}
        if effort.level is None:
            assert not moved
        else:
            assert moved <= MOVES.get(effort.ability, MOVES["reach"])[effort.level], effort


@pytest.mark.parametrize("seed", SEEDS)
def test_attained_angles_are_within_the_joints(seed: int) -> None:
    case, found = efforts(seed)
    profile, now = case.scene.agent("P1").profile, now_rad(case, case.scene.agent("P1"))
    axes = [axis for axis in (profile.pan, profile.tilt, profile.turn, profile.lean) if axis]
    for effort in found:
        for axis in axes:
            low, high = min(axis.range_rad[0], now[axis.joint]), max(axis.range_rad[1], now[axis.joint])
            assert low - 1e-9 <= effort.joints_rad[axis.joint] <= high + 1e-9


@pytest.mark.parametrize("seed", SEEDS)
def test_the_posture_changes_from_level_three_on_only(seed: int) -> None:
    case, found = efforts(seed)
    stage = case.stage()
    before = posture_of(stage, stage.scene.agent("P1"), COARSE.contact)
    for effort in found:
        if effort.level in (0, 1, 2, 5):
            assert effort.posture == before
        elif effort.level == 3:
            assert effort.posture != before or {"Bend_Hips", "Crouch"} & set(effort.actions)
        elif effort.level == 4:
            assert effort.posture == "standing"


@pytest.mark.parametrize("seed", SEEDS[:4])
def test_who_is_able_with_some_effort_is_able_with_more(seed: int) -> None:
    case, found = efforts(seed)
    stage = case.stage()
    for effort in found:
        if effort.level is not None:
            able_at = [
                able(stage, "P1", effort.target, effort.ability, max_level=most, settings=COARSE) for most in range(5)
            ]
            assert able_at == [effort.level <= most for most in range(5)], effort


def test_the_rooms_above_have_all_levels() -> None:
    levels = {(effort.ability, effort.level) for seed in SEEDS for effort in efforts(seed)[1]}
    assert {level for ability, level in levels if ability == "see"} >= {0, 1, 2, 4, 5}
    assert {level for ability, level in levels if ability == "reach"} >= {1, 2, 4, 5}


@pytest.mark.parametrize(("turned_deg", "sees"), [(0, "front"), (90, "left"), (180, "back"), (-90, "right")])
def test_who_turns_the_head_sees_other_things(turned_deg: int, sees: str) -> None:
    """The angles are the tracker's: whether a neck can do it is for the next virtual action to ask."""
    things = {
        name: Thing(name, (0.1,), (1.5 * math.cos(angle), 1.5 * math.sin(angle), 1.6), "sphere")
        for name, angle in (("front", 0.0), ("left", math.pi / 2), ("back", math.pi), ("right", -math.pi / 2))
    }
    stage = Room(tuple(things.values()), (Person("P1", (0.0, 0.0)),)).stage()
    pan = stage.scene.agent("P1").joints["head_pan"]
    stage.show(stage.scene.initial.replace({pan: math.radians(turned_deg)}))
    levels = {name: least_effort(stage, "P1", name, "see").level for name in things}
    assert [name for name, level in levels.items() if level == 0] == [sees]
    assert all(level for name, level in levels.items() if name != sees)
    aside = levels["left" if sees in ("front", "back") else "front"]
    assert aside is not None


def test_a_head_that_looks_back_comes_back_to_its_range_only() -> None:
    ball = Thing("ball", (0.1,), (0.0, 1.5, 1.6), "sphere")
    stage = Room((ball,), (Person("P1", (0.0, 0.0)),)).stage()
    pan = stage.scene.agent("P1").joints["head_pan"]
    stage.show(stage.scene.initial.replace({pan: math.radians(-150)}))
    found = least_effort(stage, "P1", "ball", "see")
    assert found.level is not None
    assert found.level >= 2
    assert math.degrees(found.joints_rad["head_pan"]) <= 60 + 1e-6
