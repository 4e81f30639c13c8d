import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskgist.settings import DEFAULT
from taskgist.world import Fitter, Hold, Scene, Stage, State, container_of, holding_of, overlaps, rests_on, support_of
from taskgist.world.geometry.shapes import lowest_point, surface_points
from taskgist.world.geometry.transforms import about_z
from tests.scenes import TABLE, agent, box, cylinder, scene

CONTACT = DEFAULT.contact
TOP = 0.72
BIN = """<body name="bin" pos="0.3 0.3 0.72">
<geom type="box" size="0.1 0.1 0.005" pos="0 0 0.005"/>
<geom type="box" size="0.1 0.005 0.1" pos="0 0.1 0.1"/><geom type="box" size="0.1 0.005 0.1" pos="0 -0.1 0.1"/>
<geom type="box" size="0.005 0.1 0.1" pos="0.1 0 0.1"/><geom type="box" size="0.005 0.1 0.1" pos="-0.1 0 0.1"/>
</body>"""
SHELF = """<body name="shelf" pos="0.3 0.3 0.72"><geom type="box" size="0.1 0.1 0.005" pos="0 0 0.005"/>
<geom type="box" size="0.1 0.005 0.1" pos="0 0.1 0.1"/></body>"""


def support(room: Scene, name: str, state: State | None = None) -> str | None:
    return support_of(Stage(room, state), name, CONTACT)


@pytest.mark.parametrize(("gap", "expected"), [(-0.01, "table"), (0.0, "table"), (0.01, "table"), (0.03, None)])
def test_support_tolerates_noise_but_no_gap(gap: float, expected: str | None) -> None:
    assert support(scene(TABLE, cylinder("cup", 0, 0, TOP + 0.05 + gap)), "cup") == expected


def test_objects_support_objects() -> None:
    room = scene(TABLE, box("white_box", 0, 0, TOP + 0.1, (0.1, 0.1, 0.1)), cylinder("cup", 0, 0, TOP + 0.25))
    assert support(room, "cup") == "white_box"
    assert support(room, "white_box") == "table"


def test_a_wall_beside_is_no_support_and_neither_is_a_board_above() -> None:
    wall = '<body name="wall" pos="0.1 0 1.2"><geom type="box" size="0.05 1 1"/></body>'
    board = '<body name="board" pos="0 0 1.065"><geom type="box" size="0.3 0.3 0.01"/></body>'
    assert support(scene(wall, cylinder("cup", 0.005, 0, 1.0)), "cup") is None
    assert support(scene(board, cylinder("cup", 0, 0, 1.0, half=0.05)), "cup") is None


@settings(max_examples=30, deadline=None)
@given(st.floats(-math.pi, math.pi), st.floats(-3, 3), st.floats(-3, 3))
def test_support_does_not_depend_on_where_the_room_stands(yaw: float, x: float, y: float) -> None:
    turned = f"""<body name="table" pos="{x} {y} 0.7" quat="{" ".join(map(str, about_z(yaw)))}">
    <geom type="box" size="0.4 0.6 0.02"/></body>"""
    c, s = math.cos(yaw), math.sin(yaw)
    edge = (x + 0.45 * c - 0.1 * s, y + 0.45 * s + 0.1 * c)  # just beside the edge
    room = scene(turned, cylinder("cup", *edge, TOP + 0.05))
    assert support(room, "cup") is None
    edge = (x + 0.38 * c - 0.1 * s, y + 0.38 * s + 0.1 * c)
    assert support(scene(turned, cylinder("cup", *edge, TOP + 0.05)), "cup") == "table"


@pytest.mark.parametrize(("furniture", "expected"), [(BIN, "bin"), (SHELF, None)])
def test_a_container_has_walls_all_round(furniture: str, expected: str | None) -> None:
    room = scene(TABLE, furniture, cylinder("cup", 0.3, 0.3, TOP + 0.06))
    assert container_of(Stage(room), "cup", CONTACT) == expected


