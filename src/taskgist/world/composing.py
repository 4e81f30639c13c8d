"""Composing a room: the models that a scene names become one, and what it says of their bodies comes true.

Everything else then sees the same kind of room: objects are bodies with a free joint, and an agent is a model of its
own. In this order

1. the room's model is read, or a floor is laid where there is none;
2. its keyframe tells where things lie and doors stand;
3. bodies that are agents are taken out, as models of their own, and bodies that are left out go;
4. bodies that are objects are freed: whatever joints they had, they get a free joint;
5. furniture and objects that are models of their own are put in.

Actuators, sensors and tendons are dropped where any of that is done: they may speak of what is gone, and nothing here
asks for them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import count

import mujoco
import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import SceneError, UnknownNameError
from taskgist.settings import Limits
from taskgist.world.bodies.bases import drop_controls, drop_joints, free, is_free, moves_all_ways
from taskgist.world.bodies.markup import asking_mujoco
from taskgist.world.bodies.mending import made_of
from taskgist.world.bodies.mjcf import check_bodies
from taskgist.world.bodies.model_files import read_model, size_problems
from taskgist.world.geometry.transforms import Pose, matrix_from_euler, wxyz_from_matrix
from taskgist.world.scene_file import AgentEntry, PlacedModel, SceneFile
from taskgist.world.seen import touches

FLOOR_M = 10.0
"""Half the edge of the floor of a room without a model."""
LEAST_KG = 1e-9
"""MuJoCo lets nothing move that weighs less (1e-15 kg, and inertias follow)."""


@dataclass(frozen=True, eq=False)
class Composed:
    """A room of several models as one.

    Attributes:
        room: The specification, without agents.
        starts: Joints that the keyframe puts somewhere, and where.
        standing: Where agents stand that are bodies of the room's model, by name: the pose of that body.
    """

    room: mujoco.MjSpec
    starts: list[tuple[mujoco.MjsJoint, Array]] = field(default_factory=list)
    standing: dict[str, Pose] = field(default_factory=dict)

    def start(self, model: mujoco.MjModel) -> Array:
        """Where everything is in the compiled scene before agents are placed, (nq,)."""
        qpos = np.array(model.qpos0)
        for joint, values in self.starts:
            first = int(model.jnt_qposadr[joint.id])
            qpos[first : first + len(values)] = values
        return qpos


def compose(file: SceneFile, files: dict[str, bytes], limits: Limits) -> Composed:
    """The room of a scene.

    Args:
        file: The scene file.
        files: Its bundle; models of agents that are bodies of the room are added where they are missing.
        limits: Bounds of what it may hold.

    Raises:
        SceneError: A model cannot be read, or what the file says of one cannot be done.
        UnknownNameError: A body or a keyframe that the room's model does not have.
    """
    room = read_room(file, files, limits)
    name_things(room)
    agents = [entry for entry in file.agents if entry.room_body is not None]
    _check_in_room(room, file, agents)
    freed = list(_to_free(room, file))
    composed = Composed(room)
    lying: list[Array] = []
    if file.keyframe is not None or agents or freed:
        model, data = _as_it_stands(room, file, files)
        _check_masses(model, freed, file)
        composed.standing.update({entry.name: _pose(data, room.body(entry.room_body)) for entry in agents})
        if file.keyframe is not None:
            lying = [np.concatenate((data.xpos[body.id], data.xquat[body.id])) for body in freed]
            composed.starts.extend(_starts(room, file, freed, data))
    for key in list(room.keys):
        room.delete(key)
    if agents or freed or file.leave_out or file.placed:
        drop_controls(room)
    for entry in agents:
        _take_out(room, entry, file, files)
    for name in file.leave_out:
        _delete(room, name)
    joints = [free(room, body) for body in freed]
    composed.starts.extend(zip(joints, lying, strict=False))  # without a keyframe they lie as their bodies do
    for each in file.placed:
        _put_in(room, each, files, file.where, limits)
    check_bodies(len(room.bodies), file.where, limits)
    return composed


def read_room(file: SceneFile, files: dict[str, bytes], limits: Limits) -> mujoco.MjSpec:
    """The room's own model, as it stands in the bundle; a floor where the scene names none."""
    if file.model is not None:
        return read_spec(files, file.model, file.where, limits=limits)
    room = mujoco.MjSpec()
    room.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=(FLOOR_M, FLOOR_M, 0.1))
    return room


