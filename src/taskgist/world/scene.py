"""A scene: a room with objects (a MuJoCo model), and the agents placed in it.

A scene file is a short TOML document beside the model::

    [scene]
    name = "living room"
    model = "room.xml"                 # MJCF or URDF of room and objects
    keyframe = "home"                  # optional: the model's key by which objects lie and doors stand
    objects = ["cup", "box"]           # optional; default: every body that moves freely
    leave_out = ["target"]             # optional: bodies of the model that are not in the scene
    estimated = ["table"]              # optional: bodies that nobody measured
    seen_groups = [0, 1, 2]            # optional: the model's geom groups that are seen

    [furniture.shelf]                  # optional: furniture that is a model of its own
    model = "shelf.urdf"
    position_m = [1.0, 0.5, 0.0]
    yaw_deg = 90

    [objects.mug]                      # optional: an object that is a model of its own, or a mesh
    mesh = "mug.obj"
    position_m = [0.4, 0.1, 0.8]

    [agents.P1]
    profile = "human"                  # built in, or the file of your own
    position_m = [-0.8, 0.0]           # floor point beneath the pelvis (or base)
    yaw_deg = 0                        # heading; 0 looks along +x
    posture = "sitting"                # the seat is found beneath; default: standing
    body = { stature_m = 1.75 }        # optional sizes, see world/body/anthropometry.py
    joints_deg = { head_tilt = -20 }   # optional

What can be derived is not asked for: supports, containers and seats come from geometry.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from types import MappingProxyType

import mujoco
import numpy as np

from taskgist.common.files import shown_path
from taskgist.errors import SceneError, UnknownNameError
from taskgist.settings import DEFAULT, Limits
from taskgist.world.assembly import Assembled, as_mjcf, assemble, free_bodies
from taskgist.world.bodies.agent import SEEN_GROUPS, Agent, subtree
from taskgist.world.bodies.hands import GHOST_GROUP
from taskgist.world.gathering import SCENE_FILE, bundle_from_path, bundle_from_spec, bundle_with_agent
from taskgist.world.geometry.convex import whole
from taskgist.world.geometry.shapes import surface_points
from taskgist.world.scene_file import AgentEntry, SceneFile, parse_scene_file
from taskgist.world.seen import alphas, visible_geoms
from taskgist.world.state import State

ROOM_FILE = "room.xml"
"""Name of the room's model in scenes that are made of values."""
NO_GEOMS = np.empty(0, dtype=np.intp)
COLUMNS_OF_JOINTS: Mapping[int, tuple[str, ...]] = {
    int(mujoco.mjtJoint.mjJNT_FREE): ("x", "y", "z", "qw", "qx", "qy", "qz"),
    int(mujoco.mjtJoint.mjJNT_BALL): ("qw", "qx", "qy", "qz"),
}
"""Parts of the positions of joints that have several."""


