"""What the fuzzer starts from: small inputs of every kind that are right, and the commands that read them.

Rooms are in ``fuzz_rooms``, tables are written out here; recordings, knowledge, pools and maps are made by the code
that is fuzzed.
"""

from __future__ import annotations

import dataclasses
import io
import json
import sqlite3
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.writer import Writer

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
from tools.fuzz_checks import Check, others_records, own_files
from tools.fuzz_mutations import copied
from tools.fuzz_rooms import bracket, obj, prism, rooms, stl
from tools.fuzz_takes import matlab, takes

Command = tuple[str, ...]
"""Arguments of ``taskgist``; or ``read-maps``, ``read-pool``, ``read-displacements`` and a file."""


@dataclass(frozen=True)
class Seed:
    """Files that are right, and what is done with them.

    Attributes:
        kind: What is fuzzed.
        files: All files of the folder in which the commands run, by path.
        mutated: Those that are spoiled; for names, the names.
        commands: One of these is run.
        written: Files that a command may change or make.
        check: What is asked of a command that succeeds.
    """

    kind: str
    files: Mapping[str, bytes]
    mutated: tuple[str, ...]
    commands: tuple[Command, ...]
    written: tuple[str, ...] = ()
    check: Check | None = None


def seeds(folder: Path) -> tuple[Seed, ...]:
    """All seeds.

    Args:
        folder: An empty one, for files that are made by writing them.
    """
    return (*_room_seeds(), *_table_seeds(), *_own_seeds(folder), *_mixed_seeds(folder))


# --- Rooms: scenes, models, profiles, meshes.

ASK_CUP: Command = ("query", "room.toml", "--agent", "P1", "--object", "cup", "--ability", "reach")
ASK_MUG: Command = ("query", "room.toml", "--agent", "P1", "--object", "mug", "--ability", "see", "--json")
ASK_BOX: Command = ("query", "room.toml", "--agent", "R", "--object", "box", "--ability", "grasp")
ASK_WHY: Command = ("query", "room.toml", "--agent", "R", "--object", "cup", "--ability", "see", "--why")
ASKED: tuple[Command, ...] = (ASK_CUP, ASK_MUG, ASK_BOX, ASK_WHY)
IN_URDF: tuple[Command, ...] = tuple(
    ("query", "urdf.toml", "--agent", agent, "--object", "vase", "--ability", "see") for agent in ("P1", "J")
)
IN_CROWDED: tuple[Command, ...] = (
    ("query", "urdf.toml", "--agent", "R", "--object", "first", "--ability", "see"),
    ("query", "urdf.toml", "--agent", "P1", "--object", "second", "--ability", "reach", "--json"),
)
IN_MANY: tuple[Command, ...] = (
    ("query", "many.toml", "--agent", "R", "--object", "cup", "--ability", "see"),
    ("query", "many.toml", "--agent", "P1", "--object", "bracket", "--ability", "reach", "--json"),
)
IN_COMPOSED: tuple[Command, ...] = (
    ("query", "room.toml", "--agent", "R", "--object", "mug", "--ability", "see"),
    ("query", "room.toml", "--agent", "P1", "--object", "stone", "--ability", "reach", "--json"),
    ("query", "room.toml", "--agent", "P1", "--object", "tray", "--ability", "see"),
)
IN_FLAT: tuple[Command, ...] = (
    ("query", "flat.toml", "--agent", "P1", "--object", "cup", "--ability", "see"),
    ("query", "flat.toml", "--agent", "P1", "--object", "cloth", "--ability", "reach", "--json"),
)
CHECK_ROBOT: Command = ("agent", "check", "robot.toml")
CHECK_ARM: Command = ("agent", "check", "arm.toml")
DRAFTED: tuple[Command, ...] = (
    CHECK_ARM,
    ("agent", "draft", "arm.xml", "-o", "new.toml"),
    ("agent", "draft", "arm.urdf", "-o", "new.toml", "--json"),
)


