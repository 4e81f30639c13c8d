"""What a profile leaves to its model: cameras as eyes, hands measured on their fingers, bodies without an eye."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest

from taskgist.errors import SceneError
from taskgist.perspective.effort import ABILITIES
from taskgist.perspective.image import view_of, visibility
from taskgist.perspective.search import least_effort
from taskgist.world import Scene, Stage
from taskgist.world.bodies.fingers import Plain, Unclear, measured_hand
from taskgist.world.bodies.model_files import add_model, find_file, read_model
from taskgist.world.body_check import BODY, BodyCheck, check_body
from tests.bodies import needs

FINGERS = """<body name="left_finger" pos="0.06 0.005 0"><joint name="left" type="slide" axis="0 1 0" range="0 0.04"/>
 <geom type="box" size="0.03 0.005 0.01" pos="0.03 0.005 0"/></body>
<body name="right_finger" pos="0.06 -0.005 0"><joint name="right" type="slide" axis="0 -1 0" range="0 0.04"/>
 <geom type="box" size="0.03 0.005 0.01" pos="0.03 -0.005 0"/></body>"""
HINGED = """<body name="left_finger" pos="0.06 0.03 0"><joint name="left" axis="0 0 1" range="0 0.5"/>
 <geom type="box" size="0.03 0.005 0.01" pos="0.03 0 0"/></body>
<body name="right_finger" pos="0.06 -0.03 0"><joint name="right" axis="0 0 -1" range="0 0.5"/>
 <geom type="box" size="0.03 0.005 0.01" pos="0.03 0 0"/></body>"""
JAW = """<geom type="box" size="0.03 0.005 0.01" pos="0.09 -0.03 0"/>
<body name="jaw" pos="0.06 -0.02 0"><joint name="jaw" type="slide" axis="0 1 0" range="0 0.06"/>
 <geom type="box" size="0.03 0.005 0.01" pos="0.03 0 0"/></body>"""
THREE = """<body name="thumb" pos="0.06 -0.005 0"><joint name="thumb" type="slide" axis="0 -1 0" range="0 0.05"/>
 <geom type="box" size="0.03 0.006 0.01" pos="0.03 -0.006 0"/></body>
<body name="first" pos="0.06 0.005 0.03"><joint name="first" type="slide" axis="0 1 0" range="0 0.04"/>
 <geom type="box" size="0.03 0.006 0.01" pos="0.03 0.006 0"/></body>
<body name="second" pos="0.06 0.005 -0.03"><joint name="second" type="slide" axis="0 1 0" range="0 0.04"/>
 <geom type="box" size="0.03 0.006 0.01" pos="0.03 0.006 0"/></body>"""
MODEL = """<mujoco><compiler angle="radian" autolimits="true"/><worldbody><body name="base">
<geom type="cylinder" size="0.1 0.5" pos="0 0 0.5"/>
<body name="head" pos="0 0 1.1"><joint name="pan" axis="0 0 1" range="-1 1"/><geom size="0.05"/>
 <camera name="head_cam" pos="0.06 0 0.02" xyaxes="0 -1 0 0 0 1" fovy="45" resolution="160 120"/>
 <camera name="plain_cam" pos="0.06 0 0" xyaxes="0 -1 0 0 0 1"/>
 <camera name="flat_cam" pos="0.06 0 0" xyaxes="0 -1 0 0 0 1" projection="orthographic" resolution="8 8"/></body>
<camera name="chase" mode="trackcom" pos="-2 0 1" resolution="8 8"/>
<body name="wheel" pos="-0.2 0 0.1"><joint name="roll" axis="0 1 0" range="-1 1"/><geom size="0.05"/></body>
<body name="upper" pos="0 -0.2 0.9"><joint name="shoulder" axis="0 1 0" range="-1.5 1.5"/>
 <geom type="capsule" size="0.03" fromto="0 0 0 0.4 0 0"/>
 <body name="grip" pos="0.4 0 0"><joint name="wrist" axis="1 0 0" range="-1.5 1.5"/>
  <geom type="box" size="0.03 0.04 0.02" pos="0.03 0 0"/>FINGERS</body></body></body>
