"""What each frame says of who carries a thing: contacts, gaps, slips and speeds, from what was tracked.

All is looked up for single frames. Speeds are those of straight lines fitted to what lies within a window around a
frame; what needs kinematics is looked at once for each frame, and only where the thing does not rest.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from taskgist.common.arrays import Array
from taskgist.observe.frames import KEPT_FRAMES, FrameSequence, velocity
from taskgist.observe.holding import Evidence, Hand, NearHand
from taskgist.settings import Settings
from taskgist.world.bodies.agent import Agent, ArmIndices
from taskgist.world.contacts import POINT_SPACING_M, Rest, RestingMemory, hand_gap_m, hand_known, object_points
from taskgist.world.geometry.transforms import Pose, matrix_from_wxyz
from taskgist.world.stage import Stage

GRAVITY_M_S2 = np.array([0.0, 0.0, -9.81])
FALLING_FRAMES = 4
"""As many frames at least show how fast a speed changes."""


@dataclass(frozen=True)
class Look:
    """What a stage shows of one thing in one frame.

    Attributes:
        rest: What it rests on or lies in, or would if it stayed there.
        rests: Whether it stays there: it neither rises nor sinks against that.
        gaps_m: Signed gaps to the tracked hands nearer than ``near_m``, metres; none where it rests.
    """

    rest: Rest
    rests: bool
    gaps_m: Mapping[Hand, float]


class Tracked:
    """Where things and palms are in the frames of a sequence; shared by all things of a scene.

    Args:
        stage: Their scene; it shows other states after each question.
        frames: The frames; more may be appended.
        settings: All settings.
    """

    def __init__(self, stage: Stage, frames: FrameSequence, settings: Settings) -> None:
        self.stage, self.frames, self.settings = stage, frames, settings
        self.resting = RestingMemory(stage.scene, settings.contact)
        scene = stage.scene
        self._rows = {name: row for row, name in enumerate(scene.objects)}
        columns = [np.arange(scene.nq)[scene.object_slice(name)] for name in scene.objects]
        self._columns = np.array(columns, dtype=np.intp).reshape(-1, 7)
        self.pose, self.palms = lru_cache(KEPT_FRAMES)(self._pose), lru_cache(KEPT_FRAMES)(self._palms)
        self._places, self._velocities = (
            lru_cache(KEPT_FRAMES)(self._places_in),
            lru_cache(KEPT_FRAMES)(self._moving_in),
        )

    @cached_property
    def arms(self) -> dict[Hand, tuple[Agent, ArmIndices]]:
        """All hands of the scene, in its order."""
        agents = [self.stage.scene.agent(name) for name in self.stage.scene.agents]
        return {(agent.name, arm.profile.side): (agent, arm) for agent in agents for arm in agent.arms}

    @cached_property
    def middles(self) -> Array:
        """The middle of each object in its own frame, metres, (n, 3): wherever that frame lies, it says the same."""
        scene, stage = self.stage.scene, self.stage.show(self.stage.scene.initial)
        found = np.zeros((len(scene.objects), 3))
        for row, name in enumerate(scene.objects):
            points = object_points(stage, name, POINT_SPACING_M)
            if len(points):
                found[row] = stage.body(scene.object_body(name)).to_local(points).mean(axis=0)
        return found

    def known(self, name: str, index: int) -> bool:
        """Whether an object was tracked in a frame."""
        return not math.isnan(self._places(index)[self._rows[name], 0])

    def _pose(self, name: str, index: int) -> Pose | None:
        """Where an object is in a frame; None where it was not tracked."""
        if not self.known(name, index):
            return None
        pose = self.frames.state(index).qpos[self._columns[self._rows[name]]]
        return Pose(pose[:3], matrix_from_wxyz(pose[3:]))

    def _palms(self, index: int) -> dict[Hand, Array]:
        """Where the palms of the tracked hands are in a frame, metres, (3,) each."""
        stage = self.stage.show(self.frames.state(index))
        return {
            hand: stage.site(arm.palm_site).position
            for hand, (agent, arm) in self.arms.items()
            if hand_known(stage, agent, arm)
        }

    def around(self, name: str, index: int) -> tuple[list[float], Array]:
        """Times in seconds, (n,), and places of an object's middle, metres, (n, 3), while it was tracked."""
        window = self.frames.window(index, self.settings.carrying.window_s)
        first, last, row = index, index, self._rows[name]
        while first > window.start and self.known(name, first - 1):
            first -= 1
        while last < window.stop - 1 and self.known(name, last + 1):
            last += 1
        places = [self._places(each)[row] for each in range(first, last + 1)]
        return self.frames.times_s[first : last + 1], np.array(places)

    def velocity(self, name: str, index: int) -> Array | None:
        """Velocity of an object's middle in a frame in which it was tracked, metres per second, (3,)."""
        found: Array = self._velocities(index)[self._rows[name]]
        return velocity(*self.around(name, index)) if math.isnan(found[0]) else found

    def _places_in(self, index: int) -> Array:
        """Where the middles of all objects are in a frame, metres, (n, 3); NaN where they were not tracked."""
        state = self.frames.state(index)
        poses = state.qpos[self._columns]
        places = (matrix_from_wxyz(poses[:, 3:]) @ self.middles[:, :, None])[:, :, 0] + poses[:, :3]
        for name in (*state.untracked, *self.stage.scene.shapeless):
            if name in self._rows:
                places[self._rows[name]] = np.nan
        return np.asarray(places)

    def _moving_in(self, index: int) -> Array:
        """Velocities of those objects that were tracked all around a frame, (n, 3); NaN of the others."""
        window = self.frames.window(index, self.settings.carrying.window_s)
        moving = velocity(self.frames.times_s[window.start : window.stop], [self._places(each) for each in window])
        return np.full(self.middles.shape, np.nan) if moving is None else moving


