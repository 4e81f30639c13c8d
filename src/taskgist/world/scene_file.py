"""Scene files as values: the model of a room, the agents placed in it, and the TOML document that says both.

``parse_scene_file`` reads a document (``world/scene.py`` shows one), ``write_scene_file`` writes it; what one
writes, the other reads as the same value.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import tomli_w

from taskgist.common.text import clean_name
from taskgist.common.toml import TomlTable
from taskgist.errors import SceneError
from taskgist.settings import DEFAULT, Limits
from taskgist.world.bodies.profile import Posture, read_posture

SCENE_KEYS = {"name", "model", "objects", "estimated", "seen_groups"}
AGENT_KEYS = {"profile", "position_m", "yaw_deg", "posture", "seat_height_m", "body", "joints_deg", "joints_m"}
SEAT_HEIGHTS_M = (0.0, 1.5)
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
        position_m: Floor point beneath the pelvis (or base), (2,).
        yaw_rad: Heading; 0 looks along x.
        posture: Sitting (on the seat that is found beneath) or standing.
        seat_height_m: Height of the seat, where none is modelled.
        body: Sizes of a body that is made to measure, such as ``stature_m``.
        joints_rad: Angles of joints that turn, by name.
        joints_m: Positions of joints that slide, by name.
    """

    name: str
    profile: str = "human"
    position_m: tuple[float, float] = (0.0, 0.0)
    yaw_rad: float = 0.0
    posture: Posture = "standing"
    seat_height_m: float | None = None
    body: Mapping[str, float] = field(default_factory=dict)
    joints_rad: Mapping[str, float] = field(default_factory=dict)
    joints_m: Mapping[str, float] = field(default_factory=dict)

    @property
    def profile_key(self) -> str:
        """Name in the bundle of the profile's TOML."""
        return f"{self.name}.profile.toml"

    @property
    def model_key(self) -> str:
        """Name in the bundle of the profile's model."""
        return f"{self.name}.model.xml"


@dataclass(frozen=True)
class SceneFile:
    """A scene file.

    Attributes:
        name: Name for people.
        model: File of the room's model.
        objects: The bodies that are objects; None: every free body.
        estimated: Bodies whose place or shape nobody measured.
        agents: Who is there.
        where: The file, for messages.
        seen_groups: The model's geom groups that are seen; None: 0, 1 and 2, without coarse shapes for collisions.
    """

    name: str
    model: str
    objects: tuple[str, ...] | None
    estimated: tuple[str, ...]
    agents: tuple[AgentEntry, ...]
    where: str = field(compare=False)
    seen_groups: tuple[int, ...] | None = None


def parse_scene_file(text: bytes | str, *, where: str, limits: Limits = DEFAULT.limits) -> SceneFile:
    """Read a scene file's text.

    Raises:
        SceneError: Not TOML, too large, or a field is missing, unknown or has a value that cannot be.
    """
    document = TomlTable.parse(text, where, most_bytes=limits.toml_bytes).only({"scene", "agents"})
    scene = document.table("scene").only(SCENE_KEYS)
    agents = document.table("agents")
    return SceneFile(
        name=scene.name("name", clean_name(Path(where).stem) or "scene"),
        model=scene.text("model"),
        objects=scene.texts("objects") if "objects" in scene else None,
        estimated=scene.texts("estimated"),
        agents=tuple(_agent(name, agents.table(name).only(AGENT_KEYS)) for name in agents),
        where=where,
        seen_groups=_checked_groups(scene) if "seen_groups" in scene else None,
    )


def _checked_groups(scene: TomlTable) -> tuple[int, ...]:
    groups = scene.any("seen_groups")
    known = isinstance(groups, list) and all(type(group) is int and group in GROUPS for group in groups)
    if not groups or not known:
        raise scene.error("must be a list of geom groups", "seen_groups", groups, "each from 0 to 5, as [0, 1, 2]")
    return tuple(groups)


def _agent(name: str, entry: TomlTable) -> AgentEntry:
    if "/" in name or not name:
        raise SceneError(
            "not a name for an agent", where=entry.document.where, field=entry.path, hint="leave out the slash"
        )
    body, joints, slides = entry.table("body"), entry.table("joints_deg"), entry.table("joints_m")
    return AgentEntry(
        name=name,
        profile=entry.text("profile", "human"),
        position_m=entry.pair("position_m", (0.0, 0.0)),
        yaw_rad=math.radians(entry.number("yaw_deg", 0.0)),
        posture=read_posture(entry.text("posture", "standing"), where=f"{entry.place}"),
        seat_height_m=_checked_seat_height(entry) if "seat_height_m" in entry else None,
        body={key: body.number(key) for key in body},
        joints_rad={key: math.radians(joints.number(key)) for key in joints},
        joints_m={key: slides.number(key) for key in slides},
    )


def _checked_seat_height(entry: TomlTable) -> float:
    height = entry.number("seat_height_m")
    if not SEAT_HEIGHTS_M[0] <= height <= SEAT_HEIGHTS_M[1]:
        hint = f"between {SEAT_HEIGHTS_M[0]} and {SEAT_HEIGHTS_M[1]} m over the floor"
        raise entry.error("nobody sits at that height", "seat_height_m", height, hint)
    return height


def write_scene_file(file: SceneFile) -> bytes:
    """A scene file's text, in UTF-8. Numbers are rounded to ``DECIMALS``; empty tables are left out."""
    scene: dict[str, Any] = {"name": file.name, "model": file.model}
    if file.objects is not None:
        scene["objects"] = list(file.objects)
    if file.estimated:
        scene["estimated"] = list(file.estimated)
    if file.seen_groups is not None:
        scene["seen_groups"] = list(file.seen_groups)
    agents = {entry.name: _agent_table(entry) for entry in file.agents}
    return tomli_w.dumps({"scene": scene, "agents": agents} if agents else {"scene": scene}).encode()


def _agent_table(entry: AgentEntry) -> dict[str, Any]:
    table: dict[str, Any] = {
        "profile": entry.profile,
        "position_m": [_written(value) for value in entry.position_m],
        "yaw_deg": _written(math.degrees(entry.yaw_rad)),
        "posture": entry.posture,
    }
    if entry.seat_height_m is not None:
        table["seat_height_m"] = _written(entry.seat_height_m)
    joints_deg = {joint: math.degrees(angle) for joint, angle in entry.joints_rad.items()}
    for key, numbers in (("body", entry.body), ("joints_deg", joints_deg), ("joints_m", entry.joints_m)):
        if numbers:
            table[key] = {name: _written(value) for name, value in numbers.items()}
    return table


def _written(value: float) -> float:
    return round(float(value), DECIMALS)
