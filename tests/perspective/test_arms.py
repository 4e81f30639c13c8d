"""Closed is closed: what arms get at, and what is in their way, in rooms of which anybody would say the same."""

from __future__ import annotations

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from taskgist.language.efforts import why
from taskgist.perspective import Ability, Effort, Viewpoint, least_effort
from taskgist.perspective.arms import NOTHING, Around, arms_of, first_met, free_configuration, shut_in
from taskgist.perspective.effort import BlockedArm, Reason
from taskgist.perspective.search import effort_from
from taskgist.perspective.target import crossed
from taskgist.settings import DEFAULT
from taskgist.world import Stage
from taskgist.world.bodies.arm_chain import LOW, SPAN, STEPS, chain_of
from taskgist.world.bodies.capability import CapabilityMap
from taskgist.world.geometry.solids import solids_of
from tools.rooms import Person, Room, Shape, Thing, table, wall

Array = NDArray[np.float64]
Size = tuple[float, float, float]
P1 = Person("P1", (0.0, 0.0))
HERE_ONLY = replace(DEFAULT, efforts=replace(DEFAULT.efforts, move_radius_m=0.0))
BOARD_M = 0.01
"""Half the thickness of a board."""
SHOULDER = ("shoulder_flexion", "shoulder_abduction", "shoulder_rotation")
ARM = (*SHOULDER, "elbow", "forearm_rotation", "wrist_flexion", "wrist_deviation")


def cup(x: float = 0.5, y: float = 0.15, z: float = 1.1) -> Thing:
    return Thing("cup", (0.035, 0.05), (x, y, z), "cylinder")


def case(at: Size, half: Size, without: str = "", name: str = "case") -> Thing:
    """A case of boards; sides that are left out are named by letters: front, back, left, right, top, under."""
    x, y, z = half
    boards = {
        "f": ((BOARD_M, y, z), (-x, 0.0, 0.0)),
        "b": ((BOARD_M, y, z), (x, 0.0, 0.0)),
        "l": ((x, BOARD_M, z), (0.0, y, 0.0)),
        "r": ((x, BOARD_M, z), (0.0, -y, 0.0)),
        "t": ((x, y, BOARD_M), (0.0, 0.0, z)),
        "u": ((x, y, BOARD_M), (0.0, 0.0, -z)),
    }
    shapes = tuple(Shape("box", size, place) for side, (size, place) in boards.items() if side not in without)
    return Thing(name, (), at, free=False, shapes=shapes)


CUPBOARD = ((0.6, 0.1, 1.15), (0.2, 0.35, 0.3))
LIPS = tuple(Thing(f"lip{s}", (0.01, 0.2, 0.095), (0.4, 0.15, 1.1 + s * 0.105), free=False) for s in (-1, 1))
CLOSED = {
    "cupboard": (case(*CUPBOARD),),
    "cupboard with a door of its own": (case(*CUPBOARD, "f"), case(*CUPBOARD, "blrtu", "door")),
    "drawer that is shut": (case((0.5, 0.15, 1.1), (0.15, 0.2, 0.08)),),
    "cover over it": (table(0.6, height=1.05), case((0.5, 0.15, 1.15), (0.1, 0.1, 0.1), "u")),
    "thin case, turned": (replace(case((0.5, 0.15, 1.1), (0.12, 0.12, 0.12)), yaw=0.6),),
    "slit of a letter box": (case((0.6, 0.15, 1.1), (0.2, 0.2, 0.2), "f"), *LIPS),
    "wall from side to side": (wall("wall", 0.42, half=(0.02, 40.0, 1.25)),),
    "wall that the thing touches": (wall("wall", 0.45, half=(0.01, 40.0, 1.0)),),
}
"""Each with a cup at (0.5, 0.15, 1.1)."""
OPEN = {
    "nothing": (),
    "shelf": (case((0.6, 0.1, 1.15), (0.2, 0.35, 0.3), "f"),),
    "shelf open at the side": (case((0.5, 0.1, 1.15), (0.2, 0.25, 0.3), "l"),),
    "drawer": (case((0.5, 0.15, 1.1), (0.15, 0.2, 0.08), "t"),),
    "box without a lid": (table(0.6, height=1.03), case((0.5, 0.15, 1.1), (0.1, 0.1, 0.06), "t")),
    "slot of a hand's breadth": (case((0.5, 0.15, 1.12), (0.15, 0.3, 0.1), "f"),),
    "over a low pane": (table(0.6, height=1.05), Thing("pane", (0.003, 0.6, 0.1), (0.3, 0.0, 1.15), free=False)),
    "round a narrow pane": (Thing("pane", (0.003, 0.08, 0.4), (0.35, 0.15, 1.1), free=False),),
    "beneath a board": (Thing("board", (0.2, 0.4, BOARD_M), (0.55, 0.1, 1.3), free=False),),
    "on a table": (table(0.6, height=1.05),),
}