def _room_seeds() -> tuple[Seed, ...]:
    room = rooms()
    plain, urdf, crowded, many = room["plain"], room["urdf"], room["crowded"], room["many"]
    hollow = {**plain, "mug.obj": obj(bracket())}
    composed = room["composed"]
    composed_models = tuple(name for name in composed if name.endswith((".xml", ".urdf")))
    composed_meshes = tuple(name for name in composed if name.endswith((".obj", ".stl")))
    crowded_meshes = tuple(name for name in crowded if name.endswith((".stl", ".dae")))
    many_files = tuple(name for name in many if name.endswith((".obj", ".stl", ".png")))
    return (
        Seed("scene", plain, ("room.toml",), ASKED),
        Seed("model", plain, ("room.xml",), ASKED),
        Seed("model", plain, ("robot.xml",), (CHECK_ROBOT, ASK_BOX)),
        Seed("model", many, ("many.xml", "many.xml", "lamp.xml"), IN_MANY, check=own_files),
        Seed("model", room["counted"], ("room.xml",), (ASK_CUP,)),
        Seed("urdf", urdf, ("room.urdf",), IN_URDF),
        Seed("urdf", crowded, ("room.urdf", "robot.urdf", "robot.toml", "urdf.toml"), IN_CROWDED, check=own_files),
        Seed("urdf", crowded, ("robot.urdf",), (CHECK_ROBOT,)),
        Seed("mesh", hollow, ("mug.obj",), (ASK_MUG,)),
        Seed("mesh", urdf, ("part.stl", "part.dae"), IN_URDF),
        Seed("mesh", crowded, crowded_meshes, IN_CROWDED, check=own_files),
        Seed("mesh", many, many_files, IN_MANY, check=own_files),
        Seed("flat", room["flat"], ("square.obj", "poster.stl", "ball.ply"), IN_FLAT),
        Seed("flat", room["flat"], ("flat.xml", "robot.urdf", "a/m.stl"), (*IN_FLAT, CHECK_ROBOT)),
        Seed("concave", hollow, ("room.xml", "room.toml"), (ASK_MUG,)),
        Seed("concave", room["concave"], ("part.stl", "part.dae", "room.urdf"), IN_URDF),
        Seed("profile", plain, ("robot.toml",), (CHECK_ROBOT, ASK_BOX, ASK_WHY)),
        Seed("composed", composed, ("room.toml",), IN_COMPOSED, check=own_files),
        Seed("composed", composed, composed_models, IN_COMPOSED, check=own_files),
        Seed("composed", composed, composed_meshes, IN_COMPOSED, check=own_files),
        Seed("draft", room["gripper"], ("arm.xml", "arm.urdf"), DRAFTED, ("new.toml",)),
        Seed("profile", room["gripper"], ("arm.toml",), (CHECK_ARM,)),
        Seed("name", plain, ("P1", "cup", "mug"), (ASK_CUP, ASK_MUG)),
        Seed("name", plain, ("R", "box", "table", "pan", "rh"), (ASK_BOX,)),
        Seed("name", crowded, ("R", "first", "second", "head"), IN_CROWDED, check=own_files),
        Seed("name", composed, ("R", "mug", "stone", "shelf", "cup", "r0_base", "home"), IN_COMPOSED, check=own_files),
    )


# --- Tables and mappings.

FROM_CSV: tuple[Command, ...] = (("import", "csv.toml", "-o", "out.mcap"),)
FROM_NPZ: tuple[Command, ...] = (("import", "npz.toml", "-o", "out.mcap", "--json"),)
FROM_ROS: tuple[Command, ...] = (("import", "ros.toml", "-o", "out.mcap"),)


def _table_seeds() -> tuple[Seed, ...]:
    tables, ros = _tables(), _ros_table()
    return (
        Seed("mapping", tables, ("csv.toml",), FROM_CSV, ("out.mcap",)),
        Seed("mapping", tables, ("npz.toml",), FROM_NPZ, ("out.mcap",)),
        Seed("mapping", ros, ("ros.toml",), FROM_ROS, ("out.mcap",)),
        Seed("table", tables, ("body.csv", "cup.tsv"), FROM_CSV, ("out.mcap",)),
        Seed("table", tables, ("data.npz", "cup.npy"), FROM_NPZ, ("out.mcap",)),
        Seed("table", ros, ("topics.csv",), FROM_ROS, ("out.mcap",)),
        Seed("table", matlab(), ("data.mat",), (("import", "mat.toml", "-o", "out.mcap"),), ("out.mcap",)),
        Seed("name", tables, ("P1", "P2", "cup", "ball", "table", "give", "grip", "body"), FROM_CSV, ("out.mcap",)),
        *(
            Seed("take", {name: data}, (name,), (("import", name, "-o", "out.mcap"),), ("out.mcap", "out.toml"))
            for name, data in takes().items()
        ),
    )


# --- What taskgist itself writes.