@dataclass(frozen=True, eq=False)
class Scene:
    """A compiled scene. Immutable; states of it are separate values.

    Attributes:
        name: Name for people.
        model: The compiled MuJoCo model of room, objects and agents.
        initial: The state in which the scene file places everything.
        bundle: Every file that makes the scene, by relative name; ``Scene.from_bundle`` makes the same scene of it.
        estimated: Bodies whose place or shape nobody measured.
        owners: What each geom belongs to, by geom index: an agent, an object or a piece of furniture.
    """

    name: str
    model: mujoco.MjModel
    initial: State
    bundle: Mapping[str, bytes]
    estimated: frozenset[str]
    owners: tuple[str, ...]
    _agents: Mapping[str, Agent]
    _objects: Mapping[str, int]
    _limits: Limits

    @classmethod
    def load(cls, path: str | Path, *, limits: Limits = DEFAULT.limits) -> Scene:
        """Read a scene file, and the files that it names.

        Args:
            path: The scene file.
            limits: What is refused before memory is taken for it.

        Raises:
            SceneError: The file, its model or a profile is missing, too large or cannot be used.
        """
        return cls.from_bundle(bundle_from_path(Path(path), limits=limits), where=shown_path(Path(path)), limits=limits)

    @classmethod
    def from_bundle(
        cls, bundle: Mapping[str, bytes], *, where: str = SCENE_FILE, limits: Limits = DEFAULT.limits
    ) -> Scene:
        """A scene from its files in memory. Nothing else is opened, whatever a model among them names.

        Where its scene file names no objects, these are the bodies with a free joint; ``load`` and ``from_spec`` name
        others that move freely there.

        Args:
            bundle: Contents by relative names, ``scene.toml`` among them.
            where: What the scene comes from, for messages.
            limits: What is refused before memory is taken for it.

        Raises:
            SceneError: As ``load``, or a file that is named is not in the bundle.
        """
        if SCENE_FILE not in bundle:
            raise SceneError("no scene.toml in the scene's files", where=where)
        file = parse_scene_file(bundle[SCENE_FILE], where=where, limits=limits)
        return _scene(file, assemble(file, bundle, limits=limits), limits)

    @classmethod
    def from_spec(
        cls,
        room: mujoco.MjSpec,
        agents: Iterable[AgentEntry] = (),
        *,
        name: str = "scene",
        objects: Collection[str] | None = None,
        estimated: Collection[str] = (),
        seen_groups: Collection[int] | None = None,
        keyframe: str | None = None,
        leave_out: Collection[str] = (),
        files: Mapping[str, bytes] | None = None,
        where: str | None = None,
        limits: Limits = DEFAULT.limits,
    ) -> Scene:
        """A scene made of values: a room as MuJoCo's own specification, and the agents placed in it.

        Example::

            room = mujoco.MjSpec()
            room.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5, 5, 0.1])
            cup = room.worldbody.add_body(name="cup", pos=[0.6, 0, 0.05])
            cup.add_freejoint()
            cup.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[0.03, 0.05, 0])
            scene = Scene.from_spec(room, [AgentEntry("P1"), AgentEntry("P2", position_m=(1.5, 0), yaw_rad=math.pi)])

        Args:
            room: Room and objects; it stays as it is. Its meshes are read from its ``assets``, else from disk. The
                scene keeps its numbers with six significant digits, which is how MuJoCo writes them.
            agents: Who is there, in this order.
            name: Name for people.
            objects: The bodies that facts can be said of; None: every body that moves freely.
            estimated: Bodies whose place or shape nobody measured.
            seen_groups: Geom groups of the room's shapes that are seen; None: 0 to 2, without coarse stand-ins.
            keyframe: The room's key by which its objects lie and its doors stand; None: as its bodies are.
            leave_out: Bodies of the room that are not in the scene, nor what they carry.
            files: Profiles (``NAME.profile.toml``) and models (``NAME.model.xml``) of agents that are not on disk.
            where: What the scene comes from, for messages; default: its name.
            limits: What is refused before memory is taken for it.

        Raises:
            SceneError: As ``load``.
        """
        where = name if where is None else where
        chosen = None if objects is None else tuple(objects)
        groups = None if seen_groups is None else tuple(seen_groups)
        file = SceneFile(
            name=name,
            model=ROOM_FILE,
            objects=chosen,
            estimated=tuple(estimated),
            agents=tuple(agents),
            where=where,
            seen_groups=groups,
            keyframe=keyframe,
            leave_out=tuple(leave_out),
        )
        bundle = bundle_from_spec(room, file, files or {}, limits=limits)
        return cls.from_bundle(bundle, where=where, limits=limits)

    def joined_by(
        self, agent: AgentEntry, state: State | None = None, *, where: str | None = None
    ) -> tuple[Scene, State]:
        """This scene with one more agent in it, and a state of it.

        Example: a PR2 comes into a room whose recording knows none::

            scene, state = recording.scene.joined_by(AgentEntry("PR2", "pr2", (1.0, 0.5)), recording.at(3.0))

        Args:
            agent: Who comes in, and where it stands; a profile of its own is looked for from the working folder.
            state: Where everything else is; None: as this scene has it.
            where: What the scene comes from, for messages; default: its name.

        Returns:
            The scene, and the state in which all others are where they were.

        Raises:
            SceneError: Somebody or something of that name is there, or the profile or its model cannot be used.
        """
        where = self.name if where is None else where
        bundle = bundle_with_agent(self.bundle, agent, where=where, limits=self._limits)
        scene = Scene.from_bundle(bundle, where=where, limits=self._limits)
        before = self.initial if state is None else state
        at = {column: index for index, column in enumerate(scene.columns)}
        values = {at[column]: float(value) for column, value in zip(self.columns, before.qpos, strict=True)}
        qpos = scene.initial.replace(values).qpos
        return scene, State(qpos, before.time_s, before.untracked, before.holding, before.eyes)

    def __reduce__(self) -> tuple[object, ...]:
        return partial(Scene.from_bundle, limits=self._limits), (dict(self.bundle),)

    @property
    def agents(self) -> tuple[str, ...]:
        """Names of the agents, in the file's order."""
        return tuple(self._agents)

    @property
    def objects(self) -> tuple[str, ...]:
        """Names of the objects that facts can be said of."""
        return tuple(self._objects)

    @property
    def nq(self) -> int:
        """Number of generalised positions."""
        return int(self.model.nq)

    def agent(self, name: str) -> Agent:
        """The agent of that name.

        Raises:
            UnknownNameError: There is none.
        """
        if name not in self._agents:
            raise UnknownNameError("agent", name, self._agents)
        return self._agents[name]

    def object_body(self, name: str) -> int:
        """Body index of an object.

        Raises:
            UnknownNameError: There is none.
        """
        if name not in self._objects:
            raise UnknownNameError("object", name, self._objects)
        return self._objects[name]

    def object_geoms(self, name: str) -> np.ndarray:
        """Geom indices of an object, (n,)."""
        self.object_body(name)
        return self.geoms_of(name)

    def geoms_of(self, owner: str) -> np.ndarray:
        """Geom indices of an agent, object or piece of furniture, (n,)."""
        return self._geoms_by_owner.get(owner, NO_GEOMS)

    def seen_geoms(self, owner: str) -> np.ndarray:
        """Indices of the shapes of an agent, object or piece of furniture that rays meet, (n,)."""
        return self._seen_by_owner.get(owner, NO_GEOMS)

    def solid_geoms_of(self, owner: str) -> np.ndarray:
        """Indices of the shapes that an agent, object or piece of furniture touches others with, (n,).

        Those of a concave mesh are its convex parts. Where the model lets nothing collide, what is seen counts.
        """
        return self._solid_by_owner.get(owner, NO_GEOMS)

    @cached_property
    def objects_geoms(self) -> np.ndarray:
        """Indices of the shapes that objects touch others with, (n,)."""
        solid = [self.solid_geoms_of(name) for name in self.objects]
        return np.concatenate(solid) if solid else NO_GEOMS

    @cached_property
    def things_geoms(self) -> np.ndarray:
        """Indices of all shapes but those of agents, (n,)."""
        return np.flatnonzero([owner not in self.agents for owner in self.owners])

    @cached_property
    def shapeless(self) -> frozenset[str]:
        """Objects without any shape: where they are may be known, but nothing else about them."""
        return frozenset(name for name in self.objects if not len(self.geoms_of(name)))

    @cached_property
    def never_known(self) -> frozenset[str]:
        """What counts as not tracked in every state: objects without a shape, and heads of agents without an eye."""
        return self.shapeless | {f"{name}/head" for name, agent in self._agents.items() if not agent.profile.eye.sees}

    @cached_property
    def _seen_by_owner(self) -> Mapping[str, np.ndarray]:
        return {owner: own[self.visible[own]] for owner, own in self._geoms_by_owner.items()}

    @cached_property
    def _solid_by_owner(self) -> Mapping[str, np.ndarray]:
        solid = {owner: own[np.isin(own, self.solid_geoms)] for owner, own in self._geoms_by_owner.items()}
        return {owner: own if len(own) else self._seen_by_owner[owner] for owner, own in solid.items()}

    @cached_property
    def _geoms_by_owner(self) -> Mapping[str, np.ndarray]:
        by_owner: dict[str, list[int]] = {}
        for geom, owner in enumerate(self.owners):
            by_owner.setdefault(owner, []).append(geom)
        return {owner: np.array(geoms) for owner, geoms in by_owner.items()}

    @cached_property
    def bodies(self) -> tuple[str, ...]:
        """Names of the objects and pieces of furniture: everything solid that is neither agent nor the room itself."""
        of_bodies = {self.owners[g] for g in range(len(self.owners)) if int(self.model.geom_bodyid[g]) != 0}
        return tuple(sorted(of_bodies - set(self.agents)))

    @cached_property
    def solid_geoms(self) -> np.ndarray:
        """Indices of the shapes that block: all but ghosts and those that the model lets nothing collide with, (n,)."""
        touching = (self.model.geom_contype != 0) | (self.model.geom_conaffinity != 0)
        return np.flatnonzero(touching & (self.model.geom_group != GHOST_GROUP))

    @cached_property
    def visible(self) -> np.ndarray:
        """Whether rays meet each shape: its group is seen, and it is not wholly transparent, (ngeom,)."""
        return visible_geoms(self.model)

    def hiding(self, transparent_alpha: float) -> np.ndarray:
        """Whether each shape hides what is behind it, (ngeom,): not if its colour's alpha is at most that."""
        return self._alphas > transparent_alpha

    @cached_property
    def _alphas(self) -> np.ndarray:
        return alphas(self.model)

    def untracked_geoms(self, untracked: Iterable[str]) -> np.ndarray:
        """Geom indices of untracked objects ("cup"), agents ("P1") and parts of agents ("P1/left_arm"), (n,)."""
        hidden: list[int] = []
        for name in untracked:
            agent, _, part = name.partition("/")
            bodies = self._agents[agent].parts.get(part, ()) if part and agent in self._agents else None
            own = self.geoms_of(agent) if bodies is None else np.flatnonzero(np.isin(self.model.geom_bodyid, bodies))
            hidden += [int(geom) for geom in own]
        return np.array(sorted(set(hidden)), dtype=np.intp)

    def surface_points(self, geom: int, spacing_m: float) -> tuple[np.ndarray, np.ndarray]:
        """Points and outward normals on a shape's surface, in its own frame; see ``shapes``. Sampled once."""
        key = (geom, spacing_m)
        if key not in self._surfaces:
            self._surfaces[key] = surface_points(self.model, geom, spacing_m)
        return self._surfaces[key]

    @cached_property
    def _surfaces(self) -> dict[tuple[int, float], tuple[np.ndarray, np.ndarray]]:
        return {}

    def object_slice(self, name: str) -> slice:
        """Slice of qpos (7) of an object: position in metres and wxyz."""
        joint = self.model.body_jntadr[self.object_body(name)]
        start = int(self.model.jnt_qposadr[joint])
        return slice(start, start + 7)

    def inner_joints(self, name: str) -> np.ndarray:
        """Indices into qpos of the scalar joints within an object, such as that of a lid, (n,)."""
        self.object_body(name)
        return self._inner_joints[name]

    @cached_property
    def _inner_joints(self) -> Mapping[str, np.ndarray]:
        scalar = np.isin(self.model.jnt_type, (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE))
        inside = {
            name: np.isin(self.model.jnt_bodyid, subtree(self.model, body)) for name, body in self._objects.items()
        }
        return {name: np.asarray(self.model.jnt_qposadr[within & scalar]) for name, within in inside.items()}

    def base_slice(self, agent: str) -> slice:
        """Slice of qpos (7) of an agent's root: position in metres and wxyz."""
        return self.agent(agent).base

    def joints(self, agent: str) -> tuple[str, ...]:
        """Names of an agent's scalar joints, without its prefix."""
        return tuple(self.agent(agent).joints)

    def joint_indices(self, agent: str) -> np.ndarray:
        """Indices into qpos of those joints, in the same order."""
        return np.array(list(self.agent(agent).joints.values()), dtype=np.intp)

    def parts(self, agent: str) -> tuple[str, ...]:
        """Names of the parts of an agent that a tracker may lose."""
        return tuple(self.agent(agent).parts)

    @cached_property
    def columns(self) -> tuple[str, ...]:
        """What each generalised position is, nq names: "P2/head_pan", or "cup.x" to "cup.qz" of what moves freely."""
        model, names = self.model, list[str]()
        for joint in range(model.njnt):
            own = str(model.joint(joint).name) or str(model.body(int(model.jnt_bodyid[joint])).name)
            parts = COLUMNS_OF_JOINTS.get(int(model.jnt_type[joint]), ("",))
            names += [f"{own}.{part}" if part else own for part in parts]
        return tuple(names)

    def mjcf(self) -> tuple[str, dict[str, bytes]]:
        """Room, objects and agents as one model that MuJoCo reads without taskgist, positions in the same order.

        Returns:
            The text, and the contents of the meshes and images that it names, by name:
            ``mujoco.MjModel.from_xml_string(text, files)``.
        """
        file = parse_scene_file(self.bundle[SCENE_FILE], where=self.name, limits=self._limits)
        return as_mjcf(file, self.bundle, limits=self._limits)


