"""Models as they are published: what is no model is named, and what lacks masses or sizes is read."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from taskgist.errors import SceneError
from taskgist.world import Scene
from taskgist.world.body_check import check_body

PROFILE = """name = "robot"
model = "{model}"
[eye]
frame = "head"
exclude = "head"
fov_deg = [60, 45]
image_px = [320, 240]
[head]
pan = {{ joint = "pan" }}
"""
LINK = '<link name="{name}"><visual><geometry>{shape}</geometry></visual></link>'


def loaded(folder: Path, name: str, content: bytes) -> Scene:
    """A room whose model is that file."""
    (folder / name).write_bytes(content)
    (folder / "scene.toml").write_text(f'[scene]\nmodel = "{name}"')
    return Scene.load(folder / "scene.toml")


XACRO = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{}</robot>'
BOX = LINK.format(name="a", shape='<box size="1 1 1"/>')
IFC = b"ISO-10303-21;\nHEADER;\nFILE_SCHEMA (('IFC4'));\nENDSEC;"
FOREIGN = [
    (
        "cup.sdf",
        b'<?xml version="1.0"?><!-- a <robot> --><sdf version="1.6"/>',
        "is SDF, the format of Gazebo; convert",
    ),
    ("cup.xml", b"<sdf version='1.6'/>", "sdf2mjcf model.sdf model.xml"),
    ("empty.world", b"<sdf version='1.6'><world/></sdf>", "is SDF"),
    ("room.usda", b"#usda 1.0\n", "is USD (Universal Scene Description)"),
    ("room.usd", b"PXR-USDC\0\0", "is USD"),
    ("room.usdz", b"PK\x03\x04" + bytes(26) + b"room.usdc", "is USD"),
    ("room.glb", b"glTF\x02\0\0\0", "is glTF; import it in Blender"),
    ("room.gltf", b'{"asset": {"version": "2.0"}}', "is glTF"),
    ("room.fbx", b"Kaydara FBX Binary  \0", "is FBX"),
    ("room.blend", b"\x28\xb5\x2f\xfd packed", "is a Blender file"),
    ("room.dae", b"<COLLADA version='1.4.1'/>", "is COLLADA, a mesh and no model; name it in an MJCF: <mesh file=...>"),
    ("room.obj", b"v 0 0 0\n", "is OBJ, a mesh and no model"),
    ("room.stl", b"solid a", "is STL, a mesh and no model"),
    ("room.ply", b"ply\n", "is PLY, a mesh and no model"),
    ("room.wrl", b"#VRML V2.0 utf8\n", "is VRML or X3D"),
    ("room.x3d", b"<X3D/>", "is VRML or X3D"),
    ("room.skp", b"\xff\xfe\xff\x0eS\0k\0e\0t\0c\0h\0U\0p\0", "is a SketchUp model"),
    ("room.3ds", b"MM\x10\0", "is 3DS"),
    ("room.step", b"ISO-10303-21;\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN'));", "is STEP, solids of CAD"),
    ("room.ifc", IFC, "is IFC, a building"),
    ("arm.srdf", b"<robot name='r'><group name='arm'/></robot>", "is SRDF, which tells MoveIt about a robot"),
    ("part.xml", b"<mujocoinclude><geom/></mujocoinclude>", "is a part of an MJCF, to be included; name the document"),
    ("room.mjb", b"\x31\xd4\0\0", "is MJB, a compiled model"),
    ("arm.xacro", XACRO.format(BOX).encode(), "expand it first: xacro arm.xacro > arm.urdf, and name that file"),
    ("arm.urdf.xacro", XACRO.format(BOX).encode(), "xacro arm.urdf.xacro > arm.urdf"),
    (
        "arm.urdf",
        XACRO.format(BOX + "<xacro:include/>").encode(),
        "not expanded: <xacro:include>; expand it first: xacro",
    ),
    ("arm.urdf", BOX.replace("1 1 1", "${w} 1 1").join(("<robot>", "</robot>")).encode(), "not expanded: ${w} 1 1"),
    ("macro.urdf", XACRO.format("").encode(), "a URDF without any link; xacro leaves such a document"),
    ("page.xml", b"<html/>", "not a model; models are MJCF (<mujoco>) and URDF (<robot>)"),
]


@pytest.mark.parametrize(("name", "content", "says"), FOREIGN)
def test_what_is_no_model_is_named_for_what_it_is(name: str, content: bytes, says: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError) as error:
        loaded(tmp_path, name, content)
    assert says in str(error.value)
    assert name in str(error.value)


def test_the_check_of_a_robot_names_it_too(tmp_path: Path) -> None:
    (tmp_path / "arm.xacro").write_text(XACRO.format(BOX + '<xacro:arg name="p"/>'))
    (tmp_path / "robot.toml").write_text(PROFILE.format(model="arm.xacro"))
    (problem,) = check_body(str(tmp_path / "robot.toml")).problems
    assert "is xacro that is not expanded; expand it first: xacro arm.xacro > arm.urdf" in str(problem)


def test_so_does_a_scene_in_memory() -> None:
    files = {"scene.toml": b'[scene]\nmodel = "arm.urdf"', "arm.urdf": XACRO.format(BOX + "<xacro:arm/>").encode()}
    with pytest.raises(SceneError, match=r"expand it first: xacro arm\.urdf > arm_expanded\.urdf, and name that file"):
        Scene.from_bundle(files)


def test_a_description_that_was_expanded_may_still_name_xacro(tmp_path: Path) -> None:
    joint = '<joint name="j" type="fixed"><parent link="r"/><child link="a"/></joint>'
    assert loaded(tmp_path, "arm.urdf", XACRO.format(f'<link name="r"/>{BOX}{joint}').encode()).bodies == ("a",)


HEAD = '<body name="head" pos="0 0 .6"><joint name="pan" axis="0 0 1" range="-90 90"/><geom size=".06"/></body>'
MASSLESS = {
    "nothing": f'<body name="base">{HEAD}</body>',
    "only a look": f'<body name="base"><geom size=".1" mass="0" contype="0" conaffinity="0"/>{HEAD}</body>',
    "no density": f'<body name="base"><geom size=".1" density="0"/>{HEAD}</body>',
    "links on the way": f'<body name="base"><body name="a"><body name="b">{HEAD}</body></body></body>',
}


@pytest.mark.parametrize("body", MASSLESS.values(), ids=MASSLESS)
def test_a_robot_whose_root_has_no_mass_is_fit(body: str, tmp_path: Path) -> None:
    (tmp_path / "robot.xml").write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    (tmp_path / "robot.toml").write_text(PROFILE.format(model="robot.xml"))
    check = check_body(str(tmp_path / "robot.toml"))
    assert check.problems == ()
    assert check.scene is not None
    again = Scene.from_bundle(check.scene.bundle)
    np.testing.assert_array_equal(again.model.body_mass, check.scene.model.body_mass)


def test_what_has_no_mass_may_move_in_a_room(tmp_path: Path) -> None:
    text = '<mujoco><worldbody><body name="cup"><freejoint/><geom size=".05" mass="0"/></body></worldbody></mujoco>'
    assert loaded(tmp_path, "room.xml", text.encode()).objects == ("cup",)


IMPOSSIBLE = """<mujoco><worldbody><body name="cup"><freejoint/><geom size=".05"/>
<inertial pos="0 0 0" mass="1" diaginertia="1 1 9"/></body></worldbody></mujoco>"""


def test_an_inertia_that_no_body_has_stops_no_room(tmp_path: Path) -> None:
    assert loaded(tmp_path, "room.xml", IMPOSSIBLE.encode()).objects == ("cup",)


def urdf_of(*shapes: str) -> bytes:
    """A room with one link, which has these shapes."""
    visuals = "".join(f'<visual name="v"><geometry>{shape}</geometry></visual>' for shape in shapes)
    link = f'<link name="a">{visuals}</link>'
    joint = '<joint name="j" type="fixed"><parent link="r"/><child link="a"/></joint>'
    return f'<robot name="r"><link name="r"/>{link}{joint}</robot>'.encode()


def test_boards_and_discs_of_a_urdf_may_have_no_thickness(tmp_path: Path) -> None:
    content = urdf_of('<box size="2 3 0"/>', '<cylinder radius="0.5" length="0.0"/>', '<sphere radius="0"/>')
    scene = loaded(tmp_path, "room.urdf", content)
    sizes = scene.model.geom_size[scene.geoms_of("a")]
    np.testing.assert_allclose(sizes, [(1, 1.5, 0.0005), (0.5, 0.0005, 0)])


def test_names_that_repeat_are_no_words_on_the_terminal(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    scene = loaded(tmp_path, "room.urdf", urdf_of('<box size="1 1 1"/>', '<box size="2 2 2"/>'))
    assert len(scene.geoms_of("a")) == 2
    assert capfd.readouterr() == ("", "")


def test_what_mujoco_merely_mentions_is_no_warning(tmp_path: Path, recwarn: pytest.WarningsRecorder) -> None:
    text = '<mujoco><compiler settotalmass="3"/><worldbody><body name="a"><geom size="1"/></body></worldbody></mujoco>'
    assert loaded(tmp_path, "room.xml", text.encode()).bodies == ("a",)
    assert not recwarn.list


def test_a_declaration_may_follow_empty_lines(tmp_path: Path) -> None:
    content = b'\n\n<?xml version="1.0"?>\n' + urdf_of('<box size="1 1 1"/>')
    assert loaded(tmp_path, "room.urdf", content).bodies == ("a",)
    with pytest.raises(SceneError, match="line 5"):
        loaded(tmp_path, "room.urdf", content.replace(b'<link name="a">', b'\n<link name="a" x="&#9;">'))
