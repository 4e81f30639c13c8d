"""Drafted profiles: what a model tells is in them with its reason, what it does not is open, and they hold."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from taskgist.errors import SceneError
from taskgist.world.body_check import BODY, check_body
from taskgist.world.drafting.draft import Draft, draft_profile
from taskgist.world.stage import Stage
from tests.bodies import URDFS, needs

FINGERS = """<body name="{0}_finger_1" pos="0.06 0.005 0">
   <joint name="{0}_f1" type="slide" axis="0 1 0" range="0 0.04"/>
   <geom type="box" size="0.03 0.005 0.01" pos="0.03 0.005 0"/></body>
  <body name="{0}_finger_2" pos="0.06 -0.005 0"><joint name="{0}_f2" type="slide" axis="0 -1 0" range="0 0.04"/>
   <geom type="box" size="0.03 0.005 0.01" pos="0.03 -0.005 0"/></body>"""
ARM = """<body name="{0}_upper" pos="{2} {1} 1.2"><joint name="{0}_1" axis="0 0 1" range="-2 2"/>
 <geom type="capsule" size="0.04" fromto="0 0 0 0.3 0 0"/>
 <body name="{0}_elbow" pos="0.3 0 0"><joint name="{0}_2" axis="0 1 0" range="-2 2"/>
 <geom type="capsule" size="0.04" fromto="0 0 0 0.25 0 0"/>
 <body name="{0}_wrist" pos="0.25 0 0"><joint name="{0}_3" axis="0 1 0" range="-2 2"/>
  <geom type="box" size="0.03 0.05 0.03" pos="0.03 0 0"/>{3}</body></body></body>"""
HEAD = """<body name="neck" pos="0 0 1.5"><joint name="yaw" axis="0 0 1" range="-1 1"/><geom size="0.04"/>
 <body name="head" pos="0 0 0.1"><joint name="nod" axis="0 1 0" range="-0.5 0.5"/><geom size="0.08"/>{}</body></body>"""
CAMERA = '<camera name="head_cam" pos="0.09 0 0" xyaxes="0 -1 0 0 0 1" fovy="50" resolution="320 240"/>'
WHEELS = "".join(
    f'<body name="w{x}{y}" pos="{x} {y} 0.1"><joint name="roll{x}{y}" axis="0 1 0"/>'
    '<geom type="cylinder" size="0.1 0.02" euler="1.5708 0 0"/></body>'
    for x in (-0.2, 0.2)
    for y in (-0.3, 0.3)
)


def robot(*parts: str, head: str = HEAD.format(CAMERA), torso: str = "") -> str:
    """A column that turns, with arms and a head on it."""
    return f"""<mujoco model="robot"><compiler angle="radian" autolimits="true"/><worldbody><body name="base">
