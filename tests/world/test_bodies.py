"""Every built-in body, in every role: they are told apart by their profiles alone."""

from __future__ import annotations

import math
import warnings
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from taskgist.perspective import ABILITIES, able, actions_of, least_effort, view_of, visibility
from taskgist.world import Scene, Stage, overlaps
from taskgist.world.geometry.shapes import lowest_point
from tests.bodies import EVERY_BODY, needs, room, standing
from tools.rooms import COARSE

SIZES = {"human": (1.64, 0.70), "pr2": (1.37, 0.95), "talos": (1.61, 0.92), "jido": (1.48, 0.90), "hrp2": (1.40, 0.70)}
"""Height of the eye and length of the arm, metres: from data sheets, figures and the authors' code."""


@cache
def alone(body: str, cup: tuple[float, float, float] = (0.6, 0.0, 1.0)) -> Scene:
    return room(standing("R", body), cup=cup)


def level(body: str, ability: str, cup: tuple[float, float, float]) -> int | None:
    return least_effort(Stage(alone(body, cup)), "R", "cup", ability, COARSE).level  # type: ignore[arg-type]


@pytest.mark.parametrize("body", EVERY_BODY)
def test_it_stands_on_the_floor_and_looks_ahead(body: str) -> None:
    scene = alone(body)
    stage, agent = Stage(scene), scene.agent("R")
    points = [(g, lowest_point(scene.model, int(g), stage.geom(int(g)).matrix)) for g in agent.geoms]
    lowest = min(stage.geom(int(geom)).to_world(point)[2] for geom, point in points if point is not None)
    assert lowest == pytest.approx(0.0, abs=2e-3)
    eye = stage.eye(agent)
    assert eye.matrix[:, 0] == pytest.approx((1, 0, 0), abs=0.02)
    assert eye.matrix[:, 2] == pytest.approx((0, 0, 1), abs=0.02)
    assert eye.position[2] == pytest.approx(SIZES[body][0], abs=0.03)
    assert all(arm.profile.length_m == pytest.approx(SIZES[body][1], abs=0.01) for arm in agent.arms)


@pytest.mark.parametrize("body", EVERY_BODY)
def test_left_and_right_are_mirrored(body: str) -> None:
    stage = Stage(alone(body))
    agent = stage.scene.agent("R")
    if len(agent.arms) == 2:
        left, right = agent.arm("left"), agent.arm("right")
        shoulders = [stage.shoulder(arm).position for arm in (left, right)]
        palms = [stage.site(arm.palm_site).position for arm in (left, right)]
        for on_left, on_right in (shoulders, palms):
            assert on_left == pytest.approx(on_right * (1, -1, 1), abs=0.02)
            assert on_left[1] > 0
    for arm in agent.arms:
        assert stage.shoulder(arm).matrix[:, 0] == pytest.approx((1, 0, 0), abs=0.02)
        assert np.linalg.norm(stage.site(arm.palm_site).position - stage.shoulder(arm).position) < arm.profile.length_m


@pytest.mark.parametrize("body", EVERY_BODY)
def test_joints_rest_within_their_limits_and_no_range_exceeds_them(body: str) -> None:
    scene = alone(body)
    agent = scene.agent("R")
    for name, index in agent.joints.items():
        joint = scene.model.joint(f"R/{name}")
        if joint.limited[0]:
            assert joint.range[0] - 1e-9 <= scene.initial.qpos[index] <= joint.range[1] + 1e-9, name
    for field, axis in agent.profile.axes:
        joint = scene.model.joint(f"R/{axis.joint}")
        assert joint.range[0] <= axis.range_rad[0] < axis.range_rad[1] <= joint.range[1], field


@pytest.mark.parametrize("body", EVERY_BODY)
def test_it_is_whole_and_nothing_of_itself_hides_its_view(body: str) -> None:
    scene = alone(body)
    agent = scene.agent("R")
    assert set(agent.parts) >= {"head", "torso", "right_arm"}
    in_parts = [int(part_body) for bodies in agent.parts.values() for part_body in bodies]
    assert len(in_parts) == len(set(in_parts))
    seen_of_itself = np.isin(view_of(Stage(scene), "R").geoms, agent.geoms).mean()
    assert seen_of_itself < 0.1
    assert len(agent.core_geoms)
    assert all(len(arm.hand_geoms) for arm in agent.arms)
    assert overlaps(Stage(scene), deeper_than_m=0.01) == {}


@pytest.mark.parametrize("body", EVERY_BODY)
def test_nearer_things_take_less_effort(body: str) -> None:
    height = Stage(alone(body)).shoulder(alone(body).agent("R").arms[0]).position[2]
    near, far, out_of_reach = ((x, 0.0, height) for x in (0.55, 1.6, 6.0))
    for ability in ("reach", "grasp"):
        levels = [level(body, ability, cup) for cup in (near, far, out_of_reach)]
        assert levels[0] in (1, 2)
        assert levels[1:] == [4, 5]
    ahead = (1.5, 0.0, Stage(alone(body)).eye(alone(body).agent("R")).position[2])
    assert level(body, "see", ahead) == 0
    assert level(body, "see", (1.5, 1.6, ahead[2])) in (1, 2)


