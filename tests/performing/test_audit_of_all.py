"""What an audit looks at besides the performer's arm and its load: hands, fingers, and all that should stay put."""

from dataclasses import replace

import numpy as np
import pytest

from taskgist.errors import UnknownNameError
from taskgist.performing.audit import audit
from taskgist.performing.findings import Audit, MotionLimits
from taskgist.pipeline.performing import limits_of
from taskgist.planning.performer import Performer
from taskgist.settings import DEFAULT
from taskgist.world import Scene
from taskgist.world.geometry.transforms import about_z
from tests.bodies import needs
from tests.performing.motions import HOLD, LIMITS, RATE_HZ, Performance, carry, ramp, scene

ONLOOKER = """[agents.P]
profile = "human"
position_m = [-2.0, 0.0]
"""


@pytest.fixture(scope="module")
def done() -> Performance:
    return carry(more=ONLOOKER)


def found_kinds(found: Audit) -> dict[tuple[str, str], float]:
    return {(each.kind, each.what): each.amount for each in found.findings}


# --- Hands and fingers.


def test_a_thing_that_leaves_the_hand_later_is_found_there(done: Performance) -> None:
    """It is near when it is taken, and lags behind by a hand's breadth in the end."""
    qpos = np.array(done.qpos)
    lag = np.linspace(0.0, 0.15, done.released - done.taken)
    qpos[done.taken : done.released, done.box.start] += lag
    grips = [each for each in done.audited(qpos=qpos).findings if each.kind == "grip"]
    assert [(each.what, each.other, each.frame) for each in grips] == [("box", "J's right hand", done.released - 1)]
    assert grips[0].amount > 0.05
    assert grips[0].frames < done.released - done.taken


def test_only_soft_hands_give(done: Performance) -> None:
    """A thing slips by 4 mm: let pass in the hand of whom that is said of, and of nobody else."""
    qpos = np.array(done.qpos)
    qpos[40:, done.box.start] += np.concatenate((ramp(0.0, 0.004, 2.0), np.full(len(qpos) - 100, 0.004)))

    def with_soft(*names: str) -> Audit:
        return audit(done.scene, done.times_s, qpos, done.holding, LIMITS | {"P": MotionLimits()}, soft=names)

    assert set(found_kinds(with_soft())) == {("drift", "box")}
    assert set(found_kinds(with_soft("P"))) == {("drift", "box")}
    assert with_soft("J").clean
    with pytest.raises(UnknownNameError, match="no agent 'P3'"):
        with_soft("P3")


@pytest.fixture(scope="module")
def pr2() -> Scene:
    return scene(profile="pr2")


FINGERS = ("r_gripper_l_finger_joint", "r_gripper_r_finger_joint", "r_gripper_l_finger_tip_joint")


def opening(room: Scene, duration_s: float, *still: str) -> Audit:
    """A PR2 opens its right hand by 0.2 rad in so long, but for some joints."""
    qpos, frames = np.tile(room.initial.qpos, (31, 1)), 1 + round(duration_s * RATE_HZ)
    joints = room.agent("J").joints
    wide = np.concatenate((np.linspace(0.0, 0.2, frames), np.full(31 - frames, 0.2)))
    for name in (*FINGERS, "r_gripper_r_finger_tip_joint", "r_gripper_l_parallel_root_joint"):
        if name not in still:
            qpos[:, joints[name]] += wide
    limits = {"J": limits_of(Performer(room, "J"), DEFAULT.planning)}
    return audit(room, np.arange(31) / RATE_HZ, qpos, [()] * 31, limits)


@needs("pr2")
def test_fingers_in_haste_are_found(pr2: Scene) -> None:
    """A hand takes 0.7 s from closed to open, 0.548 rad, or longer."""
    assert opening(pr2, 0.3).clean
    found = opening(pr2, 0.2)
    assert {(each.kind, each.what.removeprefix("J/")) for each in found.findings} >= {
        ("speed", name) for name in FINGERS
    }
    fastest = found.findings[0]
    assert fastest.amount == pytest.approx(1.0, rel=0.01)
    assert fastest.allowed == pytest.approx(0.548 / 0.7, rel=0.01)


@needs("pr2")
def test_a_finger_that_does_not_follow_is_found(pr2: Scene) -> None:
    """One motor drives the PR2's fingers and their tips; what carries no shape is not asked."""
    found = opening(pr2, 1.0, "r_gripper_r_finger_joint")
    assert found_kinds(found) == {("coupling", "J/r_gripper_r_finger_joint"): pytest.approx(0.2)}
    assert "J/r_gripper_r_finger_joint is 11.5° from where the joint that it follows has it" in found.findings[0].text
    assert opening(pr2, 1.0, "r_gripper_l_parallel_root_joint").clean


