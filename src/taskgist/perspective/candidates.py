"""Candidates of an effort level: the states that base, legs and torso may take, by increasing amount.

A candidate is a state that virtual actions lead to (Eq. 1-6); head and arms are as they were, for the abilities aim
and stretch them themselves. All candidates of a level are held in one table: states are made one by one, when asked
for. Where a candidate brings eye, head and shoulders is told without showing its state: by what the torso does, and by
where the base gets to.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices
from taskgist.common.compiled import compiled, compiled_part
from taskgist.errors import UnknownNameError
from taskgist.perspective.effort import (
    BEND,
    CROUCH,
    LEAN,
    LIFT,
    MOVE,
    PAN,
    PUSH,
    SIDLE,
    SIT,
    STAND,
    TILT,
    TURN,
    Amount,
    stretch,
)
from taskgist.perspective.floor import Floor, Place, moved
from taskgist.settings import Efforts
from taskgist.world.bodies.agent import Agent, ArmIndices
from taskgist.world.bodies.profile import Axis
from taskgist.world.geometry.linkage import POSE, Linkage, carry_pose
from taskgist.world.geometry.transforms import Pose, matrix_from_wxyz, wxyz_from_rotation_vector
from taskgist.world.stage import Stage
from taskgist.world.state import State

STILL_RAD = 1e-9
"""Turns below this are rounding."""


# --- Virtual actions, and the states that they lead to (Eq. 1-6).


def actions_of(agent: Agent) -> tuple[str, ...]:
    """The virtual actions that an agent's body has, in the order in which they are listed."""
    p = agent.profile
    has = {PAN: p.pan, TILT: p.tilt, TURN: p.turn, LEAN: p.lean, MOVE: p.moves}
    both = "sitting" in p.legs.can and "standing" in p.legs.can
    bends, lift = (BEND, CROUCH) if p.legs.hips else (), (LIFT,) if agent.lifts else ()
    postures = (*((STAND, SIT) if both else ()), *bends, *lift, *((PUSH, SIDLE) if both else ()))
    return (*(action for action, part in has.items() if part), *postures, *(stretch(side) for side in agent.sides))


def checked_actions(agent: Agent, actions: Iterable[str] | None) -> frozenset[str]:
    """The given actions, or all that the agent has.

    Raises:
        UnknownNameError: The agent has no such action.
    """
    known = actions_of(agent)
    chosen = known if actions is None else tuple(actions)
    for action in chosen:
        if action not in known:
            raise UnknownNameError("virtual action", action, known)
    return frozenset(chosen)


NO_AMOUNT = Amount()


@dataclass(frozen=True, eq=False)
class Candidate:
    """A state that virtual actions of base, legs and torso lead to; head and arms are as they were.

    Attributes:
        state: The state.
        actions: What leads there, in order.
        amount: How much of it.
        aside: What is out of its place then, and in nobody's way any longer: the seat that was pushed back, and what
            lay on the agent's lap, which is taken up first.
    """

    state: State
    actions: tuple[str, ...] = ()
    amount: Amount = NO_AMOUNT
    aside: frozenset[str] = frozenset()


# --- Turns and leans of the torso (Eq. 4).


@dataclass(frozen=True)
class TorsoPose:
    """A turn and a lean of the torso.

    Attributes:
        changes: New angles in radians, by index into qpos; joints that stay are left out.
        actions: The virtual actions.
        by_rad: How far turn and lean are from the current ones, together.
    """

    changes: Mapping[int, float] = field(default_factory=dict)
    actions: tuple[str, ...] = ()
    by_rad: float = 0.0


def torso_poses(agent: Agent, current: State, settings: Efforts, actions: frozenset[str]) -> list[TorsoPose]:
    """Every turn with every lean of the torso, the torso as it is among them.

    Args:
        agent: The agent.
        current: From which the amount counts.
        settings: Steps of turn and lean.
        actions: Virtual actions that may be used.
    """
    profile, joints = agent.profile, agent.joints
    turns = _turned(TURN, profile.turn, joints, current, settings.turn_step_rad) if TURN in actions else [TorsoPose()]
    leans = _turned(LEAN, profile.lean, joints, current, settings.lean_step_rad) if LEAN in actions else [TorsoPose()]
    return [
        TorsoPose({**turn.changes, **lean.changes}, turn.actions + lean.actions, turn.by_rad + lean.by_rad)
        for turn, lean in itertools.product(turns, leans)
    ]


