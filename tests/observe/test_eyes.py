"""Where eyes look: laws of the turn, which of several things they are at, and what becomes of it in a recording."""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
import pytest

from taskgist.observe import Observer, snapshot
from taskgist.observe.eyes import Use, regarded, turned_towards
from taskgist.perspective import visibility
from taskgist.settings import DEFAULT, Gaze, Settings
from taskgist.world import Fitter, Scene, Stage, State
from taskgist.world.geometry.transforms import Pose, matrix_from_wxyz
from taskgist.world.state import AHEAD, EyeTurn
from tests.observe.states import RATE_HZ, TOP, States, cup_between_two, live

GAZE, RANGE_RAD = DEFAULT.gaze, DEFAULT.gaze.range_rad
HEADS = dataclasses.replace(DEFAULT, gaze=Gaze(inferred=False))
SEEDS = range(20)


def random_pose(random: np.random.Generator) -> Pose:
    wxyz = random.normal(size=4)
    return Pose(random.normal(size=3), matrix_from_wxyz(wxyz / np.linalg.norm(wxyz)))


def angle_rad(one: np.ndarray, other: np.ndarray) -> float:
    return math.acos(float(np.clip(one @ other / np.linalg.norm(one) / np.linalg.norm(other), -1.0, 1.0)))


def gaze_of(scene: Scene, state: State, name: str, turn: EyeTurn) -> np.ndarray:
    """Where an eye looks, a unit vector, once it is turned."""
    return Stage(scene, state.with_eyes({name: turn})).eye(scene.agent(name)).matrix[:, 0]


# --- The turn


