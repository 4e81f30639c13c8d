import itertools
import subprocess
import sys

import numpy as np
import pytest

from taskgist.common import extras
from taskgist.common.arrays import Array
from taskgist.errors import InputError
from taskgist.planning.timing import timed

RATE_HZ = 30.0


def dense(corners: Array, step: float) -> Array:
    """Way points along straight lines between corners."""
    parts = [corners[:1]]
    for start, end in itertools.pairwise(corners):
        count = max(1, int(np.ceil(np.abs(end - start).max() / step)))
        parts.append(start + (end - start) * np.arange(1, count + 1)[:, None] / count)
    return np.concatenate(parts)


def random_way(seed: int, step: float = 0.03, joints: int = 7) -> Array:
    random = np.random.default_rng(seed)
    return dense(random.uniform(-1.5, 1.5, size=(random.integers(2, 7), joints)), step)


def rates(positions: Array, rate_hz: float) -> tuple[Array, Array]:
    """Speeds and accelerations by differences, with rest before and after."""
    resting = np.concatenate((positions[:1], positions, positions[-1:]))
    speeds = np.diff(resting, axis=0) * rate_hz
    return speeds, np.diff(speeds, axis=0) * rate_hz


def places_on(way: Array, position: Array) -> tuple[Array, Array]:
    """Distance of a position to every line between way points (largest of all joints), and where on the way that is."""
    steps = np.diff(way, axis=0)
    shares = np.clip(((position - way[:-1]) * steps).sum(axis=1) / (steps**2).sum(axis=1), 0.0, 1.0)
    gaps = np.abs(way[:-1] + shares[:, None] * steps - position).max(axis=1)
    return gaps, np.arange(len(steps)) + shares


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("rate_hz", [30.0, 200.0])
def test_limits_hold_and_one_of_them_is_reached(seed: int, rate_hz: float) -> None:
    random = np.random.default_rng(seed)
    velocity, acceleration = random.uniform(0.5, 2.0, 7), random.uniform(1.0, 6.0, 7)
    times_s, positions = timed(random_way(seed), velocity, acceleration, rate_hz=rate_hz)
    speeds, changes = rates(positions, rate_hz)
    assert np.diff(times_s) == pytest.approx(1 / rate_hz)
    assert (np.abs(speeds) <= velocity * (1 + 1e-6)).all()
    assert (np.abs(changes) <= acceleration * (1 + 1e-6)).all()
    assert max((np.abs(speeds) / velocity).max(), (np.abs(changes) / acceleration).max()) > 0.9


@pytest.mark.parametrize("seed", range(6))
def test_it_begins_and_ends_at_rest_where_the_way_does(seed: int) -> None:
    way = random_way(seed)
    _, positions = timed(way, np.full(7, 1.0), np.full(7, 2.0), rate_hz=1000.0)
    assert positions[[0, -1]] == pytest.approx(way[[0, -1]])
    speeds, _ = rates(positions, 1000.0)
    assert np.abs(speeds[[1, -2]]).max() < 0.005


@pytest.mark.parametrize("seed", range(6))
def test_it_stays_on_the_way_and_passes_it_in_order(seed: int) -> None:
    step = 0.04
    way = random_way(seed, step)
    _, positions = timed(way, np.full(7, 1.5), np.full(7, 3.0), rate_hz=RATE_HZ)
    place = 0.0
    for position in positions:
        gaps, places = places_on(way, position)
        ahead = (gaps <= step / 3 + 1e-9) & (places >= place - 1e-6)
        assert ahead.any()
        place = float(places[ahead].min())
    fine = timed(way, np.full(7, 1.5), np.full(7, 3.0), rate_hz=500.0)[1]
    for point in way:
        assert np.abs(fine - point).max(axis=1).min() < step / 3 + 1.5 / 500


def test_a_straight_way_takes_as_long_as_it_must() -> None:
    times_s, positions = timed(dense(np.array([[0.0], [2.0]]), 0.02), [1.0], [2.0], rate_hz=100.0)
    assert times_s[-1] == pytest.approx(2.0 / 1.0 + 1.0 / 2.0, rel=0.02)
    assert (np.diff(positions[:, 0]) > 0).all()


def test_it_stops_where_it_turns_back() -> None:
    way = dense(np.array([[0.0, 0.0], [0.5, 0.2], [0.0, 0.0]]), 0.02)
    _, positions = timed(way, [1.0, 1.0], [2.0, 2.0], rate_hz=RATE_HZ)
    assert positions.max(axis=0) == pytest.approx((0.5, 0.2))
    _, changes = rates(positions, RATE_HZ)
    assert np.abs(changes).max() < 2.0 + 1e-6


