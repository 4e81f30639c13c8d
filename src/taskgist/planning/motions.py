"""From how a thing is brought to its goal to what the robot does, phase by phase.

The robot folds its arms, drives to where it picks the thing up, and reaches out; the hand comes along the line that was
found for it, closes, and lifts; the thing is drawn near, for the way, as far as there is room; then all the same the
other way round. Arms and base move along ways on which the whole robot and its load are free at every step (``paths``),
within limits of speed and acceleration (``timing``).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.moving.steps import SHARED_S
from taskgist.planning.hand_ways import HandWay, PickPose
from taskgist.planning.handing import FULL, Taker, Taking
from taskgist.planning.judging import Reason
from taskgist.planning.paths import base_path, joint_path
from taskgist.planning.performer import TOLERANCE_M, Base, Grip, Performer, near_bases, with_values
from taskgist.planning.placing import Means
from taskgist.planning.plan import RATE_HZ, Phase, PhaseName
from taskgist.planning.sliding import Slid
from taskgist.planning.stands import Stand
from taskgist.planning.sweeps import Sweep, points_are_free
from taskgist.planning.timing import timed
from taskgist.planning.transfer import Transfer
from taskgist.settings import Planning
from taskgist.world.geometry.transforms import wrapped
from taskgist.world.state import Hold

HAND_STEP_M = 0.015
"""How far a hand moves at most for a step of each joint, in which ways of arms are measured."""
BASE_STEP_M, BASE_STEP_RAD = 0.01, 0.02
ARM_CHECKS, BASE_CHECKS = 6_000, 6_000
"""Configurations that the search of one way may check."""
AROUND_M = 2.0
"""How far from the straight line a base may go to get around things."""
TAKING_EVERY = 4
"""Of the frames in which somebody takes a thing each so-manieth is looked at, and the last."""
CORNERS_CUT = 3
"""How often a motion along a way is timed: each time twice as close to its corners."""
SAME_M, SAME_RAD = 0.005, 0.01
"""Stands that are nearer than this are one."""


class NoMotionError(Exception):
    """No motion was found for a phase; the text says for which."""


class NoEndError(NoMotionError):
    """The end of the motions will not do.

    Attributes:
        reason: Why not.
    """

    def __init__(self, reason: Reason) -> None:
        super().__init__(str(reason))
        self.reason = reason


class NoPickError(NoMotionError):
    """The robot does not get hold of the thing as was thought, wherever it is to go.

    Attributes:
        transfer: In which.
    """

    def __init__(self, text: str, transfer: Transfer) -> None:
        super().__init__(text)
        self.transfer = transfer


class Held(NamedTuple):
    """The thing in the hand: how it is fixed there, and which hand that is."""

    grip: Grip
    hold: Hold


@dataclass
class _At:
    """Where everything is while a plan is made; what the robot holds, and all holds, a taker's among them."""

    qpos: Array
    held: Held | None = None
    holds: frozenset[Hold] = frozenset()


