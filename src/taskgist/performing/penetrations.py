"""Penetrations: what a performer, and what moves with it, runs into, on every frame and between them.

Nothing here is shared with the planner's own test of collisions: frames come from the motion alone, gaps from MuJoCo.
Between two frames nobody checked anything, so joints and things are taken to move evenly, and time is halved as long
as a bound leaves room for more than what is let pass: two shapes with gaps g₀ and g₁ at both ends of a while, in which
they move against each other by c, and off the straight line by e, come no nearer than (g₀ + g₁ − c) / 2 − e
("conservative advancement" [Mirtich 1996]). What can still be missed is deeper by no more than ``UNSEEN_M``.

What may touch, and how deep:

- a thing, and what it touches at the start, or later: no deeper than what is let pass; what lies deeper in something
  lies nowhere where things lie;
- people, and what they touch at the start: as deep as then, up to ``SOFT_M``; seats give, and thighs;
- two links of one robot: as deep as they are in the model's neutral pose, or in that in which the robot rests; of one
  person 3 cm deeper: flesh gives;
- a hand and what it holds, also while it closes and opens around it without moving otherwise: a few millimetres;
- the shapes of one hand; neighbours in a body, and next neighbours whose hulls overlap in one of these two poses.

A robot that begins in something is found there, in the first frame.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.planning.people_colliding import GIVES_M
from taskgist.planning.persons import moves_itself
from taskgist.world import Agent, Hold, Scene
from taskgist.world.geometry.distances import Clearance

Joint = mujoco.mjtJoint
UNSEEN_M = 1e-4
"""By how much deeper than what is let pass two shapes can be between frames unseen."""
SOFT_M = 0.06
"""How deep people may be in what they touch at the start (ours: in shipped and generated rooms pelvis and thighs of
people who sit are up to 45 mm in their seats, for in a model both are hard)."""
NEXT = 2
"""Joints between two links whose hulls may overlap: meshes of links are drawn into each other."""
STILL = 1e-9
NEAR_M = 0.02
"""Gaps up to this are measured, and told as the smallest ones."""

FREE, BALL, HINGE = (int(kind) for kind in (Joint.mjJNT_FREE, Joint.mjJNT_BALL, Joint.mjJNT_HINGE))

Pair = tuple[int, int]


class Drift(NamedTuple):
    """How far a thing moves, and turns, in a hand: metres and radians."""

    moved_m: float
    turned_rad: float


@dataclass(frozen=True, eq=False)
class Grip:
    """One hand on one thing, from taking to letting go.

    Attributes:
        hold: Whose hand, and what it holds.
        first: First frame in which it holds.
        last: Last frame in which it holds.
        opens: The frames, first and last, between which only fingers move: those before and after included.
        drift: How far the thing may move and turn in the hand.
    """

    hold: Hold
    first: int
    last: int
    opens: tuple[int, int]
    drift: Drift


@dataclass(frozen=True)
class Penetration:
    """Two shapes that overlap at some time.

    Attributes:
        geoms: The shapes: one of the performer or its load, and the other.
        frame: The frame in which, or after which, that is.
        share: How far on to the next frame, from 0 to below 1.
        depth_m: How deep.
        allowed_m: How deep they may.
    """

    geoms: Pair
    frame: int
    share: float
    depth_m: float
    allowed_m: float


class Motion:
    """Where every shape is in each frame, and how far it moves to the next.

    Args:
        scene: The scene.
        qpos: Frames, (n, nq).
    """

    def __init__(self, scene: Scene, qpos: Array) -> None:
        self.scene, self.model, self.qpos = scene, scene.model, qpos
        self.data = mujoco.MjData(scene.model)
        count, model = len(qpos), scene.model
        self.positions = np.empty((count, model.ngeom, 3))
        self.matrices = np.empty((count, model.ngeom, 9))
        self.sites = np.empty((count, model.nsite, 12))
        self.bodies = np.empty((count, model.nbody, 7))
        for frame, row in enumerate(qpos):
            self.show(row)
            self.positions[frame], self.matrices[frame] = self.data.geom_xpos, self.data.geom_xmat
            self.sites[frame] = np.concatenate((self.data.site_xpos, self.data.site_xmat), axis=1)
            self.bodies[frame] = np.concatenate((self.data.xpos, self.data.xquat), axis=1)
        self.steps = np.zeros((max(count - 1, 0), model.nv))
        for frame, step in enumerate(self.steps):
            mujoco.mj_differentiatePos(model, step, 1.0, qpos[frame], qpos[frame + 1])
        turned = np.linalg.norm(np.diff(self.matrices, axis=0), axis=2) / math.sqrt(2)
        self.travel_m = np.linalg.norm(np.diff(self.positions, axis=0), axis=2) + turned * model.geom_rbound
        self.bulge_m = self._bulges()

    def show(self, row: Array) -> None:
        """Bring the shapes where a frame, or something between two, has them."""
        self.data.qpos[:] = row
        mujoco.mj_kinematics(self.model, self.data)

    def show_between(self, frame: int, share: float) -> None:
        """The same for a share of the way from a frame to the next."""
        row = np.array(self.qpos[frame])
        mujoco.mj_integratePos(self.model, row, self.steps[frame], share)
        self.show(row)

    def _bulges(self) -> Array:
        """How far any point of each shape may leave the straight line between two frames, metres, (n − 1, ngeom).

        A point that turns by angles θᵢ about axes no farther than r, and slides by s meanwhile, is accelerated by at
        most (Σθ)² r + 2 Σθ Σs along its way, and so leaves the chord by at most an eighth of that.
        """
        model = self.model
        turning, sliding = np.zeros((len(self.steps), model.nbody)), np.zeros((len(self.steps), model.nbody))
        amounts = np.abs(self.steps)
        for body in range(1, model.nbody):
            parent = int(model.body_parentid[body])
            turning[:, body], sliding[:, body] = turning[:, parent], sliding[:, parent]
            for joint in range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body]):
                dof, kind = int(model.jnt_dofadr[joint]), int(model.jnt_type[joint])
                if kind == FREE:
                    sliding[:, body] += np.linalg.norm(self.steps[:, dof : dof + 3], axis=1)
                    turning[:, body] += np.linalg.norm(self.steps[:, dof + 3 : dof + 6], axis=1)
                elif kind == BALL:
                    turning[:, body] += np.linalg.norm(self.steps[:, dof : dof + 3], axis=1)
                else:
                    (turning if kind == HINGE else sliding)[:, body] += amounts[:, dof]
        lever = np.zeros(model.nbody)
        for root in np.unique(model.body_rootid):
            own = np.flatnonzero(model.body_rootid[model.geom_bodyid] == root)
            if root and len(own):
                middle = self.positions[:, own].mean(axis=1, keepdims=True)
                reach = np.linalg.norm(self.positions[:, own] - middle, axis=2) + model.geom_rbound[own]
                lever[model.body_rootid == root] = 2 * reach.max()
        bulge = (turning**2 * lever + 2 * turning * sliding) / 8
        return np.asarray(bulge[:, model.geom_bodyid])

    def moved_objects(self) -> tuple[str, ...]:
        """Objects that are not always where they are at first."""
        apart = np.abs(self.qpos - self.qpos[:1]).max(axis=0) > STILL
        return tuple(name for name in self.scene.objects if apart[self.scene.object_slice(name)].any())


class Penetrations:
    """Finds them; and keeps the smallest gaps that it met, and the number of configurations that it looked at.

    Args:
        motion: The motion.
        performers: Names of the agents that perform.
        grips: All hands on things.
        tolerance_m: How much deeper than allowed counts.
        in_hand_m: How deep a hand and what it holds may be in each other.
    """

    def __init__(
        self,
        motion: Motion,
        performers: Collection[str],
        grips: Sequence[Grip],
        *,
        tolerance_m: float,
        in_hand_m: float,
    ) -> None:
        self._motion, self._grips = motion, grips
        self._tolerance_m, self._in_hand_m = tolerance_m, in_hand_m
        self._clearance = Clearance(motion.model, motion.data)
        scene = motion.scene
        owners = (*performers, *motion.moved_objects())
        self._movers = np.concatenate([scene.solid_geoms_of(name) for name in owners]).astype(np.intp)
        self._others = np.union1d(scene.solid_geoms, self._movers)
        # How near a pair must be in a frame to be able to meet before the next, or to have met since the last.
        moved = (motion.travel_m + 2 * motion.bulge_m).max(axis=1, initial=0.0)
        around = np.concatenate(([0.0], moved, [0.0]))
        self._limits_m = np.maximum(NEAR_M, 2 * np.maximum(around[1:], around[:-1])).tolist()
        people = [name for name in performers if moves_itself(scene.agent(name))]
        self._person = [-1] * motion.model.ngeom
        for number, name in enumerate(people):
            for geom in scene.agent(name).geoms:
                self._person[geom] = number
        self._at_ease_m = {pair: depth_m for name in performers for pair, depth_m in _at_ease(motion, name).items()}
        self._apart = _never_meet(motion, self._movers, self._at_ease_m)
        self._masks: dict[tuple[int, ...], Mask] = {}
        self._allowed_m: dict[Pair, float] = {}
        self.gaps_m: dict[str, float] = {}
        self.looked = 0

    def find(self) -> Iterator[Penetration]:
        """All of them in order of time, each pair once for a frame or what follows it."""
        motion, count = self._motion, len(self._motion.qpos)
        motion.show(motion.qpos[0])
        before = self._near(0)
        self._allowed_m = self._by_design(before)
        self._note(before, 0, 0)
        yield from self._too_deep(0, 0.0, before)
        for frame in range(1, count):
            motion.show(motion.qpos[frame])
            after = self._near(frame)
            self._note(after, frame, frame)
            yield from self._between(frame - 1, before, after)
            yield from self._too_deep(frame, 0.0, after)
            before = after

    def _by_design(self, start: dict[Pair, float]) -> dict[Pair, float]:
        """Of pairs of shapes that overlap in the first frame, how deep they may, metres, beyond what is let pass."""
        scene, allowed_m = self._motion.scene, dict(self._at_ease_m)
        for pair, gap in start.items():
            agents = [scene.agent(owner) for owner in {scene.owners[geom] for geom in pair} if owner in scene.agents]
            if gap < 0.0 and all(map(moves_itself, agents)):
                allowed_m[pair] = min(-gap, SOFT_M) if agents else 0.0
        return allowed_m

    def _near(self, frame: int) -> dict[Pair, float]:
        """Gaps of the pairs that are near in a frame, which is shown."""
        self.looked += 1
        pairs = self._clearance.near_pairs(self._movers, self._others, limit_m=self._limits_m[frame])
        kept = [(geom, other) for geom, other in pairs if not self._apart[geom, other]]
        return self._measured(kept, self._limits_m[frame])

    def _measured(self, pairs: Collection[Pair], limit_m: float) -> dict[Pair, float]:
        return {pair: self._clearance.gap_m(*pair, limit_m=limit_m) for pair in pairs}

    def _in_hand(self, first: int, last: int) -> Mask:
        """Pairs of a hand and what it holds, or closes or opens around, at some time between frames, (ngeom, ngeom)."""
        active = tuple(
            index for index, grip in enumerate(self._grips) if grip.opens[0] <= last and grip.opens[1] >= first
        )
        if active not in self._masks:
            mask = np.zeros_like(self._apart)
            for index in active:
                hold = self._grips[index].hold
                hand = self._motion.scene.agent(hold.agent).arm(hold.side).hand_geoms
                thing = self._motion.scene.solid_geoms_of(hold.object)
                mask[np.ix_(hand, thing)] = mask[np.ix_(thing, hand)] = True
            self._masks[active] = mask
        return self._masks[active]

    def _between(self, frame: int, before: dict[Pair, float], after: dict[Pair, float]) -> Iterator[Penetration]:
        """Penetrations on the way from a frame to the next, by halving."""
        in_hand, limit_m = self._in_hand(frame, frame + 1), min(self._limits_m[frame], self._limits_m[frame + 1])
        travel_m, bulge_m = self._motion.travel_m[frame], self._motion.bulge_m[frame]
        whiles = [(0.0, 1.0, before, after)]
        while whiles:
            start, end, first, last = whiles.pop()
            length = end - start
            doubtful = []
            for pair in first.keys() | last.keys():
                off = float(bulge_m[pair[0]] + bulge_m[pair[1]])
                moved = length * float(travel_m[pair[0]] + travel_m[pair[1]])
                if length < 1.0:
                    moved += length * 4 * off  # speed differs from the mean by half of the acceleration, 8 × off
                bulge = length**2 * off
                least = (first.get(pair, limit_m) + last.get(pair, limit_m) - moved) / 2 - bulge
                if least < -self._most_m(pair, in_hand) and moved / 2 + bulge > UNSEEN_M:
                    doubtful.append(pair)
            if doubtful:
                self.looked += 1
                middle = (start + end) / 2
                self._motion.show_between(frame, middle)
                gaps = self._measured(sorted(doubtful), limit_m)
                self._note(gaps, frame, frame + 1)
                yield from self._too_deep(frame, middle, gaps)
                # What is too deep is told; how much deeper it gets in between is not looked for.
                deep = {pair for pair, gap in gaps.items() if gap < -self._most_m(pair, in_hand)}
                kept_first, kept_last = ({p: g[p] for p in doubtful if p in g} for g in (first, last))
                inner = {pair: gap for pair, gap in gaps.items() if pair not in deep}
                for part in (kept_first, kept_last):
                    for pair in deep:
                        part.pop(pair, None)
                whiles += [(middle, end, inner, kept_last), (start, middle, kept_first, inner)]

    def _most_m(self, pair: Pair, in_hand: Mask) -> float:
        """Down to which depth a pair is let pass."""
        return max(self._may_m(pair) + self._tolerance_m, self._in_hand_m if in_hand[pair] else 0.0)

    def _may_m(self, pair: Pair) -> float:
        """How deep a pair may be by design: parts of one person as flesh gives."""
        one, other = pair
        of_one_person = self._person[one] == self._person[other] >= 0
        return self._allowed_m.get(pair, 0.0) + (GIVES_M if of_one_person else 0.0)

    def _too_deep(self, frame: int, share: float, gaps: dict[Pair, float]) -> Iterator[Penetration]:
        in_hand = self._in_hand(frame, frame + 1 if share else frame)
        for pair, gap in gaps.items():
            if gap < -self._most_m(pair, in_hand):
                allowed_m = self._in_hand_m if in_hand[pair] else self._may_m(pair)
                yield Penetration(pair, frame, share, -gap, allowed_m)

    def _note(self, gaps: dict[Pair, float], first: int, last: int) -> None:
        """Keep the smallest gap to each thing, but to what it touched at the start, and to what it holds."""
        owners, in_hand = self._motion.scene.owners, self._in_hand(first, last)
        for pair, gap in gaps.items():
            one, other = (owners[geom] for geom in pair)
            if one != other and gap < NEAR_M and pair not in self._allowed_m and not in_hand[pair]:
                key = f"{one} to {other}"
                self.gaps_m[key] = min(self.gaps_m.get(key, math.inf), gap)


# --- Pairs of shapes that never count.


def _never_meet(motion: Motion, movers: Indices, at_ease_m: Mapping[Pair, float]) -> Mask:
    """Pairs whose gap says nothing, (ngeom, ngeom): of one rigid whole, of one body's neighbours, of one hand.

    Each pair of movers is kept once.
    """
    scene, model = motion.scene, motion.model
    rigid = np.asarray(_rigid_wholes(motion)[model.geom_bodyid])
    owners = np.unique(np.array(scene.owners), return_inverse=True)[1]
    is_object = np.isin(np.array(scene.owners), scene.objects)
    apart: Mask = np.equal(rigid[:, None], rigid[None, :]) | is_object[:, None]
    apart &= np.equal(owners[:, None], owners[None, :])
    for name in scene.agents:
        agent = scene.agent(name)
        for arm in agent.arms:
            apart[np.ix_(arm.hand_geoms, arm.hand_geoms)] = True
        _forgive_neighbours(motion, agent, apart, at_ease_m)
    of_movers = np.zeros(model.ngeom, dtype=bool)
    of_movers[movers] = True
    both = of_movers[:, None] & of_movers[None, :]
    return np.asarray(apart | (both & np.tri(model.ngeom, dtype=bool)))


def _rigid_wholes(motion: Motion) -> Indices:
    """For each body the topmost one that it does not move against in the whole motion, (nbody,)."""
    model = motion.model
    moves: Mask = np.abs(motion.steps).max(axis=0, initial=0.0) > STILL
    top = np.zeros(model.nbody, dtype=np.intp)
    for body in range(1, model.nbody):
        dofs = slice(model.body_dofadr[body], model.body_dofadr[body] + model.body_dofnum[body])
        own = model.body_dofnum[body] > 0 and moves[dofs].any()
        top[body] = body if own else top[model.body_parentid[body]]
    return top


def _at_ease(motion: Motion, name: str) -> dict[Pair, float]:
    """How deep the links of one robot are in each other as its model is, and as it rests; of people at the start."""
    scene, model = motion.scene, motion.model
    agent, found = scene.agent(name), dict[Pair, float]()
    geoms, clearance = scene.solid_geoms_of(name), Clearance(model, motion.data)
    rests = {**dict(agent.profile.rest_rad), **dict(agent.profile.rest_m)}
    for resting in (False, True):
        row = np.array(motion.qpos[0])
        for joint, position in () if moves_itself(agent) else agent.joints.items():
            (index,) = np.flatnonzero(model.jnt_qposadr == position)
            value = rests.get(joint, model.qpos0[position]) if resting else model.qpos0[position]
            row[position] = np.clip(value, *model.jnt_range[index]) if model.jnt_limited[index] else value
        motion.show(row)
        for geom, other, depth_m in clearance.overlaps(geoms, geoms):
            if geom < other:
                found[geom, other] = max(depth_m, found.get((geom, other), 0.0))
    return found


def _forgive_neighbours(motion: Motion, agent: Agent, apart: Mask, at_ease_m: Mapping[Pair, float]) -> None:
    """Mark pairs of one body's links: neighbours, and next neighbours whose hulls overlap at ease."""
    model, geoms = motion.model, motion.scene.solid_geoms_of(agent.name)
    links = {int(model.body_weldid[model.geom_bodyid[geom]]) for geom in geoms}
    overlapping = {tuple(sorted(int(model.body_weldid[model.geom_bodyid[g]]) for g in pair)) for pair in at_ease_m}
    for link in links:
        for other in links:
            joints = _joints_between(model, link, other)
            if joints <= 1 or (joints <= NEXT and tuple(sorted((link, other))) in overlapping):
                of_link, of_other = (
                    np.flatnonzero(model.body_weldid[model.geom_bodyid] == each) for each in (link, other)
                )
                apart[np.ix_(of_link, of_other)] = True


def _joints_between(model: mujoco.MjModel, link: int, other: int) -> int:
    """How many moving links are between two of one body, the farther one counted."""
    above, below = _links_above(model, link), _links_above(model, other)
    meet = next(each for each in above if each in below)
    return above.index(meet) + below.index(meet)


def _links_above(model: mujoco.MjModel, link: int) -> list[int]:
    """A link, what carries it, and so on up to the root of its body and the world."""
    found = [link]
    while found[-1] != 0:
        found.append(int(model.body_weldid[model.body_parentid[found[-1]]]))
    return found