def _turned(
    action: str, axis: Axis | None, joints: Mapping[str, int], current: State, step_rad: float
) -> list[TorsoPose]:
    """The current angle, which is always allowed, then all multiples of a step within the joint's range."""
    if axis is None:
        return [TorsoPose()]
    index = joints[axis.joint]
    now = float(current.qpos[index])
    low, high = (limit / step_rad for limit in axis.range_rad)
    angles = [count * step_rad for count in range(math.ceil(low - 1e-9), math.floor(high + 1e-9) + 1)]
    others = [angle for angle in angles if abs(angle - now) > STILL_RAD]
    return [TorsoPose(), *(TorsoPose({index: angle}, (action,), abs(angle - now)) for angle in others)]


# --- The frames of an agent that abilities depend on: its eye, the joints of its head, and its shoulders.
#
# Frames are rows of 12 numbers, position and then orientation, as compiled functions take them: the eye first, then
# the joints of the head (a point of the axis, and the axis as x), then the shoulders, and once more the shoulders,
# thrust forward.

EYE = 0
"""Which of the frames is the eye."""


@dataclass(frozen=True)
class HeadJoint:
    """A joint of the head: the virtual action that moves it, its index into qpos, range and present angle in radians.

    ``depth`` is the joint's place in the model's order: of two joints of a head, the later one is carried by the other.
    """

    action: str
    index: int
    range_rad: tuple[float, float]
    now_rad: float
    depth: int


class Neck(NamedTuple):
    """The usable joints of a head, as compiled functions take them.

    Attributes:
        frames: Which of the agent's frames each is, (h,).
        inwards: Their order from the eye to the base, (h,).
        now: Their present angles, radians, (h,).
        ranges: The angles that they may take, radians, (h, 2): the present one is always allowed.
    """

    frames: Indices
    inwards: Indices
    now: Array
    ranges: Array


@dataclass(frozen=True, eq=False)
class UsableHead:
    """Those joints of a head that may be used."""

    joints: tuple[HeadJoint, ...]
    neck: Neck

    @classmethod
    def of(cls, head: Sequence[HeadJoint], actions: frozenset[str]) -> UsableHead:
        """The joints that some actions move."""
        columns = [column for column, joint in enumerate(head) if joint.action in actions]
        joints = tuple(head[column] for column in columns)
        now = np.array([joint.now_rad for joint in joints])
        low, high = np.array([joint.range_rad for joint in joints]).reshape(-1, 2).T
        frames = EYE + 1 + np.array(columns, dtype=np.intp)
        inwards = np.argsort([-joint.depth for joint in joints]).astype(np.intp)
        return cls(joints, Neck(frames, inwards, now, np.column_stack((np.minimum(low, now), np.maximum(high, now)))))

    def changes(self, angles: Array) -> dict[int, float]:
        """Angles, (h,), by index into qpos."""
        return {joint.index: angle for joint, angle in zip(self.joints, angles.tolist(), strict=True)}


class Frames:
    """Where an agent's frames are in one state, and where turns and leans of its torso would bring them.

    Args:
        stage: The scene in that state.
        agent: The agent.

    Attributes:
        head: The joints of its head.
        first_shoulder: Which of the frames is the first arm's shoulder.
        base: Where its base is, metres, (3,).
    """

    def __init__(self, stage: Stage, agent: Agent) -> None:
        model, profile = stage.scene.model, agent.profile
        self._qpos = stage.state.qpos
        frames = [(int(model.site_bodyid[agent.eye_site]), stage.eye_ahead(agent))]
        head = []
        for action, axis in ((PAN, profile.pan), (TILT, profile.tilt)):
            if axis is not None:
                joint = int(model.joint(f"{agent.name}/{axis.joint}").id)
                index = agent.joints[axis.joint]
                head.append(HeadJoint(action, index, axis.range_rad, float(self._qpos[index]), joint))
                anchor, along = stage.screw(joint)
                frames.append((int(model.jnt_bodyid[joint]), Pose(anchor, np.repeat(along[:, None], 3, axis=1))))
        self.head, self.first_shoulder = tuple(head), len(frames)
        self._usable: dict[frozenset[str], UsableHead] = {}
        frames += [(arm.carrier_body, stage.shoulder(arm)) for arm in agent.arms]
        frames += [(arm.carrier_body, _thrust(stage, agent, arm)) for arm in agent.arms]
        torso = tuple(axis.joint for axis in (profile.turn, profile.lean) if axis is not None)
        self._linkage = Linkage.of(stage, agent, torso, tuple(frames))
        self.base = self._linkage.base

    def usable(self, actions: frozenset[str]) -> UsableHead:
        """The joints of the head that some actions move."""
        if actions not in self._usable:
            self._usable[actions] = UsableHead.of(self.head, actions)
        return self._usable[actions]

    def moved(self, angles: Sequence[Mapping[int, float]]) -> Array:
        """Where new angles of the torso's joints by index into qpos, n of them, bring the frames: (n, f, 12)."""
        joints = self._linkage.joints.tolist()
        now = {index: float(self._qpos[index]) for index in joints}
        moves = [[new.get(index, now[index]) - now[index] for index in joints] for new in angles]
        return self._linkage.moved(np.array(moves).reshape(len(angles), len(joints)))


