import json
import time

import mujoco
import numpy as np
import pytest

from taskgist.common.arrays import Array
from taskgist.errors import InputError, UnknownNameError
from taskgist.performing.audit import audit
from taskgist.performing.findings import Audit, Finding, MotionLimits
from taskgist.performing.penetrations import Motion
from taskgist.pipeline import shipped_room
from taskgist.recording.recording import rounded
from taskgist.world import Hold, Scene, Stage, State
from taskgist.world.geometry.transforms import about_z, multiply
from tests.performing.motions import GRASP, HOLD, LIMITS, RATE_HZ, Performance, carry, ramp, scene, with_arm


@pytest.fixture(scope="module")
def done() -> Performance:
    return carry()


def kinds(found: Audit) -> set[str]:
    return {finding.kind for finding in found.findings}


def only(found: Audit, kind: str) -> Finding:
    assert kinds(found) == {kind}, [finding.text for finding in found.findings]
    return max(found.findings, key=lambda finding: finding.amount)


def board(name: str, at: tuple[float, float, float], half: tuple[float, float, float]) -> str:
    place, size = (" ".join(map(str, each)) for each in (at, half))
    return f'<body name="{name}" pos="{place}"><geom type="box" size="{size}"/></body>'


# --- Clean motions.


def test_a_good_performance_is_clean(done: Performance) -> None:
    found = done.audited()
    assert found.clean, [finding.text for finding in found.findings]
    assert found.frames == len(done.qpos)
    assert found.duration_s == pytest.approx((len(done.qpos) - 1) / RATE_HZ)
    assert found.gaps_m["J to post"] == pytest.approx(0.0136, abs=0.001)


def test_it_is_clean_at_other_rates_as_well(done: Performance) -> None:
    fine = np.array([row for step in range(len(done.qpos) - 1) for row in between(done, step, 4)] + [done.qpos[-1]])
    held = [each for each in done.holding[:-1] for _ in range(4)] + [done.holding[-1]]
    times_s = np.arange(len(fine)) / (4 * RATE_HZ)
    assert audit(done.scene, times_s, fine, held, {"J": MotionLimits()}).clean
    assert audit(done.scene, done.times_s[::2], done.qpos[::2], done.holding[::2], LIMITS).clean


def between(done: Performance, frame: int, count: int) -> list[Array]:
    model, step, rows = done.scene.model, np.zeros(done.scene.model.nv), []
    mujoco.mj_differentiatePos(model, step, 1.0, done.qpos[frame], done.qpos[frame + 1])
    for share in np.arange(count) / count:
        row = np.array(done.qpos[frame])
        mujoco.mj_integratePos(model, row, step, share)
        rows.append(row)
    return rows


def test_what_stands_in_a_carried_box_goes_with_it() -> None:
    """A pea on the box's top moves with it, and is no free thing that flies."""
    room = carry('<body name="pea" pos="0 0 5"><freejoint/><geom type="sphere" size="0.004"/></body>')
    pea, box = room.scene.object_slice("pea"), room.box
    qpos = np.array(room.qpos)
    stage = Stage(room.scene)
    for row in qpos:
        body = stage.show(State(row)).body(room.scene.object_body("box"))
        row[pea] = (*body.to_world((0.0, 0.0, 0.039)), *row[box][3:])
    found = room.audited(qpos=qpos)
    assert found.clean, [finding.text for finding in found.findings]
    still = np.array(qpos)
    still[120:, pea] = qpos[120, pea]
    finding = next(each for each in room.audited(qpos=still).findings if each.kind == "rest")
    assert finding.what == "pea"
    assert finding.frame >= 120


