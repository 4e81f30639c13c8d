"""Profiles: what they leave out is derived, and every mistake is named."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from taskgist.errors import InputError, SceneError, UnknownNameError
from taskgist.world import AgentProfile, Scene, Stage, builtin_profiles
from taskgist.world.bodies.eyes import Frame
from taskgist.world.bodies.profile import builtin_profile_text, examine_profile, parse_profile
from taskgist.world.body_check import BODY, check_body
from tests.bodies import needs

MODEL = """<mujoco><compiler angle="degree" autolimits="true"/><worldbody><body name="base" pos="0 0 7">
<geom type="box" size="0.2 0.2 0.5"/>
<body name="column" pos="0 0 0.5"><joint name="lift" type="slide" axis="0 0 1" range="0.1 0.3"/>
 <geom type="box" size="0.05 0.05 0.2" pos="0 0 0.2"/>
 <body name="camera" pos="0.1 0 0.4" euler="0 90 0"><joint name="pan" axis="-1 0 0" range="-50 50"/>
  <geom name="lens" size="0.03"/></body>
 <body name="upper" pos="0 -0.2 0.3"><joint name="shoulder" axis="0 1 0" range="-90 90"/>
  <geom type="capsule" size="0.03" fromto="0 0 0 0.4 0 0"/>
  <body name="fore" pos="0.4 0 0"><joint name="elbow" axis="0 0 1" range="10 150"/>
   <geom type="capsule" size="0.03" fromto="0 0 0 0.3 0 0"/>
   <body name="grip" pos="0.3 0 0"><geom size="0.04" pos="0.05 0 0"/></body></body></body></body>
