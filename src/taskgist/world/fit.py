"""Fitting a body to tracked points: inverse kinematics over landmarks.

Trackers deliver points (and sometimes directions) of body parts; a body wants joint angles. Each landmark is a site
of the agent's model with the tracker's own name for it (``left_elbow``, ``nose``), so a fit is a sum of named targets,
met by Gauss-Newton steps under joint limits (``fit_steps``)::

    fitter = Fitter(scene, "P1")
    fit = fitter.fit(state, points={"head": (0.1, 0, 1.6)}, directions={"face": (1, 0, 0)})
    fit.state, fit.errors_m["head"]

A whole track is fitted by arrays, its names looked up once: ``features`` and ``settle``.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from taskgist.common.arrays import Array, Indices
from taskgist.errors import SceneError, UnknownNameError
from taskgist.world.assembly import assemble
from taskgist.world.bodies.agent import Agent
from taskgist.world.bodies.arm_chain import ALONG, JOINT_COLUMNS, SLIDES
from taskgist.world.fit_steps import FEATURE_COLUMNS, LEVER, NOWHERE, PLACE, ROOT, ROOT_DOFS, WEIGHT, descend, places_of
from taskgist.world.gathering import SCENE_FILE
from taskgist.world.scene import Scene
from taskgist.world.scene_file import AgentEntry, SceneFile, parse_scene_file
from taskgist.world.state import State

# --- An agent alone: the same body in an empty room, for what takes long where much could move.
#
# Inverse kinematics solves for everything that a model has joints for. In a room with others and with things, most of
# that stays where it is; without them each step takes less than half the time.

EMPTY_ROOM: Mapping[str, bytes] = {"empty.xml": b"<mujoco/>"}
SOME_SEAT_M = 0.45
"""Where nothing is to sit on, the height of a seat must be said; the fitted state has that of the scene."""


@dataclass(frozen=True, eq=False)
class Alone:
    """A model of one agent of a scene and nothing else.

    Attributes:
        model: The model; names are those of the scene.
        agent: The agent in it.
        columns: Index into the scene's qpos of each of the model's, (nq,).
    """

    model: mujoco.MjModel
    agent: Agent
    columns: Indices

    def qpos(self, everywhere: Array) -> Array:
        """The agent's own positions (nq,) among those of the scene, (scene's nq,)."""
        return np.array(everywhere[self.columns])

    def within(self, everywhere: Array, qpos: Array) -> Array:
        """Positions of the scene with the agent's own replaced, (scene's nq,)."""
        changed = np.array(everywhere)
        changed[self.columns] = qpos
        return changed


def alone(scene: Scene, name: str) -> Alone:
    """An agent of a scene, alone.

    Raises:
        UnknownNameError: There is no such agent.
    """
    there = scene.agent(name)
    model, agent = _apart(scene, name) if scene.nq > _count(there) else (scene.model, there)
    columns = np.empty(model.nq, dtype=np.intp)
    columns[agent.base] = np.arange(there.base.start, there.base.stop)
    for joint, column in agent.joints.items():
        columns[column] = there.joints[joint]
    return Alone(model, agent, columns)


def _count(agent: Agent) -> int:
    """How many positions an agent has."""
    return int(agent.base.stop - agent.base.start) + len(agent.joints)


def _apart(scene: Scene, name: str) -> tuple[mujoco.MjModel, Agent]:
    """The agent compiled anew, without the scene."""
    file = parse_scene_file(scene.bundle[SCENE_FILE], where=scene.name)
    (entry,) = (entry for entry in file.agents if entry.name == name)
    (model,) = EMPTY_ROOM
    empty = SceneFile(file.name, model, None, (), (_seated(entry),), file.where)
    assembled = assemble(empty, {**scene.bundle, **EMPTY_ROOM})
    return assembled.model, assembled.agents[name]


def _seated(entry: AgentEntry) -> AgentEntry:
    return replace(entry, seat_height_m=entry.seat_height_m or SOME_SEAT_M, room_body=None)


# --- What a fit asks for: features of the body at targets.
#
# Errors are differences of positions in the world. (The logarithm of a whole pose, in the frame of what is fitted,
# would weigh the same distance up to half as much again for a body that faces the other way.)

POSTURE_COST = 1e-3
"""Pull towards the posture of rest for joints that nothing else decides."""
STIFF: Mapping[str, float] = {"girdle": 20.0, "torso": 10.0, "torso_side": 40.0, "head_roll": 40.0, "wrist": 3.0}
"""How much more reluctantly joints move than others, by words in their names: people bend sideways last (ours)."""


@dataclass(frozen=True)
class Marker:
    """A point that is fixed to a body near one of its landmarks: a marker on the skin, another tracker's joint.

    Attributes:
        landmark: The landmark beside which it lies.
        offset_m: From there to it, metres, along the axes that the body has in its zero configuration.
        axes: The landmark with whose body the offset turns; empty: the same landmark.
    """

    landmark: str
    offset_m: tuple[float, float, float]
    axes: str = ""


@dataclass(frozen=True, eq=False)
class Features:
    """Points and directions of a body that targets are given for, in this order.

    Attributes:
        points: Names of the points.
        directions: Names of the directions, which come after them.
        rows: What ``fit_steps`` knows of each, (f, 7).
        carriers: Index of the joint that carries the place of each, and of that which turns its lever, (f, 2).
    """

    points: tuple[str, ...]
    directions: tuple[str, ...]
    rows: Array
    carriers: Indices


@dataclass(frozen=True, eq=False)
class JointTree:
    """The joints of an agent that is alone in a model, as numbers: all at zero, in the axes of its root.

    Attributes:
        joints: A point of the axis (3), the axis (3), whether it slides, and nothing, parents first, (j, 9).
        parents: The joint that carries each; −1 for the root, (j,).
        columns: Index of each into the model's qpos, (j,).
        zero: Its value there while it is at zero, (j,).
        limits: Its least and greatest value, counted from zero; infinite where it has none, (j, 2).
        names: Its name, without the agent's.
        carrier: The joint that carries each of the model's bodies; −1 for the root and what is beside the agent.
        data: Where bodies and sites are while all joints are at zero and the root is at the origin.
    """

    joints: Array
    parents: Indices
    columns: Indices
    zero: Array
    limits: Array
    names: tuple[str, ...]
    carrier: Indices
    data: mujoco.MjData

    def values(self, qpos: Array) -> Array:
        """Values of the joints, counted from zero, (j,), or those of many configurations (n, nq), (n, j)."""
        return np.asarray(qpos[..., self.columns] - self.zero)


def joint_tree(model: mujoco.MjModel, agent: Agent) -> JointTree:
    """The joints of an agent that is alone in a model.

    Raises:
        SceneError: One of them neither turns about an axis nor slides.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = model.qpos0
    data.qpos[agent.base] = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    mujoco.mj_kinematics(model, data)
    carrier, found, parents = np.full(model.nbody, ROOT), list[int](), list[int]()
    for body in agent.bodies.tolist():
        carrier[body] = carrier[model.body_parentid[body]]
        for joint in range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body]):
            kind = int(model.jnt_type[joint])
            if kind == int(mujoco.mjtJoint.mjJNT_BALL):
                hint = "make it of hinges"
                name = str(model.joint(joint).name)
                raise SceneError("a fit does not turn balls", where=agent.name, field="joint", value=name, hint=hint)
            if kind != int(mujoco.mjtJoint.mjJNT_FREE):
                parents.append(int(carrier[body]))
                carrier[body] = len(found)
                found.append(joint)
    joints = np.zeros((len(found), JOINT_COLUMNS))
    joints[:, :ALONG], joints[:, ALONG:SLIDES] = data.xanchor[found], data.xaxis[found]
    joints[:, SLIDES] = model.jnt_type[found] == int(mujoco.mjtJoint.mjJNT_SLIDE)
    columns = model.jnt_qposadr[found].astype(np.intp)
    zero = model.qpos0[columns]
    limited = (model.jnt_limited[found] != 0)[:, None]
    limits = np.where(limited, model.jnt_range[found] - zero[:, None], (-np.inf, np.inf))
    names = tuple(str(model.joint(joint).name).removeprefix(f"{agent.name}/") for joint in found)
    return JointTree(joints, np.array(parents, dtype=np.intp), columns, zero, limits, names, carrier, data)


