"""A robot as a planner needs it: its hand measured, its arms solved, its collisions against MuJoCo alone."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

from taskgist.errors import SceneError, UnknownNameError
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.planning.grasping import Grasping
from taskgist.planning.performer import Performer, refuse_held, with_values
from taskgist.world import Pose, Scene, Stage, State
from taskgist.world.bodies.profile import builtin_profile_text
from tests.bodies import EVERY_BODY, needs
from tests.planning.rooms import TABLE_M, Judge, box, room, two_tables
from tools.rooms import Thing

WITH_PR2 = [pytest.param("pr2", marks=needs("pr2")), "jido"]
TOO_DEEP_M = 0.002


@pytest.fixture(scope="module", params=WITH_PR2)
def performer(request: pytest.FixtureRequest) -> Performer:
    return Performer(two_tables(request.param, box(1.5)), "R")


def drawn(performer: Performer, side: str, rng: np.random.Generator) -> np.ndarray:
    """The start with an arm drawn over its ranges."""
    chain = performer.chain(side)
    values = rng.uniform(np.maximum(chain.low, -math.pi), np.minimum(chain.high, math.pi))
    return with_values(performer.start.qpos, chain.positions, values)


def off(one: Pose, other: Pose) -> tuple[float, float]:
    """How far two poses are apart, metres and radians."""
    cosine = (np.trace(one.matrix.T @ other.matrix) - 1) / 2
    return float(np.linalg.norm(one.position - other.position)), math.acos(float(np.clip(cosine, -1.0, 1.0)))


@pytest.mark.parametrize("profile", EVERY_BODY)
def test_every_body_has_seven_joints_or_as_many_as_its_arm_has_and_its_lift_comes_first(profile: str) -> None:
    performer = Performer(room(profile), "R")
    for side in performer.sides:
        chain = performer.chain(side)
        lifts = chain.lifts.sum()
        assert len(chain) - lifts == (6 if profile == "hrp2" else 7)
        assert chain.lifts[:lifts].all()
        assert lifts == len(performer.agent.lifts)
        assert (chain.low < chain.high).all()
        assert not any("finger" in name or "girdle" in name or "torso_turn" in name for name in chain.names)


@pytest.mark.parametrize("profile", [*WITH_PR2, "talos"])
def test_only_between_its_heights_anything_is_reached(profile: str) -> None:
    performer = Performer(room(profile, box(0.5)), "R")
    low_m, high_m = performer.heights_m
    column, half_m = performer.scene.object_slice("box"), 0.025

    def is_reached(height_m: float) -> bool:
        pose = (0.5, -0.2, height_m, 1.0, 0.0, 0.0, 0.0)
        efforts = SceneEfforts(Stage(performer.scene, performer.start.replace(at=column, to=pose)))
        return efforts.effort("R", "box", "reach", performer.actions).is_known_to_do

    assert [is_reached(height_m) for height_m in (low_m - half_m - 0.001, high_m + half_m + 0.001)] == [False, False]
    if performer.drives:
        assert [is_reached(height_m) for height_m in (max(low_m, 0.0) + 0.08, high_m - 0.08)] == [True, True], (
            "not much narrower"
        )


@pytest.mark.parametrize("profile", EVERY_BODY)
def test_solved_poses_are_met_by_the_whole_robot_within_limits_and_nothing_else_moves(profile: str) -> None:
    performer, rng = Performer(room(profile), "R"), np.random.default_rng(3)
    side = performer.sides[-1]
    chain, solved = performer.chain(side), 0
    for _ in range(8):
        wanted = performer.palm(drawn(performer, side, rng), side)
        for found in performer.ik(side, wanted, performer.start.qpos):
            away_m, turned_rad = off(performer.palm(found, side), wanted)
            assert away_m < 0.002
            assert turned_rad < math.radians(1.0)
            values = found[chain.positions]
            assert (values >= chain.low).all()
            assert (values <= chain.high).all()
            others = np.setdiff1d(np.arange(len(found)), chain.positions)
            np.testing.assert_array_equal(found[others], performer.start.qpos[others])
            solved += 1
    assert solved >= 6  # people's shoulders do not take all that their hinges would


def test_nearest_configuration_comes_first_and_the_same_question_has_the_same_answer(performer: Performer) -> None:
    side = performer.sides[0]
    wanted = performer.palm(drawn(performer, side, np.random.default_rng(5)), side)
    found = performer.ik(side, wanted, performer.start.qpos, starts=8, most=4)
    again = performer.ik(side, wanted, performer.start.qpos, starts=8, most=4)
    assert len(found) > 1
    np.testing.assert_array_equal(np.array(found), np.array(again))
    chain, now = performer.chain(side), performer.start.qpos
    costs = [np.abs(each - now)[chain.positions] @ chain.weights for each in found]
    assert costs == sorted(costs)


def test_where_no_arm_gets_there_is_no_configuration(performer: Performer) -> None:
    side = performer.sides[0]
    palm = performer.palm(performer.start.qpos, side)
    assert performer.ik(side, Pose(palm.position + (3.0, 0.0, 0.0), palm.matrix), performer.start.qpos) == []


def test_a_lift_that_may_not_move_stays(performer: Performer) -> None:
    side = performer.sides[0]
    chain, now = performer.chain(side), performer.start.qpos
    palm = performer.palm(now, side)
    raised = Pose(palm.position + (0.0, 0.0, 0.05), palm.matrix)
    for found in performer.ik(side, raised, now, lift=False):
        np.testing.assert_allclose(found[chain.positions][chain.lifts], now[chain.positions][chain.lifts], atol=1e-9)


def test_the_base_moves_and_turns_upright(performer: Performer) -> None:
    moved = performer.at(performer.start.qpos, (0.3, -0.2, 2.0))
    assert performer.base(moved) == pytest.approx((0.3, -0.2, 2.0))
    before, after = (
        Stage(performer.scene, State(q)).body(performer.agent.root_body) for q in (performer.start.qpos, moved)
    )
    assert after.position[2] == before.position[2]
    assert after.matrix[2, 2] == pytest.approx(1.0)


# --- Hands.


def opening_m(performer: Performer, side: str, qpos: np.ndarray) -> float:
    """How far two balls, one on each side of the middle, can be moved apart before they touch the fingers: by hand."""
    scene, arm, gripper = performer.scene, performer.agent.arm(side), performer.gripper(side)
    data = mujoco.MjData(scene.model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(scene.model, data)
    matrix = data.site_xmat[arm.palm_site].reshape(3, 3) @ gripper.axes
    tips = max(
        float(
            (data.geom_xpos[g] + data.geom_xmat[g].reshape(3, 3) @ corner - data.site_xpos[arm.palm_site])
            @ matrix[:, 0]
        )
        for g in arm.hand_geoms
        for corner in vertices(scene.model, int(g))
    )
    point = data.site_xpos[arm.palm_site] + (tips - 0.010) * matrix[:, 0]
    probe = int(scene.solid_geoms_of("box")[0])
    scene.model.geom_size[probe], before = 1e-4, scene.model.geom_size[probe].copy()
    gaps = []
    for sign in (1.0, -1.0):
        for gone in np.arange(0.0, 0.08, 0.0005):
            data.geom_xpos[probe] = point + sign * gone * matrix[:, 1]
            if any(mujoco.mj_geomDistance(scene.model, data, int(g), probe, 0.1, None) <= 0 for g in arm.hand_geoms):
                gaps.append(float(gone))
                break
    scene.model.geom_size[probe] = before
    return sum(gaps)


def vertices(model: mujoco.MjModel, geom: int) -> np.ndarray:
    """Points of a shape that span it."""
    mesh = int(model.geom_dataid[geom])
    if mesh >= 0:
        return np.array(model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]], dtype=float)
    return np.asarray(np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * model.geom_size[geom])


@needs("pr2")
@pytest.mark.parametrize("wanted_m", [0.03, 0.06, 0.085])
def test_the_pr2_opens_as_wide_as_it_is_told_all_four_finger_joints_together(wanted_m: float) -> None:
    performer = Performer(two_tables("pr2", box(1.5)), "R")
    qpos = performer.opened(performer.start.qpos, "left", wanted_m)
    assert opening_m(performer, "left", qpos) == pytest.approx(wanted_m, abs=0.004)
    fingers = [qpos[performer.agent.joints[f"l_gripper_{name}_joint"]] for name in ("l_finger", "r_finger")]
    tips = [qpos[performer.agent.joints[f"l_gripper_{name}_finger_tip_joint"]] for name in ("l", "r")]
    assert np.ptp([*fingers, *tips]) == 0.0


@needs("talos")
def test_a_hand_whose_fingers_move_otherwise_is_measured_as_well() -> None:
    gripper = Performer(room("talos"), "R").gripper("left")
    assert 0.0 < gripper.narrowest_m < 0.03 < 0.08 < gripper.widest_m
    assert len(gripper.positions) == 7


def test_fingers_that_do_not_open_are_named() -> None:
    gripper = Performer(room("hrp2"), "R").gripper("right")
    assert gripper.too_narrow(0.05) is None
    assert gripper.too_narrow(0.07) == "the right hand is open by 0.060 m, not by 0.070 m: no joint of it opens it"


# --- Collisions.


def test_the_start_is_free_whatever_overlaps_there(performer: Performer) -> None:
    assert performer.blocking(performer.start.qpos) is None
    assert performer.blocking(performer.at_rest(performer.start.qpos)) is None


def test_what_is_called_free_is_free_by_mujoco_alone_and_what_is_blocked_is_not(performer: Performer) -> None:
    judge, rng = Judge(performer.scene), np.random.default_rng(7)
    free = blocked = 0
    for number in range(60):
        qpos = drawn(performer, performer.sides[number % len(performer.sides)], rng)
        qpos = performer.at(
            qpos, (float(rng.uniform(0.5, 1.5)), float(rng.uniform(-0.3, 0.3)), float(rng.uniform(-1, 1)))
        )
        depth_m, between = judge.deepest(qpos)
        found = performer.blocking(qpos)
        if found is None:
            assert depth_m < TOO_DEEP_M, between
            free += 1
        elif not found.other.startswith("R/"):  # own pairs that touch at the start count where they are deeper then
            assert depth_m > 0.0005
            blocked += 1
    assert free > 2
    assert blocked > 10


def test_the_two_sides_of_a_collision_are_named(performer: Performer) -> None:
    found = performer.blocking(performer.at(performer.start.qpos, (1.5, 0.0, 0.0)))
    assert found is not None
    assert found.other == "table"
    assert found.part in performer.agent.parts
    assert found.depth_m > 0.01


def test_an_arm_against_its_own_body_is_named(performer: Performer) -> None:
    rng, met = np.random.default_rng(1), set()
    away = performer.at(performer.start.qpos, (0.0, 3.0, 0.0))
    for _ in range(60):
        chain = performer.chain(performer.sides[0])
        arm = drawn(performer, performer.sides[0], rng)[chain.positions]
        found = performer.blocking(with_values(away, chain.positions, arm))
        if found is not None:
            met.add(found.other)
    assert any(other.startswith("R/") for other in met)


def test_a_load_goes_with_the_hand_and_collides(performer: Performer) -> None:
    side, scene = performer.sides[0], performer.scene
    palm = performer.palm(performer.start.qpos, side)
    held = np.array(performer.start.qpos)
    held[scene.object_slice("box")] = (*palm.position, 1, 0, 0, 0)
    grip = performer.grip(held, "box", side)
    assert performer.blocking(held, grip) is None
    moved = performer.at(held, (0.2, 0.1, 0.5))
    at = Stage(scene, State(performer.carried(moved, grip))).body(scene.object_body("box"))
    palm = performer.palm(moved, side)
    np.testing.assert_allclose(palm.to_world(grip.in_palm.position), at.position, atol=1e-9)
    np.testing.assert_allclose(palm.matrix @ grip.in_palm.matrix, at.matrix, atol=1e-9)
    met = set()
    for x in np.arange(0.3, 1.3, 0.02):  # into a table, with the load first or the robot
        found = performer.blocking(performer.at(held, (float(x), 0.0, 0.0)), grip)
        met |= {found.other} if found else set()
    assert "table" in met


# --- Bad input.


def test_an_unknown_agent_is_refused_with_those_that_are_there() -> None:
    with pytest.raises(UnknownNameError, match="no agent 'P9'"):
        Performer(room("jido"), "P9")


def test_a_body_without_a_hand_is_refused() -> None:
    text = builtin_profile_text("jido").partition("[hand]")[0]
    scene = room("jido")
    without = Scene.from_bundle({**scene.bundle, "R.profile.toml": text.encode()})
    with pytest.raises(SceneError, match="R has no hand that grasps"):
        Performer(without, "R")


# --- How it begins.


@pytest.mark.parametrize("robot", WITH_PR2)
def test_a_robot_that_stands_in_a_table_is_bad_input_and_one_beside_it_is_not(robot: str) -> None:
    wall = Thing("wall", (0.1, 1.0, 0.6), (1.5, 0.0, 0.6), free=False)
    far = room(robot, wall)
    own = np.intersect1d(far.agent("R").geoms, far.solid_geoms)
    gap_m = Stage(far).closest(own, far.solid_geoms_of("wall"), limit_m=2.0)[0]
    for deep_m, fits in ((-0.001, True), (0.0005, True), (0.003, False), (0.05, False)):
        nearer = Thing("wall", (0.1, 1.0, 0.6), (1.5 - gap_m - deep_m, 0.0, 0.6), free=False)
        if fits:
            assert Performer(room(robot, nearer), "R").blocking(room(robot, nearer).initial.qpos) is None
            continue
        with pytest.raises(SceneError) as caught:
            Performer(room(robot, nearer), "R")
        text = str(caught.value)
        assert "R begins in something" in text
        assert f"is {1000 * deep_m:.0f} mm deep in wall" in text
        assert "place it elsewhere" in text


def test_a_robot_that_begins_in_itself_is_bad_input() -> None:
    performer = Performer(room("jido"), "R")
    rng, chain = np.random.default_rng(2), performer.chain("right")
    for _ in range(300):
        qpos = drawn(performer, "right", rng)
        blocked = performer.blocking(qpos)
        if blocked is not None and blocked.other.startswith("R/") and blocked.depth_m > 0.01:
            break
    else:
        pytest.fail("no arm was drawn that is in its own body")
    with pytest.raises(SceneError, match=r"R begins in .*: .* mm deep in R/"):
        Performer(performer.scene, "R", start=State(qpos))
    assert len(chain)


def test_a_thing_in_its_table_is_bad_input() -> None:
    sunk = Thing("box", (0.025,) * 3, (1.5, 0.0, TABLE_M + 0.015))
    with pytest.raises(SceneError, match=r"the box is 10.0 mm deep in table; place it on or beside that"):
        Grasping(Performer(two_tables("jido", sunk), "R"), two_tables("jido", sunk).initial, "box")
    Grasping(Performer(two_tables("jido", box(1.5)), "R"), two_tables("jido", box(1.5)).initial, "box")


def test_who_holds_something_at_the_start_is_told() -> None:
    scene = two_tables("jido", box(1.5), Thing("cup", (0.02, 0.02, 0.02), (1.7, 0.3, TABLE_M + 0.02)))
    refuse_held(scene, scene.initial, "R", "box")
    performer = Performer(scene, "R")
    palm = performer.palm(scene.initial.qpos, "right")
    in_hand = (*palm.to_world(np.zeros(3)), 1.0, 0.0, 0.0, 0.0)
    held = scene.initial.replace(at=scene.object_slice("cup"), to=in_hand)
    with pytest.raises(SceneError, match="R holds the cup in its right hand"):
        refuse_held(scene, held, "R", "box")
    with pytest.raises(SceneError, match="the cup is held by R, in the right hand"):
        refuse_held(scene, held, "R", "cup")
    with pytest.raises(UnknownNameError):
        refuse_held(scene, held, "R", "spoon")
