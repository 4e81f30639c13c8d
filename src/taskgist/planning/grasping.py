"""How a robot picks a thing up, and puts it down, from where it stands: grasps, and the lines of the hand around them.

Grasps are those that perspective explains the ability to grasp with: sampled on the thing, in its own frame, so that
the one with which it is picked up is the one with which it is put down. For each of them one question comes after the
other, the cheap ones first, and what fails is counted at the first gate that it fails:

1. the hand is free where the thing lies, and where it is to lie (boxes of the hand, as perspective has them);
2. the arm reaches (capability map), its gripper opens so wide;
3. inverse kinematics: the palm is at the grasp, and the whole robot, as its model has it, is free;
4. the hand comes 10 cm along the approach, open, every few millimetres free, without a jump of the arm;
5. its fingers, as its model has them, close on the thing and not through it;
6. it rises with the thing in it, as free.

Putting down is the same way backwards: down with the thing, then back with the open hand.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.errors import SceneError
from taskgist.perspective.constraints import Collisions
from taskgist.perspective.effort import Blocking, Miss, Reason
from taskgist.perspective.grasp_sampling import Grasps, grasps_in_object, hand_frames
from taskgist.perspective.grasp_trials import GraspTrials
from taskgist.perspective.target import Recorder
from taskgist.planning.hand_ways import Failures, Gate, HandWay, PickPose, PlacePose, Tally, farthest, named
from taskgist.planning.performer import Grip, Performer, with_values
from taskgist.planning.whole_body import IN_HAND_M, TOLERANCE_M, Pair, pose_of
from taskgist.world.bodies.hands import Hand
from taskgist.world.contacts import hand_gap_m
from taskgist.world.geometry.transforms import Pose
from taskgist.world.stage import Stage
from taskgist.world.state import State

BACK_M, STEP_M = 0.10, 0.005
"""Length of the approach, and how far apart the configurations along a line are."""
RISE_M, LEAST_RISE_M = 0.08, 0.05
"""How far a thing is lifted straight up; and how far at least, where something is above."""
Kind = tuple[str, bytes]
"""A side of the robot, and what grasps of a kind share; see ``Grasping.within_reach``."""
AWAY_M = 1e4
"""Where a robot is put that is in nobody's way."""