def _scene(file: SceneFile, assembled: Assembled, limits: Limits) -> Scene:
    model = assembled.model
    objects = _objects(file, model, set(assembled.agents))
    bodies = {str(model.body(b).name) for b in range(1, model.nbody)}
    for name in file.estimated:
        if name not in bodies:
            raise UnknownNameError("body", name, bodies, where=f"{file.where}: scene.estimated")
    return Scene(
        name=file.name,
        model=model,
        initial=assembled.initial,
        bundle=MappingProxyType(dict(assembled.bundle)),
        estimated=frozenset(file.estimated),
        owners=_owners(model, set(assembled.agents), set(objects)),
        _agents=MappingProxyType(assembled.agents),
        _objects=MappingProxyType(objects),
        _limits=limits,
    )


def _objects(file: SceneFile, model: mujoco.MjModel, agents: set[str]) -> dict[str, int]:
    free = free_bodies(model, agents)
    for name in file.objects or ():
        if name not in free:
            lying = (str(model.body(int(body)).name) for body in np.flatnonzero(model.body_parentid == 0)[1:])
            known = {body for body in lying if body and body.partition("/")[0] not in agents}
            raise UnknownNameError("object (a body of the model)", name, known, where=file.where)
    own = [each.name for each in file.placed if each.kind == "object"]
    objects = {name: free[name] for name in (free if file.objects is None else (*file.objects, *own))}
    for name, body in objects.items():
        _check_shapes(file, model, name, body)
    return objects


