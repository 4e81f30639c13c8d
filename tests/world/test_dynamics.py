import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskgist.errors import SceneError, UnknownNameError
from taskgist.settings import DEFAULT
from taskgist.world import FreeMotion, Scene, Stage, State, container_of, free_motion, support_of
from taskgist.world.dynamics import GRAVITY_M_S2, STEP_S, free_motions
from taskgist.world.geometry.transforms import about_z, matrix_from_wxyz, normalized, rotate
from tests.scenes import TABLE, agent, box, cylinder, scene

TOP = 0.72
BIN = """<body name="bin" pos="0 0 0.72">
<geom type="box" size="0.1 0.1 0.005" pos="0 0 0.005"/>
<geom type="box" size="0.1 0.005 0.1" pos="0 0.1 0.1"/><geom type="box" size="0.1 0.005 0.1" pos="0 -0.1 0.1"/>
<geom type="box" size="0.005 0.1 0.1" pos="0.1 0 0.1"/><geom type="box" size="0.005 0.1 0.1" pos="-0.1 0 0.1"/>
</body>"""
ROLLING = 'condim="6" friction="0.5 0.005 0.0005" priority="1"'
BALL = f"""<body name="ball" pos="0 0 0.75"><freejoint/><geom type="sphere" size="0.03" {ROLLING}/></body>"""
WEDGE = """<mesh name="wedge" vertex="-0.03 -0.03 -0.03 0.03 -0.03 -0.03 0 0.04 -0.03 0 0 0.05"/>"""
CUBE = (0.03, 0.03, 0.03)


def room_with_mesh() -> Scene:
    text = f"""<mujoco><asset>{WEDGE}</asset><worldbody><geom name="floor" type="plane" size="5 5 0.1"/>{TABLE}
    <body name="wedge" pos="0 0 1.0"><freejoint/><geom type="mesh" mesh="wedge"/></body></worldbody></mujoco>"""
    toml = '[scene]\nname = "test"\nmodel = "room.xml"\n'
    return Scene.from_bundle({"scene.toml": toml.encode(), "room.xml": text.encode()})


def energies_j_kg(motion: FreeMotion) -> np.ndarray:
    """Energy of a point mass: what it has lost to turning and to contacts is gone for it."""
    velocities = np.diff(motion.poses[:, :3], axis=0) / STEP_S
    heights = (motion.poses[1:, 2] + motion.poses[:-1, 2]) / 2
    return np.asarray(0.5 * (velocities**2).sum(axis=1) + GRAVITY_M_S2 * heights)


def test_a_free_fall_takes_as_long_as_it_should() -> None:
    room = scene(TABLE, cylinder("cup", 0, 0, 2.0))
    motion = free_motion(room, room.initial, "cup")
    times = motion.times_s[:200]
    assert motion.poses[:200, 2] == pytest.approx(2.0 - GRAVITY_M_S2 * times**2 / 2, abs=0.002)
    assert np.allclose(motion.poses[:200, 3:], (1.0, 0.0, 0.0, 0.0))
    assert motion.touches_s == pytest.approx(np.sqrt(2 * (2.0 - 0.05 - TOP) / GRAVITY_M_S2), abs=0.003)


def test_a_throw_is_a_parabola() -> None:
    room = scene(cylinder("cup", 0, 0, 1.0))
    motion = free_motion(room, room.initial, "cup", linear_m_s=(1.0, -0.5, 2.0))
    times = motion.times_s[:250, None]
    expected = (0.0, 0.0, 1.0) + times * (1.0, -0.5, 2.0) - np.array((0.0, 0.0, GRAVITY_M_S2 / 2)) * times**2
    assert motion.poses[:250, :3] == pytest.approx(expected, abs=0.003)


def test_what_falls_onto_a_table_rests_on_it() -> None:
    room = scene(TABLE, cylinder("cup", 0.1, 0.2, 1.2))
    motion = free_motion(room, room.initial, "cup")
    rest = room.initial.replace(at=room.object_slice("cup"), to=motion.end)
    assert motion.rests
    assert motion.end[:3] == pytest.approx((0.1, 0.2, TOP + 0.05), abs=0.001)
    assert support_of(Stage(room, rest), "cup", DEFAULT.contact) == "table"


def test_what_rests_stays() -> None:
    room = scene(TABLE, box("cube", 0.1, 0.2, TOP + 0.03, CUBE))
    motion = free_motion(room, room.initial, "cube")
    assert motion.rests
    assert motion.duration_s < 0.3
    assert motion.end == pytest.approx(motion.poses[0], abs=1e-4)


