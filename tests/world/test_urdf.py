"""URDF: rooms and robots as ROS describes them."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from taskgist.errors import SceneError
from taskgist.perspective import visibility
from taskgist.settings import DEFAULT
from taskgist.world import Scene, Stage, support_of
from taskgist.world.bodies.collada import triangles_from_dae
from taskgist.world.bodies.meshes import flat_name
from taskgist.world.bodies.model_files import find_file, is_urdf
from taskgist.world.bodies.urdf import read_urdf
from tests.bodies import URDFS, is_there, needs

ROOM = """<?xml version="1.0"?>
<robot name="room">
  <link name="floor"><visual><origin xyz="0 0 -0.05"/><geometry><box size="6 6 0.1"/></geometry></visual>
    <collision><origin xyz="0 0 -0.05"/><geometry><box size="6 6 0.1"/></geometry></collision></link>
  <link name="table">
    <inertial><mass value="-3"/><inertia ixx="0" ixy="0" ixz="0" iyy="1" iyz="0" izz="nan"/></inertial>
    <visual><geometry><box size="0.8 1.2 0.04"/></geometry>
      <material name="oak"><color rgba="0.6 0.4 0.2 1"/><texture filename="package://nowhere/oak.png"/></material></visual>
    <collision><geometry><box size="0.8 1.2 0.04"/></geometry></collision></link>
  <joint name="to_table" type="fixed"><parent link="floor"/><child link="table"/><origin xyz="1 0 0.7"/></joint>
  <link name="block"><inertial><mass value="0.2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><geometry><mesh filename="MESH"/></geometry></visual>
    <collision><geometry><mesh filename="MESH"/></geometry></collision></link>
  <joint name="to_block" type="floating"><parent link="floor"/><child link="block"/><origin xyz="0.8 0 0.77"/></joint>
  <link name="lamp"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="to_lamp" type="fixed"><parent link="table"/><child link="lamp"/><origin xyz="0.2 0.4 0.12"/></joint>
</robot>"""

DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit name="centimeter" meter="0.01"/><up_axis>Y_UP</up_axis></asset>
  <library_geometries><geometry id="cube"><mesh>
    <source id="p"><float_array id="pa" count="24">{points}</float_array>
      <technique_common><accessor source="#pa" count="8" stride="3"/></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    {faces}
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="s"><node id="n">{transform}
    <node><instance_geometry url="#cube"/></node></node>
  </visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#s"/></scene>
</COLLADA>"""
CORNERS = [(x, y, z) for x in (-5, 5) for y in (-5, 5) for z in (-5, 5)]
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
TRIANGLES = [(q[0], q[k], q[k + 1]) for q in QUADS for k in (1, 2)]


def dae(kind: str = "triangles", transform: str = "") -> bytes:
    """A cube of 10 cm as COLLADA, with normals between the points' indices."""
    loops = TRIANGLES if kind == "triangles" else QUADS
    indices = [" ".join(f"{i} 0" for i in loop) for loop in loops]
    inputs = '<input semantic="VERTEX" source="#v" offset="0"/><input semantic="NORMAL" source="#p" offset="1"/>'
    head = f'<{kind} count="{len(loops)}">{inputs}'
    counts = f"<vcount>{' '.join(str(len(loop)) for loop in loops)}</vcount>" if kind == "polylist" else ""
    body = "".join(f"<p>{each}</p>" for each in indices) if kind == "polygons" else f"<p>{' '.join(indices)}</p>"
    points = " ".join(str(value) for corner in CORNERS for value in corner)
    return DAE.format(points=points, faces=f"{head}{counts}{body}</{kind}>", transform=transform).encode()


def volume(triangles: np.ndarray) -> float:
    return float(np.abs(np.linalg.det(triangles).sum()) / 6)


def written(folder: Path, mesh: str, agents: str = "") -> Path:
    (folder / "room.urdf").write_text(ROOM.replace("MESH", mesh))
    (folder / "scene.toml").write_text(f'[scene]\nmodel = "room.urdf"\n{agents}')
    return folder / "scene.toml"


@pytest.mark.parametrize("kind", ["triangles", "polylist", "polygons"])
def test_collada_becomes_triangles_in_metres_whatever_its_faces(kind: str) -> None:
    triangles = triangles_from_dae(dae(kind), "cube.dae")
    assert len(triangles) == 12
    assert volume(triangles) == pytest.approx(1e-3, rel=1e-5)
    assert triangles.reshape(-1, 3).min(axis=0) == pytest.approx((-0.05,) * 3)


@pytest.mark.parametrize(
    ("transform", "low"),
    [
        ("<translate>100 0 0</translate>", (0.95, -0.05, -0.05)),
        ("<scale>2 1 1</scale>", (-0.1, -0.05, -0.05)),
        ("<translate>0 100 0</translate><rotate>0 0 1 90</rotate><scale>2 1 1</scale>", (-0.05, 0.9, -0.05)),
        ("<matrix>1 0 0 0 0 1 0 0 0 0 1 -100 0 0 0 1</matrix>", (-0.05, -0.05, -1.05)),
    ],
)
def test_the_nodes_of_collada_place_their_shapes(transform: str, low: tuple[float, float, float]) -> None:
    points = triangles_from_dae(dae(transform=transform), "x").reshape(-1, 3)
    assert points.min(axis=0) == pytest.approx(low, abs=1e-6)


