"""Rooms of several models, keyframes, bodies that are freed, and robots that stand in the room's model.

The laws: what MuJoCo says of a room alone holds in the scene; each model of a room lies where its table puts it; a
robot in the room's model is the same agent as one with a model of its own.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from taskgist.errors import InputError
from taskgist.recording import Recording, read, write
from taskgist.world import Scene, Stage, State
from taskgist.world.fit import alone
from taskgist.world.scene_file import AgentEntry
from tests.world.test_profiles import MODEL, PROFILE
from tools.fuzz_rooms import Mesh, dae, obj, prism, stl

FLOOR = "<geom name='floor' type='plane' size='5 5 0.1'/>"
DOOR = "<body name='door' pos='2 0 1'><joint axis='0 0 1' range='-90 90'/><geom type='box' size='0.02 0.4 1'/></body>"
CUP = "<body name='cup' pos='0.1 0.2 0.8'>{}<geom type='cylinder' size='0.04 0.05'/></body>"
SLIDE = "<joint type='slide' axis='1 0 0' name='x'/>"
SLIDES = SLIDE + "<joint type='slide' axis='0 1 0'/><joint type='slide' axis='0 0 1'/>"
HINGES = "<joint axis='1 0 0'/><joint axis='0 1 0'/><joint axis='0 0 1'/>"
BALL = "<joint type='ball'/>"
CONTROLS = (
    "<actuator><motor joint='x'/></actuator><sensor><jointpos joint='x'/></sensor>"
    "<equality><joint joint1='x'/></equality><tendon><fixed name='t'><joint joint='x' coef='1'/></fixed></tendon>"
)


def room(*bodies: str, rest: str = "") -> str:
    return f"<mujoco><worldbody>{FLOOR}{''.join(bodies)}</worldbody>{rest}</mujoco>"


def loaded(folder: Path, toml: str, **files: str) -> Scene:
    for name, text in files.items():
        (folder / name.replace("__", ".")).write_text(text)
    (folder / "scene.toml").write_text(toml)
    scene = Scene.load(folder / "scene.toml")
    again = Scene.from_bundle(dict(scene.bundle))
    assert again.objects == scene.objects
    np.testing.assert_array_equal(again.initial.qpos, scene.initial.qpos)
    assert again.bundle == scene.bundle
    return scene


def poses(model: mujoco.MjModel, qpos: np.ndarray | None = None, key: int | None = None) -> dict[str, np.ndarray]:
    """Position and orientation of every body that has a name, (12,)."""
    data = mujoco.MjData(model)
    if key is not None:
        mujoco.mj_resetDataKeyframe(model, data, key)
    if qpos is not None:
        data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    return {
        str(model.body(b).name): np.concatenate((data.xpos[b], data.xmat[b]))
        for b in range(model.nbody)
        if model.body(b).name
    }


def same_poses(found: dict[str, np.ndarray], expected: dict[str, np.ndarray]) -> None:
    for name, pose in expected.items():
        assert found[name] == pytest.approx(pose, abs=2e-5), name


# --- Keyframes.

KEYED = room(
    DOOR,
    CUP.format("<freejoint/>"),
    f"<body name='box' pos='0.5 0 1'>{SLIDES}{BALL}<geom type='box' size='0.1 0.05 0.05'/></body>",
    "<body name='tag' mocap='true' pos='0 1 1'><geom size='0.02'/></body>",
    rest="<keyframe><key name='shut'/><key name='open' qpos='0.7  1 2 3 0 1 0 0  0.1 0.2 0.3 0.6 0.8 0 0'"
    " mpos='3 2 1' mquat='0 0 1 0'/></keyframe>" + CONTROLS,
)


@pytest.mark.parametrize(("key", "index"), [("shut", 0), ("open", 1)])
def test_what_a_keyframe_says_holds_in_the_scene(tmp_path: Path, key: str, index: int) -> None:
    agent = "[agents.P1]\nposition_m = [-2, 0]"
    scene = loaded(tmp_path, f'[scene]\nmodel = "room.xml"\nkeyframe = "{key}"\n{agent}', room__xml=KEYED)
    assert scene.objects == ("cup", "box", "tag")
    expected = poses(mujoco.MjModel.from_xml_string(KEYED), key=index)
    same_poses(poses(scene.model, scene.initial.qpos), expected)
    assert scene.initial.qpos[scene.object_slice("tag")][:3] == pytest.approx(expected["tag"][:3])


def test_without_a_keyframe_all_is_as_the_bodies_are(tmp_path: Path) -> None:
    scene = loaded(tmp_path, '[scene]\nmodel = "room.xml"', room__xml=KEYED)
    same_poses(poses(scene.model, scene.initial.qpos), poses(mujoco.MjModel.from_xml_string(KEYED)))


def test_the_lid_of_what_is_freed_stands_as_the_keyframe_says(tmp_path: Path) -> None:
    lid = "<body name='lid'><joint name='hinge' axis='0 1 0'/><geom size='0.02'/></body>"
    box = f"<body name='box'>{SLIDES}<geom size='0.1'/>{lid}</body>"
    text = room(box, rest="<keyframe><key name='open' qpos='1 2 3 0.5'/></keyframe>")
    scene = loaded(tmp_path, '[scene]\nmodel = "room.xml"\nkeyframe = "open"\nobjects = ["box"]', room__xml=text)
    assert scene.initial.qpos == pytest.approx((1, 2, 3, 1, 0, 0, 0, 0.5))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (KEYED, r"scene\.keyframe: no keyframe 'opem'; did you mean 'open'\? \(known: open, shut\)"),
        (room(DOOR), r"scene\.keyframe: the room's model has no keyframes \(got 'opem'\)"),
        (room(DOOR, rest="<keyframe><key qpos='1'/></keyframe>"), "no keyframe that has a name"),
    ],
)
def test_a_keyframe_that_is_not_there_is_named(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        loaded(tmp_path, '[scene]\nmodel = "room.xml"\nkeyframe = "opem"', room__xml=text)


# --- Bodies that become objects.


@pytest.mark.parametrize("joints", [SLIDES + BALL, SLIDES + HINGES, SLIDES, SLIDE, ""])
@pytest.mark.parametrize("named", [True, False])
def test_bodies_become_objects_if_they_move_all_ways_or_are_named(tmp_path: Path, joints: str, named: bool) -> None:
    text = room(DOOR, CUP.format(joints), rest=CONTROLS if joints else "")
    objects = 'objects = ["cup"]' if named else ""
    scene = loaded(tmp_path, f'[scene]\nmodel = "room.xml"\n{objects}', room__xml=text)
    all_ways = joints.endswith((BALL, HINGES))
    assert scene.objects == (("cup",) if named or all_ways else ())
    same_poses(poses(scene.model, scene.initial.qpos), poses(mujoco.MjModel.from_xml_string(text)))
    if named:
        moved = scene.initial.replace(at=scene.object_slice("cup"), to=(3, 2, 1, 0, 0, 0, 1))
        assert poses(scene.model, moved.qpos)["cup"][:3] == pytest.approx((3, 2, 1))
        assert scene.geoms_of("cup").tolist() == [scene.model.body("cup").geomadr[0]]


def test_a_mocap_body_that_touches_nothing_is_an_object_only_if_it_is_named(tmp_path: Path) -> None:
    text = room("<body name='handle' mocap='true'><geom size='0.1' contype='0' conaffinity='0'/></body>")
    assert loaded(tmp_path, '[scene]\nmodel = "room.xml"', room__xml=text).objects == ()
    assert loaded(tmp_path, '[scene]\nmodel = "room.xml"\nobjects = ["handle"]', room__xml=text).objects == ("handle",)


def test_in_recordings_from_before_mocap_bodies_stay_what_they_were() -> None:
    bundle = {"scene.toml": b'[scene]\nmodel = "room.xml"', "room.xml": KEYED.encode()}
    assert Scene.from_bundle(bundle).objects == ("cup",)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (
            "<body name='shelf'><geom size='0.1'/><body name='cup'><geom size='0.1'/></body></body>",
            "is part of 'shelf'",
        ),
        ("<body name='cup'><geom size='0.1' mass='0'/></body>", r"an object without mass \(got 'cup'\); give one of"),
    ],
)
def test_what_cannot_be_an_object_is_refused(tmp_path: Path, body: str, message: str) -> None:
    with pytest.raises(InputError, match=rf"scene\.objects: {message}"):
        loaded(tmp_path, '[scene]\nmodel = "room.xml"\nobjects = ["cup"]', room__xml=room(body))


def test_links_of_a_urdf_room_are_objects_if_they_are_named(tmp_path: Path) -> None:
    kinds = ("floating", "fixed", "planar", "prismatic")
    links = "".join(
        f"<link name='{kind}'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>"
        f"<joint name='j_{kind}' type='{kind}'><origin xyz='{x} 0 1'/><parent link='floor'/><child link='{kind}'/>"
        "<axis xyz='0 0 1'/><limit lower='0' upper='1' effort='1' velocity='1'/></joint>"
        for x, kind in enumerate(kinds)
    )
    urdf, toml = f"<robot name='r'><link name='floor'/>{links}</robot>", '[scene]\nmodel = "room.urdf"\n'
    assert loaded(tmp_path, toml, room__urdf=urdf).objects == ("floating",)
    scene = loaded(tmp_path, f"{toml}objects = {list(kinds)}", room__urdf=urdf)
    assert scene.objects == kinds
    assert [scene.initial.qpos[scene.object_slice(kind)][0] for kind in kinds] == pytest.approx([0, 1, 2, 3])
    assert scene.nq == 7 * len(kinds)


# --- Rooms of several models.

TETRAHEDRON = "v 0 0 0\nv {0} 0 0\nv 0 {0} 0\nv 0 0 {0}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
MUG = """<robot name="mug"><link name="base">
<inertial><mass value="0.3"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><mesh filename="m.obj"/></geometry></visual></link>
<link name="handle"><visual><origin xyz="0.1 0 0"/><geometry><box size="0.02 0.02 0.1"/></geometry></visual></link>
<joint name="j" type="fixed"><parent link="base"/><child link="handle"/></joint></robot>"""
SHELF = room(
    "<body name='side' pos='0 0.4 0.5'><geom name='g' type='box' size='0.2 0.02 0.5'/></body>",
    "<body name='drawer' pos='0 0 0.5'><joint type='slide' axis='1 0 0' range='0 0.3' name='pull'/>"
    "<geom type='box' size='0.2 0.3 0.05'/></body>",
    "<body name='loose' pos='0 0 0.8'><freejoint/><geom size='0.05'/></body>",
    rest="<actuator><motor joint='pull'/></actuator><keyframe><key qpos='0.1 0 0 0.8 1 0 0 0'/></keyframe>",
).replace(FLOOR, "<geom type='box' size='0.2 0.4 0.02'/>")
BOX = room(
    "<body name='object' pos='0 0 0.05'><joint type='slide'/><geom type='box' size='0.1 0.1 0.05'/>"
    "<body name='lid' pos='-0.1 0 0.05'><joint name='hinge' axis='0 -1 0' range='0 90'/>"
    "<geom type='box' size='0.1 0.1 0.005' pos='0.1 0 0.005'/></body></body>"
).replace(FLOOR, "")
KITCHEN = """[scene]
name = "kitchen"
[furniture.shelf]
model = "shelf.xml"
position_m = [1, 0.5, 0]
yaw_deg = 90
[objects.mug]
model = "mug.urdf"
position_m = [0.4, 0.1, 0.8]
[objects.other]
model = "mug.urdf"
position_m = [0.4, 0.4, 0.8]
rpy_deg = [0, 90, 0]
[objects.box]
model = "box.xml"
position_m = [0, 0.6, 0.8]
yaw_deg = 180
[objects.stone]
mesh = "m.obj"
scale = 0.5
mass_kg = 0.7
[agents.P1]
position_m = [-1, 0]
"""


def kitchen(folder: Path, toml: str = KITCHEN) -> Scene:
    (folder / "m.obj").write_text(TETRAHEDRON.format(0.1))
    return loaded(folder, toml, shelf__xml=SHELF, mug__urdf=MUG, box__xml=BOX)


def test_a_room_of_several_models_is_the_room_of_their_bodies(tmp_path: Path) -> None:
    scene = kitchen(tmp_path)
    assert scene.objects == ("mug", "other", "box", "stone")
    assert scene.bodies == ("box", "mug", "other", "shelf", "stone")
    at = poses(scene.model, scene.initial.qpos)
    assert {name for name in at if name.startswith("shelf")} == {"shelf", "shelf/side", "shelf/drawer", "shelf/loose"}
    assert at["shelf/side"][:3] == pytest.approx((1 - 0.4, 0.5, 0.5)), "a quarter to the left"
    assert at["box"][:3] == pytest.approx((0, 0.6, 0.85)), "the model's origin is put there, not its body"
    assert at["other"][3:].reshape(3, 3) @ (0, 0, 1) == pytest.approx((1, 0, 0))
    assert scene.columns[:1] == ("shelf/pull",)
    assert len(scene.inner_joints("box")) == 1
    assert len(scene.geoms_of("mug")) == 2
    assert scene.owners.count("shelf") == 4
    assert scene.model.body("stone").mass[0] == pytest.approx(0.7)
    assert 0.5 * scene.model.geom_rbound[scene.geoms_of("mug")[0]] == pytest.approx(
        scene.model.geom_rbound[scene.geoms_of("stone")[0]]
    )
    assert sum(name.endswith(".obj") for name in scene.bundle) == 1, "one file serves them all"


def test_meshes_of_one_name_are_not_taken_for_each_other(tmp_path: Path) -> None:
    for folder, size in (("a", 0.1), ("b", 0.2)):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "m.obj").write_text(TETRAHEDRON.format(size))
    toml = "".join(f'[objects.{name}]\nmesh = "{name}/m.obj"\n' for name in "ab")
    scene = loaded(tmp_path, toml)
    volumes = [float(scene.model.body(name).mass[0]) for name in "ab"]
    assert volumes[1] == pytest.approx(8 * volumes[0])


@pytest.mark.parametrize(("suffix", "write_mesh"), [("obj", obj), ("stl", stl), ("dae", dae)])
def test_an_object_is_a_mesh_of_any_kind(tmp_path: Path, suffix: str, write_mesh: Callable[[Mesh], bytes]) -> None:
    (tmp_path / f"a nut.{suffix}").write_bytes(write_mesh(prism()))
    table = f'[objects.nut]\nmesh = "a nut.{suffix}"\nscale = 2\nposition_m = [1, 0, 0]\n'
    scene = loaded(tmp_path, f"{table}[agents.P1]\n")
    (geom,), model = scene.geoms_of("nut"), scene.model
    start = model.mesh_vertadr[model.geom_dataid[geom]]
    corners = model.mesh_vert[start : start + model.mesh_vertnum[model.geom_dataid[geom]]]
    extent = np.ptp(Stage(scene).geom(geom).to_world(corners), axis=0)
    hexagon = 2 * 0.08 * np.cos(np.radians(30)), 2 * 0.08, 2 * 0.1
    assert sorted(extent) == pytest.approx(hexagon, abs=1e-5), "twice as large as in its file"
    assert scene.initial.qpos[scene.object_slice("nut")][:3] == pytest.approx((1, 0, 0))


def test_objects_of_the_room_and_of_models_are_objects_together(tmp_path: Path) -> None:
    bodies = room(CUP.format("<freejoint/>"), CUP.format("<freejoint/>").replace("cup", "pot"))
    toml = KITCHEN.replace('name = "kitchen"', 'model = "room.xml"\nobjects = ["cup"]')
    (tmp_path / "room.xml").write_text(bodies)
    scene = kitchen(tmp_path, toml)
    assert scene.objects == ("cup", "mug", "other", "box", "stone")
    joined, state = scene.joined_by(AgentEntry("P2", position_m=(2.0, 0.0)))
    assert joined.objects == scene.objects
    before = poses(scene.model, scene.initial.qpos)
    same_poses(poses(joined.model, state.qpos), before)


def test_a_recording_holds_all_of_it(tmp_path: Path) -> None:
    scene = kitchen(tmp_path)
    qpos = np.tile(scene.initial.qpos, (3, 1))
    path = tmp_path / "r.mcap"
    write(Recording(scene=scene, times_s=np.arange(3.0), qpos=qpos), path)
    for name in ("m.obj", "shelf.xml", "mug.urdf", "box.xml"):
        (tmp_path / name).unlink()
    found = read(path)
    assert found.scene.objects == scene.objects
    same_poses(poses(found.scene.model, found.at(1.0).qpos), poses(scene.model, scene.initial.qpos))
    text, files = found.scene.mjcf()
    assert mujoco.MjModel.from_xml_string(text, files).nq == scene.nq


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("[objects.mug]", "[objects.shelf]", r"objects\.shelf: is the name of furniture\.shelf, too"),
        ("[agents.P1]", "[agents.mug]", r"agents\.mug: is the name of"),
        ("[objects.mug]", '[objects."a/b"]', "not a name for an object; leave out the slash"),
        ("[objects.mug]", "[furniture.mug]\nscale = 1", r"no field 'scale' \(known: model, position_m"),
        ("yaw_deg = 90", "yaw_deg = 90\nrpy_deg = [0, 0, 1]", r"furniture\.shelf\.rpy_deg: is turned twice"),
        ("scale = 0.5", 'model = "mug.urdf"', "has a mesh and a model"),
        ("scale = 0.5", "scale = 0", r"objects\.stone\.scale: is out of range"),
        ("yaw_deg = 180", "mass_kg = 1", r"objects\.box\.mass_kg: is for a mesh"),
        ('"box.xml"', '"boxes.xml"', r"objects\.box: no such file"),
        ('"box.xml"', '"shelf.xml"', r"one top-level body, 'shelf.xml' has side, drawer, loose, shapes of the world"),
        (
            'name = "kitchen"',
            'model = "mug.object.xml"',
            r"scene\.model: is what a recording calls the model of something",
        ),
        ('name = "kitchen"', 'objects = ["mog"]', r"no object \(a body of the model\) 'mog'; did you mean 'mug'"),
    ],
)
def test_what_is_wrong_with_a_model_is_told(tmp_path: Path, right: str, wrong: str, message: str) -> None:
    assert right in KITCHEN
    with pytest.raises(InputError, match=message):
        kitchen(tmp_path, KITCHEN.replace(right, wrong))


def test_a_name_of_the_rooms_model_is_not_given_twice(tmp_path: Path) -> None:
    (tmp_path / "room.xml").write_text(room(DOOR.replace("door", "mug")))
    with pytest.raises(InputError, match=r"objects: the model has something of that name \(got 'mug'\)"):
        kitchen(tmp_path, KITCHEN.replace('name = "kitchen"', 'model = "room.xml"'))


def test_an_object_in_millimetres_names_its_table(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"objects\.stone 'm\.obj': the box around 'stone' is .* in millimetres"):
        kitchen(tmp_path, KITCHEN.replace("scale = 0.5", "scale = 1000"))


# --- Robots that stand in the room's model.

CRANE = MODEL[MODEL.index("<body name=") : MODEL.rindex("</worldbody>")]
PLACED = CRANE.replace('pos="0 0 7"', 'pos="1 2 0.5" euler="0 0 30"', 1)
SPEAKS = (
    "<equality><weld body1='fore' body2='cup'/><joint joint1='pan' joint2='shoulder'/></equality>"
    "<actuator><motor joint='elbow'/></actuator><sensor><framepos objtype='body' objname='grip'/></sensor>"
    "<tendon><fixed name='t'><joint joint='pan' coef='1'/></fixed></tendon>"
    "<contact><exclude body1='grip' body2='cup'/></contact>"
    "<keyframe><key name='k' qpos='0 0 0 0.1 0.2 0.3 0.4 0.8 1 0 0 0'/></keyframe>"
)
IN_ROOM = room(
    DOOR,
    PLACED,
    CUP.format("<freejoint/>"),
    "<camera name='c' mode='targetbody' target='grip'/><body name='post'><geom size='0.1'/></body>",
    rest=SPEAKS,
)
STANDS = '[scene]\nmodel = "room.xml"\n{}[agents.C]\nprofile = "crane.toml"\nroom_body = "base"\n{}'


def with_robot(folder: Path, scene_extra: str = "", extra: str = "", text: str = IN_ROOM) -> Scene:
    return loaded(folder, STANDS.format(scene_extra, extra), crane__toml=PROFILE, room__xml=text)


def test_a_robot_in_the_rooms_model_is_the_agent_that_it_would_be_beside_it(tmp_path: Path) -> None:
    scene = with_robot(tmp_path)
    toml = '[scene]\nmodel = "room.xml"\n[agents.C]\nprofile = "crane.toml"\nposition_m = [1, 2]\nyaw_deg = 30\n'
    apart = room(DOOR, CUP.format("<freejoint/>"), "<body name='post'><geom size='0.1'/></body>")
    beside = loaded(tmp_path, toml, crane__xml=MODEL, room__xml=apart)
    assert scene.columns == beside.columns
    assert scene.owners == beside.owners
    assert scene.bodies == ("cup", "door", "post")
    same_poses(poses(scene.model, scene.initial.qpos), poses(beside.model, beside.initial.qpos))
    joints = [str(scene.model.joint(int(each)).name) for each in scene.model.eq_obj1id]
    assert joints == ["C/pan"], "what couples its own joints goes with it, what holds it to others does not"


def test_its_names_may_have_a_prefix_in_the_room(tmp_path: Path) -> None:
    named = re.sub(r'name="(\w+)"', r'name="r0:\1"', PLACED)
    couples = "<equality><joint joint1='r0:pan' joint2='r0:shoulder'/></equality>"
    contacts = "<contact><exclude body1='r0:fore' body2='r0:base'/><pair geom1='r0:lens' geom2='floor'/></contact>"
    toml = STANDS.format("", 'room_prefix = "r0:"').replace('"base"', '"r0:base"')
    scene = loaded(tmp_path, toml, crane__toml=PROFILE, room__xml=room(named, rest=couples + contacts))
    plain = with_robot(tmp_path)
    assert scene.joints("C") == plain.joints("C")
    there = poses(plain.model, plain.initial.qpos)
    same_poses(
        poses(scene.model, scene.initial.qpos), {name: pose for name, pose in there.items() if name.startswith("C/")}
    )
    assert [str(scene.model.joint(int(each)).name) for each in scene.model.eq_obj1id] == ["C/pan"]
    with pytest.raises(InputError, match=r"agents\.P1\.room_prefix: is of names in the room's model \(got 'r0:'\)"):
        loaded(tmp_path, '[scene]\nmodel = "room.xml"\n[agents.P1]\nroom_prefix = "r0:"', room__xml=IN_ROOM)


def test_it_stands_where_the_scene_says_if_it_says_so(tmp_path: Path) -> None:
    scene = with_robot(tmp_path, extra="position_m = [-1, 0]\nyaw_deg = 90\njoints_m = { lift = 0.3 }")
    assert scene.initial.qpos[scene.base_slice("C")] == pytest.approx((-1, 0, 0.5, *np.sqrt((0.5, 0, 0, 0.5))))
    assert scene.initial.qpos[scene.agent("C").joints["lift"]] == pytest.approx(0.3)


def test_a_keyframe_puts_the_things_around_it(tmp_path: Path) -> None:
    scene = with_robot(tmp_path, 'keyframe = "k"\n')
    assert scene.initial.qpos[scene.object_slice("cup")][:3] == pytest.approx((0.3, 0.4, 0.8))
    assert scene.initial.qpos[scene.base_slice("C")][:3] == pytest.approx((1, 2, 0.5))


def test_a_robot_from_the_room_is_fitted_alone(tmp_path: Path) -> None:
    scene = with_robot(tmp_path)
    own = alone(scene, "C")
    state = State(own.qpos(scene.initial.qpos))
    everywhere = poses(scene.model, scene.initial.qpos)
    same_poses(
        {name: pose for name, pose in everywhere.items() if name.startswith("C/")},
        {name: pose for name, pose in poses(own.model, state.qpos).items() if name.startswith("C/")},
    )


def test_bodies_are_left_out_with_all_that_speaks_of_them(tmp_path: Path) -> None:
    toml = '[scene]\nmodel = "room.xml"\nleave_out = ["base", "door"]\n'
    scene = loaded(tmp_path, toml, room__xml=IN_ROOM)
    assert scene.bodies == ("cup", "post")
    assert scene.columns == tuple(f"cup.{part}" for part in ("x", "y", "z", "qw", "qx", "qy", "qz"))


@pytest.mark.parametrize(
    ("scene_extra", "extra", "message"),
    [
        ('leave_out = ["based"]\n', "", r"scene\.leave_out: no body 'based'; did you mean 'base'"),
        ('leave_out = ["grip"]\n', "", r"is part of what agents\.C\.room_body takes out of the room \(got 'grip'\)"),
        ('objects = ["post"]\nleave_out = ["post"]\n', "", r"objects: is what scene\.leave_out takes \(got 'post'\)"),
        ('leave_out = ["post", "post"]\n', "", r"scene\.leave_out: .*name it once"),
        (
            "",
            "[agents.D]\nprofile = 'crane.toml'\nroom_body = 'fore'",
            r"D\.room_body: is part of what agents\.C",
        ),
        ("", "[agents.post]\nprofile = 'human'", "the model has something of that name"),
    ],
)
def test_what_cannot_be_taken_out_is_told(tmp_path: Path, scene_extra: str, extra: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        with_robot(tmp_path, scene_extra, extra)


def test_who_comes_in_is_no_body_of_the_room(tmp_path: Path) -> None:
    scene = with_robot(tmp_path)
    with pytest.raises(InputError, match="who comes in is no body of the room"):
        scene.joined_by(AgentEntry("D", room_body="post"))