def posture_costs(joints: Iterable[str]) -> Array:
    """Pull of each joint towards the posture of rest, (j,)."""
    stiffness = (max((factor for word, factor in STIFF.items() if word in joint), default=1.0) for joint in joints)
    return POSTURE_COST * np.array(list(stiffness))


# --- The words of a fit: which joints may move, which points and directions of a body can be asked for.

ARMS = ("girdle", "shoulder", "elbow", "forearm", "wrist")
MOVING: Mapping[str, tuple[str, ...]] = {
    "arms": ARMS,
    "upper_body": ("torso", *ARMS),
    "trunk_and_arms": ("torso", "head", *ARMS),
}
"""Named sets of joints that a fit may move, by words in the joints' names; ``body`` moves everything, the root too."""

Axis = tuple[str, tuple[float, float, float]]
"""A landmark, and an axis in its frame."""

AXES: Mapping[str, Axis] = {
    "face": ("eye", (1.0, 0.0, 0.0)),
    "head_up": ("eye", (0.0, 0.0, 1.0)),
    "left_hand": ("left_wrist", (0.0, 0.0, -1.0)),
    "right_hand": ("right_wrist", (0.0, 0.0, -1.0)),
    "left_palm": ("left_wrist", (0.0, -1.0, 0.0)),
    "right_palm": ("right_wrist", (0.0, 1.0, 0.0)),
    "left_thumb": ("left_wrist", (1.0, 0.0, 0.0)),
    "right_thumb": ("right_wrist", (1.0, 0.0, 0.0)),
    "pelvis": ("pelvis", (1.0, 0.0, 0.0)),
    "pelvis_up": ("pelvis", (0.0, 0.0, 1.0)),
    "chest": ("chest", (1.0, 0.0, 0.0)),
}
"""Directions that a fit may ask for: a landmark, and the axis of its frame. Of hands: to the fingers, out of the palm,
to the thumb."""


