"""Every kind of finding can be found, and a sound recording has none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from taskgist.pipeline import Finding, check
from taskgist.recording import Provenance, Recording
from tests.pipeline.small import FRAMES, room, small, still, sunk_box
from tests.scenes import box
from tests.shipped import excerpt, label

NEVER = np.zeros(FRAMES, bool)
LATE = np.arange(FRAMES) > 15
BROKEN_OFF = np.arange(FRAMES) < 15
GAP = np.arange(FRAMES) / 30 + 0.5 * (np.arange(FRAMES) > 10)


def moving() -> Recording:
    """The cup slides from the first frame on."""
    world = room()
    qpos = still(world)
    qpos[:, world.object_slice("cup").start] += np.arange(FRAMES) / 100
    return small(world, qpos=qpos)


def jumping(name: str, **fields: Any) -> Recording:
    """A body or an object is 10 m away for three frames."""
    world = room()
    free = world.base_slice(name) if name in world.agents else world.object_slice(name)
    qpos = still(world)
    qpos[15:18, free.start] += 10.0
    return small(world, qpos=qpos, **fields)


def oddly_fitted() -> Recording:
    """Reports that another program wrote."""
    return small(
        provenance=Provenance(
            simulated=True, fit={"P1": 3, "P2": {"points_cm": {"left_wrist": {"median": "large"}, "x": []}}}
        )
    )


def badly_fitted() -> Recording:
    fit: dict[str, Any] = {"P1": {"points_cm": {"left_wrist": {"median": 7.0}, "neck": {"median": 2.0}}}}
    return small(provenance=Provenance(simulated=True, fit=fit))


KINDS: dict[str, tuple[Recording, list[tuple[str, str, str]]]] = {
    "sound": (small(), []),
    "unlabelled": (small(label=None), [("unfit", "label", "there is none")]),
    "gap": (small(times_s=GAP), [("warning", "time", "no frames for 0.53 s after 0.33 s (usually every 0.033 s)")]),
    "never tracked": (
        small(tracked={"P2/head": NEVER}),
        [
            ("warning", "P2/head", "never tracked"),
            ("note", "facts at the label's start", "unknown: see.effort, see.state, see.action, visibility.score"),
            ("note", "facts at the label's end", "unknown: see.effort, see.state, see.action, visibility.score"),
        ],
    ),
    "lost at times": (
        small(tracked={"P1/left_arm": BROKEN_OFF}),
        [("warning", "P1/left_arm", "untracked in 52 % of the frames, between 0.50 and 1.00 s")],
    ),
    "object lost at the start": (
        small(tracked={"cup": LATE}),
        [
            ("unfit", "cup", "no fact can be said of it at the label's start (0.20 s)"),
            ("warning", "cup", "untracked in"),
        ],
    ),
    "object never tracked": (
        small(tracked={"cup": NEVER}),
        [("unfit", "cup", "label's start"), ("unfit", "cup", "label's end"), ("warning", "cup", "never tracked")],
    ),
    "target agent never tracked": (
        small(tracked={"P2": NEVER}),
        [
            ("warning", "P2", "never"),
            ("note", "facts at the label's start", "hands"),
            ("note", "label's end", "posture"),
        ],
    ),
    "poor fit": (badly_fitted(), [("note", "P1's left_wrist", "the fitted body is 7.0 cm away from it (median)")]),
    "odd fit": (oddly_fitted(), []),
    "an object jumps": (
        jumping("cup"),
        [("warning", "cup", "jumps by 10.00 m at 0.50 s (300 m/s), and 1 times more")],
    ),
    "overlap": (
        small(room(sunk_box())),
        [("warning", "box and table", "overlap by up to 6.0 cm (at 0.00 s)")],
    ),
    "moving at the start": (
        moving(),
        [("warning", "label", "the recording begins too late: cup moves already in its")],
    ),
    "estimated": (small(room(extra='estimated = ["table"]')), [("note", "table", "its place or shape is an estimate")]),
}


@pytest.mark.parametrize("kind", KINDS)
def test_findings(kind: str) -> None:
    flawed, expected = KINDS[kind]
    checkup = check(flawed)
    assert len(checkup.findings) == len(expected), checkup.findings
    for finding, parts in zip(checkup.findings, expected, strict=True):
        assert all(part in text_of(finding) for part in parts), finding
    assert checkup.fit == ("unfit" not in {finding.severity for finding in checkup.findings})


def test_a_body_jumps() -> None:
    (finding,) = (each for each in check(jumping("P1")).findings if "jumps" in each.problem)
    assert (finding.severity, finding.about) == ("warning", "P1")
    assert "jumps by 10.00 m at 0.50 s" in finding.problem


@pytest.mark.parametrize(
    ("up_m", "beneath", "severity"), [(-0.5, "", "unfit"), (0.25, "", "warning"), (0.3, "step", None), (0.0, "", None)]
)
def test_people_under_and_over_the_floor(up_m: float, beneath: str, severity: str | None) -> None:
    world = room(box(beneath, -0.8, 0.0, 0.15, (0.3, 0.3, 0.15))) if beneath else room()
    qpos = still(world)
    qpos[:, world.base_slice("P1").start + 2] += up_m
    found = [each for each in check(small(world, qpos=qpos)).findings if "the soles" in each.problem]
    assert [each.severity for each in found] == ([] if severity is None else [severity])
    assert all(each.about == "P1" and f"[0, 0, {-up_m:.2f}]" in each.remedy for each in found)


def test_where_nothing_was_tracked_nothing_jumps() -> None:
    """Frames without tracking hold fillers; what is elsewhere after half a second of them may have walked."""
    elsewhere = np.isin(np.arange(FRAMES), (15, 16, 17))
    assert not any("jumps" in each.problem for each in check(jumping("cup", tracked={"cup": ~elsewhere})).findings)


def test_fast_motion_is_no_jump() -> None:
    world = room()
    qpos = still(world)
    qpos[:, world.object_slice("cup").start] += np.arange(FRAMES) * 9.0 / 30
    assert not any("jumps" in each.problem for each in check(small(world, qpos=qpos)).findings)


@pytest.mark.parametrize(
    ("half_m", "problem"), [(4.0, "is 8 m long: in millimetres?"), (0.0002, "shrunk a thousandfold")]
)
def test_sizes_in_another_unit(half_m: float, problem: str) -> None:
    world = room(box("crate", 0.0, 20.0, 10.0, (half_m,) * 3))
    (finding,) = (each for each in check(small(world)).findings if each.about == "crate")
    assert problem in finding.problem


def text_of(finding: Finding) -> str:
    return f"{finding.severity} {finding.about}: {finding.problem}"


def test_what_is_wrong_comes_with_a_remedy_and_the_worst_comes_first() -> None:
    findings = check(small(label=None, times_s=GAP, provenance=badly_fitted().provenance)).findings
    assert [finding.severity for finding in findings] == ["unfit", "warning", "note"]
    assert all(finding.remedy for finding in findings)


def test_progress_is_told() -> None:
    shares: list[float] = []
    check(small(), progress=lambda _what, share: shares.append(share))
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


@pytest.mark.parametrize("name", ["handover_1", "handover_5", "show_a"])
def test_shipped_recordings_are_fit(name: str) -> None:
    ends = label(name)
    assert check(excerpt(name, ends.start_s - 0.4, ends.end_s + 0.3, every=2)).fit
