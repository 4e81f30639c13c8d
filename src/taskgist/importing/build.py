"""From tracks to a recording: a scene is made, bodies are fitted, and everything unknown stays marked so."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from xml.sax.saxutils import quoteattr

import numpy as np

from taskgist.common.workers import Progress, silent
from taskgist.errors import MappingError, SceneError
from taskgist.importing.bodies import BodyTrack, body_toml, estimate_size, fit_person
from taskgist.importing.mapping import ImportMapping, Shape, Support
from taskgist.importing.tracks import ObjectTrack, Tracks, read_tracks
from taskgist.recording.recording import Recording
from taskgist.world.bodies.human import HumanSize
from taskgist.world.geometry.transforms import about_z
from taskgist.world.scene import Scene

ROOM = "room.xml"
WOOD, COLOURS = "0.62 0.47 0.32 1", ("0.80 0.25 0.22 1", "0.20 0.45 0.70 1", "0.30 0.60 0.35 1", "0.75 0.60 0.20 1")


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
    about = replace(
        mapping.about,
        notes=(*tracks.notes, *(note for body in bodies.values() for note in body.notes)),
        fit={name: dict(body.report) for name, body in bodies.items()},
    )
    return Recording(
        scene=scene,
        times_s=tracks.times_s,
        qpos=_positions(scene, tracks, bodies),
        tracked=_tracked(tracks, bodies),
        label=mapping.label,
        provenance=about,
        name=mapping.name,
        signals=tracks.signals,
    )


def build_scene(mapping: ImportMapping, tracks: Tracks, sizes: Mapping[str, HumanSize]) -> Scene:
    """The scene of a mapping: floor, supports, objects, and bodies of the people's size."""
    meshes = {
        f"{name}_{number}{shape.mesh.suffix}": shape.mesh.read_bytes()
        for name, track in tracks.objects.items()
        for number, shape in enumerate(track.shapes)
        if shape.mesh
    }
    bundle = {
        "scene.toml": _scene_toml(mapping, tracks, sizes).encode(),
        ROOM: _room_mjcf(tracks).encode(),
        **meshes,
    }
    return Scene.from_bundle(bundle, where=str(mapping.file))


def _size(mapping: ImportMapping, name: str, tracks: Tracks) -> HumanSize:
    person = tracks.people[name]
    try:
        return estimate_size(person.points, person.stature_m)
    except SceneError as error:
        hint = "check units and which points are which landmarks, or give stature_m"
        raise MappingError(
            error.problem, where=mapping.file, field=f"people.{name}.{error.field}", value=error.value, hint=hint
        ) from error


def _scene_toml(mapping: ImportMapping, tracks: Tracks, sizes: Mapping[str, HumanSize]) -> str:
    estimated = [f'"{support.name}"' for support in tracks.supports if support.estimated]
    estimated += [f'"{name}"' for name, track in tracks.objects.items() if track.estimated]
    lines = ["[scene]", f'name = "{mapping.name}"', f'model = "{ROOM}"', f"estimated = [{', '.join(estimated)}]"]
    for name, size in sizes.items():
        lines += ["", f'[agents."{name}"]', 'profile = "human"', f"body = {body_toml(size)}"]
    return "\n".join(lines) + "\n"


def _room_mjcf(tracks: Tracks) -> str:
    meshes = [
        f'<mesh name="{name}_{number}" file="{name}_{number}{shape.mesh.suffix}" '
        f'scale="{_numbers([shape.scale_m] * 3)}"/>'
        for name, track in tracks.objects.items()
        for number, shape in enumerate(track.shapes)
        if shape.mesh
    ]
    bodies = [_support(support) for support in tracks.supports]
    bodies += [
        _object(name, track, COLOURS[i % len(COLOURS)]) for i, (name, track) in enumerate(tracks.objects.items())
    ]
    return "\n".join(
        (
            '<mujoco model="imported room">',
            f"<asset>{''.join(meshes)}</asset>" if meshes else "",
            '<worldbody><geom name="floor" type="plane" size="5 5 0.1" rgba="0.8 0.8 0.8 1"/>',
            *bodies,
            "</worldbody></mujoco>",
        )
    )


def _support(support: Support) -> str:
    size = _numbers(edge / 2 for edge in support.size_m)
    pose = f'pos="{_numbers(support.position_m)}" quat="{_numbers(about_z(support.yaw_rad))}"'
    return f'<body name={quoteattr(support.name)} {pose}><geom type="box" size="{size}" rgba="{WOOD}"/></body>'


def _object(name: str, track: ObjectTrack, rgba: str) -> str:
    geoms = "".join(_geom(f"{name}_{number}", shape, rgba) for number, shape in enumerate(track.shapes))
    return f"<body name={quoteattr(name)}><freejoint/>{geoms}</body>"


def _geom(mesh_name: str, shape: Shape, rgba: str) -> str:
    wxyz = np.array(shape.wxyz)
    if shape.kind == "mesh":
        kind = f'type="mesh" mesh="{mesh_name}"'
    elif shape.kind == "box":
        kind = f'type="box" size="{_numbers(edge / 2 for edge in shape.size_m)}"'
    elif shape.kind == "cylinder":
        kind = f'type="cylinder" size="{_numbers((shape.size_m[0], shape.size_m[1] / 2))}"'
    else:
        kind = f'type="sphere" size="{_numbers(shape.size_m)}"'
    return f'<geom {kind} pos="{_numbers(shape.position_m)}" quat="{_numbers(wxyz)}" rgba="{rgba}"/>'


def _numbers(values: object) -> str:
    return " ".join(f"{float(value):.6g}" for value in values)  # type: ignore[attr-defined]


def _positions(scene: Scene, tracks: Tracks, bodies: Mapping[str, BodyTrack]) -> np.ndarray:
    """Positions (N, nq): each body from its own fit, each object from its track; fillers where unknown."""
    qpos = np.tile(scene.initial.qpos, (len(tracks.times_s), 1))
    for name, body in bodies.items():
        qpos[:, scene.base_slice(name)] = body.base
        qpos[:, scene.joint_indices(name)] = body.joints_rad
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


def _tracked(tracks: Tracks, bodies: Mapping[str, BodyTrack]) -> dict[str, np.ndarray]:
    tracked = {name: track.known for name, track in tracks.objects.items()}
    for name, body in bodies.items():
        tracked |= {f"{name}/{part}": known for part, known in body.tracked.items()}
    return {name: known for name, known in tracked.items() if not known.all()}