def _thrust(stage: Stage, agent: Agent, arm: ArmIndices) -> Pose:
    """Where an arm's shoulder would be if the girdle thrust it forward; where it is, if none does."""
    shoulder = stage.shoulder(arm)
    changes = thrust_of(agent, arm, stage.state)
    if not changes:
        return shoulder
    assert arm.profile.thrust is not None
    (index, angle) = next(iter(changes.items()))
    anchor, axis = stage.screw(int(stage.scene.model.joint(f"{agent.name}/{arm.profile.thrust.joint}").id))
    turn = matrix_from_wxyz(wxyz_from_rotation_vector((angle - float(stage.state.qpos[index])) * axis))
    return Pose(anchor + turn @ (shoulder.position - anchor), turn @ shoulder.matrix)


def thrust_of(agent: Agent, arm: ArmIndices, state: State) -> dict[int, float]:
    """The new angle of what thrusts an arm's shoulder forward, radians by index into qpos; none if nothing does."""
    axis = arm.profile.thrust
    if axis is None:
        return {}
    index = agent.joints[axis.joint]
    return {index: axis.range_rad[1]} if state.qpos[index] < axis.range_rad[1] - STILL_RAD else {}


# --- All candidates of a level in one table.

Numbers = NDArray[np.int32]
DIGITS = 6
"""Amounts that agree to so many digits are equal, wherever the scene stands."""
OVERHEAD_M = 1e-6
"""Nobody turns to what is this near to the axis of the base."""


@dataclass(frozen=True, eq=False)
class TorsoPoses:
    """A posture of an agent, with all that its torso may do in it.

    Attributes:
        agent: Whose.
        start: The posture.
        frames: Where eye, head and shoulders are in it.
        poses: What the torso may do.
        rows: Where each of these brings the frames, (b, f, 12).
        amounts_rad: How much it is, (b,), rounded for comparing.
        thrusts: Whether shoulders may be thrust forward as well.
    """

    agent: Agent
    start: Candidate
    frames: Frames
    poses: Sequence[TorsoPose]
    rows: Array
    amounts_rad: Array
    thrusts: bool

    @classmethod
    def of(
        cls, agent: Agent, start: Candidate, frames: Frames, poses: Sequence[TorsoPose], *, thrusts: bool
    ) -> TorsoPoses:
        """A posture and some turns and leans of the torso."""
        amounts = np.round([pose.by_rad for pose in poses], DIGITS)
        return cls(agent, start, frames, poses, frames.moved([pose.changes for pose in poses]), amounts, thrusts)


@dataclass(frozen=True, eq=False)
class Ways:
    """Where a base may go, in order of the way.

    Attributes:
        offsets_m: How far it moves, metres along the world's x and y, (p, 2).
        lengths_m: Lengths of the ways, (p,).
        rounded_m: The same, rounded for comparing.
        cells: Their cells of the floor, (p, 2).
    """

    offsets_m: Array
    lengths_m: Array
    rounded_m: Array
    cells: Indices

    @classmethod
    def to(cls, places: Sequence[Place]) -> Ways:
        """The ways to some places."""
        offsets = np.array([place.offset_m for place in places]).reshape(-1, 2)
        lengths = np.array([place.way_m for place in places])
        cells = np.array([place.cell for place in places], dtype=np.intp).reshape(-1, 2)
        return cls(offsets, lengths, np.round(lengths, DIGITS), cells)

    def thinned(self, away_m: Array) -> Ways:
        """Fewer and fewer of them where what an agent turns to is far: a step changes little there.

        Args:
            away_m: How far it is from each of the places, metres, (p,).
        """
        lattice = np.exp2(np.searchsorted(THINNED_M, away_m)).astype(np.intp)[:, None]
        kept = (self.cells % lattice == 0).all(axis=1)
        return Ways(self.offsets_m[kept], self.lengths_m[kept], self.rounded_m[kept], self.cells[kept])


