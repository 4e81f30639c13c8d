"""Scene files as values: the models of a room, the agents placed in it, and the TOML document that says both.

``parse_scene_file`` reads a document (``world/scene.py`` shows one), ``write_scene_file`` writes it; what one
writes, the other reads as the same value.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import tomli_w

from taskgist.common.text import clean_name
from taskgist.common.toml import TomlTable
from taskgist.settings import DEFAULT, Limits
from taskgist.world.bodies.profile import Posture, read_posture

SCENE_KEYS = {"name", "model", "keyframe", "objects", "leave_out", "estimated", "seen_groups"}
AGENT_KEYS = {
    "profile",
    "room_body",
    "room_prefix",
    "position_m",
    "yaw_deg",
    "posture",
    "seat_height_m",
    "body",
    "joints_deg",
    "joints_m",
}
POSE_KEYS = {"position_m", "yaw_deg", "rpy_deg"}
MODEL_KEYS = {"model"} | POSE_KEYS
OBJECT_KEYS = {"mesh", "scale", "mass_kg"} | MODEL_KEYS
SEAT_HEIGHTS_M = (0.0, 1.5)
LEAST_SCALE, LEAST_MASS_KG = 1e-6, 1e-6
GROUPS = tuple(range(6))
"""MuJoCo's geom groups."""
DECIMALS = 9
"""Decimals of written numbers: nanometres, and billionths of a degree."""


@dataclass(frozen=True)
class AgentEntry:
    """An agent as a scene places it: one ``[agents.NAME]`` table.

    Attributes:
        name: Its name.
        profile: A built-in profile, or the file of your own (.toml).
        position_m: Floor point beneath the pelvis (or base), (2,). Where it is not given: the origin, or None for a
            body of the room, which stands where the room's model has it.
        yaw_rad: Heading; 0 looks along x. Where it is not given: 0, or None for a body of the room likewise.
        posture: Sitting (on the seat that is found beneath) or standing.
        seat_height_m: Height of the seat, where none is modelled.
        body: Sizes of a body that is made to measure, such as ``stature_m``.
        joints_rad: Angles of joints that turn, by name.
        joints_m: Positions of joints that slide, by name.
        room_body: The body of the room's model that it is, with all that it carries; None: its profile's own model.
        room_prefix: What its names begin with in the room's model, and do not in the profile.
    """

    name: str
    profile: str = "human"
    position_m: tuple[float, float] | None = None
    yaw_rad: float | None = None
    posture: Posture = "standing"
    seat_height_m: float | None = None
    body: Mapping[str, float] = field(default_factory=dict)
    joints_rad: Mapping[str, float] = field(default_factory=dict)
    joints_m: Mapping[str, float] = field(default_factory=dict)
    room_body: str | None = None
    room_prefix: str = ""

    def __post_init__(self) -> None:
        if self.room_body is None and self.position_m is None:
            object.__setattr__(self, "position_m", (0.0, 0.0))
        if self.room_body is None and self.yaw_rad is None:
            object.__setattr__(self, "yaw_rad", 0.0)

    @property
    def profile_key(self) -> str:
        """Name in the bundle of the profile's TOML."""
        return f"{self.name}.profile.toml"

    @property
    def model_key(self) -> str:
        """Name in the bundle of the profile's model."""
        return f"{self.name}.model.xml"


Kind = Literal["furniture", "object"]


@dataclass(frozen=True)
class PlacedModel:
    """A model that a scene puts into its room: one ``[furniture.NAME]`` or ``[objects.NAME]`` table.

    Attributes:
        name: What it is called in the scene.
        kind: Whether it stands where it is, or moves freely.
        file: MJCF or URDF; of an object maybe a mesh.
        position_m: Where the model's origin is, metres, (3,).
        rpy_rad: How it is turned there: roll, pitch and yaw, as in URDF.
        is_mesh: Whether the file is a mesh.
        scale: By what the mesh's numbers are multiplied to be metres.
        mass_kg: What the mesh weighs; None: as much as water of its hull's volume.
    """

    name: str
    kind: Kind
    file: str
    position_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rpy_rad: tuple[float, float, float] = (0.0, 0.0, 0.0)
    is_mesh: bool = False
    scale: float = 1.0
    mass_kg: float | None = None

    @property
    def key(self) -> str:
        """Name in the bundle of its model."""
        return f"{self.name}.{self.kind}.xml"

    @property
    def table(self) -> str:
        """Its table in the scene file."""
        return f"{'objects' if self.kind == 'object' else 'furniture'}.{self.name}"


