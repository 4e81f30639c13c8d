"""Rooms, robots and meshes from which the fuzzer starts: written out here, small, and right."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Sequence

import numpy as np

ROOM_TOML = """[scene]
name = "a table for two"
model = "room.xml"
objects = ["cup", "box", "mug"]
estimated = ["table"]

[agents.P1]
profile = "human"
position_m = [-0.95, 0.0]
yaw_deg = 0
posture = "sitting"
body = { stature_m = 1.65 }
joints_deg = { head_tilt = -20 }

[agents.P2]
position_m = [1.0, 0.2]
yaw_deg = 180

[agents.R]
profile = "robot.toml"
position_m = [0.0, 1.4]
yaw_deg = -90
"""
ROOM_XML = """<mujoco model="room">
  <compiler angle="radian" autolimits="true"/>
  <asset>
    <mesh name="mug" file="mug.obj" scale="1 1 1"/>
    <texture name="grid" type="2d" builtin="checker" width="64" height="64"/>
    <material name="wood" texture="grid" rgba="0.6 0.5 0.3 1"/>
  </asset>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1" material="wood"/>
    <body name="table" pos="0 0 0.7"><geom type="box" size="0.4 0.6 0.02"/></body>
    <body name="chair" pos="-0.95 0 0"><geom type="box" size="0.2 0.2 0.225" pos="0 0 0.225"/></body>
    <body name="cup" pos="0.1 0.1 0.77"><freejoint/><geom type="cylinder" size="0.04 0.05"/></body>
    <body name="box" pos="-0.1 0.2 0.77"><freejoint/><geom type="box" size="0.05 0.05 0.05" mass="0.2"/></body>
    <body name="mug" pos="0.0 -0.2 0.72"><freejoint/><geom type="mesh" mesh="mug"/></body>
    <body name="lamp" pos="1 1 0"><geom type="capsule" fromto="0 0 0 0 0 1" size="0.05"/></body>
    <body name="door" pos="0 3 1"><joint axis="0 0 1" range="-1 1"/><geom size="0.05 0.4 1" type="box"/></body>
  </worldbody>
