"""A recording comes in, and its facts are told: twenty seconds of two people, tracked with noise, and what they handle.

Bodies are fitted beside mink, a quadratic program a step, from the same starts to the same targets.
"""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.figure import Figure
from benchmarks.peers.mink_fit import MinkFitter
from benchmarks.timing import in_turn, once
from taskgist.common.arrays import Array
from taskgist.importing import import_recording, load_mapping
from taskgist.observe import Observer
from taskgist.pipeline import explain_recording, shipped_study, timeline
from taskgist.pipeline.kept_facts import FactsOverTime, facts_from_json
from taskgist.recording import Recording, read, write
from taskgist.world import Fitter, landmarks

SECONDS, RATE_HZ = 20.0, 30.0
NOISE_M = 0.004
FITTED = 90
"""Frames whose fits are held against mink's."""
REPEATS = 3
SPINE = ("pelvis", "chest", "neck", "head", "nose")
SIDED = ("eye", "ear", "shoulder", "elbow", "wrist", "fingertip", "hip", "knee", "ankle", "heel", "toe")
POINTS = (*SPINE, *(f"{side}_{part}" for side, part in itertools.product(("left", "right"), SIDED)))


def figures() -> Iterator[Figure]:
    """Fits, an import, and facts the first and the second time."""
    source = read(shipped_study()["give"][0])
    tracks = {agent: tracked(source, agent) for agent in source.scene.agents}
    yield fits(source, next(iter(tracks.values())))
    with tempfile.TemporaryDirectory() as folder:
        mapping = written(Path(folder), source, tracks)
        yield importing(mapping)
        recording = read(mapping.with_name("take.mcap"))
    yield facts(recording)


def frames_of(source: Recording) -> list[int]:
    """The recording there and back, for as long as is asked for."""
    there = list(range(len(source)))
    way = itertools.cycle((*there, *there[-2:0:-1]))
    return list(itertools.islice(way, int(SECONDS * RATE_HZ)))


def tracked(source: Recording, agent: str) -> Array:
    """Where a tracker sees the landmarks of an agent in each frame, metres, (N, points, 3)."""
    fitter = Fitter(source.scene, agent)
    places = fitter.places(fitter.features(POINTS), np.array([source.qpos[frame] for frame in frames_of(source)]))
    return places + np.random.default_rng(3).normal(scale=NOISE_M, size=places.shape)


def fits(source: Recording, track: Array) -> Figure:
    """A frame of one body, each started from the one before."""
    scene, name = source.scene, source.scene.agents[0]
    assert {*POINTS} <= {*landmarks(scene, name)}
    start = np.array(source.qpos[0])
    fitter, peer = Fitter(scene, name), MinkFitter(scene, name)
    features = fitter.features(POINTS)

    def ours() -> None:
        qpos = start
        for targets in track[:FITTED]:
            qpos = fitter.settle(features, qpos, targets, rest=start, iterations=20)

    def minks() -> None:
        qpos = start
        for targets in track[:FITTED]:
            qpos, _ = peer.fit(qpos, dict(zip(POINTS, targets, strict=True)), {}, rest=start, iterations=20)

    beside = {what: each / FITTED for what, each in in_turn({"mink": minks, "ours": ours}, REPEATS).items()}
    ours_s = beside.pop("ours")
    return Figure("recordings", "fitting a body to 27 points, a frame", ours_s, beside)


def written(folder: Path, source: Recording, tracks: dict[str, Array]) -> Path:
    """A mapping of what was tracked, beside its arrays."""
    things = {
        name: np.array([source.qpos[f][source.scene.object_slice(name)] for f in frames_of(source)])
        for name in source.scene.objects
    }
    np.savez(folder / "take.npz", **{f"of_{name}": array for name, array in (tracks | things).items()})
    names = ", ".join(f'"{name}"' for name in POINTS)
    text = ""
    for name in tracks:
        text += f'[sources.{name}]\nfile = "take.npz"\narray = "of_{name}"\nlayout = ["time", "{{point}}", "value"]\n'
        text += f'names = [{names}]\nrate_hz = {RATE_HZ}\nunits = "m"\n[people.{name}]\nsource = "{name}"\n'
        text += f"[people.{name}.points]\n" + "".join(f'{point} = "{point}"\n' for point in POINTS)
    for name in things:
        text += f'[sources.{name}]\nfile = "take.npz"\narray = "of_{name}"\nrate_hz = {RATE_HZ}\nunits = "m"\n'
        text += 'rotation = { kind = "wxyz", columns = [3, 4, 5, 6] }\n'
        text += (
            f'[objects.{name}]\nsource = "{name}"\nshape = {{ type = "cylinder", radius_m = 0.03, length_m = 0.1 }}\n'
        )
    label = source.label
    assert label is not None
    text += f'[label]\ntask = "give"\nperforming_agent = "{label.performing_agent}"\n'
    text += f'target_agent = "{label.target_agent}"\ntarget_object = "{label.target_object}"\n'
    text += f"start_s = {label.start_s}\nend_s = {label.end_s}\n"
    mapping = folder / "take.toml"
    mapping.write_text(text, encoding="utf-8")
    return mapping


def importing(mapping: Path) -> Figure:
    """Two bodies and their things, from the arrays to the file."""

    def run() -> None:
        write(import_recording(load_mapping(mapping)), mapping.with_name("take.mcap"))

    run()
    ours = min(once(run) for _ in range(REPEATS))
    return Figure("recordings", "importing 20 s of two people", ours, {"its duration": SECONDS})


def facts(recording: Recording) -> Figure:
    """Timelines and effect, watched on one core; and read back from what is kept of them."""
    label = recording.label
    assert label is not None

    def watched() -> FactsOverTime:
        observer = Observer(recording.scene, recording)
        line = timeline(recording, observer, agent=label.target_agent, name=label.target_object)
        return FactsOverTime((line,), explain_recording(recording, observer=observer))

    document = watched().to_json()
    times = in_turn({"ours": watched, "told again": lambda: facts_from_json(document)}, REPEATS)
    ours = times.pop("ours")
    return Figure("recordings", "facts of 20 s of two people", ours, {"its duration": SECONDS, **times})
