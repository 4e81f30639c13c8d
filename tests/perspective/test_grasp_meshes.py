"""Grasps on meshes: handles, rims, shelves that are reached into from the front."""

import re
from dataclasses import replace

import numpy as np
import pytest

from taskgist.perspective import Ability, Effort, least_effort
from taskgist.perspective.grasp_sampling import (
    MOST,
    TOUCH_M,
    Grasps,
    grasps_in_object,
    hand_centers,
    hand_frames,
    opposite_points,
)
from taskgist.settings import DEFAULT
from taskgist.world import Scene, Stage, distances_outside_m
from tests import meshes
from tests.meshes import Mesh, mesh_scene
from tests.perspective.twin_grasp import touched
from tests.scenes import agent, cylinder

HERE_ONLY = replace(DEFAULT, efforts=replace(DEFAULT.efforts, move_radius_m=0.0))
P1 = agent("P1", 0, 0)


def with_thing(mesh: Mesh, place: tuple[float, float, float] = (0.5, 0.2, 1.15)) -> Scene:
    return mesh_scene(meshes.body("thing", "thing", place), P1, thing=mesh)


def free_grasps(scene: Scene) -> Grasps:
    hand = scene.agent("P1").profile.hand
    assert hand is not None
    grasps = grasps_in_object(Stage(scene), "thing", hand, DEFAULT.grasp)
    return grasps.only(~grasps.in_itself)


def effort(scene: Scene, name: str, who: str = "P1") -> Effort:
    return least_effort(Stage(scene), who, name, "grasp", HERE_ONLY)


def test_a_mugs_handle_can_be_grasped_and_its_inside_cannot() -> None:
    scene = with_thing(meshes.mug())
    grasps = free_grasps(scene)
    on_handle = np.hypot(*grasps.centers[:, :2].T) > 0.06
    assert on_handle.any()
    assert grasps.widths_m[on_handle].min() == pytest.approx(0.012, abs=1e-3)
    assert (grasps.approaches[on_handle][:, 0] < 0.9).all()  # never from within the mug
    assert effort(scene, "thing").level == 1


def pair_widths_m(mesh: Mesh, within_m: float) -> set[float]:
    scene = with_thing(mesh)
    at_origin = scene.initial.replace(at=scene.object_slice("thing"), to=(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0))
    pairs = opposite_points(Stage(scene, at_origin), "thing", DEFAULT.grasp, within_m)
    return {round(float(width), 3) for width in pairs.widths_m}


def test_a_mugs_rim_is_taken_between_a_thumb_and_fingers() -> None:
    """The thumb, 22 mm broad, fits into a mug of 7 cm; a pad as broad as four fingers would not."""
    scene = with_thing(meshes.cup(around=32))
    grasps = free_grasps(scene)
    at_the_rim = grasps.only((grasps.widths_m < 0.01) & (np.abs(grasps.closings[:, 2]) < 0.5))
    assert len(at_the_rim)
    inwards = np.sum(at_the_rim.closings * at_the_rim.centers * (1, 1, 0), axis=1)
    assert (inwards > 0).all()  # from the thumb's point outwards to the fingers'


def test_a_mug_without_a_handle_is_held_around_its_outside() -> None:
    scene = with_thing(meshes.cup(around=32))
    grasps = free_grasps(scene)
    above_the_bottom = grasps.only(grasps.centers[:, 2] > 0.02)
    around = above_the_bottom.only(above_the_bottom.widths_m > 0.02)
    assert len(around)
    assert around.widths_m.min() == pytest.approx(0.08, abs=1e-3)
    assert np.hypot(*around.centers[:, :2].T).max() < 0.01
    assert effort(scene, "thing").level == 1


def test_behind_a_wall_faces_count_as_far_as_the_hand_opens() -> None:
    """Two boards stand 4 cm apart, each 1 cm thick, a third far behind them; all are 40 cm wide."""
    boards = [meshes.board((0, y, 0), (0.2, 0.005, 0.2)) for y in (0.0, 0.05, 0.35)]
    mesh = meshes.joined(*boards)
    assert pair_widths_m(mesh, 0.1) == {0.01, 0.06, 0.4}
    assert pair_widths_m(mesh, 0.05) == {0.01, 0.4}
    assert pair_widths_m(mesh, 0.5) == {0.01, 0.06, 0.31, 0.36, 0.4}
    assert pair_widths_m(boards[0], 0.005) == {0.01, 0.4}  # whatever the hand, first faces tell how wide it is


