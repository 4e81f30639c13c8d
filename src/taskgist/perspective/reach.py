"""Reach: an arm gets its palm to some cell of the object, and nothing is in the way of it (5.1.2; see ``arms``).

Head, torso and base must not collide, nor the arm. Who holds the object reaches it without effort. An arm that was not
tracked can be stretched out all the same, for its shoulder hangs on the torso; only whether its hand holds the object
is then unknown, unless the object is farther away than the whole arm.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from functools import cached_property, partial

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.perspective.arms import (
    Arms,
    Around,
    all_within,
    arms_of,
    free_configuration,
    shut_in,
    usually_met,
)
from taskgist.perspective.candidates import Candidates, thrust_of
from taskgist.perspective.effort import BlockedArm, Held, Miss, OutOfReach, Quantity, Reached, Reason, stretch
from taskgist.perspective.points_in_reach import DIGITS, NOWHERE, TRIES, PointCloud, beyond, first_in_reach
from taskgist.perspective.target import Target, vector
from taskgist.perspective.viewpoint import FindMiss, Hit, Screening, Viewpoint
from taskgist.settings import ReachModel
from taskgist.world.bodies.agent import ArmIndices
from taskgist.world.contacts import hand_known
from taskgist.world.geometry.linkage import POSE
from taskgist.world.geometry.solids import COLUMNS

# --- What the judges of reach and grasp share: arms that are stretched out, and level 0, which is holding.
#
# Only the agent's own hands matter. One that was not tracked leaves it unknown, unless the object rests on something
# or is farther away than the whole arm.

NOTHING_AROUND = Around(np.empty((0, COLUMNS)), np.empty((0, 0), dtype=np.bool_), 0.0, 0.0, False, np.zeros((2, 3)))
NAMED = 2
"""Names of what is in the way that a reason tells; the evidence has all of them."""
LINK_M = 0.1
"""How thick the links of an arm may be, and how far its palm is from what it touches."""
INSIDE_M = 0.01
"""How far within an object's surface its free surroundings are looked for."""
MOST_SHUT_M = 0.4
"""Of things whose farthest point is farther than this from their middle it is not asked whether they are shut in."""
LARGEST_M = 1.0
"""What a flood of this radius leaves counts as open, however long the arm."""
WHOLE_ARM = 1.25
"""A hand holds nothing farther from its shoulder than this times the arm's length (ours; a human's is 1.1)."""
PARTS: tuple[tuple[str, ...], ...] = ((), ("torso",), ("torso",), ("torso", "legs"), ("torso", "legs"))
"""Parts that must be tracked to judge each level."""
MOST_STAYING = 3
"""The greatest effort level at which an agent stays where it is; it takes other postures there."""
NO_ARM = Miss(Reason.NO_ARM, "no arm may be stretched out")
NO_SURFACE = Miss(Reason.NO_SURFACE, "has no surface")
NOT_HELD = Miss(Reason.NOT_HELD, "not held")


def out_of_reach(side: str, length_m: float, shoulder: Array, points: Array, model: ReachModel) -> Miss:
    """Why an arm of some length reaches none of some points, (k, 3), from a shoulder, (3,)."""
    gap_m = float(np.linalg.norm(points - shoulder, axis=1).min())
    if gap_m <= length_m:
        text = f"outside the sector of the {side} arm" if model == "sector" else f"where the {side} arm does not get to"
        return Miss(Reason.OUT_OF_SECTOR, text, hindrance=OutOfReach(side))
    beyond_m = gap_m - length_m
    far = f"{beyond_m:.2f} m" if beyond_m >= 0.005 else f"{1000 * beyond_m:.1f} mm"
    text = f"{gap_m:.2f} m from the {side} shoulder, {far} beyond the arm"
    return Miss(Reason.TOO_FAR, text, Quantity(beyond_m, "m"), OutOfReach(side, beyond_m))


def usable_arms(here: Viewpoint) -> tuple[tuple[int, ...], Arms]:
    """The arms that an agent may stretch out: their indices, and the same, twice, for compiled functions.

    The right one comes first, and is taken where two are equally near: most people are right-handed. The second time,
    shoulders are thrust forward; none is by the paper's rough reach.
    """
    arms = here.agent.arms
    usable = [index for index, arm in enumerate(arms) if stretch(arm.profile.side) in here.actions]
    usable.sort(key=lambda index: arms[index].profile.side == "left")
    return tuple(usable), arms_of(tuple(arms[index] for index in (*usable, *usable)), here.settings.reach.model)