def effort(things: tuple[Thing, ...], ability: Ability, person: Person = P1) -> Effort:
    return least_effort(Room((cup(), *things), (person,)).stage(), "P1", "cup", ability)


@pytest.mark.parametrize("ability", ["reach", "grasp"])
@pytest.mark.parametrize("room", CLOSED)
def test_nobody_gets_at_what_is_closed_up(room: str, ability: Ability) -> None:
    assert effort(CLOSED[room], ability).level == 5


@pytest.mark.parametrize("room", OPEN)
def test_what_is_open_is_got_at(room: str) -> None:
    found = effort(OPEN[room], "reach")
    assert found.level is not None
    assert found.level <= 2


@pytest.mark.parametrize(
    ("room", "owner"),
    [("cupboard", "case"), ("drawer that is shut", "case"), ("cover over it", "case"), ("thin case, turned", "case")],
)
def test_what_shuts_a_thing_in_is_named(room: str, owner: str) -> None:
    found = effort(CLOSED[room], "reach")
    told = found.evidence.told
    assert told is not None
    assert told.reason is Reason.SHUT_IN
    assert isinstance(told.hindrance, BlockedArm)
    assert owner in dict(told.hindrance.counts)
    assert f"shut in by {owner}" in why(found)
    assert found.evidence_document["miss"]["shut_in"] is True  # type: ignore[index]


def test_what_is_in_the_way_of_an_arm_is_named() -> None:
    room = Room((cup(0.55), wall("wall", 0.42, half=(0.02, 0.8, 1.25))), (P1,))
    found = least_effort(room.stage(), "P1", "cup", "reach", HERE_ONLY)
    assert (found.level, found.evidence.told.reason) == (5, Reason.ARM_BLOCKED)  # type: ignore[union-attr]
    assert found.reason in {f"the way of the {side} arm is blocked by wall" for side in ("left", "right")}
    assert least_effort(room.stage(), "P1", "cup", "reach").level == 4  # round the wall


def test_the_papers_reach_looks_at_nothing_in_the_way() -> None:
    rough = replace(DEFAULT, reach=replace(DEFAULT.reach, model="sector"))
    for things in CLOSED.values():
        assert least_effort(Room((cup(), *things), (P1,)).stage(), "P1", "cup", "reach", rough).level in {1, 2}


def test_what_is_held_or_wanted_is_in_nobodys_way() -> None:
    """A tray before the thing, in the agent's own hand; the thing itself, however large."""
    block = Thing("cup", (0.2, 0.3, 0.3), (0.65, 0.1, 1.1))
    assert least_effort(Room((block,), (P1,)).stage(), "P1", "cup", "reach").level == 1


def test_large_things_in_a_case_are_answered() -> None:
    """No flood is as large as they are; arms find the way blocked all the same."""
    block = Thing("cup", (0.3, 1.2, 0.3), (0.8, 0.1, 1.1))
    things = (block, case((0.8, 0.1, 1.1), (0.35, 1.25, 0.35)))
    found = least_effort(Room(things, (P1,)).stage(), "P1", "cup", "reach", HERE_ONLY)
    assert (found.level, found.evidence.told.reason) == (5, Reason.ARM_BLOCKED)  # type: ignore[union-attr]


def test_somebody_in_the_way_is_named() -> None:
    room = Room((cup(0.55, 0.0, 1.2),), (P1, Person("P2", (0.33, 0.0), math.pi / 2)))
    found = least_effort(room.stage(), "P1", "cup", "reach", HERE_ONLY)
    assert found.level != 1
    assert "blocked by P2" in found.evidence.misses[1].text


# --- The parts, each against another way to find the same.


def human(stature: float = 1.75, place: tuple[float, float] = (0.3, -0.2), yaw: float = 0.7) -> Stage:
    return Room((cup(),), (Person("P1", place, yaw, stature=stature),)).stage()