@needs("pr2")
def test_fingers_follow_where_a_scene_gives_their_leader_alone(pr2: Scene) -> None:
    wider = scene(profile="pr2", more="joints_deg = { r_gripper_l_finger_joint = 25 }\n")
    qpos = np.tile(wider.initial.qpos, (3, 1))
    assert audit(wider, np.arange(3.0), qpos, [()] * 3, {"J": MotionLimits()}).clean
    changed = np.flatnonzero(wider.initial.qpos != pr2.initial.qpos)
    joints = wider.agent("J").joints
    assert {joints[name] for name in FINGERS} <= set(changed.tolist())
    assert np.allclose(wider.initial.qpos[[joints[name] for name in FINGERS]], np.deg2rad(25))


# --- Who does nothing.


def test_who_does_nothing_moves_nothing_but_the_head(done: Performance) -> None:
    person = done.scene.agent("P")
    pan, turn = person.profile.pan, person.profile.turn
    assert pan is not None
    assert turn is not None
    for index, amount, what in (
        (person.joints[turn.joint], 0.3, f"P/{turn.joint}"),
        (done.scene.base_slice("P").start, 0.2, "P's base"),
    ):
        qpos = np.array(done.qpos)
        qpos[:, index] += np.concatenate(([0.0], ramp(0.0, amount, (len(qpos) - 1) / RATE_HZ)))
        assert found_kinds(done.audited(qpos=qpos)) == {("stray", what): pytest.approx(amount, abs=1e-3)}
        assert audit(done.scene, done.times_s, qpos, done.holding, LIMITS | {"P": MotionLimits()}).clean
    qpos = np.array(done.qpos)
    qpos[:, person.joints[pan.joint]] += np.concatenate(([0.0], ramp(0.0, 0.5, (len(qpos) - 1) / RATE_HZ)))
    assert done.audited(qpos=qpos).clean, "onlookers look"
    qpos[100:, person.joints[pan.joint]] -= 1.0
    assert found_kinds(done.audited(qpos=qpos)) == {("jump", f"P/{pan.joint}"): pytest.approx(1.0, abs=0.05)}


def test_who_turns_in_place_and_does_nothing_is_found(done: Performance) -> None:
    qpos, base = np.array(done.qpos), done.scene.base_slice("P")
    for row, angle in zip(qpos[1:], ramp(0.0, 0.4, (len(qpos) - 1) / RATE_HZ), strict=True):
        row[base.start + 3 : base.stop] = about_z(angle)
    (finding,) = done.audited(qpos=qpos).findings
    assert (finding.kind, finding.what, finding.unit) == ("stray", "P's base", "rad")
    assert finding.amount == pytest.approx(0.4, abs=1e-3)
    assert "P's base has moved by 22.9°, and nobody moves it" in finding.text


def test_a_door_that_opens_by_itself_is_found() -> None:
    room = carry(
        '<body name="door" pos="3 0 1"><joint name="hinge" axis="0 0 1"/><geom type="box" size="0.4 0.02 0.9"/></body>'
    )
    assert room.audited().clean
    qpos = np.array(room.qpos)
    qpos[:, room.scene.model.joint("hinge").qposadr[0]] += np.linspace(0.0, 0.5, len(qpos))
    assert found_kinds(room.audited(qpos=qpos)) == {("stray", "hinge"): pytest.approx(0.5)}


# --- What is left behind.


def test_what_stands_on_a_thing_that_is_taken_away_does_not_stay_in_the_air() -> None:
    """A pea on the box stays where it is as the box goes; on the post it may stay."""
    room = carry('<body name="pea" pos="0 0 5"><freejoint/><geom type="sphere" size="0.004"/></body>')
    qpos, pea = np.array(room.qpos), room.scene.object_slice("pea")
    x, y, z = qpos[0, room.box][:3]
    qpos[:, pea.start : pea.start + 3] = (x, y, z + 0.039)
    (finding,) = (
        each for each in room.audited(qpos=qpos).findings if each.kind != "penetration"
    )  # the box rises into it
    assert (finding.kind, finding.what) == ("rest", "pea")
    assert room.taken <= finding.frame < room.released
    aside = np.array(qpos)
    aside[:, pea.start : pea.start + 3] = (x - 0.022, y, z - 0.031)
    assert room.audited(qpos=aside).clean
    assert replace(room, qpos=qpos[: room.taken], holding=room.holding[: room.taken]).audited().clean, "until then"
    assert HOLD in room.holding[room.taken]
