"""A performer's body: which posture brings a hand somewhere.

The torso leans and turns only as far as the arm alone does not get there; the arm then follows the hand exactly; the
other hand stays where it rests.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from itertools import product
from typing import Literal

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import SceneError
from taskgist.moving.hand_pose import SIGNS, UP, HandPose, upright
from taskgist.moving.motion import Motion
from taskgist.world.fit import Fitter
from taskgist.world.geometry.transforms import rotate, yaw_of
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State

COMFORTABLE_SHARE = 0.88
"""Share of an arm's length that it stretches without the torso's help."""
LEANS_RAD = np.radians(np.arange(0.0, 57.0, 3.0))
TURNS_RAD = np.radians((0.0, 10.0, 20.0, 30.0))
FAR_TURNS_RAD = np.radians(np.arange(-90.0, 91.0, 10.0))
"""Turns to both sides, for who looks for something aside."""
TURN_PRICE = 0.5
"""How much less people mind turning than leaning."""
READY_AHEAD_SHARE, READY_DOWN_SHARE = 0.12, 0.10
"""Where a hand is raised to before it reaches out: ahead of and below its shoulder, as shares of the stature."""
READY_RISE_RAD = math.radians(55.0)
"""How steeply its fingers point then: a hand comes up from beneath the edge of a table."""
DRAWN_BACK_M, DRAWN_UP_M = 0.11, 0.10
"""How far it is first drawn back and up from where it rests."""
ELBOW_OUT_M = 0.12
ELBOW_WEIGHT = 0.03
"""The elbow's wish counts little beside the hand's goal: it chooses among the arm's ways to get there."""
FIT_DAMPING = 1e-5
"""Goals of hands are exact: with less damping than noisy keypoints need, fits get there in half the steps."""
AHEAD_M = 0.3
"""How far behind the shoulder the fingers' direction starts: near the body hands point ahead rather than aside."""
WRIST_BENT_RAD = math.radians(25.0)
"""How far a wrist is bent without effort."""


