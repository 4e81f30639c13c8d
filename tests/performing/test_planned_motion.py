"""Ways that are found, timed and audited: three rooms that know nothing of each other agree."""

import itertools

import numpy as np
import pytest

from taskgist.common.arrays import Array
from taskgist.performing.audit import audit
from taskgist.performing.findings import MotionLimits
from taskgist.planning.paths import joint_path
from taskgist.planning.timing import timed
from taskgist.world import Scene, Stage, State
from tests.performing.motions import RATE_HZ, scene

CLEARANCE_M = 0.003
JOINTS = tuple(f"arm_{number}" for number in range(1, 8))
SPEED, ACCELERATION = 1.0, 2.0
LIMITS = {"J": MotionLimits(dict.fromkeys(JOINTS, SPEED), dict.fromkeys(JOINTS, ACCELERATION))}


class Arm:
    """Jido's arm over a table with poles on it, and a plain test of collisions."""

    def __init__(self, room: Scene) -> None:
        self.room, self._stage = room, Stage(room)
        agent = room.agent("J")
        self.arm = agent.arms[0]
        self._mine = np.intersect1d(self.arm.geoms, room.solid_geoms)
        self._others = np.setdiff1d(room.solid_geoms, self._mine)
        self._touching = {pair[:2] for pair in self._stage.overlaps(self._mine, self._others)}
        self.indices = [agent.joints[name] for name in JOINTS]
        self.ranges = np.array([room.model.joint(f"J/{name}").range for name in JOINTS])

    def state(self, angles: Array) -> State:
        return self.room.initial.replace(dict(zip(self.indices, angles, strict=True)))

    def is_free(self, angles: Array) -> bool:
        stage = self._stage.show(self.state(angles))
        near = stage.near_pairs(self._mine, self._others, limit_m=CLEARANCE_M)
        return all(
            pair in self._touching or stage.distance(*pair, limit_m=CLEARANCE_M) >= CLEARANCE_M - 1e-9 for pair in near
        )

    def over_the_table(self, random: np.random.Generator) -> Array:
        """A free configuration with the palm low over the table."""
        while True:
            angles = random.uniform(*self.ranges.T)
            x, y, z = self._stage.show(self.state(angles)).site(self.arm.palm_site).position
            if 0.5 < x < 1.0 and abs(y) < 0.7 and 0.75 < z < 1.05 and self.is_free(angles):
                return np.asarray(angles)


@pytest.fixture(scope="module")
def arm() -> Arm:
    random = np.random.default_rng(1)
    poles = "".join(
        f'<body name="pole{k}" pos="{random.uniform(0.5, 1.0)} {random.uniform(-0.7, 0.7)} 0.85">'
        '<geom type="box" size="0.03 0.03 0.15"/></body>'
        for k in range(6)
    )
    table = '<body name="table" pos="0.95 0 0.35"><geom type="box" size="0.3 0.8 0.35"/></body>'
    return Arm(scene(table, poles))


def audited(arm: Arm, angles: Array) -> set[tuple[str, str | None]]:
    rows = np.array([arm.state(row).qpos for row in angles])
    found = audit(arm.room, np.arange(len(rows)) / RATE_HZ, rows, [()] * len(rows), LIMITS)
    return {(each.kind, each.other) for each in found.findings}


def test_a_way_that_is_found_and_timed_is_clean_and_the_straight_line_is_not(arm: Arm) -> None:
    random = np.random.default_rng(0)
    places = [arm.over_the_table(random) for _ in range(7)]
    around = 0
    for seed, (start, goal) in enumerate(itertools.pairwise(places)):
        way = joint_path(start, [goal], arm.ranges, arm.is_free, step=0.02, seed=seed, checks=30_000)
        assert way is not None
        assert audited(arm, timed(way, [SPEED] * 7, [ACCELERATION] * 7, rate_hz=RATE_HZ)[1]) == set()
        line = start + (goal - start) * np.linspace(0.0, 1.0, 200)[:, None]
        if not all(arm.is_free(point) for point in line):
            around += 1
            met = audited(arm, timed(line, [SPEED] * 7, [ACCELERATION] * 7, rate_hz=RATE_HZ)[1])
            assert {kind for kind, _ in met} == {"penetration"}
    assert around >= 2, "some lines are blocked"