</mujoco>
"""
ROBOT_TOML = """name = "own"
model = "robot.xml"
[eye]
frame = "eye"
exclude = ["head"]
fov_deg = [63, 49]
image_px = [160, 120]
gaze_cone_deg = 30
[head]
pan = { joint = "pan", range_deg = [-80, 80] }
tilt = { joint = "tilt" }
[torso]
turn = { joint = "turn" }
[base]
moves = true
[rest_deg]
s1 = 10
[[arms]]
side = "right"
shoulder = "ra"
root = "ra"
hand = "rh"
palm = { frame = "rh", offset_m = [0.06, 0, 0.01], rpy_deg = [0, 0, 0] }
length_m = 0.5
azimuth_deg = [-60, 120]
elevation_deg = [-80, 70]
[hand]
kind = "parallel"
opening_m = 0.12
finger_length_m = 0.09
finger_thickness_m = 0.02
palm_m = [0.08, 0.04]
"""
ROBOT_XML = """<mujoco model="robot"><worldbody>
<body name="base" pos="0 0 0.4"><geom type="cylinder" size="0.2 0.4"/>
<body name="torso" pos="0 0 0.4"><joint name="turn" type="hinge" axis="0 0 1" range="-60 60"/>
<geom type="box" size="0.1 0.15 0.2" pos="0 0 0.2"/>
<body name="head" pos="0 0 0.5"><joint name="pan" type="hinge" axis="0 0 1" range="-90 90"/>
<joint name="tilt" type="hinge" axis="0 -1 0" range="-45 45"/><geom type="sphere" size="0.08"/>
<site name="eye" pos="0.08 0 0"/></body>
<body name="ra" pos="0 -0.2 0.35"><joint name="s1" type="hinge" axis="0 1 0" range="-120 120"/>
<geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03"/>
<body name="rh" pos="0.35 0 0"><joint name="e1" type="hinge" axis="0 0 1" range="-150 150"/>
<geom type="box" size="0.04 0.03 0.02"/><site name="palm" pos="0.06 0 0"/></body></body>
</body></body></worldbody></mujoco>
"""
GRIPPER_TOML = """name = "arm"
model = "arm.xml"
[eye]
camera = "head_cam"
[base]
moves = false
[[arms]]
side = "left"
shoulder = "upper"
root = "upper"
hand = "hand"
palm = { frame = "hand", offset_m = [0.1, 0, 0] }
azimuth_deg = [-60, 120]
elevation_deg = [-80, 70]
[hand]
tip_m = 0.003
"""
GRIPPER_XML = """<mujoco model="arm"><compiler angle="radian" autolimits="true"/><worldbody>
<body name="base"><geom type="cylinder" size="0.1 0.4" pos="0 0 0.4"/>
<body name="mast" pos="0 0 1"><joint name="pan" axis="0 0 1" range="-1 1"/><geom size="0.05"/>
<camera name="head_cam" pos="0.06 0 0" xyaxes="0 -1 0 0 0 1" fovy="45" resolution="64 48"/></body>
<body name="upper" pos="0 0.2 0.8"><joint name="j1" axis="0 0 1" range="-2 2"/>
<geom type="capsule" size="0.03" fromto="0 0 0 0.3 0 0"/>
<body name="fore" pos="0.3 0 0"><joint name="j2" axis="0 1 0" range="-2 2"/>
<geom type="capsule" size="0.03" fromto="0 0 0 0.2 0 0"/>
<body name="hand" pos="0.2 0 0"><joint name="j3" axis="1 0 0" range="-2 2"/>
<geom type="box" size="0.03 0.04 0.02" pos="0.03 0 0"/>
<body name="one" pos="0.06 0.005 0"><joint name="f1" type="slide" axis="0 1 0" range="0 0.04"/>
<geom type="box" size="0.03 0.005 0.01" pos="0.03 0.005 0"/></body>
<body name="two" pos="0.06 -0.03 0"><joint name="f2" axis="0 0 1" range="0 0.5"/>
<geom type="capsule" size="0.006" fromto="0 0 0 0.06 0 0"/></body></body></body></body>
</body></worldbody><equality><joint joint1="f2" joint2="f1" polycoef="0 -10 0 0 0"/></equality></mujoco>
"""
GRIPPER_URDF = """<robot name="arm"><link name="base"/>
<link name="camera_optical_frame"/>
<link name="l1"><visual><geometry><box size="0.3 0.05 0.05"/></geometry></visual></link>
<link name="l2"><collision><geometry><box size="0.3 0.05 0.05"/></geometry></collision></link>
<link name="jaw"><collision><geometry><cylinder radius="0.01" length="0.08"/></geometry></collision></link>
<joint name="c" type="fixed"><parent link="base"/><child link="camera_optical_frame"/>
<origin xyz="0 0 1" rpy="-1.5708 0 -1.5708"/></joint>
<joint name="j1" type="continuous"><parent link="base"/><child link="l1"/><axis xyz="0 0 1"/></joint>
<joint name="j2" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="0.3 0 0"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="grip" type="prismatic"><parent link="l2"/><child link="jaw"/><origin xyz="0.1 0 0.05"/><axis xyz="0 0 1"/>
<limit lower="0" upper="0.05" effort="1" velocity="1"/></joint>
<gazebo reference="camera_optical_frame"><sensor type="camera"><camera><horizontal_fov>1.1</horizontal_fov>
<image><width>64</width><height>48</height></image></camera></sensor></gazebo></robot>
"""
URDF_TOML = """[scene]
model = "room.urdf"
[agents.P1]
position_m = [-1.0, 0.0]
[agents.J]
profile = "jido"
position_m = [1.2, 0]
yaw_deg = 180
"""
URDF = """<?xml version="1.0"?>
<robot name="room">
 <link name="world_root"/>
 <link name="table">
  <visual><origin xyz="0 0 0.7" rpy="0 0 0"/><geometry><box size="0.8 1.2 0.04"/></geometry></visual>
  <collision><origin xyz="0 0 0.7"/><geometry><box size="0.8 1.2 0.04"/></geometry></collision>
 </link>
 <link name="cup">
  <inertial><mass value="0.2"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial>
  <visual><geometry><mesh filename="part.stl"/></geometry></visual>
  <collision><geometry><cylinder radius="0.04" length="0.1"/></geometry></collision>
 </link>
 <link name="vase"><visual><geometry><mesh filename="part.dae" scale="1 1 1"/></geometry></visual></link>
 <joint name="j1" type="fixed"><parent link="world_root"/><child link="table"/></joint>
 <joint name="j2" type="floating"><origin xyz="0.1 0 0.72"/><parent link="world_root"/><child link="cup"/></joint>
 <joint name="j3" type="floating"><origin xyz="-0.1 0 0.72"/><parent link="world_root"/><child link="vase"/></joint>
