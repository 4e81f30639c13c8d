"""Scene files: the TOML document that names a scene, and the gathering of all files that it needs."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mujoco

from taskgist.errors import SceneError, UnknownNameError
from taskgist.world.profile import POSTURES, Posture, builtin_profile_text, builtin_profiles, parse_profile

SCENE_KEYS = {"name", "model", "objects", "estimated"}
AGENT_KEYS = {"profile", "position_m", "yaw_deg", "posture", "seat_height_m", "body", "joints_deg"}
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


def parse_scene_file(text: str, *, where: str) -> SceneFile:
    """Read a scene file's text.

    Raises:
        SceneError: Not TOML, or a field is missing, unknown or has a value that cannot be.
    """
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"not valid TOML: {error}", where=where) from error
    scene = table.get("scene", {})
    _only(scene, SCENE_KEYS, "scene", where)
    if "model" not in scene:
        raise SceneError("missing", where=where, field="scene.model", hint="name the MJCF or URDF file of the room")
    agents = tuple(_agent(name, entry, where) for name, entry in table.get("agents", {}).items())
    objects = scene.get("objects")
    return SceneFile(
        name=str(scene.get("name", Path(where).stem)),
        model=str(scene["model"]),
        objects=None if objects is None else tuple(objects),
        estimated=tuple(scene.get("estimated", ())),
        agents=agents,
        where=where,
    )


def _agent(name: str, entry: Mapping[str, Any], where: str) -> AgentEntry:
    prefix = f"agents.{name}"
    _only(entry, AGENT_KEYS, prefix, where)
    if "/" in name:
        raise SceneError("an agent's name has no slash", where=where, field=prefix, value=name)
    position = entry.get("position_m", (0.0, 0.0))
    if len(position) != 2 or not all(_finite(v) for v in position):
        hint = "two numbers in metres: the floor point beneath the pelvis or base"
        raise SceneError("not a floor position", where=where, field=f"{prefix}.position_m", value=position, hint=hint)
    posture = entry.get("posture", "standing")
    if posture not in POSTURES:
        raise UnknownNameError("posture", str(posture), POSTURES, where=f"{where}: {prefix}")
    return AgentEntry(
        name=name,
        profile=str(entry.get("profile", "human")),
        position_m=(float(position[0]), float(position[1])),
        yaw_rad=math.radians(_number(entry, "yaw_deg", prefix, where)),
        posture=posture,
        seat_height_m=_number(entry, "seat_height_m", prefix, where) if "seat_height_m" in entry else None,
        body={key: _number(entry["body"], key, f"{prefix}.body", where) for key in entry.get("body", {})},
        joints_rad={
            key: math.radians(_number(entry["joints_deg"], key, f"{prefix}.joints_deg", where))
            for key in entry.get("joints_deg", {})
        },
    )


def _number(table: Mapping[str, Any], key: str, prefix: str, where: str) -> float:
    value = table.get(key, 0.0)
    if not _finite(value):
        raise SceneError("must be a finite number", where=where, field=f"{prefix}.{key}", value=value)
    return float(value)


def _finite(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _only(table: Mapping[str, Any], known: set[str], prefix: str, where: str) -> None:
    for key in table:
        if key not in known:
            raise UnknownNameError("field", key, known, where=f"{where}: [{prefix}]")


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
    file = parse_scene_file(text.decode("utf-8"), where=str(path))
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
    profile = parse_profile(text.decode("utf-8"), where=profile_path, stature_m=agent.body.get(STATURE))
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