@pytest.mark.parametrize("body", EVERY_BODY)
def test_more_effort_never_loses_an_ability(body: str) -> None:
    stage = Stage(alone(body, (0.9, 0.5, 0.9)))
    for ability in ABILITIES:
        answers = [able(stage, "R", "cup", ability, max_level=most, settings=COARSE) for most in range(5)]
        assert answers == sorted(answers, key=bool)
        least = least_effort(stage, "R", "cup", ability, COARSE).level
        assert least is not None
        assert answers == [most >= least for most in range(5)]


@pytest.mark.parametrize("body", EVERY_BODY)
@pytest.mark.parametrize("cup", [(1.2, 0.9, 1.6), (0.8, -0.5, 0.6), (0.5, 0.1, 1.2)])
def test_no_joint_outside_of_the_level_moves(body: str, cup: tuple[float, float, float]) -> None:
    scene = alone(body, cup)
    stage, agent = Stage(scene), scene.agent("R")
    before = {axis.joint: float(scene.initial.qpos[agent.joints[axis.joint]]) for _, axis in agent.profile.axes}
    torso = {axis.joint for field, axis in agent.profile.axes if field.startswith("torso")}
    head = {axis.joint for field, axis in agent.profile.axes if field.startswith("head")}
    for ability in ABILITIES:
        found = least_effort(stage, "R", "cup", ability)
        moved = {name for name, angle in found.joints_rad.items() if abs(angle - before[name]) > 1e-9}
        allowed = {0: set[str](), 1: head, 2: head | torso}.get(found.level or 0, head | torso)
        assert moved <= (allowed if ability == "see" else allowed - head), (ability, found)
        ranges = {axis.joint: axis.range_rad for _, axis in agent.profile.axes}
        for name, angle in found.joints_rad.items():
            assert ranges[name][0] - 1e-9 <= angle <= ranges[name][1] + 1e-9
        assert set(found.actions) <= {*actions_of(agent), "No_Action_Required", "No_Possible_Known_Action"}


@pytest.mark.parametrize("body", EVERY_BODY)
def test_as_bystander_it_is_seen_and_hides_what_is_behind_it(body: str) -> None:
    scene = room(standing("P", "human"), standing("R", body, 1.2, 0.0, 180.0), cup=(1.9, 0.0, 0.6))
    stage = Stage(scene)
    for viewer, seen in (("P", "R"), ("R", "P")):
        assert np.isin(view_of(stage, viewer).geoms, scene.geoms_of(seen)).mean() > 0.005
    hidden = visibility(stage, "P", "cup")
    assert hidden is not None
    assert dict(hidden.occluders).get("R", 0) > 0
    way = least_effort(stage, "P", "cup", "reach")
    assert way.level == 4


@pytest.mark.parametrize("body", EVERY_BODY)
def test_where_the_room_stands_changes_nothing(body: str) -> None:
    turned = math.radians(70)
    cup = (0.7, 0.2, 1.0)
    placed = (
        3 + 0.7 * math.cos(turned) - 0.2 * math.sin(turned),
        -2 + 0.7 * math.sin(turned) + 0.2 * math.cos(turned),
        1.0,
    )
    elsewhere = Stage(room(standing("R", body, 3.0, -2.0, 70.0), cup=placed))
    for ability in ABILITIES:
        found = least_effort(elsewhere, "R", "cup", ability, COARSE)
        assert (found.level, found.actions) == (
            (here := least_effort(Stage(alone(body, cup)), "R", "cup", ability, COARSE)).level,
            here.actions,
        )


@needs("pr2")
def test_five_bodies_share_a_room_and_travel_in_one_bundle() -> None:
    bodies = ("human", "pr2", "talos", "jido", "hrp2")
    scene = room(*(standing(f"A_{body}", body, 2.0 * k, 3.0) for k, body in enumerate(bodies)))
    again = Scene.from_bundle(dict(scene.bundle))
    assert again.agents == tuple(f"A_{body}" for body in bodies)
    assert again.initial.qpos == pytest.approx(scene.initial.qpos)
    assert sum(map(len, scene.bundle.values())) < 2e6


def test_an_agent_inside_a_table_is_answered_not_refused() -> None:
    table = '<body name="table" pos="0 0 0.7"><geom type="box" size="0.8 0.8 0.02"/></body>'
    stage = Stage(room(standing("P", "human"), cup=(0.5, 0.0, 0.78), things=table))
    for ability in ABILITIES:
        assert least_effort(stage, "P", "cup", ability).level in range(6)


@needs("pr2")
def test_meshes_of_room_and_robot_come_together_without_a_warning(tmp_path: Path) -> None:
    (tmp_path / "wedge.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    shape = '<geometry><mesh filename="wedge.obj"/></geometry>'
    link = f'<link name="room"><visual>{shape}</visual><collision>{shape}</collision></link>'
    (tmp_path / "room.urdf").write_text(f'<robot name="r">{link}</robot>')
    people = '[agents.R]\nprofile = "pr2"\nposition_m = [-2, 0]\n[agents.H]\nprofile = "human"\nposition_m = [-3, 0]\n'
    (tmp_path / "scene.toml").write_text(f'[scene]\nmodel = "room.urdf"\n{people}')
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        warnings.filterwarnings("error", message="Attaching a child")
        assert Scene.load(tmp_path / "scene.toml").agents == ("R", "H")
