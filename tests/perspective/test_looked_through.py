"""Glass is looked through, and still solid; who looks for it sees it. Planes hide from both sides."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from taskgist.maps.ability_map import ability_map
from taskgist.perspective import least_effort, view_of, visibility
from taskgist.settings import DEFAULT, Maps
from taskgist.world import Scene, Stage, State, holding_of
from tests.perspective.comparing import compare_pixels
from tests.perspective.random_rooms import Case, random_case

ROOM = """<mujoco><asset><material name="tinted" rgba=".2 .3 .2 {alpha}"/></asset><worldbody>
<geom name="floor" type="plane" size="10 10 .1"/>
<body name="table" pos="1 0 .725"><geom type="box" size=".4 .6 .015"/></body>
<body name="pane" pos=".5 0 1.2"><geom type="box" size=".003 .8 .5" {paint}/>{post}</body>
<body name="cup" pos=".8 0 .79"><freejoint/><geom type="cylinder" size=".035 .05"/></body>
<body name="bottle" pos=".8 .3 .84"><freejoint/><geom type="cylinder" size=".03 .1" rgba="1 1 1 .2"/></body>
</worldbody></mujoco>"""
SCENE = b'[scene]\nmodel = "room.xml"\n[agents.P1]\nposition_m = [0, 0]\n'
PAINTS = ('rgba=".8 .9 1 {alpha}"', 'material="tinted"')


def stage_of(alpha: float, paint: str = PAINTS[0], post: str = "") -> Stage:
    room = ROOM.format(alpha=alpha, paint=paint.format(alpha=alpha), post=post)
    return Stage(Scene.from_bundle({"scene.toml": SCENE, "room.xml": room.encode()}))


def visible_px(stage: Stage, name: str) -> float:
    seen = visibility(stage, "P1", name)
    assert seen is not None
    return seen.visible_px


@pytest.mark.parametrize("paint", PAINTS)
def test_a_pane_of_glass_is_looked_through(paint: str) -> None:
    clear, dim, without = stage_of(0.2, paint), stage_of(0.6, paint), stage_of(0.0, paint)
    for name in ("cup", "bottle"):
        assert least_effort(clear, "P1", name, "see").level in (0, 1)
        assert visible_px(clear, name) == visible_px(without, name) > 0
        hidden = visibility(dim, "P1", name)
        assert hidden is not None
        assert hidden.visible_px == 0
        assert [owner for owner, _ in hidden.occluders] == ["pane"]


def test_what_is_looked_through_is_a_setting() -> None:
    stage, keen = stage_of(0.2), replace(DEFAULT, vision=replace(DEFAULT.vision, transparent_alpha=0.1))
    seen = visibility(stage, "P1", "cup", keen)
    assert seen is not None
    assert seen.visible_px == 0
    assert [owner for owner, _ in seen.occluders] == ["pane"]
    assert keen.digest != DEFAULT.digest
    assert "pane" in view_of(stage, "P1", keen).pixels()
    assert "pane" not in view_of(stage, "P1").pixels()


def test_a_frame_around_glass_still_hides() -> None:
    post = '<geom type="box" size=".003 .1 .5" rgba="0 0 0 1"/>'
    stage = stage_of(0.2, post=post)
    seen = visibility(stage, "P1", "cup")
    assert seen is not None
    assert [owner for owner, _ in seen.occluders] == ["pane"]
    assert seen.visible_px == 0


def test_a_bottle_of_glass_is_seen_by_who_looks_for_it_and_hides_nothing() -> None:
    stage = stage_of(0.2)
    scene = stage.scene
    behind = scene.initial.replace(at=scene.object_slice("cup"), to=(1.0, 0.375, 0.79, 1, 0, 0, 0))
    stage = Stage(scene, behind)
    for name in ("cup", "bottle"):
        seen = visibility(stage, "P1", name)
        assert seen is not None
        assert seen.visible_px == seen.unoccluded_px > 0
    assert view_of(stage, "P1").pixels().get("bottle", 0) == 0


def test_glass_carries_and_is_solid() -> None:
    stage = stage_of(0.2)
    scene = stage.scene
    table = scene.geoms_of("table")
    scene.model.geom_rgba[table, 3] = 0.2
    scene = Scene.from_bundle(
        {
            "scene.toml": SCENE,
            "room.xml": bytes(scene.bundle["room.xml"]).replace(b'.6 .015"/>', b'.6 .015" rgba="1 1 1 .2"/>'),
        }
    )
    holding = holding_of(Stage(scene), "cup", DEFAULT.contact)
    assert holding is not None
    assert holding.support == "table"
    assert set(scene.geoms_of("pane")) <= set(scene.solid_geoms)


def test_maps_look_through_glass() -> None:
    """A map's cell is a point; what is behind the pane is seen as if it were not there, and not through a board."""
    coarse = replace(DEFAULT, maps=Maps(cell_m=0.15))
    maps = [ability_map(stage_of(alpha), "P1", "see", settings=coarse) for alpha in (0.0, 0.2, 0.6)]
    solid = maps[1].solid | maps[2].solid
    levels = [np.where(solid, -1, each.levels) for each in maps]
    assert (levels[0] == levels[1]).all()
    assert (levels[1] != levels[2]).sum() > 20


