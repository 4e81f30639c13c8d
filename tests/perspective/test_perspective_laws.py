"""Laws that hold in every room."""

import math
from dataclasses import replace

import pytest
from hypothesis import given, seed, settings
from hypothesis import strategies as st

from taskgist.perspective import ABILITIES, Effort, Viewpoint, able, effort_from, least_effort, visibility
from taskgist.perspective.effort import Occlusion
from tools.rooms import COARSE, Person, Room, Thing, chair, random_room, table, wall

FEW = settings(max_examples=5, deadline=None, derandomize=True, database=None)
SIDES = {"left": "right", "right": "left"}


def efforts(room: Room) -> dict[tuple[str, str], Effort]:
    stage = room.stage()
    here = Viewpoint(stage, "P1", COARSE)
    return {(name, ability): effort_from(here, name, ability) for name in stage.scene.objects for ability in ABILITIES}


def symbols(effort: Effort) -> tuple[object, ...]:
    return effort.level, effort.actions, effort.amount and effort.amount.key, effort.posture


@seed(1)
@FEW
@given(
    st.integers(0, 40),
    st.floats(-math.pi, math.pi),
    st.floats(-3, 3),
    st.floats(-3, 3),
)
def test_moving_and_turning_the_whole_room_changes_nothing(number: int, yaw: float, x: float, y: float) -> None:
    room = random_room(number)
    before, after = efforts(room), efforts(room.moved(yaw, x, y))
    assert {key: symbols(effort) for key, effort in before.items()} == {
        key: symbols(effort) for key, effort in after.items()
    }


@pytest.mark.parametrize("number", range(10, 16))
def test_moving_and_turning_the_whole_room_changes_no_pixel(number: int) -> None:
    """Rays that graze an outline within rounding would; in rooms at random there are none."""
    room = random_room(number, image_px=(320, 240))
    stage, moved = room.stage(), room.moved(1.1 * number, 2.0, -1.0).stage()
    for name in stage.scene.objects:
        before, after = visibility(stage, "P1", name), visibility(moved, "P1", name)
        assert before is not None
        assert after is not None
        assert (before.visible_px, before.occluders) == (after.visible_px, after.occluders)


@pytest.mark.parametrize("number", range(6))
def test_a_mirrored_room_mirrors_arms_and_keeps_efforts(number: int) -> None:
    room = random_room(number)
    mirrored = mirror_joints(room.mirrored())
    before, after = efforts(room), efforts(mirrored)
    for key, effort in before.items():
        assert symbols(effort)[::2] == symbols(after[key])[::2], key
        assert mirror_names(effort.actions) == after[key].actions, key
        if "arm" in effort.evidence_document:
            assert SIDES[str(effort.evidence_document["arm"])] == after[key].evidence_document["arm"]


def mirror_joints(room: Room) -> Room:
    people = []
    for person in room.people:
        joints = tuple((j, angle if j == "head_tilt" else -angle) for j, angle in person.joints_deg)
        people.append(replace(person, joints_deg=joints))
    return replace(room, people=tuple(people))


def mirror_names(actions: tuple[str, ...]) -> tuple[str, ...]:
    swap = {f"Stretch_Out_Arm({side})": f"Stretch_Out_Arm({other})" for side, other in SIDES.items()}
    return tuple(swap.get(action, action) for action in actions)


@pytest.mark.parametrize("number", range(4))
def test_more_effort_never_loses_an_ability(number: int) -> None:
    stage = random_room(number).stage()
    for ability in ABILITIES:
        answers = [able(stage, "P1", "brick", ability, max_level=level, settings=COARSE) for level in range(5)]
        assert answers == sorted(answers, key=bool)
        level = least_effort(stage, "P1", "brick", ability, COARSE).level
        assert level is not None
        assert answers == [each >= level for each in range(5)]


@seed(2)
@FEW
@given(st.floats(0.7, 2.5), st.floats(-1.0, 1.0), st.floats(0.1, 2.2), st.floats(-math.pi, math.pi))
def test_nobody_sees_through_a_wall(x: float, y: float, z: float, yaw: float) -> None:
    """The wall is wider and higher than anybody could look past."""
    cup = Thing("cup", (0.05, 0.05, 0.05), (0.6 + x, y, z))
    room = Room((wall("wall", 0.6, half=(0.02, 6.0, 3.0)), cup), (Person("P1", (0, 0)),), (64, 48)).moved(yaw, 1.0, 2.0)
    stage = room.stage()
    seen = visibility(stage, "P1", "cup")
    assert seen is not None
    assert seen.visible_px == 0
    assert {owner for owner, _ in seen.occluders} <= {"wall", "P1"}
    assert least_effort(stage, "P1", "cup", "see", COARSE).level == 5


def test_asking_changes_no_state() -> None:
    stage = Room((chair(0.0), table(1.1), Thing("cup", (0.03, 0.05), (1.0, 0, 0.77), "cylinder")), (SITTING,)).stage()
    state, before = stage.state, stage.state.qpos.copy()
    shown = stage.geom_centers(range(stage.scene.model.ngeom))
    for ability in ABILITIES:
        least_effort(stage, "P1", "cup", ability, COARSE)
    assert stage.state is state
    assert (state.qpos == before).all()
    assert (stage.geom_centers(range(stage.scene.model.ngeom)) == shown).all()


SITTING = Person("P1", (0.0, 0.0), 0.0, "sitting")


def test_what_hides_an_object_is_told_with_a_ray_to_each() -> None:
    screens = tuple(
        Thing(f"screen {number}", (0.02, 0.5, 0.8), (0.8, y, 0.8), free=False) for number, y in enumerate((-0.5, 0.5))
    )
    cup = Thing("cup", (0.1,), (1.6, 0.0, 0.5), "sphere")
    stage = Room((*screens, cup, chair(0.0)), (Person("P1", (0.0, 0.0), 0.0, "sitting"),)).stage()
    found = effort_from(Viewpoint(stage, "P1", COARSE, actions=("Pan_Head", "Tilt_Head")), "cup", "see")
    assert found.level == 5
    assert found.evidence.told is not None
    miss = found.evidence.told.hindrance
    assert isinstance(miss, Occlusion)
    assert dict(miss.occluders).keys() == {"screen 0", "screen 1"}
    assert sum(dict(miss.occluders).values()) == miss.unoccluded_px > 50
    assert [hit[0] for _, hit in miss.hits_m] == pytest.approx([0.78, 0.78])
    assert miss.eye_m[0] < 0.3
