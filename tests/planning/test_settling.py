import json
import math

import numpy as np
import pytest

from taskgist.errors import UnknownNameError
from taskgist.planning.settling import Settled, settled
from taskgist.settings import DEFAULT
from taskgist.world import Scene, Stage, State, support_of
from tests.scenes import TABLE, agent, box, cylinder, scene

TOP = 0.72
EDGE = 0.4
CUBE = (0.03, 0.03, 0.03)
TALL = (0.02, 0.02, 0.08)


def put(name: str, x: float, z: float, half: tuple[float, float, float], tilt_rad: float = 0.0) -> str:
    """A box put somewhere, tilted about y."""
    turned = f"{math.cos(tilt_rad / 2)} 0 {math.sin(tilt_rad / 2)} 0"
    return box(name, x, 0.0, z, half).replace("><freejoint", f' quat="{turned}"><freejoint')


def let_go(*bodies: str, thing: str = "cube") -> Settled:
    room = scene(TABLE, *bodies)
    return settled(room, room.initial, thing)


def test_a_box_on_a_table_stays() -> None:
    end = let_go(put("cube", 0.1, TOP + 0.03, CUBE))
    assert end.stays
    assert end.rests
    assert end.shift.moved_m < 0.001
    assert end.text == "cube stays where it is put"


def test_a_box_a_little_above_a_table_settles_on_it() -> None:
    end = let_go(put("cube", 0.1, TOP + 0.036, CUBE))
    assert end.stays
    assert end.shift.moved_m == pytest.approx(0.006, abs=0.001)


@pytest.mark.parametrize(("beyond_m", "falls"), [(-0.01, False), (0.012, True)])
def test_a_box_over_an_edge_falls(beyond_m: float, falls: bool) -> None:
    """Its middle is beyond the table's edge, or not."""
    room = scene(TABLE, put("cube", EDGE + beyond_m, TOP + 0.03, CUBE))
    end = settled(room, room.initial, "cube")
    assert end.stays != falls
    assert support_of(Stage(room, end.state), "cube", DEFAULT.contact) == ("floor" if falls else "table")
    if falls:
        assert end.shift.moved_m > 0.5
        assert "cube moves by" in end.text


@pytest.mark.parametrize(("tilt_deg", "back"), [(3.0, True), (25.0, False)])
def test_a_tall_box_on_its_edge_tips(tilt_deg: float, back: bool) -> None:
    """Tilted beyond its diagonal (14°) it falls over; before that it stands up again."""
    tilt = math.radians(tilt_deg)
    height = TALL[2] * math.cos(tilt) + TALL[0] * math.sin(tilt)
    end = let_go(put("cube", 0.1, TOP + height, TALL, tilt))
    assert end.rests
    assert end.stays == back
    assert end.shift.turned_rad == pytest.approx(tilt if back else math.pi / 2 - tilt, abs=0.02)


def test_what_stands_on_a_loose_board_makes_it_tip() -> None:
    """A board over the table's edge lies still by itself, and not with a box on its end."""
    board = put("board", EDGE - 0.02, TOP + 0.005, (0.15, 0.05, 0.005))
    assert let_go(board, thing="board").stays
    end = let_go(board, put("cube", EDGE + 0.1, TOP + 0.04, CUBE))
    assert not end.stays
    assert "board" in end.pushed
    assert "it pushes board by" in end.text


def test_a_stack_stands_and_what_is_far_keeps_still() -> None:
    end = let_go(
        put("lower", 0.1, TOP + 0.03, CUBE), put("cube", 0.1, TOP + 0.09, CUBE), cylinder("cup", -0.2, 0, 0.77)
    )
    assert end.stays
    assert set(end.motions) == {"cube", "lower"}


def test_where_it_is_put_into_another_thing_both_are_pushed_apart() -> None:
    end = let_go(put("cup", 0.1, TOP + 0.03, CUBE), put("cube", 0.125, TOP + 0.03, CUBE))
    assert not end.stays
    assert end.pushed
    assert "cup" in end.pushed or end.shift.moved_m > 0.01


def ball_room() -> Scene:
    ball = f'<body name="ball" pos="0 0 {TOP + 0.03}"><freejoint/><geom type="sphere" size="0.03" condim="3"/></body>'
    ramp = f'<body name="ramp" pos="0 0 {TOP}" euler="0 2 0"><geom type="box" size="0.39 0.2 0.001"/></body>'
    return scene(TABLE, ramp, ball)


def test_what_rolls_on_does_not_rest() -> None:
    room = ball_room()
    end = settled(room, room.initial, "ball", longest_s=0.5)
    assert not end.rests
    assert not end.stays
    assert "does not come to rest" in end.text


def test_the_hand_that_lets_go_is_passed_through() -> None:
    """A person's hand about the cup holds it up, unless it is open."""
    room = scene(TABLE, cylinder("cup", 3.0, 3.0, 1.5), agents=agent("P1", -0.6, 0.0))
    palm = Stage(room).site(room.agent("P1").arm("right").palm_site).position
    state = room.initial.replace(at=room.object_slice("cup"), to=(*palm, 1.0, 0.0, 0.0, 0.0))
    free = settled(room, state, "cup", passing=["P1"])
    assert not free.shift.is_small
    assert free.state.qpos[room.object_slice("cup")][2] == pytest.approx(0.05, abs=0.06)


def test_the_state_afterwards_has_the_thing_where_it_ended() -> None:
    room = scene(TABLE, put("cube", 0.1, TOP + 0.036, CUBE), cylinder("cup", -0.2, 0, 0.77))
    end = settled(room, State(room.initial.qpos, 3.0), "cube")
    assert end.state.qpos[room.object_slice("cube")] == pytest.approx(end.motions["cube"].end)
    assert np.array_equal(end.state.qpos[room.object_slice("cup")], room.initial.qpos[room.object_slice("cup")])
    assert end.state.time_s == 3.0


def test_it_is_json_and_the_same_every_time() -> None:
    one, other = (let_go(put("cube", EDGE + 0.012, TOP + 0.03, CUBE)) for _ in range(2))
    document = json.loads(json.dumps(one.to_json()))
    assert document == json.loads(json.dumps(other.to_json()))
    assert (document["stays"], document["thing"]) == (False, "cube")


def test_only_things_are_let_go() -> None:
    room = scene(TABLE, put("cube", 0.1, TOP + 0.03, CUBE))
    with pytest.raises(UnknownNameError, match="no object 'table'"):
        settled(room, room.initial, "table")