WATCHED: tuple[Command, ...] = (
    ("label", "show_a.mcap"),
    ("label", "show_a.mcap", "--task", "hide", "--json"),
    ("check", "show_a.mcap"),
    ("facts", "show_a.mcap", "--at", "1.5"),
    ("learn", "show_a.mcap", "-k", "new.db"),
    ("query", "show_a.mcap", "--agent", "P2", "--object", "cup", "--ability", "see", "--json"),
)
LABELLED: tuple[Command, ...] = (
    ("label", "show_a.mcap", "--task", "hide", "--json"),
    ("label", "show_a.mcap", "--start", "0.1", "--end", "2.5", "--task", "show", "--target", "P2", "--object", "cup"),
)
KNOWN: tuple[Command, ...] = (
    ("explain", "show", "-k", "knowledge.db"),
    ("explain", "-k", "knowledge.db", "--json"),
    ("learn", "facts.json", "-k", "knowledge.db"),
)
LEARN_FACTS: Command = ("learn", "facts.json", "-k", "new.db", "--json")


def _own_seeds(folder: Path) -> tuple[Seed, ...]:
    facts = {"facts.json": json.dumps(FACTS, indent=1).encode()}
    recorded = _recorded(folder)
    shared = {name: with_foreign_records(data) for name, data in recorded.items()}
    known = {"knowledge.db": _knowledge(folder / "show_a.mcap", folder / "knowledge.db"), **facts}
    first = {"knowledge.db": _of_first_schema(folder / "knowledge.db", folder / "first.db"), **facts}
    pool, displaced, maps = _pool(folder), _displacements(folder), _maps(folder)
    return (
        Seed("recording", recorded, ("show_a.mcap",), WATCHED, ("show_a.mcap", "new.db")),
        Seed("recording", shared, ("show_a.mcap",), LABELLED, ("show_a.mcap",), others_records),
        Seed("knowledge", known, ("knowledge.db",), KNOWN, ("knowledge.db",)),
        Seed("knowledge", first, ("knowledge.db",), KNOWN, ("knowledge.db",)),
        Seed("facts", facts, ("facts.json",), (LEARN_FACTS,), ("new.db",)),
        Seed("pool", {"pool.json.gz": pool}, ("pool.json.gz",), (("read-pool", "pool.json.gz"),)),
        Seed("pool", {"moved.json.gz": displaced}, ("moved.json.gz",), (("read-displacements", "moved.json.gz"),)),
        Seed("map", {"maps.npz": maps}, ("maps.npz",), (("read-maps", "maps.npz"),)),
        Seed("name", facts, ("show", "P1", "P2", "mug", "show-1"), (LEARN_FACTS,), ("new.db",)),
        Seed("name", known, ("show", "P1", "mug"), (KNOWN[0], KNOWN[2]), ("knowledge.db",)),
        Seed("name", shared, ("show", "P2", "cup"), LABELLED[1:], ("show_a.mcap",), others_records),
    )


# --- Arguments, and what is no regular file, with all of these.


