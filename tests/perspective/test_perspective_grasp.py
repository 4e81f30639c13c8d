"""Reach and grasp: sectors, widths and what is in a hand's way."""

import math
from dataclasses import replace

import numpy as np
import pytest

from taskgist.language.efforts import why
from taskgist.perspective import Ability, Effort, Viewpoint, effort_from, least_effort
from taskgist.perspective.effort import Reached
from taskgist.perspective.grasp_sampling import around, grasps_in_object, sample_grasps
from taskgist.perspective.points_in_reach import PointCloud
from taskgist.perspective.reach import Reach, ReachScreening
from taskgist.perspective.viewpoint import FindMiss, Hit
from taskgist.settings import DEFAULT
from taskgist.world import Scene, Stage
from taskgist.world.contacts import seat_m, support_of
from tests.perspective.twin_grasp import hand_poses
from tools.rooms import Person, Room, Thing, table, wall

STANDING = Person("P1", (0.0, 0.0))
CUP = Thing("cup", (0.03, 0.05), (0.5, 0.2, 1.2), "cylinder")
HERE_ONLY = replace(DEFAULT, efforts=replace(DEFAULT.efforts, move_radius_m=0.0))
ROUGH_HERE = replace(HERE_ONLY, reach=replace(DEFAULT.reach, model="sector"))


def effort(things: tuple[Thing, ...], ability: Ability, person: Person = STANDING) -> Effort:
    return least_effort(Room(things, (person,)).stage(), "P1", things[0].name, ability, HERE_ONLY)


def held(room: Room, side: str) -> Stage:
    """The cup against the palm of a hand."""
    stage = room.stage()
    palm = stage.site(stage.scene.agent("P1").arm(side).palm_site).position
    outward = 0.02 if side == "left" else -0.02
    place = palm + (0.0, -outward, 0.0)
    return stage.show(stage.state.replace(at=stage.scene.object_slice("cup"), to=(*place, 1, 0, 0, 0)))


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("ability", ["reach", "grasp"])
def test_what_is_held_needs_no_effort(side: str, ability: Ability) -> None:
    found = least_effort(held(Room((CUP,), (STANDING,)), side), "P1", "cup", ability)
    assert (found.level, found.actions, found.name) == (0, ("No_Action_Required",), "No_Effort_Required")
    assert found.evidence_document["arm"] == side
    assert found.reason == "held"


def reached(stage: Stage, side: str, points: np.ndarray) -> Hit | FindMiss | None:
    """How P1 reaches one of some points with one arm from where it stands, if it does, by the paper's rough reach."""
    here = Viewpoint(stage, "P1", ROUGH_HERE, actions=(f"Stretch_Out_Arm({side})",))
    (candidates,) = here.candidates.of_level(1, points[0])
    screening = ReachScreening(Reach(here, here.target("cup")), candidates, PointCloud.of(points))
    return next(screening.results(0)) if screening.next(0, 1) == 0 else None


def test_reach_is_the_arms_length_from_the_shoulder() -> None:
    stage = Room((CUP,), (STANDING,)).stage()
    arm = stage.scene.agent("P1").arm("left")
    assert arm.profile.length_m == pytest.approx(0.70)
    points = stage.shoulder(arm).to_world([(0.7, 0.0, 0.0), (0.7001, 0.0, 0.0), (0.0, 0.69, 0.0), (-0.5, -0.1, 0.0)])
    assert [reached(stage, "left", point[None]) is not None for point in points] == [True, False, True, False]
    found = reached(stage, "left", points)
    assert isinstance(found, Hit)
    nearest = found.find_evidence()
    assert isinstance(nearest, Reached)
    assert (nearest.arm, nearest.point_m) == ("left", tuple(points[2].tolist()))
    assert nearest.distance_m == pytest.approx(0.69)