class Body:
    """The body of one agent of a scene, with the joints that reaching takes.

    Postures are vectors over ``joints``: the torso's turn and lean, then both arms.

    Args:
        scene: The scene.
        name: Name of the agent.
        at_rest: The state in which it rests: a hand that does nothing stays where it is there. None: the scene's.
        turns_far: Whether it turns its torso as far as it goes, and to both sides, where less does not do.

    Attributes:
        agent: The agent.
        joints: Names of those joints, (n,).
        columns: Their indices into qpos, (n,).
        ranges_rad: Their least and greatest angle, (n, 2).
    """

    def __init__(self, scene: Scene, name: str, at_rest: State | None = None, *, turns_far: bool = False) -> None:
        self.agent, self._turns_far = scene.agent(name), turns_far
        self._stage = Stage(scene)
        turn, lean = self.agent.profile.turn, self.agent.profile.lean
        if turn is None or lean is None or len(self.agent.arms) != 2:
            raise SceneError("demonstrators need a torso that turns and leans, and two arms", where=name)
        arms = _arm_joints(scene, name)
        self.joints = (turn.joint, lean.joint, *arms)
        self.columns = np.array([self.agent.joints[joint] for joint in self.joints])
        self.ranges_rad = np.array([scene.model.joint(f"{name}/{joint}").range for joint in self.joints])
        self._resting = at_rest or scene.initial
        self._at_rest = {side: self.hand(self._resting, side) for side in self.agent.sides}

    @cached_property
    def _fitter(self) -> Fitter:
        elbows = {f"{side}_elbow": ELBOW_WEIGHT for side in self.agent.sides}
        return Fitter(self._stage.scene, self.agent.name, moving=self.joints[2:], weights=elbows, damping=FIT_DAMPING)

    def posture(self, state: State) -> Array:
        """The posture (n,) in a state."""
        return np.array(state.qpos[self.columns])

    @property
    def resting_posture(self) -> Array:
        """The posture (n,) at rest."""
        return self.posture(self._resting)

    def with_posture(self, state: State, posture: Array) -> State:
        """A state with another posture."""
        return state.replace(dict(zip(self.columns.tolist(), posture.tolist(), strict=True)))

    def hand(self, state: State, side: str) -> HandPose:
        """Where a hand is in a state."""
        arm = self.agent.arm(side)
        stage = self._stage.show(state)
        matrix = stage.body(arm.hand_body).matrix
        return HandPose(stage.site(arm.palm_site).position, -matrix[:, 2], SIGNS[side] * matrix[:, 1])

    def shoulder(self, state: State, side: str) -> Array:
        """Place of a shoulder in metres, (3,)."""
        return self._stage.show(state).shoulder(self.agent.arm(side)).position

    def raising(self, side: str) -> tuple[HandPose, HandPose]:
        """How a hand comes up from rest: drawn back from the edge of a table, then ready before its shoulder."""
        rest, initial = self._at_rest[side], self._resting
        ahead = rotate(initial.qpos[self.agent.base][3:], (1.0, 0.0, 0.0))
        stature = self.agent.stature_m
        place = self.shoulder(initial, side) + READY_AHEAD_SHARE * stature * ahead - READY_DOWN_SHARE * stature * UP
        ready = upright(side, place, ahead, rise_rad=READY_RISE_RAD)
        drawn = rest.toward(ready, 0.5)
        return HandPose(rest.palm - DRAWN_BACK_M * ahead + DRAWN_UP_M * UP, drawn.fingers, drawn.facing), ready

    def with_torso(self, state: State, torso_rad: Array) -> State:
        """A state with another turn and lean of the torso, (2,)."""
        return state.replace(dict(zip(self.columns[:2].tolist(), torso_rad.tolist(), strict=True)))

    def torso_for(self, state: State, side: str, palm: Array) -> Array:
        """The least turn and lean (2,) with which an arm gets comfortably to a place; the most if none does.

        Who turns far gets as near as may be then.
        """
        comfortable = COMFORTABLE_SHARE * self.agent.arm(side).profile.length_m
        most = np.array([SIGNS[side] * TURNS_RAD[-1], LEANS_RAD[-1]])
        nearest = (math.inf, most)
        for turns_rad in (TURNS_RAD, *((FAR_TURNS_RAD,) if self._turns_far else ())):
            by_price = sorted(product(turns_rad, LEANS_RAD), key=lambda pair: TURN_PRICE * abs(pair[0]) + pair[1])
            for turn, lean in by_price:
                torso = np.array([SIGNS[side] * turn, lean])
                away_m = self.away_m(state, side, palm, torso)
                if away_m <= comfortable:
                    return torso
                nearest = min(nearest, (round(away_m, 6), torso), key=lambda each: each[0])
        return nearest[1] if self._turns_far else most

    def away_m(self, state: State, side: str, palm: Array, torso_rad: Array) -> float:
        """How far a shoulder is from a place, with a turn and lean of the torso, (2,)."""
        return float(np.linalg.norm(self.shoulder(self.with_torso(state, torso_rad), side) - palm))

    def reaching(
        self, state: State, side: str, hand: HandPose, torso_rad: Array, *, iterations: int
    ) -> tuple[State, float]:
        """The state in which a hand is somewhere, while the other one stays where it rests.

        Args:
            state: Where to start from: what is near decides among the ways to bend an arm.
            side: The hand.
            hand: Where it shall be.
            torso_rad: Turn and lean of the torso, (2,).
            iterations: Most steps of the fit.

        Returns:
            The state, and the distance in metres that the hand is still away.
        """
        hands = {**self._other_hands(state, torso_rad), side: hand}
        points = {f"{of}_palm": pose.palm for of, pose in hands.items()}
        directions = {f"{of}_hand": pose.fingers for of, pose in hands.items()}
        directions |= {f"{of}_palm": pose.facing for of, pose in hands.items()}
        leaning = self.with_torso(state, torso_rad)
        points[f"{side}_elbow"] = self._elbow(leaning, side, hand)
        fit = self._fitter.fit(leaning, points=points, directions=directions, iterations=iterations)
        return fit.state, fit.errors_m[f"{side}_palm"]

    def _other_hands(self, state: State, torso_rad: Array) -> dict[str, HandPose]:
        """Where hands are that do nothing: as at rest, but that the torso takes them along once it turns far."""
        farther = float(torso_rad[0] - np.clip(torso_rad[0], -TURNS_RAD[-1], TURNS_RAD[-1]))
        if not self._turns_far or not farther:
            return self._at_rest
        middle = np.array([*state.qpos[self.agent.base][:2], 0.0])
        return {side: hand.moved(-middle).turned(farther).moved(middle) for side, hand in self._at_rest.items()}

    def _elbow(self, state: State, side: str, hand: HandPose) -> Array:
        """Where the elbow would like to be: level with the arm's middle and out, so that it clears a table."""
        yaw = yaw_of(state.qpos[self.agent.base][3:])
        outward = SIGNS[side] * np.array([math.sin(yaw), -math.cos(yaw), 0.0])
        return np.asarray((self.shoulder(state, side) + hand.palm) / 2 + ELBOW_OUT_M * outward)

    def tip_m(self, side: str) -> float:
        """How far the fingertips are beyond the palm's middle."""
        model, name = self._stage.scene.model, self.agent.name
        tip, palm = (model.site(f"{name}/{side}_{site}").pos for site in ("fingertip", "palm"))
        return float(palm[2] - tip[2])

    def dip_to(self, state: State, side: str, place: Array, torso_rad: Array) -> float:
        """How far below the horizontal the fingers point when a hand reaches for a place: nearly along the arm."""
        x, y, z = place - self.shoulder(self.with_torso(state, torso_rad), side)
        return max(0.0, math.atan2(-z, math.hypot(x, y)) - WRIST_BENT_RAD)

    def heading_to(self, state: State, side: str, place: Array) -> Array:
        """Horizontal direction (2,) in which a hand points when it reaches for a place from its shoulder."""
        yaw = yaw_of(state.qpos[self.agent.base][3:])
        ahead = np.array([math.cos(yaw), math.sin(yaw)])
        away = (place - self.shoulder(state, side))[:2]
        return np.asarray(away + AHEAD_M * ahead)


