import itertools
import math
import subprocess
import sys

import numpy as np
import pytest

from taskgist.common import extras
from taskgist.common.arrays import Array
from taskgist.errors import InputError
from taskgist.planning.paths import Free, base_path, joint_path

RANGES = [(-3.0, 3.0)] * 3
STEP = 0.05
START, GOAL = (-2.0, 0.0, 0.0), (2.0, 0.5, -1.0)


def nowhere(_: Array) -> bool:
    return True


def around_a_wall(q: Array) -> bool:
    """A wall across the first joint, open where the second one is high."""
    return not (abs(q[0]) < 0.2 and q[1] < 2.5)


def through_a_slit(q: Array) -> bool:
    """A thick wall with one slit of three steps."""
    return not (abs(q[0]) < 0.5 and abs(q[1] - 1.0) > 0.075)


def shut(q: Array) -> bool:
    return abs(float(q[0])) >= 0.2


def is_a_way(way: Array, start: object, end: object, step: object, free: Free) -> None:
    assert way[0] == pytest.approx(np.asarray(start))
    assert way[-1] == pytest.approx(np.asarray(end))
    assert (np.abs(np.diff(way, axis=0)) <= np.asarray(step) + 1e-9).all()
    assert all(free(point) for point in way)


def test_a_free_straight_line_is_the_way() -> None:
    way = joint_path(START, [GOAL], RANGES, nowhere, step=STEP, seed=0)
    assert way is not None
    is_a_way(way, START, GOAL, STEP, nowhere)
    assert np.linalg.norm(np.diff(way, axis=0), axis=1).sum() == pytest.approx(math.dist(START, GOAL))
    assert len(way) == 81


@pytest.mark.parametrize("free", [around_a_wall, through_a_slit])
@pytest.mark.parametrize("seed", range(4))
def test_a_blocked_line_is_gone_around(free: Free, seed: int) -> None:
    way = joint_path(START, [GOAL], RANGES, free, step=STEP, seed=seed, checks=100_000)
    assert way is not None
    is_a_way(way, START, GOAL, STEP, free)


def test_nothing_is_between_two_way_points_that_a_check_would_have_met() -> None:
    """Walked a hundred times as finely, the way stays free of a wall that is a little thinner."""
    way = joint_path(START, [GOAL], RANGES, around_a_wall, step=STEP, seed=1)
    assert way is not None
    fine = [a + (b - a) * share for a, b in itertools.pairwise(way) for share in np.linspace(0, 1, 100)]
    assert not any(abs(q[0]) < 0.2 - STEP and q[1] < 2.5 - STEP for q in fine)


@pytest.mark.parametrize("checks", [0, 1, 50, 3000])
def test_where_there_is_no_way_it_says_so_within_its_checks(checks: int) -> None:
    asked = 0

    def counted(q: Array) -> bool:
        nonlocal asked
        asked += 1
        return shut(q)

    assert joint_path(START, [GOAL], RANGES, counted, step=STEP, seed=0, checks=checks) is None
    assert asked == checks


def test_the_nearest_goal_that_can_be_reached_is_the_end() -> None:
    near, blocked, outside = (-1.0, 0.0, 0.0), (0.0, 0.0, 0.0), (-2.0, 0.0, 4.0)
    for goals in ([GOAL, blocked, near, outside], [outside, near, GOAL]):
        way = joint_path(START, goals, RANGES, around_a_wall, step=STEP, seed=0)
        assert way is not None
        is_a_way(way, START, near, STEP, around_a_wall)
    assert joint_path(START, [blocked, outside], RANGES, around_a_wall, step=STEP, seed=0) is None


def test_only_one_of_two_goals_can_be_reached() -> None:
    closed_in = (1.0, 0.0, 2.0)

    def free(q: Array) -> bool:
        return around_a_wall(q) and bool(math.dist(q, closed_in) > 0.5 or math.dist(q, closed_in) < 0.1)

    way = joint_path(START, [closed_in, GOAL], RANGES, free, step=STEP, seed=0)
    assert way is not None
    is_a_way(way, START, GOAL, STEP, free)


def test_who_starts_in_something_has_no_way() -> None:
    assert joint_path((0.0, 0.0, 0.0), [GOAL], RANGES, shut, step=STEP, seed=0) is None


def test_the_same_question_has_the_same_answer() -> None:
    def asked(seed: int) -> Array:
        way = joint_path(START, [GOAL], RANGES, around_a_wall, step=STEP, seed=seed)
        assert way is not None
        return way

    first, other = asked(3), asked(4)
    assert not np.array_equal(first, other)
    assert np.array_equal(asked(3), first)


PROGRAM = """
from tests.planning.test_paths import *
way = joint_path(START, [GOAL], RANGES, around_a_wall, step=STEP, seed=3)
print(way.tobytes().hex())
"""


def test_another_process_gives_the_same_answer_and_says_nothing_else() -> None:
    way = joint_path(START, [GOAL], RANGES, around_a_wall, step=STEP, seed=3)
    assert way is not None
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    assert (done.stdout.strip(), done.stderr) == (way.tobytes().hex(), "")


