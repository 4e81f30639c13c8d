"""Where an object is, as anybody would say it of an ordinary room."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskgist.observe import Observer, Placement
from taskgist.observe.relations import carried_by
from taskgist.world import Scene, Stage, State
from tests.observe.states import States
from tests.scenes import TABLE, agent, box, cylinder, scene

SEATED = agent("P1", -0.8, 0, posture="sitting", extra="seat_height_m = 0.45")
STOOL = '<body name="stool" pos="-0.8 0 0.22"><geom type="box" size="0.2 0.2 0.22"/></body>'
WALL = '<body name="wall" pos="0 2 1.2"><geom type="box" size="2 0.05 1.2"/></body>'
HOOK = '<body name="hook" pos="0 1.9 1.5"><geom type="capsule" fromto="0 0.05 0 0 -0.06 0" size="0.006"/></body>'
RAIL = '<body name="rail" pos="0 1.0 1.5"><geom type="capsule" fromto="-1 0 0 1 0 0" size="0.012"/></body>'
CEILING = '<geom name="ceiling" type="plane" size="3 3 0.1" pos="0 0 2.4" euler="180 0 0"/>'
MUG = """<body name="mug" pos="{x} {y} {z}"><freejoint/><geom type="cylinder" size="0.04 0.05"/>
<geom type="capsule" fromto="0 0.04 0.04 0 0.08 0.04" size="0.006"/>
<geom type="capsule" fromto="0 0.08 0.04 0 0.08 -0.03" size="0.006"/></body>"""
"""Its handle is at y + 4 to 8 cm, the upper bow of it at z + 4 cm."""


def placement(room: Scene, name: str, state: State | None = None) -> Placement | None:
    """Of something that stays where it is."""
    start = state or room.initial
    states = [State(start.qpos, frame / 10, start.untracked) for frame in range(5)]
    return Observer(room, States(states)).placement(name).at(0.3)


def lap_of(room: Scene) -> tuple[float, float, float]:
    """A place on the thighs of P1: their middle, and how high they are."""
    of_body = {geom: room.model.body(room.model.geom_bodyid[geom]).name for geom in room.solid_geoms_of("P1").tolist()}
    low, high = Stage(room).bounds(np.array([geom for geom, body in of_body.items() if "thigh" in body]))
    return float(low[0] + high[0]) / 2, float(low[1] + high[1]) / 2, float(high[2])


@pytest.mark.parametrize("gap_m", [0.002, 0.005, 0.01, 0.03])
@pytest.mark.parametrize("thick_m", [0.002, 0.01, 0.04])
@pytest.mark.parametrize("name", ["ball", "coin", "cup"])
def test_beneath_a_board_is_not_on_it(gap_m: float, thick_m: float, name: str) -> None:
    """Nothing carries it: it floats, being thrown, or its tracker errs."""
    board = f'<body name="board" pos="0 0 1"><geom type="box" size="0.3 0.3 {thick_m / 2}"/></body>'
    half_m = {"ball": 0.03, "coin": 0.001, "cup": 0.05}[name]
    z = 1 - thick_m / 2 - gap_m - half_m
    thing = {
        "ball": f'<body name="ball" pos="0 0 {z}"><freejoint/><geom type="sphere" size="0.03"/></body>',
        "coin": cylinder("coin", 0, 0, z, half=0.001, radius=0.012),
        "cup": cylinder("cup", 0, 0, z),
    }[name]
    assert placement(scene(board, thing), name) == Placement("In_Air")


@settings(deadline=None, max_examples=30)
@given(st.floats(-0.015, 0.0145), st.sampled_from([0.001, 0.004, 0.02, 0.05]))
def test_a_tracker_errs_by_a_centimetre_and_it_is_still_on_its_support(gap_m: float, half_m: float) -> None:
    room = scene(TABLE, box("thing", 0, 0, 0.72 + half_m + gap_m, (0.04, 0.03, half_m)))
    assert placement(room, "thing") == Placement("On_Support", ("table",))


def test_a_cup_on_a_lap_is_on_its_owner() -> None:
    bare = scene(STOOL, agents=SEATED)
    x, y, z = lap_of(bare)
    room = scene(STOOL, box("book", x, y, z + 0.012, (0.1, 0.08, 0.01)), agents=SEATED)
    assert placement(room, "book") == Placement("On_Agent", ("P1",))
    assert carried_by(Stage(room), "book") == ("P1",)


def test_of_what_lies_where_a_lap_was_last_seen_nothing_is_known() -> None:
    bare = scene(STOOL, agents=SEATED)
    x, y, z = lap_of(bare)
    room = scene(STOOL, box("book", x, y, z + 0.012, (0.1, 0.08, 0.01)), agents=SEATED)
    lost = State(room.initial.qpos, 0.0, frozenset({"P1/legs"}))
    assert placement(room, "book", lost) == Placement(None)
    assert carried_by(Stage(room, lost), "book") is None


def test_a_key_in_a_pocket_is_on_its_owner() -> None:
    bare = scene(agents=agent("P1", 0, 0))
    stage = Stage(bare)
    hip = stage.body_position(bare.agent("P1").root_body)
    room = scene(box("key", hip[0] + 0.02, hip[1] - 0.12, hip[2] - 0.06, (0.02, 0.003, 0.01)), agents=agent("P1", 0, 0))
    assert placement(room, "key") == Placement("On_Agent", ("P1",))


def test_a_mug_hangs_by_its_handle() -> None:
    """The bow of the handle lies upon hook or rail."""
    assert placement(scene(RAIL, MUG.format(x=0, y=0.94, z=1.442)), "mug") == Placement("Hanging", ("rail",))
    assert placement(scene(WALL, HOOK, MUG.format(x=0, y=1.82, z=1.448)), "mug") == Placement("Hanging", ("hook",))


def test_a_picture_hangs_at_the_wall() -> None:
    assert placement(scene(WALL, box("picture", 0.4, 1.94, 1.5, (0.2, 0.01, 0.15))), "picture") == Placement(
        "Hanging", ("wall",)
    )


def test_what_touches_nothing_is_in_the_air() -> None:
    room = scene(TABLE, WALL, CEILING, cylinder("cup", 0, 0, 1.5), agents=agent("P1", -0.8, 0))
    assert placement(room, "cup") == Placement("In_Air")
    assert placement(scene(CEILING, cylinder("cup", 0, 0, 2.345)), "cup") == Placement("In_Air")


def test_what_stands_at_a_wall_or_a_leg_stands() -> None:
    room = scene(
        TABLE, WALL, cylinder("cup", 1.0, 1.9, 0.05), cylinder("pot", 0.2, 0, 0.77), agents=agent("P1", -0.8, 0)
    )
    assert placement(room, "cup") == Placement("On_Support", ("floor",))
    assert placement(room, "pot") == Placement("On_Support", ("table",))