<camera name="wall_cam" pos="3 0 2" resolution="8 8"/></worldbody></mujoco>"""
PROFILE = """name = "crane"
model = "crane.xml"
[eye]
camera = "head_cam"
[head]
pan = { joint = "pan" }
[[arms]]
side = "right"
shoulder = "upper"
hand = "grip"
palm = { frame = "grip", offset_m = [0.11, 0, 0] }
root = "upper"
azimuth_deg = [-60, 120]
elevation_deg = [-90, 80]
[hand]
"""


def checked(folder: Path, profile: str = PROFILE, fingers: str = FINGERS) -> BodyCheck:
    (folder / "crane.xml").write_text(MODEL.replace("FINGERS", fingers))
    (folder / "crane.toml").write_text(profile)
    return check_body(str(folder / "crane.toml"))


def body_of(result: BodyCheck) -> Scene:
    assert result.problems == ()
    assert result.scene is not None
    return result.scene


# --- Cameras.


def test_a_camera_is_an_eye_that_looks_where_the_camera_does(tmp_path: Path) -> None:
    result = checked(tmp_path)
    scene = body_of(result)
    eye, profile = Stage(scene).eye(scene.agent(BODY)), scene.agent(BODY).profile.eye
    assert eye.position == pytest.approx((0.06, 0.0, 1.12))
    assert eye.matrix == pytest.approx(np.eye(3), abs=1e-9), "x ahead, z up"
    assert (profile.image_px, profile.exclude) == ((160, 120), "head")
    across, up = profile.fov_rad
    assert up == pytest.approx(math.radians(45))
    assert math.tan(across / 2) == pytest.approx(160 / 120 * math.tan(up / 2))
    assert profile.gaze_cone_rad == pytest.approx(math.atan(math.hypot(math.tan(across / 2), math.tan(up / 2))))
    assert any("eye.camera 'head_cam' of the body 'head': 57.8° by 45.0°" in line for line in result.derived)
    assert result.doubts == ()


def test_pixels_of_the_eye_are_those_that_mujoco_projects_there(tmp_path: Path) -> None:
    """A point at the edge of the camera's image is at the edge of the eye's."""
    scene = body_of(checked(tmp_path))
    agent, model = scene.agent(BODY), scene.model
    data = mujoco.MjData(model)
    data.qpos[:] = scene.initial.qpos
    mujoco.mj_forward(model, data)
    camera = model.camera(f"{BODY}/head_cam").id
    at, turn = data.cam_xpos[camera], data.cam_xmat[camera].reshape(3, 3)
    half_up = math.tan(math.radians(float(model.cam_fovy[camera])) / 2)
    corner = at + turn @ np.array([half_up * 160 / 120, half_up, -1.0])  # right and top: x right, y up, looks along -z
    x, y, z = Stage(scene).eye(agent).to_local(corner)
    across, up = agent.profile.eye.fov_rad
    assert (-y / x, z / x) == pytest.approx((math.tan(across / 2), math.tan(up / 2)))


def test_what_the_profile_gives_wins_over_the_camera(tmp_path: Path) -> None:
    given = 'camera = "plain_cam"\nfov_deg = [80, 60]\nimage_px = [64, 48]\nexclude = ["head", "base"]'
    eye = body_of(checked(tmp_path, PROFILE.replace('camera = "head_cam"', given))).agent(BODY).profile.eye
    assert eye.fov_rad == pytest.approx((math.radians(80), math.radians(60)))
    assert (eye.image_px, eye.exclude, eye.housing) == ((64, 48), "head", ("base",))
    only_px = PROFILE.replace('camera = "head_cam"', 'camera = "plain_cam"\nimage_px = [64, 64]')
    assert body_of(checked(tmp_path, only_px)).agent(BODY).profile.eye.fov_rad == pytest.approx([math.radians(45)] * 2)


def test_a_sensor_with_a_focal_length_tells_the_field_of_view(tmp_path: Path) -> None:
    lens = 'focal="0.004 0.004" sensorsize="0.006 0.004" resolution="60 40"'
    model = MODEL.replace('fovy="45" resolution="160 120"', lens)
    (tmp_path / "crane.xml").write_text(model.replace("FINGERS", FINGERS))
    (tmp_path / "crane.toml").write_text(PROFILE)
    eye = body_of(check_body(str(tmp_path / "crane.toml"))).agent(BODY).profile.eye
    assert eye.fov_rad == pytest.approx((2 * math.atan(0.75), 2 * math.atan(0.5)), abs=1e-6)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ('camera = "head_cma"', "eye.camera: no camera 'head_cma'; did you mean 'head_cam'?"),
        ('camera = "plain_cam"', "eye.camera: the camera says nothing of its image"),
        ('camera = "chase"', "eye.camera: a camera that is not fixed to the body"),
        ('camera = "wall_cam"', "eye.camera: a camera that is not fixed to the body"),
        ('camera = "flat_cam"', "eye.camera: an eye is a pinhole"),
        ('camera = "head_cam"\nframe = "head"', "eye.frame: an eye is a camera, or a frame"),
        ('camera = "head_cam"\noptical = true', "eye.optical: an eye is a camera, or a frame"),
        ("camera = 3", "eye.camera: must be a text"),
        ('camera = "head_cam"\nimage = [1, 1]', "no field 'image'; did you mean 'image_px'"),
    ],
)
def test_cameras_that_are_no_eye_are_refused(tmp_path: Path, line: str, message: str) -> None:
    problems = checked(tmp_path, PROFILE.replace('camera = "head_cam"', line)).problems
    assert message in "\n".join(map(str, problems))


def test_a_model_without_cameras_asks_for_a_frame(tmp_path: Path) -> None:
    (tmp_path / "crane.urdf").write_text('<robot name="r"><link name="base"/></robot>')
    (tmp_path / "crane.toml").write_text('name = "r"\nmodel = "crane.urdf"\n[eye]\ncamera = "head_cam"\n')
    said = "\n".join(map(str, check_body(str(tmp_path / "crane.toml")).problems))
    assert "the model has no cameras (got 'head_cam'); name a link of the robot instead" in said


# --- Hands.


@pytest.mark.parametrize(
    ("fingers", "kind", "opening_m", "rest"),
    [
        (FINGERS, "parallel", 0.09, {"finger_thickness_m": 0.01, "finger_width_m": 0.02}),
        (HINGED, "parallel", None, {"finger_width_m": 0.02}),
        (JAW, "parallel", 0.06, {"finger_thickness_m": 0.01, "finger_width_m": 0.02}),
        (THREE, "three_finger", 0.10, {"spread_m": 0.06, "finger_thickness_m": 0.012, "finger_width_m": 0.02}),
    ],
)
def test_plain_fingers_tell_kind_and_sizes(
    tmp_path: Path, fingers: str, kind: str, opening_m: float | None, rest: dict[str, float]
) -> None:
    result = checked(tmp_path, fingers=fingers)
    hand = body_of(result).agent(BODY).profile.hand
    assert hand is not None
    assert hand.kind == kind
    if opening_m is not None:
        assert hand.opening_m == pytest.approx(opening_m, abs=1e-4)
        assert hand.finger_length_m == pytest.approx(0.06, abs=1e-4)
        assert hand.palm_m == pytest.approx((0.04, 0.06), abs=1e-4)
    else:  # inner faces 0.05 m apart at the hinges, wider towards the tips
        assert 0.05 + 2 * 0.04 * math.sin(0.5) < hand.opening_m < 0.05 + 2 * 0.06 * math.sin(0.5) + 0.01
    for field, value in rest.items():
        assert getattr(hand, field) == pytest.approx(value, abs=1e-4), field
    (told,) = [line for line in result.derived if line.startswith("hand")]
    assert f"measured on grip: kind {kind}, opening_m {hand.opening_m:.3f}" in told


def test_what_the_profile_gives_of_a_hand_wins(tmp_path: Path) -> None:
    result = checked(tmp_path, f"{PROFILE}opening_m = 0.07\ntip_m = 0.003\n")
    hand = body_of(result).agent(BODY).profile.hand
    assert hand is not None
    assert (hand.kind, hand.opening_m, hand.tip_m) == ("parallel", 0.07, 0.003)
    assert "opening_m" not in "\n".join(result.derived)
    contrary = checked(tmp_path, f"{PROFILE}finger_thickness_m = 0.2\n").problems
    assert "hand.finger_thickness_m: a hand has no such fingers (got 0.2)" in str(contrary[0])


@pytest.mark.parametrize(
    ("fingers", "why"),
    [("", "nothing in it moves"), (FINGERS + HINGED.replace("_finger", "").replace('"left"', '"l"'), "fingers of it")],
)
def test_what_is_not_plain_is_asked_for_by_name(tmp_path: Path, fingers: str, why: str) -> None:
    fingers = fingers.replace('joint name="right"', 'joint name="r"', 1) if fingers else ""
    (problem,) = checked(tmp_path, fingers=fingers).problems
    text = str(problem)
    assert "hand.kind: the model does not tell kind, opening_m, finger_length_m, finger_thickness_m, palm_m" in text
    assert why in text
    sizes = "opening_m = 0.08\nfinger_length_m = 0.06\nfinger_thickness_m = 0.01\npalm_m = [0.06, 0.05]\n"
    hand = body_of(checked(tmp_path, PROFILE + sizes, fingers)).agent(BODY).profile.hand
    assert hand is not None
    assert hand.kind == "human", "as ever where nothing is said, and nothing is plain"


def test_hands_are_measured_alike_however_the_arm_is_turned(tmp_path: Path) -> None:
    """A rigid motion of the hand changes no size."""
    sizes = []
    for turn in ("0 0 0", "0.3 -0.7 1.9"):
        model = MODEL.replace('name="grip" pos="0.4 0 0"', f'name="grip" pos="0.4 0 0" euler="{turn}"')
        (tmp_path / "crane.xml").write_text(model.replace("FINGERS", HINGED))
        compiled = mujoco.MjModel.from_xml_path(str(tmp_path / "crane.xml"))
        found = measured_hand(compiled, compiled.body("grip").id)
        assert isinstance(found, Plain)
        sizes.append([found.fields[key] for key in ("opening_m", "finger_length_m", "finger_thickness_m")])
        assert found.palm == pytest.approx((found.palm[0], 0.0, 0.0), abs=1e-6)
    assert sizes[0] == pytest.approx(sizes[1], abs=1e-4)


PUBLISHED = [
    ("panda_description/urdf/panda.urdf", "panda_hand", "parallel", 0.080),  # Franka: 80 mm
    ("pr2_description/urdf/pr2.urdf", "l_gripper_palm_link", "parallel", 0.090),  # Willow Garage: 90 mm (manual: 86)
]


@needs("pr2")
@pytest.mark.parametrize(("urdf", "hand", "kind", "opening_m"), PUBLISHED)
def test_measured_hands_open_as_far_as_their_makers_say(urdf: str, hand: str, kind: str, opening_m: float) -> None:
    files: dict[str, bytes] = {}
    path = find_file(f"package://example-robot-data/robots/{urdf}", near=None, where="test", field="model")
    add_model(path, "model.xml", files)
    spec = read_model(files, "model.xml", where="test", room=False)
    spec.assets = {name: data for name, data in files.items() if not name.endswith(".xml")}
    spec.compiler.balanceinertia = True
    model = spec.compile()
    found = measured_hand(model, int(model.body(hand).id))
    assert isinstance(found, Plain)
    assert found.fields["kind"] == kind
    assert found.fields["opening_m"] == pytest.approx(opening_m, abs=0.003)
    assert 0.03 < found.fields["finger_length_m"] < 0.08
    assert 0.01 < found.fields["finger_thickness_m"] < 0.03


def test_a_linkage_of_two_branches_is_one_finger() -> None:
    """As Robotiq's: an inner knuckle beside each outer one, which carries the finger."""
    half = """<body name="{0}_outer" pos="0.03 {1}0.03 0"><joint name="{0}" axis="0 0 {1}1" range="-0.6 0"/>
      <geom type="box" size="0.02 0.004 0.01" pos="0.02 {1}0.01 0"/>
      <geom type="box" size="0.02 0.004 0.01" pos="0.06 {1}0.0165 0"/></body>
    <body name="{0}_inner" pos="0.035 {1}0.012 0"><joint name="{0}_knuckle" axis="0 0 {1}1" range="-0.6 0"/>
      <geom type="box" size="0.012 0.003 0.008" pos="0.012 {1}0.01 0"/></body>"""
    hand = f'<body name="hand"><geom type="box" size="0.03 0.04 0.03"/>{half.format("l", "")}{half.format("r", "-")}'
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian" autolimits="true"/><worldbody>{hand}</body></worldbody></mujoco>'
    )
    found = measured_hand(model, 1)
    assert isinstance(found, Plain)
    assert found.fields["opening_m"] == pytest.approx(2 * (0.03 + 0.0165 - 0.004), abs=1e-4)


