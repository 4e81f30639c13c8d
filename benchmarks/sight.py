"""Seeing: the pixels of one object, and of all, beside renderers and ray casters that draw the whole image."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from statistics import median

import numpy as np

from benchmarks.figure import Bound, Figure
from benchmarks.peers.bullet import TinyRenderer
from benchmarks.peers.embree import Embree
from benchmarks.peers.eye_view import EyeView
from benchmarks.peers.gl import SegmentationRenderer
from benchmarks.peers.multi_ray import MultiRay
from benchmarks.rooms import furnished
from benchmarks.timing import Run, in_turn, seconds, work
from taskgist.perspective import view_of, visibility
from taskgist.world import Scene, Stage

AGENTS, OBJECTS, MOST_SHARE = 3, 12, 0.03
OUTLINE_PX, OUTLINE_SHARE = 3, 0.05
"""What has few pixels is counted in parts of them: these are more exact than whole ones."""
TWIN, CONE, OURS_WHOLE = MultiRay.name, "embree, same bounding cone", "our own whole image"
PEERS = (MultiRay, SegmentationRenderer, TinyRenderer, Embree)


def figures() -> Iterator[Figure]:
    """One object from one eye, and all objects from one eye."""
    scene = furnished(AGENTS, OBJECTS)
    stage = Stage(scene)
    agent = max(scene.agents, key=lambda name: len(_small(stage, name)))
    with peers(scene, agent) as whole:
        yield one_object(stage, agent, whole)
        yield all_objects(stage, agent, whole)


def _small(stage: Stage, agent: str) -> dict[str, int]:
    """Pixels of the objects that an agent sees and that fill up to three per cent of its image."""
    view = view_of(stage, agent)
    pixels = view.pixels()
    most = MOST_SHARE * view.geoms.size
    return {name: pixels[name] for name in stage.scene.objects if 0 < pixels.get(name, 0) <= most}


@contextmanager
def peers(scene: Scene, agent: str) -> Iterator[dict[str, Run]]:
    """Every renderer that works here, by name: each call draws or casts the whole image of an agent's eye."""
    view = EyeView.of(scene, scene.initial, agent)
    stage = Stage(scene)
    with ExitStack() as stack:
        found: dict[str, Run] = {OURS_WHOLE: lambda: view_of(stage, agent)}
        for peer in PEERS:
            try:
                made = peer(view)
            except (ImportError, RuntimeError):
                continue
            stack.callback(made.close)
            found[peer.name] = made.image
        yield found


def one_object(stage: Stage, agent: str, whole: dict[str, Run]) -> Figure:
    """The median over all objects that fill up to three per cent of the image."""
    names = _small(stage, agent)
    assert names
    times: dict[str, list[float]] = {}
    rays: list[int] = []
    for name in names:
        seen = visibility(stage, agent, name)
        assert seen is not None
        assert abs(seen.visible_px - names[name]) <= OUTLINE_PX + OUTLINE_SHARE * names[name]

        def ours(name: str = name) -> object:
            return visibility(stage, agent, name)

        for who, taken in in_turn({"ours": ours, **_in_cone(stage, agent, name)}, repeats=25).items():
            times.setdefault(who, []).append(taken)
        rays.append(work(stage, ours)["rays"])
    beside = in_turn(whole, repeats=5) | {who: median(found) for who, found in times.items() if who != "ours"}
    fastest = min((taken for who, taken in beside.items() if who not in (OURS_WHOLE, TWIN, CONE)), default=np.inf)
    mine = median(times["ours"])
    return Figure(
        "sight",
        f"visible pixels of one object, {len(names)} objects up to 3 % of 320 × 240, {AGENTS} agents",
        mine,
        beside,
        goal="20 × faster than mj_multiRay, 10 × than the fastest whole-image peer",
        met=beside[TWIN] / mine >= 20 and fastest / mine >= 10,
        counts={"rays": median(rays), "pixels": median(names.values())},
        bound=_rays_alone(stage, agent, median(rays)),
    )


def _in_cone(stage: Stage, agent: str, name: str) -> dict[str, Run]:
    """Embree with only the rays of the object's bounding cone, where it is installed."""
    try:
        embree = Embree(EyeView.of(stage.scene, stage.state, agent))
    except ImportError:
        return {}
    shapes = stage.scene.object_geoms(name)
    return {CONE: lambda: int(np.isin(embree.cast(embree.cone(shapes)), shapes).sum())}


def all_objects(stage: Stage, agent: str, whole: dict[str, Run]) -> Figure:
    """Every object of the scene from one eye."""

    def ours() -> list[object]:
        return [visibility(stage, agent, name) for name in stage.scene.objects]

    beside = in_turn({"ours": ours, **whole}, repeats=7)
    mine = beside.pop("ours")
    rays = work(stage, ours)["rays"]
    return Figure(
        "sight",
        f"visible pixels of all {len(stage.scene.objects)} objects from one eye",
        mine,
        beside,
        goal="not slower than the fastest whole-image peer",
        met=mine <= min(taken for who, taken in beside.items() if who != OURS_WHOLE),
        counts={"rays": rays},
        bound=_rays_alone(stage, agent, rays),
    )


def _rays_alone(stage: Stage, agent: str, rays: float) -> Bound:
    """What so many rays take if each is held against one shape only, at the speed of our caster."""
    view = EyeView.of(stage.scene, stage.state, agent)
    directions, eye = view.rays(), view.position
    shape = stage.scene.object_geoms(stage.scene.objects[0])[:1]
    speed = len(directions) / seconds(lambda: stage.cast_at(shape, eye, directions))
    return Bound(f"{rays:.0f} rays, each at one shape only, at {speed / 1e6:.0f} M/s", rays / speed)