def landmarks(scene: Scene, agent: str) -> tuple[str, ...]:
    """Names of the landmarks that an agent's model has."""
    return landmarks_in(scene.model, agent)


def landmarks_in(model: mujoco.MjModel, agent: str) -> tuple[str, ...]:
    """Names of an agent's landmarks in a model."""
    prefix = f"{agent}/"
    names = (str(model.site(s).name) for s in range(model.nsite))
    return tuple(name.removeprefix(prefix) for name in names if name.startswith(prefix))


def chosen_joints(agent: Agent, moving: str | Collection[str]) -> Iterable[str]:
    """Names of the joints that may move.

    Args:
        agent: Whose.
        moving: A name of ``MOVING``, ``"body"``, or names of joints.

    Raises:
        UnknownNameError: There is no such set of joints, or no such joint.
    """
    if not isinstance(moving, str):
        for joint in moving:
            if joint not in agent.joints:
                raise UnknownNameError("joint", joint, agent.joints, where=agent.name)
        return moving
    if moving == "body":
        return agent.joints
    if moving not in MOVING:
        raise UnknownNameError("set of joints", moving, ("body", *MOVING))
    return [joint for joint in agent.joints if any(word in joint for word in MOVING[moving])]


DIRECTION_COST_M = 0.15
"""Lever with which an error of direction (radians) counts like an error of place (metres)."""
STEP_DAMPING = 3e-4
"""Pull of a step towards none: joints that the targets hardly decide would else swing to and fro. With 3e-4 a frame of
noisy keypoints needs 6 steps, with 1e-6 it needs 14 and ends no better."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted state and how well it meets its targets.

    Attributes:
        state: The state with the agent fitted.
        errors_m: Distance in metres between each landmark and its target.
        errors_rad: Angle between each direction and its target.
    """

    state: State
    errors_m: Mapping[str, float]
    errors_rad: Mapping[str, float]


