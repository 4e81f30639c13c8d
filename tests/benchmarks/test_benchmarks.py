"""What measures is measured too: rooms of the asked size, sums that add up, peers that look through the same window."""

import math
from itertools import pairwise

import mujoco
import numpy as np
import pytest

from benchmarks.figure import Bound, Figure, seconds_text
from benchmarks.peers.eye_view import EyeView
from benchmarks.peers.multi_ray import MultiRay
from benchmarks.peers.triangles import triangles
from benchmarks.record import by_topic, compared, recorded
from benchmarks.rooms import furnished, moved
from benchmarks.timing import in_turn, share
from taskgist.perspective import view_of
from taskgist.world import Stage, overlaps
from tools.markdown import filled
from tools.speed_page import duration, figures, measured, remarks


@pytest.mark.parametrize(("agents", "objects"), [(1, 1), (3, 12), (5, 60)])
def test_rooms_have_the_size_that_was_asked_for(agents: int, objects: int) -> None:
    scene = furnished(agents, objects, image_px=(32, 24))
    assert (len(scene.agents), len(scene.objects)) == (agents, objects)
    things = set(scene.objects)
    assert not [pair for pair in overlaps(Stage(scene), deeper_than_m=0.02) if things >= set(pair)]


def test_rooms_are_the_same_by_number_and_differ_otherwise() -> None:
    first, again, other = (furnished(2, 8, image_px=(32, 24), seed=seed) for seed in (1, 1, 2))
    assert np.array_equal(first.initial.qpos, again.initial.qpos)
    assert not np.array_equal(first.initial.qpos, other.initial.qpos)


def test_what_is_moved_is_elsewhere_and_nothing_else_is() -> None:
    scene = furnished(2, 8, image_px=(32, 24))
    name = scene.objects[3]
    changed = set(np.flatnonzero(moved(scene, name, 4).qpos != scene.initial.qpos).tolist())
    at = scene.object_slice(name)
    assert changed
    assert changed <= set(range(at.start, at.stop))


def test_percentiles_are_values_of_the_list() -> None:
    values = [float(value) for value in range(1, 101)]
    assert (share(values, 50), share(values, 95), share(values, 100)) == (50.0, 95.0, 100.0)
    assert share([3.0], 95) == 3.0


def test_contenders_take_turns() -> None:
    order: list[str] = []
    times = in_turn({name: lambda name=name: order.append(name) for name in "ab"}, repeats=2)  # type: ignore[misc]
    assert order == ["a", "b"] * 3
    assert set(times) == {"a", "b"}


@pytest.mark.parametrize(
    ("kind", "size", "volume"),
    [
        ("box", "0.1 0.2 0.3", 0.048),
        ("sphere", "0.3", 4 / 3 * math.pi * 0.027),
        ("ellipsoid", "0.1 0.2 0.3", 4 / 3 * math.pi * 0.006),
        ("cylinder", "0.2 0.3", math.pi * 0.04 * 0.6),
        ("capsule", "0.1 0.3", math.pi * (0.01 * 0.6 + 4 / 3 * 0.001)),
    ],
)
def test_triangles_enclose_the_volume_of_the_shape(kind: str, size: str, volume: float) -> None:
    text = f'<mujoco><worldbody><geom type="{kind}" size="{size}"/></worldbody></mujoco>'
    corners, faces = triangles(mujoco.MjModel.from_xml_string(text), 0)
    a, b, c = (corners[faces[:, corner]] for corner in range(3))
    enclosed = abs(float(np.sum(np.cross(a, b) * c)) / 6)
    assert enclosed == pytest.approx(volume, rel=0.01)


def test_peers_look_through_the_window_of_the_eye() -> None:
    scene = furnished(2, 8, image_px=(64, 48))
    stage = Stage(scene)
    for agent in scene.agents:
        drawn = MultiRay(EyeView.of(scene, scene.initial, agent)).image()
        assert np.mean(drawn == view_of(stage, agent).geoms) > 0.999


def test_a_figure_is_held_to_the_record_in_yardsticks() -> None:
    figure = Figure("sight", "all", 0.002)
    record = by_topic([figure.plain | {"yardsticks": 4.0}, Figure("sight", "other", 1.0).plain])
    assert record == {"sight": {"all": 4.0}}
    assert compared(figure, 4.1, record) == "1.02 × recorded"
    assert compared(figure, 5.01, record) == "SLOWER: 1.25 × recorded"
    assert compared(Figure("sight", "new", 1.0), 1.0, record) == "not recorded"


def test_the_record_holds_positive_figures() -> None:
    assert all(value > 0 for figures in recorded().values() for value in figures.values())


def test_durations_read_well() -> None:
    times = (1.234, 0.0456, 7.8e-5)
    assert (
        [seconds_text(each) for each in times] == [duration(each) for each in times] == ["1.23 s", "45.6 ms", "78 µs"]
    )


def test_the_page_shows_every_figure_with_its_peers_nearest_first() -> None:
    figure = Figure(
        "sight",
        "all",
        0.002,
        {"slow": 0.2, "quick": 0.01},
        goal="soon",
        met=False,
        counts={"rays": 7},
        bound=Bound("x", 0.001),
    )
    rows = list(figures([figure.plain]))
    assert rows[2] == "| **all** | **2 ms** | | soon: **not met** | 7 rays; bound 1 ms (x), 2 × that |"
    assert [row.split("|")[1].strip() for row in rows[3:]] == ["quick", "slow"]
    assert list(remarks(figure.plain | {"counts": {}, "bound": None, "note": "well"})) == ["well"]
    assert all(len(one.split("|")) == len(other.split("|")) for one, other in pairwise(rows))


NAMES = ("one", "machine", "two", "profile of maps")


def test_each_topic_comes_to_its_own_place() -> None:
    document = {
        "machine": {
            "processor": "P",
            "cores": 2,
            "system": "S",
            "python": "3",
            "packages": {"numpy": "2"},
            "load": None,
        },
        "figures": [Figure(topic, f"{topic} time", 1.0).plain for topic in ("one", "two")],
        "profile": {"maps": [{"function": "f", "calls": "3", "own": 0.5, "with_calls": 1.0}]},
        "growth": [],
    }
    empty = "".join(f"# {name}\n<!-- {name} -->\n<!-- end -->\nafter {name}\n" for name in NAMES)
    page = filled(empty, measured(document))
    first, machine, second, profiled = (page.partition(f"# {name}")[2] for name in NAMES)
    assert (
        first.index("one time") < first.index("after one") < first.index("P, one of 2 cores") < first.index("two time")
    )
    assert "one time" not in machine
    assert "| `f` | 3 | 50.0% | 100.0% |" not in second.partition("after two")[0]
    assert profiled.index("| `f` | 3 | 50.0% | 100.0% |") < profiled.index("after profile of maps")
    assert filled(page, measured(document)) == page
