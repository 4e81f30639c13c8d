"""Scene files: the TOML document that names a scene, and the gathering of all files that it needs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from taskgist.errors import SceneError, UnknownNameError
from taskgist.world.body.model_files import body_files, model_files, read_file, read_model
from taskgist.world.body.named import name_problems
from taskgist.world.body.packages import find_file
from taskgist.world.body.profile import Posture, builtin_profile_text, builtin_profiles
from taskgist.world.body.profile_fields import read_posture
from taskgist.world.body.profile_file import parse_profile
from taskgist.world.toml_table import TomlTable

SCENE_KEYS = {"name", "model", "objects", "estimated"}
AGENT_KEYS = {"profile", "position_m", "yaw_deg", "posture", "seat_height_m", "body", "joints_deg", "joints_m"}
SEAT_HEIGHTS_M = (0.0, 1.5)
STATURE = "stature_m"
DEFAULT_STATURE_M = 1.75


@dataclass(frozen=True)
class AgentEntry:
    """One ``[agents.NAME]`` table."""

    name: str
    profile: str
    position_m: tuple[float, float]
    yaw_rad: float
    posture: Posture
    seat_height_m: float | None
    body: Mapping[str, float]
    joints_rad: Mapping[str, float]
    joints_m: Mapping[str, float]

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
    """A parsed scene file."""

    name: str
    model: str
    objects: tuple[str, ...] | None
    estimated: tuple[str, ...]
    agents: tuple[AgentEntry, ...]
    where: str = field(compare=False)


def parse_scene_file(text: bytes | str, *, where: str) -> SceneFile:
    """Read a scene file's text.

    Raises:
        SceneError: Not TOML, or a field is missing, unknown or has a value that cannot be.
    """
    document = TomlTable.parse(text, where).only({"scene", "agents"})
    scene = document.table("scene").only(SCENE_KEYS)
    agents = document.table("agents")
    return SceneFile(
        name=scene.text("name", Path(where).stem),
        model=scene.text("model"),
        objects=scene.names("objects") if "objects" in scene else None,
        estimated=scene.names("estimated"),
        agents=tuple(_agent(name, agents.table(name).only(AGENT_KEYS)) for name in agents),
        where=where,
    )


def _agent(name: str, entry: TomlTable) -> AgentEntry:
    if "/" in name or not name:
        raise SceneError("not a name for an agent", where=entry.where, field=entry.path, hint="leave out the slash")
    body, joints, slides = entry.table("body"), entry.table("joints_deg"), entry.table("joints_m")
    return AgentEntry(
        name=name,
        profile=entry.text("profile", "human"),
        position_m=entry.pair("position_m", (0.0, 0.0)),
        yaw_rad=math.radians(entry.number("yaw_deg", 0.0)),
        posture=read_posture(entry.text("posture", "standing"), where=f"{entry.where}: {entry.path}"),
        seat_height_m=_seat_height(entry) if "seat_height_m" in entry else None,
        body={key: body.number(key) for key in body},
        joints_rad={key: math.radians(joints.number(key)) for key in joints},
        joints_m={key: slides.number(key) for key in slides},
    )


def _seat_height(entry: TomlTable) -> float:
    height = entry.number("seat_height_m")
    if not SEAT_HEIGHTS_M[0] <= height <= SEAT_HEIGHTS_M[1]:
        hint = f"between {SEAT_HEIGHTS_M[0]} and {SEAT_HEIGHTS_M[1]} m over the floor"
        raise entry.error("nobody sits at that height", "seat_height_m", height, hint)
    return height


def bundle_from_path(path: Path) -> dict[str, bytes]:
    """Gather a scene file and everything that it needs into memory.

    Args:
        path: The scene's TOML file.

    Returns:
        File contents by the names that ``parse_scene_file`` and ``assemble`` look for.

    Raises:
        SceneError: A file is missing or is no model.
    """
    text = read_file(path)
    file = parse_scene_file(text, where=str(path))
    bundle = {"scene.toml": text}
    model = find_file(file.model, near=path.parent, where=path, field="scene.model")
    bundle |= model_files(model, file.model, room=True)
    for agent in file.agents:
        bundle |= _profile_files(agent, path)
    return bundle


def _profile_files(agent: AgentEntry, scene_path: Path) -> dict[str, bytes]:
    prefix = f"{agent.name}_"
    if agent.profile in builtin_profiles():
        text, folder, where = builtin_profile_text(agent.profile).encode(), None, f"profile {agent.profile}"
    else:
        path = scene_path.parent / agent.profile
        field = f"{scene_path}: agents.{agent.name}"
        if path.suffix != ".toml":
            raise UnknownNameError("profile", agent.profile, builtin_profiles(), where=field)
        text, folder, where = read_file(path, named_by=f"{field}.profile"), path.parent, str(path)
    profile = parse_profile(text, where=where, stature_m=agent.body.get(STATURE))
    files = body_files(profile, agent.model_key, prefix=prefix, folder=folder, where=where)
    if folder is not None and files:  # here, where the file's own name is known
        spec = read_model(files, agent.model_key, where=where, room=False)
        for problem in name_problems(spec, profile, where):
            raise problem
    return {agent.profile_key: text, **files}