@pytest.mark.parametrize("yaw_rad", [0.0, 0.6, 2.0])
def test_what_falls_into_a_bin_is_in_it(yaw_rad: float) -> None:
    turned = " ".join(map(str, about_z(yaw_rad)))
    room = scene(TABLE, BIN.replace('name="bin"', f'name="bin" quat="{turned}"'), box("cube", 0.02, 0.01, 1.2, CUBE))
    motion = free_motion(room, room.initial, "cube", angular_rad_s=(3.0, 2.0, 1.0))
    rest = room.initial.replace(at=room.object_slice("cube"), to=motion.end)
    assert motion.rests
    assert container_of(Stage(room, rest), "cube", DEFAULT.contact) == "bin"


@settings(max_examples=15, deadline=None)
@given(st.floats(0.0, 5.0), st.floats(-0.25, 0.25), st.floats(-0.4, 0.4), st.floats(-6.0, 6.0))
def test_nothing_tunnels_and_no_energy_comes_from_nowhere(down_m_s: float, x: float, y: float, spin: float) -> None:
    room = scene(TABLE, box("cube", x, y, 1.0, CUBE))
    motion = free_motion(
        room, room.initial, "cube", linear_m_s=(0, 0, -down_m_s), angular_rad_s=(spin, 0, spin), longest_s=1.0
    )
    over = (np.abs(motion.poses[:, 0]) < 0.4) & (np.abs(motion.poses[:, 1]) < 0.6)
    assert motion.poses[over, 2].min() > TOP
    turning = 0.5 * (2 * 0.03**2 * 2 / 3) * spin**2  # of a cube about two of its axes, per kilogram
    energies = energies_j_kg(motion)
    assert energies.max() < energies[0] + turning + 0.01


def test_shapes_collide_as_they_are_turned() -> None:
    """A cube slides down a board that is inclined by 30 degrees, and stays on one of five."""
    ends = []
    for tilt in (np.radians(5.0), np.radians(30.0)):
        turned = f"{np.cos(tilt / 2)} 0 {np.sin(tilt / 2)} 0"
        slippery = f'friction="0.3 0.005 0.0001" size="0.5 0.2 0.01" quat="{turned}"'
        board = f'<body name="board" pos="0 0 1"><geom type="box" {slippery}/></body>'
        room = scene(board, box("cube", 0, 0, 1.08, CUBE).replace("<geom", '<geom friction="0.3 0.005 0.0001"'))
        ends.append(free_motion(room, room.initial, "cube", longest_s=1.0).end)
    assert ends[0][0] == pytest.approx(0.0, abs=0.05)
    assert ends[1][0] > 0.4


def test_a_ball_rolls_on_and_slows_down() -> None:
    room = scene(TABLE, BALL)
    motion = free_motion(room, room.initial, "ball", linear_m_s=(0.0, 0.4, 0.0), longest_s=1.0)
    speeds = np.linalg.norm(np.diff(motion.poses[:, :3], axis=0), axis=1) / STEP_S
    assert speeds[400] == pytest.approx(0.4 * 5 / 7 - 0.8 * 0.0005 / 0.03 * GRAVITY_M_S2 * 5 / 7, abs=0.05)
    assert np.all(motion.poses[:, 2] == pytest.approx(0.75, abs=0.002))
    assert speeds[150] > speeds[450] > 0.05


def test_friction_stops_what_slides() -> None:
    room = scene(TABLE, box("cube", 0.0, -0.3, TOP + 0.01, (0.05, 0.05, 0.01)))
    friction = float(room.model.geom_friction[room.object_geoms("cube")[0], 0])
    motion = free_motion(room, room.initial, "cube", linear_m_s=(0.0, 1.5, 0.0))
    assert motion.rests
    assert motion.end[1] + 0.3 == pytest.approx(1.5**2 / (2 * friction * GRAVITY_M_S2), rel=0.15)


def test_turning_is_told_in_the_world() -> None:
    turned = normalized((0.9, 0.1, 0.3, -0.2))
    room = scene(box("cube", 0, 0, 3.0, CUBE))
    state = room.initial.replace(at=room.object_slice("cube"), to=(0, 0, 3.0, *turned))
    motion = free_motion(room, state, "cube", angular_rad_s=(0.0, 0.0, 2.0), longest_s=0.5)
    expected = rotate(about_z(2.0 * 0.5), matrix_from_wxyz(turned).T).T
    assert matrix_from_wxyz(motion.end[3:]) == pytest.approx(expected, abs=0.01)