class ArmJudge:
    """Judges an ability of the arms towards one object.

    Args:
        here: Whose, and from where.
        target: The object.

    Attributes:
        here: As given.
        target: As given.
        arms: Indices of those that may be stretched out.
        reaches: The same for compiled functions, twice: see ``usable_arms``.
        thrusts: Whether any of them may be thrust forward.
        shut_in: Why no way leads from the object to any arm, where that was found out.
        looked: Whether it was tried to find out.
        brief: Whether only the level and how it is attained are asked for, not why it is not with less.
    """

    def __init__(self, here: Viewpoint, target: Target) -> None:
        self.here, self.target = here, target
        self.arms, self.reaches = usable_arms(here)
        self.model = here.settings.reach.model
        self.thrusts = self.model != "sector" and any(here.agent.arms[index].profile.thrust for index in self.arms)
        self.shut_in: Miss | None = None
        self._buried: dict[PointCloud, bool] = {}
        self.looked = self.brief = False

    @property
    def hopeless(self) -> bool:
        """Whether no candidate gives the ability, as far as is known by now."""
        return self.shut_in is not None

    @cached_property
    def surface(self) -> PointCloud:
        """The object's cells."""
        return PointCloud.of(self.target.points)

    @cached_property
    def obstacles(self) -> Indices:
        """Rows of the solid shapes that may be in an arm's way when it reaches the object, (n,)."""
        here, cloud = self.here, self.surface
        far_m = cloud.radius_m + LINK_M + float(self.reaches.sectors[:, 0].max(initial=0.0))  # from palm to shoulder
        geoms = here.collisions.near(cloud.middle, far_m)
        own = here.stage.scene.geoms_of(self.target.name)
        return np.searchsorted(here.collisions.obstacles, geoms[~np.isin(geoms, own)])

    @cached_property
    def around(self) -> Around:
        """What may be in the way of the arms when they reach the object."""
        here = self.here
        squeeze_m, touch_m = here.settings.efforts.collision_m, here.settings.reach.touch_m
        solids = here.collisions.solids[self.obstacles]
        felt = here.recorder.arms.bounds
        usual = usually_met(self.shoulders, self.reaches, solids, squeeze_m, felt)
        return Around(solids, usual, touch_m, squeeze_m, True, felt)

    @property
    def shoulders(self) -> Array:
        """Where the shoulders of those arms are now, twice, and the frames of what carries them, (2 a, 12)."""
        stage, arms = self.here.stage.show(self.here.state), self.here.agent.arms
        poses = [stage.shoulder(arms[index]) for index in (*self.arms, *self.arms)]
        return np.array([[*pose.position, *pose.matrix.ravel()] for pose in poses]).reshape(-1, POSE)

    def owners(self, met: Indices) -> tuple[tuple[str, int], ...]:
        """Whose shapes were met how often, most first; counts by obstacle, (n,)."""
        counts: Counter[str] = Counter()
        obstacles, owners = self.here.collisions.obstacles, self.here.stage.scene.owners
        for row in np.flatnonzero(met).tolist():
            counts[owners[int(obstacles[self.obstacles[row]])]] += int(met[row])
        return tuple(sorted(counts.items(), key=lambda each: (-each[1], each[0])))

    def look_for_way(self) -> None:
        """Find out whether any way at all leads from the object to an arm; see ``shut_in``."""
        self.looked, around, cloud = True, self.around, self.surface
        if cloud.radius_m > MOST_SHUT_M:
            return
        met = np.zeros(len(around.solids), dtype=np.intp)
        inwards = cloud.middle - cloud.points
        away_m = np.maximum(np.linalg.norm(inwards, axis=1), INSIDE_M)[:, None]
        starts = cloud.points + inwards * (INSIDE_M / away_m)
        eye = self.here.stage.eye(self.here.agent).position
        here = np.concatenate((self.shoulders[:, :3], eye[None]))
        radius_m = min(float(self.reaches.sectors[:, 0].max()), LARGEST_M) + cloud.radius_m
        if shut_in(starts, cloud.middle, radius_m, here, around.solids, met, around.felt):
            counts = self.owners(met)
            side = self.arm(self.arms[0]).profile.side
            text = f"shut in by {' and '.join(owner for owner, _ in counts[:NAMED])}"
            self.shut_in = Miss(Reason.SHUT_IN, text, hindrance=BlockedArm(side, counts, shut_in=True))

    def buried(self, cloud: PointCloud) -> bool:
        """Whether all of some points of the object are within other things, so that nobody gets there from anywhere."""
        if cloud not in self._buried:
            self._buried[cloud] = all_within(cloud.points, self.around.solids)
            self.here.recorder.arms.add_points(cloud.points)
        return self._buried[cloud]

    def arm(self, index: int) -> ArmIndices:
        """An arm of the agent by its index; after all of them, they come again with their shoulders thrust forward."""
        return self.here.agent.arms[index % len(self.here.agent.arms)]

    def thrust(self, index: int) -> dict[int, float]:
        """New angles of what thrusts forward the shoulder of an arm, by index into qpos."""
        agent = self.here.agent
        return thrust_of(agent, self.arm(index), self.here.state) if index >= len(agent.arms) else {}

    def passes_over(self, level: int) -> bool:
        """Whether the object is out of reach from all candidates of a level that stay where the agent is."""
        if not 1 <= level <= MOST_STAYING or not len(self.reaches.sectors):
            return False
        middle, radius_m = self.here.candidates.shoulders_ball(level)
        self.here.recorder.postures |= level == MOST_STAYING
        far_m = radius_m + self.surface.radius_m + float(self.reaches.sectors[:, 0].max()) + self.farther_m
        return float(np.linalg.norm(self.surface.middle - middle)) > far_m + INSIDE_M

    @property
    def farther_m(self) -> float:
        """How much farther than the object's surface a hand may be."""
        return 0.0

    def unknown(self, level: int) -> str | None:
        """The shoulders are where the torso is; legs matter from their level on; hands for holding only."""
        return self.here.untracked(PARTS[level]) if level else self._hand_unknown()

    def _hand_unknown(self) -> str | None:
        """Sentence about a hand that was not tracked and might hold the object; None if there is none."""
        here = self.here
        if self.target.name in here.held:
            return None
        stage, agent = here.stage.show(here.state), here.agent
        for arm in agent.arms:
            if not hand_known(stage, agent, arm) and self._could_hold(arm) and not here.is_supported(self.target):
                return f"{agent.name}'s {arm.profile.side} hand not tracked, and it might hold the object"
        return None

    def _could_hold(self, arm: ArmIndices) -> bool:
        """Whether the object is near enough to the arm's shoulder in the state that the stage shows."""
        shoulder = self.here.stage.shoulder(arm).position
        nearest = float(np.linalg.norm(self.target.points - shoulder, axis=1).min(initial=np.inf))
        return nearest <= WHOLE_ARM * arm.profile.length_m

    def without_effort(self) -> Hit | FindMiss:
        """Level 0: held, or not."""
        side = self.here.held.get(self.target.name)
        return (lambda: NOT_HELD) if side is None else Hit(partial(Held, side))