def name_things(room: mujoco.MjSpec) -> None:
    """Call bodies that move freely and have no name ``thing_1``, ``thing_2``, ..., in the order of the model."""
    names = {str(body.name) for body in room.bodies}
    free_names = (name for name in (f"thing_{number}" for number in count(1)) if name not in names)
    for body in room.worldbody.bodies:
        if not body.name and is_free(body):
            body.name = next(free_names)


def read_spec(files: dict[str, bytes], name: str, where: str, *, agent: bool = False, limits: Limits) -> mujoco.MjSpec:
    """A model of the bundle, whose shapes have sizes and do not bend."""
    spec = read_model(files, name, where=where, room=not agent, limits=limits)
    for problem in size_problems(spec, f"{where}: {name}"):
        raise problem
    _check_flexes(spec, f"{where}: {name}")
    return spec


def _check_flexes(spec: mujoco.MjSpec, where: str) -> None:
    """Refuse what bends: no ray of ours meets it, so that all behind it would be seen."""
    for flex in spec.flexes:
        hint = "leave it out, or make it a mesh (or boxes) where it hangs or lies"
        problem = "a flex (cloth, rope or soft body) is not read"
        raise SceneError(problem, where=where, field="flex", value=flex.name, hint=hint)


def compiled(spec: mujoco.MjSpec, files: dict[str, bytes], where: str) -> mujoco.MjModel:
    """The specification as a model, with the files of a bundle, to which flat meshes are added with a thickness.

    Raises:
        SceneError: MuJoCo refuses.
    """
    spec.assets = assets(files)
    with asking_mujoco("MuJoCo cannot compile this scene:", where):
        return made_of(spec, files, mujoco.MjSpec.compile)


def assets(files: Mapping[str, bytes]) -> dict[str, bytes]:
    """The files of a bundle that are no documents: meshes and images."""
    return {name: data for name, data in files.items() if not name.endswith((".toml", ".xml", ".urdf"))}


# --- Which bodies a scene may name, and which move freely by themselves.


def movers(room: mujoco.MjSpec, file: SceneFile) -> tuple[str, ...]:
    """Names of the bodies of a room's model that move freely: its objects, if a scene file names none.

    These are bodies with a free joint, or with joints that do the same, and mocap bodies with a shape that touches
    others: those without are handles, by which simulations pull robots about.
    """
    gone = {*file.leave_out, *(entry.room_body for entry in file.agents)}
    named = (body for body in room.worldbody.bodies if body.name and body.name not in gone)
    return tuple(str(body.name) for body in named if is_free(body) or moves_all_ways(body) or _is_mocap_object(body))


def _is_mocap_object(body: mujoco.MjsBody) -> bool:
    return bool(body.mocap) and any(touches(geom) for geom in body.find_all("geom"))


def _named(room: mujoco.MjSpec, name: str, where: str) -> mujoco.MjsBody:
    """The body of that name, which is not the world."""
    body = room.body(name) if name != "world" else None
    if body is None:
        names = {str(each.name) for each in room.bodies if each.name not in ("", "world")}
        raise UnknownNameError("body", name, names, where=where)
    return body


def _check_in_room(room: mujoco.MjSpec, file: SceneFile, agents: Collection[AgentEntry]) -> None:
    """Every body that is an agent or left out is there, and none of them is part of another, or an object."""
    said = [(f"agents.{entry.name}.room_body", str(entry.room_body)) for entry in agents]
    said += [("scene.leave_out", name) for name in file.leave_out]
    bodies = [_named(room, name, f"{file.where}: {place}") for place, name in said]
    taken: dict[str, str] = {}
    for (place, name), body in sorted(zip(said, bodies, strict=True), key=lambda each: _depth(each[1])):
        above: mujoco.MjsBody | None = body
        while above is not None and str(above.name) not in taken:
            above = above.parent
        if above is not None:
            problem = f"is part of what {taken[str(above.name)]} takes out of the room"
            raise SceneError(problem, where=file.where, field=place, value=name, hint="name it once")
        taken[name] = place
    for name in file.objects or ():
        if name in taken:
            hint = "an object is in the room: leave one of both out"
            raise SceneError(f"is what {taken[name]} takes", where=file.where, field="objects", value=name, hint=hint)