</robot>
"""


# --- Files whose names meet where folders are left out; and what MJCF makes many of.

CROWDED_TOML = """[scene]
model = "room.urdf"
[agents.P1]
position_m = [-1.0, 0.0]
[agents.R]
profile = "robot.toml"
position_m = [0.0, 1.4]
yaw_deg = -90
"""
CROWDED_URDF = """<?xml version="1.0"?>
<robot name="crowded">
 <link name="floor"/>
 <link name="first"><visual><geometry><mesh filename="a/m.stl"/></geometry></visual></link>
 <link name="second"><visual><geometry><mesh filename="a_m.stl"/></geometry></visual></link>
 <link name="third"><visual><geometry><mesh filename="R_a_m.stl"/></geometry></visual></link>
 <link name="fourth"><visual><geometry><mesh filename="a/m.dae"/></geometry></visual></link>
 <joint name="j1" type="floating"><origin xyz="0 0 0.7"/><parent link="floor"/><child link="first"/></joint>
 <joint name="j2" type="floating"><origin xyz="0.2 0 0.7"/><parent link="floor"/><child link="second"/></joint>
 <joint name="j3" type="floating"><origin xyz="0 0.2 0.7"/><parent link="floor"/><child link="third"/></joint>
 <joint name="j4" type="floating"><origin xyz="0.2 0.2 0.7"/><parent link="floor"/><child link="fourth"/></joint>
</robot>
"""
ROBOT_URDF_TOML = ROBOT_TOML.replace("robot.xml", "robot.urdf")
ROBOT_URDF = """<?xml version="1.0"?>
<robot name="robot">
 <link name="base"><collision><geometry><mesh filename="a_m.stl"/></geometry></collision></link>
 <link name="torso"><visual><geometry><mesh filename="package://robot/a/m.stl"/></geometry></visual></link>
 <link name="head"><visual><geometry><sphere radius="0.08"/></geometry></visual></link>
 <link name="eye"/>
 <link name="ra"><visual><geometry><mesh filename="a/m.stl"/></geometry></visual></link>
 <link name="rh"><collision><geometry><box size="0.08 0.06 0.04"/></geometry></collision></link>
 <joint name="turn" type="revolute"><origin xyz="0 0 0.8"/><parent link="base"/><child link="torso"/>
  <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
 <joint name="pan" type="revolute"><origin xyz="0 0 0.5"/><parent link="torso"/><child link="head"/>
  <axis xyz="0 0 1"/><limit lower="-1.6" upper="1.6" effort="1" velocity="1"/></joint>
 <joint name="tilt" type="revolute"><origin xyz="0.08 0 0"/><parent link="head"/><child link="eye"/>
  <axis xyz="0 -1 0"/><limit lower="-0.8" upper="0.8" effort="1" velocity="1"/></joint>
 <joint name="s1" type="revolute"><origin xyz="0 -0.2 0.35"/><parent link="torso"/><child link="ra"/>
  <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
 <joint name="e1" type="revolute"><origin xyz="0.35 0 0"/><parent link="ra"/><child link="rh"/>
  <axis xyz="0 0 1"/><limit lower="-2.6" upper="2.6" effort="1" velocity="1"/></joint>