def _check_shapes(file: SceneFile, model: mujoco.MjModel, name: str, body: int) -> None:
    """What shapes an object has must include one that can be seen; without any, all about it is unknown."""
    own = np.flatnonzero(np.isin(model.geom_bodyid, subtree(model, body)))
    if not len(own):
        return
    flat = (int(mujoco.mjtGeom.mjGEOM_PLANE), int(mujoco.mjtGeom.mjGEOM_HFIELD))
    seen = own[visible_geoms(model)[own] & ~np.isin(model.geom_type[own], flat)]
    if not len(seen):
        groups = SEEN_GROUPS if file.seen_groups is None else file.seen_groups
        hint = (
            "give it a box, sphere, capsule, cylinder, ellipsoid or mesh, not wholly transparent, in a seen group "
            f"({', '.join(map(str, groups))})"
        )
        raise SceneError(
            "an object without a shape that can be seen", where=file.where, field="objects", value=name, hint=hint
        )


def _owners(model: mujoco.MjModel, agents: set[str], objects: set[str]) -> tuple[str, ...]:
    return tuple(_owner(model, geom, agents, objects) for geom in range(model.ngeom))


def _owner(model: mujoco.MjModel, geom: int, agents: set[str], objects: set[str]) -> str:
    """Agent, object or top-level piece of furniture; geoms of the world body stand for themselves."""
    body = int(model.geom_bodyid[geom])
    if body == 0:
        return whole(str(model.geom(geom).name)) or "room"
    chain = [body]
    while (parent := int(model.body_parentid[chain[-1]])) != 0:
        chain.append(parent)
    names = [str(model.body(b).name) for b in chain]
    agent = names[-1].partition("/")[0]
    if agent in agents:
        return agent
    return next((name for name in names if name in objects), names[-1] or "room")