def test_a_hand_of_five_fingers_is_not_plain() -> None:
    finger = '<body pos="0.1 {0} 0"><joint axis="0 0 1" range="0 1"/><geom type="box" size="0.03 0.005 0.005"/></body>'
    hand = "".join(finger.format(0.02 * number) for number in range(5))
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler autolimits="true"/><worldbody><body><geom size="0.05"/>{hand}</body></worldbody></mujoco>'
    )
    assert measured_hand(model, 1) == Unclear("5 fingers of it move")


# --- No eye.

BLIND = PROFILE.replace('[eye]\ncamera = "head_cam"\n', "")


def room_with(folder: Path, profile: str) -> Scene:
    checked(folder, profile)
    cup = '<body name="cup" pos="0.5 -0.2 0.9"><freejoint/><geom type="cylinder" size="0.03 0.05"/></body>'
    floor = '<geom type="plane" size="5 5 1"/>'
    (folder / "room.xml").write_text(f"<mujoco><worldbody>{floor}{cup}</worldbody></mujoco>")
    (folder / "scene.toml").write_text('[scene]\nmodel = "room.xml"\n[agents.C]\nprofile = "crane.toml"\n')
    return Scene.load(folder / "scene.toml")


def test_what_a_body_without_an_eye_sees_is_unknown_and_it_reaches_all_the_same(tmp_path: Path) -> None:
    blind, seeing = room_with(tmp_path, BLIND), room_with(tmp_path, PROFILE)
    for ability in ABILITIES:
        one, other = (least_effort(Stage(scene), "C", "cup", ability).level for scene in (blind, seeing))
        assert other in (0, 1)
        assert one == (None if ability == "see" else other)
    why = least_effort(Stage(blind), "C", "cup", "see").evidence.reason
    assert "C has no eye" in str(why)
    assert visibility(Stage(blind), "C", "cup") is None
    with pytest.raises(SceneError, match="agent C: has no eye: what it sees is unknown; name one in its profile"):
        view_of(Stage(blind), "C")


