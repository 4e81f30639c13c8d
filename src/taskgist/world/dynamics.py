"""Dynamics: how things move when nobody holds them, among everything else, which keeps still.

Scenes are made for geometry. For motion, MuJoCo gets a model of its own: the things as free, uniform bodies, and all
other solid shapes fixed where they are. Where a single thing moves, its mass does not matter, only how it is spread;
several are all taken to be of the same density. Example::

    motion = free_motion(scene, state, "cup", passing=["P1/right_arm"])  # which has just let it go
    motion.at(times_s)  # it fell onto the table
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from taskgist.common.arrays import Array
from taskgist.errors import SceneError
from taskgist.world.geometry.shapes import hull_triangles
from taskgist.world.geometry.transforms import conjugate, normalized, rotate, wxyz_from_matrix
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State

Geom = mujoco.mjtGeom

GRAVITY_M_S2 = 9.81
STEP_S, SUBSTEPS = 0.002, 4
"""Time between two poses, and MuJoCo's steps in it: at 5 m/s a thing moves by less than the thinnest boards in one."""
CONTACT_S, STIFFNESS = 0.001, (0.95, 0.999, 0.001, 0.5, 2.0)
"""Time constant and impedance of contacts: at 4 m/s a thing dips by about a millimetre into what it meets."""
DENSITY_KG_M3 = 300.0
"""Density of things (ours: boxes and vessels with air in them)."""
FULL_CONTACT, ROLLING_M = 6, 5e-4
"""Contacts resist sliding, turning and rolling; and how much (torque over load), where the model does not say it."""
RESTING_M_S, RESTING_RAD_S, RESTING_S = 0.005, 0.05, 0.15
"""What is slower than this for that long has come to rest."""
LONGEST_S = 4.0
BODY = "thing"


@dataclass(frozen=True, eq=False)
class FreeMotion:
    """A motion by physics alone.

    Attributes:
        poses: Position in metres and wxyz of the thing's frame, (n, 7), in steps of ``STEP_S`` from 0 on; read-only.
        rests: Whether it came to rest, or else the time was up.
        touches_s: When it first touches something; infinity: never.
    """

    poses: Array
    rests: bool
    touches_s: float

    def __post_init__(self) -> None:
        poses = np.array(self.poses, dtype=float)
        poses.flags.writeable = False
        object.__setattr__(self, "poses", poses)

    def __reduce__(self) -> tuple[object, ...]:
        return FreeMotion, (np.array(self.poses), self.rests, self.touches_s)

    @property
    def times_s(self) -> Array:
        """Times from the beginning, seconds, (n,)."""
        return np.arange(len(self.poses), dtype=np.float64) * STEP_S

    @property
    def end(self) -> Array:
        """Where it ends: position in metres and wxyz, (7,)."""
        return np.array(self.poses[-1])

    @property
    def duration_s(self) -> float:
        """How long it moves, until it is known to rest."""
        return (len(self.poses) - 1) * STEP_S

    def at(self, times_s: ArrayLike) -> Array:
        """Poses at some times, (t, 7); at the first and the last one it stays before and after."""
        place = np.clip(np.asarray(times_s, dtype=float) / STEP_S, 0.0, len(self.poses) - 1.0)
        before = np.floor(place).astype(np.intp)
        after = np.minimum(before + 1, len(self.poses) - 1)
        share = (place - before)[:, None]
        mixed = (1.0 - share) * self.poses[before] + share * self.poses[after]
        mixed[:, 3:] = normalized(mixed[:, 3:])
        return np.asarray(mixed)


def free_motion(
    scene: Scene,
    state: State,
    name: str,
    *,
    linear_m_s: ArrayLike = (0.0, 0.0, 0.0),
    angular_rad_s: ArrayLike = (0.0, 0.0, 0.0),
    passing: Iterable[str] = (),
    longest_s: float = LONGEST_S,
) -> FreeMotion:
    """Let one thing move freely until it rests: gravity, contacts and friction, by MuJoCo.

    Args:
        scene: The scene.
        state: Where everything is; all but the thing stays there.
        name: The thing, an object of the scene.
        linear_m_s: Velocity of its frame's origin at the start, in the world, (3,).
        angular_rad_s: Its angular velocity at the start, in the world, (3,).
        passing: What it passes through: objects, agents, or parts of these such as "P1/right_arm".
        longest_s: When to stop if it still moves.

    Raises:
        SceneError: The thing has no shape, or one without inside, so that nothing can be said of its motion.
        UnknownNameError: There is no such object.
    """
    motion = free_motions(
        scene,
        state,
        (name,),
        linear_m_s=linear_m_s,
        angular_rad_s=angular_rad_s,
        passing=passing,
        longest_s=longest_s,
    )
    return motion[name]