@pytest.mark.parametrize(("up_deg", "expected"), [(85, False), (75, True), (-60, True), (-89, True)])
def test_the_sector_ends_below_the_vertical(up_deg: float, expected: bool) -> None:
    stage = Room((CUP,), (STANDING,)).stage()
    shoulder, up = stage.shoulder(stage.scene.agent("P1").arm("left")), math.radians(up_deg)
    points = shoulder.to_world([(0.5 * math.cos(up), 0.0, 0.5 * math.sin(up))])
    assert (reached(stage, "left", points) is not None) == expected


@pytest.mark.parametrize(("outward_deg", "expected"), [(-65, False), (-55, True), (0, True), (115, True), (125, False)])
def test_the_sector_is_mirrored_between_the_arms(outward_deg: int, expected: bool) -> None:
    stage = Room((CUP,), (STANDING,)).stage()
    for side, sign in (("left", 1), ("right", -1)):
        shoulder = stage.shoulder(stage.scene.agent("P1").arm(side))
        angle = math.radians(sign * outward_deg)
        points = shoulder.to_world([(0.5 * math.cos(angle), 0.5 * math.sin(angle), 0.0)])
        assert (reached(stage, side, points) is not None) == expected


def test_a_thing_on_the_left_is_for_the_left_arm() -> None:
    found = effort((CUP,), "reach")
    assert (found.level, found.actions) == (1, ("Stretch_Out_Arm(left)",))
    mirrored = effort((replace(CUP, place=(0.5, -0.2, 1.2)),), "reach")
    assert mirrored.actions == ("Stretch_Out_Arm(right)",)


@pytest.mark.parametrize(("half_m", "arms"), [(0.049, ["left"]), (0.051, ["left", "right"]), (0.15, ["left", "right"])])
def test_a_ball_wider_than_a_hand_takes_both(half_m: float, arms: list[str]) -> None:
    ball = Thing("ball", (half_m,), (0.5, 0.1, 1.2), "sphere")
    assert effort((ball,), "reach").level == 1
    found = effort((ball,), "grasp")
    assert (found.level, found.actions) == (1, tuple(f"Stretch_Out_Arm({side})" for side in arms))
    assert found.evidence_document.get("arms", [found.evidence_document.get("arm")]) == arms


def test_what_is_wider_than_both_hands_carry_is_reached_but_not_grasped() -> None:
    crate = Thing("crate", (0.31, 0.31, 0.31), (0.7, 0.0, 1.2))
    assert effort((crate,), "reach").level == 1
    found = effort((crate,), "grasp")
    assert (found.level, found.reason) == (5, "too wide (0.62 m > 0.60 m)")


def test_a_plate_is_grasped_at_its_edge() -> None:
    plate = Thing("plate", (0.15, 0.15, 0.01), (0.5, 0.2, 1.2))
    found = effort((plate,), "grasp")
    assert found.level == 1
    assert found.evidence_document["width_m"] == pytest.approx(0.02, abs=1e-4)
    center = np.abs(np.array(found.evidence_document["point_m"]) - plate.place)
    assert center.max() > 0.08  # the palm stays out of the plate


def test_a_framed_plate_is_not_grasped_in_its_middle_for_the_palm_would_be_in_it() -> None:
    plate = Thing("plate", (0.15, 0.15, 0.01), (0.5, 0.2, 1.1))
    frame = [Thing(f"x{s}", (0.04, 0.2, 0.1), (0.5 + 0.15 * s, 0.2, 1.1), free=False) for s in (-1, 1)]
    frame += [Thing(f"y{s}", (0.2, 0.04, 0.1), (0.5, 0.2 + 0.15 * s, 1.1), free=False) for s in (-1, 1)]
    assert effort((plate, *frame), "reach").level == 1
    found = effort((plate, *frame), "grasp")
    assert found.level == 5
    assert "plate" in found.evidence_document["miss"]["approaches"]  # type: ignore[index]


def test_the_own_chest_is_in_the_hands_way_until_it_turns() -> None:
    button = Thing("cup", (0.015, 0.015, 0.015), (0.05, 0.11, 1.24))
    assert effort((button,), "reach").level == 1
    found = effort((button,), "grasp")
    assert found.level == 2
    assert found.actions[0] in {"Turn_Torso", "Lean_Torso"}
    assert found.reason == "every approach blocked by P1"


