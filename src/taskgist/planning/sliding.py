"""Sliding a flat thing out over an edge of what it lies on, so that a hand gets around it (5.1.3, 9.1).

What lies flat and is wider than the hand is held from above and beneath, and beneath there is its support. People press
their fingertips on it and draw it over the edge, until enough of it sticks out; so does a robot here: its fingers come
from above, closed, and the thing goes with them, level and in a straight line. That the fingers hold it by friction is
assumed, as it is of every hand that holds something; that it does not tip over the edge is asked of physics.

An action of its own: the thing lies still in between, and is picked up as any other.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.perspective.grasp_sampling import Grasps
from taskgist.perspective.sliding import Sliding
from taskgist.planning.grasping import STEP_M, Grasping
from taskgist.planning.hand_ways import Failures, Gate, PickPose, farthest, named
from taskgist.planning.performer import Grip, Performer, with_values
from taskgist.planning.placing import Candidate
from taskgist.planning.settling import settled
from taskgist.settings import Grasp
from taskgist.world.contacts import object_points, support_of
from taskgist.world.geometry.transforms import Pose
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State

DIRECTIONS = 16
"""Level directions in which a thing is slid."""
LEANS_RAD = (math.radians(30.0), math.radians(50.0))
"""How far the closed hand may lean from the vertical."""
OVERHANGS = (1.0, 0.75)
"""Shares of what may stick out over the edge that are tried."""
ACROSS = 15
"""Places, from side to side, that are asked whether they are of its top."""
LEAVE_STEPS = 20
"""Steps that the hand goes up again."""
TOP_M, TOUCHES_M = 0.003, 0.003
"""Places as high as the thing's highest are its top; fingertips as near to it as this touch it."""
DOWN = np.array((0.0, 0.0, -1.0))


def slid_out(scene: Scene, state: State, performer: Performer, thing: str) -> Iterator[Candidate]:
    """Where a thing may be slid out so that it stays lying and the robot's hand gets around it; near places first.

    Only furniture has such edges: an object beneath it, a tray or a sheet of paper, would be drawn along.

    Args:
        scene: The scene.
        state: Where everything is.
        performer: The robot, which is thought away.
        thing: The thing.
    """
    stage = Stage(scene, state)
    carrier = support_of(stage, thing, performer.settings.contact)
    if carrier is None or carrier in scene.objects:
        return
    column = scene.object_slice(thing)
    pose = state.qpos[column]
    for shift in _shifts(stage, performer, thing):
        end = state.replace(at=column, to=(*(pose[:3] + shift), *pose[3:]))
        if len(Grasping(performer, end, thing).free) and settled(scene, end, thing).stays:
            yield Candidate("slide_out", thing, end.qpos[column], carrier, end)


def why_not_slid(scene: Scene, state: State, performer: Performer, thing: str) -> str:
    """Why a thing is not slid out anywhere, in words; the arguments are those of ``slid_out``."""
    stage = Stage(scene, state)
    carrier = support_of(stage, thing, performer.settings.contact)
    if carrier is None:
        return f"the {thing} lies on nothing over which it could be slid"
    if carrier in scene.objects:
        return f"the {thing} lies on the {carrier}, which would be drawn along"
    if not _shifts(stage, performer, thing):
        return f"no edge of the {carrier} is near enough to the {thing}, and free"
    return f"where the {thing} sticks out over an edge of the {carrier}, no hand gets around it, or it does not stay"


def _shifts(stage: Stage, performer: Performer, thing: str) -> list[Array]:
    """By how much a thing can be slid over an edge, metres, (3,) each, the shortest first."""
    settings: Grasp = performer.settings.grasp
    solids = stage.scene.solid_geoms_of(thing)
    others = np.setdiff1d(stage.solid_geoms(), np.concatenate((solids, performer.agent.geoms)))
    sliding = Sliding(stage, solids, object_points(stage, thing, performer.settings.reach.cell_m), others, settings)
    found = []
    for angle_rad in np.arange(DIRECTIONS) * (math.tau / DIRECTIONS):
        way = np.array((math.cos(angle_rad), math.sin(angle_rad), 0.0))
        over = sliding.over_edge(way)
        if over is not None:
            found += [(over.by_m - (1.0 - share) * over.out_m) * way for share in OVERHANGS]
    return sorted(found, key=lambda shift: round(float(np.linalg.norm(shift)), 6))


@dataclass(frozen=True, eq=False)
class Slid:
    """How a hand slides a thing.

    Attributes:
        press: Its way to the thing, whose ``rise`` is the way with it.
        leave: Joints of the chain upwards from where the thing is left, (n, k).
    """

    press: PickPose
    leave: Array


