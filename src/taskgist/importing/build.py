"""From tracks to a recording: a scene is made, bodies are fitted, and everything unknown stays marked so."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import mujoco
import numpy as np

from taskgist.common.files import read_whole
from taskgist.common.workers import Progress, silent
from taskgist.errors import MappingError, SceneError
from taskgist.importing.bodies import BodyTrack, entry_of, fit_person
from taskgist.importing.floor import floor_problem, floor_remedy, off_the_floor_m
from taskgist.importing.mapping import ImportMapping, Shape, Support
from taskgist.importing.robots import robot_entry, robot_positions
from taskgist.importing.sizes import estimate_size
from taskgist.importing.tracks import ObjectTrack, Tracks, read_tracks
from taskgist.recording.recording import Recording
from taskgist.settings import DEFAULT
from taskgist.world.bodies.human import GROUP, HumanSize
from taskgist.world.geometry.transforms import about_z
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage

Colour = tuple[float, float, float, float]
"""Red, green, blue and opacity."""

FLOOR_SIZE_M = (5.0, 5.0, 0.1)
"""What of the endless floor is drawn: half sizes, and the spacing of its lines."""
WOOD: Colour = (0.62, 0.47, 0.32, 1.0)
COLOURS: tuple[Colour, ...] = (
    (0.80, 0.25, 0.22, 1.0),
    (0.20, 0.45, 0.70, 1.0),
    (0.30, 0.60, 0.35, 1.0),
    (0.75, 0.60, 0.20, 1.0),
)


def import_recording(mapping: ImportMapping, progress: Progress = silent) -> Recording:
    """Bring a mapping's tables in as a recording.

    Args:
        mapping: The mapping.
        progress: Told how far it is.

    Raises:
        MappingError: Tables or values cannot be right.
    """
    progress("reading tables", 0.0)
    tracks = read_tracks(mapping)
    sizes = {name: _size(mapping, name, tracks) for name in tracks.people}
    scene = build_scene(mapping, tracks, sizes)
    bodies: dict[str, BodyTrack] = {}
    for number, (name, person) in enumerate(tracks.people.items()):

        def of_this(share: float, number: int = number, name: str = name) -> None:
            progress(f"fitting {name}", (number + share) / len(tracks.people))

        bodies[name] = fit_person(name, sizes[name], person, of_this)
    qpos = _positions(scene, tracks, bodies)
    doubtful = {name: _doubtful_legs(scene, qpos, name, body) for name, body in bodies.items()}
    about = replace(
        mapping.about,
        notes=(
            *tracks.notes,
            *(note for body in bodies.values() for note in body.notes),
            *(_doubt(name, frames) for name, frames in doubtful.items() if frames.any()),
        ),
        fit={name: dict(body.report) for name, body in bodies.items()},
    )
    recording = Recording(
        scene=scene,
        times_s=tracks.times_s,
        qpos=qpos,
        tracked=_tracked(tracks, bodies, doubtful),
        label=mapping.label,
        provenance=about,
        name=mapping.name,
        signals=tracks.signals,
    )
    notes = (*about.notes, *_floor_notes(recording))
    return recording if notes == about.notes else replace(recording, provenance=replace(about, notes=notes))


def _floor_notes(recording: Recording) -> Iterator[str]:
    stage = Stage(recording.scene)
    for name in recording.scene.agents:
        height_m = off_the_floor_m(recording, name, stage)
        if height_m is not None:
            yield f"{name}: {floor_problem(height_m)}: {floor_remedy(name, height_m)}"


def _size(mapping: ImportMapping, name: str, tracks: Tracks) -> HumanSize:
    person = tracks.people[name]
    try:
        return estimate_size(person.points, person.stature_m, person.markers)
    except SceneError as error:
        hint = "check units and which points are which landmarks, or give stature_m"
        raise MappingError(
            error.problem, where=mapping.file, field=f"people.{name}.{error.field}", value=error.value, hint=hint
        ) from error


def build_scene(mapping: ImportMapping, tracks: Tracks, sizes: Mapping[str, HumanSize]) -> Scene:
    """The scene of a mapping: floor, supports, objects, robots, and bodies of the people's size."""
    room = mujoco.MjSpec()
    room.modelname = "imported room"
    room.worldbody.add_geom(
        name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=FLOOR_SIZE_M, rgba=(0.8, 0.8, 0.8, 1.0)
    )
    for support in tracks.supports:
        _add_support(room, support)
    for number, (name, track) in enumerate(tracks.objects.items()):
        _add_object(room, name, track, COLOURS[number % len(COLOURS)])
    estimated = [support.name for support in tracks.supports if support.estimated]
    estimated += [name for name, track in tracks.objects.items() if track.estimated]
    return Scene.from_spec(
        room,
        [
            *(entry_of(name, size) for name, size in sizes.items()),
            *(robot_entry(name, robot.profile) for name, robot in tracks.robots.items()),
        ],
        name=mapping.name,
        estimated=estimated,
        where=str(mapping.file),
    )


def _add_support(room: mujoco.MjSpec, support: Support) -> None:
    body = room.worldbody.add_body(name=support.name, pos=support.position_m, quat=about_z(support.yaw_rad))
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=np.array(support.size_m) / 2, rgba=WOOD)