class Fitter:
    """Fits one agent of a scene, other things staying where they are.

    Args:
        scene: The scene.
        agent: Name of the agent to fit.
        moving: A name of ``MOVING``, ``"body"``, or the names of the joints that may move.
        root: Whether the root moves too; by default with ``"body"`` only.
        weights: Relative cost of a landmark or direction; 1 where none is given.
        markers: Points that are no landmarks of the body but lie beside one, by the names that ``fit`` gets them under.
        axes: Directions of the body that differ from ``AXES``, or are not among them: a landmark, and the axis in its
            frame, of length 1.
        damping: Pull of a step towards none; less than by default where the targets are exact.
    """

    def __init__(
        self,
        scene: Scene,
        agent: str,
        *,
        moving: str | Collection[str] = "body",
        root: bool | None = None,
        weights: Mapping[str, float] | None = None,
        markers: Mapping[str, Marker] | None = None,
        axes: Mapping[str, Axis] | None = None,
        damping: float = STEP_DAMPING,
    ) -> None:
        self._damping = damping
        self._markers = dict(markers or {})
        self._axes = {**AXES, **(axes or {})}
        self._weights = dict(weights or {})
        self._alone = alone(scene, agent)
        self._agent = self._alone.agent
        self._tree = joint_tree(self._alone.model, self._agent)
        chosen = set(chosen_joints(self._agent, moving))
        self._free = np.array([j for j, name in enumerate(self._tree.names) if name in chosen], dtype=np.intp)
        self._limits = self._tree.limits[self._free]
        self._posture = posture_costs([self._tree.names[joint] for joint in self._free])
        moves = moving == "body" if root is None else root
        self._active = np.zeros((ROOT_DOFS if moves else 0) + len(self._free), dtype=np.int8)
        self._known: dict[tuple[tuple[str, ...], tuple[str, ...]], Features] = {}

    def fit(
        self,
        state: State,
        *,
        points: Mapping[str, ArrayLike] | None = None,
        directions: Mapping[str, ArrayLike] | None = None,
        rest: State | None = None,
        iterations: int = 30,
    ) -> Fit:
        """Fit the agent.

        Args:
            state: Where to start from; everything but the agent's moving joints stays.
            points: Targets of landmarks in the world, metres, (3,) each; those that are not finite are left out.
            directions: Targets of directions (``AXES``) in the world, (3,) each.
            rest: The posture that joints lean to where nothing else decides; by default the one to start from.
            iterations: Most Gauss-Newton steps.

        Raises:
            UnknownNameError: The model has no such landmark or direction.
        """
        wanted = {name: np.asarray(p, dtype=float) for name, p in (points or {}).items() if np.all(np.isfinite(p))}
        aimed = {name: np.asarray(d, dtype=float) for name, d in (directions or {}).items() if np.all(np.isfinite(d))}
        features = self.features(wanted, aimed)
        targets = self.targets(features, [*wanted.values(), *aimed.values()])
        self._active[:] = 0  # the answer hangs on nothing that was fitted before
        qpos = self.settle(features, state.qpos, targets, rest=(rest or state).qpos, iterations=iterations)
        errors = self.errors(features, qpos[None], targets[None])[0].tolist()
        count = len(wanted)
        return Fit(
            State(qpos, state.time_s, state.untracked),
            dict(zip(wanted, errors[:count], strict=True)),
            dict(zip(aimed, errors[count:], strict=True)),
        )

    # --- By arrays: names are looked up once for many frames.

    def features(self, points: Iterable[str], directions: Iterable[str] = ()) -> Features:
        """The points and directions of some names, to give targets for.

        Raises:
            UnknownNameError: The model has no such landmark or direction.
        """
        key = tuple(points), tuple(directions)
        if key not in self._known:
            self._known[key] = self._looked_up(*key)
        return self._known[key]

    def targets(self, features: Features, places: ArrayLike) -> Array:
        """Targets of features, points first: metres, and directions of any length, (f, 3) or (n, f, 3), all finite."""
        targets = np.array(places, dtype=float).reshape(-1, 3)
        aimed = targets[len(features.points) :]
        aimed /= np.linalg.norm(aimed, axis=1, keepdims=True)
        return targets

    def settle(self, features: Features, qpos: Array, targets: Array, *, rest: Array, iterations: int) -> Array:
        """Fit the agent: the scene's positions, (nq,).

        Args:
            features: What targets are given for.
            qpos: Where to start from, (nq,).
            targets: Where each is to be in the world, metres, or point, of length 1, (f, 3); NaN leaves it out.
            rest: The posture that joints lean to where nothing else decides, (nq,).
            iterations: Most Gauss-Newton steps.
        """
        tree, own = self._tree, self._alone.qpos(qpos)
        base, values = own[self._agent.base], tree.values(own)
        descend(
            tree.joints,
            tree.parents,
            self._free,
            self._limits,
            features.rows,
            features.carriers,
            targets,
            self._posture,
            tree.values(self._alone.qpos(rest))[self._free],
            base,
            values,
            self._active,
            self._damping,
            iterations,
        )
        own[tree.columns] = values + tree.zero
        return self._alone.within(qpos, own)

    def places(self, features: Features, qpos: Array) -> Array:
        """Where points are, metres, and directions point, of length 1, in positions of the scene (n, nq), (n, f, 3)."""
        tree, own = self._tree, np.ascontiguousarray(qpos[:, self._alone.columns])
        roots = np.ascontiguousarray(own[:, self._agent.base])
        return places_of(tree.joints, tree.parents, features.rows, features.carriers, roots, tree.values(own))

    def errors(self, features: Features, qpos: Array, targets: Array) -> Array:
        """How far features are from their targets: metres, and for directions radians; NaN where there is none, (n, f).

        Args:
            features: What targets are given for.
            qpos: Positions of the scene, (n, nq).
            targets: Where each is to be in the world, metres, or point, of length 1, (n, f, 3).
        """
        places = self.places(features, qpos)
        away, first = np.linalg.norm(places - targets, axis=2), len(features.points)
        cosines = np.sum(places[:, first:] * targets[:, first:], axis=2)
        away[:, first:] = np.arccos(np.clip(cosines, -1.0, 1.0))
        return np.asarray(away)

    def _looked_up(self, points: Sequence[str], directions: Sequence[str]) -> Features:
        data, carrier = self._tree.data, self._tree.carrier
        rows = np.zeros((len(points) + len(directions), FEATURE_COLUMNS))
        carriers = np.full((len(rows), 2), NOWHERE)
        for row, name in enumerate(points):
            marker = self._markers.get(name, Marker(name, (0.0, 0.0, 0.0)))
            site, frame = self._site(marker.landmark), self._site(marker.axes or marker.landmark)
            rows[row, WEIGHT] = self._weights.get(name, 1.0)
            rows[row, PLACE:LEVER] = data.site_xpos[site]
            rows[row, LEVER:] = data.site_xmat[frame].reshape(3, 3) @ np.array(marker.offset_m)
            carriers[row] = [carrier[self._alone.model.site_bodyid[each]] for each in (site, frame)]
        for row, name in enumerate(directions, start=len(points)):
            landmark, axis = self._axis(name)
            site = self._site(landmark)
            rows[row, WEIGHT] = DIRECTION_COST_M * self._weights.get(name, 1.0)
            rows[row, LEVER:] = data.site_xmat[site].reshape(3, 3) @ np.array(axis)
            carriers[row, 1] = carrier[self._alone.model.site_bodyid[site]]
        return Features(tuple(points), tuple(directions), rows, carriers)

    def _axis(self, name: str) -> Axis:
        if name not in self._axes:
            raise UnknownNameError("direction", name, self._axes, where=self._agent.name)
        return self._axes[name]

    def _site(self, landmark: str) -> int:
        model, name = self._alone.model, self._agent.name
        site = int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, f"{name}/{landmark}"))
        if site < 0:
            raise UnknownNameError("landmark", landmark, landmarks_in(model, name))
        return site
