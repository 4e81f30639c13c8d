"""Robots whose models slide and turn on the floor: these joints give way to a base that is free."""

from __future__ import annotations

from pathlib import Path

import mujoco
import pytest

from taskgist.world import Scene
from taskgist.world.bodies.bases import base_joints
from taskgist.world.body_check import check_body
from tests.world.test_composing import poses, same_poses
from tests.world.test_profiles import MODEL, written

X, Y, Z = (
    f"<joint name='base_{a}' type='slide' axis='{v}'/>" for a, v in zip("xyz", ("1 0 0", "0 1 0", "0 0 1"), strict=True)
)
YAW = "<joint name='base_yaw' type='hinge' axis='0 0 1'/>"
BALL, HINGES = "<joint name='b' type='ball'/>", YAW + "<joint name='r' axis='1 0 0'/><joint name='p' axis='0 1 0'/>"
BASE = '<body name="base" pos="0 0 7">'
SPEAKS = (
    "<actuator><velocity joint='base_x'/></actuator><equality><joint joint1='base_x'/></equality>"
    "<tendon><fixed name='t'><joint joint='base_x' coef='1'/></fixed></tendon><sensor><tendonpos tendon='t'/></sensor>"
)


def links(*joints: str) -> str:
    """Links without shapes, one below the other, each with its joints; the last carries the robot."""
    mass = "<inertial pos='0 0 0' mass='0.01' diaginertia='1e-3 1e-3 1e-3'/>"
    opened = "".join(f"<body name='link{i}'>{mass}{joint}" for i, joint in enumerate(joints))
    closed = "</body>" * len(joints)
    return MODEL.replace(BASE, f"{opened}<body name='base'>").replace("</worldbody>", f"{closed}</worldbody>")


@pytest.mark.parametrize("joints", [X + Y + YAW, YAW + Y + X, X + Y, X + Y + Z, X + Y + Z + BALL, X + Y + Z + HINGES])
def test_a_base_that_slides_is_a_free_one(tmp_path: Path, joints: str) -> None:
    plain = Scene.load(written(tmp_path))
    model = MODEL.replace(BASE, BASE + joints).replace("</mujoco>", f"{SPEAKS}</mujoco>")
    slides = Scene.load(written(tmp_path, model=model))
    assert slides.columns == plain.columns
    same_poses(poses(slides.model, slides.initial.qpos), poses(plain.model, plain.initial.qpos))
    assert Scene.from_bundle(dict(slides.bundle)).columns == plain.columns


@pytest.mark.parametrize("chain", [(X, Y, YAW), (YAW, "", X, Y), ("", X + Y, YAW), (X + Y + YAW,), (X, Y + YAW)])
def test_links_without_shapes_may_carry_it(tmp_path: Path, chain: tuple[str, ...]) -> None:
    plain = Scene.load(written(tmp_path))
    slides = Scene.load(written(tmp_path, model=links(*chain)))
    assert slides.joints("C") == plain.joints("C")
    there = poses(slides.model, slides.initial.qpos)
    same_poses(there, poses(plain.model, plain.initial.qpos))


@pytest.mark.parametrize("joints", [X, YAW, X + YAW, Z + YAW, X + Z, X + X.replace("base_x", "again"), BALL])
def test_other_joints_at_the_root_are_no_base(joints: str) -> None:
    spec = mujoco.MjSpec.from_string(MODEL.replace(BASE, BASE + joints))
    assert base_joints(spec.worldbody.first_body()) == []


def test_a_lift_above_the_base_stays_a_joint(tmp_path: Path) -> None:
    model = links(X, Y, YAW, "").replace("<body name='base'>", f"<body name='base'>{Z.replace('base_z', 'up')}")
    scene = Scene.load(written(tmp_path, model=model))
    assert scene.joints("C")[0] == "up"


def link(name: str, shape: str = "") -> str:
    return f"<link name='{name}'>{shape}</link>"


def joint(child: str, parent: str, kind: str, axis: str) -> str:
    limit = "<limit lower='-1' upper='1' effort='1' velocity='1'/>"
    ends = f"<parent link='{parent}'/><child link='{child}'/><axis xyz='{axis}'/>"
    return f"<joint name='{child}' type='{kind}'>{ends}{limit}</joint>"


@pytest.mark.parametrize("root", ["world", "odom"])
@pytest.mark.parametrize(
    "kinds",
    [
        ["fixed"],
        ["floating"],
        ["planar"],
        ["prismatic 1 0 0", "prismatic 0 1 0", "continuous 0 0 1"],
        ["continuous 0 0 1", "prismatic 1 0 0", "prismatic 0 1 0", "fixed"],
    ],
)
def test_the_root_of_a_urdf_stands_on_the_floor(tmp_path: Path, root: str, kinds: list[str]) -> None:
    shape = "<collision><geometry><sphere radius='0.1'/></geometry></collision>"
    names = [root, *(f"link{i}" for i in range(len(kinds) - 1)), "base_link"]
    links = [link(name, shape if name == "base_link" else "") for name in names]
    for parent, child, kind in zip(names, names[1:], kinds, strict=False):
        word, _, axis = kind.partition(" ")
        links.append(joint(child, parent, word, axis or "0 0 1"))
    neck = link("neck", shape) + joint("neck", "base_link", "revolute", "0 0 1")
    (tmp_path / "r.urdf").write_text(f"<robot name='r'>{''.join(links)}{neck}</robot>")
    eye = "[eye]\nframe = 'neck'\nexclude = 'neck'\nfov_deg = [60, 40]\nimage_px = [160, 120]\n"
    scene = Scene.load(written(tmp_path, f"name = 'r'\nmodel = 'r.urdf'\n{eye}"))
    assert scene.joints("C") == ("neck",)
    assert scene.initial.qpos[scene.base_slice("C")] == pytest.approx((0, 0, 0.1, 1, 0, 0, 0))


def test_the_check_of_a_body_says_nothing_against_it(tmp_path: Path) -> None:
    written(tmp_path, model=MODEL.replace(BASE, BASE + X + Y + YAW))
    checked = check_body(str(tmp_path / "crane.toml"))
    assert not checked.problems