def free_motions(
    scene: Scene,
    state: State,
    names: Sequence[str],
    *,
    linear_m_s: ArrayLike = (0.0, 0.0, 0.0),
    angular_rad_s: ArrayLike = (0.0, 0.0, 0.0),
    passing: Iterable[str] = (),
    longest_s: float = LONGEST_S,
) -> dict[str, FreeMotion]:
    """Let some things move freely, and against each other, until all of them rest.

    Args:
        scene: The scene.
        state: Where everything is; all but the things stays there.
        names: The things, objects of the scene, each once.
        linear_m_s: Velocity of the first one, as in ``free_motion``; the others begin at rest.
        angular_rad_s: Its angular velocity.
        passing: What all of them pass through.
        longest_s: When to stop if one of them still moves.

    Returns:
        The motion of each, all equally long.

    Raises:
        SceneError: A thing has no shape, or one without inside, so that nothing can be said of its motion.
        UnknownNameError: There is no such object.
    """
    model = _model(scene, state.without(passing), names)
    data = mujoco.MjData(model)
    data.qpos[:] = np.concatenate([state.qpos[scene.object_slice(name)] for name in names])
    data.qvel[:3] = linear_m_s
    data.qvel[3:6] = rotate(conjugate(data.qpos[3:7]), angular_rad_s)  # MuJoCo tells it in the body's frame
    poses, touches_s, resting, count = [data.qpos.copy()], [np.inf] * len(names), 0, round(longest_s / STEP_S)
    while len(poses) <= count and resting * STEP_S < RESTING_S:
        mujoco.mj_step(model, data, SUBSTEPS)
        poses.append(data.qpos.copy())
        touching = {int(body) for body in model.geom_bodyid[data.contact.geom].ravel()} if data.ncon else set()
        for index in range(len(names)):
            if index + 1 in touching and not np.isfinite(touches_s[index]):
                touches_s[index] = (len(poses) - 1) * STEP_S
        resting = resting + 1 if _is_slow(data) else 0
    each = np.array(poses).reshape(len(poses), len(names), 7)
    rests = resting * STEP_S >= RESTING_S
    return {name: FreeMotion(each[:, index], rests, touches_s[index]) for index, name in enumerate(names)}


def _is_slow(data: mujoco.MjData) -> bool:
    """Whether all things are slow."""
    squares = (data.qvel.reshape(-1, 2, 3) ** 2).sum(axis=2).max(axis=0)
    return bool(squares[0] < RESTING_M_S**2 and squares[1] < RESTING_RAD_S**2)


def _model(scene: Scene, state: State, names: Sequence[str]) -> mujoco.MjModel:
    """The things as free bodies, in the frames of their bodies in the scene, among fixed shapes."""
    stage = Stage(scene, state)
    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.gravity = STEP_S / SUBSTEPS, (0.0, 0.0, -GRAVITY_M_S2)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    for name in names:
        frame = stage.body(scene.object_body(name))
        thing = spec.worldbody.add_body(name=f"{BODY} {name}")
        thing.add_freejoint()
        for geom in scene.solid_geoms_of(name).tolist():
            pose = stage.geom(geom)
            _add(spec, thing, scene.model, geom, frame.to_local(pose.position), frame.matrix.T @ pose.matrix)
    for geom in stage.solid_geoms().tolist():
        if scene.owners[geom] not in names:
            pose = stage.geom(geom)
            _add(spec, spec.worldbody, scene.model, geom, pose.position, pose.matrix)
    try:
        return spec.compile()
    except ValueError as error:
        hint = "give it a solid shape, such as a box"
        raise SceneError(
            f"MuJoCo cannot move it: {error}", where=scene.name, field=", ".join(names), hint=hint
        ) from error


def _add(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, model: mujoco.MjModel, geom: int, position: Array, matrix: Array
) -> None:
    """Add a copy of a shape, with its own friction, to a body."""
    added = body.add_geom(type=Geom(int(model.geom_type[geom])), density=DENSITY_KG_M3)
    added.pos, added.quat = position, wxyz_from_matrix(matrix)
    added.friction, added.condim = model.geom_friction[geom], FULL_CONTACT
    if model.geom_condim[geom] < FULL_CONTACT:
        added.friction[2] = ROLLING_M
    added.priority, added.solref, added.solimp = int(model.geom_priority[geom]), (CONTACT_S, 1.0), STIFFNESS
    if added.type == Geom.mjGEOM_MESH:
        added.meshname = f"mesh {geom}"
        corners = np.unique(hull_triangles(model, int(model.geom_dataid[geom])).reshape(-1, 3), axis=0)
        spec.add_mesh(name=added.meshname, uservert=corners.ravel())
    else:
        added.size = model.geom_size[geom]