THINNED_M = (2.0, 4.0)
"""Distances beyond which only every second cell each way is a place, and every fourth (ours: no arm is so long)."""
NO_WAY = Ways(np.zeros((1, 2)), np.zeros(1), np.zeros(1), np.zeros((1, 2), dtype=np.intp))
"""The base stays."""
NO_TURN = np.zeros(1)


class Table(NamedTuple):
    """Candidates as compiled functions take them.

    Attributes:
        rows: Where each pose of the torso brings the frames, (b, f, 12).
        joints: How many joints of the head are among them.
        base: Where the base is before it moves, metres, (3,).
        offsets_m: How far it moves to each place, (p, 2).
        turns: Sine and cosine of the turn there, (p, 2).
        spot: Index of each candidate's place, (n,).
        bend: Index of its pose of the torso, (n,).
    """

    rows: Array
    joints: int
    base: Array
    offsets_m: Array
    turns: Array
    spot: Numbers
    bend: Numbers


class Candidates:
    """Candidates by increasing amount: every place with every pose of the torso.

    Args:
        torso: The posture, and what the torso may do in it.
        ways: Where the base may go; it stays if left out.
        turned_rad: How far the whole agent turns on the spot, (p,).

    Attributes:
        torso: As given.
        table: For compiled functions.
        ends: For each candidate, which is the first one after it of another amount, (n,).
    """

    def __init__(self, torso: TorsoPoses, ways: Ways = NO_WAY, turned_rad: Array = NO_TURN) -> None:
        self.torso, self._ways, self._turned_rad = torso, ways, turned_rad
        place, pose, self.ends, sines = _ordered(ways.rounded_m, turned_rad, torso.amounts_rad)
        frames = torso.frames
        self.table = Table(torso.rows, len(frames.head), frames.base, ways.offsets_m, sines, place, pose)

    def __len__(self) -> int:
        return len(self.ends)

    def __getitem__(self, index: int) -> Candidate:
        """The candidate of that index."""
        place, pose = self.table.spot[index], self.torso.poses[self.table.bend[index]]
        start = self.torso.start
        state, used = start.state.replace(pose.changes), pose.actions
        way_m, turned_rad = float(self._ways.lengths_m[place]), float(self._turned_rad[place])
        if self._ways is not NO_WAY:
            x, y = self._ways.offsets_m[place].tolist()
            state, used = moved(state, self.torso.agent, (x, y), turned_rad), (MOVE, *used)
        moved_m = start.amount.moved_m + way_m
        amount = replace(start.amount, moved_m=moved_m, turned_rad=abs(turned_rad), torso_rad=pose.by_rad)
        return Candidate(state, (*start.actions, *used), amount, start.aside)

    @property
    def offsets_m(self) -> Array:
        """How far the base moves in each, metres along the world's x and y, (n, 2)."""
        return self.table.offsets_m[self.table.spot]

    def frames(self, index: int) -> Array:
        """Where a candidate brings the frames, (f, 12)."""
        return _carried(self.table, index)

    def shoulder(self, index: int, arm: int) -> Pose:
        """Where a candidate brings a shoulder, in the frame of what carries it; after all arms, thrust forward."""
        row = self.frames(index)[self.torso.frames.first_shoulder + arm]
        return Pose(row[:3], row[3:].reshape(3, 3))


@compiled
def turns_towards(target: Array, base: Array, facing_rad: float, offsets_m: Array) -> Array:
    """How far an agent turns at each place so that its chest faces a target, radians from −π to π.

    Args:
        target: Metres, (3,).
        base: Where the base is now, metres, at least (2,).
        facing_rad: Where the chest faces now, about the vertical.
        offsets_m: How far the places are from there, (p, 2).
    """
    turns = np.empty(len(offsets_m))
    for p in range(len(turns)):
        turns[p] = 0.0
        x, y = target[0] - base[0] - offsets_m[p, 0], target[1] - base[1] - offsets_m[p, 1]
        if math.hypot(x, y) > OVERHEAD_M:
            turn = math.atan2(y, x) - facing_rad
            turns[p] = turn - 2 * math.pi * np.rint(turn / (2 * math.pi))
    return turns