def row_of(stage: Stage, side: str) -> Array:
    pose = stage.shoulder(stage.scene.agent("P1").arm(side))
    return np.concatenate((pose.position, pose.matrix.ravel()))


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(("stature", "within_m"), [(1.75, 1e-4), (1.6, 0.01), (1.95, 0.01)])
def test_kept_configurations_bring_the_palm_where_mujoco_has_it(side: str, stature: float, within_m: float) -> None:
    stage = human(stature)
    agent = stage.scene.agent("P1")
    arm, rng = agent.arm(side), np.random.default_rng(2)
    found, shoulder = arm.reach, stage.shoulder(arm)
    flip = np.array((1.0, -1.0 if found.mirrored else 1.0, 1.0)) * found.scale
    chain = found.map.chain
    for index in rng.integers(len(found.map.configurations), size=40).tolist():
        steps = found.map.configurations[index]
        angles = chain.joints[:, LOW] + chain.joints[:, SPAN] * steps / STEPS
        names = [agent.joints[f"{side}_{name}"] for name in ARM]
        state = stage.scene.initial.replace(dict(zip(names, angles.tolist(), strict=True)))
        palm = stage.show(state).site(arm.palm_site).position
        stage.show(stage.scene.initial)
        ours = shoulder.to_world([found.map.palms[index] * flip])[0]
        assert np.linalg.norm(palm - ours) <= within_m


def test_the_grip_of_a_usual_body_is_as_long_as_published() -> None:
    """0.66 to 0.71 m from the shoulder at 1.75 m, the girdle at rest."""
    stage = human(1.75, (0.0, 0.0), 0.0)
    arm = stage.scene.agent("P1").arm("left")
    assert 0.66 <= np.linalg.norm(arm.reach.map.palms, axis=1).max() <= 0.71


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_configuration_that_is_called_free_is_free_for_mujoco(side: str) -> None:
    """Boxes anywhere about an arm: links are capsules for us, so that they may differ by what these leave out."""
    rng, count = np.random.default_rng(5), {True: 0, False: 0}
    for _ in range(12):
        half = tuple(rng.uniform(0.01, 0.2, 3).tolist())
        block = Thing("block", half, tuple((rng.uniform(-0.5, 0.5, 3) + (0.4, 0.0, 1.2)).tolist()), free=False)
        stage = Room((cup(), block), (P1,)).stage()
        agent = stage.scene.agent("P1")
        arm = agent.arm(side)
        arms, geoms = arms_of((arm,), "capability"), stage.scene.geoms_of("block")
        solids = solids_of(stage.scene.model, geoms, *stage.geoms(geoms))
        around = Around(solids, np.zeros((1, 1), dtype=np.bool_), 0.045, 0.0, True, np.zeros((2, 3)))
        pose = row_of(stage, side)
        for point in stage.shoulder(arm).position + rng.uniform(-0.6, 0.6, (20, 3)):
            index = free_configuration(pose, arms, 0, point, around, np.zeros(1, dtype=np.intp))
            count[index != NOTHING] += 1
            if index == NOTHING:
                continue
            chain = arm.reach.map.chain
            angles = chain.joints[:, LOW] + chain.joints[:, SPAN] * arms.configurations[index] / STEPS
            names = [agent.joints[f"{side}_{name}"] for name in ARM]
            stage.show(stage.scene.initial.replace(dict(zip(names, angles.tolist(), strict=True))))
            assert np.linalg.norm(stage.site(arm.palm_site).position - point) <= 0.046
            deepest = max((depth for *_, depth in stage.overlaps(arm.geoms, geoms)), default=0.0)
            assert deepest <= 0.03  # a palm is broader than a capsule
            stage.show(stage.scene.initial)
    assert min(count.values()) > 20


def outside_m(kind: str, size: tuple[float, ...], points: Array) -> Array:
    """How far points in a shape's own frame are outside of it."""
    beside, height = np.linalg.norm(points[:, :2], axis=1), np.abs(points[:, 2])
    if kind == "box":
        return np.asarray(np.linalg.norm(np.maximum(np.abs(points) - size, 0.0), axis=1))
    if kind == "cylinder":
        return np.asarray(np.hypot(np.maximum(beside - size[0], 0.0), np.maximum(height - size[1], 0.0)))
    if kind == "capsule":
        return np.asarray(np.hypot(beside, np.maximum(height - size[1], 0.0)) - size[0])
    return np.asarray(np.linalg.norm(points, axis=1) - size[0])