def test_what_is_elsewhere_does_not_ride_on_what_is_held() -> None:
    """A cube that glides over the floor, slowly, while a hand holds something still."""
    room = carry('<body name="cube" pos="2 2 0.02"><freejoint/><geom type="box" size="0.02 0.02 0.02"/></body>')
    held = next(frame for frame in range(room.taken + 20, room.released))
    qpos = np.repeat(room.qpos[held][None], 120, axis=0)
    still = room.audited(qpos=qpos, holding=(frozenset({HOLD}),) * 120)
    assert not [each for each in still.findings if each.what == "cube"]
    qpos[:, room.scene.object_slice("cube").start] += np.linspace(0.0, 0.2, 120)
    found = room.audited(qpos=qpos, holding=(frozenset({HOLD}),) * 120)
    assert "cube" in {each.what for each in found.findings}


# --- Penetrations.


def swung(*bodies: str, frames: int = 4) -> tuple[Scene, Array, Array]:
    """An arm swung aside by half a radian in a few frames, a second each."""
    room = scene(*bodies)
    start = with_arm(room, GRASP)
    qpos = np.tile(start.qpos, (frames, 1))
    qpos[:, room.agent("J").joints["arm_1"]] += np.linspace(0.0, 1.0, frames)
    return room, np.arange(frames, dtype=float), qpos


def hand_between(frames: int) -> tuple[float, float, float]:
    """Where the palm is half-way between the first two of the frames."""
    room, _, qpos = swung(frames=2 * frames - 1)
    palm = Stage(room, State(qpos[1])).site(room.agent("J").arms[0].palm_site).position
    x, y, z = palm.tolist()
    return x, y, z


def test_a_hand_through_a_sheet_between_two_frames_is_found() -> None:
    x, y, z = hand_between(3)
    angle = float(np.degrees(np.arctan2(y, x)))
    sheet = f"""<body name="sheet" pos="{x} {y} {z}" euler="0 0 {angle}">
    <geom type="box" size="0.1 0.001 0.1"/></body>"""
    room, times_s, qpos = swung(sheet, frames=3)
    stage = Stage(room)
    mine, others = room.solid_geoms_of("J"), room.solid_geoms_of("sheet")
    for row in qpos:
        assert not list(stage.show(State(row)).overlaps(mine, others)), "the frames themselves are free"
    found = audit(room, times_s, qpos, [()] * len(qpos), {"J": MotionLimits()})
    finding = only(found, "penetration")
    assert finding.other == "sheet"
    assert 0.0 < finding.time_s < 1.0
    assert f"at {finding.time_s:.2f} s J/" in finding.text
    assert "deep in sheet" in finding.text