def test_a_cup_deep_in_a_tube_is_reached_but_not_grasped() -> None:
    """An outstretched hand goes in once the shoulder is above; there is no room to open it around the cup."""
    walls = [Thing(f"x{s}", (0.01, 0.08, 0.2), (0.5 + 0.06 * s, 0.2, 1.1), free=False) for s in (-1, 1)]
    walls += [Thing(f"y{s}", (0.08, 0.01, 0.2), (0.5, 0.2 + 0.06 * s, 1.1), free=False) for s in (-1, 1)]
    things = (replace(CUP, place=(0.5, 0.2, 1.0)), *walls)
    assert effort(things, "reach").level == 2
    assert least_effort(Room(things, (STANDING,)).stage(), "P1", "cup", "reach", ROUGH_HERE).level == 1
    found = effort(things, "grasp")
    assert found.level == 5
    assert found.reason.startswith("every approach blocked by ")


def test_what_lies_on_the_table_is_taken_from_above_not_through_it() -> None:
    coin = Thing("coin", (0.015, 0.015, 0.012), (0.45, 0.15, 0.932))
    found = effort((coin, table(0.65, height=0.92)), "grasp")
    assert found.level is not None
    assert found.level < 5
    assert found.evidence_document["approach"][2] < -0.5  # type: ignore[index]


def test_another_agents_hand_around_the_thing_is_in_the_way() -> None:
    thimble = Thing("cup", (0.006, 0.006, 0.006), (0.5, 0.2, 1.2))  # nothing of it sticks out of the fist
    other = Person("P2", (1.1, 0.2), math.pi, joints_deg=(("right_shoulder_flexion", 90),))
    stage = Room((thimble,), (STANDING, other)).stage()
    hand = stage.scene.agent("P2").arm("right")
    inside = stage.geom_centers(hand.hand_geoms).mean(axis=0)
    stage.show(stage.state.replace(at=stage.scene.object_slice("cup"), to=(*inside, 1, 0, 0, 0)))
    for ability in ("reach", "grasp"):  # a fist is closed on all sides
        blocked = least_effort(stage, "P1", "cup", ability, HERE_ONLY)
        assert blocked.level == 5
        assert "P2" in blocked.reason


def test_nothing_is_grasped_from_behind() -> None:
    found = effort((CUP,), "grasp")
    stage = Room((CUP,), (STANDING,)).stage()
    shoulder = stage.shoulder(stage.scene.agent("P1").arm("left")).position
    ahead = np.array(found.evidence_document["point_m"]) - shoulder
    assert np.array(found.evidence_document["approach"]) @ ahead >= -1e-9


def test_opposite_points_of_a_box_are_its_three_widths() -> None:
    stage = Room((Thing("brick", (0.02, 0.03, 0.04), (0.5, 0.2, 1.2), yaw=0.7),), (STANDING,)).stage()
    hand = stage.scene.agent("P1").profile.hand
    assert hand is not None
    grasps = grasps_in_object(stage, "brick", hand, DEFAULT.grasp)
    assert {round(float(width), 4) for width in grasps.widths_m} == {0.04, 0.06, 0.08}
    np.testing.assert_allclose(np.abs(grasps.closings).max(axis=1), 1.0)


def test_faces_that_are_not_opposed_are_refused() -> None:
    """The faces of a tetrahedron are never opposed."""
    mesh = '<asset><mesh name="t" vertex="0 0 0  0.05 0 0  0 0.05 0  0 0 0.05"/></asset>'
    body = '<body name="cup" pos="0.5 0.2 1.2"><freejoint/><geom type="mesh" mesh="t"/></body>'
    room = f"<mujoco>{mesh}<worldbody>{body}</worldbody></mujoco>"
    stage = Stage(Scene.from_bundle(dict(Room((), (STANDING,)).scene().bundle) | {"room.xml": room.encode()}))
    assert least_effort(stage, "P1", "cup", "grasp", HERE_ONLY).reason == "no two opposite faces to close on"