KINDS = {"box": 3, "sphere": 1, "cylinder": 2, "capsule": 2}


@pytest.mark.parametrize("kind", KINDS)
def test_lines_meet_what_their_points_come_near_to(kind: str) -> None:
    rng, found = np.random.default_rng(8), {True: 0, False: 0}
    for _ in range(15):
        size = tuple(rng.uniform(0.01, 0.2, KINDS[kind]).tolist())
        thing = Thing(
            "thing", size, (0.0, 0.0, 1.0), kind, yaw=float(rng.uniform(-3, 3)), roll=float(rng.uniform(-3, 3))
        )
        stage = Room((thing,), (P1,)).stage()
        geoms = stage.scene.geoms_of("thing")
        solids = solids_of(stage.scene.model, geoms, *stage.geoms(geoms))
        for start, end in rng.uniform(-0.35, 0.35, (60, 2, 3)) + (0.0, 0.0, 1.0):
            points = start + np.linspace(0, 1, 400)[:, None] * (end - start)
            away = outside_m(kind, size, stage.geom(int(geoms[0])).to_local(points))
            for radius_m in (0.0, 0.03):
                (ax, ay, az), (bx, by, bz) = start.tolist(), end.tolist()
                ours = first_met(solids, ax, ay, az, bx, by, bz, radius_m) >= 0
                assert ours or away.min() > radius_m - 0.0025
                assert not ours or away.min() < radius_m + 0.0025
                found[ours] += 1
    assert min(found.values()) > 100


@pytest.mark.parametrize("seed", range(6))
def test_a_case_shuts_in_until_a_board_is_taken_away(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y, z = rng.uniform(0.08, 0.25, 3).tolist()
    outside = (1.0, 0.0, 1.0)
    for without in ("", *"fblrtu"):
        at = (0.03, -0.02, float(rng.uniform(0.5, 1.5)))
        box = replace(case(at, (x, y, z), without), yaw=float(rng.uniform(-3, 3)))
        stage = Room((cup(*at), box), (Person("P1", (5.0, 5.0)),)).stage()
        geoms = stage.scene.geoms_of("case")
        solids = solids_of(stage.scene.model, geoms, *stage.geoms(geoms))
        met = np.zeros(len(geoms), dtype=np.intp)
        found = shut_in(np.array([at]), np.array(at), 0.7, np.array([outside]), solids, met, np.zeros((2, 3)))
        assert found == (without == "")
        assert without or met.sum() > 0


def test_who_sits_in_a_case_with_a_thing_gets_at_it() -> None:
    booth = case((0.2, 0.0, 1.0), (0.62, 0.62, 1.0), name="booth")
    assert effort((booth,), "reach").level == 1


def test_a_viewpoint_notes_where_arms_felt_for_something() -> None:
    """What comes into an arm's way changes an answer, so that the answer depends on what is there."""
    stage = Room((cup(), Thing("board", (0.01, 0.5, 0.5), (3.0, 0.0, 1.1))), (P1,)).stage()
    here = Viewpoint(stage, "P1", HERE_ONLY)
    effort_from(here, "cup", "reach")
    low, high = here.recorder.arms.bounds
    assert low[0] <= 0.3 <= high[0]
    assert crossed(here.recorder.bounds[None], np.array([[(0.29, -0.5, 0.6), (0.31, 0.5, 1.6)]]))[0]


def test_a_shoulder_that_is_one_ball_turns_about_three_axes() -> None:
    spec = mujoco.MjSpec.from_string(
        """<mujoco><worldbody><body name="torso"><body name="root" pos="0 0 0"><joint name="ball" type="ball"/>
        <geom type="capsule" size="0.03" fromto="0 0 0 0.3 0 0"/><body name="hand" pos="0.3 0 0">
        <geom type="box" size="0.05 0.03 0.01"/><site name="palm"/></body></body><site name="shoulder"/></body>
        </worldbody></mujoco>"""
    )
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    names = {name: int(model.body(name).id) for name in ("root", "hand")} | {"carrier": int(model.body("torso").id)}
    sites = {name: int(model.site(name).id) for name in ("shoulder", "palm")}
    chain = chain_of(model, data, names | sites, np.arange(model.ngeom))
    assert len(chain.joints) == 3
    found = CapabilityMap.of(chain, 20_000)
    assert np.linalg.norm(found.palms, axis=1) == pytest.approx(0.3, abs=1e-4)