class EvidenceOf:
    """The evidence of each frame for one thing.

    Args:
        tracked: Where everything is.
        name: The thing.
    """

    def __init__(self, tracked: Tracked, name: str) -> None:
        self._tracked, self._name = tracked, name
        self._limits = tracked.settings.carrying
        self.look: Callable[[int], Look] = lru_cache(KEPT_FRAMES)(self._look)
        self.at: Callable[[int], Evidence] = lru_cache(KEPT_FRAMES)(self._at)

    def known(self, index: int) -> bool:
        """Whether the thing was tracked in a frame."""
        return self._tracked.known(self._name, index)

    def rests(self, index: int) -> bool:
        """Whether it rests in a frame."""
        return self.known(index) and self.look(index).rests

    def _look(self, index: int) -> Look:
        """Look at a frame in which it was tracked."""
        tracked = self._tracked
        stage = tracked.stage.show(tracked.frames.state(index))
        rest = tracked.resting(stage, self._name)
        if self._stays(rest, index):
            return Look(rest, True, {})
        palms, near_m = tracked.palms(index), self._limits.near_m
        stage = tracked.stage.show(tracked.frames.state(index))
        gaps_m = {hand: hand_gap_m(stage, tracked.arms[hand][1], self._name, limit_m=near_m) for hand in palms}
        return Look(rest, False, {hand: gap_m for hand, gap_m in gaps_m.items() if gap_m < near_m})

    def _stays(self, rest: Rest, index: int) -> bool:
        """Whether it neither rises nor sinks against what it is on or in; where that moves, too, it may be carried."""
        beneath = rest.container or rest.support
        if beneath is None:
            return False
        moving = self._tracked.velocity(self._name, index)
        if moving is None:
            return True
        up_m_s = moving[2]
        if beneath in self._tracked.stage.scene.objects:
            along = self._tracked.velocity(beneath, index)
            up_m_s -= 0.0 if along is None else along[2]
        return bool(abs(up_m_s) <= self._tracked.settings.timing.moving_m_s)

    def _at(self, index: int) -> Evidence:
        dt_s = self._dt_s(index)
        if not self.known(index):
            return Evidence(dt_s, tracked=False)
        look = self.look(index)
        if look.rests:
            return Evidence(dt_s, touches=True, rests=True)
        moving, palms = self._tracked.velocity(self._name, index), self._tracked.palms(index)
        near = [NearHand(hand, gap_m, self._slip_m_s(hand, index)) for hand, gap_m in look.gaps_m.items()]
        return Evidence(
            dt_s,
            touches=bool(look.rest.container or look.rest.support),
            speed_m_s=None if moving is None else float(np.linalg.norm(moving)),
            falls=self._falls(index),
            near=tuple(near),
            lost=frozenset(self._tracked.arms).difference(palms),
        )

    def _dt_s(self, index: int) -> float:
        times_s = self._tracked.frames.times_s
        if len(times_s) < 2:
            return self._limits.independent_s
        return times_s[max(index, 1)] - times_s[max(index, 1) - 1]

    def _slip_m_s(self, hand: Hand, index: int) -> float | None:
        """Speed of a palm in the thing's frame around one frame, metres per second; None where it is unknown."""
        tracked, times_s, places = self._tracked, list[float](), list[Array]()
        for each in tracked.frames.window(index, self._limits.window_s):
            pose, palm = tracked.pose(self._name, each), tracked.palms(each).get(hand)
            if pose is not None and palm is not None:
                times_s.append(tracked.frames.times_s[each])
                places.append(pose.to_local(palm))
        slip = velocity(times_s, places) if places else None
        return None if slip is None else float(np.linalg.norm(slip))

    def _falls(self, index: int) -> bool:
        """Whether its speed changes as that of a thing that falls freely."""
        acceleration = acceleration_m_s2(*self._tracked.around(self._name, index))
        if acceleration is None:
            return False
        return bool(np.linalg.norm(acceleration - GRAVITY_M_S2) < self._limits.fall_m_s2)


def acceleration_m_s2(times_s: Sequence[float], places: Array) -> Array | None:
    """Acceleration of a parabola fitted to places, metres per second², (3,); None where there are too few.

    Args:
        times_s: Times in seconds, (n,).
        places: What is where at each of them, metres, (n, 3).
    """
    if len(times_s) < FALLING_FRAMES:
        return None
    line = np.asarray(times_s) - np.mean(times_s)
    bend = line**2
    bend = bend - bend.mean() - line * float(line @ bend) / float(line @ line)  # square to a line and to a constant
    return np.asarray(2.0 * (bend @ places) / float(bend @ bend))