class Reach(ArmJudge):
    """Judges the ability to reach one object."""

    def screen(self, candidates: Candidates) -> Screening:
        """What the arms reach from some candidates."""
        return ReachScreening(self, candidates, self.surface)


class ReachScreening:
    """What each arm reaches from n candidates, of points of the object.

    Args:
        judge: Whose arms.
        candidates: The candidates.
        cloud: The points.

    Attributes:
        arms: Indices of the arms, in the second half with their shoulders thrust forward: see ``ArmJudge.arm``.
    """

    def __init__(self, judge: ArmJudge, candidates: Candidates, cloud: PointCloud) -> None:
        self._judge, self._candidates, self._cloud = judge, candidates, cloud
        thrust = (
            [index + len(judge.here.agent.arms) for index in judge.arms]
            if judge.thrusts and candidates.torso.thrusts
            else []
        )
        self.arms = (*judge.arms, *thrust)
        shoulders = candidates.torso.frames.first_shoulder + np.array(self.arms, dtype=np.intp)
        self._from, self._to = (
            (candidates.table, shoulders, len(judge.arms), judge.reaches),
            (cloud.points, cloud.middle, cloud.radius_m),
        )
        count = len(self.arms)
        self._nearest, self._reach_m = np.empty(count, dtype=np.intp), np.empty(count)
        self._missed, self._gap_m = np.full(count, NOWHERE), np.full(count, np.inf)
        self._blocked = np.full(count, NOWHERE)

    def next(self, start: int, stop: int) -> int:
        """The first candidate from which an arm reaches one of the points."""
        if not len(self._cloud.points) or self._judge.shut_in is not None:
            return stop
        judge, noted = self._judge, (self._nearest, self._reach_m, self._missed, self._gap_m, self._blocked)
        # What is in the way matters only from where an arm is long enough.
        start, able = first_in_reach(*self._from, NOTHING_AROUND, *self._to, start, stop, False, *noted)
        if not able or judge.model == "sector":
            return start
        if judge.brief and judge.buried(self._cloud):
            return stop
        where = (*self._from, judge.around, *self._to)
        found, able = first_in_reach(*where, start, stop, not judge.looked, *noted)
        if found < stop and not able:
            judge.look_for_way()
            over = judge.shut_in is not None or (judge.brief and judge.hopeless)
            found, able = first_in_reach(*where, stop if over else found + 1, stop, False, *noted)
        return found

    def beyond(self, margin_m: float) -> bool:
        """Whether all points are farther than this beyond every arm, from every candidate."""
        table, shoulders, _, arms = self._from
        return beyond(table, shoulders, arms, *self._to, margin_m)

    def able(self, index: int) -> list[int]:
        """Which of the arms reach some point from such a candidate, the nearer shoulder's first.

        Returns:
            Places in ``arms``, each arm once; those that need not be thrust forward come first.
        """
        self.next(index, index + 1)
        columns, once = np.flatnonzero(self._nearest != NOWHERE).tolist(), len(self._judge.arms)
        return sorted(columns, key=lambda column: (column >= once, round(float(self._reach_m[column]), DIGITS)))

    def results(self, index: int) -> Iterator[Hit | FindMiss]:
        """How those arms reach the object."""
        return iter([self._stretched(column) for column in self.able(index)])

    def miss(self) -> Miss | None:
        """Why the candidates passed over reach nothing: the arm that misses the object least."""
        if not self._judge.arms:
            return NO_ARM
        if not len(self._cloud.points):
            return NO_SURFACE
        if self._judge.shut_in is not None:
            return self._judge.shut_in
        if (self._blocked != NOWHERE).any():
            return self._in_the_way(int(np.argmax(self._blocked != NOWHERE)))
        column = int(np.argmin(np.round(self._gap_m, DIGITS)))
        if self._missed[column] == NOWHERE:
            return None
        arm = self.arms[column]
        shoulder = self._candidates.shoulder(int(self._missed[column]), arm)
        profile = self._judge.arm(arm).profile
        length_m = profile.length_m if self._judge.model == "sector" else float(self._judge.reaches.sectors[column, 0])
        return out_of_reach(profile.side, length_m, shoulder.position, self._cloud.points, self._judge.model)

    def _in_the_way(self, column: int) -> Miss:
        """What keeps an arm from the points, from the first candidate where it would reach them otherwise."""
        judge, index = self._judge, int(self._blocked[column])
        arm = self.arms[column]
        pose = self._candidates.frames(index)[self._candidates.torso.frames.first_shoulder + arm]
        met = np.zeros(len(judge.around.solids), dtype=np.intp)
        for point in self._cloud.points[np.argsort(np.linalg.norm(self._cloud.points - pose[:3], axis=1))[:TRIES]]:
            free_configuration(pose, judge.reaches, column, point, judge.around, met)
        side, counts = judge.arm(arm).profile.side, judge.owners(met)
        text = f"the way of the {side} arm is blocked"
        if counts:
            text += f" by {' and '.join(owner for owner, _ in counts[:NAMED])}"
        return Miss(Reason.ARM_BLOCKED, text, hindrance=BlockedArm(side, counts))

    def _stretched(self, column: int) -> Hit:
        judge, arm = self._judge, self.arms[column]
        side, distance_m = judge.arm(arm).profile.side, float(self._reach_m[column])
        point = self._cloud.points[self._nearest[column]]
        return Hit(
            lambda: Reached(side, vector(point), distance_m),
            judge.thrust(arm),
            (stretch(side),),
            cost=round(distance_m, DIGITS),
            thrusts=column >= len(judge.arms),
        )