class Grasping:
    """The grasps of one thing by one robot, at the place where it lies and at the one where it is to lie.

    Args:
        performer: The robot.
        state: Where everything is.
        thing: What is grasped.
        goal: Where the thing's body is to be: position in metres and wxyz, (7,); None if it need not be put down.
        rises: Whether the thing is lifted once it is grasped; what another hand holds is not.

    Attributes:
        tally: Where grasps failed until now, when the thing was to be picked up, once for each stand.
        place_tally: Where they failed when it was to be put down, once for each stand of each goal.
        thing_slice: Where the thing's body is in qpos.
        miss: Why the hand closes on the thing nowhere, wherever it lies; None if it does.

    Raises:
        UnknownNameError: There is no such thing.
        SceneError: It is in something.
    """

    def __init__(
        self, performer: Performer, state: State, thing: str, goal: Array | None = None, *, rises: bool = True
    ) -> None:
        self.performer, self.thing, self._rises = performer, thing, rises
        self.tally, self.place_tally = Tally(), Tally()
        scene = performer.scene
        self.thing_slice = scene.object_slice(thing)
        self.start = state
        self.goal = None if goal is None else state.replace(at=self.thing_slice, to=goal)
        assert performer.agent.profile.hand is not None
        self._hand: Hand = performer.agent.profile.hand
        self._stage = Stage(scene, state)
        performer.body.refuse_sunk(state.qpos, thing)
        self.grasps: Grasps = self._sampled()
        self.miss = None if len(self.grasps) else self._no_grasp()
        self._near_m = performer.settings.contact.grip_m
        self._touches: dict[bytes, dict[Pair, float]] = {}

    def towards(self, goal: Array) -> Grasping:
        """The same grasps of the thing where it lies, with another place to put it down.

        Neither has to find anew what the other found out about the start; where grasps fail, both count together.

        Args:
            goal: Where the thing's body is to be: position in metres and wxyz, (7,).
        """
        _ = self._free_at_start  # found once, before it is copied
        other = copy(self)
        for found_for_a_goal in ("free", "_palms"):
            other.__dict__.pop(found_for_a_goal, None)
        other.goal = self.start.replace(at=self.thing_slice, to=goal)
        return other

    @cached_property
    def free(self) -> Indices:
        """Grasps with which the hand is free at both places, those from other sides first; others are counted."""
        rows = self._free_at_start
        if self.goal is not None:
            rows = self._free_of_others(self.goal, rows, Gate.HAND_AT_GOAL)
        return self._spread(rows)

    @cached_property
    def _free_at_start(self) -> Indices:
        return self._free_of_others(self.start, np.arange(len(self.grasps)), Gate.HAND_AT_START)

    def centers(self, place: State) -> Array:
        """Where the free grasps are while the thing is where a state has it, metres, (n, 3)."""
        return pose_of(place.qpos[self.thing_slice]).to_world(self.grasps.centers[self.free])

    def in_reach(self, side: str, qpos: Array, place: State, lifts: Sequence[float] = (0.0,)) -> Indices:
        """Which of the free grasps an arm reaches, by its capability map, in their order.

        Args:
            side: The arm.
            qpos: Positions of the scene with the robot where it stands.
            place: Where the thing is.
            lifts: How far the shoulder is lifted from there, metres, each tried.
        """
        return self.reached_from(self.performer.shoulder(qpos, side), side, place, lifts)

    def reached_from(self, shoulder: Array, side: str, place: State, lifts: Sequence[float] = (0.0,)) -> Indices:
        """The same, from where a shoulder is and how what carries it is turned, (12,)."""
        pose, (palms, ahead) = pose_of(place.qpos[self.thing_slice]), self._palms[side]
        reached = self.performer.pointing(side).able(shoulder, pose.to_world(palms), ahead @ pose.matrix.T, lifts)
        return self.free[reached]

    @cached_property
    def _palms(self) -> Mapping[str, tuple[Array, Array]]:
        """Each side's palm in the free grasps, and where its hand points, in the thing's frame, (n, 3) each."""
        grasps = self.grasps.only(self.free)
        frames = hand_frames(grasps)
        found = {}
        for side in self.performer.sides:
            in_hand = self.performer.gripper(side).palm_in_hand(
                float(np.median(grasps.widths_m)) if len(grasps) else 0.0
            )
            ahead = in_hand.matrix @ self.performer.ahead_in_palm(side)
            found[side] = grasps.centers + frames @ in_hand.position, frames @ ahead
        return found

    def lifts(self, qpos: Array, side: str) -> tuple[float, ...]:
        """How far a shoulder can be lifted from where it is: not at all, to both ends, and half-way, metres."""
        chain = self.performer.chain(side)
        if not chain.lifts.any():
            return (0.0,)
        now = float(qpos[chain.positions][chain.lifts].sum())
        low, high = float(chain.low[chain.lifts].sum()), float(chain.high[chain.lifts].sum())
        return tuple(sorted({0.0, low - now, (low + high) / 2 - now, high - now}))

    def within_reach(self, qpos: Array) -> Mapping[Kind, Sequence[int]]:
        """Grasps within reach from where the robot stands, by the side that reaches them and their kind.

        Kinds whose first grasp comes first in the order of the free ones come first; grasps out of reach are counted.

        Args:
            qpos: Positions of the scene with the robot at its stand; only its own count, (nq,).
        """
        sides, before = self.performer.sides, self._at(self.start, qpos)
        reached = {side: set(self.in_reach(side, before, self.start, self.lifts(before, side))) for side in sides}
        found: dict[Kind, list[int]] = {}
        for row in self.free.tolist():
            able = [side for side in sides if row in reached[side]]
            if not able:
                self.tally.add(Gate.REACH)
            for side in able:
                found.setdefault((side, self.kind(row)), []).append(row)
        return found

    def comes(self, qpos: Array, side: str, row: int) -> bool:
        """Whether a hand comes to a grasp where the thing lies, its lines left aside; counted if it does not.

        Args:
            qpos: Positions of the scene with the robot at its stand, (nq,).
            side: The hand.
            row: The grasp.
        """
        too_narrow = self.performer.gripper(side).too_narrow(float(self.grasps.widths_m[row]))
        failed: Failures = [] if too_narrow is None else [(Gate.OPENING, too_narrow)]
        if not failed and self._comes(self.start, qpos, side, row, failed):
            return True
        self.tally.add(*farthest(failed))
        return False

    def pick(self, qpos: Array, side: str, row: int) -> PickPose | None:
        """How a hand that comes to a grasp picks the thing up by it; None if it does not, which is counted.

        Args:
            qpos: Positions of the scene with the robot at its stand; only its own count, (nq,).
            side: The hand.
            row: The grasp.
        """
        before, failed = self._at(self.start, qpos), list[tuple[Gate, str | None]]()
        for palm in self._palms_in(side, row, self.start):
            for way in self._ways(side, row, before, palm, None, failed):
                return PickPose(**vars(way))
        self.tally.add(*farthest(failed))
        return None

    def places(self, qpos: Array, pick: PickPose) -> Iterator[PlacePose]:
        """Ways to put the thing down where it is to lie, as it was picked up.

        Args:
            qpos: Positions of the scene with the robot at its stand; only its own count, (nq,).
            pick: How it was picked up.

        Raises:
            SceneError: The thing is not to be put down.
        """
        if self.goal is None:
            raise SceneError(f"{self.thing} is to be put down nowhere", hint="give Grasping a goal")
        place = self.goal
        before = self._at(place, qpos)
        usual_m = self._merged(pick.grip.usual_m, self._touching(before))
        grip, done = replace(pick.grip, usual_m=usual_m), False
        failed: Failures = []
        for way in self._ways(pick.side, pick.grasp, before, self._palm_at(place, pick.grip), grip, failed):
            done = True
            yield PlacePose(**vars(way))
        if failed and not done:
            self.place_tally.add(*farthest(failed))

    def fits(self, qpos: Array, side: str, row: int, failed: Failures) -> bool:
        """Whether a hand comes to a grasp where the thing is to lie, its lines left aside: quicker than a whole way.

        Args:
            qpos: Positions of the scene with the robot at its stand, (nq,).
            side: The hand.
            row: The grasp.
            failed: Filled with where its configurations failed.
        """
        assert self.goal is not None
        return self._comes(self.goal, qpos, side, row, failed)

    def _comes(self, place: State, qpos: Array, side: str, row: int, failed: Failures) -> bool:
        gripper, before = self.performer.gripper(side), self._at(place, qpos)
        ready = with_values(before, gripper.positions, gripper.opened(self._openings(side, row)[0]))
        for palm in self._palms_in(side, row, place):
            for found in self.performer.comes(side, palm, ready):
                blocked = self.performer.blocking(found)
                if blocked is None:
                    return True
                failed.append((Gate.BODY, named(blocked)))
        if not failed:
            failed.append((Gate.KINEMATICS, None))
        return False

    def _at(self, place: State, qpos: Array) -> Array:
        """Positions of the scene, (nq,), with the thing where a state has it."""
        return with_values(qpos, self.thing_slice, place.qpos[self.thing_slice])

    def _palm_at(self, place: State, grip: Grip) -> Pose:
        """Where the palm is when the held thing is at a place."""
        pose, in_palm = pose_of(place.qpos[self.thing_slice]), grip.in_palm
        return Pose(pose.to_world(-in_palm.matrix.T @ in_palm.position), pose.matrix @ in_palm.matrix.T)

    def _sampled(self) -> Grasps:
        """Grasps on the outside of the thing, in its frame."""
        sampled = grasps_in_object(self._stage, self.thing, self._hand, self.performer.settings.grasp)
        return self.performer.outside(self._stage, self.thing, sampled)

    # --- What the hand meets at the thing.

    def _no_grasp(self) -> Miss:
        """Why the hand closes on the thing nowhere."""
        narrowest_m = self.grasps.narrowest_m
        if narrowest_m is None:
            return Miss(Reason.NO_OPPOSITE_FACES, f"the {self.thing} has no two opposite faces to close a hand on")
        if narrowest_m > self._hand.opening_m:
            widths = f"{narrowest_m:.3f} m > {self._hand.opening_m:.3f} m"
            return Miss(Reason.TOO_WIDE, f"the {self.thing} is too wide for the hand ({widths})")
        return Miss(Reason.TOO_NARROW, f"the {self.thing} is too narrow for all fingers to meet it")

    def _free_of_others(self, place: State, rows: Indices, gate: Gate) -> Indices:
        """Those grasps with which the hand meets nothing where the thing is, the robot itself left aside."""
        if not len(rows):
            return rows
        performer, scene = self.performer, self.performer.scene
        agent = performer.agent
        away = np.array(place.qpos)
        away[agent.base][:2] += AWAY_M
        with self._stage.showing(place.replace(at=agent.base, to=away[agent.base])) as stage:
            collisions = Collisions(stage, agent, performer.settings, (), Recorder())
            pose = stage.body(scene.object_body(self.thing))
            trials = GraspTrials(stage, agent, pose, self.grasps, self._hand, collisions)
            free, rest = [], rows
            while len(rest):
                found = trials.first_free(rest, agent.arms[0].ghosts)
                if found is None:
                    break
                free.append(found)
                rest = rest[int(np.flatnonzero(rest == found)[0]) + 1 :]
            owners = [*(scene.owners[geom] for geom in trials.others.tolist()), self.thing]
            names = [owner if owner in scene.agents else f"the {owner}" for owner in owners]
        for row in np.setdiff1d(rows, free):
            met = int(trials.met[row])
            tally = self.place_tally if gate is Gate.HAND_AT_GOAL else self.tally
            tally.add(gate, names[met] if met >= 0 else None)
        return np.array(free, dtype=np.intp)

    def _spread(self, rows: Indices) -> Indices:
        """Grasps in the order in which they are tried: one from each side in turn, each time nearest to the middle."""
        if not len(rows):
            return rows
        grasps = self.grasps.only(rows)
        points = self._stage.show(self.start).bounds(self._stage.scene.seen_geoms(self.thing)).mean(axis=0)
        middle = pose_of(self.start.qpos[self.thing_slice]).to_local(points)
        away_m = np.round(np.linalg.norm(grasps.centers - middle, axis=1), 6)
        turns: dict[bytes, int] = {}
        keys = []
        for row in np.lexsort((rows, away_m)).tolist():
            side = self.kind(int(rows[row]))
            turns[side] = turns.get(side, -1) + 1
            keys.append((turns[side], float(away_m[row]), int(rows[row])))
        return np.array([row for _, _, row in sorted(keys)], dtype=np.intp)

    def kind(self, row: int) -> bytes:
        """What grasps of a kind share: roughly from where they come, and along which line they close."""
        directions = np.concatenate((self.grasps.approaches[row], np.abs(self.grasps.closings[row])))
        return (np.round(1.5 * directions) + 0.0).tobytes()

    # --- One grasp after the other.

    def _palms_in(self, side: str, row: int, place: State) -> Iterator[Pose]:
        """Where the palm is in a grasp, in the world; with fingers and thumb changed over, too, if that is the same."""
        in_hand = self.performer.gripper(side).palm_in_hand(self._openings(side, row)[0])
        pose, axes = pose_of(place.qpos[self.thing_slice]), hand_frames(self.grasps.only(np.array([row])))[0]
        for turned in (1.0,) if self._alike_changed_over[side] else (1.0, -1.0):
            at = Pose(pose.to_world(self.grasps.centers[row]), pose.matrix @ axes * (1.0, turned, turned))
            yield Pose(at.to_world(in_hand.position), at.matrix @ in_hand.matrix)

    @cached_property
    def _alike_changed_over(self) -> Mapping[str, bool]:
        """Whether each side's hand is turned by the wrist's last joint, or fingers and thumb are not to change over."""
        performer = self.performer
        rolls = {side: performer.rolls_about(side, performer.gripper(side).axes[:, 0]) for side in performer.sides}
        return {side: self._hand.one_sided or freely for side, freely in rolls.items()}

    def _openings(self, side: str, row: int) -> tuple[float, float]:
        """How wide the hand is open before it closes, and around the thing, metres."""
        width_m = float(self.grasps.widths_m[row])
        return min(width_m + 2 * float(self.grasps.gaps_m[row]), self.performer.gripper(side).widest_m), width_m

    def _ways(
        self,
        side: str,
        row: int,
        before: Array,
        palm: Pose,
        grip: Grip | None,
        failed: Failures,
    ) -> Iterator[HandWay]:
        """Ways of a hand to a palm's pose and up from there.

        Args:
            side: The hand.
            row: The grasp.
            before: All positions at the stand, the thing where it is grasped or put.
            palm: Where the palm is at the grasp.
            grip: The thing in the hand; None if it is as it comes to be grasped.
            failed: Filled with where each configuration failed.
        """
        performer, gripper, chain = self.performer, self.performer.gripper(side), self.performer.chain(side)
        open_hand = gripper.opened(self._openings(side, row)[0])
        ready = with_values(before, gripper.positions, open_hand)
        solutions = performer.ik(side, palm, ready)
        if not solutions:
            failed.append((Gate.KINEMATICS, None))
        for found in solutions:
            blocked = performer.blocking(found)
            if blocked is not None:
                failed.append((Gate.BODY, named(blocked)))
                continue
            line = self._line(side, palm, gripper.axes[:, 0], found)
            if line is None:
                failed.append((Gate.JUMP, None))
                continue
            blocked = self._first_blocked(ready, chain.positions, line[:-1])
            if blocked is not None:
                failed.append((Gate.APPROACH, named(blocked)))
                continue
            shut = self._shut(side, row, found)
            if shut is None:
                failed.append((Gate.FINGERS, None))
                continue
            off_m = hand_gap_m(
                performer.body.show(shut), performer.agent.arm(side), self.thing, limit_m=2 * self._near_m
            )
            if off_m >= self._near_m:
                failed.append((Gate.LOOSE, f"{100 * off_m:.0f} cm"))
                continue
            held = grip or replace(performer.grip(shut, self.thing, side), usual_m=self._touching(before))
            rise = self._rise(side, palm, shut, held, failed)
            if rise is None:
                continue
            yield HandWay(
                thing=self.thing,
                side=side,
                grasp=row,
                positions=chain.positions,
                before=before,
                line=line,
                rise=rise,
                open_hand=open_hand,
                closed_hand=shut[gripper.positions],
                hand_positions=gripper.positions,
                grip=held,
            )

    def _shut(self, side: str, row: int, found: Array) -> Array | None:
        """All positions, (nq,), with the hand closed as far as its fingers are not in the thing; None if too open.

        Fingers are collided as hulls: where these are thicker than pads, they stop earlier.
        """
        gripper, (most_m, width_m) = self.performer.gripper(side), self._openings(side, row)
        opening_m = width_m
        while opening_m <= min(most_m, width_m + IN_HAND_M):
            shut = with_values(found, gripper.positions, gripper.opened(opening_m))
            depth_m = self.performer.body.in_hand_m(shut, self.thing, side)
            if depth_m <= TOLERANCE_M:
                return shut
            opening_m += max(depth_m - TOLERANCE_M / 2, TOLERANCE_M / 2)
        return None

    def _line(self, side: str, palm: Pose, approach_in_palm: Array, found: Array) -> Array | None:
        """Joints of the chain along the approach, the grasp last, (n, k); None if the arm does not follow."""
        back = -(palm.matrix @ approach_in_palm)
        steps = np.arange(1, round(BACK_M / STEP_M) + 1) * STEP_M
        palms = [Pose(palm.position + far * back, palm.matrix) for far in steps]
        way = self.performer.follow(side, palms, found)
        if way is None:
            return None
        return np.concatenate((way[::-1], found[self.performer.chain(side).positions][None]))

    def _rise(self, side: str, palm: Pose, shut: Array, held: Grip, failed: Failures) -> Array | None:
        """Joints of the chain upwards from the grasp, as far as it is free, at least 5 cm; None if that is blocked."""
        performer, positions = self.performer, self.performer.chain(side).positions
        way, last, blocked = [shut[positions]], shut, performer.blocking(shut, held)
        if not self._rises and blocked is None:
            return np.array(way)
        for up in np.arange(1, round(RISE_M / STEP_M) + 1) * STEP_M:
            if blocked is not None:
                break
            values = performer.follow(side, [Pose(palm.position + (0.0, 0.0, up), palm.matrix)], last)
            if values is None:
                break
            last = with_values(shut, positions, values[0])
            blocked = performer.blocking(last, held)
            if blocked is None:
                way.append(values[0])
        if (len(way) - 1) * STEP_M >= LEAST_RISE_M - 1e-9:
            return np.array(way)
        failed.append((Gate.JUMP, None) if blocked is None else (Gate.RISE, named(blocked)))
        return None

    def _first_blocked(self, qpos: Array, positions: Indices, way: Array) -> Blocking | None:
        """What is first in the way of a line, (n, k), looked at from its end."""
        each = (self.performer.blocking(with_values(qpos, positions, values)) for values in way[::-1])
        return next((blocked for blocked in each if blocked is not None), None)

    def _touching(self, before: Array) -> dict[Pair, float]:
        """How deep the thing is in what carries it, where it is."""
        key = before[self.thing_slice].tobytes()
        if key not in self._touches:
            self._touches[key] = self.performer.body.touches(before, self.thing)
        return self._touches[key]

    @staticmethod
    def _merged(one: Mapping[Pair, float], other: Mapping[Pair, float]) -> dict[Pair, float]:
        merged = dict(one)
        for pair, depth_m in other.items():
            merged[pair] = max(depth_m, merged.get(pair, 0.0))
        return merged
