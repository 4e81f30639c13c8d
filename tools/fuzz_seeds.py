"""What the fuzzer starts from: small inputs of every kind that are right, and the commands that read them.

Most are written out here; recordings, knowledge, pools and maps are made by the code that is fuzzed.
"""

from __future__ import annotations

import dataclasses
import io
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from taskgist.learning.explanation import Context
from taskgist.learning.knowledge import Knowledge
from taskgist.maps.ability_map import ability_map, write_maps
from taskgist.maps.grid import Grid
from taskgist.pipeline.explain import explain_recording
from taskgist.pipeline.shipped import shipped_study
from taskgist.recording.mcap import read, write
from taskgist.store.database import save
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist_lab.evaluation.pool import NODES, SOURCES, empty_pool, write_pool
from taskgist_lab.evaluation.values import CLEAN, Sample
from taskgist_lab.paper.displacements import Displacements, write_displacements

Command = tuple[str, ...]
"""Arguments of ``taskgist``; or ``read-maps``, ``read-pool``, ``read-displacements`` and a file."""


@dataclass(frozen=True)
class Seed:
    """Files that are right, and what is done with them.

    Attributes:
        kind: What is fuzzed.
        files: All files of the folder in which the commands run, by name.
        mutated: Names of those that are spoiled.
        commands: One of these is run.
        written: Names of files that a command may change or make.
    """

    kind: str
    files: Mapping[str, bytes]
    mutated: tuple[str, ...]
    commands: tuple[Command, ...]
    written: tuple[str, ...] = ()


def seeds(folder: Path) -> tuple[Seed, ...]:
    """All seeds.

    Args:
        folder: An empty one, for files that are made by writing them.
    """
    recorded = {f"{path.stem}.mcap": _excerpt(path, folder) for path in (shipped_study()["show"][0],)}
    knowledge = _knowledge(folder / "show_a.mcap", folder / "knowledge.db")
    rooms = {
        "room.toml": ROOM_TOML.encode(),
        "room.xml": ROOM_XML.encode(),
        "mug.obj": _obj(),
        "robot.toml": ROBOT_TOML.encode(),
        "robot.xml": ROBOT_XML.encode(),
    }
    urdf = {
        "urdf.toml": URDF_TOML.encode(),
        "room.urdf": URDF.encode(),
        "part.stl": _stl(),
        "part.dae": _dae(),
    }
    tables = _tables()
    questions = tuple(
        ("query", "room.toml", "--agent", agent, "--object", thing, "--ability", ability, *json_)
        for agent, thing, ability, json_ in (
            ("P1", "cup", "reach", ()),
            ("P1", "mug", "see", ("--json",)),
            ("R", "box", "grasp", ()),
            ("R", "cup", "see", ("--why",)),
        )
    )
    in_urdf = tuple(
        ("query", "urdf.toml", "--agent", agent, "--object", "vase", "--ability", "see") for agent in ("P1", "J")
    )
    from_csv: tuple[Command, ...] = (("import", "csv.toml", "-o", "out.mcap"),)
    from_npz: tuple[Command, ...] = (("import", "npz.toml", "-o", "out.mcap", "--json"),)
    watched: tuple[Command, ...] = (
        ("label", "show_a.mcap"),
        ("label", "show_a.mcap", "--task", "hide", "--json"),
        ("check", "show_a.mcap"),
        ("facts", "show_a.mcap", "--at", "1.5"),
        ("learn", "show_a.mcap", "-k", "new.db"),
        ("query", "show_a.mcap", "--agent", "P2", "--object", "cup", "--ability", "see", "--json"),
    )
    asked: tuple[Command, ...] = (
        ("explain", "show", "-k", "knowledge.db"),
        ("explain", "-k", "knowledge.db", "--json"),
        ("learn", "facts.json", "-k", "knowledge.db"),
    )
    facts = {"facts.json": json.dumps(FACTS, indent=1).encode()}
    pool, displaced, maps = _pool(folder), _displacements(folder), _maps(folder, rooms)
    return (
        Seed("scene", rooms, ("room.toml",), questions),
        Seed("model", rooms, ("room.xml",), questions),
        Seed("model", rooms, ("robot.xml",), (("agent", "check", "robot.toml"), questions[2])),
        Seed("urdf", urdf, ("room.urdf",), in_urdf),
        Seed("mesh", rooms, ("mug.obj",), (questions[1],)),
        Seed("mesh", urdf, ("part.stl", "part.dae"), in_urdf),
        Seed("profile", rooms, ("robot.toml",), (("agent", "check", "robot.toml"), questions[2], questions[3])),
        Seed("mapping", tables, ("csv.toml",), from_csv, ("out.mcap",)),
        Seed("mapping", tables, ("npz.toml",), from_npz, ("out.mcap",)),
        Seed("table", tables, ("body.csv", "cup.tsv"), from_csv, ("out.mcap",)),
        Seed("table", tables, ("data.npz", "cup.npy"), from_npz, ("out.mcap",)),
        Seed("recording", recorded, ("show_a.mcap",), watched, ("show_a.mcap", "new.db")),
        Seed("knowledge", {"knowledge.db": knowledge, **facts}, ("knowledge.db",), asked, ("knowledge.db",)),
        Seed("facts", facts, ("facts.json",), (("learn", "facts.json", "-k", "new.db", "--json"),), ("new.db",)),
        Seed("pool", {"pool.json.gz": pool}, ("pool.json.gz",), (("read-pool", "pool.json.gz"),)),
        Seed("pool", {"moved.json.gz": displaced}, ("moved.json.gz",), (("read-displacements", "moved.json.gz"),)),
        Seed("map", {"maps.npz": maps}, ("maps.npz",), (("read-maps", "maps.npz"),)),
        Seed(
            "option",
            {**rooms, **recorded, **facts, **tables, "knowledge.db": knowledge},
            (),
            (*questions, *watched, *asked, *from_csv, *OPTIONS),
            ("show_a.mcap", "new.db", "knowledge.db", "out.mcap", "map.png", "map.npz", "eye.png"),
        ),
        Seed("path", rooms, tuple(rooms), (questions[1], ("agent", "check", "robot.toml"))),
        Seed("path", tables, tuple(tables), (*from_csv, *from_npz), ("out.mcap",)),
        Seed("path", recorded, ("show_a.mcap",), watched, ("show_a.mcap", "new.db")),
        Seed("path", {"knowledge.db": knowledge, **facts}, ("knowledge.db", "facts.json"), asked, ("knowledge.db",)),
    )