@dataclass(frozen=True)
class SceneFile:
    """A scene file.

    Attributes:
        name: Name for people.
        model: File of the room's model; None: there is a floor.
        objects: The bodies of the room's model that are objects; None: every free body.
        estimated: Bodies whose place or shape nobody measured.
        agents: Who is there.
        where: The file, for messages.
        seen_groups: The model's geom groups that are seen; None: 0, 1 and 2, without coarse shapes for collisions.
        keyframe: The key of the room's model by which its objects lie and its doors stand; None: as its bodies are.
        leave_out: Bodies of the room's model that are left out, with all that they carry.
        placed: Furniture and objects that are models of their own.
    """

    name: str
    model: str | None
    objects: tuple[str, ...] | None
    estimated: tuple[str, ...]
    agents: tuple[AgentEntry, ...]
    where: str = field(compare=False)
    seen_groups: tuple[int, ...] | None = None
    keyframe: str | None = None
    leave_out: tuple[str, ...] = ()
    placed: tuple[PlacedModel, ...] = ()

    def takes(self, free_body: str) -> bool:
        """Whether a body that moves freely is one of the scene's objects."""
        return self.objects is None or free_body in self.objects or self.placed_object(free_body) is not None

    def placed_object(self, name: str) -> PlacedModel | None:
        """The object of that name that is a model of its own."""
        return next((each for each in self.placed if each.kind == "object" and each.name == name), None)

    def field_of_model(self, name: str) -> str:
        """The field that gives an object's model, for messages."""
        each = self.placed_object(name)
        return f"scene.model {self.model!r}" if each is None else f"{each.table} {each.file!r}"


def parse_scene_file(text: bytes | str, *, where: str, limits: Limits = DEFAULT.limits) -> SceneFile:
    """Read a scene file's text.

    Raises:
        SceneError: Not TOML, too large, or a field is missing, unknown or has a value that cannot be.
    """
    document = TomlTable.parse(text, where, most_bytes=limits.toml_bytes)
    document.only({"scene", "agents", "furniture", "objects"})
    scene = document.table("scene").only(SCENE_KEYS)
    agents, furniture, objects = (document.table(key) for key in ("agents", "furniture", "objects"))
    _check_apart(furniture, objects, agents)
    placed = [_placed(name, "furniture", furniture.table(name).only(MODEL_KEYS)) for name in furniture]
    placed += [_placed(name, "object", objects.table(name).only(OBJECT_KEYS)) for name in objects]
    entries = tuple(_agent(name, agents.table(name).only(AGENT_KEYS)) for name in agents)
    model = scene.text("model") if "model" in scene or not placed else None
    if model in {each.key for each in placed} | {entry.model_key for entry in entries}:
        hint = "call the file otherwise"
        raise scene.error("is what a recording calls the model of something else", "model", model, hint)
    return SceneFile(
        name=scene.name("name", clean_name(Path(where).stem) or "scene"),
        model=model,
        objects=scene.texts("objects") if "objects" in scene else None,
        estimated=scene.texts("estimated"),
        agents=entries,
        where=where,
        seen_groups=_checked_groups(scene) if "seen_groups" in scene else None,
        keyframe=scene.text("keyframe", None),
        leave_out=scene.texts("leave_out"),
        placed=tuple(placed),
    )


def _checked_groups(scene: TomlTable) -> tuple[int, ...]:
    groups = scene.any("seen_groups")
    known = isinstance(groups, list) and all(type(group) is int and group in GROUPS for group in groups)
    if not groups or not known:
        raise scene.error("must be a list of geom groups", "seen_groups", groups, "each from 0 to 5, as [0, 1, 2]")
    return tuple(groups)


def _check_apart(*tables: TomlTable) -> None:
    """Refuse names that hold a slash, by which parts are named, and names that two tables share."""
    taken: dict[str, str] = {}
    for table, name in [(each, name) for each in tables for name in each]:
        if "/" in name or not name:
            kind = {"agents": "an agent", "objects": "an object"}.get(table.path, "furniture")
            raise table.error(f"not a name for {kind}", name, hint="leave out the slash")
        if name in taken:
            raise table.error(f"is the name of {taken[name]}, too", name, hint="give each its own")
        taken[name] = table.path_of(name)


def _placed(name: str, kind: Kind, entry: TomlTable) -> PlacedModel:
    is_mesh = "mesh" in entry
    if is_mesh and "model" in entry:
        raise entry.error("has a mesh and a model", hint="give one of both")
    if not is_mesh and (key := next((key for key in ("scale", "mass_kg") if key in entry), None)):
        raise entry.error("is for a mesh", key, entry.any(key), "leave it out: a model says so itself")
    yaw_deg = entry.number("yaw_deg", 0.0)
    if "rpy_deg" in entry and "yaw_deg" in entry:
        raise entry.error(
            "is turned twice", "rpy_deg", entry.any("rpy_deg"), "leave out yaw_deg, the last of the three"
        )
    roll, pitch, yaw = (math.radians(angle) for angle in entry.triple("rpy_deg", (0.0, 0.0, yaw_deg)))
    return PlacedModel(
        name=name,
        kind=kind,
        file=entry.text("mesh" if is_mesh else "model"),
        position_m=entry.triple("position_m", (0.0, 0.0, 0.0)),
        rpy_rad=(roll, pitch, yaw),
        is_mesh=is_mesh,
        scale=entry.number("scale", 1.0, least=LEAST_SCALE),
        mass_kg=entry.number("mass_kg", None, least=LEAST_MASS_KG),
    )