def test_hand_closes_around_the_pair_and_the_palm_stays_behind() -> None:
    stage = Room((CUP,), (STANDING,)).stage()
    hand = stage.scene.agent("P1").profile.hand
    assert hand is not None
    grasps = sample_grasps(stage, "cup", hand, DEFAULT.grasp)
    assert len(grasps) == len(grasps.centers) == len(grasps.approaches) > 0
    for index in range(0, len(grasps), 17):
        closing, approach = grasps.closings[index], grasps.approaches[index]
        palm, fingers, thumb = hand_poses(grasps, index, hand)
        gap = abs((fingers.position - thumb.position) @ closing) - hand.finger_thickness_m
        assert gap == pytest.approx(grasps.widths_m[index] + 0.01)
        assert (palm.position - grasps.centers[index]) @ approach < -hand.finger_length_m / 2
        assert abs(approach @ closing) < 1e-9


def test_approaches_surround_the_closing_direction_evenly() -> None:
    closing = np.array([(0.0, 0.0, 1.0), (0.6, 0.8, 0.0)])
    directions = around(closing, 8)
    assert directions.shape == (2, 8, 3)
    np.testing.assert_allclose(directions.sum(axis=1), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=2), 1.0)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", directions, closing), 0.0, atol=1e-12)


def test_leaning_into_a_bar_is_not_possible_so_the_torso_turns_aside() -> None:
    beyond = replace(CUP, place=(0.99, 0.2, 1.1))
    bar = Thing("bar", (0.02, 0.15, 0.03), (0.3, 0.0, 1.25), free=False)
    free, beside = effort((beyond,), "reach"), effort((beyond, bar), "reach")
    assert effort((beyond, wall("wall", 0.4, half=(0.02, 1.0, 1.2))), "reach").level == 5
    assert free.actions == ("Lean_Torso", "Stretch_Out_Arm(left)")
    assert beside.actions == ("Turn_Torso", "Lean_Torso", "Stretch_Out_Arm(left)")
    assert free.amount is not None
    assert beside.amount is not None
    assert beside.amount > free.amount


def flat(name: str, half: tuple[float, float, float], x: float = 0.5, y: float = 0.1, sunk: float = 0.0) -> Thing:
    """Something that lies on the table."""
    return Thing(name, half, (x, y, 0.92 + half[2] - sunk))


TABLE = table(0.65, height=0.92)


@pytest.mark.parametrize(
    ("thing", "prepared"),
    [
        (flat("card", (0.043, 0.027, 0.0005)), "tilted"),
        (flat("coin", (0.0115, 0.0115, 0.001)), None),
        (flat("phone", (0.037, 0.075, 0.004), x=0.42), None),
        (flat("leaf", (0.043, 0.027, 0.0002)), "tilted"),
        (flat("book", (0.08, 0.11, 0.01)), "tilted"),
        (flat("plate", (0.12, 0.12, 0.009)), "tilted"),
    ],
    ids=lambda value: getattr(value, "name", str(value)),
)
def test_what_lies_flat_on_a_table_is_picked_up(thing: Thing, prepared: str | None) -> None:
    found = effort((thing, TABLE), "grasp")
    assert found.level in {1, 2}
    assert found.evidence_document.get("prepared") == prepared


@pytest.mark.parametrize("sunk", [-0.014, -0.004, 0.004, 0.014])
@pytest.mark.parametrize(
    "thing", [("pencil", (0.004, 0.08, 0.004)), ("mug", (0.04, 0.04, 0.05)), ("tray", (0.1, 0.15, 0.01))]
)
def test_what_was_tracked_into_or_above_its_support_is_grasped_as_if_it_lay_on_it(
    thing: tuple[str, tuple[float, float, float]], sunk: float
) -> None:
    lying, off = (effort((flat(*thing, sunk=by), TABLE), "grasp") for by in (0.0, sunk))
    assert (off.level, off.actions) == (lying.level, lying.actions)
    for key in ("point_m", "prepared", "arms"):
        assert off.evidence_document.get(key) == pytest.approx(lying.evidence_document.get(key), abs=1e-6)
    stage = Room((flat(*thing, sunk=sunk), TABLE), (STANDING,)).stage()
    assert support_of(stage, thing[0], DEFAULT.contact) == "table"