def _depth(body: mujoco.MjsBody) -> int:
    """How many bodies carry it."""
    return 0 if body.parent is None else 1 + _depth(body.parent)


def _to_free(room: mujoco.MjSpec, file: SceneFile) -> Iterator[mujoco.MjsBody]:
    """Bodies that are named as objects and have no free joint."""
    for name in file.objects or ():
        body = room.body(name) if name != "world" else None
        if body is None or is_free(body):
            continue
        if body.parent.name != "world":
            hint = "an object lies in the room by itself: put its body directly below <worldbody>, or leave it out"
            problem = f"is part of {str(body.parent.name)!r}"
            raise SceneError(problem, where=file.where, field="scene.objects", value=name, hint=hint)
        yield body


def _check_masses(model: mujoco.MjModel, freed: Collection[mujoco.MjsBody], file: SceneFile) -> None:
    for body in freed:
        if model.body_subtreemass[body.id] < LEAST_KG:
            hint = "give one of its shapes a mass or a density above zero, or the body an <inertial>"
            problem, name = "an object without mass", str(body.name)
            raise SceneError(problem, where=file.where, field="scene.objects", value=name, hint=hint)


# --- What the keyframe says, and where bodies are by it.


def _as_it_stands(
    room: mujoco.MjSpec, file: SceneFile, files: dict[str, bytes]
) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The room before anything is done to it, as its keyframe has it, where one is named."""
    key = _key(room, file)
    model = compiled(room, files, file.where)
    data = mujoco.MjData(model)
    if key is not None:
        mujoco.mj_resetDataKeyframe(model, data, key)
    mujoco.mj_kinematics(model, data)
    return model, data


def _pose(data: mujoco.MjData, body: mujoco.MjsBody) -> Pose:
    return Pose(data.xpos[body.id].copy(), data.xmat[body.id].reshape(3, 3).copy())


def _starts(
    room: mujoco.MjSpec, file: SceneFile, freed: Collection[mujoco.MjsBody], data: mujoco.MjData
) -> Iterator[tuple[mujoco.MjsJoint, Array]]:
    """The joints that stay in the room, and where they are."""
    gone = [room.body(name) for name in (*file.leave_out, *(e.room_body for e in file.agents)) if name is not None]
    without = {int(joint.id) for body in gone for joint in body.find_all("joint")}
    without |= {int(joint.id) for body in freed for joint in body.joints}
    for joint in room.joints:
        if int(joint.id) not in without:
            first = int(data.model.jnt_qposadr[joint.id])
            yield joint, data.qpos[first : first + POSITIONS.get(joint.type, 1)].copy()


POSITIONS = {mujoco.mjtJoint.mjJNT_FREE: 7, mujoco.mjtJoint.mjJNT_BALL: 4}
"""How many numbers say where a joint is; others have one."""


def _key(room: mujoco.MjSpec, file: SceneFile) -> int | None:
    """Index of the keyframe that the scene names."""
    if file.keyframe is None:
        return None
    names = [str(key.name) for key in room.keys]
    if file.keyframe not in names:
        if not any(names):
            hint = 'name one in the model, as <keyframe><key name="home" qpos="..."/></keyframe>, or leave this out'
            problem = (
                "the room's model has no keyframe that has a name" if names else "the room's model has no keyframes"
            )
            raise SceneError(problem, where=file.where, field="scene.keyframe", value=file.keyframe, hint=hint)
        raise UnknownNameError("keyframe", file.keyframe, filter(None, names), where=f"{file.where}: scene.keyframe")
    return names.index(file.keyframe)


# --- What is taken out, left out, freed.


def _take_out(room: mujoco.MjSpec, entry: AgentEntry, file: SceneFile, files: dict[str, bytes]) -> None:
    """Make a body of the room a model of its own, among the bundle's files, and delete it in the room."""
    assert entry.room_body is not None
    if entry.model_key not in files:
        alone, copy = mujoco.MjSpec(), room.copy()
        alone.assets = copy.assets = assets(files)
        with asking_mujoco(f"MuJoCo cannot take {entry.room_body!r} out of the room:", file.where):
            alone.worldbody.add_frame().attach_body(copy.body(entry.room_body), "", "")
            root = alone.worldbody.first_body()
            root.pos, root.quat = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
            _drop_prefix(alone, entry.room_prefix)
            files[entry.model_key] = str(alone.to_xml()).encode()
    _delete(room, entry.room_body)