def _agent(name: str, entry: TomlTable) -> AgentEntry:
    body, joints, slides = entry.table("body"), entry.table("joints_deg"), entry.table("joints_m")
    return AgentEntry(
        name=name,
        profile=entry.text("profile", "human"),
        position_m=entry.pair("position_m") if "position_m" in entry else None,
        yaw_rad=math.radians(entry.number("yaw_deg")) if "yaw_deg" in entry else None,
        posture=read_posture(entry.text("posture", "standing"), where=f"{entry.place}"),
        seat_height_m=_checked_seat_height(entry) if "seat_height_m" in entry else None,
        body={key: body.number(key) for key in body},
        joints_rad={key: math.radians(joints.number(key)) for key in joints},
        joints_m={key: slides.number(key) for key in slides},
        room_body=entry.text("room_body", None),
        room_prefix=_checked_prefix(entry) if "room_prefix" in entry else "",
    )


def _checked_prefix(entry: TomlTable) -> str:
    if "room_body" not in entry:
        hint = "name the body of the room's model that this agent is, as room_body"
        raise entry.error("is of names in the room's model", "room_prefix", entry.any("room_prefix"), hint)
    return entry.text("room_prefix")


def _checked_seat_height(entry: TomlTable) -> float:
    height = entry.number("seat_height_m")
    if not SEAT_HEIGHTS_M[0] <= height <= SEAT_HEIGHTS_M[1]:
        hint = f"between {SEAT_HEIGHTS_M[0]} and {SEAT_HEIGHTS_M[1]} m over the floor"
        raise entry.error("nobody sits at that height", "seat_height_m", height, hint)
    return height


def write_scene_file(file: SceneFile) -> bytes:
    """A scene file's text, in UTF-8. Numbers are rounded to ``DECIMALS``; empty tables are left out."""
    scene: dict[str, Any] = {"name": file.name}
    texts = {"model": file.model, "keyframe": file.keyframe}
    scene |= {key: text for key, text in texts.items() if text is not None}
    if file.objects is not None:
        scene["objects"] = list(file.objects)
    lists = {"leave_out": file.leave_out, "estimated": file.estimated}
    scene |= {key: list(names) for key, names in lists.items() if names}
    if file.seen_groups is not None:
        scene["seen_groups"] = list(file.seen_groups)
    tables = {
        "furniture": {each.name: _placed_table(each) for each in file.placed if each.kind == "furniture"},
        "objects": {each.name: _placed_table(each) for each in file.placed if each.kind == "object"},
        "agents": {entry.name: _agent_table(entry) for entry in file.agents},
    }
    return tomli_w.dumps({"scene": scene} | {key: table for key, table in tables.items() if table}).encode()


def _placed_table(each: PlacedModel) -> dict[str, Any]:
    table: dict[str, Any] = {
        "mesh" if each.is_mesh else "model": each.file,
        "position_m": [_written(value) for value in each.position_m],
    }
    *tilt_deg, yaw_deg = (_written(math.degrees(angle)) for angle in each.rpy_rad)
    if any(tilt_deg):
        table["rpy_deg"] = [*tilt_deg, yaw_deg]
    else:
        table["yaw_deg"] = yaw_deg
    if each.is_mesh:
        table["scale"] = each.scale
    if each.mass_kg is not None:
        table["mass_kg"] = each.mass_kg
    return table


def _agent_table(entry: AgentEntry) -> dict[str, Any]:
    table: dict[str, Any] = {"profile": entry.profile}
    if entry.room_body is not None:
        table["room_body"] = entry.room_body
    if entry.room_prefix:
        table["room_prefix"] = entry.room_prefix
    if entry.position_m is not None:
        table["position_m"] = [_written(value) for value in entry.position_m]
    if entry.yaw_rad is not None:
        table["yaw_deg"] = _written(math.degrees(entry.yaw_rad))
    table["posture"] = entry.posture
    if entry.seat_height_m is not None:
        table["seat_height_m"] = _written(entry.seat_height_m)
    joints_deg = {joint: math.degrees(angle) for joint, angle in entry.joints_rad.items()}
    for key, numbers in (("body", entry.body), ("joints_deg", joints_deg), ("joints_m", entry.joints_m)):
        if numbers:
            table[key] = {name: _written(value) for name, value in numbers.items()}
    return table


def _written(value: float) -> float:
    return round(float(value), DECIMALS)