def test_a_body_without_an_eye_is_fit_and_told_of(tmp_path: Path) -> None:
    result = checked(tmp_path, BLIND.replace("[head]\npan", "[torso]\nturn").replace('"pan"', '"shoulder"'))
    scene = body_of(result)
    assert "no eye: what it sees is unknown" in result.lacks
    assert "head" not in scene.agent(BODY).parts


# --- Joints that carry nothing of what they are for.


@pytest.mark.parametrize(
    ("table", "doubt"),
    [
        (
            "lean = { joint = 'roll' }",
            "torso.lean: the joint 'roll' carries neither the eye nor a shoulder; it carries wheel",
        ),
        ("turn = { joint = 'roll' }", "torso.turn: the joint 'roll' carries neither the eye nor a shoulder"),
    ],
)
def test_a_torso_joint_that_carries_neither_eye_nor_shoulder_is_doubted(tmp_path: Path, table: str, doubt: str) -> None:
    result = checked(tmp_path, PROFILE.replace("[[arms]]", f"[torso]\n{table}\n[[arms]]"))
    assert doubt in "\n".join(result.doubts)
    carries_the_eye = PROFILE.replace("[head]\npan = {", "[torso]\nturn = {")
    assert checked(tmp_path, carries_the_eye).doubts == ()