@pytest.mark.parametrize("sunk", [-0.014, -0.004, 0.0, 0.004, 0.008, 0.014])
def test_a_seat_is_found_on_the_floor_too(sunk: float) -> None:
    stage = Room((Thing("pencil", (0.004, 0.08, 0.004), (0.5, 0.0, 0.004 - sunk)),), (STANDING,)).stage()
    assert support_of(stage, "pencil", DEFAULT.contact) == "floor"
    assert seat_m(stage, "pencil", DEFAULT.contact) == pytest.approx(sunk, abs=1e-9)


def test_a_seat_is_not_on_what_stands_beside() -> None:
    """A mug was tracked 3 mm into the side of a box that is lower than the mug."""
    mug, box = flat("mug", (0.04, 0.04, 0.05)), flat("box", (0.05, 0.05, 0.01), x=0.587)
    stage = Room((mug, box, TABLE), (STANDING,)).stage()
    assert seat_m(stage, "mug", DEFAULT.contact) == pytest.approx(0.0, abs=1e-9)


def test_a_book_that_cannot_be_tilted_is_slid_and_one_that_cannot_be_slid_is_not_grasped() -> None:
    book = flat("book", (0.08, 0.11, 0.01))
    lid = Thing("lid", (0.1, 0.13, 0.005), (0.5, 0.1, 0.96), free=False)
    rim = Thing("rim", (0.005, 0.6, 0.03), (0.26, 0.0, 0.95), free=False)
    prepared = [
        effort((book, TABLE, *others), "grasp").evidence_document.get("prepared") for others in ((), (lid,), (rim,))
    ]
    assert prepared == ["tilted", "slid over the edge", "tilted"]
    assert effort((book, TABLE, lid, rim), "grasp").level == 5


def test_a_robot_slides_a_tile_over_the_edge_unless_something_stands_there() -> None:
    robot = Person("P1", (0.0, 0.0), profile="jido")
    tile, top = flat("tile", (0.06, 0.06, 0.004), x=0.58), table(0.9, height=0.92)
    found = effort((tile, top), "grasp", robot)
    assert found.evidence_document["prepared"] == "slid over the edge"
    assert found.evidence_document["point_m"][0] < 0.5 + 1e-6  # type: ignore[index]
    fence = [
        Thing("fence_x", (0.005, 0.6, 0.03), (0.507, 0.0, 0.95), free=False),
        Thing("fence_y", (0.4, 0.005, 0.03), (0.9, 0.25, 0.95), free=False),
        Thing("fence_z", (0.4, 0.005, 0.03), (0.9, -0.1, 0.95), free=False),
    ]
    assert effort((tile, top, *fence), "grasp", robot).level == 5


@pytest.mark.parametrize(
    "thing",
    [
        Thing("carton", (0.15, 0.15, 0.15), (0.5, 0.0, 1.07)),
        Thing("ball", (0.075,), (0.45, 0.1, 0.995), "sphere"),
        Thing("jar", (0.055, 0.06), (0.45, -0.1, 0.98), "cylinder"),
        Thing("pot", (0.12, 0.08), (0.5, 0.0, 1.0), "cylinder"),
    ],
    ids=lambda thing: thing.name,
)
def test_what_is_too_wide_for_one_hand_is_taken_between_both(thing: Thing) -> None:
    found = effort((thing, TABLE), "grasp")
    assert (found.level, found.actions) == (1, ("Stretch_Out_Arm(left)", "Stretch_Out_Arm(right)"))
    assert why(found).startswith(f"P1 grasps the {thing.name} by stretching out both arms;")
    document = found.evidence_document
    left, right = np.array(document["points_m"])
    assert document["arms"] == ["left", "right"]
    np.testing.assert_allclose(right - left, np.array(document["closing"]) * document["width_m"], atol=1e-9)
    assert left[1] > right[1]  # arms do not cross