def test_agents_and_other_things_are_in_the_way_unless_passed_through() -> None:
    room = scene(TABLE, box("box", 0, 0, TOP + 0.1, (0.1, 0.1, 0.1)), cylinder("cup", 0, 0, 1.2))
    assert free_motion(room, room.initial, "cup").end[2] == pytest.approx(TOP + 0.25, abs=0.002)
    assert free_motion(room, room.initial, "cup", passing=["box"]).end[2] == pytest.approx(TOP + 0.05, abs=0.002)
    crowd = scene(box("cube", 0, 0, 2.5, CUBE), agents=agent("P1", 0, 0))
    assert free_motion(crowd, crowd.initial, "cube", longest_s=0.4).poses[:, 2].min() > 1.7
    assert free_motion(crowd, crowd.initial, "cube", passing=["P1/left_arm"], longest_s=0.4).poses[:, 2].min() > 1.7
    assert free_motion(crowd, crowd.initial, "cube", passing=["P1"]).end[2] == pytest.approx(0.03, abs=0.002)


def test_meshes_move_too() -> None:
    room = room_with_mesh()
    motion = free_motion(room, room.initial, "wedge")
    assert motion.rests
    assert motion.poses[:, 2].min() > TOP
    assert motion.end[2] == pytest.approx(TOP + 0.03, abs=0.003)


def test_a_motion_is_the_same_each_time_and_survives_pickling() -> None:
    room = scene(TABLE, box("cube", 0.37, 0, 1.0, CUBE))
    one, other = (free_motion(room, room.initial, "cube", angular_rad_s=(1, 2, 3)) for _ in range(2))
    assert np.array_equal(one.poses, other.poses)
    copy = pickle.loads(pickle.dumps(one))
    assert np.array_equal(copy.poses, one.poses)
    assert not copy.poses.flags.writeable


def test_between_steps_a_motion_is_smooth_and_at_its_ends_it_stays() -> None:
    room = scene(cylinder("cup", 0, 0, 1.0))
    motion = free_motion(room, room.initial, "cup", longest_s=0.2)
    assert motion.at([-1.0, 0.021, 9.0])[:, 2] == pytest.approx(
        (1.0, (motion.poses[10, 2] + motion.poses[11, 2]) / 2, motion.poses[-1, 2])
    )
    assert not motion.rests
    assert motion.touches_s == np.inf


def test_what_cannot_move_is_refused() -> None:
    room = scene(
        '<body name="spot" pos="0 0 1"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>'
    )
    with pytest.raises(SceneError, match="spot"):
        free_motion(room, room.initial, "spot")
    with pytest.raises(UnknownNameError):
        free_motion(room, State(room.initial.qpos), "cup")


def test_several_things_move_each_other() -> None:
    """A cube lands on another, which stays; alone, each falls as it does without the other."""
    room = scene(TABLE, box("low", 0.1, 0.2, TOP + 0.03, CUBE), box("high", 0.1, 0.2, TOP + 0.2, CUBE))
    both = free_motions(room, room.initial, ("high", "low"))
    assert both["high"].rests
    assert both["high"].end[:3] == pytest.approx((0.1, 0.2, TOP + 0.09), abs=0.002)
    assert both["low"].end[:3] == pytest.approx((0.1, 0.2, TOP + 0.03), abs=0.002)
    assert both["low"].touches_s < both["high"].touches_s
    alone = free_motion(room, room.initial, "high")
    before = slice(0, round(both["high"].touches_s / STEP_S) - 1)
    assert both["high"].poses[before] == pytest.approx(alone.poses[before], abs=1e-9)


def test_the_lower_of_two_things_is_moved_by_the_upper() -> None:
    """A heavy cube on the far end of a board tips it over the table's edge."""
    board = box("board", 0.38, 0.0, TOP + 0.005, (0.15, 0.05, 0.005))
    room = scene(TABLE, board, box("cube", 0.5, 0.0, TOP + 0.04, CUBE))
    assert free_motion(room, room.initial, "board").end[2] == pytest.approx(TOP + 0.005, abs=0.002)
    assert free_motions(room, room.initial, ("cube", "board"))["board"].end[2] < 0.5