<geom type="box" size="0.25 0.25 0.1" pos="0 0 0.2"/>{"".join(parts[1:])}
<body name="torso"><joint name="waist" axis="0 0 1" range="-1 1"/>{torso}
<geom type="box" size="0.1 0.1 0.4" pos="0 0 1"/>
{parts[0]}{head}</body></body></worldbody></mujoco>"""


def both(fingers: str = FINGERS) -> str:
    arms = (("left", 0.25), ("right", -0.25))
    return "".join(ARM.format(side, y, 0.0, fingers.format(side)) for side, y in arms)


def drafted(folder: Path, model: str, name: str = "robot.xml") -> tuple[Draft, dict[str, Any]]:
    (folder / name).write_text(model)
    draft = draft_profile(str(folder / name), named=name)
    (folder / "robot.toml").write_text(draft.text)
    return draft, tomllib.loads(draft.text)


def test_a_whole_robot_is_drafted_with_nothing_open_and_is_fit(tmp_path: Path) -> None:
    draft, profile = drafted(tmp_path, robot(both(), WHEELS))
    assert draft.open == ()
    assert profile["eye"] == {"camera": "head_cam"}
    assert profile["head"] == {"pan": {"joint": "yaw"}, "tilt": {"joint": "nod"}}
    assert profile["torso"] == {"turn": {"joint": "waist"}}
    assert profile["base"] == {"moves": True}
    assert [(arm["side"], arm["root"], arm["hand"]) for arm in profile["arms"]] == [
        ("left", "left_upper", "left_wrist"),
        ("right", "right_upper", "right_wrist"),
    ]
    assert profile["arms"][0]["palm"] == {"frame": "left_wrist", "offset_m": [0.11, 0, 0]}
    assert (profile["hand"]["kind"], profile["hand"]["opening_m"]) == ("parallel", 0.09)
    check = check_body(str(tmp_path / "robot.toml"))
    assert (check.problems, check.doubts) == ((), ())
    assert check.scene is not None
    assert Stage(check.scene).eye(check.scene.agent(BODY)).matrix == pytest.approx(np.eye(3), abs=1e-6)


def test_every_line_has_its_reason(tmp_path: Path) -> None:
    draft, _ = drafted(tmp_path, robot(both(), WHEELS))
    fields = [line for line in draft.text.splitlines() if " = " in line and not line.startswith(("name", "model", "#"))]
    assert fields
    for line in fields:
        assert len(line.partition("  # ")[2]) > 3, line


def test_two_mirrored_robots_are_drafted_alike(tmp_path: Path) -> None:
    """The order in which arms stand in the file changes nothing."""
    arms = [ARM.format(name, y, 0.0, FINGERS.format(name)) for name, y in (("a", 0.25), ("b", -0.25))]
    one = drafted(tmp_path, robot("".join(arms), WHEELS))[1]
    other = drafted(tmp_path, robot("".join(arms[::-1]), WHEELS))[1]
    assert one == other
    assert [(arm["side"], arm["root"]) for arm in one["arms"]] == [("left", "a_upper"), ("right", "b_upper")]


def test_what_names_say_of_sides_is_told_where_places_say_otherwise(tmp_path: Path) -> None:
    arms = "".join(ARM.format(side, y, 0.0, FINGERS.format(side)) for side, y in (("left", -0.25), ("right", 0.25)))
    draft, profile = drafted(tmp_path, robot(arms))
    assert {arm["side"]: arm["root"] for arm in profile["arms"]} == {"left": "left_upper", "right": "right_upper"}
    assert "does the model look along x?" in draft.text


def test_a_bench_arm_without_a_camera_has_no_eye_and_stays(tmp_path: Path) -> None:
    arm = ARM.format("only", 0.0, 0.0, FINGERS.format("only")).replace('pos="0.0 0.0 1.2"', 'pos="0 0 0.3"')
    model = f"""<mujoco><compiler angle="radian" autolimits="true"/><worldbody><body name="base">
    <geom type="cylinder" size="0.1 0.15" pos="0 0 0.15"/>{arm}</body></worldbody></mujoco>"""
    draft, profile = drafted(tmp_path, model)
    assert (draft.open, profile["name"]) == ((), "robot")
    assert "eye" not in profile
    assert "# no [eye]: no camera, optical frame, eye or head in the model" in draft.text
    assert profile["base"] == {"moves": False}
    (only,) = profile["arms"]
    assert (only["side"], only["root"]) == ("right", "only_upper")
    assert only["azimuth_deg"] == [-114, 114], "as its first joint turns"
    check = check_body(str(tmp_path / "robot.toml"))
    assert (check.problems, check.doubts) == ((), ())
    assert "no eye: what it sees is unknown" in check.lacks


@pytest.mark.parametrize(("axis", "sector"), [("0 0 1", [-60, 89]), ("0 0 -1", [-89, 60])])
def test_an_only_arm_reaches_about_as_its_first_joint_turns(axis: str, sector: list[int], tmp_path: Path) -> None:
    """It points ahead at zero, and turns from 1.57 to its right to 1.05 to its left; it is a right arm."""
    arm = ARM.format("only", 0.0, 0.0, FINGERS.format("only"))
    first = '<joint name="only_1" axis="0 0 1" range="-2 2"/>'
    assert first in arm
    arm = arm.replace(first, f'<joint name="only_1" axis="{axis}" range="-1.57 1.05"/>')
    (only,) = drafted(tmp_path, robot(arm))[1]["arms"]
    assert (only["side"], only["azimuth_deg"]) == ("right", sector)


def test_a_camera_on_a_hand_and_one_outside_are_no_eye(tmp_path: Path) -> None:
    outside = '<camera name="view" pos="2 0 1" xyaxes="0 1 0 0 0 1"/>'
    held = both().replace(
        '<geom type="box" size="0.03 0.05 0.03"', f'{CAMERA}<geom type="box" size="0.03 0.05 0.03"', 1
    )
    draft, profile = drafted(tmp_path, robot(held, head=HEAD.format(outside)))
    assert "head_cam (an arm carries it)" in draft.text
    assert "view (it looks at the robot from outside)" in draft.text
    assert profile["eye"]["frame"] == "head", "no camera is there: the head, by its name"
    assert [each.partition(":")[0] for each in draft.open] == ["eye.fov_deg"]


@pytest.mark.parametrize(
    ("euler", "fields"),
    [
        ("-1.5707963 0 -1.5707963", {"optical": True}),
        ("0 0 0", {}),
        ("0 0 1.5707963", {"rpy_deg": [0, 0, -90]}),
    ],
)
def test_a_frame_is_an_eye_that_looks_ahead(tmp_path: Path, euler: str, fields: dict[str, Any]) -> None:
    frame = f'<body name="camera_optical_frame" pos="0.09 0 0" euler="{euler}"/>'.replace("euler", "euler", 1)
    model = robot(both(), head=HEAD.format(frame)).replace('angle="radian"', 'angle="radian" eulerseq="XYZ"')
    draft, profile = drafted(tmp_path, model)
    assert profile["eye"]["frame"] == "camera_optical_frame"
    assert {key: profile["eye"][key] for key in ("optical", "rpy_deg") if key in profile["eye"]} == fields
    filled = draft.text.replace("# fov_deg = [60, 47]", "fov_deg = [60, 47]")
    (tmp_path / "robot.toml").write_text(filled)
    check = check_body(str(tmp_path / "robot.toml"))
    assert (check.problems, check.doubts) == ((), ())


def test_what_is_close_around_the_lens_is_taken_out_of_sight(tmp_path: Path) -> None:
    case = '<body name="case" pos="0.12 0 0"><geom type="box" size="0.01 0.05 0.05"/></body>'
    _, profile = drafted(tmp_path, robot(both(), head=HEAD.format(CAMERA + case)))
    assert profile["eye"]["exclude"] == ["head", "case"]


def test_a_joint_that_slides_above_the_arms_lifts_and_legs_stand(tmp_path: Path) -> None:
    lift = '<joint name="lift" type="slide" axis="0 0 1" range="0 0.3"/>'
    draft, _ = drafted(tmp_path, robot(both(), torso=lift))
    assert "# lifts the torso, without being named: lift" in draft.text
    leg = """<body name="{0}_thigh" pos="0 {1} 0.2"><joint name="{0}_hip" axis="0 1 0" range="-1 1"/>
      <geom type="capsule" size="0.05" fromto="0 0 0 0 0 -0.4"/>
      <body name="{0}_shank" pos="0 0 -0.4"><joint name="{0}_knee" axis="0 1 0" range="0 2"/>
       <geom type="capsule" size="0.05" fromto="0 0 0 0 0 -0.4"/>
       <body name="{0}_foot" pos="0 0 -0.4"><joint name="{0}_ankle" axis="0 1 0" range="-1 1"/>
        <geom type="box" size="0.1 0.05 0.03" pos="0.05 0 -0.05"/></body></body></body>"""
    _, profile = drafted(tmp_path, robot(both(), leg.format("left", 0.1), leg.format("right", -0.1)))
    assert profile["base"] == {"moves": True}
    assert profile["posture"] == {
        "can": ["standing"],
        "hips": ["left_hip", "right_hip"],
        "knees": ["left_knee", "right_knee"],
        "ankles": ["left_ankle", "right_ankle"],
    }
    check = check_body(str(tmp_path / "robot.toml"))
    assert (check.problems, check.doubts) == ((), ())


def test_a_hand_that_is_not_plain_is_left_open_and_the_rest_can_be_used(tmp_path: Path) -> None:
    five = "".join(
        f'<body name="{{0}}_f{n}" pos="0.06 {0.02 * n - 0.04} 0"><joint name="{{0}}_f{n}" axis="0 1 0" range="0 1"/>'
        '<geom type="capsule" size="0.008" fromto="0 0 0 0.06 0 0"/></body>'
        for n in range(5)
    )
    draft, profile = drafted(tmp_path, robot(both(five)))
    (question,) = draft.open
    assert question.startswith("hand: not plain (left_wrist: 5 fingers of it move; right_wrist: 5 fingers of it move)")
    assert "hand" not in profile
    check = check_body(str(tmp_path / "robot.toml"))
    assert check.problems == ()
    assert "no hand: it reaches, and grasps nothing" in check.lacks
    sizes = {"opening_m": 0.08, "finger_length_m": 0.06, "finger_thickness_m": 0.016, "palm_m": [0.1, 0.06]}
    text = draft.text.replace("# [hand]", "[hand]").replace("# kind", "kind")
    for field, value in sizes.items():
        text = text.replace(f"# {field} = ", f"{field} = {value}")
    (tmp_path / "robot.toml").write_text(text)
    assert check_body(str(tmp_path / "robot.toml")).problems == ()


def test_what_keeps_a_model_from_being_an_agent_is_open(tmp_path: Path) -> None:
    room = robot(both()).replace("</worldbody>", '<body name="table"><geom size="0.1"/></body></worldbody>')
    draft, _ = drafted(tmp_path, room)
    assert any(each.startswith("model: a model of an agent has one top-level body") for each in draft.open)
    assert "# open: model: a model of an agent" in draft.text
    nameless = robot(both()).replace(' name="nod"', "")
    assert any("a joint without a name (got 'body head')" in each for each in drafted(tmp_path, nameless)[0].open)


def test_a_third_arm_is_left_out_and_told_of(tmp_path: Path) -> None:
    third = ARM.format("middle", 0.0, 0.1, FINGERS.format("middle"))
    draft, profile = drafted(tmp_path, robot(both() + third))
    assert [arm["root"] for arm in profile["arms"]] == ["left_upper", "right_upper"]
    assert draft.open == ("arms: which of them? left out: middle_upper",)


def test_joints_rest_where_the_models_keyframe_has_them(tmp_path: Path) -> None:
    key = '<keyframe><key name="home" qpos="0 0.5 0 0 0 0 0 0 0 0 0 -0.25 0"/></keyframe></mujoco>'
    _, profile = drafted(tmp_path, robot(both()).replace("</mujoco>", key))
    assert profile["rest_deg"] == {"left_1": pytest.approx(28.648), "yaw": pytest.approx(-14.324)}


def test_names_of_strangers_break_no_line(tmp_path: Path) -> None:
    odd = robot(both()).replace("left_upper", "left &quot;upper&quot; # arm")
    draft, profile = drafted(tmp_path, odd)
    assert draft.open == ()
    assert profile["arms"][0]["root"] == 'left "upper" # arm'


def test_what_is_no_model_is_refused(tmp_path: Path) -> None:
    (tmp_path / "robot.xml").write_text("<nothing/>")
    with pytest.raises(SceneError, match=r"robot\.xml: nothing: not a model"):
        draft_profile(str(tmp_path / "robot.xml"))
    with pytest.raises(SceneError, match="no such file"):
        draft_profile(str(tmp_path / "rbot.xml"))


@needs("talos")
def test_the_draft_of_talos_names_what_its_own_profile_names() -> None:
    profile = tomllib.loads(draft_profile(URDFS["talos"]).text)
    assert profile["head"] == {"pan": {"joint": "head_2_joint"}, "tilt": {"joint": "head_1_joint"}}
    assert profile["torso"] == {"turn": {"joint": "torso_1_joint"}, "lean": {"joint": "torso_2_joint"}}
    assert profile["eye"]["fov_deg"] == [60, 46.8]
    assert profile["posture"]["knees"] == ["leg_left_4_joint", "leg_right_4_joint"]
    assert [(arm["side"], arm["root"], arm["hand"]) for arm in profile["arms"]] == [
        ("left", "arm_left_1_link", "gripper_left_base_link"),
        ("right", "arm_right_1_link", "gripper_right_base_link"),
    ]


@needs("pr2")
def test_the_draft_of_pr2_names_what_its_own_profile_names() -> None:
    draft = draft_profile(URDFS["pr2"])
    profile = tomllib.loads(draft.text)
    assert profile["head"] == {"pan": {"joint": "head_pan_joint"}, "tilt": {"joint": "head_tilt_joint"}}
    assert "torso" not in profile
    assert profile["base"] == {"moves": True}
    assert [(arm["shoulder"], arm["hand"], arm["palm"]) for arm in profile["arms"]] == [
        (f"{side}_shoulder_pan_link", f"{side}_gripper_palm_link", f"{side}_gripper_tool_frame") for side in "lr"
    ]
    assert [each.partition(":")[0] for each in draft.open] == ["eye.fov_deg"], "its URDF says nothing of lenses"


def test_a_body_without_arms_is_drafted_too(tmp_path: Path) -> None:
    draft, profile = drafted(tmp_path, robot("", WHEELS))
    assert draft.open == ()
    assert "# no [[arms]]: no hand, and no chain of five joints that turn" in draft.text
    assert (profile["base"], profile["eye"]) == ({"moves": True}, {"camera": "head_cam"})
    assert check_body(str(tmp_path / "robot.toml")).problems == ()


def test_joints_of_legs_that_turn_without_end_are_no_wheels_and_shoulders_no_fingers(tmp_path: Path) -> None:
    leg = """<body name="s{0}{1}" pos="{0} {1} 0.15"><joint name="a{0}{1}" axis="0 1 0"/>
      <geom type="capsule" size="0.02" fromto="0 0 0 0.05 0 -0.2"/>
      <body name="t{0}{1}" pos="0.05 0 -0.2"><joint name="b{0}{1}" axis="0 1 0"/>
       <geom type="capsule" size="0.02" fromto="0 0 0 -0.05 0 -0.2"/></body></body>"""
    legs = "".join(leg.format(x, y) for x in (-0.2, 0.2) for y in (-0.2, 0.2))
    draft, profile = drafted(tmp_path, robot("", legs))
    assert profile["base"] == {"moves": False}
    small = "".join(
        f'<body name="{side}_shoulder" pos="0 {y} 1.2"><joint name="{side}" axis="0 1 0" range="-1 1"/>'
        '<geom size="0.03"/></body>'
        for side, y in (("left", 0.1), ("right", -0.1))
    )
    bend = '<joint name="bend" axis="0 1 0" range="-1 1"/><joint name="roll" axis="1 0 0" range="-1 1"/>'
    draft, profile = drafted(tmp_path, robot(small, torso=bend))
    assert "arms" not in profile
    assert draft.open == ()
