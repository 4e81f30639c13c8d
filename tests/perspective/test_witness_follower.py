"""Who follows a tracker knows in every frame what a fresh look at it would find."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from taskgist.perspective import scene_efforts as everyone
from taskgist.perspective.effort import ABILITIES
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.settings import DEFAULT, Following
from taskgist.world import Scene, Stage, State
from taskgist_lab.ordinary.furniture import sofa
from taskgist_lab.ordinary.rooms import scene_of
from tests.ordinary import a, block, board, sits, stands
from tests.perspective.comparing import EXACT as COARSE
from tests.perspective.comparing import FRAMES, compare_following, frames
from tests.perspective.random_rooms import Case, random_case
from tools.rooms import COARSE as SETTINGS
from tools.rooms import Person, Room, Thing


def test_following_finds_what_a_fresh_look_finds() -> None:
    """In a room; ``make twins`` compares it in hundreds."""
    found = compare_following(random_case(503, image_px=(48, 36)))
    assert found.count > 100
    assert not found.differences


def test_noise_is_followed_as_the_states_that_it_was_taken_for() -> None:
    """With noise on everything, one agent and one object moving: as a fresh look at what the state was taken for."""
    case = random_case(501, image_px=(48, 36), untracked=False)
    follower, rng, scene = SceneEfforts(Stage(case.scene, case.state), SETTINGS), np.random.default_rng(1), case.scene
    follower.all()
    agent, asked = scene.agent(scene.agents[0]), list[int]()
    for frame in range(1, 7):
        qpos = trembling(case, rng)
        if frame > 3:
            qpos[agent.base][0] += 0.03 * (frame - 3)
            qpos[scene.object_slice(scene.objects[0])][2] += 0.03 * (frame - 3)
        follower.update(State(qpos, time_s=frame / 30))
        assert follower.all() == SceneEfforts(Stage(scene, follower.state), SETTINGS).all()
        asked.append(follower.asked_count)
    assert asked[:3] == [0, 0, 0]
    assert min(asked[3:]) > 0


def trembling(case: Case, rng: np.random.Generator) -> np.ndarray:
    """The case's positions with a tracker's noise."""
    qpos = np.array(case.state.qpos)
    for name in case.scene.agents:
        qpos[case.scene.joint_indices(name)] += rng.normal(0.0, math.radians(0.2), len(case.scene.joints(name)))
    bases = [case.scene.base_slice(name) for name in case.scene.agents]
    for at in (*bases, *map(case.scene.object_slice, case.scene.objects)):
        qpos[at][:3] += rng.normal(0.0, 0.0005, 3)
        qpos[at][3:] += rng.normal(0.0, math.radians(0.1), 4)
        qpos[at][3:] /= np.linalg.norm(qpos[at][3:])
    return qpos


def test_within_a_time_what_changed_is_found_the_oldest_first() -> None:
    case = random_case(502, image_px=(48, 36), untracked=False)
    follower, agent = SceneEfforts(Stage(case.scene, case.state), COARSE), case.scene.agent(case.scene.agents[0])
    first = follower.latest(0.0)
    assert all(each.time_s == case.state.time_s for each in first.values())
    base = np.array(case.state.qpos[agent.base]) + (0.03, 0, 0, 0, 0, 0, 0)
    moved = State(case.state.replace(at=agent.base, to=base).qpos, time_s=1.0)
    follower.update(moved)
    late = follower.latest(0.0)
    assert {late[question].time_s for question in late if question[0] == agent.name} == {case.state.time_s}
    assert all(late[question].effort is first[question].effort for question in late if question[0] == agent.name)
    in_time, fresh = follower.latest(60.0), SceneEfforts(Stage(case.scene, moved), COARSE).all()
    assert {question: each.effort for question, each in in_time.items()} == fresh
    assert {each.time_s for each in in_time.values()} == {1.0}


def test_efforts_stay_what_they_are_whatever_comes_later() -> None:
    case = random_case(502, image_px=(48, 36))
    follower = SceneEfforts(Stage(case.scene, case.state), COARSE)
    first = follower.all()
    follower.update(case.state)
    told = {question: effort.evidence for question, effort in follower.all().items()}
    for state in frames(case):
        follower.update(state)
        follower.all()
    fresh = SceneEfforts(Stage(case.scene, case.state), COARSE).all()
    assert {question: effort.evidence for question, effort in first.items()} == told
    assert {question: effort.evidence for question, effort in fresh.items()} == told


def test_what_interrupts_a_frame_does_no_harm(monkeypatch: pytest.MonkeyPatch) -> None:
    case = random_case(503, image_px=(48, 36))
    states = list(frames(case))
    follower = SceneEfforts(Stage(case.scene, states[0]), COARSE)
    follower.all()

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(everyone, "effort_from", interrupted)
        follower.update(states[2])
        with pytest.raises(KeyboardInterrupt):
            follower.all()
    follower.update(states[3])
    assert follower.all() == SceneEfforts(Stage(case.scene, states[3]), COARSE).all()


@pytest.mark.parametrize("calls", range(2))
def test_what_interrupts_going_on_to_a_frame_does_no_harm(calls: int, monkeypatch: pytest.MonkeyPatch) -> None:
    case = random_case(503, image_px=(48, 36))
    states, left = list(frames(case)), [calls]
    follower = SceneEfforts(Stage(case.scene, states[0]), COARSE)
    follower.all()
    show = Stage.show

    def interrupted(stage: Stage, state: State) -> Stage:
        left[0] -= 1
        if left[0] < 0:
            raise KeyboardInterrupt
        return show(stage, state)

    with monkeypatch.context() as patched:
        patched.setattr(Stage, "show", interrupted)
        with pytest.raises(KeyboardInterrupt):
            follower.update(states[2])
    assert follower.all() == SceneEfforts(Stage(case.scene, states[2]), COARSE).all()
    follower.update(states[3])
    assert follower.all() == SceneEfforts(Stage(case.scene, states[3]), COARSE).all()


def test_a_frame_in_which_nothing_moves_asks_nothing() -> None:
    case = random_case(501, image_px=(48, 36), untracked=False)
    follower = SceneEfforts(Stage(case.scene, case.state), COARSE)
    first = follower.all()
    assert follower.asked_count == len(first)
    follower.update(case.state)
    assert follower.all() == first
    assert follower.asked_count == 0


def test_what_happens_far_away_is_not_asked_again() -> None:
    cups = tuple(Thing(f"cup {n}", (0.03, 0.05), (8.0 * n + 0.5, 0.1, 1.1), "cylinder") for n in range(2))
    people = (Person("P1", (0.0, 0.0), math.pi / 2), Person("P2", (8.0, 0.0), math.pi / 2))
    scene = Room(cups, people, (48, 36)).scene()
    follower = SceneEfforts(Stage(scene), COARSE)
    follower.all()
    place = scene.initial.qpos[scene.object_slice("cup 1")] + (0.02, 0, 0, 0, 0, 0, 0)
    state = scene.initial.replace(at=scene.object_slice("cup 1"), to=place)
    follower.update(state)
    assert follower.all() == SceneEfforts(Stage(scene, state), COARSE).all()
    assert follower.asked_count < 12


@pytest.mark.parametrize("axis", range(3))
def test_a_thing_that_comes_near_to_what_is_grasped_is_noticed(axis: int) -> None:
    """A board is moved towards a cup from one side, in steps, until it touches it."""
    board = Thing("board", (0.15, 0.15, 0.15), (3.0, 3.0, 1.1))
    cup = Thing("cup", (0.03, 0.05), (0.5, 0.1, 1.1), "cylinder")
    scene = Room((cup, board), (Person("P1", (0.0, 0.0)),), (48, 36)).scene()
    follower, found = SceneEfforts(Stage(scene), COARSE), set()
    for away_m in (1.0, 0.6, 0.4, 0.3, 0.25, 0.22, 0.2, 0.19, 0.18, 0.3, 2.0):
        place = np.array((0.5, 0.1, 1.1, 1.0, 0.0, 0.0, 0.0))
        place[axis] += away_m
        state = scene.initial.replace(at=scene.object_slice("board"), to=place)
        follower.update(state)
        assert follower.all() == SceneEfforts(Stage(scene, state), COARSE).all()
        effort = follower.effort("P1", "cup", "grasp")
        found.add((effort.level, effort.evidence.attained))
        assert effort.evidence == SceneEfforts(Stage(scene, state), COARSE).effort("P1", "cup", "grasp").evidence
    assert len(found) > 1


def test_efforts_by_some_actions_are_followed_too() -> None:
    case = random_case(504, image_px=(48, 36))
    follower, actions = SceneEfforts(Stage(case.scene, case.state), COARSE), ("Pan_Head", "Lean_Torso")
    agent, compared = case.scene.agents[0], 0
    for state in frames(case):
        follower.update(state)
        fresh = SceneEfforts(Stage(case.scene, state), COARSE)
        for ability in ("see", "reach"):
            assert follower.efforts_with(agent, ability, actions) == fresh.efforts_with(agent, ability, actions)
            compared += 1
    assert compared == 2 * (FRAMES + 1)


SIZED = replace(DEFAULT.efforts, move_radius_m=2.0)
EXACT = replace(DEFAULT, following=Following(place_m=0.0, turn_rad=0.0), efforts=SIZED)
LEGS, CRATE, BOOK, CUP = ("left leg", "right leg"), "crate", "book", "cup"
LEFT, RIGHT, FAR = (0.64, 0.57, 0.19), (0.64, -0.57, 0.19), (8.0, 8.0, 1.0)
SHUT_IN: tuple[tuple[str, str, tuple[float, float, float]], ...] = (
    ("the cup is moved", CUP, (2.4, -0.7, 0.05)),
    ("somebody walks by", "P2", (1.9, 1.2, 0.0)),
    ("somebody stands in the way out", "P2", (0.6, -1.1, 0.0)),
    ("somebody is gone again", "P2", (3.0, 3.0, 0.0)),
    ("a crate at one end of the table", CRATE, (0.75, -1.0, 0.45)),
    ("and at the other", CRATE, (0.75, 1.0, 0.45)),
    ("and behind the table", CRATE, (1.6, 0.0, 0.45)),
    ("what lay on the lap is on the floor", BOOK, (1.9, 0.5, 0.02)),
    ("a leg of the table less", LEGS[1], FAR),
    ("and the other", LEGS[0], (8.0, 8.0, 3.0)),
    ("the crate is before the knees", CRATE, (0.95, 0.0, 0.45)),
    ("and on the sofa", CRATE, (0.0, -0.6, 0.88)),
    ("all is free", CRATE, FAR),
    ("a leg is back", LEGS[0], LEFT),
    ("and the other", LEGS[1], RIGHT),
    ("what lay on the lap is there again", BOOK, (0.3, 0.0, 0.60)),
    ("the crate is on the sofa again", CRATE, (0.0, -0.6, 0.88)),
    ("and somebody at the other end", "P2", (0.6, 1.1, 0.0)),
)
"""What happens around a sofa, its table and who sits between: who or what is put where then, metres."""


def between_sofa_and_table() -> Scene:
    """A room in which who sits is shut in between a sofa and a low table, with a book on the lap."""
    things = {
        LEGS[0]: block((0.05, 0.05, 0.38), *LEFT[:2]),
        LEGS[1]: block((0.05, 0.05, 0.38), *RIGHT[:2]),
        CRATE: block((0.4, 0.5, 0.9), *FAR),
        BOOK: a("book", 0.3, 0.0, 0.585),
        CUP: a("cup", 2.5, -0.6, 0.0),
    }
    pieces = (sofa("sofa", (0.0, 0.0)), board("top", (0.5, 1.2, 0.04), 0.86, 0.0, 0.40))
    people = (sits(0.05), replace(stands(3.0, 3.0), name="P2"))
    return scene_of("sofa", pieces, [replace(thing, name=name) for name, thing in things.items()], people)


def carried(scene: Scene, state: State, name: str, place: tuple[float, float, float]) -> Iterator[State]:
    """The states on the way of a thing, or of an agent, to another place: lifted, over there, and put down."""
    at = scene.base_slice(name) if name in scene.agents else scene.object_slice(name)
    start, end = np.array(state.qpos[at]), np.array(state.qpos[at])
    end[: 2 if name in scene.agents else 3] = place[: 2 if name in scene.agents else 3]
    for there in (start + ABOVE, end + ABOVE, end):
        yield state.replace(at=at, to=there)


ABOVE = np.array((0.0, 0.0, 6.0, 0.0, 0.0, 0.0, 0.0))
"""Nobody notices what moves so high up."""


def test_who_is_shut_in_on_a_sofa_is_followed_whatever_gets_in_the_way() -> None:
    scene = between_sofa_and_table()
    follower, state, kept = SceneEfforts(Stage(scene), EXACT), scene.initial, 0
    ways, starts = set(), set()
    questions = [("P", name, ability) for name in scene.objects for ability in ABILITIES]
    for what, name, place in SHUT_IN:
        on_its_way = tuple(carried(scene, state, name, place))
        for state in on_its_way:
            follower.update(state)
        fresh = SceneEfforts(Stage(scene, state), EXACT)
        for question in questions:
            assert follower.effort(*question) == fresh.effort(*question), (what, question)
        kept += fresh.asked_count - follower.asked_count
        far = follower.effort("P", CUP, "reach")
        ways.add((far.actions, far.amount and far.amount.key))
        starts.add("Move_Along_Seat" in far.actions)
    assert starts == {True, False}
    assert len(ways) >= 3
    assert kept >= len(SHUT_IN)