def _arm_joints(scene: Scene, name: str) -> tuple[str, ...]:
    """Names of the joints of both arms."""
    agent = scene.agent(name)
    model = scene.model
    geoms = np.concatenate([arm.geoms for arm in agent.arms])
    bodies = set(model.geom_bodyid[geoms].tolist())
    by_column = {int(model.jnt_qposadr[j]): int(model.jnt_bodyid[j]) for j in range(model.njnt)}
    return tuple(joint for joint, column in agent.joints.items() if by_column[column] in bodies)


# --- Following: the body follows a hand along its way, from posture to posture, at people's pace.

MEAN_SPEED_M_S = 0.45
"""Mean speed of a hand; the peak is nearly twice as much (unhurried reaching [Flash & Hogan 1985])."""
LEVER_M = 0.20
"""Lever with which the largest turn of a joint counts like a way of the hand: it bounds the joints' speeds."""
SHORTEST_S = 0.6
WAY_ITERATIONS, GOAL_ITERATIONS = 10, 60
"""Most steps of a fit on the way, where the next knot goes on from there, and at the goal, which must be met."""
LARGEST_ERROR_M = 0.003
"""How far a hand may end from its goal."""
MORE_LEAN_RAD = tuple(math.radians(degrees) for degrees in (0.0, 4.0, 8.0, 12.0))
"""How much farther than thought one leans where the arm does not get to its goal."""
SHORTEST_STEP_M = 1e-4
"""Keeps postures apart whose hands are at the same place."""
Phase = Literal["out", "over", "back"]
LEANING: Mapping[Phase, Callable[[Array], Array]] = {
    "out": lambda way: way**2,
    "over": lambda way: way,
    "back": lambda way: 1.0 - (1.0 - way) ** 2,
}
"""Share of the torso's movement after a share of the hand's way: near the body a hand needs no lean."""


def followed(
    body: Body, state: State, side: str, way: Sequence[HandPose], *, torso_rad: Array, phase: Phase, role: str
) -> list[State]:
    """States in which a hand follows a way, the one to start from included.

    Who does not get to the goal leans a little more.

    Args:
        body: Whose hand.
        state: Where everything is at first.
        side: The hand.
        way: Where it passes, the last one being the goal.
        torso_rad: Turn and lean of the torso at the goal, (2,).
        phase: Out from rest, over from place to place, or back to rest, which follows after the goal.
        role: Who that is in the demonstration, for the error.

    Raises:
        SceneError: The hand does not get to its goal; on the way back it need not.
    """
    if phase == "back":
        states, _ = _through(body, state, side, way, torso_rad, phase)
        return [*states, body.with_posture(states[-1], body.resting_posture)]
    for more in MORE_LEAN_RAD:
        torso = np.clip(torso_rad + (0.0, more), *body.ranges_rad[:2].T)
        states, error = _through(body, state, side, way, torso, phase)
        if error <= LARGEST_ERROR_M:
            return states
    raise SceneError(
        f"the {side} hand ends {1000 * error:.0f} mm from where it shall be",
        where=body.agent.name,
        field=f"{side}_palm",
        value=tuple(way[-1].palm.round(3).tolist()),
        hint=f"put the thing or its goal nearer to the {role} agent",
    )


def _through(
    body: Body, state: State, side: str, way: Sequence[HandPose], torso_rad: Array, phase: Phase
) -> tuple[list[State], float]:
    """States in which the hand passes its way, and how many metres the last one is from its goal."""
    states, error = [state], 0.0
    begin = body.posture(state)[:2]
    shares = LEANING[phase](np.linspace(0.0, 1.0, len(way) + 1)[1:])
    for hand, share in zip(way, shares, strict=True):
        torso = begin + share * (torso_rad - begin)
        iterations = GOAL_ITERATIONS if hand is way[-1] else WAY_ITERATIONS
        state, error = body.reaching(state, side, hand, torso, iterations=iterations)
        states.append(state)
    return states, error


def paced(
    body: Body, side: str, states: Sequence[State], *, start_s: float, tempo: float, duration_s: float | None
) -> Motion:
    """The motion of a body through states.

    Args:
        body: The body.
        side: The hand that it is about.
        states: The states, two or more.
        start_s: When it begins.
        tempo: How much longer than usual it takes, as a factor.
        duration_s: How long it takes; None: as long as unhurried people take.
    """
    palms = np.array([body.hand(state, side).palm for state in states])
    postures = np.array([body.posture(state) for state in states])
    moved = np.linalg.norm(np.diff(palms, axis=0), axis=1)
    turned = np.abs(np.diff(postures, axis=0)).max(axis=1)
    steps = np.hypot(moved, LEVER_M * turned) + SHORTEST_STEP_M
    ways = np.concatenate(([0.0], np.cumsum(steps)))
    lasts = duration_s or max(SHORTEST_S, ways[-1] / MEAN_SPEED_M_S) * tempo
    return Motion(postures, ways / ways[-1], start_s, lasts)