def test_a_large_shape_is_sampled_sparsely_and_its_handle_still_found() -> None:
    tub = meshes.revolved([(1e-4, 0), (0.18, 0), (0.18, 0.3), (0.17, 0.3), (0.17, 0.01), (1e-4, 0.01)], 32)
    scene = with_thing(meshes.joined(tub, meshes.handle(at=0.178)))
    hand = scene.agent("P1").profile.hand
    assert hand is not None
    grasps = grasps_in_object(Stage(scene), "thing", hand, DEFAULT.grasp)
    assert DEFAULT.grasp.approaches < len(grasps) <= 6 * MOST * DEFAULT.grasp.approaches
    assert (np.abs(grasps.widths_m - 0.012) < 1e-3).any()


def test_quick_tests_of_a_hand_in_a_mesh_find_what_measuring_every_pair_finds() -> None:
    scene = with_thing(meshes.cup())
    at_origin = scene.initial.replace(at=scene.object_slice("thing"), to=(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0))
    stage, profile = Stage(scene, at_origin), scene.agent("P1").profile
    assert profile.hand is not None
    grasps, arm = grasps_in_object(stage, "thing", profile.hand, DEFAULT.grasp), scene.agent("P1").arms[0]
    palm = int(arm.ghosts[0])
    seen = set()
    for index in range(0, len(grasps), 23):
        stage.place(arm.ghosts, hand_centers(grasps, profile.hand)[index], hand_frames(grasps)[index].reshape(9))
        by_design = touched(grasps, index)
        met = [
            depth_m
            for ghost, solid, depth_m in stage.overlaps(arm.ghosts, grasps.solids)
            if (ghost == palm or solid not in by_design) and abs(depth_m - TOUCH_M) > 1e-5
        ]
        assert bool(grasps.in_itself[index]) == any(depth_m > TOUCH_M for depth_m in met)
        seen.add(bool(grasps.in_itself[index]))
    assert seen == {True, False}


def test_how_far_points_are_outside_is_the_same_as_far_as_it_is_asked() -> None:
    scene = with_thing(meshes.octahedron(0.05))
    (solid,) = scene.solid_geoms_of("thing").tolist()
    points = np.random.default_rng(3).uniform(-0.1, 0.1, (500, 3))
    whole = distances_outside_m(scene.model, solid, points)
    some = distances_outside_m(scene.model, solid, points, within_m=0.02)
    near = whole <= 0.02
    assert near.any()
    np.testing.assert_array_equal(some[near], whole[near])
    assert (some[~near] > 0.02).all()
    assert (some <= whole).all()


def test_a_handle_counts_where_the_tub_is_too_wide() -> None:
    tub = meshes.board((0, 0, 0.09), (0.11, 0.11, 0.09))
    alone = effort(with_thing(tub), "thing")
    assert alone.evidence_document["arms"] == ["left", "right"]
    found = effort(with_thing(meshes.joined(tub, meshes.handle(at=0.11, out=0.05, half=0.05))), "thing")
    assert found.level is not None
    assert found.level < 5
    assert found.evidence_document["width_m"] == pytest.approx(0.012, abs=1e-3)


def test_a_bowl_is_taken_at_its_rim_from_above() -> None:
    grasps = free_grasps(with_thing(meshes.bowl()))
    assert (grasps.centers[:, 2] > -0.03).any()
    assert (grasps.approaches[:, 2] < 0.3).all()
    assert (grasps.approaches[:, 2] < -0.3).mean() > 0.8
    assert (grasps.gaps_m > DEFAULT.grasp.clearance_m).mean() > 0.7  # straight fingers need room for the curved wall


@pytest.mark.parametrize(
    ("mesh", "widths_m"),
    [
        (meshes.board((0, 0, 0), (0.15, 0.15, 0.15)), set()),  # nothing
        (meshes.board((0, 0, 0), (0.15, 0.15, 0.03)), {0.06}),  # one pair of faces, at the edges
        (meshes.board((0, 0, 0), (0.15, 0.15, 0.004)), {0.008}),  # a thin plate
        (meshes.board((0, 0, 0), (0.04, 0.03, 0.02)), {0.04, 0.06, 0.08}),  # all faces
    ],
)
def test_faces_that_a_hand_can_close_on(mesh: Mesh, widths_m: set[float]) -> None:
    scene = with_thing(mesh)
    grasps = free_grasps(scene)
    assert {round(float(width), 4) for width in grasps.widths_m} == widths_m
    half = np.ptp(mesh[0], axis=0) / 2
    if half.max() > 0.1:  # the palm stays out of the plate
        assert (np.abs(grasps.centers) > 0.15 - 0.09).any(axis=1).all()
    assert ("arms" in effort(scene, "thing").evidence_document) == (not widths_m)