def _mixed_seeds(folder: Path) -> tuple[Seed, ...]:
    plain, tables, recorded = rooms()["plain"], _tables(), _recorded(folder)
    facts = {"facts.json": json.dumps(FACTS, indent=1).encode()}
    known = {"knowledge.db": _knowledge(folder / "show_a.mcap", folder / "options.db"), **facts}
    return (
        Seed(
            "option",
            {**plain, **recorded, **tables, **known},
            (),
            (*ASKED, *WATCHED, *KNOWN, *FROM_CSV, *OPTIONS),
            ("show_a.mcap", "new.db", "knowledge.db", "out.mcap", "map.png", "map.npz", "eye.png"),
        ),
        Seed("path", plain, tuple(plain), (ASK_MUG, CHECK_ROBOT)),
        Seed("path", tables, tuple(tables), (*FROM_CSV, *FROM_NPZ), ("out.mcap",)),
        Seed("path", recorded, ("show_a.mcap",), WATCHED, ("show_a.mcap", "new.db")),
        Seed("path", known, ("knowledge.db", "facts.json"), KNOWN, ("knowledge.db",)),
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
skeleton = "mediapipe_pose"
[people.P1.points]
{_POINTS}
""" + _REST.format(second=1, cup="")


ROS_TOML = (
    CSV_TOML.replace("body.csv", "topics.csv")
    .replace('{ column = "stamp", unit = "ms" }', '{ column = "%time", unit = "ns" }', 1)
    .replace('units = "mm"', 'units = "m"\noffset_s = -1_700_000_000')
    .replace('"{person}_{point}_{axis}"', '"field.{person}.{point}.pose.position.{axis}"')
    .replace(
        '{ type = "cylinder", radius_m = 0.04, length_m = 0.10, axis = "z" }',
        '{ type = "mesh", file = "a/m.stl", units = "m" }, { type = "mesh", file = "a_m.stl", units = "m" }',
    )
)
UNUSED_COLUMNS = 300
"""Of a table of topics; a real one has some hundreds that nobody asks for."""


def _people() -> tuple[np.ndarray, np.ndarray]:
    """Times in seconds, (frames,), and points of two people, (frames, people, points, 3)."""
    times_s = np.arange(FRAMES) / RATE_HZ
    standing = np.array(list(LANDMARKS.values()))
    facing = standing * (-1.0, -1.0, 1.0)
    sway = 0.02 * np.sin(times_s)[:, None, None] * (1.0, 0.5, 0.0)
    return times_s, np.stack([standing - (0.7, 0.0, 0.0) + sway, facing + (0.7, 0.0, 0.0) - sway], axis=1)


def _tables() -> dict[str, bytes]:
    times_s, people = _people()
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


def _ros_table() -> dict[str, bytes]:
    """Two people in a table of topics: wide, in nanoseconds since 1970; and a cup of two meshes."""
    times_s, people = _people()
    points = [
        f"field.{p}.{n.upper()}.pose.position.{axis}" for p in ("one", "two") for n in LANDMARKS for axis in "xyz"
    ]
    header = ["%time", "field.header.seq", *points, *(f"field.covariance{i}" for i in range(UNUSED_COLUMNS))]
    rows = [
        [
            f"{1_700_000_000_000_000_000 + round(1e9 * t)}",
            str(i),
            *(f"{v:.4f}" for v in row.ravel()),
            *["0.0"] * UNUSED_COLUMNS,
        ]
        for i, (t, row) in enumerate(zip(times_s, people, strict=True))
    ]
    return {
        "ros.toml": ROS_TOML.encode(),
        "topics.csv": "\n".join(",".join(row) for row in [header, *rows]).encode(),
        "cup.tsv": _tables()["cup.tsv"],
        "a/m.stl": stl(prism(0.10)),
        "a_m.stl": stl(prism(0.12)),
    }


# --- What is made by the code that is fuzzed, or was by an earlier release.

FIRST_SCHEMA = Path(__file__).parents[1] / "tests/store/data/knowledge_0_1_0.db"
"""Knowledge of release 0.1.0."""


def _of_first_schema(present: Path, first: Path) -> bytes:
    """Present knowledge in the tables of release 0.1.0."""
    first.write_bytes(FIRST_SCHEMA.read_bytes())
    with closing(sqlite3.connect(first)) as connection, connection:
        connection.execute("ATTACH ? AS present", [str(present)])
        for table in ("taskgist_explanations", "taskgist_answers"):
            columns = ", ".join(row[1] for row in connection.execute(f"PRAGMA main.table_info({table})"))
            connection.execute(f"DELETE FROM main.{table}")
            connection.execute(f"INSERT INTO main.{table} ({columns}) SELECT {columns} FROM present.{table}")
    return first.read_bytes()


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


def _recorded(folder: Path) -> dict[str, bytes]:
    path = shipped_study()["show"][0]
    return {path.name: _excerpt(path, folder)}


def with_foreign_records(data: bytes) -> bytes:
    """A recording with channels, attachments and metadata of others."""

    def add(writer: Writer) -> None:
        writer.add_attachment(1, 1, "notes.txt", "text/plain", b"of the lab")
        writer.add_attachment(1, 1, "notes.txt", "text/plain", b"of the lab, too")
        writer.add_metadata("lab", {"room": "3", "scene": "\u0420\u0443\u043a\u0430"})
        writer.add_metadata("lab", {"room": "4"})
        schema = writer.register_schema("sensor_msgs/Image", "ros2msg", b"uint32 height")
        for number, topic in enumerate(("/camera/image", "/taskgist/of_others")):
            channel = writer.register_channel(topic, "cdr", schema)
            for index in range(3):
                writer.add_message(channel, 10**8 * index, bytes(range(100 + number)), 10**8 * index)

    return copied(data, add)


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


def _maps(folder: Path) -> bytes:
    for name, content in rooms()["plain"].items():
        (folder / name).write_bytes(content)
    stage = Stage(Scene.load(folder / "room.toml"))
    grid = Grid((-0.3, -0.3, 0.7), 0.0, 0.1, (4, 4, 4))
    stream = io.BytesIO()
    write_maps(stream, [ability_map(stage, "P1", "reach", grid=grid)])
    return stream.getvalue()
