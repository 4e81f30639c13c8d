"""What a command that succeeds must have kept apart, or kept: looked at in the fork in which it ran.

A check is given the command before it runs, in the folder where it runs, and gives what is asked when it has ended
with 0 or 1: what is wrong, in a few words; nothing if all is as promised.
"""

from __future__ import annotations

import copy
import io
import tomllib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import mujoco
import numpy as np
from mcap.reader import make_reader
from numpy.typing import NDArray

from taskgist.world.bodies.model_files import builtin_models, find_file, is_urdf
from taskgist.world.geometry.convex import PART
from taskgist.world.geometry.pieces import SHEET_M
from taskgist.world.scene import Scene

Check = Callable[[tuple[str, ...]], Callable[[], str]]
Content = NDArray[np.float64]
TOLERANCE = 1.1 * SHEET_M
"""Numbers of a file are written anew, in a bundle and by MuJoCo, and what is flat gets a thickness."""


# --- Scenes: no file takes another's place.
#
# For MJCF the witness is MuJoCo, which reads the files itself, out of their folders. It reads no COLLADA, and calls a
# mesh of a URDF by its file: there each mesh is held against what it gives in a document of its own.


def own_files(command: tuple[str, ...]) -> Callable[[], str]:
    """Whether each mesh and height field of a scene is what its own file says."""

    def wrong() -> str:
        path = Path(next(word for word in command if word.endswith(".toml")))
        scene = Scene.load(path)
        for model in _models(path, scene):
            if at_fault := _wrong_file(scene.model, model):
                return f"another file in the place of {at_fault}"
        return ""

    return wrong


@dataclass(frozen=True)
class ModelFile:
    """A model of a scene that is a file.

    Attributes:
        path: Where it is.
        prefix: What its names begin with.
        root: The body that a URDF's root link is; None: that of its own name.
        collides_only: Whether only solids count.
        may_lack: Whether some of it may have been left out.
        scale: Of a mesh; None for models.
    """

    path: Path
    prefix: str = ""
    root: str | None = None
    collides_only: bool = False
    may_lack: bool = False
    scale: float | None = None


def _models(path: Path, scene: Scene) -> Iterator[ModelFile]:
    document = tomllib.loads(path.read_text("utf-8"))
    agents = document.get("agents", {})
    if room := document["scene"].get("model"):
        lacks = "leave_out" in document["scene"] or any("room_body" in entry for entry in agents.values())
        yield ModelFile(path.parent / room, root="world", may_lack=lacks)
    for kind in ("furniture", "objects"):
        for name, entry in document.get(kind, {}).items():
            scale = entry.get("scale", 1.0) if "mesh" in entry else None
            file = find_file(entry.get("mesh") or entry["model"], near=path.parent, where=path, field=kind)
            yield ModelFile(file, f"{name}/", name, scale=scale)
    for name, entry in zip(scene.agents, agents.values(), strict=True):
        given = entry.get("profile", "human")
        if given.endswith(".toml") and "room_body" not in entry:
            profile = tomllib.loads((path.parent / given).read_text("utf-8"))
            if profile["model"] not in builtin_models():
                model = find_file(profile["model"], near=(path.parent / given).parent, where=given, field="model")
                yield ModelFile(model, f"{name}/", collides_only=profile.get("shapes") == "collision")


def _wrong_file(whole: mujoco.MjModel, model: ModelFile) -> str:
    if model.scale is not None:
        own = model.scale * _alone(Element("mesh", filename=model.path.name), model.path)
        (there,) = _boxes(whole, str(model.root))
        return "" if np.allclose(own, there, atol=TOLERANCE) else f"mesh {model.path.name!r}"
    return _wrong_link(whole, model) if is_urdf(model.path.read_bytes()) else _wrong_asset(whole, model)


def _wrong_asset(whole: mujoco.MjModel, model: ModelFile) -> str:
    """The name of something that a room, a robot or a thing has of another file, or lacks."""
    try:
        alone = mujoco.MjModel.from_xml_path(str(model.path))
    except ValueError:  # what MuJoCo does not take from a folder, it is no witness of
        return ""
    found = _assets(whole)
    for (kind, name), content in _assets(alone).items():
        there = found.get((kind, model.prefix + name))
        if there is None and model.may_lack:
            continue
        if there is None or there.shape != content.shape or not np.allclose(there, content, atol=TOLERANCE):
            return f"{kind} {name!r}"
    return ""


