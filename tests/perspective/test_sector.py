"""What arms reach by the paper's rough reach, against distances, azimuths and elevations worked out point by point."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from taskgist.perspective import Viewpoint
from taskgist.perspective.candidates import Candidates
from taskgist.perspective.effort import Miss, Reached, Reason
from taskgist.perspective.points_in_reach import PointCloud, grasps_in_reach
from taskgist.perspective.reach import Reach, ReachScreening
from taskgist.perspective.viewpoint import Hit
from taskgist.world import Arm, ArmIndices, Pose
from tests.perspective.random_rooms import random_case
from tools.rooms import ROUGH, Person, Room, Thing, chair

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Generator = np.random.Generator
SEEDS = range(900, 904)
ROUNDING = 1e-9
"""How far outside of its sector an arm still reaches."""
BODIES = ("human", "jido", "hrp2")


# the plain way ------------------------------------------------------------------------------------------------


def distances_m(shoulder: Pose, points: Array) -> Array:
    return np.asarray(np.linalg.norm(points - shoulder.position, axis=1))


def reached(shoulder: Pose, arm: Arm, points: Array) -> Flags:
    """Which points are no farther than the arm is long, and in front of its shoulder."""
    x, y, z = shoulder.to_local(points).T
    azimuth, elevation = np.arctan2(-y if arm.side == "right" else y, x), np.arctan2(z, np.hypot(x, y))
    inside = distances_m(shoulder, points) <= arm.length_m + ROUNDING
    for angle, (low, high) in ((azimuth, arm.azimuth_rad), (elevation, arm.elevation_rad)):
        inside &= (low - ROUNDING <= angle) & (angle <= high + ROUNDING)
    return np.asarray(inside)


def able(judge: Reach, candidates: Candidates, index: int, points: Array) -> list[int]:
    """Arms that reach one of some points from a candidate, the nearer shoulder's first."""
    least = []
    for column, arm in enumerate(judge.arms):
        shoulder = candidates.shoulder(index, arm)
        ours = reached(shoulder, judge.arm(arm).profile, points)
        if ours.any():
            least.append((round(float(distances_m(shoulder, points)[ours].min()), 6), column))
    return [column for _, column in sorted(least)]


def gaps_m(judge: Reach, candidates: Candidates, points: Array) -> Array:
    """How far the nearest point is from each arm's shoulder, from each candidate, (n, a)."""
    return np.array(
        [
            [distances_m(candidates.shoulder(index, arm), points).min() for arm in judge.arms]
            for index in range(len(candidates))
        ]
    )


# rooms --------------------------------------------------------------------------------------------------------


def judges(seed: int) -> Iterator[Reach]:
    case = random_case(seed)
    for agent in case.scene.agents:
        here = Viewpoint(case.stage(), agent, ROUGH)
        for name in case.scene.objects:
            yield Reach(here, here.target(name))


def batches(judge: Reach) -> Iterator[Candidates]:
    for level in range(1, 5):
        yield from judge.here.candidates.of_level(level, judge.target.middle)


def clouds(judge: Reach, candidates: Candidates, rng: Generator) -> Iterator[Array]:
    """The object's points, and points anywhere about a shoulder: one, a few, and spread out."""
    yield judge.surface.points
    if judge.arms and len(candidates):
        shoulder = candidates.shoulder(int(rng.integers(len(candidates))), judge.arms[0])
        length_m = judge.arm(judge.arms[0]).profile.length_m
        for count, spread in ((1, 0.0), (5, 0.1), (5, 1.0)):
            middle = shoulder.position + rng.uniform(-1.2, 1.2, 3) * length_m
            yield middle + spread * rng.uniform(-1, 1, (count, 3))


@pytest.mark.parametrize("seed", SEEDS)
def test_arms_reach_what_is_within_length_and_sector(seed: int) -> None:
    rng, found = np.random.default_rng(seed), {True: 0, False: 0}
    for judge in judges(seed):
        for candidates in batches(judge):
            for points in clouds(judge, candidates, rng):
                screening = ReachScreening(judge, candidates, PointCloud.of(points))
                ours = [able(judge, candidates, index, points) for index in range(len(candidates))]
                assert passed_over(screening, len(candidates)) == [index for index, arms in enumerate(ours) if not arms]
                for index, arms in enumerate(ours):
                    found[bool(arms)] += 1
                    if arms or rng.random() < 0.1:
                        assert screening.able(index) == arms
    assert min(found.values()) > 50