def test_the_load_through_a_bar_is_found() -> None:
    """Amid its path there is a thin bar that only the lower end of a long box meets."""
    plain = carry(deeper_m=0.05)
    middle = Stage(plain.scene, State(plain.qpos[(plain.taken + plain.released) // 2]))
    x, y, z = middle.body(plain.scene.object_body("box")).to_world((0.0, 0.0, -0.085)).tolist()
    room = carry(board("bar", (x, y, z), (0.1, 0.002, 0.006)), deeper_m=0.05)
    finding = only(room.audited(), "penetration")
    assert (finding.what, finding.other) == ("box", "bar")
    assert 0.002 < finding.amount < 0.02


def test_a_base_that_drives_into_something_is_found_and_all_of_it() -> None:
    room = carry(board("crate", (0.0, 1.0, 0.1), (0.1, 0.55, 0.1)))
    finding = only(room.audited(), "penetration")
    assert finding.other == "crate"
    assert finding.what.startswith("J/")
    assert finding.frames > 10


@pytest.mark.parametrize("moving", [True, False])
def test_a_robot_that_begins_in_something_is_found_there(moving: bool) -> None:
    """A crate 5 mm in its base, which drives away from it, or stays where it is while its head turns."""
    base = Stage(scene()).bounds(scene().agent("J").core_geoms)
    room = scene(board("crate", (0.0, float(base[1, 1]) + 0.095, 0.1), (0.1, 0.1, 0.1)))
    qpos = np.tile(room.initial.qpos, (31, 1))
    index = room.base_slice("J").start + 1 if moving else room.agent("J").joints["head_pan"]
    qpos[:, index] -= np.concatenate(([0.0], ramp(0.0, 0.1, 1.0)))
    finding = only(audit(room, np.arange(31) / RATE_HZ, qpos, [()] * 31, {"J": MotionLimits()}), "penetration")
    assert (finding.frame, finding.other) == (0, "crate")
    assert finding.amount == pytest.approx(0.005, abs=0.001)
    assert finding.allowed == 0.0


@pytest.mark.parametrize(("sunk_m", "clean"), [(0.0015, True), (0.003, False), (0.006, False)])
def test_a_thing_rests_on_what_carries_it_and_not_in_it(sunk_m: float, clean: bool) -> None:
    """The posts reach a little into the box that stands on them."""
    found = carry(higher_m=(sunk_m, sunk_m)).audited()
    assert found.clean == clean, [finding.text for finding in found.findings]
    if not clean:
        assert {(each.kind, each.what) for each in found.findings} == {("penetration", "box")}
        assert (found.findings[0].frame, found.findings[0].other) == (0, "post")


def test_people_may_be_in_what_they_sit_on() -> None:
    people = Scene.load(shipped_room())
    qpos = np.tile(people.initial.qpos, (10, 1))
    chair, own = people.solid_geoms_of("chair"), people.solid_geoms_of("P2")
    assert max(depth for *_, depth in Stage(people).overlaps(own, chair)) > 0.03
    pan = people.agent("P2").profile.pan
    assert pan is not None
    qpos[:, people.agent("P2").joints[pan.joint]] -= np.linspace(0.0, 0.1, 10)
    assert audit(people, np.arange(10.0), qpos, [()] * 10, {"P2": MotionLimits()}).clean
    qpos[:, people.base_slice("P2").start + 2] -= 0.04
    finding = only(audit(people, np.arange(10.0), qpos, [()] * 10, {"P2": MotionLimits()}), "penetration")
    assert finding.other == "chair"


def turned_past_a_wall(depth_m: float, share: float) -> tuple[Scene, Array]:
    """Jido turns in place, and a corner of its base is deepest in a wall between two frames, after a share of them."""

    def gaps_m(room: Scene, yaws: Array) -> Array:
        stage, found = Stage(room), []
        for yaw in yaws:
            state = room.initial.replace(
                at=slice(room.base_slice("J").start + 3, room.base_slice("J").stop), to=about_z(yaw)
            )
            found.append(
                stage.show(state).closest(room.solid_geoms_of("J"), room.solid_geoms_of("wall"), limit_m=2.0)[0]
            )
        return np.array(found)

    yaws = np.linspace(0.3, 1.2, 181)
    gaps = gaps_m(scene(board("wall", (1.6, 0.0, 0.1), (0.1, 1.0, 0.1))), yaws)
    nearest = int(gaps.argmin())
    assert 0 < nearest < len(yaws) - 1, "a corner comes by"
    room = scene(board("wall", (1.6 - gaps[nearest] - depth_m, 0.0, 0.1), (0.1, 1.0, 0.1)))
    wide = 0.35
    turns = yaws[nearest] + wide * (np.arange(-2, 4) - share)
    assert gaps_m(room, turns).min() > -0.002, "all frames are let pass"
    qpos = np.tile(room.initial.qpos, (len(turns), 1))
    qpos[:, room.base_slice("J").start + 3 : room.base_slice("J").stop] = [about_z(yaw) for yaw in turns]
    return room, qpos


@pytest.mark.parametrize("depth_m", [0.0024, 0.003])
@pytest.mark.parametrize("share", [0.35, 0.5, 0.61])
def test_a_graze_between_two_frames_is_found_however_shallow(depth_m: float, share: float) -> None:
    room, qpos = turned_past_a_wall(depth_m, share)
    found = audit(room, np.arange(float(len(qpos))), qpos, [()] * len(qpos), {"J": MotionLimits()})
    finding = only(found, "penetration")
    assert (finding.other, finding.frame) == ("wall", 2)
    assert 0.002 < finding.amount < depth_m + 2e-4
    room, qpos = turned_past_a_wall(0.0018, share)
    assert audit(room, np.arange(float(len(qpos))), qpos, [()] * len(qpos), {"J": MotionLimits()}).clean


def test_an_arm_in_its_own_body_is_found() -> None:
    room = scene()
    qpos = np.tile(with_arm(room, GRASP).qpos, (61, 1))
    for number, (start, end) in enumerate(zip(GRASP, (-1.4, 0.88, 0.2, 1.85, 1.31, -1.79, -1.55), strict=True), 1):
        qpos[:, room.agent("J").joints[f"arm_{number}"]] = np.concatenate(([start], ramp(start, end, 2.0)))
    found = audit(room, np.arange(61) / 10, qpos, [()] * 61, {"J": MotionLimits()})
    finding = only(found, "penetration")
    assert finding.what.startswith("J/")
    assert finding.other is not None
    assert finding.other.startswith("J/")


def test_a_hand_through_what_it_holds_is_found() -> None:
    """A box so large that the gripper is 4 cm in it."""
    room = carry(half=(0.06, 0.06, 0.06))
    kept = slice(0, room.released)
    finding = only(audit(room.scene, room.times_s[kept], room.qpos[kept], room.holding[kept], LIMITS), "penetration")
    assert {finding.what, finding.other} == {"J/gripper", "box"}
    assert finding.amount > 0.03
    assert finding.allowed == 0.005


def test_a_hand_may_be_a_little_in_what_it_holds_until_it_leaves() -> None:
    """A box wider than the opening: the fingers are in it while they hold it, and leave through it."""
    fat = carry(half=(0.03, 0.05, 0.03))
    finding = only(fat.audited(), "penetration")
    assert {finding.what, finding.other} == {"J/gripper", "box"}
    assert finding.frame >= fat.released
    kept = slice(0, fat.released)
    assert audit(fat.scene, fat.times_s[kept], fat.qpos[kept], fat.holding[kept], LIMITS).clean


def test_a_thing_that_follows_a_hand_which_does_not_hold_it_is_found(done: Performance) -> None:
    found = done.audited(holding=[frozenset[Hold]()] * len(done.qpos))
    assert [(each.kind, each.what) for each in found.findings] == [("rest", "box"), ("free motion", "box")]
    finding = found.findings[1]
    assert finding.amount > 0.3
    assert "box has moved by" in finding.text


def test_a_thing_that_slides_or_turns_by_itself_is_found(done: Performance) -> None:
    rest = len(done.qpos) - done.released
    for angle, aside in ((0.0, 0.015), (0.2, 0.0)):
        qpos, share = np.array(done.qpos), ramp(0.0, 1.0, rest / RATE_HZ)
        qpos[done.released :, done.box.start] += aside * share
        for frame, part in enumerate(share, done.released):
            turned = multiply(about_z(angle * part), qpos[frame, done.box][3:])
            qpos[frame, done.box.start + 3 : done.box.stop] = turned
        finding = only(done.audited(qpos=qpos), "free motion")
        assert finding.amount == pytest.approx(aside or angle, rel=0.02)


# --- Limits.


def test_a_joint_beyond_its_limit_is_found(done: Performance) -> None:
    qpos = np.array(done.qpos)
    qpos[:, done.joint("head_tilt")] = np.concatenate(([0.0], ramp(0.0, 0.6, (len(qpos) - 1) / RATE_HZ)))
    finding = only(done.audited(qpos=qpos), "joint limit")
    assert finding.what == "J/head_tilt"
    assert finding.amount == pytest.approx(0.6 - 0.541052, abs=1e-6)
    assert "J/head_tilt is 3.4° beyond its limit" in finding.text


def test_haste_is_found(done: Performance) -> None:
    found = audit(done.scene, done.times_s / 3, done.qpos, done.holding, LIMITS)
    assert {(each.kind, each.what) for each in found.findings} == {
        ("speed", "J/arm_2"),
        ("acceleration", "J/arm_2"),
        ("speed", "J's base"),
        ("acceleration", "J's base"),
    }
    fastest = next(each for each in found.findings if (each.kind, each.what) == ("speed", "J/arm_2"))
    assert fastest.amount == pytest.approx(3 * 1.875 * 0.25 / 2.0, rel=0.02)
    assert "J/arm_2 moves at" in fastest.text


def test_a_start_at_full_speed_is_found() -> None:
    room = scene()
    qpos = np.tile(room.initial.qpos, (31, 1))
    qpos[:, room.base_slice("J").start] += np.linspace(0.0, 0.3, 31)
    found = audit(room, np.arange(31) / RATE_HZ, qpos, [()] * 31, LIMITS)
    finding = only(found, "acceleration")
    assert (finding.what, finding.frames) == ("J's base", 2)
    assert finding.frame in (0, 30)
    assert finding.amount == pytest.approx(0.3 * RATE_HZ)


# --- Held and free things.


@pytest.mark.parametrize("how", ["moved", "turned"])
def test_a_thing_that_slips_in_the_hand_is_found(done: Performance, how: str) -> None:
    qpos = np.array(done.qpos)
    slip = np.concatenate((np.zeros(40), ramp(0.0, 1.0, 2.0), np.ones(len(qpos) - 100)))
    if how == "moved":
        qpos[:, done.box.start] += 0.003 * slip
    else:
        qpos[:, done.box.start + 3 : done.box.stop] = [
            multiply(about_z(angle), row) for angle, row in zip(0.03 * slip, qpos[:, done.box][:, 3:], strict=True)
        ]
    finding = only(done.audited(qpos=qpos), "drift")
    assert (finding.what, finding.other) == ("box", "J's right hand")
    assert finding.amount == pytest.approx(0.003 if how == "moved" else 0.03, rel=0.01, abs=1e-4)


def test_a_little_drift_is_let_pass(done: Performance) -> None:
    qpos = np.array(done.qpos)
    qpos[40:, done.box.start] += np.concatenate((ramp(0.0, 0.0015, 2.0), np.full(len(qpos) - 100, 0.0015)))
    assert done.audited(qpos=qpos).clean


def test_holding_from_afar_is_found(done: Performance) -> None:
    """The box is carried a hand's breadth beside the hand."""
    qpos = np.array(done.qpos)
    qpos[:, done.box.start] += 0.25
    found = done.audited(qpos=qpos)
    finding = next(each for each in found.findings if each.kind == "grip")
    assert finding.amount > 0.1
    assert "J's right hand holds box from" in finding.text


def test_a_thing_left_in_the_air_is_found(done: Performance) -> None:
    """It is let go while the arm drives aside, and stays there."""
    qpos, middle = np.array(done.qpos), (done.taken + done.released) // 2
    qpos[middle:, done.box] = qpos[middle, done.box]
    holding = (*done.holding[:middle], *[frozenset[Hold]()] * (len(qpos) - middle))
    found = done.audited(qpos=qpos, holding=holding)
    assert "box rests on nothing, and nobody holds it" in {each.text.split(" s ", 1)[1] for each in found.findings}


def test_a_thing_that_hangs_in_the_air_until_it_is_taken_is_found() -> None:
    """The post on which it stood is lower: it waits in the air, and the hand that takes it is there already."""
    finding = only(carry(higher_m=(-0.05, 0.0)).audited(), "rest")
    assert (finding.what, finding.frame) == ("box", 0)


def test_what_is_elsewhere_than_planned_in_the_end_is_found(done: Performance) -> None:
    planned = np.array(done.qpos[-1])
    assert done.audited().clean
    assert audit(done.scene, done.times_s, done.qpos, done.holding, LIMITS, planned=planned).clean
    planned[done.box.start] += 0.012
    planned[done.box.start + 3 : done.box.stop] = multiply(about_z(0.1), planned[done.box.start + 3 : done.box.stop])
    found = audit(done.scene, done.times_s, done.qpos, done.holding, LIMITS, planned=planned)
    assert [(each.kind, each.what, each.unit) for each in found.findings] == [
        ("end", "box", "m"),
        ("end", "box", "rad"),
    ]
    assert "box is 12.0 mm from where the plan has it in the end" in found.findings[0].text
    assert found.findings[1].amount == pytest.approx(0.1, abs=1e-3)
    with pytest.raises(InputError, match="a planned end is one frame"):
        audit(done.scene, done.times_s, done.qpos, done.holding, LIMITS, planned=done.qpos)


def test_what_is_written_is_looked_at(done: Performance) -> None:
    """Every position moved by less than what a recording keeps changes nothing that is found."""
    kept = rounded(done.qpos, done.scene)
    assert np.abs(kept - done.qpos).max() > 1e-5
    a, b = done.audited(), audit(done.scene, done.times_s, kept, done.holding, {"J": MotionLimits()})
    assert a.gaps_m == b.gaps_m


def test_a_thing_still_held_at_the_end_is_at_rest(done: Performance) -> None:
    middle = (done.taken + done.released) // 2
    parked = next(f for f in range(middle, len(done.qpos)) if np.allclose(done.qpos[f], done.qpos[f - 1], atol=1e-9))
    upto = slice(0, parked + 1)
    qpos, holding = done.qpos[upto], done.holding[upto]
    assert holding[-1]
    found = audit(done.scene, done.times_s[upto], qpos, holding, LIMITS)
    assert found.clean, [finding.text for finding in found.findings]


def test_a_thing_that_snaps_into_place_is_found(done: Performance) -> None:
    qpos = np.array(done.qpos)
    qpos[done.released :, done.box.start] += 0.02
    finding = only(done.audited(qpos=qpos), "jump")
    assert (finding.what, finding.frame) == ("box", done.released - 1)
    assert finding.amount == pytest.approx(0.02)
    assert finding.text == f"at {finding.time_s:.2f} s box jumps by 20.0 mm, although no hand holds it"


def test_a_thing_may_fall(done: Performance) -> None:
    """Let go 1 cm above the post, the box falls that far, as things fall."""
    qpos = np.array(done.qpos)
    height, since = 0.01, np.arange(len(qpos) - done.released) / RATE_HZ
    drop = np.minimum(9.81 * since**2 / 2, height)
    qpos[:, done.box.start + 2] += np.concatenate((np.full(done.released, height), height - drop))
    lifted = [each for each in done.audited(qpos=qpos).findings if each.kind in ("jump", "free motion", "rest")]
    assert not lifted


def test_a_joint_and_a_base_that_jump_are_found(done: Performance) -> None:
    for index, name, amount in ((done.joint("head_pan"), "J/head_pan", 1.0), (0, "J's base", 0.5)):
        qpos = np.array(done.qpos)
        at = index if "/" in name else done.scene.base_slice("J").start
        qpos[250:, at] += amount
        found = audit(done.scene, done.times_s, qpos, done.holding, {"J": MotionLimits()})
        jumps = [each for each in found.findings if each.kind == "jump"]
        assert [(each.what, each.frame) for each in jumps] == [(name, 249)]
        assert jumps[0].amount == pytest.approx(amount)


# --- A twin: whatever is met when every frame and every millimetre is looked at.


def slow_penetrations(room: Scene, qpos: Array) -> set[tuple[str, str]]:
    stage, motion = Stage(room), Motion(room, qpos)
    mine = room.solid_geoms_of("J")
    others = np.setdiff1d(room.solid_geoms, mine)
    found = set()
    for frame in range(len(qpos) - 1):
        count = int(np.ceil(motion.travel_m[frame].max() / 0.002)) + 1
        for share in np.linspace(0.0, 1.0, count):
            row = np.array(qpos[frame])
            mujoco.mj_integratePos(room.model, row, motion.steps[frame], share)
            for geom, other, _ in stage.show(State(row)).overlaps(mine, others, deeper_than_m=0.002):
                found.add((str(room.model.body(room.model.geom_bodyid[geom]).name), room.owners[other]))
    return found


@pytest.mark.parametrize("seed", range(4))
def test_nothing_is_missed_among_clutter(seed: int) -> None:
    random = np.random.default_rng(seed)
    bars = [
        board(f"bar{k}", tuple(random.uniform((0.1, -0.8, 0.4), (0.9, 0.8, 1.5))), tuple(random.uniform(0.002, 0.1, 3)))
        for k in range(80)
    ]
    room = scene(*bars)
    start = with_arm(room, GRASP)
    mine, others = room.solid_geoms_of("J"), np.setdiff1d(room.solid_geoms, room.solid_geoms_of("J"))
    touching = {room.owners[other] for _, other, _ in Stage(room, start).overlaps(mine, others)}
    room = scene(*(bar for k, bar in enumerate(bars) if f"bar{k}" not in touching))
    qpos = np.tile(with_arm(room, GRASP).qpos, (9, 1))
    for number in range(1, 8):
        qpos[:, room.agent("J").joints[f"arm_{number}"]] += np.linspace(0.0, random.uniform(-1.2, 1.2), 9)
    found = audit(room, np.arange(9.0), qpos, [()] * 9, {"J": MotionLimits()})
    pairs = {(each.what, each.other) for each in found.findings if each.kind == "penetration"}
    pairs = {(what, other) for what, other in pairs if other and not other.startswith("J/")}
    slow = slow_penetrations(room, qpos)
    assert slow
    assert pairs >= slow
    assert len(pairs - slow) <= 1, "what is found beyond that is met between two millimetres"


# --- Forms.


def test_findings_are_json(done: Performance) -> None:
    qpos = np.array(done.qpos)
    qpos[done.released :, done.box.start] += 0.02
    document = json.loads(json.dumps(done.audited(qpos=qpos).to_json()))
    assert document["clean"] is False
    assert document["findings"][0]["kind"] == "jump"
    assert document["findings"][0]["text"].startswith(f"at {(done.released - 1) / RATE_HZ:.2f} s box jumps by 20.0 mm")


def test_what_does_not_fit_is_refused(done: Performance) -> None:
    with pytest.raises(InputError, match="times, frames and holds are one each"):
        audit(done.scene, done.times_s[1:], done.qpos, done.holding, LIMITS)
    with pytest.raises(InputError, match="their times increase"):
        audit(done.scene, done.times_s[::-1], done.qpos, done.holding, LIMITS)
    with pytest.raises(UnknownNameError, match="no agent 'P3'"):
        audit(done.scene, done.times_s, done.qpos, done.holding, {"P3": MotionLimits()})
    with pytest.raises(UnknownNameError, match="no joint 'elbow'"):
        audit(done.scene, done.times_s, done.qpos, done.holding, {"J": MotionLimits({"elbow": 1.0})})
    with pytest.raises(UnknownNameError, match="no object 'cup'"):
        audit(done.scene, done.times_s, done.qpos, [{Hold("J", "right", "cup")}] * len(done.qpos), LIMITS)


def test_an_audit_is_quick(done: Performance) -> None:
    """20 s of motion take less than 2 s, with room for a busy machine: processor time is what counts."""
    qpos = np.concatenate([done.qpos] + [np.repeat(done.qpos[-1:], 342, axis=0)])
    holding = (*done.holding, *[frozenset[Hold]()] * 342)
    assert HOLD in holding[done.taken]
    begin = time.process_time()
    audit(done.scene, np.arange(600) / RATE_HZ, qpos, holding, LIMITS)
    assert time.process_time() - begin < 2.0