</robot>
"""
MANY_TOML = ROOM_TOML.replace("room.xml", "many.xml").replace('["cup", "box", "mug"]', '["cup", "bracket"]')
MANY_XML = """<mujoco model="many">
  <compiler angle="radian" autolimits="true" meshdir="shapes" texturedir="colours"/>
  <default><default class="seen"><geom contype="0" conaffinity="0"/></default></default>
  <asset>
    <mesh name="first" file="a/m.obj"/>
    <mesh name="second" file="a_m.obj"/>
    <mesh name="third" file="m.obj"/>
    <mesh name="R_a" file="R_a.obj"/>
    <mesh file="bracket.stl"/>
    <texture name="plain" type="2d" file="m.obj" content_type="image/png"/>
    <texture name="dice" type="cube" fileright="a/m.png" fileleft="a_m.png" fileup="m.png" filedown="a/m.png"
             filefront="a_m.png" fileback="m.png"/>
    <texture name="unfolded" type="cube" file="m.png" gridsize="1 1"/>
    <texture name="sky" type="skybox" builtin="gradient" rgb1="0 0 1" rgb2="1 1 1" width="8" height="48"/>
    <material name="dotted" texture="dice"/>
    <hfield name="hills" file="hills.png" size="0.3 0.3 0.05 0.01"/>
    <hfield name="steps" nrow="3" ncol="3" elevation="0 0 0 0 1 0 0 0 1" size="0.3 0.3 0.05 0.01"/>
    <model name="lamp" file="lamp.xml"/>
  </asset>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="table" pos="0 0 0.7"><geom type="box" size="0.4 0.6 0.02" material="dotted"/></body>
    <body name="chair" pos="-0.95 0 0"><geom type="box" size="0.2 0.2 0.225" pos="0 0 0.225"/></body>
    <body name="cup" pos="0.1 0.1 0.72"><freejoint/><geom class="seen" type="mesh" mesh="first"/>
      <geom class="seen" type="mesh" mesh="second" pos="0 0 0.1"/></body>
    <body name="bracket" pos="-0.1 0.1 0.72"><freejoint/><geom type="mesh" mesh="bracket"/></body>
    <geom class="seen" type="mesh" mesh="third" pos="2 2 0"/>
    <geom class="seen" type="mesh" mesh="R_a" pos="2 1 0"/>
    <geom type="hfield" hfield="hills" pos="-2 2 0"/>
    <geom type="hfield" hfield="steps" pos="-2 1 0"/>
    <replicate count="3" offset="0.2 0 0" euler="0 0 0.1">
      <body name="pole" pos="1 -2 0"><geom type="capsule" fromto="0 0 0.1 0 0 1" size="0.02"/></body>
    </replicate>
    <frame pos="1 1 0"><attach model="lamp" body="lamp" prefix="l_"/></frame>
  </worldbody>
</mujoco>
"""
COUNTED_TOML = """[scene]
model = "room.xml"
[agents.P1]
position_m = [-1.0, 0.0]
"""
COUNTED_XML = """<mujoco>
  <asset>
    <hfield name="h" nrow="4" ncol="4" size="1 1 0.1 0.1"/>
    <texture name="t" type="cube" builtin="flat" width="8" height="8"/>
    <mesh name="m" builtin="supersphere" params="6 1 1"/>
  </asset>
  <worldbody>
    <body name="cup"><freejoint/><geom size="0.05"/></body>
    <replicate count="3" offset="0 0 1"><replicate count="2" offset="0 1 0"><geom size="0.1"/></replicate></replicate>
    <geom type="hfield" hfield="h"/><geom type="mesh" mesh="m" contype="0" conaffinity="0"/>
  </worldbody>
</mujoco>
"""
LAMP_XML = """<mujoco model="lamp">
  <asset><mesh name="m" file="a/m.obj"/></asset>
  <worldbody>
    <body name="lamp">
      <geom type="mesh" mesh="m" contype="0" conaffinity="0"/><geom type="sphere" size="0.05" pos="0 0 0.3"/>
    </body>
  </worldbody>
</mujoco>
"""
COMPOSED_TOML = """[scene]
name = "a room of several models"
model = "room.xml"
keyframe = "home"
objects = ["cup", "tray", "tag"]
leave_out = ["target"]

[furniture.shelf]
model = "shelf.xml"
position_m = [0.5, 1.2, 0]
yaw_deg = 90

[furniture.rack]
model = "rack.urdf"
position_m = [-0.5, 1.2, 0]
rpy_deg = [0, 5, 30]

[objects.mug]
model = "mug.urdf"
position_m = [0.1, 0.3, 0.72]

[objects.stone]
mesh = "stone.obj"
scale = 0.5
mass_kg = 0.3
position_m = [0.2, -0.3, 0.72]

[agents.P1]
position_m = [-0.95, 0.0]