@pytest.mark.parametrize("seed", SEEDS)
def test_eyes_never_turn_beyond_their_range_and_get_to_what_lies_within(seed: int) -> None:
    random = np.random.default_rng(seed)
    ahead, point = random_pose(random), random.normal(size=3) * 2
    off_rad = angle_rad(ahead.matrix[:, 0], point - ahead.position)
    turn = turned_towards(ahead, point, "cup", RANGE_RAD)
    assert turn.towards == "cup"
    assert turn.turned_rad == pytest.approx(min(off_rad, RANGE_RAD), abs=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_turned_eyes_are_nearer_to_the_thing_by_as_much_as_they_turn(room: Scene, seed: int) -> None:
    """The turn is a turn straight towards it, in the world and whichever way the head is turned."""
    random = np.random.default_rng(seed)
    joints = {room.agent("P1").joints[f"head_{way}"]: random.uniform(-0.6, 0.6) for way in ("pan", "tilt")}
    state, point = room.initial.replace(joints), random.normal(size=3) * 2
    ahead = Stage(room, state).eye_ahead(room.agent("P1"))
    turn = turned_towards(ahead, point, "cup", RANGE_RAD)
    before_rad = angle_rad(ahead.matrix[:, 0], point - ahead.position)
    after_rad = angle_rad(gaze_of(room, state, "P1", turn), point - ahead.position)
    assert after_rad == pytest.approx(max(before_rad - RANGE_RAD, 0.0), abs=1e-6)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_thing_that_moves_a_little_turns_the_eyes_a_little(seed: int) -> None:
    """But for what is just behind the head, where the shorter way changes sides."""
    random = np.random.default_rng(seed)
    ahead, point = random_pose(random), random.normal(size=3)
    near = point + random.normal(size=3) * 1e-5
    if ahead.to_local(point)[0] < -0.9 * np.linalg.norm(point - ahead.position):
        point = near = 2 * ahead.position - point
    one, other = (turned_towards(ahead, each, "cup", RANGE_RAD) for each in (point, near))
    moved_rad = angle_rad(point - ahead.position, near - ahead.position)
    apart_rad = math.hypot(one.left_rad - other.left_rad, one.up_rad - other.up_rad)
    assert apart_rad <= 3 * moved_rad + 1e-9


def test_what_is_ahead_or_straight_behind_turns_no_eye() -> None:
    ahead = Pose(np.zeros(3), np.eye(3))
    for x in (1.0, -1.0):
        assert turned_towards(ahead, np.array([x, 0, 0]), "cup", RANGE_RAD) == EyeTurn(0.0, 0.0, "cup")


def test_left_is_left_and_up_is_up(room: Scene) -> None:
    eye = Stage(room).eye(room.agent("P1"))
    left = gaze_of(room, room.initial, "P1", EyeTurn(left_rad=0.3))
    up = gaze_of(room, room.initial, "P1", EyeTurn(up_rad=0.3))
    assert eye.matrix.T @ left == pytest.approx([math.cos(0.3), math.sin(0.3), 0], abs=1e-9)
    assert eye.matrix.T @ up == pytest.approx([math.cos(0.3), 0, math.sin(0.3)], abs=1e-9)


# --- Which thing


def test_without_hands_at_anything_eyes_are_at_nothing() -> None:
    assert regarded(1.0, [], GAZE) is None
    assert regarded(1.0, [Use("cup", 1.6, 2.0), Use("mug", 0.0, 0.9)], GAZE) is None


@pytest.mark.parametrize(("time_s", "thing"), [(2.4, "tray"), (2.5, "cup"), (3.0, "cup"), (5.0, "cup"), (5.1, "tray")])
def test_eyes_go_on_to_what_is_taken_next(time_s: float, thing: str) -> None:
    assert regarded(time_s, [Use("tray", 0.0, 9.0), Use("cup", 3.0, 5.0)], GAZE) == thing


@pytest.mark.parametrize("seed", SEEDS)
def test_of_several_things_it_is_the_nearest_in_time_in_whatever_order_they_are_told(seed: int) -> None:
    random = np.random.default_rng(seed)
    starts_s = random.uniform(0, 4, size=4)
    uses = [Use(f"thing{number}", start_s, start_s + 3) for number, start_s in enumerate(starts_s.tolist())]
    time_s = random.uniform(0, 6)
    at = [use for use in uses if use.start_s - 0.5 <= time_s <= use.end_s]
    found = regarded(time_s, uses, GAZE)
    assert found == (min(at, key=lambda use: abs(use.start_s - time_s)).thing if at else None)
    assert regarded(time_s, uses[::-1], GAZE) == found


# --- Over time

TAKEN_S, LEFT_S = 1.5, 2.5


@pytest.fixture(scope="module")
def room() -> Scene:
    return cup_between_two()


@pytest.fixture(scope="module")
def carried(room: Scene) -> list[State]:
    """P1's hand waits far from the cup, is there at once, carries it off to the right, and leaves it in the air."""
    fitter = Fitter(room, "P1", moving="arms", weights={"right_palm": 3.0})
    arm = room.agent("P1").arm("right")
    cup, states, state = np.array([-0.25, -0.15, TOP + 0.05]), list[State](), room.initial
    for frame in range(int(4 * RATE_HZ)):
        time_s = frame / RATE_HZ
        held = TAKEN_S <= time_s < LEFT_S
        share = np.clip(time_s - TAKEN_S, 0, 1)
        target = np.array([-0.27, -0.16 - 0.25 * share, TOP + 0.08 + 0.15 * share]) if held else (-0.6, -0.5, 1.3)
        state = fitter.fit(state, points={"right_palm": np.array(target)}).state
        if held:
            cup = Stage(room, state).site(arm.palm_site).position + (0.02, 0.01, -0.03)
        states.append(State(state.replace(at=room.object_slice("cup"), to=(*cup, 1, 0, 0, 0)).qpos, time_s))
    return states


def eyes(room: Scene, states: Sequence[State], settings: Settings = DEFAULT) -> list[dict[str, EyeTurn]]:
    observer = Observer(room, States(states), settings)
    return [dict(observer.as_confirmed(state).eyes) for state in states]


def test_eyes_are_at_the_thing_from_half_a_second_before_it_is_held_until_it_is_let_go(
    room: Scene, carried: list[State]
) -> None:
    observer = Observer(room, States(carried))
    (held,) = [each for each in observer.hand("P1", "right").intervals if each.value.symbol == "Holding_Object"]
    at = [state.time_s for state, turns in zip(carried, eyes(room, carried), strict=True) if "P1" in turns]
    assert at[0] == pytest.approx(held.start_s - GAZE.before_s, abs=1e-6)
    assert held.end_s - 0.5 / RATE_HZ <= at[-1] + 1 / RATE_HZ <= held.end_s + 1.5 / RATE_HZ
    assert len(at) == round((at[-1] - at[0]) * RATE_HZ) + 1
    assert all("P2" not in turns for turns in eyes(room, carried)), "P2's hands do nothing"


def test_eyes_are_at_what_a_hand_pushes_along_a_table_and_not_at_what_it_lies_beside(room: Scene) -> None:
    """For a second the hand and the cup move along together, and the cup never leaves the table; then both stay."""
    fitter, states, state = Fitter(room, "P1", moving="arms", weights={"right_palm": 3.0}), list[State](), room.initial
    arm = room.agent("P1").arm("right")
    for frame in range(int(3 * RATE_HZ)):
        time_s = frame / RATE_HZ
        along_m = 0.2 * np.clip(time_s - 1.0, 0, 1)
        state = fitter.fit(state, points={"right_palm": np.array([-0.3, -0.25 + along_m, TOP + 0.08])}).state
        palm = Stage(room, state).site(arm.palm_site).position
        state = state.replace(at=room.object_slice("cup"), to=(palm[0] + 0.02, palm[1] + 0.05, TOP + 0.05, 1, 0, 0, 0))
        states.append(State(state.qpos, time_s))
    observer = Observer(room, States(states))
    assert {each.value.symbol for each in observer.placement("cup").intervals} == {"On_Support"}
    at = [state.time_s for state, turns in zip(states, eyes(room, states), strict=True) if "P1" in turns]
    moving = [each for each in observer.motion("cup").intervals if each.value == "Moving"]
    assert at[0] == pytest.approx(moving[0].start_s - GAZE.before_s, abs=1e-6)
    assert at[-1] + 1 / RATE_HZ == pytest.approx(moving[-1].end_s, abs=1e-6)


def test_whenever_it_is_asked_first_it_is_the_same(room: Scene, carried: list[State]) -> None:
    observer = Observer(room, States(carried))
    assert [dict(observer.as_confirmed(state).eyes) for state in reversed(carried)] == eyes(room, carried)[::-1]


def test_live_it_is_the_same_once_it_is_settled(room: Scene, carried: list[State]) -> None:
    whole = eyes(room, carried)
    delay = int(RATE_HZ * 2.0)
    for count in range(delay + 10, len(carried), 7):
        observer = live(room, carried[:count])
        state = carried[count - delay]
        assert dict(observer.as_confirmed(state).eyes) == whole[count - delay]


def test_nobody_who_takes_nothing_is_looked_at_otherwise_than_by_the_head(room: Scene, carried: list[State]) -> None:
    still = [State(carried[0].qpos, state.time_s) for state in carried]
    assert eyes(room, still) == [{}] * len(still)


def test_a_setting_goes_back_to_heads_alone(room: Scene, carried: list[State]) -> None:
    assert eyes(room, carried, HEADS) == [{}] * len(carried)
    assert HEADS.digest != DEFAULT.digest


def test_a_recorded_gaze_stands_above_all(room: Scene, carried: list[State]) -> None:
    recorded = {"P1": AHEAD, "P2": EyeTurn(0.2, -0.1)}
    told = [state.with_eyes(recorded) for state in carried]
    assert eyes(room, told) == [recorded] * len(told)
    assert eyes(room, told, HEADS) == [recorded] * len(told)


@pytest.mark.parametrize("lost", ["P1/head", "P1/right_arm", "cup"])
def test_nothing_is_assumed_of_what_is_not_known(room: Scene, carried: list[State], lost: str) -> None:
    unknown = [State(state.qpos, state.time_s, frozenset({lost})) for state in carried]
    assert eyes(room, unknown) == [{}] * len(unknown)


def test_what_was_assumed_is_in_the_evidence(room: Scene, carried: list[State]) -> None:
    state = carried[int(2.0 * RATE_HZ)]
    turn = Observer(room, States(carried)).as_confirmed(state).eyes["P1"]
    assert turn.turned_rad > math.radians(10)
    found = snapshot(Stage(room, state), Observer(room, States(carried)), agent="P1", name="cup")
    for attribute in ("see.effort", "visibility.score"):
        evidence = found[attribute].evidence
        assert (evidence["eyes_towards"], evidence["eyes_rad"]) == ("cup", turn.turned_rad)
    degrees = round(math.degrees(turn.turned_rad))
    assert f"the eyes assumed to turn {degrees}° towards the cup" in str(found["see.effort"].evidence["reason"])


def test_who_takes_it_sees_it_though_the_head_looks_past_it(room: Scene, carried: list[State]) -> None:
    joints, head = room.agent("P1").joints, {"head_pan": 0.35, "head_tilt": -0.4}
    looking = [state.replace({joints[name]: angle for name, angle in head.items()}) for state in carried]
    state = looking[int(2.0 * RATE_HZ)]
    seen = visibility(Stage(room, state), "P1", "cup")
    assert seen is not None
    assert math.radians(35) < seen.off_gaze_rad < math.radians(60)
    told = {}
    for settings in (DEFAULT, HEADS):
        observer = Observer(room, States(looking), settings)
        found = snapshot(Stage(room, state), observer, agent="P1", name="cup", settings=settings)
        told[settings.gaze.inferred] = found["see.effort"].value
    assert told == {True: "No_Effort_Required", False: "Head_Effort"}