def test_both_hands_must_be_free_and_get_there() -> None:
    carton = Thing("carton", (0.15, 0.15, 0.15), (0.5, 0.0, 1.07))
    stage = Room((carton, TABLE), (STANDING,)).stage()
    for actions in ({"Stretch_Out_Arm(left)"}, {"Stretch_Out_Arm(right)"}):
        found = effort_from(Viewpoint(stage, "P1", HERE_ONLY, actions=actions), "carton", "grasp")
        assert found.level == 5
        assert found.reason == "too wide (0.30 m > 0.10 m)"
    boards = [Thing(f"board_{y}", (0.2, 0.01, 0.2), (0.5, y, 1.12), free=False) for y in (-0.17, 0.17)]
    boards += [Thing("back", (0.01, 0.18, 0.2), (0.67, 0.0, 1.12), free=False)]
    blocked = effort((carton, TABLE, *boards), "grasp")
    assert (blocked.level, blocked.reason.startswith("every approach blocked by ")) == (5, True)
    beyond = effort((replace(carton, place=(0.4, 0.7, 1.07)), TABLE), "grasp")
    assert beyond.level != 1


def test_a_mirrored_carton_is_taken_by_the_mirrored_hands() -> None:
    carton = Thing("carton", (0.12, 0.14, 0.15), (0.5, 0.1, 1.07), yaw=0.3)
    room = Room((carton, TABLE), (STANDING,))
    one, other = (least_effort(each.stage(), "P1", "carton", "grasp", HERE_ONLY) for each in (room, room.mirrored()))
    assert (one.level, one.amount, one.actions) == (other.level, other.amount, other.actions)
    here, there = (np.array(found.evidence_document["points_m"]) for found in (one, other))
    np.testing.assert_allclose(np.sum(here * (1, -1, 1), axis=0)[[0, 2]], np.sum(there, axis=0)[[0, 2]], atol=1e-6)


@pytest.mark.parametrize(
    ("x", "y", "prepared"),
    [
        (0.0, 0.0, None),
        (0.0, 0.083, "drawn aside"),
        pytest.param(
            *(0.083, 0.083, "drawn aside"),
            marks=pytest.mark.xfail(strict=True, reason="no sampled arm gets into that corner"),
        ),
    ],
)
def test_a_die_in_a_bin_is_drawn_out_of_its_corner(x: float, y: float, prepared: str | None) -> None:
    """A bin of 20 cm, 30 cm deep; the die lies amid, at a wall, or in a corner."""
    walls = [Thing(f"x{s}", (0.005, 0.11, 0.15), (0.4 + 0.105 * s, 0.1, 0.85), free=False) for s in (-1, 1)]
    walls += [Thing(f"y{s}", (0.11, 0.005, 0.15), (0.4, 0.1 + 0.105 * s, 0.85), free=False) for s in (-1, 1)]
    bottom = Thing("bottom", (0.11, 0.11, 0.01), (0.4, 0.1, 0.69), free=False)
    die = Thing("die", (0.015, 0.015, 0.015), (0.4 + x, 0.1 + y, 0.715))
    found = effort((die, bottom, *walls), "grasp")
    assert found.level in {1, 2, 3}
    assert found.evidence_document.get("prepared") == prepared
    packed = [
        Thing(f"block{n}", (0.04, 0.04, 0.04), (0.4 + x + dx, 0.1 + y + dy, 0.74)) for n, (dx, dy) in enumerate(AROUND)
    ]
    assert effort((die, bottom, *packed), "grasp").level == 5


AROUND = [(dx, dy) for dx in (-0.057, 0.0, 0.057) for dy in (-0.057, 0.0, 0.057) if dx or dy]
"""Where blocks stand that leave a die no room."""