@pytest.mark.parametrize("seed", range(60, 66))
def test_rooms_with_glass_are_seen_as_mujoco_sees_them_without(seed: int) -> None:
    """The twin takes what is transparent away, but for what is looked for."""
    case, rng = random_case(seed), np.random.default_rng(seed)
    files = dict(case.scene.bundle)
    room = files["room.xml"].decode()
    files["room.xml"] = re.sub(
        r"<geom (?!name=\"floor)", lambda _: f'<geom rgba="1 1 1 {rng.choice((0.3, 1.0))}" ', room
    ).encode()
    scene = Scene.from_bundle(files)
    state = State(case.state.qpos, untracked=case.state.untracked, holding=case.state.holding)
    found = compare_pixels(Case(seed, scene, state), whole=False)
    assert found.count > 2
    assert not found.differences
    alpha = scene.model.geom_rgba[:, 3]
    assert ((alpha > 0) & (alpha < 0.5)).any()


# planes -------------------------------------------------------------------------------------------------------

SCREENED = """<mujoco><compiler angle="degree"/><worldbody><geom name="floor" type="plane" size="10 10 .1"/>
<geom name="screen" type="plane" pos="1 0 1.6" euler="0 {turn} 0" size=".6 .6 .1"/>
<body name="cup" pos="1.5 0 1.6"><freejoint/><geom {shape}/></body></worldbody>
<asset><mesh name="wedge" vertex="-.04 -.04 -.04  .04 -.04 -.04  0 .04 -.04  0 0 .04"/></asset></mujoco>"""


@pytest.mark.parametrize("turn", [90, -90])
@pytest.mark.parametrize("shape", ['type="cylinder" size="0.035 0.05"', 'type="mesh" mesh="wedge"'])
def test_a_plane_hides_from_both_sides(turn: int, shape: str) -> None:
    room = SCREENED.format(turn=turn, shape=shape).encode()
    stage = Stage(Scene.from_bundle({"scene.toml": SCENE, "room.xml": room}))
    seen = visibility(stage, "P1", "cup")
    assert seen is not None
    assert seen.visible_px == 0
    assert [owner for owner, _ in seen.occluders] == ["screen"]
    assert least_effort(stage, "P1", "cup", "see").level not in (0, 1)
    assert "cup" not in view_of(stage, "P1").pixels()
    cells = ability_map(stage, "P1", "see", settings=replace(DEFAULT, maps=Maps(cell_m=0.15)))
    behind = np.abs(cells.grid.centers() - (1.3, 0.0, 1.6)).max(axis=1).argmin()
    assert cells.levels.ravel()[behind] > 1


def test_a_plane_is_met_like_a_thin_board_from_wherever_rays_come() -> None:
    boards = ('type="plane" size=".6 .4 .1"', 'type="box" size=".6 .4 1e-9"')
    stages = [
        Stage(
            Scene.from_bundle(
                {
                    "scene.toml": SCENE,
                    "room.xml": f'<mujoco><worldbody><geom name="board" pos="1 0 1" euler=".4 .7 .2" {board}/>'
                    '<body name="cup" pos="9 9 9"><freejoint/><geom size=".01"/></body></worldbody></mujoco>'.encode(),
                }
            )
        )
        for board in boards
    ]
    rng = np.random.default_rng(0)
    ways = rng.normal(size=(4000, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    starts = (1, 0, 1) + rng.uniform(-1.5, 1.5, (20, 3))
    met = 0
    for start in starts:
        plane, box = (stage.cast_at(stage.scene.geoms_of("board"), start, ways) for stage in stages)
        by_mujoco = [stage.cast(start, ways, only=stage.scene.geoms_of("board")) for stage in stages]
        normals = np.zeros_like(ways)
        stages[0].cast(start, ways, only=stages[0].scene.geoms_of("board"), normals=normals)
        each = stages[0].cast_each(stages[0].scene.geoms_of("board"), np.tile(start, (len(ways), 1)), ways)
        hit = plane[0] >= 0
        assert (hit == (box[0] >= 0)).all()
        assert plane[1][hit] == pytest.approx(box[1][hit], abs=1e-6)
        assert (by_mujoco[0][0] == by_mujoco[1][0]).all()
        assert by_mujoco[0][1][hit] == pytest.approx(plane[1][hit], abs=1e-9)
        assert (np.sum(normals[hit] * ways[hit], axis=1) < 0).all()
        assert each[2][hit] == pytest.approx(normals[hit], abs=1e-9)
        met += int(hit.sum())
    assert met > 1000
    assert math.isinf(float(plane[1][~hit][0]))