def test_above_the_rim_is_not_inside() -> None:
    room = scene(TABLE, BIN, cylinder("pole", 0.3, 0.3, TOP + 0.26, radius=0.02, half=0.25))
    assert container_of(Stage(room), "pole", CONTACT) is None


def held_cup(gap: float = 0.0) -> tuple[Scene, State]:
    room = scene(TABLE, cylinder("cup", 2, 0, 1.1), agents=agent("P1", -0.8, 0))
    fit = Fitter(room, "P1", moving="arms").fit(room.initial, points={"right_palm": (-0.3, -0.15, 1.1)})
    palm = Stage(room, fit.state).site(room.agent("P1").arm("right").palm_site).position
    state = fit.state.replace(at=room.object_slice("cup"), to=(*palm, 1, 0, 0, 0))
    hand = room.agent("P1").arm("right").hand_geoms
    while Stage(room, state).closest(hand, room.object_geoms("cup"), limit_m=1.0)[0] < gap:
        palm = palm + np.array([0.005, 0, 0])
        state = state.replace(at=room.object_slice("cup"), to=(*palm, 1, 0, 0, 0))
    return room, state


def test_a_close_hand_holds_what_rests_on_nothing() -> None:
    room, state = held_cup()
    holding = holding_of(Stage(room, state), "cup", CONTACT)
    assert holding is not None
    assert holding.hands == (("P1", "right"),)


def test_a_hand_farther_than_a_grip_holds_nothing() -> None:
    room, state = held_cup(gap=CONTACT.grip_m + 0.01)
    holding = holding_of(Stage(room, state), "cup", CONTACT)
    assert holding is not None
    assert holding.hands == ()
    assert holding.complete


def test_nothing_that_rests_on_a_support_is_held() -> None:
    room = scene(TABLE, cylinder("cup", 0, 0, TOP + 0.05), agents=agent("P1", -0.75, 0))
    fit = Fitter(room, "P1", moving="upper_body").fit(room.initial, points={"right_palm": (-0.02, -0.03, TOP + 0.06)})
    stage = Stage(room, fit.state)
    arm = room.agent("P1").arm("right")
    assert stage.closest(arm.hand_geoms, room.object_geoms("cup"), limit_m=0.1)[0] < CONTACT.grip_m
    holding = holding_of(stage, "cup", CONTACT)
    assert holding is not None
    assert holding.hands == ()
    assert holding.support == "table"


def test_what_was_decided_over_time_to_be_held_does_not_rest() -> None:
    """It is being lifted: near to the table still, and in the hand."""
    room = scene(TABLE, cylinder("cup", 0, 0, TOP + 0.055), agents=agent("P1", -0.75, 0))
    fit = Fitter(room, "P1", moving="upper_body").fit(room.initial, points={"right_palm": (-0.02, -0.03, TOP + 0.06)})
    for decided, held in (([Hold("P1", "right", "cup")], True), ([], False), (None, False)):
        holding = holding_of(Stage(room, fit.state.with_holding(decided)), "cup", CONTACT)
        assert holding is not None
        assert (holding.hands, holding.support) == (((("P1", "right"),), None) if held else ((), "table"))


def test_an_untracked_hand_might_hold() -> None:
    room, state = held_cup()
    lost = State(state.qpos, 0.0, frozenset({"P1/right_arm"}))
    holding = holding_of(Stage(room, lost), "cup", CONTACT)
    assert holding is not None
    assert not holding.complete
    assert holding_of(Stage(room, State(state.qpos, 0.0, frozenset({"cup"}))), "cup", CONTACT) is None