OPTIONS: tuple[Command, ...] = (
    ("query", "room.toml", "--where", "P1 reaches <= 2 and not P2 sees"),
    ("query", "room.toml", "--agent", "P1", "--actions", "Pan_Head,Tilt_Head"),
    ("facts", "show_a.mcap", "--agent", "P2", "--object", "cup", "--every", "0.5", "--json"),
    ("label", "show_a.mcap", "--start", "0.1", "--end", "2.5", "--task", "show", "--target", "P2", "--object", "cup"),
    ("label", "show_a.mcap", "--performer", "P1", "--task", "show", "--propose", "--dry-run"),
    ("explain", "show", "-k", "knowledge.db", "--why", "see.class", "--band", "narrow"),
    ("map", "room.toml", "--agent", "P1", "--level", "0", "--size", "0.1,0.1,0.2", "--npz", "map.npz"),
    ("see", "room.toml", "--agent", "P1", "--object", "cup", "-o", "eye.png"),
    ("simulate", "--list"),
    ("import", "csv.toml", "--data", ".", "--set", "folder=x", "-o", "out.mcap"),
    ("query", "show_a.mcap", "--at", "1.0", "--agent", "P2", "--object", "cup", "--ability", "see"),
)

# --- Rooms, bodies, meshes.

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


def _prism() -> tuple[list[tuple[float, float, float]], list[tuple[int, int, int]]]:
    """Vertices and triangles of a hexagonal prism: convex, so that nothing is decomposed."""
    ring = [(0.04 * math.cos(k * math.pi / 3), 0.04 * math.sin(k * math.pi / 3)) for k in range(6)]
    vertices = [(x, y, z) for z in (0.0, 0.1) for x, y in ring]
    sides = [face for a in range(6) for b in [(a + 1) % 6] for face in ((a, b, b + 6), (a, b + 6, a + 6))]
    ends = [face for a in range(1, 5) for face in ((0, a + 1, a), (6, a + 6, a + 7))]
    return vertices, sides + ends


