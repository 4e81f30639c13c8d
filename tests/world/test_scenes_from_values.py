"""Scenes made of values: what is written is read as it was, whatever it is called."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskgist.common.text import UNSEEN
from taskgist.errors import InputError, SceneError
from taskgist.world import AgentEntry, Scene, Stage
from taskgist.world.scene_file import PlacedModel, SceneFile, parse_scene_file, write_scene_file
from tests.meshes import obj

BOX, PLANE, MESH = mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_MESH
AWKWARD = 'say "hi" & <b> = \\ [agents]'
CORNERS = np.array([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)], dtype=float)
FACES = np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])

texts = st.text(min_size=1, max_size=8).filter(lambda text: not UNSEEN.search(text))
numbers = st.integers(-(10**9), 10**9).map(lambda number: number / 10**6)
tables = st.dictionaries(texts, numbers, max_size=2)


@st.composite
def entries(draw: st.DrawFn) -> AgentEntry:
    return AgentEntry(
        draw(texts.filter(lambda name: "/" not in name)),
        profile=draw(texts),
        position_m=(draw(numbers), draw(numbers)),
        yaw_rad=math.radians(draw(numbers)),
        posture=draw(st.sampled_from(["standing", "sitting"])),
        seat_height_m=draw(st.none() | st.just(0.4)),
        body=draw(tables),
        joints_rad={joint: math.radians(angle) for joint, angle in draw(tables).items()},
        joints_m=draw(tables),
    )


@st.composite
def entries_in_the_room(draw: st.DrawFn) -> AgentEntry:
    return AgentEntry(
        draw(texts.filter(lambda name: "/" not in name)),
        room_body=draw(texts),
        room_prefix=draw(st.just("") | texts),
        position_m=draw(st.none() | st.tuples(numbers, numbers)),
        yaw_rad=draw(st.none() | numbers.map(math.radians)),
    )


@st.composite
def placed_models(draw: st.DrawFn) -> PlacedModel:
    roll, pitch, yaw = (math.radians(draw(numbers)) for _ in range(3))
    is_mesh = draw(st.booleans())
    return PlacedModel(
        draw(texts.filter(lambda name: "/" not in name)),
        "object" if is_mesh else draw(st.sampled_from(["furniture", "object"])),
        draw(texts),
        position_m=(draw(numbers), draw(numbers), draw(numbers)),
        rpy_rad=(roll, pitch, yaw) if draw(st.booleans()) else (0.0, 0.0, yaw),
        is_mesh=is_mesh,
        scale=draw(st.sampled_from([1.0, 0.001])) if is_mesh else 1.0,
        mass_kg=draw(st.none() | st.just(0.3)) if is_mesh else None,
    )


@given(
    texts,
    texts,
    st.none() | st.lists(texts, max_size=2).map(tuple),
    st.lists(texts, max_size=2).map(tuple),
    st.lists(entries() | entries_in_the_room() | placed_models(), max_size=3, unique_by=lambda entry: entry.name),
    st.none() | st.lists(st.integers(0, 5), min_size=1, max_size=3).map(tuple),
    st.none() | texts,
    st.lists(texts, max_size=2).map(tuple),
)
def test_a_written_scene_file_reads_as_the_same_value(
    name: str,
    model: str,
    objects: tuple[str, ...] | None,
    estimated: tuple[str, ...],
    tables: list[AgentEntry | PlacedModel],
    seen_groups: tuple[int, ...] | None,
    keyframe: str | None,
    leave_out: tuple[str, ...],
) -> None:
    agents = tuple(each for each in tables if isinstance(each, AgentEntry))
    models = [each for each in tables if isinstance(each, PlacedModel)]
    placed = tuple(sorted(models, key=lambda each: each.kind))  # furniture first
    file = SceneFile(name, model, objects, estimated, agents, "here", seen_groups, keyframe, leave_out, placed)
    assert parse_scene_file(write_scene_file(file), where="elsewhere") == file


def room() -> mujoco.MjSpec:
    spec = mujoco.MjSpec()
    spec.modelname = AWKWARD
    spec.worldbody.add_geom(name="floor", type=PLANE, size=(5.0, 5.0, 0.1))
    cube = spec.worldbody.add_body(name=AWKWARD, pos=(0.5, 0.25, 0.05))
    cube.add_freejoint()
    cube.add_geom(type=BOX, size=(0.05, 0.05, 0.05))
    return spec


def test_a_room_that_is_a_value_may_have_a_keyframe_and_bodies_to_leave_out() -> None:
    spec = room()
    spec.worldbody.add_body(name="mark").add_geom(type=BOX, size=(0.1, 0.1, 0.1))
    spec.add_key(name="k", qpos=(1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0))
    scene = Scene.from_spec(spec, keyframe="k", leave_out=["mark"])
    assert scene.bodies == (AWKWARD,)
    assert scene.initial.qpos[:3] == pytest.approx((1, 2, 3))
    with pytest.raises(InputError, match=r"scene: scene\.keyframe: no keyframe 'l'"):
        Scene.from_spec(spec, keyframe="l")


def test_names_may_hold_any_sign() -> None:
    who = AgentEntry('P "1"', position_m=(-0.5, 0.0), yaw_rad=0.25, body={"stature_m": 1.6})
    scene = Scene.from_spec(room(), [who, AgentEntry("P2", position_m=(2.0, 0.0))], name=AWKWARD, estimated=[AWKWARD])
    for each in (scene, Scene.from_bundle(scene.bundle)):
        assert (each.name, each.agents, each.objects) == (AWKWARD, ('P "1"', "P2"), (AWKWARD,))
        assert each.estimated == {AWKWARD}
        assert each.agent('P "1"').stature_m == 1.6
        assert each.initial.qpos[each.base_slice('P "1"')][:2] == pytest.approx((-0.5, 0.0))
        assert each.initial.qpos[each.object_slice(AWKWARD)][:3] == pytest.approx((0.5, 0.25, 0.05))


@pytest.mark.parametrize("on_disk", [False, True])
def test_meshes_come_from_the_specification_or_from_disk(tmp_path: Path, on_disk: bool) -> None:
    spec, text = room(), obj((CORNERS, FACES))
    if on_disk:
        (tmp_path / "shapes").mkdir()
        (tmp_path / "shapes" / "wedge.obj").write_bytes(text)
        (tmp_path / "room.xml").write_text(spec.to_xml())
        spec = mujoco.MjSpec.from_file(str(tmp_path / "room.xml"))
    else:
        spec.assets = {"shapes/wedge.obj": text}
    spec.add_mesh(name="wedge", file="shapes/wedge.obj")
    wedge = spec.worldbody.add_body(name="wedge", pos=(0.0, 0.0, 1.0))
    wedge.add_freejoint()
    wedge.add_geom(type=MESH, meshname="wedge")
    scene = Scene.from_spec(spec)
    geoms, distances_m = Stage(scene).cast((0.01, 0.01, 2.0), np.array([(0.0, 0.0, -1.0)]))
    assert scene.owners[geoms[0]] == "wedge"
    assert distances_m[0] == pytest.approx(0.92)
    assert spec.meshes[0].file == "shapes/wedge.obj"


def test_a_profile_of_your_own_is_read_from_its_file(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"lab: agents\.R\.profile"):
        Scene.from_spec(room(), [AgentEntry("R", profile=str(tmp_path / "none.toml"))], name="lab")


def test_what_cannot_be_compiled_is_told_with_the_name_of_the_scene() -> None:
    spec = room()
    spec.worldbody.add_body(name="flat").add_geom(type=BOX, size=(0.0, 0.1, 0.1))
    with pytest.raises(SceneError, match=r"the hall.*of body 'flat'.*a shape of no size"):
        Scene.from_spec(spec, name="the hall")