@pytest.mark.parametrize(
    "data", [b"<COLLADA/>", b"no xml", dae().replace(b"#pa", b"#pb").replace(b'id="p"', b'id="q"')]
)
def test_collada_that_cannot_be_read_says_how_to_save_it(data: bytes) -> None:
    with pytest.raises(SceneError, match=r"x: .*save it as STL or OBJ"):
        triangles_from_dae(data, "x")


@pytest.mark.parametrize("uri", ["meshes/block.dae", "package://things/meshes/block.dae"])
def test_a_room_in_urdf(tmp_path: Path, uri: str, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "src" / "things"
    (package / "meshes").mkdir(parents=True)
    (package / "meshes" / "block.dae").write_bytes(dae())
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "src"))
    path = written(package, uri, "[agents.P1]\nposition_m = [-0.2, 0]\n")
    scene = Scene.load(path)
    assert scene.objects == ("block",), "what floats is an object"
    assert set(scene.bodies) == {"table", "block"}, "the root is the world, the lamp belongs to the table"
    stage = Stage(scene)
    assert support_of(stage, "block", DEFAULT.contact) == "table"
    seen = visibility(stage, "P1", "block")
    assert seen is not None
    assert seen.visible_px > 100
    shutil.rmtree(tmp_path / "src")
    again = Scene.from_bundle(dict(scene.bundle))
    assert visibility(Stage(again), "P1", "block") == seen, "the bundle needs none of the files"


def test_what_is_shown_is_seen_and_what_collides_blocks(tmp_path: Path) -> None:
    (tmp_path / "block.dae").write_bytes(dae())
    scene = Scene.load(written(tmp_path, "block.dae"))
    model = scene.model
    kinds = {
        name: sorted((int(model.geom_group[g]), bool(model.geom_contype[g])) for g in scene.geoms_of(name))
        for name in ("block", "table")
    }
    assert kinds["block"] == [(1, False), (3, True)]
    assert kinds["table"] == [(1, False), (1, True), (3, True)], "the lamp only collides: it is seen by that"


def test_a_urdf_in_memory_is_read_too() -> None:
    bundle = {
        "scene.toml": b'[scene]\nmodel = "room.urdf"\n',
        "room.urdf": ROOM.replace("MESH", "meshes/block.dae").encode(),
        "meshes/block.dae": dae(),
    }
    scene = Scene.from_bundle(bundle)
    assert scene.objects == ("block",)
    assert Scene.from_bundle(dict(scene.bundle)).objects == ("block",)


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        (
            "MESH",
            "package://nix/block.stl",
            "mesh: no such file in any package .*folder that holds 'nix' to ROS_PACKAGE_PATH",
        ),
        ("MESH", "block.stl", r"mesh: no such file .*block\.stl"),
        ("</robot>", "", r"room\.urdf: not valid XML"),
        ('<child link="table"/>', '<child link="nothing"/>', "a URDF has one root link .*floor, table"),
        ('filename="MESH"', "", "a mesh without a file"),
        ('<sphere radius="0.1"/>', '<sphere radius="0"/>', "sphere without a name of body 'lamp': a shape of no size"),
        ('type="fixed"', 'type="wobbly"', "MuJoCo cannot read"),
    ],
)
def test_urdf_that_cannot_be_used_says_why(tmp_path: Path, right: str, wrong: str, message: str) -> None:
    (tmp_path / "room.urdf").write_text(ROOM.replace(right, wrong).replace("MESH", "there.dae"))
    (tmp_path / "there.dae").write_bytes(dae())
    (tmp_path / "scene.toml").write_text('[scene]\nmodel = "room.urdf"\n')
    with pytest.raises(SceneError, match=message):
        Scene.load(tmp_path / "scene.toml")


def test_names_of_meshes_stay_apart_without_their_folders() -> None:
    uris = ["package://a/m/x.stl", "package://b/m/x.stl", "a/m/y.stl", "../a/x.stl", "package:///a/n/x.stl"]
    names = [flat_name(uri) for uri in uris]
    assert len(set(names)) == len(uris)
    assert not any("/" in name for name in names)


def test_urdf_is_told_from_mjcf() -> None:
    assert is_urdf(ROOM.encode())
    assert not is_urdf(b"<mujoco><worldbody/></mujoco>")
    assert not is_urdf(b"<mujoco><!-- <robot> --></mujoco>")
    with pytest.raises(SceneError, match="not a URDF document"):
        read_urdf(b"<sdf/>", lambda _: b"", {}, where="x")


@needs("pr2")
@pytest.mark.parametrize("name", URDFS)
def test_every_link_of_a_robot_is_a_body(name: str) -> None:
    path = find_file(URDFS[name], near=None, where="test", field="model")
    text = path.read_bytes()

    def read(uri: str) -> bytes:
        return find_file(uri, near=path.parent, where=path, field="mesh").read_bytes()

    files: dict[str, bytes] = {}
    spec = read_urdf(text, read, files, where=path, prefix="R_", shapes="collision")
    links = {line.split(b'"')[1].decode() for line in text.split(b"<link ")[1:] if line.startswith(b'name="')}
    assert {str(body.name) for body in spec.bodies} - {"world"} == links
    assert all(file.startswith("R_") and "/" not in file for file in files)
    assert is_there(name)