def _drop_prefix(alone: mujoco.MjSpec, prefix: str) -> None:
    """Call bodies, joints, sites and shapes without a prefix; what speaks of their contacts alone goes."""
    for each in (*alone.bodies, *alone.joints, *alone.sites, *alone.geoms):
        each.name = str(each.name).removeprefix(prefix)
    for equality in alone.equalities:
        equality.name1 = str(equality.name1).removeprefix(prefix)
        equality.name2 = str(equality.name2).removeprefix(prefix)
    for contact in (*alone.pairs, *alone.excludes):
        alone.delete(contact)


def _delete(room: mujoco.MjSpec, name: str) -> None:
    """Delete a body and all that it carries, with the meshes that nothing else has."""
    body = room.body(name)
    names = {str(each.name) for each in (body, *body.find_all("body")) if each.name}
    for aimed in (*room.cameras, *room.lights):
        if str(aimed.targetbody) in names:
            aimed.targetbody, aimed.mode = "", mujoco.mjtCamLight.mjCAMLIGHT_FIXED
    had = {str(geom.meshname) for geom in body.find_all("geom")}
    room.delete(body)
    had -= {str(geom.meshname) for geom in room.geoms}
    for mesh in [mesh for mesh in room.meshes if mesh.name in had]:
        room.delete(mesh)


# --- Furniture and objects that are models of their own.


def _put_in(room: mujoco.MjSpec, each: PlacedModel, files: dict[str, bytes], where: str, limits: Limits) -> None:
    check_free_name(room, each.name, where, each.table)
    if each.key not in files:
        problem, hint = "no such file among the scene's own", f"the bundle holds it as {each.key!r}"
        raise SceneError(problem, where=where, field=each.table, value=each.file, hint=hint)
    spec = read_spec(files, each.key, where, limits=limits)
    drop_controls(spec)
    spec.compiler.balanceinertia = True  # MJCF text of a URDF has lost that; published inertias are often impossible
    quat = wxyz_from_matrix(matrix_from_euler(np.array(each.rpy_rad), "xyz", intrinsic=False))
    room.assets = spec.assets = assets(files)  # MuJoCo warns if only one of them has any
    with asking_mujoco(f"MuJoCo cannot put {each.name!r} into this scene:", where):
        if each.kind == "object":
            root = str(_freed_root(spec, each, where).name)
            frame = room.worldbody.add_frame(pos=each.position_m, quat=quat)
            room.attach(spec, prefix=f"{each.name}/", frame=frame)
            room.body(f"{each.name}/{root}").name = each.name
        else:
            for body in spec.worldbody.bodies:
                body.mocap = False
                if is_free(body):
                    drop_joints(spec, body.joints)
            whole = room.worldbody.add_body(name=each.name, pos=each.position_m, quat=quat)
            room.attach(spec, prefix=f"{each.name}/", frame=whole.add_frame())


def _freed_root(spec: mujoco.MjSpec, each: PlacedModel, where: str) -> mujoco.MjsBody:
    """The one top-level body of an object's model, with a free joint."""
    roots = list(spec.worldbody.bodies)
    if len(roots) != 1 or len(spec.worldbody.geoms):
        names = [str(body.name) or "(no name)" for body in roots] + ["shapes of the world"] * bool(spec.worldbody.geoms)
        hint = "keep the object, and leave floor and furniture to the scene"
        problem = f"a model of an object has one top-level body, {each.file!r} has {', '.join(names) or 'none'}"
        raise SceneError(problem, where=where, field=each.table, hint=hint)
    (root,) = roots
    root.name = root.name or each.name
    free(spec, root)
    return root


def check_free_name(room: mujoco.MjSpec, name: str, where: str, field: str) -> None:
    """Refuse a name that something of the room's model has, or begins with: its bodies could not be told apart.

    Raises:
        SceneError: There is something.
    """
    if name in {str(item.name).partition("/")[0] for item in (*room.bodies, *room.geoms)}:
        kind, _, _ = field.partition(".")
        hint = f"rename it under [{kind}], or the body or shape of the model"
        raise SceneError("the model has something of that name", where=where, field=kind, value=name, hint=hint)