class Pressing(Grasping):
    """Ways to press closed fingers on a thing from above, and to slide it: "grasps" that do not close.

    Args:
        performer: The robot.
        state: Where everything is.
        thing: What is slid.
        shift: By how much, level, metres, (3,).
    """

    def __init__(self, performer: Performer, state: State, thing: str, shift: Array) -> None:
        self._shift = shift
        pose = state.qpos[performer.scene.object_slice(thing)]
        super().__init__(performer, state, thing, np.concatenate((pose[:3] + shift, pose[3:])))

    def _sampled(self) -> Grasps:
        stage, scene, thing = self._stage, self._stage.scene, self.thing
        point = self._pressed()
        hands = [] if point is None else _hands(self._shift)
        frames, count = np.array(hands).reshape(-1, 3, 3), len(hands)
        centers = np.array([] if point is None else [self._center(point, hand) for hand in hands]).reshape(-1, 3)
        pose, solids = stage.body(scene.object_body(thing)), scene.solid_geoms_of(thing)
        return Grasps(
            centers=pose.to_local(centers),
            closings=frames[:, :, 1] @ pose.matrix,
            approaches=frames[:, :, 0] @ pose.matrix,
            widths_m=np.zeros(count),
            gaps_m=np.zeros(count),
            in_itself=np.zeros(count, dtype=bool),
            shapes=np.zeros((count, 2), dtype=np.intp),
            solids=solids,
            touching=np.ones((count, len(solids)), dtype=bool),
            narrowest_m=0.0,
        )

    def _center(self, point: Array, hand: Array) -> Array:
        """Where a closed hand, turned so, is (as grasps have it) when its lowest touches a point of the top, (3,)."""
        gripper = self.performer.gripper(self.performer.sides[0])
        in_hand = gripper.palm_in_hand(0.0)
        lowest_m = gripper.ahead_m(0.0, (hand @ in_hand.matrix).T @ DOWN)
        center = point - self._hand.tips_m * hand[:, 0]
        center[2] = point[2] + lowest_m - (hand @ in_hand.position)[2]
        return np.asarray(center)

    def _pressed(self) -> Array | None:
        """The place on its top that is nearest to its middle, in the world, metres, (3,); None if there is none."""
        stage, seen = self._stage, self._stage.scene.seen_geoms(self.thing)
        low, high = stage.bounds(seen)
        grid_m = np.linspace(-0.5, 0.5, ACROSS) * float((high - low)[:2].min())
        offsets = np.stack(np.meshgrid(grid_m, grid_m), axis=-1).reshape(-1, 2)
        offsets = offsets[np.argsort(np.round(np.linalg.norm(offsets, axis=1), 6), kind="stable")]
        heights = np.full((len(offsets), 1), high[2] + TOP_M)
        starts = np.concatenate(((low + high)[:2] / 2 + offsets, heights), axis=1)
        _, distances_m, _ = stage.cast_each(seen, starts, np.tile(DOWN, (len(starts), 1)))
        top = np.flatnonzero(distances_m <= 2 * TOP_M)
        return starts[top[0]] + distances_m[top[0]] * DOWN if len(top) else None

    @cached_property
    def free(self) -> Indices:
        """All: the whole hand is looked at, where it comes."""
        return self._spread(np.arange(len(self.grasps)))

    def comes(self, qpos: Array, side: str, row: int) -> bool:
        """Whether a hand comes to the thing where it lies, and where it is to be slid; counted if not."""
        if not super().comes(qpos, side, row):
            return False
        failed: Failures = []
        if self.fits(qpos, side, row, failed):
            return True
        self.tally.add(*farthest(failed))
        return False

    def _shut(self, side: str, row: int, found: Array) -> Array | None:
        shut = super()._shut(side, row, found)
        if shut is None:
            return None
        stage, hand = self.performer.body.show(shut), self.performer.agent.arm(side).hand_geoms
        gap_m, *_ = stage.closest(hand, self.performer.body.geoms_of(self.thing), limit_m=2 * TOUCHES_M)
        return shut if gap_m <= TOUCHES_M else None

    def _rise(self, side: str, palm: Pose, shut: Array, held: Grip, failed: Failures) -> Array | None:
        """Joints of the chain as the thing is slid, (n, k); None if something is in the way."""
        positions = self.performer.chain(side).positions
        count = max(2, math.ceil(float(np.linalg.norm(self._shift)) / STEP_M))
        palms = [Pose(palm.position + share * self._shift, palm.matrix) for share in np.linspace(0.0, 1.0, count + 1)]
        way = self.performer.follow(side, palms[1:], shut)
        if way is None:
            failed.append((Gate.JUMP, None))
            return None
        way = np.concatenate((shut[positions][None], way))
        for values in way:
            blocked = self.performer.blocking(with_values(shut, positions, values), held)
            if blocked is not None:
                failed.append((Gate.RISE, named(blocked)))
                return None
        return way

    def left(self, press: PickPose) -> Slid | None:
        """The same with the way up again, from where the thing is left; None if the hand does not get up there."""
        performer = self.performer
        end = performer.carried(press.closed(press.rise[-1]), press.grip)
        palm = performer.palm(end, press.side)
        palms = [Pose(palm.position - up * DOWN, palm.matrix) for up in np.arange(1, LEAVE_STEPS + 1) * STEP_M]
        way = performer.follow(press.side, palms, end)
        if way is None or self._first_blocked(end, press.positions, way) is not None:
            return None
        return Slid(press, np.concatenate((press.rise[-1:], way)))


def _hands(shift: Array) -> list[Array]:
    """How a closed hand may be turned, (3, 3) each: columns along its approach, its closing direction, and across.

    It comes straight from above, or leans to where the thing is slid, against that, or aside.
    """
    way = shift / np.linalg.norm(shift)
    aside = np.cross(way, DOWN)
    sides = [(0.0, way, aside)]
    sides += [(lean, level, np.cross(level, DOWN)) for lean in LEANS_RAD for level in (-way, aside, -aside, way)]
    found = []
    for lean_rad, level, across in sides:
        approach = math.cos(lean_rad) * DOWN + math.sin(lean_rad) * level
        axes = (approach, across, np.cross(approach, across))
        found += [np.stack(axes, axis=1), np.stack((axes[0], axes[2], -axes[1]), axis=1)]
    return found
