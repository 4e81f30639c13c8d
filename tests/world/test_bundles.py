"""Files of a bundle lie side by side, and none takes the place of another, wherever they come from."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from taskgist.world import Scene
from taskgist.world.bodies.model_files import add_model, read_model
from tests.meshes import octahedron, stl

SMALL, LARGE = 0.1, 0.4
"""Radii of two octahedra, metres."""
URDF = """<robot name="room"><link name="floor"/>
<link name="p"><visual><geometry><mesh filename="a/m.stl"/></geometry></visual></link>
<joint name="j" type="floating"><parent link="floor"/><child link="p"/></joint>
<link name="q"><visual><geometry><mesh filename="a_m.stl"/></geometry></visual></link>
<joint name="k" type="floating"><parent link="floor"/><child link="q"/></joint></robot>"""
MJCF = """<mujoco><asset><mesh name="p" file="a/m.stl"/><mesh name="q" file="a_m.stl"/></asset><worldbody>
<body><geom type="mesh" mesh="p"/></body><body><geom type="mesh" mesh="q"/></body></worldbody></mujoco>"""
ONE = """<mujoco>{compiler}<asset><mesh name="m" file="{file}"/></asset>
<worldbody><body name="b"><geom type="mesh" mesh="m"/></body></worldbody></mujoco>"""


def radii(model: mujoco.MjModel) -> list[float]:
    """Of every mesh, metres: of an octahedron, whose middle is the origin."""
    ends = [(start, start + count) for start, count in zip(model.mesh_vertadr, model.mesh_vertnum, strict=True)]
    return [float(np.linalg.norm(model.mesh_vert[start:end], axis=1).max()) for start, end in ends]


def written(folder: Path, files: dict[str, bytes]) -> None:
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)


@pytest.mark.parametrize(("name", "text"), [("room.urdf", URDF), ("room.xml", MJCF)])
def test_two_files_of_one_name_in_different_folders_are_two(tmp_path: Path, name: str, text: str) -> None:
    meshes = {"a/m.stl": stl(octahedron(SMALL)), "a_m.stl": stl(octahedron(LARGE))}
    written(tmp_path, {"scene.toml": f'[scene]\nmodel = "{name}"\n'.encode(), name: text.encode(), **meshes})
    scene = Scene.load(tmp_path / "scene.toml")
    assert radii(scene.model) == pytest.approx([SMALL, LARGE])
    assert radii(Scene.from_bundle(dict(scene.bundle)).model) == pytest.approx([SMALL, LARGE])


def test_meshes_of_a_specification_are_as_many_as_it_has() -> None:
    spec = mujoco.MjSpec()
    meshes = {"a/m.stl": SMALL, "a_m.stl": LARGE, "b/m.stl": LARGE}
    for name in meshes:
        spec.add_mesh(name=name.replace("/", " "), file=name)
        spec.worldbody.add_body().add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name.replace("/", " "))
    spec.assets = {name: stl(octahedron(radius)) for name, radius in meshes.items()}
    assert radii(Scene.from_spec(spec).model) == pytest.approx(list(meshes.values()))


def test_images_are_left_out_whether_they_are_there_or_not(tmp_path: Path) -> None:
    spec = mujoco.MjSpec()
    texture = spec.add_texture(name="sky", type=mujoco.mjtTexture.mjTEXTURE_CUBE)
    texture.cubefiles = [f"sky/{side}.png" for side in range(6)]
    spec.add_texture(name="wood", type=mujoco.mjtTexture.mjTEXTURE_2D, file="wood.png")
    material = spec.add_material(name="oak", rgba=(0.6, 0.4, 0.2, 0.9))
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "wood"
    spec.worldbody.add_geom(size=(0.1, 0, 0), material="oak")
    spec.add_skin(name="glove", file="glove.skn")
    spec.modelfiledir = str(tmp_path)
    scene = Scene.from_spec(spec)
    assert set(scene.bundle) == {"scene.toml", "room.xml"}
    assert scene.model.mat_rgba[scene.model.geom_matid[0]] == pytest.approx((0.6, 0.4, 0.2, 0.9)), "colours stay"


TEXTURED = """<mujoco><compiler texturedir="images"/>
<default><default class="d"><material texture="t"/></default></default>
<asset><texture name="t" type="2d" file="nowhere.png"/><texture type="skybox" builtin="flat" width="8" height="8"/>
<material name="m" class="d" texture="t" rgba="1 0 0 1"/>
<material name="n"><layer role="rgb" texture="t"/></material></asset>
<custom><tuple name="all"><element objtype="texture" objname="t"/><element objtype="material" objname="m"/></tuple>
</custom>
<worldbody><geom size="1" material="m"/><geom size="1" material="n"/></worldbody></mujoco>"""


def test_a_missing_texture_stops_no_scene(tmp_path: Path) -> None:
    written(tmp_path, {"scene.toml": b'[scene]\nmodel = "room.xml"\n', "room.xml": TEXTURED.encode()})
    model = Scene.load(tmp_path / "scene.toml").model
    assert model.ntex == 0
    assert model.mat_rgba[model.geom_matid[0]].tolist() == [1, 0, 0, 1]


def test_meshes_of_an_attached_model_are_found_from_where_it_lies(tmp_path: Path) -> None:
    outer = """<mujoco><asset><model name="shelf" file="sub/shelf.xml"/></asset><worldbody>
    <frame pos="0 1 0"><attach model="shelf" body="shelf" prefix="a_"/></frame></worldbody></mujoco>"""
    inner = """<mujoco><asset><mesh name="p" file="parts/p.stl"/></asset><worldbody>
    <body name="shelf"><geom type="mesh" mesh="p"/></body></worldbody></mujoco>"""
    texts = {
        "scene.toml": b'[scene]\nmodel = "room.xml"\n',
        "room.xml": outer.encode(),
        "sub/shelf.xml": inner.encode(),
    }
    written(tmp_path, {**texts, "sub/parts/p.stl": stl(octahedron(SMALL))})
    scene = Scene.load(tmp_path / "scene.toml")
    assert scene.bodies == ("a_shelf",)
    assert radii(scene.model) == pytest.approx([SMALL])


def test_a_robot_and_a_room_and_another_robot_keep_their_own_meshes(tmp_path: Path) -> None:
    parts = {"a": ("b_m.stl", 0.1), "a_b": ("m.stl", 0.2), "": ("a_b_m.stl", 0.3)}
    files: dict[str, bytes] = {}
    for name, (mesh, radius) in parts.items():
        text = ONE.format(compiler="", file=mesh)
        written(tmp_path / f"of {name}", {"model.xml": text.encode(), mesh: stl(octahedron(radius))})
        add_model(tmp_path / f"of {name}" / "model.xml", f"{name}.xml", files, prefix=f"{name}_" if name else "")
    for name, (_, radius) in parts.items():
        spec = read_model(files, f"{name}.xml", where="a test", room=False)
        assert radii(spec.compile()) == pytest.approx([radius])


def test_reading_one_model_leaves_the_files_of_others() -> None:
    room = ONE.format(compiler='<compiler meshdir="meshes"/>', file="x.stl").encode()
    files = {"room.xml": room, "meshes/x.stl": stl(octahedron(SMALL))}
    files |= {"P.xml": ONE.format(compiler="", file="x.stl").encode(), "x.stl": stl(octahedron(LARGE))}
    before = dict(files)
    assert radii(read_model(files, "room.xml", where="a test", room=True).compile()) == pytest.approx([SMALL])
    assert radii(read_model(files, "P.xml", where="a test", room=False).compile()) == pytest.approx([LARGE])
    assert before.items() <= files.items()