def _add_object(room: mujoco.MjSpec, name: str, track: ObjectTrack, rgba: Colour) -> None:
    body = room.worldbody.add_body(name=name)
    body.add_freejoint()
    for number, shape in enumerate(track.shapes):
        geom = body.add_geom(pos=shape.position_m, quat=shape.wxyz, rgba=rgba)
        if shape.mesh:
            geom.type, geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, f"{name}_{number}"
            file = f"{name}_{number}{shape.mesh.suffix}"
            content = read_whole(
                shape.mesh, most_bytes=DEFAULT.limits.mesh_bytes, setting="mesh_bytes", error=MappingError
            )
            room.assets = {**room.assets, file: content}
            room.add_mesh(name=geom.meshname, file=file, scale=[shape.scale_m] * 3)
        else:
            geom.type, geom.size = _size_of_geom(shape)


def _size_of_geom(shape: Shape) -> tuple[mujoco.mjtGeom, tuple[float, float, float]]:
    """Kind and size of a shape without a mesh as MuJoCo has them: half edges; radius and half height; radius."""
    if shape.kind == "box":
        x, y, z = shape.size_m
        return mujoco.mjtGeom.mjGEOM_BOX, (x / 2, y / 2, z / 2)
    if shape.kind == "cylinder":
        radius, height = shape.size_m
        return mujoco.mjtGeom.mjGEOM_CYLINDER, (radius, height / 2, 0.0)
    return mujoco.mjtGeom.mjGEOM_SPHERE, (shape.size_m[0], 0.0, 0.0)


def _positions(scene: Scene, tracks: Tracks, bodies: Mapping[str, BodyTrack]) -> np.ndarray:
    """Positions (N, nq): each body from its own fit, each object from its track; fillers where unknown."""
    qpos = np.tile(scene.initial.qpos, (len(tracks.times_s), 1))
    for name, body in bodies.items():
        qpos[:, scene.base_slice(name)] = body.base
        qpos[:, scene.joint_indices(name)] = body.joints_rad
    for name, robot in tracks.robots.items():
        own = [*range(scene.nq)[scene.base_slice(name)], *scene.joint_indices(name)]
        qpos[:, own] = _filled(robot_positions(scene, name, robot)[:, own], robot.known)
    for name, track in tracks.objects.items():
        pose = np.concatenate((track.position_m, track.wxyz), axis=1)
        qpos[:, scene.object_slice(name)] = _filled(pose, track.known)
    return qpos


def _filled(values: np.ndarray, known: np.ndarray) -> np.ndarray:
    """The last known row where a row is unknown, the first known one before that."""
    if not known.any():
        filler = np.tile((0.0, 0.0, -100.0, 1.0, 0.0, 0.0, 0.0), (len(values), 1))
        return filler[:, : values.shape[1]]
    last = np.maximum.accumulate(np.where(known, np.arange(len(values)), -1))
    return np.asarray(values[np.where(last < 0, np.argmax(known), last)])


# --- Legs that nobody tracked, under hips too low for who stands: sitting, crouching, kneeling, or a floor elsewhere?
#
# The height of the hips alone does not tell. A seat beneath them does.

SEAT_SLACK_M = 0.12
"""How much higher than on a firm seat hips may be over one that was estimated (ours)."""
NOT_PEOPLE = np.array([group != GROUP for group in range(mujoco.mjNGROUP)], dtype=np.uint8)
"""Groups of shapes that a seat is looked for among."""


def _doubtful_legs(scene: Scene, qpos: np.ndarray, name: str, body: BodyTrack) -> np.ndarray:
    """Frames in which a person's estimated legs are not to be believed, (N,)."""
    doubtful = np.array(body.low & body.tracked["legs"])
    agent, data = scene.agent(name), mujoco.MjData(scene.model)
    most_m = agent.profile.legs.seat_share * agent.stature_m + SEAT_SLACK_M
    geom = np.zeros(1, dtype=np.int32)
    for frame in np.flatnonzero(doubtful):
        data.qpos[:] = qpos[frame]
        mujoco.mj_kinematics(scene.model, data)
        pelvis = data.xpos[agent.root_body]
        down = mujoco.mj_ray(scene.model, data, pelvis, np.array((0.0, 0.0, -1.0)), NOT_PEOPLE, 1, -1, geom)
        on_seat = 0.0 <= down <= most_m and scene.model.geom_bodyid[geom[0]] > 0  # 0 is the room itself: its floor
        doubtful[frame] = not on_seat
    return doubtful


def _doubt(name: str, frames: np.ndarray) -> str:
    share = f"{100 * frames.mean():.0f} % of the frames"
    return (
        f"{name}'s legs are unknown in {share}: nobody tracked them, and the hips are too low for who stands, with no "
        f"seat beneath; add the seat as [supports.NAME], or check the height of the floor"
    )


def _tracked(
    tracks: Tracks, bodies: Mapping[str, BodyTrack], doubtful: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    tracked = {name: track.known for name, track in tracks.objects.items()}
    tracked |= {name: robot.known for name, robot in tracks.robots.items()}
    for name, body in bodies.items():
        tracked |= {f"{name}/{part}": known for part, known in body.tracked.items()}
        tracked[f"{name}/legs"] = body.tracked["legs"] & ~doubtful[name]
    return {name: known for name, known in tracked.items() if not known.all()}
