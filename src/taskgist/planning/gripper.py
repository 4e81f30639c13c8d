"""A gripper as its model has it: where its pads are, and with which joint values it opens so wide.

Nothing is told about a gripper but what its profile names: the hand's body and the palm's frame. Its joints are those
in the hand's subtree that do not carry the palm. They move together, as couplings of the model say; where a coupling
was lost, each goes its share of its range, from the end at which it closes. How wide the pads are apart then is
measured: rays from between them, near the tips, meet their inner faces.

The frame of a hand is that of ``world.bodies.hands``: x along the approach, y from the thumb to the fingers, z across.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.world.bodies.agent import Agent, ArmIndices, Coupling, couplings, subtree
from taskgist.world.bodies.hands import Hand
from taskgist.world.geometry.shapes import distances_outside_m, spans_m
from taskgist.world.geometry.transforms import Pose
from taskgist.world.stage import Stage
from taskgist.world.state import State

OPENINGS = 17
"""Openings that are measured, from closed to wide; what lies between them is interpolated, to about 0.1 mm."""
PAD_M = (0.002, 0.010, 0.018)
"""How far behind the tips rays look for the pads (ours: pads are about two centimetres long)."""
TRACED, MET_M, FAR_M = 40, 1e-4, 0.3
"""Steps of a ray at most, how near it comes to what it meets, and how far it goes."""


@dataclass(frozen=True)
class Pads:
    """Where a gripper's pads are, in the palm's frame, the axes of the hand: metres.

    Attributes:
        tips_m: How far ahead of the palm's frame the fingers end.
        middle_m: Half-way between the pads, along the closing direction.
        opening_m: How far they are apart.
    """

    tips_m: float
    middle_m: float
    opening_m: float


class Gripper:
    """The hand of an arm.

    Args:
        stage: The scene in a state; it shows the same state afterwards.
        agent: Whose.
        arm: Which.
        hand: What its profile says of it.

    Attributes:
        positions: Indices into qpos of its joints, (n,); none for fingers that do not move.
        axes: The hand's axes in the palm's frame: columns along approach, closing direction and across, (3, 3).
        closed: Joint values at which its pads are nearest to each other, (n,).
        wide: Joint values at which they are farthest apart, (n,).
    """

    def __init__(self, stage: Stage, agent: Agent, arm: ArmIndices, hand: Hand) -> None:
        self._stage, self._agent, self._arm, self._hand = stage, agent, arm, hand
        model = stage.scene.model
        self._joints = _finger_joints(model, arm)
        self.positions: Indices = model.jnt_qposadr[self._joints].astype(np.intp)
        with stage.showing(stage.state):
            self.axes = self._hand_axes()
            self.closed, self.wide = self._ends()
        self.narrowest_m, self.widest_m = (self.pads(values).opening_m for values in (self.closed, self.wide))

    def too_narrow(self, width_m: float) -> str | None:
        """Why it does not open for a thing of such a width; names the joints that would; None if it does."""
        if width_m <= self.widest_m:
            return None
        names = [str(self._stage.scene.model.joint(joint).name).partition("/")[2] for joint in self._joints]
        why = f"{', '.join(names)} open it no wider" if names else "no joint of it opens it"
        return f"the {self._arm.profile.side} hand is open by {self.widest_m:.3f} m, not by {width_m:.3f} m: {why}"

    def opened(self, opening_m: float) -> Array:
        """Joint values, (n,), at which the pads are so far apart; the nearest that there are."""
        shares, pads = self._measures
        return self._at(float(np.interp(opening_m, [each.opening_m for each in pads], shares)))

    def palm_in_hand(self, opening_m: float) -> Pose:
        """The palm's frame in the hand's, whose origin is the point that the pads close on, when so wide open."""
        _, pads = self._measures
        known = [each.opening_m for each in pads]
        tips_m, middle_m = (
            float(np.interp(opening_m, known, values))
            for values in ([each.tips_m for each in pads], [each.middle_m for each in pads])
        )
        point = self.axes @ (tips_m - self._hand.tips_m, middle_m, 0.0)
        return Pose(-self.axes.T @ point, self.axes.T)

    def ahead_m(self, opening_m: float, direction: Array) -> float:
        """How far the hand, so wide open, goes from the palm's frame along a direction in that (3,), metres."""
        with self._stage.showing(self._with(self.opened(opening_m))) as stage:
            palm = stage.site(self._arm.palm_site)
            towards = palm.matrix @ direction
            return max(self._extent_m(stage, int(geom), palm, towards) for geom in self._arm.hand_geoms)

    @cached_property
    def _measures(self) -> tuple[Array, list[Pads]]:
        """Shares of the way from closed to wide, and where the pads are then."""
        shares = np.linspace(0.0, 1.0, OPENINGS if len(self.positions) else 1)
        with self._stage.showing(self._stage.state):
            return shares, [self.pads(self._at(float(share))) for share in shares]

    def pads(self, values: Array) -> Pads:
        """Where the pads are with such joint values, (n,)."""
        with self._stage.showing(self._with(values)) as stage:
            return self._measured(stage)

    def _at(self, share: float) -> Array:
        """Joint values so far from closed to wide open."""
        return np.asarray((1.0 - share) * self.closed + share * self.wide)

    def _with(self, values: Array) -> State:
        return self._stage.state.replace(dict(zip(self.positions.tolist(), values.tolist(), strict=True)))

    def _measured(self, stage: Stage) -> Pads:
        palm, shapes = stage.site(self._arm.palm_site), self._arm.hand_geoms
        turn = palm.matrix @ self.axes
        tips_m = max(self._extent_m(stage, int(geom), palm, turn[:, 0]) for geom in shapes)
        starts = self._between(palm, turn[:, 0], turn[:, 2], tips_m)
        ahead_m, behind_m = (self._gap_m(stage, starts, sign * turn[:, 1]) for sign in (1.0, -1.0))
        opening_m = self._hand.opening_m
        if ahead_m >= FAR_M and behind_m >= FAR_M:
            return Pads(tips_m, 0.0, 0.0)
        if behind_m >= FAR_M:  # a flat hand: what it closes on lies before it, as wide as it opens
            behind_m = opening_m - ahead_m
        elif ahead_m >= FAR_M:
            ahead_m = opening_m - behind_m
        return Pads(tips_m, (ahead_m - behind_m) / 2, ahead_m + behind_m)

    def _between(self, palm: Pose, approach: Array, across: Array, tips_m: float) -> Array:
        """Points between the pads, in the world, metres, (n, 3)."""
        sideways = (0.0, self._hand.spread_m / 2, -self._hand.spread_m / 2)
        beside = sideways if self._hand.kind == "three_finger" else sideways[:1]
        return np.array([palm.position + (tips_m - pad) * approach + side * across for pad in PAD_M for side in beside])

    def _gap_m(self, stage: Stage, starts: Array, direction: Array) -> float:
        """How far the hand's inner face is along a direction from points between the pads; ``FAR_M`` if there is none.

        The distance to what is nearest is always free to go (sphere tracing [Hart 1996]).
        """
        gone_m, model = np.zeros(len(starts)), stage.scene.model
        poses = [(int(geom), stage.geom(int(geom))) for geom in self._arm.hand_geoms]
        for _ in range(TRACED):
            points = starts + gone_m[:, None] * direction
            free_m = np.min(
                [distances_outside_m(model, geom, pose.to_local(points), within_m=FAR_M) for geom, pose in poses],
                axis=0,
            )
            gone_m = np.minimum(gone_m + np.maximum(free_m, 0.0), FAR_M)
            if (free_m < MET_M).any() or (gone_m >= FAR_M).all():
                break
        return float(gone_m.min())

    def _extent_m(self, stage: Stage, geom: int, palm: Pose, direction: Array) -> float:
        """How far ahead of the palm's frame a shape goes."""
        pose = stage.geom(geom)
        return float((pose.position - palm.position) @ direction) + float(
            spans_m(stage.scene.model, geom, direction @ pose.matrix)[1]
        )

    def _hand_axes(self) -> Array:
        """The axes of the hand along those of the palm's frame: the approach leads from the hand's body to the palm.

        The closing direction is that of the two others on whose both sides the hand has something; a flat hand has
        something on one side, its fingers.
        """
        stage = self._stage
        palm, origin = stage.site(self._arm.palm_site), stage.body_position(self._arm.hand_body)
        ahead = palm.to_local(palm.position) - palm.to_local(origin)
        along = int(np.argmax(np.abs(ahead)))
        approach = np.sign(ahead[along]) * np.eye(3)[along]
        tips_m = max(self._extent_m(stage, int(g), palm, palm.matrix @ approach) for g in self._arm.hand_geoms)
        met = {}
        for axis in {0, 1, 2} - {along}:
            across = palm.matrix @ np.cross(approach, np.eye(3)[axis])
            starts = self._between(palm, palm.matrix @ approach, across, tips_m)
            met[axis] = [self._gap_m(stage, starts, sign * palm.matrix[:, axis]) < FAR_M for sign in (1.0, -1.0)]
        closing_axis = max(met, key=lambda axis: (sum(met[axis]), axis == 1))
        closing = (-1.0 if met[closing_axis] == [False, True] else 1.0) * np.eye(3)[closing_axis]
        return np.stack((approach, closing, np.cross(approach, closing)), axis=1)

    def _ends(self) -> tuple[Array, Array]:
        """Joint values with the pads nearest and farthest apart: every joint at that end of its range."""
        model = self._stage.scene.model
        if not len(self._joints):
            return np.empty(0), np.empty(0)
        own = [each for each in couplings(model) if {each.follower, each.leader} <= set(self._joints)]
        followers = {each.follower for each in own}
        now = np.array(self._stage.state.qpos[self.positions])
        closed, wide = now.copy(), now.copy()
        for row, joint in enumerate(self._joints):
            if joint in followers or not model.jnt_limited[joint]:
                continue
            trials = []
            for end in model.jnt_range[joint]:
                values = now.copy()
                values[row] = end
                trials.append((self.pads(_coupled(model, self._joints, own, values)).opening_m, float(end)))
            closed[row], wide[row] = min(trials)[1], max(trials)[1]
        return _coupled(model, self._joints, own, closed), _coupled(model, self._joints, own, wide)


def _finger_joints(model: mujoco.MjModel, arm: ArmIndices) -> list[int]:
    """Joints that the hand carries and that do not carry its palm."""
    carrying, body = set(), int(model.site_bodyid[arm.palm_site])
    while body:
        carrying.add(body)
        body = int(model.body_parentid[body])
    inside = set(subtree(model, arm.hand_body)) - carrying
    return [joint for joint in range(model.njnt) if int(model.jnt_bodyid[joint]) in inside]


def _coupled(model: mujoco.MjModel, joints: list[int], couplings: list[Coupling], values: Array) -> Array:
    """The values of some joints, with those of followers as their leaders have it."""
    found = values.copy()
    for coupling in couplings:
        found[joints.index(coupling.follower)] = coupling.led(model, values[joints.index(coupling.leader)])
    return found