def test_a_head_joint_that_leaves_the_eye_where_it_is_says_what_it_carries(tmp_path: Path) -> None:
    result = checked(tmp_path, PROFILE.replace('joint = "pan"', 'joint = "wrist"'))
    said = "\n".join(result.doubts)
    assert "head.pan: the joint 'wrist' does not move the eye; it carries grip, left_finger, right_finger" in said


def test_fingers_that_are_closed_loops_are_measured_as_the_model_has_them() -> None:
    """No joint of a loop moves alone; of two branches that are tied to each other, one finger is made."""
    half = """<body name="{0}_driver" pos="0.03 {1}0.03 0"><joint name="{0}" axis="0 0 {1}1" range="-0.8 0"/>
      <geom type="box" size="0.02 0.004 0.01" pos="0.02 {1}0.01 0"/></body>
    <body name="{0}_spring" pos="0.035 {1}0.012 0"><joint name="{0}_spring" axis="0 0 {1}1" range="-0.8 0.8"/>
      <geom type="box" size="0.02 0.003 0.008" pos="0.02 {1}0.02 0"/>
      <body name="{0}_pad" pos="0.05 {1}0.025 0"><joint name="{0}_pad" axis="0 0 1" range="-1 1"/>
        <geom type="box" size="0.02 0.004 0.011" pos="0.02 {1}0.005 0"/></body></body>"""
    ties = "".join(f'<connect body1="{side}_driver" body2="{side}_pad" anchor="0.05 0.02 0"/>' for side in "lr")
    hand = f'<body name="hand"><geom type="box" size="0.03 0.04 0.03"/>{half.format("l", "")}{half.format("r", "-")}'
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian" autolimits="true"/><worldbody>{hand}</body></worldbody>'
        f"<equality>{ties}</equality></mujoco>"
    )
    found = measured_hand(model, 1)
    assert isinstance(found, Plain)
    assert found.fields["kind"] == "parallel"
    assert found.fields["opening_m"] == pytest.approx(2 * (0.012 + 0.025 + 0.005 - 0.004), abs=1e-4)
    assert found.fields["finger_width_m"] == pytest.approx(0.022, abs=1e-4)