def in_shelf() -> Scene:
    bodies = meshes.body("shelf", "shelf", (0.75, 0, 0), free=False) + cylinder("can", 0.82, 0, 1.08, 0.03, 0.06)
    return mesh_scene(bodies, agent("P1", 0.2, 0.1) + agent("P2", 1.4, 0.1, yaw_deg=180), shelf=meshes.shelf())


def test_a_shelf_is_reached_into_from_the_front_and_not_through_its_back() -> None:
    scene = in_shelf()
    front = effort(scene, "can")
    assert front.level in {1, 2}  # at arm's length
    assert front.evidence_document["approach"][0] > 0.6  # type: ignore[index]
    abilities: tuple[Ability, ...] = ("reach", "grasp")
    for ability in abilities:
        behind = least_effort(Stage(scene), "P2", "can", ability, HERE_ONLY)
        assert behind.level == 5
        assert re.fullmatch("the way of the (left|right) arm is blocked by shelf", behind.reason)
        assert behind.evidence_document["miss"]["in_the_way"]["shelf"] > 0  # type: ignore[index]


def _wall(axis: int, away_m: float, around: tuple[float, float, float]) -> str:
    """A wall square to an axis."""
    place, half = np.array(around), np.full(3, 0.13)
    place[axis] += away_m
    half[axis] = 0.005
    at, size = (" ".join(map(str, values)) for values in (place, half))
    return f'<body name="cage{axis}{away_m}" pos="{at}"><geom type="box" size="{size}"/></body>'


def test_the_way_in_must_be_free_not_only_the_grasp() -> None:
    """The hand fits around the can, but a board just before it is in its way."""
    bodies = cylinder("can", 0.5, 0.2, 1.1, 0.03, 0.06)
    walls = [(axis, sign) for axis in range(3) for sign in (-1, 1)]
    cage = "".join(_wall(axis, sign * 0.125, (0.5, 0.2, 1.1)) for axis, sign in walls)
    rough = replace(HERE_ONLY, reach=replace(DEFAULT.reach, model="sector"))
    free = effort(mesh_scene(bodies, P1), "can")
    caged = least_effort(Stage(mesh_scene(bodies + cage, P1)), "P1", "can", "grasp", rough)
    assert free.level == 1
    assert caged.level == 5
    assert caged.reason.startswith("every approach blocked by cage")
    assert sum(caged.evidence_document["miss"]["approaches"].values()) > 0  # type: ignore[index]


def test_grasps_go_with_their_object_and_are_sampled_once() -> None:
    scene = with_thing(meshes.mug())
    stage, hand = Stage(scene), scene.agent("P1").profile.hand
    assert hand is not None
    first = grasps_in_object(stage, "thing", hand, DEFAULT.grasp)
    moved = stage.state.replace(at=scene.object_slice("thing"), to=(3, 2, 1, 0.6, 0, 0, 0.8))
    assert grasps_in_object(stage.show(moved), "thing", hand, DEFAULT.grasp) is first
    with pytest.raises(ValueError, match="read-only"):
        first.centers[0] = 0.0
    coarse = grasps_in_object(stage, "thing", hand, replace(DEFAULT.grasp, approaches=4))
    assert len(coarse) * 2 == len(first)


def test_a_lid_that_opens_changes_the_grasps() -> None:
    joint = '<joint name="lid" type="slide" axis="0 0 1"/>'
    lid = f'<body pos="0 0 0.03">{joint}<geom type="box" size="0.03 0.03 0.005"/></body>'
    body = f'<body name="thing" pos="0.5 0.2 1"><freejoint/><geom type="box" size="0.03 0.03 0.02"/>{lid}</body>'
    scene = mesh_scene(body, P1)
    (lifted,) = scene.inner_joints("thing")
    stage, hand = Stage(scene), scene.agent("P1").profile.hand
    assert hand is not None
    shut = grasps_in_object(stage, "thing", hand, DEFAULT.grasp)
    open_ = grasps_in_object(stage.show(stage.state.replace({int(lifted): 0.3})), "thing", hand, DEFAULT.grasp)
    assert shut.centers[:, 2].max() == pytest.approx(0.03, abs=0.006)
    assert open_.centers[:, 2].max() == pytest.approx(0.33, abs=0.006)
