"""What people push into as they act: named by part and thing; what touches from the beginning may."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from taskgist.common.arrays import Array
from taskgist.planning.people_colliding import SEATED_M, pushing_into
from taskgist.planning.plan import Phase
from taskgist.world import Hold, Scene, Stage, State
from taskgist_lab.simulator.room import TABLE, Person, Room, on_table

NOBODY = frozenset[Hold]()


@cache
def scene() -> Scene:
    people = (
        Person("P1", 1.75, (-0.7, 0.0), 0.0, "sitting"),
        Person("P2", 1.7, (0.75, 0.0), math.pi, "sitting"),
    )
    return Room("room", people, (on_table("cup", -0.2, 0.3),), TABLE).scene()


def chest() -> Array:
    """A point in the middle of P1's torso."""
    stage = Stage(scene(), scene().initial)
    shoulders = [stage.shoulder(arm).position for arm in scene().agent("P1").arms]
    return np.asarray(np.mean(shoulders, axis=0) - (0.0, 0.0, 0.1))


def with_cup(place: Array) -> Array:
    qpos = np.array(scene().initial.qpos)
    qpos[scene().object_slice("cup")][:3] = place
    return qpos


def turned(qpos: Array, joint: str, angle_rad: float) -> Array:
    changed = np.array(qpos)
    changed[scene().agent("P1").joints[joint]] = angle_rad
    return changed


def test_who_does_nothing_pushes_into_nothing() -> None:
    still = scene().initial.qpos
    assert pushing_into(scene(), still, [Phase("reach", np.array([still, still]), NOBODY)], "P1") is None


def test_what_comes_into_somebody_is_told_with_the_part() -> None:
    still, moved = scene().initial.qpos, with_cup(chest())
    phases = [Phase("reach", np.array([still, moved]), NOBODY)]
    assert pushing_into(scene(), still, phases, "P1") == "P1's torso would push into the cup"
    assert pushing_into(scene(), still, phases, "P2") is None, "it is in P1, who does nothing then"


def test_a_held_thing_may_not_come_into_others() -> None:
    still, moved = scene().initial.qpos, with_cup(chest())
    holds = frozenset({Hold("P2", "right", "cup")})
    told = pushing_into(scene(), still, [Phase("transfer", np.array([still, moved]), holds)], "P2")
    assert told == "the cup would push into P1's torso"


def test_what_touches_at_first_may_touch_so_deep_and_no_deeper() -> None:
    stage = Stage(scene(), State(with_cup(chest())))
    own, cup = scene().solid_geoms_of("P1"), scene().solid_geoms_of("cup")
    assert max(depth_m for *_, depth_m in stage.overlaps(own, cup)) > SEATED_M, "nobody sits so deep in anything"
    within = with_cup(chest())
    assert pushing_into(scene(), within, [Phase("reach", within[None], NOBODY)], "P1") is not None
    seated = scene().initial.qpos
    chair = [deep for *_, deep in Stage(scene(), State(seated)).overlaps(own, scene().solid_geoms_of("chair_P1"))]
    assert max(chair) > 0.002, "P1 sits a little in its chair, which is let pass"


def test_a_body_does_not_push_into_itself() -> None:
    still = scene().initial.qpos
    agent = scene().agent("P1")
    elbows = [name for name in agent.joints if "elbow" in name and name.startswith("left")]
    shoulders = [name for name in agent.joints if "shoulder" in name and name.startswith("left")]
    told = set()
    rng = np.random.default_rng(0)
    for _ in range(60):
        moved = np.array(still)
        for name in (*shoulders, *elbows):
            low, high = scene().model.joint(f"P1/{name}").range
            moved = turned(moved, name, float(rng.uniform(low, high)))
        told.add(pushing_into(scene(), still, [Phase("reach", moved[None], NOBODY)], "P1"))
    assert any(each and each.startswith("P1's ") and " into P1's " in each for each in told)