def _assets(model: mujoco.MjModel) -> dict[tuple[str, str], Content]:
    """What a model has of files, by kind and name: boxes of meshes, heights."""
    found: dict[tuple[str, str], Content] = {}
    for i in range(model.nmesh):
        found["mesh", model.mesh(i).name] = _box(model, i)
    for i in range(model.nhfield):
        start = model.hfield_adr[i]
        found["hfield", model.hfield(i).name] = model.hfield_data[
            start : start + model.hfield_nrow[i] * model.hfield_ncol[i]
        ]
    return found


def _box(model: mujoco.MjModel, mesh: int) -> NDArray[np.float64]:
    """The box around a mesh as its file has it, (2, 3): MuJoCo moves it to its own axes of inertia."""
    start = model.mesh_vertadr[mesh]
    vertices = model.mesh_vert[start : start + model.mesh_vertnum[mesh]].astype(float)
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, model.mesh_quat[mesh])
    vertices = vertices @ turn.reshape(3, 3).T + model.mesh_pos[mesh]
    return np.stack((vertices.min(axis=0), vertices.max(axis=0)))


def _wrong_link(whole: mujoco.MjModel, model: ModelFile) -> str:
    """The name of a link of a URDF that has another mesh than its own."""
    robot = ElementTree.parse(model.path).getroot()
    children = {child.get("link") for child in robot.findall("joint/child")}
    for link in robot.findall("link"):
        kinds = ("collision",) if model.collides_only else ("visual", "collision")
        meshes = [mesh for kind in kinds for mesh in link.findall(f"{kind}/geometry/mesh")]
        name = str(link.get("name"))
        body = model.root if model.root and name not in children else model.prefix + name
        own = _sorted(_alone(mesh, model.path) for mesh in meshes)
        if model.may_lack and body not in {whole.body(b).name for b in range(whole.nbody)}:
            continue
        if not np.allclose(own, _sorted(_boxes(whole, body)), atol=TOLERANCE):
            return f"a mesh of link {name!r}"
    return ""


def _sorted(boxes: Iterator[NDArray[np.float64]]) -> NDArray[np.float64]:
    rows = sorted(tuple(np.round(box.ravel(), 4)) for box in boxes)
    return np.array(rows).reshape(-1, 6)


def _alone(mesh: Element, path: Path) -> NDArray[np.float64]:
    """The box around a mesh that is alone in its document."""
    file = find_file(mesh.get("filename", ""), near=path.parent, where=path, field="mesh")
    own = copy.copy(mesh)
    own.set("filename", f"alone{file.suffix}")
    robot = Element("robot", name="alone")
    SubElement(SubElement(SubElement(robot, "link", name="alone"), "visual"), "geometry").append(own)
    room = {"scene.toml": b'[scene]\nmodel = "alone.urdf"\n', "alone.urdf": ElementTree.tostring(robot)}
    return _box(Scene.from_bundle({**room, f"alone{file.suffix}": file.read_bytes()}).model, 0)


def _boxes(model: mujoco.MjModel, body: str) -> Iterator[NDArray[np.float64]]:
    for geom in np.flatnonzero(model.geom_bodyid == model.body(body).id):
        mesh = int(model.geom_dataid[geom])
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH and PART not in model.mesh(mesh).name:
            yield _box(model, mesh)


# --- Recordings: what others put into them stays.


def others_records(command: tuple[str, ...]) -> Callable[[], str]:
    """Whether a recording has all records that it had, but for its label."""
    path = Path(next(word for word in command if word.endswith(".mcap")))
    before = path.read_bytes()

    def wrong() -> str:
        after = path.read_bytes()
        if after == before:
            return ""
        try:
            had = _records(before)
        except Exception:  # what other programs could not read anyway
            return ""
        lost = had - _records(after)
        return f"lost {next(iter(lost))[0]}" if lost else ""

    return wrong


def _records(data: bytes) -> Counter[tuple[str, str, bytes]]:
    """Messages, attachments and metadata of a recording, its label apart."""
    reader = make_reader(io.BytesIO(data))
    found = Counter(
        ("a message", f"{channel.topic} {schema and schema.name} {message.log_time}", message.data)
        for schema, channel, message in reader.iter_messages()
    )
    found.update(("an attachment", each.name, each.data) for each in reader.iter_attachments())
    metadata = [each for each in reader.iter_metadata() if each.name != "taskgist.label"]
    found.update(("metadata", each.name, _packed(each.metadata)) for each in metadata)
    return found


def _packed(values: Mapping[str, str]) -> bytes:
    return repr(sorted(values.items())).encode("utf-8", "surrogatepass")