def odd_way(random: np.random.Generator) -> Array:
    """Steps of all sizes, coarse corners, corners on a lattice, one joint to and fro, or one joint after the other."""
    count, joints = int(random.integers(2, 60)), int(random.integers(1, 9))
    kinds = (
        lambda: np.cumsum(random.normal(size=(count, joints)) * 10 ** random.uniform(-6, -1, size=(count, 1)), axis=0),
        lambda: random.uniform(-2.0, 2.0, size=(count, joints)),
        lambda: np.round(random.uniform(-1.0, 1.0, size=(count, joints)), 1),
        lambda: np.eye(joints)[0] * np.cumsum(random.uniform(-0.01, 0.05, size=(count, 1)), axis=0),
        lambda: np.cumsum(np.eye(joints)[random.integers(0, joints, count)] * 0.02, axis=0),
    )
    return np.asarray(kinds[random.integers(len(kinds))]())


def test_odd_ways_keep_the_limits() -> None:
    random = np.random.default_rng(0)
    for _ in range(100):
        way = odd_way(random)
        velocity, acceleration = 10 ** random.uniform(-1, 1, way.shape[1]), 10 ** random.uniform(-1, 1.5, way.shape[1])
        _, positions = timed(way, velocity, acceleration, rate_hz=50.0)
        speeds, changes = rates(positions, 50.0)
        assert (np.abs(speeds) <= velocity * (1 + 1e-6)).all()
        assert (np.abs(changes) <= acceleration * (1 + 1e-6)).all()
        assert positions[[0, -1]] == pytest.approx(way[[0, -1]])


@pytest.mark.parametrize("tiny", [1e-7, 1.4e-5, 1e-3])
def test_tiny_steps_among_long_ones_are_no_trouble(tiny: float) -> None:
    """As shortcuts leave them: at the start, and amid the way, where it turns a little."""
    random = np.random.default_rng(5)
    for _ in range(5):
        corners = np.cumsum(random.uniform(-0.5, 0.5, size=(5, 7)), axis=0)
        near = corners[[0, 2]] + tiny * random.uniform(-1.0, 1.0, size=(2, 7))
        way = dense(np.array([corners[0], near[0], corners[1], corners[2], near[1], *corners[3:]]), 0.03)
        times_s, positions = timed(way, np.full(7, 1.0), np.full(7, 2.0), rate_hz=RATE_HZ)
        speeds, changes = rates(positions, RATE_HZ)
        assert np.abs(speeds).max() < 1.0 + 1e-6
        assert np.abs(changes).max() < 2.0 + 1e-6
        assert positions[-1] == pytest.approx(corners[-1])
        plain = timed(dense(corners, 0.03), np.full(7, 1.0), np.full(7, 2.0), rate_hz=RATE_HZ)[0]
        assert times_s[-1] < 1.4 * plain[-1]


def test_fine_steps_are_as_fast_as_coarse_ones() -> None:
    ends = np.array([[0.0, 0.0], [1.0, 0.5]])
    durations = [
        timed(dense(ends, step), [1.0, 1.0], [2.0, 2.0], rate_hz=100.0)[0][-1] for step in (0.0005, 0.005, 0.05)
    ]
    assert durations == pytest.approx([1.5] * 3, abs=0.03)


def test_who_stays_takes_no_time() -> None:
    for way in ([[0.3, 0.4]], [[0.3, 0.4], [0.3, 0.4]]):
        times_s, positions = timed(way, [1.0, 1.0], [1.0, 1.0], rate_hz=RATE_HZ)
        assert (times_s.tolist(), positions.tolist()) == ([0.0], [[0.3, 0.4]])


def test_the_same_way_has_the_same_timing() -> None:
    one, other = (timed(random_way(2), np.full(7, 1.0), np.full(7, 2.0), rate_hz=RATE_HZ)[1] for _ in range(2))
    assert np.array_equal(one, other)


def test_toppra_says_nothing() -> None:
    program = (
        "from taskgist.planning.timing import timed\n"
        "import logging\n"
        "assert timed([[0.0], [0.1], [0.2]], [1.0], [1.0], rate_hz=30)[0][-1] > 0\n"
        "assert not logging.getLogger().handlers\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("", "")


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(InputError, match="velocity: a limit is a number above zero for each joint"):
        timed([[0.0], [1.0]], [0.0], [1.0], rate_hz=RATE_HZ)
    with pytest.raises(InputError, match="acceleration: a limit is a number above zero for each joint"):
        timed([[0.0], [1.0]], [1.0], [1.0, 2.0], rate_hz=RATE_HZ)
    with pytest.raises(InputError, match="way: a way has finite way points"):
        timed([0.0, 1.0], [1.0], [1.0], rate_hz=RATE_HZ)
    with pytest.raises(InputError, match="rate_hz: a rate is above zero"):
        timed([[0.0], [1.0]], [1.0], [1.0], rate_hz=0.0)


def test_without_toppra_it_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> object:
        raise ModuleNotFoundError(name=name)

    monkeypatch.setattr(extras, "importlib", type("none", (), {"import_module": staticmethod(missing)}))
    with pytest.raises(InputError, match=r"toppra is not installed; install it: pip install 'taskgist\[planning\]'"):
        timed([[0.0], [1.0]], [1.0], [1.0], rate_hz=RATE_HZ)