[agents.R]
profile = "robot.toml"
room_body = "r0_base"
room_prefix = "r0_"
"""
COMPOSED_XML = f"""<mujoco model="room"><compiler angle="degree"/>
  <asset><mesh name="wedge" file="wedge.obj"/></asset>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="table" pos="0 0 0.7"><geom type="box" size="0.4 0.6 0.02"/></body>
    <body name="door" pos="0 3 1"><joint name="door" range="-60 60"/><geom size="0.05 0.4 1" type="box"/></body>
    <body name="cup" pos="0.1 0.1 0.77"><joint name="x" type="slide" axis="1 0 0"/>
      <joint type="slide" axis="0 1 0"/><joint type="slide"/><joint type="ball"/>
      <geom type="cylinder" size="0.04 0.05"/></body>
    <body name="tray" pos="-0.1 0.2 0.73"><geom type="mesh" mesh="wedge"/></body>
    <body name="tag" mocap="true" pos="0 -0.2 0.75"><geom size="0.02"/></body>
    <body name="target"><geom size="0.02" contype="0" conaffinity="0"/></body>
    {ROBOT_XML[ROBOT_XML.index("<body") : ROBOT_XML.index("</worldbody>")].replace('name="', 'name="r0_')}
  </worldbody>
  <equality><joint joint1="x"/><weld body1="tag" body2="r0_rh"/></equality>
  <tendon><fixed name="t"><joint joint="x" coef="1"/><joint joint="r0_pan" coef="1"/></fixed></tendon>
  <actuator><motor joint="r0_e1"/><motor tendon="t"/></actuator>
  <sensor><framepos objtype="body" objname="r0_rh"/></sensor>
  <keyframe><key name="home" qpos="0.3 0 0.1 0 1 0 0 0 0 0 0 0 0" mpos="0 -0.3 0.75"/></keyframe>
</mujoco>
"""
SHELF_XML = """<mujoco model="shelf">
  <asset><mesh name="wedge" file="shelf.obj"/></asset>
  <worldbody>
    <geom type="box" size="0.2 0.4 0.02" pos="0 0 0.5"/>
    <body name="drawer" pos="0 0 0.4"><joint name="pull" type="slide" axis="1 0 0" range="0 0.3"/>
      <geom type="box" size="0.2 0.3 0.05"/></body>
    <body name="vase" pos="0 0 0.52"><freejoint/><geom type="mesh" mesh="wedge"/></body>
  </worldbody>
  <keyframe><key qpos="0.1 0 0 0.5 1 0 0 0"/></keyframe>
</mujoco>
"""
RACK_URDF = """<?xml version="1.0"?>
<robot name="rack">
 <link name="frame"><collision><geometry><box size="0.3 0.3 0.8"/></geometry></collision></link>
 <link name="arm"><visual><geometry><mesh filename="a/m.stl"/></geometry></visual></link>
 <joint name="turn" type="revolute"><origin xyz="0 0 0.6"/><parent link="frame"/><child link="arm"/>
  <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>
"""
MUG_URDF = """<?xml version="1.0"?>
<robot name="mug">
 <link name="mug"><visual><geometry><mesh filename="m.stl"/></geometry></visual></link>
 <link name="lid"><collision><geometry><box size="0.05 0.05 0.01"/></geometry></collision></link>
 <joint name="lid" type="revolute"><origin xyz="0 0 0.1"/><parent link="mug"/><child link="lid"/>
  <axis xyz="0 1 0"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint>
</robot>
"""
MESHED_ROBOT_XML = ROBOT_XML.replace(
    "<worldbody>", '<asset><mesh name="a" file="a.obj"/></asset><worldbody>', 1
).replace('<geom type="sphere" size="0.08"/>', '<geom type="mesh" mesh="a"/>')


FLAT_TOML = """[scene]
model = "flat.xml"
[agents.P1]
position_m = [-1.0, 0.0]
[agents.R]
profile = "robot.toml"
position_m = [0.0, 1.4]
"""
FLAT_XML = """<mujoco>
  <asset>
    <mesh name="floor" file="square.obj" scale="8 8 8"/>
    <mesh name="poster" file="poster.stl"/>
    <mesh name="ball" file="ball.ply"/>
    <texture name="missing" type="2d" file="nowhere.png"/>
    <material name="paper" texture="missing" rgba="1 1 0.9 1"/>
  </asset>
  <worldbody>
    <geom name="floor" type="mesh" mesh="floor"/>
    <body name="wall" pos="1 0 1" euler="0 90 0"><geom type="mesh" mesh="poster" material="paper"/></body>
    <body name="cloth" pos="0.4 0.3 0.7"><freejoint/><geom type="mesh" mesh="floor" contype="0" conaffinity="0"/></body>
    <body name="cup" pos="0.3 0 0.7"><freejoint/><geom type="mesh" mesh="ball"/></body>
  </worldbody>
