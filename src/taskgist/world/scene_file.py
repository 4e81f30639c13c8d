"""Scene files: the TOML document that names a scene, and the gathering of all files that it needs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import mujoco

from taskgist.errors import SceneError, UnknownNameError
from taskgist.world.profile import Posture, builtin_profile_text, builtin_profiles, parse_profile, read_posture
from taskgist.world.toml_table import TomlTable

SCENE_KEYS = {"name", "model", "objects", "estimated"}
AGENT_KEYS = {"profile", "position_m", "yaw_deg", "posture", "seat_height_m", "body", "joints_deg"}
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
    body, joints = entry.table("body"), entry.table("joints_deg")
    return AgentEntry(
        name=name,
        profile=entry.text("profile", "human"),
        position_m=entry.pair("position_m", (0.0, 0.0)),
        yaw_rad=math.radians(entry.number("yaw_deg", 0.0)),
        posture=read_posture(entry.text("posture", "standing"), where=f"{entry.where}: {entry.path}"),
        seat_height_m=_seat_height(entry) if "seat_height_m" in entry else None,
        body={key: body.number(key) for key in body},
        joints_rad={key: math.radians(joints.number(key)) for key in joints},
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
    text = _read(path, None)
    file = parse_scene_file(text, where=str(path))
    bundle = {"scene.toml": text}
    bundle |= _model_files(path.parent / file.model, file.model, "", where=str(path), field="scene.model")
    for agent in file.agents:
        bundle |= _profile_files(agent, path)
    return bundle


def _profile_files(agent: AgentEntry, scene_path: Path) -> dict[str, bytes]:
    if agent.profile in builtin_profiles():
        return {agent.profile_key: builtin_profile_text(agent.profile).encode()}
    profile_path = scene_path.parent / agent.profile
    if profile_path.suffix != ".toml":
        raise UnknownNameError("profile", agent.profile, builtin_profiles(), where=f"{scene_path}: agents.{agent.name}")
    field = f"agents.{agent.name}.profile"
    text = _read(profile_path, f"{scene_path}: {field}")
    profile = parse_profile(text, where=profile_path, stature_m=agent.body.get(STATURE))
    if profile.model in builtin_profiles():
        return {agent.profile_key: text}
    model_path = profile_path.parent / profile.model
    files = _model_files(model_path, agent.model_key, f"{agent.name}_", where=str(profile_path), field="model")
    return {agent.profile_key: text, **files}


def _model_files(path: Path, key: str, prefix: str, *, where: str, field: str) -> dict[str, bytes]:
    """A model as one flat XML document under ``key``, and its meshes under their bare names."""
    if not path.is_file():
        raise SceneError(
            "no such file", where=where, field=field, value=str(path), hint="paths are relative to the file"
        )
    try:
        spec = mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise SceneError(f"MuJoCo cannot read this model: {error}", where=path) from error
    files: dict[str, bytes] = {}
    for meshes, folder in ((spec.meshes, spec.meshdir), (spec.textures, spec.texturedir)):
        for asset in meshes:
            if asset.file:
                source = path.parent / folder / asset.file
                asset.file = prefix + asset.file.replace("/", "_")
                files[asset.file] = _read(source, str(path))
    spec.meshdir = spec.texturedir = ""
    files[key] = _xml(spec, files, path)
    return files


def _xml(spec: mujoco.MjSpec, files: Mapping[str, bytes], path: Path) -> bytes:
    spec.assets = dict(files)
    try:
        return str(spec.to_xml()).encode()
    except ValueError as error:
        raise SceneError(f"MuJoCo cannot read this model: {error}", where=path) from error


def _read(path: Path, named_by: str | None) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        hint = f"named by {named_by}" if named_by else "check the path"
        raise SceneError(f"cannot be read: {error.strerror}", where=path, hint=hint) from error
