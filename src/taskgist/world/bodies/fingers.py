"""What fingers tell of their hand: its kind, how far it opens, and how long and thick it is.

Only what is plain is told. A hand is plain if its moving branches make one of these:

- two fingers against each other: ``parallel``,
- one finger that moves against one that does not: ``parallel``,
- two fingers side by side against a third: ``three_finger``.

A finger may be a linkage of two branches, of which the one that reaches farther grasps. Each finger is put to that end
of its first joint's range at which it is farthest from the others, what follows it moves along (URDF's mimic), and the
rest stays as the model has it. Then rays measure, from between the fingers near their tips::

    opening_m           from one inner face to the other, the least over the length of a pad
    finger_length_m     from the tips back to what stands between the fingers
    finger_thickness_m  from the inner face to the outer one
    finger_width_m      from side to side
    palm_m              the hand without its fingers: across them, and along them as far as they begin

Axes are those of ``hands.py``: x along the approach, y the closing direction, z across.
"""

from __future__ import annotations

import copy
import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from taskgist.common.arrays import Array
from taskgist.world.bodies.agent import couplings, solid, subtree
from taskgist.world.bodies.hands import HandKind
from taskgist.world.geometry.shapes import spans_m
from taskgist.world.geometry.transforms import normalized

PAD_M = (0.002, 0.006, 0.010, 0.014, 0.018)
"""How far behind the tips the pads are met (ours: pads are about two centimetres long)."""
AMID_M = 0.010
"""How far behind the tips a finger's thickness and width are measured."""
FAR_M = 0.4
"""No hand is larger than this between two faces that it closes (ours)."""
LEAST_OPENING_M = 0.004
"""What opens no farther grasps nothing (ours)."""
ALONG_AXIS = 0.9
"""Cosine within which an approach is taken for an axis of the hand's body."""
MOSTLY = 0.3
"""Share of the way between fingers that must lie across their joint (ours)."""
BEHIND_M = 0.005
"""How far behind the tips rays for the palm begin, off rounded tips (ours)."""
WIDEST_M = 0.06
"""No finger is thicker or wider than this (ours)."""
PALM_M = 0.01
"""The least depth of a palm (ours)."""
KINDS = {
    1: "one finger closes on one that does not move",
    2: "two fingers close on each other",
    3: "two fingers close on a third",
}
SHORTER = 0.85
"""A branch that reaches less of the way to the tips than this is the inner part of a finger's linkage (ours)."""
INNER, OUTER = 0, 5
"""Groups of the shapes that rays meet, and of the others."""
HINGE, SLIDE = int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)
LOOPS = (int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD))


@dataclass(frozen=True)
class Plain:
    """A hand whose fingers are plain.

    Attributes:
        fields: Fields of ``Hand`` by name, lengths in metres; ``palm_m`` is missing where nothing but fingers is there.
        why: What was found, for people.
        palm: A point half-way between the open tips, in the hand body's frame, metres, (3,).
        axes: The hand's axes in the hand body's frame, as columns, (3, 3).
    """

    fields: dict[str, Any]
    why: str
    palm: Array
    axes: Array


@dataclass(frozen=True)
class Unclear:
    """A hand whose fingers are not plain, and why."""

    why: str


def measured_hand(model: mujoco.MjModel, hand: int) -> Plain | Unclear:
    """What a hand's fingers tell.

    Args:
        model: The body alone, compiled.
        hand: Index of the hand's body.
    """
    owner, branches = _branches(model, hand)
    if not branches:
        return Unclear("nothing in it moves")
    ways = _Ways(model, owner, branches)
    fingers = ways.fingers()
    if not 1 <= len(fingers) <= 3:
        return Unclear(f"{len(fingers)} fingers of it move" if fingers else "nothing that moves in it has a shape")
    return ways.measured(fingers)


def moving_branches(model: mujoco.MjModel, hand: int) -> list[list[int]]:
    """Bodies of each branch that the first joints below a hand move."""
    return _branches(model, hand)[1]


def _branches(model: mujoco.MjModel, hand: int) -> tuple[int, list[list[int]]]:
    """The body whose branches are fingers, and their bodies: where only one moves, what it carries is looked at."""
    inside, firsts = subtree(model, hand), []
    moved = {hand}
    for body in inside[1:]:
        if int(model.body_parentid[body]) in moved and not model.body_jntnum[body]:
            moved.add(body)
        elif int(model.body_parentid[body]) in moved:
            firsts.append(body)
    if len(firsts) == 1:
        owner, further = _branches(model, firsts[0])
        if len(further) > 1:
            return owner, further
    return hand, _joined(model, [subtree(model, first) for first in firsts])