</mujoco>
"""
EXPANDED_URDF = ROBOT_URDF.replace("<robot", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"').replace(
    '<visual><geometry><mesh filename="package://robot/a/m.stl"/>', '<visual><geometry><box size="0.2 0.3 0"/>'
)


def rooms() -> dict[str, dict[str, bytes]]:
    """Files of rooms and their robots, by what they are for."""
    robot = {"robot.toml": ROBOT_TOML.encode(), "robot.xml": ROBOT_XML.encode()}
    return {
        "plain": {"room.toml": ROOM_TOML.encode(), "room.xml": ROOM_XML.encode(), "mug.obj": obj(prism()), **robot},
        "urdf": {
            "urdf.toml": URDF_TOML.encode(),
            "room.urdf": URDF.encode(),
            "part.stl": stl(prism()),
            "part.dae": dae(prism()),
        },
        "concave": {
            "urdf.toml": URDF_TOML.encode(),
            "room.urdf": URDF.replace("visual", "collision").encode(),
            "part.stl": stl(bracket()),
            "part.dae": dae(bracket()),
        },
        "crowded": {
            "urdf.toml": CROWDED_TOML.encode(),
            "room.urdf": CROWDED_URDF.encode(),
            "robot.toml": ROBOT_URDF_TOML.encode(),
            "robot.urdf": ROBOT_URDF.encode(),
            "a/m.stl": stl(prism(0.10)),
            "a_m.stl": stl(prism(0.11)),
            "R_a_m.stl": stl(prism(0.12)),
            "a/m.dae": dae(prism(0.13)),
            "robot/a/m.stl": stl(prism(0.14)),
        },
        "composed": {
            "room.toml": COMPOSED_TOML.encode(),
            "room.xml": COMPOSED_XML.encode(),
            "shelf.xml": SHELF_XML.encode(),
            "rack.urdf": RACK_URDF.encode(),
            "mug.urdf": MUG_URDF.encode(),
            "wedge.obj": obj(prism(0.10)),
            "shelf.obj": obj(prism(0.11)),
            "stone.obj": obj(prism(0.12)),
            "m.stl": stl(prism(0.13)),
            "a/m.stl": stl(prism(0.14)),
            "robot.toml": ROBOT_TOML.encode(),
        },
        "gripper": {
            "arm.toml": GRIPPER_TOML.encode(),
            "arm.xml": GRIPPER_XML.encode(),
            "arm.urdf": GRIPPER_URDF.encode(),
        },
        "flat": {
            "flat.toml": FLAT_TOML.encode(),
            "flat.xml": FLAT_XML.encode(),
            "square.obj": obj(square()),
            "poster.stl": stl_text(square()),
            "ball.ply": ply(prism()),
            "robot.toml": ROBOT_URDF_TOML.encode(),
            "robot.urdf": EXPANDED_URDF.encode(),
            "a_m.stl": stl(prism()),
            "a/m.stl": stl(square()),
        },
        "counted": {"room.toml": COUNTED_TOML.encode(), "room.xml": COUNTED_XML.encode()},
        "many": {
            "many.toml": MANY_TOML.encode(),
            "many.xml": MANY_XML.encode(),
            "lamp.xml": LAMP_XML.encode(),
            "shapes/a/m.obj": obj(prism(0.10)),
            "shapes/a_m.obj": obj(prism(0.11)),
            "shapes/m.obj": obj(prism(0.12)),
            "shapes/R_a.obj": obj(prism(0.13)),
            "shapes/bracket.stl": stl(bracket()),
            "shapes/hills.png": png(1),
            "a/m.obj": obj(prism(0.14)),
            "a.obj": obj(prism(0.15)),
            "colours/m.obj": png(2),
            "colours/m.png": png(3),
            "colours/a/m.png": png(4),
            "colours/a_m.png": png(5),
            "robot.toml": ROBOT_TOML.encode(),
            "robot.xml": MESHED_ROBOT_XML.encode(),
        },
    }


# --- Meshes and images.

Mesh = tuple[Sequence[tuple[float, float, float]], Sequence[tuple[int, int, int]]]
"""Vertices in metres, and triangles."""


def prism(height_m: float = 0.1) -> Mesh:
    """A hexagonal prism: convex, so that nothing is decomposed."""
    ring = [(0.04 * math.cos(k * math.pi / 3), 0.04 * math.sin(k * math.pi / 3)) for k in range(6)]
    ends = [face for a in range(1, 5) for face in ((0, a + 1, a), (6, a + 6, a + 7))]
    return _walls(ring, height_m, ends)


def square() -> Mesh:
    """A square without thickness."""
    return [(-0.1, -0.1, 0), (0.1, -0.1, 0), (0.1, 0.1, 0), (-0.1, 0.1, 0)], [(0, 1, 2), (0, 2, 3)]


def bracket() -> Mesh:
    """An L upright: concave, so that it is cut into convex parts."""
    ring = [(0.04 * x, 0.04 * y) for x, y in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))]
    ends = [face for a, b in ((4, 5), (5, 0), (0, 1), (1, 2)) for face in ((3, b, a), (9, a + 6, b + 6))]
    return _walls(ring, 0.06, ends)


def _walls(ring: Sequence[tuple[float, float]], height_m: float, ends: list[tuple[int, int, int]]) -> Mesh:
    vertices = [(x, y, z) for z in (0.0, height_m) for x, y in ring]
    sides = [face for a in range(6) for b in [(a + 1) % 6] for face in ((a, b, b + 6), (a, b + 6, a + 6))]
    return vertices, sides + ends


def obj(mesh: Mesh) -> bytes:
    """The mesh as OBJ."""
    vertices, faces = mesh
    lines = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in vertices]
    return "\n".join(lines + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]).encode()


def stl(mesh: Mesh) -> bytes:
    """The mesh as binary STL."""
    vertices, faces = mesh
    triangles = np.zeros(len(faces), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    triangles["corners"] = np.array(vertices)[np.array(faces)]
    return bytes(80) + np.array([len(faces)], dtype="<u4").tobytes() + triangles.tobytes()


def stl_text(mesh: Mesh) -> bytes:
    """The mesh as STL that is text."""
    vertices, faces = mesh
    loops = ("\n".join("vertex {:g} {:g} {:g}".format(*vertices[corner]) for corner in face) for face in faces)
    facets = (f"facet normal 0 0 1\nouter loop\n{loop}\nendloop\nendfacet" for loop in loops)
    return "\n".join(["solid a", *facets, "endsolid a"]).encode()


def ply(mesh: Mesh) -> bytes:
    """The mesh as binary PLY."""
    vertices, faces = mesh
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    head += [f"property float {axis}" for axis in "xyz"]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    corners = np.array(vertices, dtype="<f4").tobytes()
    return "\n".join(head).encode() + corners + b"".join(struct.pack("<B3i", 3, *face) for face in faces)


def dae(mesh: Mesh) -> bytes:
    """The mesh as COLLADA."""
    vertices, faces = mesh
    numbers = " ".join(f"{value:.5f}" for vertex in vertices for value in vertex)
    indices = " ".join(str(index) for face in faces for index in face)
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit meter="1"/></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="{3 * len(vertices)}">{numbers}</float_array></source>
<vertices id="vx"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{len(faces)}"><input semantic="VERTEX" source="#vx" offset="0"/><p>{indices}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><translate>0 0 0</translate><rotate>0 0 1 30</rotate>
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
""".encode()


def png(grey: int) -> bytes:
    """An image of 4 x 4 pixels of one grey, but for a white one in the last row."""
    header = struct.pack(">IIBBBBB", 4, 4, 8, 0, 0, 0, 0)
    last = bytes(255 if i == grey % 4 else 10 * grey for i in range(4))
    rows = b"".join(b"\0" + row for row in (*[bytes([10 * grey] * 4)] * 3, last))
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks
    )


CONCAVE = frozenset(write(bracket()) for write in (obj, stl, dae))
"""Meshes that are cut into convex parts, as files."""