def test_shortcuts_make_ways_short() -> None:
    """Each is at most half as long again as the shortest around the wall's upper edge."""
    shortest = math.dist((-2, 0), (-0.2, 2.5)) + 0.4 + math.dist((0.2, 2.5), (2, 0.5))
    for seed in range(4):
        way = joint_path(START, [GOAL], RANGES, around_a_wall, step=STEP, seed=seed)
        assert way is not None
        assert np.linalg.norm(np.diff(way, axis=0), axis=1).sum() < 1.5 * shortest


def test_joints_without_limits_go_the_short_way_round() -> None:
    endless = [(-math.inf, math.inf)]
    way = joint_path([3.0], [[-3.0]], endless, nowhere, step=STEP, seed=0)
    assert way is not None
    is_a_way(way, [3.0], [2 * math.pi - 3.0], STEP, nowhere)
    way = joint_path([3.0], [[-3.0 - 20 * math.pi]], endless, nowhere, step=STEP, seed=0)
    assert way is not None
    assert way[-1] == pytest.approx([2 * math.pi - 3.0])


def test_joints_without_limits_go_the_other_way_round_where_one_is_blocked() -> None:
    def free(q: Array) -> bool:
        return abs(float(q[0]) - math.pi) > 0.05

    way = joint_path([3.0], [[-3.0]], [(-math.inf, math.inf)], free, step=STEP, seed=0)
    assert way is not None
    is_a_way(way, [3.0], [-3.0], STEP, free)


def test_a_start_a_little_outside_its_limits_comes_back_in() -> None:
    way = joint_path((-3.01, 0.0, 0.0), [GOAL], RANGES, around_a_wall, step=STEP, seed=0)
    assert way is not None
    is_a_way(way, (-3.01, 0.0, 0.0), GOAL, STEP, around_a_wall)


def test_a_joint_that_cannot_move_stays() -> None:
    ranges = [(-3.0, 3.0), (-3.0, 3.0), (0.0, 0.0)]
    way = joint_path((-2, 0, 0), [(2, 0, 0)], ranges, around_a_wall, step=STEP, seed=0)
    assert way is not None
    assert np.abs(way[:, 2]).max() < 1e-6


# --- A base.

PLACES = [(-3.0, 3.0), (-3.0, 3.0), (-math.inf, math.inf)]


def long_base(place: Array) -> bool:
    """A thin base 1.6 m long that must turn to pass a door 0.8 m wide in a wall across x = 0."""
    x, y, yaw = place
    ends = [(x + s * math.cos(yaw), y + s * math.sin(yaw)) for s in np.linspace(-0.8, 0.8, 17)]
    return not any(abs(ex) < 0.1 and abs(ey) > 0.4 for ex, ey in ends)


def test_a_base_turns_to_pass_a_door() -> None:
    start, goal = (-1.5, 0.0, math.pi / 2), (1.5, 0.0, -math.pi / 2)
    way = base_path(start, goal, PLACES, long_base, step_m=0.04, step_rad=0.06, seed=0)
    assert way is not None
    assert abs(abs(way[-1, 2] - way[0, 2]) - math.pi) < 1e-6
    is_a_way(way, start, way[-1], (0.04, 0.04, 0.06), long_base)
    assert np.abs(np.sin(way[np.abs(way[:, 0]).argmin(), 2])) < 0.55


def test_a_base_finds_none_where_the_door_is_shut() -> None:
    def free(place: Array) -> bool:
        return abs(float(place[0])) > 0.5

    goal = (1.5, 0.0, 0.0)
    assert base_path((-1.5, 0, 0), goal, PLACES, free, step_m=0.05, step_rad=0.1, seed=0, checks=2000) is None


# --- Bad input, and interruptions.


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(InputError, match=r"give \(k,\), \(g, k\) and \(k, 2\)"):
        joint_path(START, GOAL, RANGES, nowhere, step=STEP, seed=0)
    with pytest.raises(InputError, match="step: a step is more than nothing"):
        joint_path(START, [GOAL], RANGES, nowhere, step=0.0, seed=0)
    with pytest.raises(InputError, match="ranges: start and goals are finite"):
        joint_path(START, [(math.nan, 0, 0)], RANGES, nowhere, step=STEP, seed=0)
    with pytest.raises(InputError, match="ranges: a base is searched for within bounds"):
        base_path(START, GOAL, [(-math.inf, 1)] * 3, nowhere, step_m=0.1, step_rad=0.1, seed=0)


def test_an_interruption_comes_through() -> None:
    asked = 0

    def interrupted(q: Array) -> bool:
        nonlocal asked
        asked += 1
        if asked == 300:
            raise KeyboardInterrupt
        return shut(q)

    with pytest.raises(KeyboardInterrupt):
        joint_path(START, [GOAL], RANGES, interrupted, step=STEP, seed=0)
    way = joint_path(START, [GOAL], RANGES, around_a_wall, step=STEP, seed=3)
    assert way is not None


def test_without_ompl_it_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> object:
        raise ModuleNotFoundError(name=name)

    monkeypatch.setattr(extras, "importlib", type("none", (), {"import_module": staticmethod(missing)}))
    assert joint_path(START, [GOAL], RANGES, nowhere, step=STEP, seed=0) is not None  # a straight line needs none
    with pytest.raises(
        InputError, match=r"ompl\.base is not installed; install it: pip install 'taskgist\[planning\]'"
    ):
        joint_path(START, [GOAL], RANGES, around_a_wall, step=STEP, seed=0)
