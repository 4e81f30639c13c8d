"""A container over a thing: it stays where it is put, touches nothing, and covers, as MuJoCo alone has it."""

from __future__ import annotations

import copy
import math

import mujoco
import numpy as np
import pytest

from taskgist.planning.covering import covers
from taskgist.world import Scene, Stage, State
from taskgist_lab.generator.things import MeshThing, OpenBox, extent_m
from taskgist_lab.simulator.room import TABLE, Person, Room, Thing

TOP = 0.72
IT = Thing("it", (0.04, 0.03, 0.03), (-0.1, 0.3, TOP), 0.4)
COVERS = {
    "box": OpenBox("box", (0.075, 0.075, 0.10), (-0.1, -0.1, TOP), upside_down=True),
    "bin": OpenBox("bin", (0.08, 0.07, 0.09), (-0.1, -0.3, TOP), 0.3),
    "mug": MeshThing("mug", extent_m("mug"), (0.05, 0.0, TOP), mesh="mug"),
}


def room(*things: Thing) -> Scene:
    people = (
        Person("R", 1.5, (-1.6, 0.0), 0.0, "standing", profile="jido"),
        Person("P2", 1.7, (0.75, 0.0), math.pi, "sitting"),
    )
    return Room("room", people, things, TABLE).scene()


@pytest.mark.parametrize("name", COVERS)
def test_it_stays_where_it_is_put_and_covers(name: str) -> None:
    scene = room(IT, *COVERS.values())
    found = list(covers(Stage(scene), "it", name, "R", "P2"))
    assert found
    for candidate in found[:: max(1, len(found) // 6)]:
        assert (candidate.means, candidate.thing, candidate.carrier) == ("put_over", name, "table")
        before = candidate.state
        after = watched(scene, before)
        for thing in ("it", name):
            moved = after[scene.object_slice(thing)] - before.qpos[scene.object_slice(thing)]
            assert np.linalg.norm(moved[:3]) < 0.002, thing
        assert hidden_share(scene, before, name) > 0.97, "but for what is seen beneath a rounded rim"


def watched(scene: Scene, state: State) -> np.ndarray:
    """Where everything is after a second under gravity, by MuJoCo's own dynamics; bodies of agents are not there."""
    model = copy.deepcopy(scene.model)
    bodies = [geom for geom in range(model.ngeom) if scene.owners[geom] in scene.agents]
    model.geom_contype[bodies] = model.geom_conaffinity[bodies] = 0
    model.eq_active0[:] = 0
    data = mujoco.MjData(model)
    data.qpos[:] = state.qpos
    things = np.concatenate([np.r_[scene.object_slice(name)] for name in scene.objects])
    dofs = np.isin(model.jnt_bodyid[model.dof_jntid], [scene.object_body(name) for name in scene.objects])
    others = np.setdiff1d(np.arange(scene.nq), things)
    for _ in range(round(1.0 / model.opt.timestep)):
        mujoco.mj_step(model, data)
        data.qpos[others], data.qvel[~dofs] = state.qpos[others], 0.0
    return np.array(data.qpos)


def hidden_share(scene: Scene, state: State, cover: str) -> float:
    """Of rays from the thing's middle all around and upwards the share that the cover stops."""
    data = mujoco.MjData(scene.model)
    data.qpos[:] = state.qpos
    mujoco.mj_kinematics(scene.model, data)
    body, thing, met = scene.object_body(cover), scene.object_body("it"), 0
    angles = [(yaw, pitch) for yaw in np.linspace(0, 2 * np.pi, 36, endpoint=False) for pitch in (0.0, 0.4, 0.9, 1.5)]
    for yaw, pitch in angles:
        way = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), np.sin(pitch)])
        geom = np.zeros(1, dtype=np.int32)
        mujoco.mj_ray(scene.model, data, data.xpos[thing], way, None, 1, thing, geom, None)
        met += geom[0] >= 0 and scene.model.body_rootid[scene.model.geom_bodyid[geom[0]]] == body
    return met / len(angles)


def test_what_has_no_room_covers_nothing() -> None:
    solid = Thing("solid", (0.08, 0.08, 0.10), (-0.1, -0.1, TOP))
    flat = OpenBox("flat", (0.09, 0.09, 0.03), (-0.1, -0.3, TOP))
    tight = OpenBox("tight", (0.05, 0.05, 0.09), (0.1, -0.3, TOP))
    scene = room(IT, solid, flat, tight)
    for name in ("solid", "flat", "tight"):
        assert not list(covers(Stage(scene), "it", name, "R", "P2")), name


def test_what_stands_beside_the_thing_keeps_a_cover_off() -> None:
    beside = Thing("beside", (0.03, 0.03, 0.10), (-0.1, 0.345, TOP))
    scene = room(IT, beside, COVERS["box"])
    assert not list(covers(Stage(scene), "it", "box", "R", "P2"))


def test_a_thing_at_the_edge_is_not_covered_by_what_would_fall() -> None:
    scene = room(Thing("it", (0.04, 0.03, 0.03), (-0.33, 0.3, TOP)), COVERS["box"])
    for candidate in covers(Stage(scene), "it", "box", "R", "P2"):
        after = watched(scene, candidate.state)
        assert np.linalg.norm((after - candidate.state.qpos)[scene.object_slice("box")][:3]) < 0.005


def test_the_same_question_has_the_same_answer() -> None:
    scene = room(IT, *COVERS.values())
    one, other = (list(covers(Stage(scene), "it", "bin", "R", "P2")) for _ in range(2))
    assert [each.pose.tolist() for each in one] == [each.pose.tolist() for each in other]