</body></worldbody></mujoco>"""

PROFILE = """name = "crane"
model = "crane.xml"
[eye]
frame = "camera"
rpy_deg = [0, -90, 0]
offset_m = [0, 0, 0.04]
exclude = "camera"
fov_deg = [60, 40]
image_px = [160, 120]
[head]
pan = { joint = "pan" }
[base]
moves = true
[rest_m]
lift = 0.2
[rest_deg]
elbow = 60
[[arms]]
side = "right"
shoulder = { frame = "column", offset_m = [0, -0.2, 0.3] }
hand = "grip"
palm = { frame = "grip", offset_m = [0.1, 0, 0] }
root = "upper"
azimuth_deg = [-60, 120]
elevation_deg = [-90, 80]
[hand]
kind = "parallel"
opening_m = 0.08
finger_length_m = 0.05
finger_thickness_m = 0.02
palm_m = [0.06, 0.05]
"""


def written(folder: Path, profile: str = PROFILE, model: str = MODEL) -> Path:
    (folder / "crane.xml").write_text(model)
    (folder / "crane.toml").write_text(profile)
    (folder / "room.xml").write_text("<mujoco><worldbody><geom type='plane' size='5 5 1'/></worldbody></mujoco>")
    (folder / "scene.toml").write_text('[scene]\nmodel = "room.xml"\n[agents.C]\nprofile = "crane.toml"\n')
    return folder / "scene.toml"


def test_a_body_is_added_with_one_toml(tmp_path: Path) -> None:
    scene = Scene.load(written(tmp_path))
    stage, agent = Stage(scene), scene.agent("C")
    assert stage.state.qpos[agent.base][:3] == pytest.approx((0, 0, 0.5)), "its lowest shape stands on the floor"
    eye = stage.eye(agent)
    assert eye.matrix == pytest.approx(np.eye(3), abs=1e-9)
    assert eye.position == pytest.approx((0.1 + 0.04, 0, 0.5 + 0.5 + 0.2 + 0.4))
    assert agent.profile.pan is not None
    assert agent.profile.pan.range_rad == pytest.approx((math.radians(-50), math.radians(50)))
    assert agent.profile.eye.gaze_cone_rad == pytest.approx(
        math.atan(math.hypot(math.tan(math.radians(30)), math.tan(math.radians(20)))), abs=1e-6
    ), "a robot attends to all of its image"
    assert {part: len(bodies) for part, bodies in agent.parts.items()} == {"right_arm": 3, "head": 1, "torso": 2}


def test_the_length_of_an_arm_is_how_far_its_joints_let_it_stretch(tmp_path: Path) -> None:
    arm = Scene.load(written(tmp_path)).agent("C").arms[0]
    bent = math.sqrt(0.4**2 + 0.4**2 + 2 * 0.4 * 0.4 * math.cos(math.radians(10)))
    assert arm.profile.length_m == pytest.approx(bent, abs=1e-6), "the elbow never opens wholly"
    straight = Scene.load(written(tmp_path, model=MODEL.replace('range="10 150"', 'range="-20 150"')))
    assert straight.agent("C").arms[0].profile.length_m == pytest.approx(0.8, abs=1e-6)
    given = Scene.load(written(tmp_path, PROFILE.replace('root = "upper"', 'root = "upper"\nlength_m = 0.7')))
    assert given.agent("C").arms[0].profile.length_m == 0.7


def test_an_optical_frame_looks_along_z() -> None:
    text = PROFILE.replace("rpy_deg = [0, -90, 0]", "optical = true").replace("offset_m = [0, 0, 0.04]\n", "")
    frame = parse_profile(text, where="x").eye.frame
    w, x, y, z = frame.wxyz
    assert (w, x, y, z) == pytest.approx((0.5, 0.5, -0.5, 0.5)) or (w, x, y, z) == pytest.approx(
        (-0.5, -0.5, 0.5, -0.5)
    )
    assert frame.name == "camera"
    assert not frame.is_plain
    assert Frame("camera").is_plain


def test_joints_turn_or_slide_as_the_scene_says(tmp_path: Path) -> None:
    path = written(tmp_path)
    path.write_text(path.read_text() + "joints_m = { lift = 0.3 }\njoints_deg = { elbow = 90 }\n")
    scene = Scene.load(path)
    agent = scene.agent("C")
    assert scene.initial.qpos[agent.joints["lift"]] == pytest.approx(0.3)
    assert scene.initial.qpos[agent.joints["elbow"]] == pytest.approx(math.pi / 2)
    for line, message in {
        "joints_deg = { lift = 3 }": r"joints_deg\.lift: not a joint that turns.*joints_m for those that slide",
        "joints_m = { elbow = 0.1 }": r"joints_m\.elbow: not a joint that slides",
        "joints_m = { lift = 2 }": r"joints_m\.lift: beyond the joint \(got 2\.0\); it slides from 0\.1 to 0\.3 metres",
        "joints_m = { lfit = 0.2 }": "no joint 'lfit'; did you mean 'lift'",
        "body = { stature_m = 1.5 }": r"agents\.C\.body: the body of 'crane' is as it is",
    }.items():
        path = written(tmp_path)
        path.write_text(path.read_text() + line + "\n")
        with pytest.raises((SceneError, UnknownNameError), match=message):
            Scene.load(path)


MISTAKES = {
    'frame = "camera"': ('frame = "camra"', r"eye\.frame: no site or body 'camra'; did you mean 'camera'"),
    'exclude = "camera"': ('exclude = "cam"', r"eye\.exclude: no body 'cam'"),
    'pan = { joint = "pan" }': ('tilt = { joint = "pann" }', r"head\.tilt: no joint 'pann'; did you mean 'pan'"),
    'hand = "grip"': ('hand = "grp"', r"arms\.right\.hand: no body 'grp'; did you mean 'grip'"),
    'palm = { frame = "grip"': ('palm = { frame = "gripp"', r"arms\.right\.palm: no site or body 'gripp'"),
    'root = "upper"': ('root = "uper"', r"arms\.right\.root: no body 'uper'; did you mean 'upper'"),
    "elbow = 60": ("elbo = 60", r"rest_deg: no joint 'elbo'; did you mean 'elbow'"),
    "lift = 0.2": ("elbow = 0.2\nlifft = 0.1", r"rest_m: no joint 'lifft'; did you mean 'lift'"),
}


@pytest.mark.parametrize("right", MISTAKES)
def test_a_name_that_the_model_does_not_have_leads_to_the_one_that_was_meant(tmp_path: Path, right: str) -> None:
    wrong, message = MISTAKES[right]
    assert right in PROFILE
    with pytest.raises(UnknownNameError, match=message) as caught:
        Scene.load(written(tmp_path, PROFILE.replace(right, wrong)))
    assert str(tmp_path / "crane.toml") in str(caught.value)


def test_every_mistake_is_named_not_only_the_first(tmp_path: Path) -> None:
    text = PROFILE
    for right, (wrong, _) in MISTAKES.items():
        text = text.replace(right, wrong)
    written(tmp_path, text)
    result = check_body(str(tmp_path / "crane.toml"))
    said = "\n".join(map(str, result.problems))
    assert result.scene is None
    assert len(result.problems) >= len(MISTAKES)
    for wrong, _ in MISTAKES.values():
        assert wrong.rpartition("= ")[2].split()[0].strip('"{}') in said or "lifft" in said


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("image_px = [160, 120]", "image_px = [0, 0]", r"eye\.image_px: an image needs at least one pixel each way"),
        ("fov_deg = [60, 40]", "fov_deg = [60, 180]", r"eye\.fov_deg: a pinhole sees between 0 and 180"),
        ("fov_deg = [60, 40]", "fov_deg = [60, 40]\ngaze_cone_deg = 0", r"gaze_cone_deg: .*half-angle between 0"),
        ("fov_deg = [60, 40]", "fov = [60, 40]", r"eye.*no field 'fov'; did you mean 'fov_deg'"),
        ("offset_m = [0, 0, 0.04]", "offset_m = [0, 0]", r"eye\.offset_m: must be three finite numbers"),
        ("exclude = ", "# exclude = ", r"eye\.exclude: is missing"),
        ("azimuth_deg = [-60, 120]", "azimuth_deg = [120, -60]", r"azimuth_deg: a range is from its low"),
        ('side = "right"', 'side = "rigth"', r"arms: no side 'rigth'; did you mean 'right'"),
        ('root = "upper"', 'root = "upper"\nlength_m = 0', r"length_m: no arm is that long"),
        ("[head]", "[haed]", "no field 'haed'; did you mean 'head'"),
        ("moves = true", "moves = 1", r"base\.moves: must be true or false"),
        ("moves = true", 'moves = true\n[posture]\ncan = ["sitting"]', r"posture\.hips: whoever sits has legs"),
        ('model = "crane.xml"', 'model = "crane.xml"\nshapes = "visible"', "no kind of shapes 'visible'"),
        ('pan = { joint = "pan" }', 'pan = { joint = "lift" }', r"head\.pan: a joint that slides \(got 'lift'\)"),
    ],
)
def test_fields_that_cannot_be_are_refused(tmp_path: Path, right: str, wrong: str, message: str) -> None:
    assert right in PROFILE
    with pytest.raises((SceneError, UnknownNameError), match=message) as caught:
        Scene.load(written(tmp_path, PROFILE.replace(right, wrong)))
    assert ".toml" in str(caught.value)


def test_all_fields_are_read_before_any_is_complained_of() -> None:
    text = PROFILE.replace("[160, 120]", "[0, 1]").replace("moves = true", "moves = 3").replace("[-90, 80]", "[80]")
    _, problems = examine_profile(text, where="crane.toml")
    assert len(problems) == 3
    with pytest.raises(InputError) as caught:
        parse_profile(text, where="crane.toml")
    assert str(caught.value) == str(problems[0])


def test_what_was_read_before_is_read_the_same_and_each_fault_is_told_of_its_own_file(tmp_path: Path) -> None:
    assert parse_profile(PROFILE, where="one.toml") == parse_profile(PROFILE, where="other.toml")
    faulty = PROFILE.replace("moves = true", "moves = 3")
    for where in ("one.toml", "other.toml"):
        with pytest.raises(SceneError, match=where):
            parse_profile(faulty, where=where)
    one, other = Scene.load(written(tmp_path)), Scene.load(written(tmp_path))
    assert one.model is not other.model
    assert np.array_equal(one.model.geom_size, other.model.geom_size)
    for _ in range(2):
        with pytest.raises(SceneError, match="must be finite numbers"):
            Scene.load(written(tmp_path, model=MODEL.replace("0.2 0.2 0.5", "nan 0.2 0.5")))


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        (
            '<body name="base" pos="0 0 7">',
            '<body name="a"><geom size="0.1"/></body><body name="base">',
            "has 2: a, base",
        ),
        (
            '<geom name="lens" size="0.03"/>',
            '<geom name="lens" size="0"/>',
            r"sphere 'lens' of body 'camera': a shape of no",
        ),
        ('<geom type="box" size="0.2 0.2 0.5"/>', '<joint name="turn"/><geom size="1"/>', r"has a free joint, or none"),
        (
            '<geom name="lens" size="0.03"/>',
            '<geom size="0.03"/><body name="lid"><joint/><geom size="0.01"/></body>',
            r"a joint without a name \(got 'body lid'\); name it",
        ),
    ],
)
def test_models_that_are_no_body_are_refused(tmp_path: Path, right: str, wrong: str, message: str) -> None:
    assert right in MODEL
    with pytest.raises(SceneError, match=message):
        Scene.load(written(tmp_path, model=MODEL.replace(right, wrong)))


@pytest.mark.parametrize(
    ("geom", "named"),
    [
        (
            "<geom name='rim' type='box' size='0.1 0 0.1'/>",
            r"box 'rim' of body 'cup': a shape of no size .*0\.1, 0\.0, 0\.1",
        ),
        ("<geom size='0'/>", "sphere without a name of body 'cup'"),
        ("<geom type='cylinder' size='0.1 -1'/>", "cylinder without a name of body 'cup'"),
    ],
)
def test_shapes_of_no_size_are_named(tmp_path: Path, geom: str, named: str) -> None:
    path = written(tmp_path)
    room = f"<mujoco><worldbody><body name='cup'><freejoint/>{geom}</body></worldbody></mujoco>"
    (tmp_path / "room.xml").write_text(room)
    with pytest.raises(SceneError, match=named):
        Scene.load(path)


def test_a_cameras_housing_is_taken_out_of_sight(tmp_path: Path) -> None:
    case = '<body name="case"><geom type="box" size="0.1 0.1 0.1"/></body>'
    model = MODEL.replace('<geom name="lens" size="0.03"/>', f'<geom name="lens" size="0.03"/>{case}')
    written(tmp_path, model=model)
    boxed = check_body(str(tmp_path / "crane.toml"))
    written(tmp_path, PROFILE.replace('exclude = "camera"', 'exclude = ["camera", "case"]'), model)
    free = check_body(str(tmp_path / "crane.toml"))
    rays = np.array([(1.0, 0.0, 0.0)])
    seen = []
    for result in (boxed, free):
        assert result.scene is not None
        stage, agent = Stage(result.scene), result.scene.agent(BODY)
        seen.append(int(stage.cast(stage.eye(agent).position, rays, exclude_body=agent.eye_exclude_body)[0][0]))
    assert seen[0] >= 0
    assert seen[1] < 0


def test_the_profile_of_a_recording_made_before_frames_is_still_read() -> None:
    assert 'site = "eye"' in builtin_profile_text("human") or "frame" in builtin_profile_text("human")
    old = PROFILE.replace('frame = "camera"\nrpy_deg = [0, -90, 0]\noffset_m = [0, 0, 0.04]', 'site = "camera"')
    assert parse_profile(old, where="x").eye.frame == Frame("camera")


@pytest.mark.parametrize("name", [pytest.param(n, marks=needs(n)) for n in builtin_profiles()])
def test_built_in_profiles_are_fit_to_use(name: str) -> None:
    result = check_body(name)
    assert result.problems == ()
    assert isinstance(result.given, AgentProfile)
    assert result.scene is not None
    assert [note for note in result.lacks if "wider" in note] == []


def test_mistakes_in_fields_hide_none_in_names(tmp_path: Path) -> None:
    """A list of everything is worked through once."""
    text = PROFILE
    wrongs = {
        'model = "crane.xml"': 'model = "crane.xml"\nshapes = "colision"',
        'frame = "camera"': 'frame = "kamera"',
        'exclude = "camera"': 'exclude = "lense"',
        "fov_deg = [60, 40]": "fov_deg = [200, 40]",
        "image_px = [160, 120]": "image_px = [0, 120]",
        'pan = { joint = "pan" }': 'pan = { joint = "pam", range_deg = [1, 0] }\ntilt = { joint = "lift" }',
        'root = "upper"': 'root = "uper"',
        "offset_m = [0.1, 0, 0]": "offset_m = [0.1, 0]",
        "azimuth_deg = [-60, 120]": "azimuth_deg = [120, -60]",
    }
    for right, wrong in wrongs.items():
        assert right in text
        text = text.replace(right, wrong, 1)
    written(tmp_path, text)
    said = [str(problem) for problem in check_body(str(tmp_path / "crane.toml")).problems]
    fields = ("shapes", "eye.frame", "eye.exclude", "eye.fov_deg", "eye.image_px", "head.pan.range_deg", "head.pan: no")
    for field in (*fields, "head.tilt", "arms.right.root", "arms.palm.offset_m", "arms.azimuth_deg"):
        assert sum(field in sentence for sentence in said) == 1, field
    assert len(said) == 11


@pytest.mark.parametrize(("key", "right"), [("hand", 'hand = "grip"'), ("palm", 'palm = { frame = "grip"')])
def test_a_hand_that_the_arm_does_not_carry_is_refused(tmp_path: Path, key: str, right: str) -> None:
    wrong = PROFILE.replace(right, right.replace("grip", "camera"))
    with pytest.raises(SceneError, match=rf"arms\.right\.{key}: the {key} is no part of the arm.*got 'camera'"):
        Scene.load(written(tmp_path, wrong))


@pytest.mark.parametrize(
    ("profile", "model", "doubt"),
    [
        (
            "rpy_deg = [0, -90, 0]|rpy_deg = [0, 0, 0]",
            "|",
            "eye.frame: 'camera' does not look ahead, but along (0.0, 0.0",
        ),
        ("rpy_deg = [0, -90, 0]|rpy_deg = [0, 0, -90]", "|", "it would with optical = true"),
        ("rpy_deg = [0, -90, 0]|rpy_deg = [90, -90, 0]", "|", "looks ahead with its z along"),
        (
            "|",
            'axis="-1 0 0" range="-50 50"|axis="0 1 0" range="-50 50"',
            "head.pan: pan turns to the side, but the axis",
        ),
        ('pan = { joint = "pan" }|tilt = { joint = "pan" }', "|", "head.tilt: tilt looks up and down, but the axis"),
        ('pan = { joint = "pan" }|pan = { joint = "elbow" }', "|", "the joint 'elbow' does not move the eye"),
    ],
)
def test_what_looks_or_turns_the_wrong_way_is_doubted(tmp_path: Path, profile: str, model: str, doubt: str) -> None:
    right, wrong = profile.split("|")
    straight, turned = model.split("|")
    assert right in PROFILE
    assert straight in MODEL
    scene_file = written(
        tmp_path,
        PROFILE.replace(right, wrong) if right else PROFILE,
        MODEL.replace(straight, turned) if turned else MODEL,
    )
    result = check_body(str(scene_file.with_name("crane.toml")))
    assert result.problems == ()
    assert doubt in "\n".join(result.doubts)


def test_what_is_right_is_not_doubted(tmp_path: Path) -> None:
    result = check_body(str(written(tmp_path).with_name("crane.toml")))
    assert result.doubts == ()


def test_a_range_wider_than_the_joint_is_cut_and_noted(tmp_path: Path) -> None:
    wide = PROFILE.replace('pan = { joint = "pan" }', 'pan = { joint = "pan", range_deg = [-90, 30] }')
    written(tmp_path, wide)
    result = check_body(str(tmp_path / "crane.toml"))
    assert result.scene is not None
    pan = result.scene.agent(BODY).profile.pan
    assert pan is not None
    assert pan.range_rad == pytest.approx((math.radians(-50), math.radians(30)))
    assert any("head.pan.range_deg is wider than the joint 'pan'" in note for note in result.lacks)


def test_robots_without_their_package_say_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.path", [])
    monkeypatch.setattr("sys.prefix", "/nowhere")
    monkeypatch.setenv("ROS_PACKAGE_PATH", "/nowhere/else")
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    (problem,) = check_body("pr2").problems
    assert "pip install 'taskgist[robots]'" in str(problem)
    assert "ROS_PACKAGE_PATH" in str(problem)