def test_a_hand_rests_on_a_table_from_above_only() -> None:
    room = scene(TABLE, agents=agent("P1", -0.75, 0))
    arm = room.agent("P1").arm("right")
    fitter = Fitter(room, "P1", moving="upper_body", weights={"right_wrist": 10.0})
    flat = {"right_hand": (1, 0, 0), "right_palm": (0, 0, -1)}
    on = fitter.fit(room.initial, points={"right_wrist": (-0.3, -0.15, TOP + 0.02)}, directions=flat)
    assert rests_on(Stage(room, on.state), arm, CONTACT) == "table"
    above = fitter.fit(room.initial, points={"right_wrist": (-0.3, -0.15, TOP + 0.15)}, directions=flat)
    assert rests_on(Stage(room, above.state), arm, CONTACT) is None


@pytest.mark.parametrize(("rise_m", "expected"), [(0.0, "pad"), (0.06, None)])
def test_a_hand_rests_on_a_thing_that_is_all_beneath_it(rise_m: float, expected: str | None) -> None:
    """Not where its rim rises beside the fingers: such a thing is gripped."""
    rim = f'<geom type="box" size="0.04 0.005 {0.01 + rise_m / 2}" pos="0 -0.07 {rise_m / 2}"/>'
    pad = f"""<body name="pad" pos="-0.24 -0.15 {TOP + 0.01}"><freejoint/>
    <geom type="box" size="0.08 0.08 0.01"/>{rim}</body>"""
    room = scene(TABLE, pad, agents=agent("P1", -0.75, 0))
    fitter = Fitter(room, "P1", moving="upper_body", weights={"right_wrist": 10.0})
    flat = {"right_hand": (1, 0, 0), "right_palm": (0, 0, -1)}
    on = fitter.fit(room.initial, points={"right_wrist": (-0.3, -0.15, TOP + 0.04)}, directions=flat)
    assert rests_on(Stage(room, on.state), room.agent("P1").arm("right"), CONTACT) == expected


def test_overlaps_name_the_pair_and_depth() -> None:
    room = scene(TABLE, cylinder("cup", 0, 0, TOP + 0.0))
    found = overlaps(Stage(room), deeper_than_m=0.01)
    assert set(found) == {("cup", "table")}
    assert found["cup", "table"] == pytest.approx(0.05, abs=0.01)


SHAPES = (
    'type="box" size="0.1 0.05 0.2"',
    'type="sphere" size="0.1"',
    'type="ellipsoid" size="0.1 0.05 0.2"',
    'type="cylinder" size="0.1 0.2"',
    'type="capsule" size="0.1 0.2"',
)


@pytest.mark.parametrize("shape", SHAPES)
def test_surface_points_lie_on_the_surface_and_normals_point_out(shape: str) -> None:
    room = scene(f'<body name="thing" pos="0 0 1"><freejoint/><geom {shape}/></body>')
    geom = int(room.object_geoms("thing")[0])
    stage = Stage(room)
    points, normals = surface_points(room.model, geom, 0.05)
    pose = stage.geom(geom)
    inner = points * 0.9999  # a ray along the very edge of a face may miss it
    for point, normal in zip(pose.to_world(inner), normals @ pose.matrix.T, strict=True):
        hits, distances = stage.cast(point + 0.5 * normal, -normal[None])
        assert hits[0] == geom
        assert distances[0] == pytest.approx(0.5, abs=1e-3)
    gaps = np.linalg.norm(points[:, None] - points[None], axis=2) + 9 * np.eye(len(points))
    assert gaps.min(axis=1).max() <= 0.05 * math.sqrt(2) + 1e-9


@settings(max_examples=20, deadline=None)
@given(st.sampled_from(SHAPES), st.integers(0, 2**32 - 1))
def test_the_lowest_point_is_lower_than_every_sample(shape: str, seed: int) -> None:
    room = scene(f'<body name="thing" pos="0 0 1"><freejoint/><geom {shape}/></body>')
    wxyz = np.random.default_rng(seed).normal(size=4)
    wxyz /= np.linalg.norm(wxyz)
    geom = int(room.object_geoms("thing")[0])
    pose = Stage(room, room.initial.replace(at=room.object_slice("thing"), to=(0, 0, 1, *wxyz))).geom(geom)
    lowest = lowest_point(room.model, geom, pose.matrix)
    assert lowest is not None
    samples, _ = surface_points(room.model, geom, 0.02)
    height = pose.to_world(lowest)[2]
    assert height <= pose.to_world(samples)[:, 2].min() + 1e-9
    assert height >= pose.to_world(samples)[:, 2].min() - 0.01


