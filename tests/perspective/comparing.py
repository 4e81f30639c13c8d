"""Fast and slow answers side by side, for one random room: levels, pixels, and who follows beside who looks afresh."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from taskgist.perspective import ABILITIES, Viewpoint, effort_from, view_of, visibility
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.settings import DEFAULT, Following, Settings
from taskgist.world import Stage, State
from tests.perspective.random_rooms import Case
from tests.perspective.twin import Twin, disagreement
from tests.perspective.twin_world import World
from tools.rooms import COARSE, ROUGH

EXACT = replace(COARSE, following=Following(place_m=0.0, turn_rad=0.0))
"""Every movement is followed, however small."""
FRAMES = 5


@dataclass
class Comparison:
    """How many answers were compared, which levels they had, and where fast and slow differ."""

    count: int = 0
    levels: Counter[tuple[str, int | None]] = field(default_factory=Counter)
    differences: list[str] = field(default_factory=list)

    def add(self, where: str, difference: str | None) -> None:
        self.count += 1
        if difference is not None:
            self.differences.append(f"{where}: {difference}")

    def __iadd__(self, other: Comparison) -> Comparison:
        self.count += other.count
        self.levels += other.levels
        self.differences += other.differences
        return self


def compare_levels(case: Case, agent: str, settings: Settings = ROUGH) -> Comparison:
    """All abilities of one agent towards all objects."""
    stage, found = case.stage(), Comparison()
    here, twin = Viewpoint(stage, agent, settings), Twin(case.stage(), agent, settings)
    for name in stage.scene.objects:
        for ability in ABILITIES:
            fast = effort_from(here, name, ability)
            found.levels[ability, fast.level] += 1
            found.add(f"room {case.seed}, {agent}, {ability} {name}", disagreement(fast, twin.answer(name, ability)))
    return found


def compare_pixels(case: Case, *, whole: bool = True) -> Comparison:
    """The whole image of every agent, if wanted, and every object in it."""
    stage, world, found = case.stage(), World(case.scene, case.state), Comparison()
    for name in case.scene.agents:
        agent = case.scene.agent(name)
        if not case.state.known([f"{name}/head"]):
            continue
        where = f"room {case.seed}, image of {name}"
        if whole:
            wrong = _unlike(case.scene.owners, view_of(stage, name).geoms.ravel(), world.image(agent))
            found.add(where, f"{wrong} pixels differ" if wrong else None)
        for target in filter(lambda each: case.state.known([each]), case.scene.objects):
            slow, fast = _counted(world, name, target), _window(stage, name, target)
            found.add(f"{where}, {target}", None if slow == fast else f"slow counts {slow}, fast {fast}")
    return found


def _unlike(owners: tuple[str, ...], geoms: np.ndarray, others: np.ndarray) -> int:
    """Pixels that show different things; which of two shapes of one thing that touch each other does not matter."""
    return sum(
        min(geom, other) < 0 or owners[geom] != owners[other]
        for geom, other in zip(geoms.tolist(), others.tolist(), strict=True)
        if geom != other
    )


Counts = tuple[float, float, float, dict[str, float]]
"""Pixels that are visible, visible in the gaze cone, visible if nothing stood in the way; and those of occluders."""


def _counted(world: World, name: str, target: str) -> Counts:
    agent, shapes, vision = world.scene.agent(name), world.seen_geoms(target), DEFAULT.vision
    found = world.look(agent, target, vision)
    in_cone = found.rays[:, 0] >= math.cos(agent.profile.eye.gaze_cone_rad)
    mine, alone = np.isin(found.geoms, shapes), found.alone >= 0
    others = Counter(world.scene.owners[geom] for geom in found.geoms[alone & ~mine])
    hiding = {owner: count * found.share for owner, count in others.items()}
    return found.count(mine, vision), found.count(mine & in_cone, vision), alone.sum() * found.share, hiding


def _window(stage: Stage, name: str, target: str) -> Counts | None:
    seen = visibility(stage, name, target)
    if seen is None:
        return None
    return seen.visible_px, seen.gaze_px, seen.unoccluded_px, dict(seen.occluders)


def frames(case: Case) -> Iterator[State]:
    """One agent and one object move a little in each frame; now and then a thing is put far away, or lost."""
    rng, state, scene = np.random.default_rng(case.seed), case.state, case.scene
    yield state
    for _ in range(FRAMES):
        if rng.random() < 0.8:
            agent = scene.agent(scene.agents[rng.integers(len(scene.agents))])
            joints = list(agent.joints.values())
            turned = {index: state.qpos[index] + rng.normal(0.0, 0.05) for index in rng.choice(joints, 3)}
            at = np.array(state.qpos[agent.base])
            at[:2] += rng.normal(0.0, 0.02, 2)
            state = state.replace(turned, at=agent.base, to=at)
        if rng.random() < 0.8:
            name = scene.objects[rng.integers(len(scene.objects))]
            place = np.array(state.qpos[scene.object_slice(name)])
            place[:3] += rng.normal(0.0, 0.4 if rng.random() < 0.2 else 0.02, 3)
            state = state.replace(at=scene.object_slice(name), to=place)
        if rng.random() < 0.15:
            lost = frozenset({scene.objects[rng.integers(len(scene.objects))]})
            state = State(state.qpos, state.time_s, state.untracked ^ lost, state.holding)
        yield state


def compare_following(case: Case) -> Comparison:
    """Efforts and their evidence, of who follows frame by frame beside those of a fresh look at each frame."""
    follower, found = SceneEfforts(Stage(case.scene), EXACT), Comparison()
    for number, state in enumerate(frames(case)):
        follower.update(state)
        followed, fresh = follower.all(), SceneEfforts(Stage(case.scene, state), EXACT).all()
        where = f"room {case.seed}, frame {number}"
        found.add(where, None if followed.keys() == fresh.keys() else "other questions")
        for question in followed.keys() & fresh.keys():
            one, other = followed[question], fresh[question]
            same = one == other and one.evidence == other.evidence
            found.add(f"{where}, {question}", None if same else f"fresh {other}, followed {one}")
        found.add(where, None if follower.asked_count <= len(fresh) else "more was asked than there is")
    return found
