"""Who walks turns its chest to what it wants, whoever asks in between."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from taskgist.perspective import Viewpoint
from taskgist.perspective.candidates import OVERHEAD_M, Candidates, Walk, turns_towards
from taskgist.world import Stage
from tests.perspective.random_rooms import random_case
from tools.rooms import COARSE, Person, Room

Array = NDArray[np.float64]
SEEDS = range(1000, 1006)
TARGETS = ((0.9, -0.4, 0.8), (-2.0, 0.3, 1.5), (0.9, 0.4, 0.1))

metres = st.floats(-4.0, 4.0)
points = st.tuples(metres, metres)


def turn_towards(target: tuple[float, float], base: tuple[float, float], facing_rad: float, height_m: float) -> float:
    """At the place where the agent is."""
    there, here = np.array((*target, height_m)), np.array((*base, 0.9))
    return float(turns_towards(there, here, facing_rad, np.zeros((1, 2)))[0])


# turning ------------------------------------------------------------------------------------------------------


@given(
    target=points,
    base=points,
    facing_rad=st.floats(-10.0, 10.0),
    offsets=st.lists(points, min_size=1, max_size=4),
    height_m=metres,
)
@example(target=(-1.0, 0.0), base=(0.0, 0.0), facing_rad=0.0, offsets=[(0.0, 0.0)], height_m=1.0)
@example(target=(-1.0, -0.0), base=(0.0, 0.0), facing_rad=0.0, offsets=[(0.0, 0.0)], height_m=1.0)
@example(target=(1.0, 0.0), base=(0.0, 0.0), facing_rad=3 * math.pi, offsets=[(0.0, 0.0)], height_m=1.0)
def test_after_the_turn_the_chest_faces_the_target(
    target: tuple[float, float],
    base: tuple[float, float],
    facing_rad: float,
    offsets: list[tuple[float, float]],
    height_m: float,
) -> None:
    there, offsets_m = np.array((*target, height_m)), np.array(offsets)
    turns = turns_towards(there, np.array((*base, 0.9)), facing_rad, offsets_m)
    assert turns.shape == (len(offsets),)
    assert (np.abs(turns) <= math.pi + 1e-12).all()
    ways = there[:2] - np.array(base) - offsets_m
    away_m = np.hypot(*ways.T)
    chest = np.column_stack((np.cos(facing_rad + turns), np.sin(facing_rad + turns)))
    far = away_m > OVERHEAD_M
    np.testing.assert_allclose(chest[far], ways[far] / away_m[far, None], atol=1e-9)
    assert not turns[~far].any()


@pytest.mark.parametrize("behind_m", [0.0, 1e-15, 1e-9, -1e-15, -1e-9])
@pytest.mark.parametrize("facing_rad", [0.0, math.pi, -math.pi, 2 * math.pi])
def test_what_is_right_behind_takes_half_a_turn_to_either_side(behind_m: float, facing_rad: float) -> None:
    x = -math.cos(facing_rad)
    turn = turn_towards((x, behind_m), (0.0, 0.0), facing_rad, 1.0)
    assert abs(turn) == pytest.approx(math.pi, abs=2e-9)
    assert abs(turn) <= math.pi + 1e-12


@pytest.mark.parametrize("share", [0.0, 0.5, 0.999, 1.001, 2.0])
@pytest.mark.parametrize("angle_rad", [0.3, 2.0, -2.9])
def test_nobody_turns_to_what_is_overhead(share: float, angle_rad: float) -> None:
    away_m = share * OVERHEAD_M
    turn = turn_towards((away_m * math.cos(angle_rad), away_m * math.sin(angle_rad)), (0.0, 0.0), 0.0, 2.0)
    assert turn == pytest.approx(angle_rad if share > 1 else 0.0)


# walking ------------------------------------------------------------------------------------------------------


def chest_off_rad(stage: Stage, here: Viewpoint, target: Array) -> float:
    """Angle about the vertical between where the chest faces and where a target is from the base."""
    base = stage.body_position(here.agent.root_body)
    forward = stage.shoulder(here.agent.arms[0]).matrix[:, 0]
    x, y = target[:2] - base[:2]
    return math.remainder(math.atan2(y, x) - math.atan2(forward[1], forward[0]), 2 * math.pi)


@pytest.mark.parametrize("yaw", [0.0, math.pi, -2.0])
@pytest.mark.parametrize("profile", ["human", "jido"])
def test_who_walks_faces_what_it_wants(yaw: float, profile: str) -> None:
    joints = (("torso_turn", 20.0), ("torso_lean", 10.0)) if profile == "human" else ()
    here = Viewpoint(
        Room((), (Person("P1", (0.1, 0.2), yaw, "standing", joints, profile=profile),)).stage(), "P1", COARSE
    )
    rng, count = np.random.default_rng(1), 0
    for target in (np.array((0.1 - math.cos(yaw), 0.2 - math.sin(yaw), 1.0)), *map(np.array, TARGETS)):
        for candidates in here.candidates.of_level(4, target):
            for index in rng.choice(len(candidates), min(6, len(candidates)), replace=False).tolist():
                candidate = candidates[index]
                if "Bend_Hips" in candidate.actions:
                    continue  # what the torso was turned by is pitched with the pelvis
                shown = here.stage.show(candidate.state)
                if math.dist(shown.body_position(here.agent.root_body)[:2], target[:2]) <= OVERHEAD_M:
                    assert candidate.amount.turned_rad == 0.0
                    continue
                assert chest_off_rad(shown, here, target) == pytest.approx(0.0, abs=1e-9)
                count += 1
    assert count > 20


def walks(seed: int) -> Iterator[tuple[Walk, Walk]]:
    """Of everybody in a room who can walk, twice: for asking in between, and one after the other."""
    case = random_case(seed)
    for agent in case.scene.agents:
        one, other = (Viewpoint(case.stage(), agent, COARSE).candidates.walk for _ in range(2))
        if one is not None and other is not None:
            yield one, other


def assert_same(ours: Candidates, theirs: Candidates) -> None:
    np.testing.assert_array_equal(ours.ends, theirs.ends)
    assert ours.table.joints == theirs.table.joints
    for name in ("rows", "base", "offsets_m", "turns", "spot", "bend"):
        np.testing.assert_array_equal(getattr(ours.table, name), getattr(theirs.table, name))


def test_two_targets_asked_in_turn_are_answered_as_one_after_the_other() -> None:
    """Whoever asks, and however often: several ask for the same target, some begin when others are half-way."""
    batches, walkers = 0, 0
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        for walk, plain in walks(seed):
            targets = [np.array(target) for target in TARGETS]
            expected = [list(plain.candidates(target)) for target in targets]
            asked = [0, 1, 0, 2, 1, 0]
            ways, found = [walk.candidates(targets[of]) for of in asked], [list[Candidates]() for _ in asked]
            open_ones = set(range(len(asked)))
            while open_ones:
                who = int(rng.choice(sorted(open_ones)))
                batch = next(ways[who], None)
                if batch is None:
                    open_ones.remove(who)
                else:
                    found[who].append(batch)
            for of, got in zip(asked, found, strict=True):
                assert len(got) == len(expected[of])
                for ours, theirs in zip(got, expected[of], strict=True):
                    assert_same(ours, theirs)
                batches = max(batches, len(got))
            walkers += 1
    assert batches > 1
    assert walkers > 3


def test_the_turns_differ_between_targets() -> None:
    walk = Viewpoint(Room((), (Person("P1", (0.0, 0.0)),)).stage(), "P1", COARSE).candidates.walk
    assert walk is not None
    one, other = (next(walk.candidates(np.array(target))) for target in TARGETS[:2])
    assert not np.array_equal(one.table.turns, other.table.turns)


def test_asking_again_for_the_same_target_makes_nothing_new() -> None:
    walk = Viewpoint(Room((), (Person("P1", (0.0, 0.0)),)).stage(), "P1", COARSE).candidates.walk
    assert walk is not None
    first, again = (list(walk.candidates(np.array(TARGETS[0]))) for _ in range(2))
    assert [id(each) for each in first] == [id(each) for each in again]