def _obj() -> bytes:
    vertices, faces = _prism()
    lines = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in vertices]
    return "\n".join(lines + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]).encode()


def _stl() -> bytes:
    vertices, faces = _prism()
    triangles = np.zeros(len(faces), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    triangles["corners"] = np.array(vertices)[np.array(faces)]
    return bytes(80) + np.array([len(faces)], dtype="<u4").tobytes() + triangles.tobytes()


def _dae() -> bytes:
    vertices, faces = _prism()
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


# --- Tables of tracked motion: two people facing each other across a table, and a cup that travels.

FRAMES, RATE_HZ = 6, 10
LANDMARKS: Mapping[str, tuple[float, float, float]] = {
    "pelvis": (0.0, 0.0, 0.92),
    "chest": (0.0, 0.0, 1.2),
    "neck": (0.0, 0.0, 1.4),
    "head": (0.02, 0.0, 1.52),
    "nose": (0.12, 0.0, 1.55),
    "left_ear": (0.02, 0.08, 1.55),
    "right_ear": (0.02, -0.08, 1.55),
    "left_shoulder": (0.0, 0.19, 1.36),
    "left_elbow": (0.02, 0.24, 1.08),
    "left_wrist": (0.12, 0.22, 0.85),
    "right_shoulder": (0.0, -0.19, 1.36),
    "right_elbow": (0.02, -0.24, 1.08),
    "right_wrist": (0.12, -0.22, 0.85),
}
"""Where each lies on a person at the origin who looks along x, metres."""

_POINTS = "\n".join(f'{name} = "{name.upper()}"' for name in LANDMARKS)
_REST = """
[people.P2]
like = "P1"
person = {second}

[objects.cup]
source = "cup"
{cup}shape = [{{ type = "cylinder", radius_m = 0.04, length_m = 0.10, axis = "z" }}]

[supports.table]
size_m = [0.6, 1.2, 0.04]
position_m = [0.0, 0.0, 0.7]
yaw_deg = 0

[label]
task = "give"
performing_agent = "P1"
target_agent = "P2"
target_object = "cup"
start_s = 0.1
end_s = 0.4
"""
CSV_TOML = f"""[about]
source = "our lab"
licence = "CC-BY-4.0"
notes = ["made up"]
[parameters]
folder = "x"
[time]
max_gap_s = 0.5
rate_hz = {RATE_HZ}
[sources.body]
file = "body.csv"
time = {{ column = "stamp", unit = "ms" }}
units = "mm"
position = "{{person}}_{{point}}_{{axis}}"
missing = 0
smooth_s = 0.1
[sources.cup]
file = "cup.tsv"
time = {{ column = "stamp", unit = "ms" }}
units = "m"
rotation = {{ kind = "xyzw", columns = "q{{axis}}" }}
[people.P1]
source = "body"
person = "one"
stature_m = 1.7
[people.P1.points]
{_POINTS}
[people.P1.unknown]
right_hand = "glove"
[people.P1.directions]
head = {{ from = ["left_ear", "right_ear"], to = ["nose"], raise_deg = 6 }}
[objects.ball]
fixed = {{ position_m = [0.2, 0.3, 0.75], yaw_deg = 10 }}
shape = {{ type = "sphere", radius_m = 0.03 }}
[signals.grip]
source = "cup"
column = "force"
unit = "N"
""" + _REST.format(second='"two"', cup="offset_m = [0, 0, 0.01]\n")
NPZ_TOML = f"""[sources.body]
file = "data.npz"
array = "body"
time = {{ column = "t", unit = "s" }}
units = "m"
names = {json.dumps([name.upper() for name in LANDMARKS])}
layout = ["time", "{{person}}", "{{point}}", "value"]
[sources.cup]
file = "cup.npy"
rate_hz = {RATE_HZ}
units = "m"
rotation = {{ kind = "wxyz", columns = [3, 4, 5, 6] }}
[people.P1]
source = "body"
person = 0
[people.P1.points]
{_POINTS}
""" + _REST.format(second=1, cup="")


def _tables() -> dict[str, bytes]:
    times_s = np.arange(FRAMES) / RATE_HZ
    standing = np.array(list(LANDMARKS.values()))
    facing = standing * (-1.0, -1.0, 1.0)
    sway = 0.02 * np.sin(times_s)[:, None, None] * (1.0, 0.5, 0.0)
    people = np.stack([standing - (0.7, 0.0, 0.0) + sway, facing + (0.7, 0.0, 0.0) - sway], axis=1)
    cup_m = np.stack([-0.2 + 0.6 * times_s, 0.1 * times_s, 0.77 + 0.1 * times_s], axis=1)
    turned = np.tile((0.0, 0.0, 0.0, 1.0), (FRAMES, 1))
    header = ["stamp", *(f"{p}_{n.upper()}_{axis}" for p in ("one", "two") for n in LANDMARKS for axis in "xyz")]
    body = [
        header,
        *([f"{1000 * t:g}", *(f"{1000 * v:.1f}" for v in row.ravel())] for t, row in zip(times_s, people, strict=True)),
    ]
    cup = [
        ["stamp", "x", "y", "z", "qx", "qy", "qz", "qw", "force"],
        *(
            [f"{1000 * t:g}", *(f"{v:.4f}" for v in (*row, *q, t))]
            for t, row, q in zip(times_s, cup_m, turned, strict=True)
        ),
    ]
    arrays, array = io.BytesIO(), io.BytesIO()
    np.savez_compressed(arrays, t=times_s, body=people, unused=np.zeros(3))
    np.save(array, np.concatenate([cup_m, np.roll(turned, 1, axis=1)], axis=1))
    return {
        "csv.toml": CSV_TOML.encode(),
        "body.csv": "\n".join(",".join(row) for row in body).encode(),
        "cup.tsv": "\n".join("\t".join(row) for row in cup).encode(),
        "npz.toml": NPZ_TOML.encode(),
        "data.npz": arrays.getvalue(),
        "cup.npy": array.getvalue(),
    }


# --- What taskgist itself writes.

FACTS = {
    "schema": "taskgist.facts/1",
    "task": "show",
    "demonstration": "show-1",
    "performing_agent": "P1",
    "target_agent": "P2",
    "target_object": "mug",
    "start": {
        "see.effort": "Head_Effort",
        "visibility.score": 0.0,
        "posture": "Sitting",
        "hands": {"left": "Free_of_Object", "right": None},
    },
    "end": {
        "see.effort": "No_Effort_Required",
        "visibility.score": 0.02,
        "posture": "Sitting",
        "motion": {"value": "Static", "evidence": {"speed_m_s": 0.01}},
    },
}
EVERY = 15
"""Of so many frames of the shipped recording one is kept: what is read sooner is fuzzed more often."""


def _excerpt(path: Path, folder: Path) -> bytes:
    whole = read(path)
    part = dataclasses.replace(
        whole,
        times_s=whole.times_s[::EVERY],
        qpos=whole.qpos[::EVERY],
        tracked={name: flags[::EVERY] for name, flags in whole.tracked.items()},
    )
    write(part, folder / path.name)
    return (folder / path.name).read_bytes()


def _knowledge(recording: Path, path: Path) -> bytes:
    save(Knowledge().add(explain_recording(read(recording))), path)
    return path.read_bytes()


def _pool(folder: Path) -> bytes:
    explanation = explain_recording(read(shipped_study()["show"][0]), predicates=())
    samples = [
        dataclasses.replace(Sample.of(explanation, NODES, number=number, condition=CLEAN, means="x"), task=task)
        for task in SOURCES["generator"].tasks
        for number in range(3)
    ]
    write_pool(empty_pool("generator", 1).with_more(samples), folder / "pool.json.gz")
    return (folder / "pool.json.gz").read_bytes()


def _displacements(folder: Path) -> bytes:
    outcomes = tuple("Static" for _ in NODES)
    displaced = Displacements("study", Context.of(), {"show": ((outcomes, "show_b: no place"),)})
    write_displacements(displaced, folder / "moved.json.gz")
    return (folder / "moved.json.gz").read_bytes()


def _maps(folder: Path, rooms: Mapping[str, bytes]) -> bytes:
    for name, content in rooms.items():
        (folder / name).write_bytes(content)
    stage = Stage(Scene.load(folder / "room.toml"))
    grid = Grid((-0.3, -0.3, 0.7), 0.0, 0.1, (4, 4, 4))
    stream = io.BytesIO()
    write_maps(stream, [ability_map(stage, "P1", "reach", grid=grid)])
    return stream.getvalue()