class Motions:
    """Makes phases of transfers.

    Args:
        performer: The robot.
        settings: Limits of speed and acceleration.
        seed: Of the searches.
    """

    def __init__(self, performer: Performer, settings: Planning, *, seed: int = 0) -> None:
        self._performer, self._settings, self._seed = performer, settings, seed
        self._picked: dict[PickPose, tuple[tuple[Phase, ...], _At] | NoMotionError] = {}

    def of(self, transfer: Transfer, means: Means, taker: Taker) -> tuple[Phase, ...]:
        """The phases of a transfer, from the robot's start.

        Args:
            transfer: Grasp and stands.
            means: Whether the thing is put down in the end, held up, or handed over.
            taker: To whom it is handed over.

        Raises:
            NoPickError: Until the thing is lifted one of them was not found.
            NoMotionError: One of the others was not found.
        """
        return tuple(self._phases(transfer, means, taker))

    def back(self, qpos: Array, holds: frozenset[Hold], goal: Base) -> tuple[Phase, ...]:
        """The way back to where the robot stood, when all is done.

        Args:
            qpos: Where everything is in the end, (nq,).
            holds: Who else holds what then.
            goal: Where the robot is to go.

        Raises:
            NoMotionError: There is none.
        """
        return tuple(self._drive(_At(np.array(qpos), holds=holds), "withdraw", goal))

    def taking(self, pick: PickPose, qpos: Array) -> Taking:
        """How it takes a thing out of another hand: it opens its own, reaches out, comes along the line, and closes.

        Args:
            pick: Its grasp of the thing, where the other hand holds it.
            qpos: Where everything is, (nq,).

        Raises:
            NoMotionError: One of these motions was not found.
        """
        at = _At(np.array(qpos))
        phases = [
            *self._fingers(at, "take", pick, pick.open_hand),
            self._arm(at, "take", pick, pick.approach[0]),
            self._line(at, "take", pick, pick.approach),
            *self._fingers(at, "take", pick, pick.closed_hand, pick.grip),
        ]
        shared = np.repeat(at.qpos[None], round(SHARED_S * RATE_HZ), axis=0)
        return Taking(pick.side, np.concatenate([phase.qpos for phase in phases]), shared)

    def _phases(self, transfer: Transfer, means: Means, taker: Taker) -> Iterator[Phase]:
        performer, pick, place = self._performer, transfer.pick, transfer.place
        thing, side = pick.thing, pick.side
        hold = Hold(performer.agent.name, side, thing)
        self._foresee(transfer, means)
        picked, end = self._until_lifted(transfer)
        yield from picked
        at = replace(end, qpos=np.array(end.qpos))
        if not near_bases(transfer.start.base, transfer.goal.base, SAME_M, SAME_RAD):
            yield from self._transport(at, pick, transfer)
        at.held = Held(place.grip, hold)
        yield self._arm(at, "transfer", place, place.lower[0])
        yield self._line(at, "lower", place, place.lower)
        if means == "hold_up":
            return
        if means == "hand_over":
            yield from self._taken(at, thing, taker)
            at.holds -= {hold}
        else:
            column = performer.scene.object_slice(thing)
            at.qpos = with_values(at.qpos, column, place.before[column])
            at.holds = frozenset()
        at.held = None
        yield from self._fingers(at, "open", place, place.open_hand, place.grip, taken_by=self._hands(at, thing))
        yield self._line(at, "retreat", place, place.retreat)
        yield from self._fold(at)

    def slid(self, stand: Stand, slid: Slid) -> tuple[Phase, ...]:
        """The phases in which a thing is slid out over an edge, from the robot's start.

        Args:
            stand: Where the robot stands.
            slid: How its hand slides the thing.

        Raises:
            NoMotionError: One of them was not found.
        """
        at, press = _At(np.array(self._performer.start.qpos)), slid.press
        phases = [
            *self._fold(at),
            *self._drive(at, "drive", stand.base),
            *self._fingers(at, "close", press, press.closed_hand),
            self._arm(at, "reach", press, press.approach[0]),
            self._line(at, "approach", press, press.approach),
        ]
        hold = Hold(self._performer.agent.name, press.side, press.thing)
        at.held, at.holds = Held(press.grip, hold), frozenset({hold})
        phases.append(self._line(at, "slide", press, press.rise))
        at.held, at.holds = None, frozenset()
        return (*phases, self._line(at, "retreat", press, slid.leave), *self._fold(at))

    def _until_lifted(self, transfer: Transfer) -> tuple[tuple[Phase, ...], _At]:
        """The phases until the thing is lifted, and how all is then: the same for all goals, so found once.

        Raises:
            NoPickError: One of them was not found.
        """
        pick = transfer.pick
        if pick not in self._picked:
            at = _At(np.array(self._performer.start.qpos))
            try:
                self._picked[pick] = tuple(self._pick(at, transfer.start, pick)), at
            except NoMotionError as error:
                self._picked[pick] = error
        found = self._picked[pick]
        if isinstance(found, NoMotionError):
            raise NoPickError(str(found), transfer)
        return found

    def _pick(self, at: _At, stand: Stand, pick: PickPose) -> Iterator[Phase]:
        yield from self._fold(at)
        yield from self._drive(at, "drive", stand.base)
        yield from self._fingers(at, "open", pick, pick.open_hand)
        yield self._arm(at, "reach", pick, pick.approach[0])
        yield self._line(at, "approach", pick, pick.approach)
        yield from self._fingers(at, "close", pick, pick.closed_hand, pick.grip)
        hold = Hold(self._performer.agent.name, pick.side, pick.thing)
        at.held, at.holds = Held(pick.grip, hold), frozenset({hold})
        yield self._line(at, "lift", pick, pick.lift)

    def _foresee(self, transfer: Transfer, means: Means) -> None:
        """See that the robot is free where its ways are to end, before any of them is looked for.

        Raises:
            NoMotionError: It is not.
        """
        performer, pick, place = self._performer, transfer.pick, transfer.place
        name = performer.agent.name
        if not near_bases(transfer.start.base, transfer.goal.base, SAME_M, SAME_RAD):
            blocked = [self._carrying_blocked(transfer, values) for values in self._carryings(pick, pick.lift[-1])]
            if all(blocked):
                raise NoMotionError(f"{name} cannot carry the {pick.thing} from stand to stand: {blocked[0]}")
        if means != "hold_up":
            folded = performer.at_rest(place.opened(place.line[0]))
            met = performer.blocking(with_values(folded, place.hand_positions, place.open_hand))
            if met is not None:
                raise NoMotionError(f"{name} cannot fold its arm there: its {met.part} would meet {met.other}")

    def _carryings(self, way: HandWay, now: Array) -> tuple[Array, Array]:
        """Joints of the arm with which a thing is carried over the floor, (k,) each: drawn near, or as they are."""
        return self._performer.at_rest(way.before)[way.positions], now

    def _carrying_blocked(self, transfer: Transfer, values: Array) -> str | None:
        """What the robot would meet at either stand as it carries a thing so; None if nothing."""
        pick = transfer.pick
        for stand in (transfer.start, transfer.goal):
            qpos = self._performer.at(pick.closed(values), stand.base)
            met = self._performer.blocking(qpos, pick.grip)
            if met is not None:
                return f"its {met.part} would meet {met.other}"
        return None

    # --- Phases.

    def _fold(self, at: _At) -> Iterator[Phase]:
        """Both arms to rest, one after the other."""
        performer = self._performer
        folded = performer.at_rest(at.qpos)
        for side in performer.sides:
            chain = performer.chain(side)
            goal = folded[chain.positions]
            if np.abs(goal - at.qpos[chain.positions]).max() > SAME_RAD:
                yield self._joints(at, "fold", side, goal, "fold its arm")

    def _taken(self, at: _At, thing: str, taker: Taker) -> Iterator[Phase]:
        """The taker's hand comes and closes around the thing."""
        grip = at.held.grip if at.held else None
        failed = FULL
        for found in taker.takings(at.qpos, thing):
            if isinstance(found, str):
                failed = found
                continue
            met = self._met_by(taker.name, found.side, at.qpos, np.concatenate((found.coming, found.shared)), grip)
            if met is not None:
                failed = met
                continue
            at.qpos = found.shared[-1]
            yield Phase("take", found.coming, at.holds)
            at.holds |= {Hold(taker.name, found.side, thing)}
            yield Phase("take", found.shared, at.holds)
            return
        raise NoMotionError(f"{taker.name} cannot take the {thing}: {failed}")

    def _met_by(self, taker: str, side: str, before: Array, qpos: Array, grip: Grip | None) -> str | None:
        """What somebody's arm, or the hand, would push into as it comes to the thing, frames (n, nq); None: nothing."""
        performer = self._performer
        arm, stage = performer.scene.agent(taker).arm(side), performer.body.stage
        load = np.empty(0, dtype=np.intp) if grip is None else performer.body.geoms_of(grip.thing)
        rest = np.setdiff1d(stage.solid_geoms(), np.concatenate((performer.scene.solid_geoms_of(taker), load)))
        performer.body.show(before, grip)
        usual_m = {pair[:2]: pair[2] for pair in stage.overlaps(arm.geoms, rest)}
        for row in (*qpos[:-1:TAKING_EVERY], qpos[-1]):
            blocked = performer.blocking(row, grip, taken_by=arm.hand_geoms)
            if blocked is not None:
                return f"{taker}'s {side} hand would come where {performer.agent.name}'s {blocked.part} is"
            for geom, other, depth_m in stage.overlaps(arm.geoms, rest, deeper_than_m=TOLERANCE_M):
                if depth_m > usual_m.get((geom, other), 0.0) + TOLERANCE_M:
                    return f"{taker}'s {side} arm would push into {performer.body.called(other)}"
        return None

    def _arm(self, at: _At, name: PhaseName, way: HandWay, goal: Array) -> Phase:
        what = f"bring its {way.side} hand to the {way.thing}" if at.held is None else f"bring the {way.thing} there"
        return self._joints(at, name, way.side, goal, what)

    def _transport(self, at: _At, pick: HandWay, transfer: Transfer) -> Iterator[Phase]:
        """Draw the thing near as far as that goes, and drive."""
        chain = self._performer.chain(pick.side)
        failed: NoMotionError | None = None
        for carrying in self._carryings(pick, at.qpos[chain.positions]):
            blocked = self._carrying_blocked(transfer, carrying)
            if blocked is not None:
                failed = failed or NoMotionError(f"it cannot carry the {pick.thing} from stand to stand: {blocked}")
                continue
            now = _At(np.array(at.qpos), at.held, at.holds)
            try:
                phases = []
                if np.abs(carrying - now.qpos[chain.positions]).max() > SAME_RAD:
                    what = f"draw the {pick.thing} near"
                    phases.append(self._joints(now, "carry", pick.side, carrying, what))
                phases += self._drive(now, "transport", transfer.goal.base)
            except NoMotionError as error:
                failed = error
                continue
            at.qpos = now.qpos
            yield from phases
            return
        assert failed is not None
        raise failed

    def _joints(self, at: _At, name: PhaseName, side: str, goal: Array, what: str) -> Phase:
        """Joints of an arm to others, (k,), along a free way; what turns without end turns the shorter way round."""
        chain = self._performer.chain(side)
        start = at.qpos[chain.positions]
        goal = np.where(chain.endless, start + np.remainder(goal - start + math.pi, math.tau) - math.pi, goal)
        low = np.where(chain.endless, start - math.pi, chain.low)
        high = np.where(chain.endless, start + math.pi, chain.high)
        step = self._performer.arm_steps(side, at.qpos, HAND_STEP_M)
        sweep = self._performer.arm_sweep(at.qpos, side, _grip(at), ends=(start, goal))
        way = joint_path(
            start,
            goal[None],
            np.stack((low, high), axis=1),
            sweep.is_free,
            step=step,
            seed=self._seed,
            checks=ARM_CHECKS,
            look=sweep.look,
        )
        if way is None:
            raise NoMotionError(f"{self._performer.agent.name} finds no way to {what}")
        return self._timed(at, name, side, way, sweep)

    def _line(self, at: _At, name: PhaseName, hand_way: HandWay, way: Array) -> Phase:
        """A hand's line, which begins where the arm is, though it may have turned more often to get there."""
        endless = self._performer.chain(hand_way.side).endless
        turns = np.round((at.qpos[hand_way.positions] - way[0]) / math.tau)
        sweep = self._performer.arm_sweep(at.qpos, hand_way.side, _grip(at))
        return self._timed(at, name, hand_way.side, way + math.tau * np.where(endless, turns, 0.0), sweep)

    def _hands(self, at: _At, thing: str) -> Indices:
        """Shapes of the hands that hold a thing."""
        arms = [self._performer.scene.agent(hold.agent).arm(hold.side) for hold in at.holds if hold.object == thing]
        return np.concatenate([np.empty(0, dtype=np.intp), *(arm.hand_geoms for arm in arms)])

    def _fingers(
        self,
        at: _At,
        name: PhaseName,
        way: HandWay,
        goal: Array,
        grip: Grip | None = None,
        *,
        taken_by: Indices | None = None,
    ) -> Iterator[Phase]:
        """Open or close the hand; what it would push into ends the plan."""
        now = at.qpos[way.hand_positions]
        if np.abs(goal - now).max(initial=0.0) < SAME_RAD / 100:
            return  # some models have fingers without joints
        count = math.ceil(self._settings.closing_s * RATE_HZ - 1e-9)
        steps = now + np.linspace(0.0, 1.0, count + 1)[1:, None] * (goal - now)
        for values in steps:
            qpos = with_values(at.qpos, way.hand_positions, values)
            blocked = self._performer.blocking(qpos, grip, taken_by=taken_by)
            if blocked is not None:
                raise NoMotionError(f"its {blocked.part} would push into {blocked.other}, closing or opening")
        yield self._phase(at, name, way.hand_positions, steps)

    def _drive(self, at: _At, name: PhaseName, goal: Base) -> Iterator[Phase]:
        performer, settings = self._performer, self._settings
        start = np.array(performer.base(at.qpos))
        end = np.array(goal)
        if near_bases(performer.base(at.qpos), goal, SAME_M, SAME_RAD):
            return
        end[2] = start[2] + wrapped(end[2] - start[2])
        low, high = np.minimum(start, end)[:2] - AROUND_M, np.maximum(start, end)[:2] + AROUND_M
        ranges = np.array([(low[0], high[0]), (low[1], high[1]), (-np.inf, np.inf)])
        sweep = performer.base_sweep(at.qpos, _grip(at), ends=(start, end))
        way = base_path(
            start,
            end,
            ranges,
            sweep.is_free,
            step_m=BASE_STEP_M,
            step_rad=BASE_STEP_RAD,
            seed=self._seed,
            checks=BASE_CHECKS,
            look=sweep.look,
        )
        if way is None:
            raise NoMotionError(f"{performer.agent.name} finds no way over the floor to where it would stand")
        velocity = (settings.base_m_s, settings.base_m_s, settings.base_rad_s)
        acceleration = (settings.base_m_s2, settings.base_m_s2, settings.base_rad_s2)
        bases = self._free_in_time(name, way, np.array(velocity), np.array(acceleration), sweep)
        qpos = np.array([performer.at(at.qpos, _base(base)) for base in bases])
        yield self._shown(at, name, qpos)

    # --- From ways to frames.

    def _timed(self, at: _At, name: PhaseName, side: str, way: Array, sweep: Sweep) -> Phase:
        """An arm along a way, (n, k), within its limits."""
        chain, settings = self._performer.chain(side), self._settings
        velocity = np.where(chain.lifts, settings.lift_m_s, settings.joint_rad_s)
        acceleration = np.where(chain.lifts, settings.lift_m_s2, settings.joint_rad_s2)
        return self._phase(at, name, chain.positions, self._free_in_time(name, way, velocity, acceleration, sweep))

    def _free_in_time(self, name: PhaseName, way: Array, velocity: Array, acceleration: Array, sweep: Sweep) -> Array:
        """A timed motion along a way that is free, between its frames as well.

        It leaves the way at its corners, by the less the denser its way points are.
        """
        for _ in range(CORNERS_CUT):
            _, values = timed(way, velocity, acceleration, rate_hz=RATE_HZ)
            if points_are_free(sweep.look_closely, values):
                return values
            way = np.insert(way, np.arange(1, len(way)), (way[1:] + way[:-1]) / 2, axis=0)
        met = "" if sweep.blocked is None else f": its {sweep.blocked.part} would meet {sweep.blocked.other}"
        raise NoMotionError(f"{self._performer.agent.name} cannot move along the way that it found to {name}{met}")

    def _phase(self, at: _At, name: PhaseName, positions: Indices, values: Array) -> Phase:
        return self._shown(at, name, np.array([with_values(at.qpos, positions, each) for each in values]))

    def _shown(self, at: _At, name: PhaseName, qpos: Array) -> Phase:
        """Frames with the held thing in the hand; what comes next begins with the last one."""
        if at.held is not None:
            qpos = np.array([self._performer.carried(each, at.held.grip) for each in qpos])
        at.qpos = qpos[-1]
        return Phase(name, qpos, at.holds)


def _grip(at: _At) -> Grip | None:
    return at.held.grip if at.held else None


def _base(values: Array) -> Base:
    x, y, yaw = (float(value) for value in values)
    return x, y, yaw