def passed_over(screening: ReachScreening, count: int) -> list[int]:
    missed, index = list(range(count)), screening.next(0, count)
    while index < count:
        missed.remove(index)
        index = screening.next(index + 1, count)
    return missed


@pytest.mark.parametrize("seed", SEEDS)
def test_outcomes_tell_the_nearest_point_of_each_arm(seed: int) -> None:
    outcomes = 0
    for judge in judges(seed):
        for candidates in batches(judge):
            screening, points = judge.screen(candidates), judge.surface.points
            index = screening.next(0, len(candidates))
            if index == len(candidates):
                continue
            for outcome, column in zip(screening.results(index), able(judge, candidates, index, points), strict=True):
                assert isinstance(outcome, Hit)
                arm, shoulder = judge.arm(judge.arms[column]), candidates.shoulder(index, judge.arms[column])
                found = outcome.find_evidence()
                assert isinstance(found, Reached)
                point = np.array([found.point_m])
                least_m = distances_m(shoulder, points)[reached(shoulder, arm.profile, points)].min()
                assert outcome.actions == (f"Stretch_Out_Arm({arm.profile.side})",)
                assert reached(shoulder, arm.profile, point).all()
                assert distances_m(shoulder, point) == pytest.approx(least_m, abs=1e-6)
                assert found.distance_m == pytest.approx(float(distances_m(shoulder, point)[0]))
                assert outcome.cost == round(float(least_m), 6)
                outcomes += 1
    assert outcomes


@pytest.mark.parametrize("seed", SEEDS)
def test_the_miss_is_that_of_the_shoulder_which_comes_nearest(seed: int) -> None:
    misses = 0
    for judge in judges(seed):
        for candidates in batches(judge):
            screening, points = judge.screen(candidates), judge.surface.points
            if not len(candidates) or screening.next(0, len(candidates)) < len(candidates):
                continue
            miss, gaps = screening.miss(), gaps_m(judge, candidates, points)
            assert isinstance(miss, Miss)
            lengths_m = {judge.arm(arm).profile.length_m for arm in judge.arms}
            assert len(lengths_m) == 1
            beyond_m = miss.quantity.value if miss.quantity else 0.0
            assert miss.reason is (Reason.TOO_FAR if miss.quantity else Reason.OUT_OF_SECTOR)
            assert beyond_m == pytest.approx(max(gaps.min() - lengths_m.pop(), 0.0), abs=1e-9)
            misses += 1
    assert misses


@pytest.mark.parametrize("seed", SEEDS)
def test_beyond_holds_where_no_point_comes_within_the_margin(seed: int) -> None:
    """It never says so in vain; of a single point, it says all there is to say."""
    rng, found = np.random.default_rng(seed), {True: 0, False: 0}
    for judge in judges(seed):
        lengths_m = np.array([judge.arm(arm).profile.length_m for arm in judge.arms])
        for candidates in batches(judge):
            for points in clouds(judge, candidates, rng):
                spare_m = (gaps_m(judge, candidates, points) - lengths_m).min() if len(candidates) else np.inf
                screening = ReachScreening(judge, candidates, PointCloud.of(points))
                for margin_m in (0.0, 0.05, 0.3, max(0.0, spare_m - 1e-6), max(0.0, spare_m + 1e-6)):
                    ours = bool(spare_m > margin_m)
                    assert screening.beyond(margin_m) <= ours
                    assert len(points) > 1 or screening.beyond(margin_m) == ours
                    found[ours] += 1
    assert min(found.values()) > 50


def test_nothing_is_reached_of_what_has_no_points() -> None:
    room = Room((chair(0.0), Thing("cup", (0.03, 0.05), (0.4, 0.2, 1.2), "cylinder")), (Person("P1", (0.0, 0.0)),))
    here = Viewpoint(room.stage(), "P1", ROUGH)
    judge = Reach(here, here.target("cup"))
    for candidates in batches(judge):
        screening = ReachScreening(judge, candidates, PointCloud.of(np.empty((0, 3))))
        assert screening.next(0, len(candidates)) == len(candidates)
        miss = screening.miss()
        assert miss is not None
        assert miss.text == "has no surface"


# edges of the sector ------------------------------------------------------------------------------------------