def test_who_has_sunk_into_a_table_top_is_not_inside_the_table() -> None:
    room = scene(TABLE, box("phone", 0, 0, TOP - 0.001, (0.035, 0.07, 0.004)))
    assert container_of(Stage(room), "phone", CONTACT) is None
    assert support(room, "phone") == "table"


def test_a_full_container_still_contains() -> None:
    room = scene(TABLE, BIN, cylinder("cup", 0.26, 0.3, TOP + 0.07), cylinder("mug", 0.35, 0.3, TOP + 0.07))
    assert [container_of(Stage(room), name, CONTACT) for name in ("cup", "mug")] == ["bin", "bin"]


def test_three_walls_and_a_floor_are_no_container() -> None:
    three = BIN.replace('<geom type="box" size="0.005 0.1 0.1" pos="0.1 0 0.1"/>', "")
    assert three != BIN
    assert container_of(Stage(scene(TABLE, three, cylinder("cup", 0.3, 0.3, TOP + 0.06))), "cup", CONTACT) is None


def test_agents_are_no_supports() -> None:
    room, state = held_cup()
    hand = Stage(room, state).body_position(room.agent("P1").arm("right").hand_body)
    resting = state.replace(at=room.object_slice("cup"), to=(*(hand + (0, 0, 0.08)), 1, 0, 0, 0))
    assert support(room, "cup", resting) is None


def test_an_untracked_support_leaves_the_placement_open() -> None:
    white_box = box("white_box", 0, 0, TOP + 0.1, (0.1, 0.1, 0.1))
    room = scene(TABLE, white_box, cylinder("cup", 0, 0, TOP + 0.25))
    lost = State(room.initial.qpos, 0.0, frozenset({"white_box"}))
    holding = holding_of(Stage(room, lost), "cup", CONTACT)
    assert holding is not None
    assert holding.support is None
    assert not holding.complete


def test_what_is_untracked_hides_nothing() -> None:
    room = scene(box("screen", 0.5, 0, 1.2, (0.02, 0.5, 0.5)), cylinder("cup", 1, 0, 1.2))
    known, lost = Stage(room), Stage(room, State(room.initial.qpos, 0.0, frozenset({"screen"})))
    seen = [room.owners[stage.cast((0, 0, 1.2), [(1.0, 0.0, 0.0)])[0][0]] for stage in (known, lost)]
    assert seen == ["screen", "cup"]
    assert set(lost.solid_geoms()) == set(known.solid_geoms()) - set(room.object_geoms("screen"))


def test_a_fine_mesh_is_sampled_evenly_and_once() -> None:
    angles = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    ring = [(0.1 * np.cos(a), 0.1 * np.sin(a), z) for z in np.linspace(-0.1, 0.1, 40) for a in angles]
    text = " ".join(f"{x:.5f}" for point in ring for x in point)
    mesh = f'<asset><mesh name="pot" vertex="{text}"/></asset>'
    body = '<body name="pot" pos="0 0 1"><freejoint/><geom type="mesh" mesh="pot"/></body>'
    files = {
        "scene.toml": b'[scene]\nmodel = "room.xml"',
        "room.xml": f"<mujoco>{mesh}<worldbody>{body}</worldbody></mujoco>".encode(),
    }
    room = Scene.from_bundle(files)
    geom = int(room.object_geoms("pot")[0])
    points, normals = room.surface_points(geom, 0.05)
    assert room.surface_points(geom, 0.05)[0] is points
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    assert len(points) < 6000
    assert np.ptp(points[:, 2]) == pytest.approx(0.2, abs=0.01)