def _joined(model: mujoco.MjModel, branches: list[list[int]]) -> list[list[int]]:
    """Branches that are tied to each other are one."""
    found = [set(branch) for branch in branches]
    for tie in np.flatnonzero(np.isin(model.eq_type, LOOPS)):
        ends = [int(model.eq_obj1id[tie]), int(model.eq_obj2id[tie])]
        if int(model.eq_objtype[tie]) == int(mujoco.mjtObj.mjOBJ_SITE):
            ends = [int(model.site_bodyid[end]) for end in ends]
        tied = [branch for branch in found if branch & set(ends)]
        if len(tied) == 2:
            found = [branch for branch in found if branch not in tied] + [tied[0] | tied[1]]
    return sorted(sorted(branch) for branch in found)


class _Ways:
    """A hand's branches, how they move and what they look like: a model of its own in which nothing else is met."""

    def __init__(self, model: mujoco.MjModel, hand: int, branches: list[list[int]]) -> None:
        self.model, self.hand, self.branches = copy.copy(model), hand, branches
        inside = np.flatnonzero(np.isin(model.geom_bodyid, subtree(model, hand)))
        self._geoms = solid(model, inside) if len(solid(model, inside)) else inside
        self.model.geom_group[:] = OUTER
        self.model.geom_group[self._geoms] = INNER
        self.model.geom_rgba[self._geoms, 3] = 1.0  # rays pass what is wholly transparent
        self.model.geom_matid[self._geoms] = -1
        self.data = mujoco.MjData(self.model)
        self._couplings = couplings(model)
        self._put({})

    # --- Where the fingers are.

    def fingers(self) -> list[list[int]]:
        """The branches that grasp: all, or the longer half if each finger is a linkage of two."""
        shaped = [branch for branch in self.branches if self.shapes_of(branch)]
        if len(shaped) not in (4, 6):
            return shaped
        origin = self.data.xpos[self.hand]
        ahead = normalized(np.mean([self._middle(branch) for branch in shaped], axis=0) - origin)
        reach = [self._most(self.shapes_of(branch), ahead) - float(origin @ ahead) for branch in shaped]
        order = np.argsort(reach)
        half = len(order) // 2
        linked = reach[order[half - 1]] < SHORTER * reach[order[half]]
        return [shaped[index] for index in sorted(order[half:])] if linked else shaped

    def shapes_of(self, bodies: Iterable[int]) -> list[int]:
        """Shapes of some bodies that are measured."""
        return [int(geom) for geom in self._geoms if int(self.model.geom_bodyid[geom]) in set(bodies)]

    def _put(self, values: dict[int, float]) -> None:
        """Put joints to some values, with all that follow them; the others are as the model has them."""
        self.data.qpos[:] = self.model.qpos0
        for joint, value in values.items():
            self.data.qpos[self.model.jnt_qposadr[joint]] = value
        for coupling in self._couplings:
            leader = self.data.qpos[self.model.jnt_qposadr[coupling.leader]]
            self.data.qpos[self.model.jnt_qposadr[coupling.follower]] = coupling.led(self.model, leader)
        mujoco.mj_kinematics(self.model, self.data)

    def _drivers(self, fingers: Sequence[Sequence[int]]) -> list[int]:
        """The joint that moves each finger: its own first one, or what that follows."""
        leaders = {each.follower: each.leader for each in self._couplings}
        firsts = [int(self.model.body_jntadr[finger[0]]) for finger in fingers]
        return list(dict.fromkeys(leaders.get(joint, joint) for joint in firsts))

    def _ends(self, fingers: Sequence[Sequence[int]]) -> tuple[dict[int, float], dict[int, float]]:
        """Values of the drivers with the fingers apart, and together."""
        apart: dict[int, float] = {}
        together: dict[int, float] = {}
        tied = self._tied(fingers)
        for driver in self._drivers(fingers):
            if tied or not self.model.jnt_limited[driver]:
                continue
            trials = []
            for end in self.model.jnt_range[driver]:
                self._put({driver: float(end)})
                trials.append((self._spread(fingers), float(end)))
            together[driver], apart[driver] = min(trials)[1], max(trials)[1]
        return apart, together

    def _tied(self, fingers: Sequence[Sequence[int]]) -> bool:
        """Whether a finger is a closed loop: no joint of it moves alone, so it is taken as the model has it."""
        bodies = {body for finger in fingers for body in finger}
        for tie in np.flatnonzero(np.isin(self.model.eq_type, LOOPS)):
            sites = int(self.model.eq_objtype[tie]) == int(mujoco.mjtObj.mjOBJ_SITE)
            end = int(self.model.eq_obj1id[tie])
            if (int(self.model.site_bodyid[end]) if sites else end) in bodies:
                return True
        return False

    def _spread(self, fingers: Sequence[Sequence[int]]) -> float:
        """How far the fingers' middles are apart, or one from the hand's own shapes."""
        middles = [self._middle(finger) for finger in fingers]
        if len(middles) == 1:
            own = self._own_shapes()
            middles.append(np.mean([self._center(geom) for geom in own], axis=0) if own else self.data.xpos[self.hand])
        return float(sum(np.linalg.norm(one - other) for one, other in itertools.combinations(middles, 2)))

    def _middle(self, bodies: Iterable[int]) -> Array:
        return np.asarray(np.mean([self._center(geom) for geom in self.shapes_of(bodies)], axis=0))

    def _center(self, geom: int) -> Array:
        """The middle of the box around a shape, in the world, (3,)."""
        turn = self.data.geom_xmat[geom].reshape(3, 3)
        return np.asarray(self.data.geom_xpos[geom] + turn @ self.model.geom_aabb[geom, :3])

    def _own_shapes(self) -> list[int]:
        """Shapes of the hand that belong to none of its branches."""
        moving = {body for branch in self.branches for body in branch}
        return [int(geom) for geom in self._geoms if int(self.model.geom_bodyid[geom]) not in moving]

    def _most(self, geoms: Iterable[int], direction: Array) -> float:
        """The greatest coordinate of some shapes along a direction, metres."""
        return max(
            float(self.data.geom_xpos[geom] @ direction)
            + float(spans_m(self.model, geom, direction @ self.data.geom_xmat[geom].reshape(3, 3))[1])
            for geom in geoms
        )

    # --- Measuring.

    def measured(self, fingers: list[list[int]]) -> Plain | Unclear:
        """The hand that these fingers make."""
        apart, together = self._ends(fingers)
        self._put(together)
        closed = [self._middle(finger) for finger in fingers]
        self._put(apart)
        fingers, first, second = self._sides(fingers, closed)
        axes = self._axes(fingers, first - second, (first + second) / 2)
        if axes is None:
            return Unclear("its fingers do not move towards each other")
        approach = axes[:, 0]
        tips = min(self._most(self.shapes_of(finger), approach) for finger in fingers)
        between = (first + second) / 2
        between = between + (tips - between @ approach) * approach
        beside = [float((self._middle(finger) - between) @ axes[:, 2]) for finger in fingers[:-1]]
        offsets = beside if len(fingers) == 3 else [0.0]
        gaps = [gap for pad in PAD_M if (gap := self._gap(between - pad * approach, axes, offsets))]
        if not gaps:
            return Unclear("no two faces of it close on each other")
        ahead, behind = min(gaps, key=sum)
        opening = ahead + behind
        if not LEAST_OPENING_M < opening < FAR_M:
            return Unclear(f"its inner faces are {opening:.3f} m apart")
        middle = between + (ahead - behind) / 2 * axes[:, 1]
        sizes = self._sizes(fingers, middle, axes, opening)
        if len(fingers) == 3:
            sizes["spread_m"] = abs(beside[0] - beside[1])
        if not 0.0 < sizes["finger_thickness_m"] < sizes["finger_length_m"]:
            return Unclear("its fingers are no longer than they are thick")
        kind: HandKind = "three_finger" if len(fingers) == 3 else "parallel"
        turn, origin = self.data.xmat[self.hand].reshape(3, 3), self.data.xpos[self.hand]
        fields = {"kind": kind, "opening_m": opening, **sizes}
        return Plain(_rounded(fields), KINDS[len(fingers)], turn.T @ (middle - origin), turn.T @ axes)

    def _sides(self, fingers: list[list[int]], closed: Sequence[Array]) -> tuple[list[list[int]], Array, Array]:
        """The fingers with the thumb last, and where those opposite to it and it are; where one closes, if it is alone.

        Of three fingers, the two that are nearest to each other lie side by side.
        """
        opened = [self._middle(finger) for finger in fingers]
        if len(fingers) == 1:
            return fingers, opened[0], closed[0]
        if len(fingers) == 2:
            return fingers, opened[0], opened[1]
        _, i, j = min((float(np.linalg.norm(opened[i] - opened[j])), i, j) for i, j in ((0, 1), (0, 2), (1, 2)))
        thumb = 3 - i - j
        return [fingers[i], fingers[j], fingers[thumb]], (opened[i] + opened[j]) / 2, opened[thumb]

    def _axes(self, fingers: Sequence[Sequence[int]], apart: Array, between: Array) -> Array | None:
        """Approach, closing direction and across, as columns (3, 3); None if its last finger does not close."""
        joint = int(self.model.body_jntadr[fingers[-1][0]])
        axis, origin = np.array(self.data.xaxis[joint]), self.data.xpos[self.hand]
        if int(self.model.jnt_type[joint]) == HINGE:
            closing = apart - (apart @ axis) * axis
            if not np.linalg.norm(closing) > max(MOSTLY * float(np.linalg.norm(apart)), 1e-4):
                return None
            approach = np.cross(axis, normalized(closing))
            approach *= np.sign(approach @ (between - origin)) or 1.0
        elif int(self.model.jnt_type[joint]) == SLIDE:
            closing = axis * (np.sign(axis @ apart) or 1.0)
            own = self._own_shapes()
            base = np.mean([self._center(geom) for geom in own], axis=0) if own else origin
            found = self._ahead(closing, (between - base, between - origin))
            if found is None:
                return None
            approach = found
        else:
            return None
        closing = normalized(closing)
        return np.stack((approach, closing, np.cross(approach, closing)), axis=1)

    def _ahead(self, closing: Array, ways: Sequence[Array]) -> Array | None:
        """Square to the closing direction, along an axis of the hand's body if the way to the fingers is about that."""
        level = next((way for each in ways if np.linalg.norm(way := each - (each @ closing) * closing) > 0.005), None)
        if level is None:
            return None
        ahead = normalized(level)
        turn = self.data.xmat[self.hand].reshape(3, 3)
        nearest = turn[:, int(np.argmax(np.abs(ahead @ turn)))]
        if abs(nearest @ ahead) > ALONG_AXIS and abs(nearest @ closing) < 1e-3:
            return np.asarray(nearest * np.sign(nearest @ ahead))
        return ahead

    def _gap(self, start: Array, axes: Array, offsets: Sequence[float]) -> tuple[float, float] | None:
        """How far the inner faces are ahead and behind of a point between them, metres; None if there are none."""
        ahead = [self._met(start + offset * axes[:, 2], axes[:, 1]) for offset in offsets]
        behind = self._met(start, -axes[:, 1])
        known = [each for each in ahead if each is not None]
        return (min(known), behind) if known and behind is not None else None

    def _met(self, start: Array, direction: Array) -> float | None:
        """How far a ray goes until it meets the hand, metres."""
        groups = np.array([group == INNER for group in range(6)], dtype=np.uint8)
        far = mujoco.mj_ray(self.model, self.data, start, direction, groups, True, -1, np.zeros(1, np.int32))
        return float(far) if 0.0 <= far < FAR_M else None

    def _sizes(self, fingers: Sequence[Sequence[int]], middle: Array, axes: Array, opening: float) -> dict[str, Any]:
        """Sizes of a finger and of the palm, metres; the point is half-way between the tips."""
        approach, closing, across = axes.T
        side = -1.0 if len(fingers) == 3 else 1.0  # a thumb stands opposite the middle, not beside it
        thick, wide = self._finger(middle - AMID_M * approach, side * closing, across, opening)
        behind = [
            self._met(middle - BEHIND_M * approach + share * opening * closing + side * wide * across, -approach)
            for share in (-0.35, 0.0, 0.35)
            for side in (-0.35, 0.0, 0.35)
        ]
        known = [each + BEHIND_M for each in behind if each is not None]
        base = min(float(self.data.xanchor[self.model.body_jntadr[finger[0]]] @ approach) for finger in fingers)
        length = min(known) if known else float(middle @ approach) - base
        found: dict[str, Any] = {"finger_length_m": length, "finger_thickness_m": thick, "finger_width_m": wide}
        own = self._own_shapes()
        if own:
            front = float(middle @ approach) - length
            deep = front + self._most(own, -approach)
            found["palm_m"] = (self._most(own, across) + self._most(own, -across), max(deep, PALM_M))
        return found

    def _finger(self, amid: Array, closing: Array, across: Array, opening: float) -> tuple[float, float]:
        """Thickness and width of the finger ahead of a point between the fingers, metres, by rays from outside."""
        start = amid + (opening / 2 + WIDEST_M) * closing
        outer = self._met(start, -closing)
        thick = WIDEST_M - outer if outer is not None and outer < WIDEST_M else 0.0
        core = amid + (opening + thick) / 2 * closing
        sides = [self._met(core + WIDEST_M * sign * across, -sign * across) for sign in (1.0, -1.0)]
        known = [WIDEST_M - side for side in sides if side is not None and side < WIDEST_M]
        return thick, sum(known) if len(known) == 2 else thick


def _rounded(fields: dict[str, Any]) -> dict[str, Any]:
    """Lengths to a tenth of a millimetre."""
    return {
        key: value
        if isinstance(value, str)
        else tuple(round(float(each), 4) for each in value)
        if isinstance(value, tuple)
        else round(float(value), 4)
        for key, value in fields.items()
    }