@compiled_part
def carry(table: Table, index: int, frame: int, pose: Array) -> None:
    """Write where a candidate brings one frame, (12,)."""
    spot, turns = table.spot[index], table.turns
    offset, row = table.offsets_m[spot], table.rows[table.bend[index], frame]
    carry_pose(row, table.base, offset, turns[spot, 0], turns[spot, 1], pose)


@compiled
def _carried(table: Table, index: int) -> Array:
    found = np.empty((table.rows.shape[1], POSE))
    for frame in range(len(found)):
        carry(table, index, frame, found[frame])
    return found


def _ordered(ways: Array, turned_rad: Array, torso: Array) -> tuple[Numbers, Numbers, Numbers, Array]:
    """Every place with every pose of the torso, by way, turn and pose.

    Equal ones keep the order of places, then of poses.

    Returns:
        Place and pose of each, where its equals end, all (n,); and sine and cosine of the turn at each place, (p, 2).
    """
    turns = np.rint(np.abs(turned_rad) * 10.0**DIGITS)
    by_amount, by_torso = np.lexsort((turns, ways)), np.argsort(torso, kind="stable")  # numpy has compiled its sorting
    return _combined(ways, turns, torso, by_amount, by_torso, turned_rad)


@compiled
def _combined(
    ways: Array, turns: Array, torso: Array, by_amount: Indices, by_torso: Indices, turned_rad: Array
) -> tuple[Numbers, Numbers, Numbers, Array]:
    """As ``_ordered``, given the spots in the order of way and turn, and the bends in that of the torso."""
    spots, bends = len(ways), len(torso)
    spot, bend = np.empty(spots * bends, dtype=np.int32), np.empty(spots * bends, dtype=np.int32)
    ends, sines = np.empty(spots * bends, dtype=np.int32), np.empty((spots, 2))
    count, first = 0, 0
    while first < spots:
        one, last = by_amount[first], first + 1
        while last < spots and ways[by_amount[last]] == ways[one] and turns[by_amount[last]] == turns[one]:
            last += 1
        low = 0
        while low < bends:
            high = low + 1
            while high < bends and torso[by_torso[high]] == torso[by_torso[low]]:
                high += 1
            end = count + (last - first) * (high - low)
            for p in range(first, last):
                for b in range(low, high):
                    spot[count], bend[count], ends[count] = by_amount[p], by_torso[b], end
                    count += 1
            low = high
        first = last
    for p in range(spots):
        sines[p, 0], sines[p, 1] = math.sin(turned_rad[p]), math.cos(turned_rad[p])
    return spot, bend, ends, sines


# --- Walking: the candidates of an agent that gets up, goes somewhere and turns there to what it wants (Move_To).


class Walk:
    """An agent ready to walk.

    Args:
        upright: The agent standing, then bent and crouched, with what its torso may do.
        facing_rad: Where its chest faces then, about the vertical.
        floor: Where it can get to.
    """

    def __init__(self, upright: Sequence[TorsoPoses], facing_rad: float, floor: Floor) -> None:
        self._upright, self._facing_rad, self.floor = upright, facing_rad, floor
        self._ways: list[Ways] = []
        self._last: tuple[bytes, list[Candidates]] = b"", []

    @property
    def start(self) -> Candidate:
        """The agent standing, before it goes."""
        return self._upright[0].start

    def candidates(self, target: Array) -> Iterator[Candidates]:
        """Batches of growing distance: most objects are near to where somebody can stand upright.

        Args:
            target: What the agent turns to, metres, (3,).
        """
        if self._last[0] != target.tobytes():
            self._last = target.tobytes(), []
        known = self._last[1]  # the three abilities ask for the same ones, one after the other
        batches = ((torso, ways) for torso in self._upright for ways in self._floor_ways())
        for index, (torso, ways) in enumerate(batches):
            if index == len(known):
                base = np.array(torso.start.state.qpos[torso.agent.base])
                near = ways.thinned(np.hypot(*(target[:2] - base[:2] - ways.offsets_m).T))
                turned_rad = turns_towards(target, base, self._facing_rad, near.offsets_m)
                known.append(Candidates(torso, near, turned_rad))
            yield known[index]

    def _floor_ways(self) -> Iterator[Ways]:
        """The floor in batches, for all targets the same."""
        for index, places in enumerate(self.floor.batches()):
            if index == len(self._ways):
                self._ways.append(Ways.to(places))
            yield self._ways[index]
