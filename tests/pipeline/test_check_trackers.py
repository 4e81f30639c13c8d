"""What trackers bring that cannot be: each fault is found, told with figures and the way out, and nothing else is."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from taskgist.observe import Observer
from taskgist.pipeline import Finding
from taskgist.pipeline.check_trackers import disagreeing_frames, frozen_poses, lost_orientations, off_the_floor
from taskgist.recording import Provenance, Recording
from taskgist.settings import DEFAULT
from taskgist.world.geometry.transforms import about_z, matrix_from_wxyz
from tests.pipeline.small import FRAMES, room, small, still
from tests.shipped import excerpt, label

Array = NDArray[np.float64]
REAL = Provenance()


def handover() -> Recording:
    """A simulated one: P1 gives a cup to P2."""
    return excerpt("give_a", label("give_a").start_s - 0.1, label("give_a").end_s + 0.3, every=2)


def moved(recording: Recording, move: Callable[[Array], Array]) -> Recording:
    """The same with its cup in another frame: places, (N, 3), go where ``move`` brings them."""
    qpos, free = np.array(recording.qpos), recording.scene.object_slice("cup")
    qpos[:, free.start : free.start + 3] = move(qpos[:, free.start : free.start + 3])
    return replace(recording, qpos=qpos, label=None)


def of_frames(recording: Recording) -> list[Finding]:
    return list(disagreeing_frames(recording, Observer(recording.scene, recording)))


def told_transform(finding: Finding) -> tuple[Array, float]:
    """The shift in metres and the turn in radians that a remedy names."""
    found = re.search(r"position_m = \[([^\]]*)\](?:, yaw_deg = ([-\d.]+))?", finding.remedy)
    assert found, finding.remedy
    return np.array([float(text) for text in found[1].split(",")]), math.radians(float(found[2] or 0.0))


def test_trackers_that_agree() -> None:
    assert of_frames(handover()) == []


@pytest.mark.parametrize("shift_m", [(0.0, 0.0, 0.3), (0.25, -0.2, 0.1), (0.0, 0.8, 0.0)])
def test_hands_away_from_a_thing_that_moves_with_them(shift_m: tuple[float, float, float]) -> None:
    """By how much is told, and what is told mends it."""
    shifted = moved(handover(), lambda places: places + shift_m)
    findings = of_frames(shifted)
    assert findings
    assert {finding.severity for finding in findings} == {"unfit"}
    assert {finding.about for finding in findings} == {"cup"}
    gap_cm = max(int(re.search(r"(\d+) cm away", finding.problem)[1]) for finding in findings)  # type: ignore[index]
    assert gap_cm == pytest.approx(100 * np.linalg.norm(shift_m), abs=15.0), "up to its own size and that of a hand"
    told_m, yaw_rad = told_transform(findings[0])
    assert yaw_rad == 0.0
    assert told_m == pytest.approx(-np.array(shift_m), abs=0.1)
    assert of_frames(moved(shifted, lambda places: places + told_m)) == []


def test_frames_turned_against_each_other() -> None:
    turn = matrix_from_wxyz(about_z(math.radians(40.0)))
    turned = moved(handover(), lambda places: places @ turn.T)
    findings = of_frames(turned)
    assert findings
    told_m, yaw_rad = told_transform(findings[0])
    back = matrix_from_wxyz(about_z(yaw_rad))
    assert of_frames(moved(turned, lambda places: places @ back.T + told_m)) == []


def test_one_person_in_another_frame() -> None:
    """The hand that is away is shifted then, and not the thing that the other hand holds well."""
    recording = excerpt("handover_3", 1.0, 5.0)
    assert of_frames(recording) == []
    qpos = np.array(recording.qpos)
    qpos[:, recording.scene.base_slice("P2").start + 1] += 0.2
    findings = of_frames(replace(recording, qpos=qpos))
    assert findings
    assert all("P2's" in finding.problem for finding in findings)
    assert all("give P2's source transform = { position_m = [" in finding.remedy for finding in findings)
    assert told_transform(findings[0])[0] == pytest.approx([0.0, -0.2, 0.0], abs=0.1)


def frozen(name: str, first: int, last: int, **fields: Any) -> Recording:
    """Somebody sways, and something is carried along in the air, but for frames in which a pose is repeated."""
    world = room()
    qpos = still(world)
    sway = 0.02 * np.sin(np.arange(FRAMES))
    for agent in world.agents:
        qpos[:, world.base_slice(agent).start] += sway
    cup = world.object_slice("cup").start
    qpos[:, cup + 2] += 0.3
    qpos[:, cup] += 0.02 * np.arange(FRAMES)
    columns = world.object_slice(name) if name in world.objects else world.base_slice(name)
    qpos[first : last + 1, columns] = qpos[first, columns]
    return small(world, qpos=qpos, **{"provenance": REAL, **fields})


def of_freezing(recording: Recording) -> list[Finding]:
    return list(frozen_poses(recording, Observer(recording.scene, recording), DEFAULT.checks))


@pytest.mark.parametrize("name", ["P1", "cup"])
def test_a_frozen_pose(name: str) -> None:
    (finding,) = of_freezing(frozen(name, 8, 25))
    assert (finding.severity, finding.about) == ("unfit", name), "the label's end, 0.8 s, lies within"
    assert "its pose is exactly the same for 0.57 s, from 0.27 to 0.83 s, in the midst of a motion" in finding.problem
    assert "leave those samples empty" in finding.remedy


def test_a_pose_that_freezes_beside_the_labels_ends() -> None:
    assert [finding.severity for finding in of_freezing(frozen("P1", 8, 25, label=None))] == ["warning"]


@pytest.mark.parametrize("sound", ["moving", "short", "marked", "simulated"])
def test_no_frozen_pose(sound: str) -> None:
    lost = np.arange(FRAMES)
    recordings = {
        "moving": frozen("P1", 8, 8),
        "short": frozen("P1", 8, 20),
        "marked": frozen("P1", 8, 25, tracked={"P1": (lost < 8) | (lost > 25)}),
        "simulated": frozen("P1", 8, 25, provenance=Provenance(simulated=True)),
    }
    assert of_freezing(recordings[sound]) == []


def test_things_may_rest_as_still_as_they_like() -> None:
    recording = small(provenance=REAL)
    assert {(finding.severity, finding.about) for finding in of_freezing(recording)} == {("note", "P1"), ("note", "P2")}


def turned(identity: slice, wxyz: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)) -> Recording:
    """A cup that turns slowly, 60° about the vertical at first, but for frames in which it is said not to be turned."""
    world = room()
    qpos, free = still(world), world.object_slice("cup")
    qpos[:, free.start + 3 : free.stop] = [about_z(math.radians(60.0 + 0.5 * frame)) for frame in range(FRAMES)]
    qpos[identity, free.start + 3 : free.stop] = wxyz
    return small(world, qpos=qpos)


def test_identity_quaternions_of_a_lost_tracker() -> None:
    (finding,) = lost_orientations(turned(slice(23, 26)), DEFAULT.checks)
    assert (finding.severity, finding.about) == ("unfit", "cup"), "the label's end, 0.8 s, lies within"
    assert "is the identity in 3 of 31 frames, first at 0.77 s, and turned by 73° in the next" in finding.problem
    assert "identity_is_lost = true" in finding.remedy


def test_another_orientation_that_comes_back() -> None:
    """That of a tracker whose axes were turned: it is reached twice, and does not move."""
    away = about_z(math.radians(-90.0))
    recording = turned(slice(10, 12), tuple(away))
    qpos, free = np.array(recording.qpos), recording.scene.object_slice("cup")
    qpos[18, free.start + 3 : free.stop] = away
    (finding,) = lost_orientations(replace(recording, qpos=qpos), DEFAULT.checks)
    assert (finding.severity, finding.about) == ("warning", "cup")
    assert "is one and the same in 3 of 31 frames" in finding.problem


def test_things_may_turn_while_nobody_looks() -> None:
    """It was not turned, and is turned by 70° when the recording goes on after half a second."""
    recording = turned(slice(0, 15))
    assert list(lost_orientations(recording, DEFAULT.checks))
    paused = replace(recording, times_s=recording.times_s + 0.5 * (np.arange(FRAMES) >= 15))
    assert list(lost_orientations(paused, DEFAULT.checks)) == []


@pytest.mark.parametrize("wxyz_deg", [None, 0.0])
def test_orientations_that_may_be(wxyz_deg: float | None) -> None:
    """Turning slowly; the identity all the time."""
    sound = turned(slice(0, 0)) if wxyz_deg is None else turned(slice(0, FRAMES))
    assert list(lost_orientations(sound, DEFAULT.checks)) == []


def raised(height_m: float, *agents: str) -> Recording:
    world = room()
    qpos = still(world)
    for agent in agents:
        qpos[:, world.base_slice(agent).start + 2] += height_m
    return small(world, qpos=qpos)


@pytest.mark.parametrize(
    ("height_m", "severity", "where"), [(-0.8, "unfit", "under"), (0.7, "unfit", "over"), (-0.2, "warning", "under")]
)
def test_people_off_the_floor(height_m: float, severity: str, where: str) -> None:
    (finding,) = off_the_floor(raised(height_m, "P1"))
    assert (finding.severity, finding.about) == (severity, "P1")
    assert f"the soles are {abs(height_m):.2f} m {where} the floor" in finding.problem
    assert f"position_m = [0, 0, {-height_m:.2f}]" in finding.remedy


def test_people_on_the_floor() -> None:
    assert list(off_the_floor(raised(0.0))) == []
    assert list(off_the_floor(raised(0.05, "P1", "P2"))) == []


def test_people_on_something_else_or_with_unknown_legs() -> None:
    world = room('<geom name="stage" type="box" pos="-0.8 0 0.2" size="0.5 0.5 0.2"/>')
    qpos = still(world)
    qpos[:, world.base_slice("P1").start + 2] += 0.4
    assert list(off_the_floor(small(world, qpos=qpos))) == []
    lost = {"P1/legs": np.zeros(FRAMES, bool)}
    assert list(off_the_floor(replace(raised(-0.8, "P1"), tracked=lost))) == []