def at(shoulder: Pose, arm: Arm, distance_m: float, azimuth_rad: float, elevation_rad: float) -> Array:
    """A point, (1, 3), where an arm has it."""
    aside = -1.0 if arm.side == "right" else 1.0
    level_m = distance_m * np.cos(elevation_rad)
    x, y, z = level_m * np.cos(azimuth_rad), level_m * np.sin(azimuth_rad), distance_m * np.sin(elevation_rad)
    return shoulder.to_world([(x, aside * y, z)])


@pytest.mark.parametrize("body", BODIES)
def test_the_sector_is_closed_and_ends_there(body: str) -> None:
    """Points on its far side, and a little inside and outside of it."""
    thing = Thing("cup", (0.03, 0.05), (0.4, 0.2, 1.2), "cylinder")
    here = Viewpoint(Room((thing,), (Person("P1", (0.3, -0.2), 0.7, profile=body),)).stage(), "P1", ROUGH)
    judge = Reach(here, here.target("cup"))
    (candidates,) = here.candidates.of_level(1, judge.target.middle)
    assert judge.arms
    for column, index in enumerate(judge.arms):
        arm, shoulder = judge.arm(index).profile, candidates.shoulder(0, index)
        (right, left), (down, up) = arm.azimuth_rad, arm.elevation_rad
        ahead = (0.7 * arm.length_m, (right + left) / 2, (down + up) / 2)
        edges = [(0, arm.length_m, 1.0), (1, right, -1.0), (1, left, 1.0), (2, up, 1.0)]
        edges += [(2, down, -1.0)] if down > -np.pi / 2 else []
        for which, edge, outward in edges:
            for beside in (-1e-6, 0.0, 1e-6):
                where = [*ahead]
                where[which] = edge + outward * beside
                points = at(shoulder, arm, where[0], where[1], where[2])
                found = column in ReachScreening(judge, candidates, PointCloud.of(points)).able(0)
                assert found == (beside <= 0.0), (arm.side, which, edge, beside)


# grasps -------------------------------------------------------------------------------------------------------


def plain_grasps(shoulder: Pose, arm: Arm, centers: Array, approaches: Array, facing: float) -> list[int]:
    away, at_m = centers - shoulder.position, distances_m(shoulder, centers)
    counts = reached(shoulder, arm, centers) & ((approaches * away).sum(axis=1) >= facing * at_m - ROUNDING)
    return sorted(np.flatnonzero(counts).tolist(), key=lambda k: (round(float(at_m[k]), 6), k))


def arms(body: str, rng: Generator) -> Iterator[tuple[ArmIndices, Array, Pose]]:
    """The arms of a body that stands anywhere, with their shoulders as a row and as a pose."""
    yaw = float(rng.uniform(-3, 3))
    person = Person("P1", (float(rng.uniform(-1, 1)), float(rng.uniform(-1, 1))), yaw, profile=body)
    stage = Room((), (person,)).stage()
    for arm in stage.scene.agent("P1").arms:
        pose = stage.shoulder(arm)
        yield arm, np.concatenate((pose.position, pose.matrix.ravel())), pose


@pytest.mark.parametrize("body", BODIES)
def test_grasps_in_reach_come_nearest_first_and_not_from_behind(body: str) -> None:
    rng, counts = np.random.default_rng(3), []
    for arm, row, pose in arms(body, rng):
        for facing in (-1.0, -0.2, 0.0, 0.5, 1.0):
            centers = pose.position + rng.uniform(-1, 1, (60, 3)) * arm.profile.length_m
            centers[20:40] = centers[:20] + rng.choice((0.0, 1e-8), (20, 1))  # equally near ones keep their order
            approaches = rng.normal(size=(60, 3))
            approaches[:10] = centers[:10] - pose.position  # straight ahead
            approaches /= np.linalg.norm(approaches, axis=1)[:, None]
            found = grasps_in_reach(row, arm, centers, approaches, facing, model="sector")
            assert found.tolist() == plain_grasps(pose, arm.profile, centers, approaches, facing)
            counts.append(len(found))
    assert min(counts) < max(counts)
    assert max(counts) > 10


def test_no_grasps_none_in_reach() -> None:
    for arm, row, _ in arms("human", np.random.default_rng(4)):
        assert not len(grasps_in_reach(row, arm, np.empty((0, 3)), np.empty((0, 3)), 0.0, model="sector"))
