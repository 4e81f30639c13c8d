"""What happens against what the label says: each fault is found, with figures and the way out, and nothing else."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from taskgist.observe import Observer
from taskgist.pipeline import Finding
from taskgist.pipeline.check_label import label_findings, roles, travels_alone
from taskgist.recognition import Change, Turn, changes_of_hands, turns_of
from taskgist.recording import Label, Recording
from taskgist.settings import DEFAULT
from tests.pipeline.small import FRAMES, LABEL, room, small, still
from tests.shipped import label, observer, recording

Array = NDArray[np.float64]


def labelled(name: str, **changes: Any) -> list[Finding]:
    """What is said of a shipped recording under another label, but that facts are unknown."""
    relabelled = recording(name).with_label(replace(label(name), **changes))
    return [f for f in label_findings(relabelled, observer(name), DEFAULT) if "unknown:" not in f.problem]


def change(name: str, thing: str) -> Change:
    (found,) = changes_of_hands(observer(name), thing, turns_of(observer(name), thing))
    return found


def of_small(world_qpos: Array | None = None, **fields: Any) -> list[Finding]:
    given = small(**fields) if world_qpos is None else small(room(), qpos=world_qpos, **fields)
    return list(label_findings(given, Observer(given.scene, given), DEFAULT))


@pytest.mark.parametrize("name", ["give_a", "handover_1", "handover_5"])
def test_labels_that_are_right(name: str) -> None:
    assert labelled(name) == []


def test_a_label_that_ends_where_it_changes_hands_is_right() -> None:
    assert labelled("give_a", start_s=3.7, end_s=change("give_a", "cup").time_s) == []


def test_a_label_may_end_in_the_very_moment_in_which_it_is_taken() -> None:
    turns = (Turn("P1", 1.0, 2.5), Turn("P2", 2.5, 5.0))
    given = (Change("P1", "P2", taken_s=2.5, released_s=2.5, kept_s=5.0),)
    assert list(roles(Label("give", "P1", "P2", "cup", 0.8, 2.5), "cup", turns, given)) == []


def test_roles_reversed() -> None:
    given_s = change("give_a", "cup").time_s
    assert given_s == pytest.approx(8.2, abs=0.3)
    (finding,) = labelled("give_a", performing_agent="P2", target_agents="P1")
    assert (finding.severity, finding.about) == ("unfit", "label")
    assert finding.problem == (f"P2 is said to give cup to P1, but P1 has it first, and P2 takes it at {given_s:.2f} s")
    assert finding.remedy.endswith("--performer P1 --target P2")


def test_who_takes_performs_where_the_task_is_another() -> None:
    assert labelled("give_a", task="take", performing_agent="P2", target_agents="P1") == []


def test_it_ends_before_it_is_taken() -> None:
    given = change("give_a", "cup")
    (finding,) = labelled("give_a", end_s=7.0)
    assert (finding.severity, finding.problem) == ("unfit", f"it ends {given.taken_s - 7.0:.2f} s before P2 has cup")
    assert finding.remedy.endswith(f"--end {given.time_s:.2f}")


def test_the_performer_never_has_it() -> None:
    (finding,) = labelled("give_a", start_s=9.5, end_s=12.0)
    assert finding.severity == "unfit"
    taken_s = change("give_a", "cup").taken_s
    assert finding.problem == f"P1 is said to give cup, but only P2 has it, from {taken_s:.2f} s on"


def test_another_than_the_performer_has_it() -> None:
    """Some tasks are performed with another thing, such as the box that hides this one: that may be."""
    (finding,) = labelled("hide_a", performing_agent="P2", target_agents="P1")
    assert finding.severity == "warning"
    assert finding.problem == "P2 is said to hide, but only P1 has cup, from 4.47 s on"
    assert finding.remedy.endswith("--performer P1")
    assert labelled("hide_a") == []


def test_the_target_no_longer_has_it() -> None:
    """In handover_2 the baton is back on the table after 1.3 s."""
    given = change("handover_2", "baton")
    (finding,) = labelled("handover_2", end_s=5.5)
    assert finding.severity == "warning"
    span = f"from {given.taken_s:.2f} to {given.kept_s:.2f} s"
    assert finding.problem == f"P2 no longer has baton at its end: only {span}"


def test_a_thing_that_travels_and_nobody_holds_it() -> None:
    """Its frame is 0.9 m beside that of the people."""
    whole = recording("give_a")
    qpos = np.array(whole.qpos)
    qpos[:, whole.scene.object_slice("cup").start + 1] += 0.9
    beside = replace(whole, qpos=qpos)
    (finding,) = travels_alone(beside, Observer(beside.scene, beside), "cup", DEFAULT)
    assert (finding.severity, finding.about) == ("unfit", "cup")
    assert "from 4.03 to 5.40 s, and nobody holds it; the nearest, P1's left hand, is 0.7" in finding.problem
    assert "transform" in finding.remedy
    assert list(travels_alone(whole, observer("give_a"), "cup", DEFAULT)) == []


def test_what_is_thrown_may_travel_alone() -> None:
    """The same way up and down in a second: once as a throw, once at an even pace."""
    world = room()
    times_s, cup = np.arange(FRAMES) / 30, world.object_slice("cup").start
    thrown, slow = still(world), still(world)
    for qpos in (thrown, slow):
        qpos[:, cup] += 2.0 * times_s
    thrown[:, cup + 2] += 0.5 + 4.905 * times_s * (1.0 - times_s)
    slow[:, cup + 2] += 0.5 + np.abs(times_s - 0.5)
    found = []
    for qpos in (thrown, slow):
        given = small(world, qpos=qpos)
        found.append(list(travels_alone(given, Observer(given.scene, given), "cup", DEFAULT)))
    assert found[0] == []
    assert [finding.severity for finding in found[1]] == ["unfit"]


def test_it_ends_in_the_air() -> None:
    """Where it stands still, a support is missing; where it does not, the end is wrong."""
    world = room()
    cup = world.object_slice("cup").start
    standing = still(world)
    standing[:, cup + 2] += 0.2
    (finding,) = of_small(standing)
    bottom_m = 0.771 + 0.2 - 0.05
    assert (finding.severity, finding.about) == ("unfit", "cup")
    assert f"stands still in the air, {bottom_m:.2f} m above z = 0, at the label's end (0.80 s)" in finding.problem
    assert f"a support with its top at z = {bottom_m:.2f} m" in finding.remedy
    falling = standing.copy()
    falling[:, cup] += np.arange(FRAMES) / 60
    moving = [each for each in of_small(falling) if "in the air" in each.problem]
    assert ["moves in the air" in each.problem for each in moving] == [True]
    assert of_small() == []


@pytest.mark.parametrize(("first", "severity"), [(0, "warning"), (5, "warning"), (12, "note")])
def test_it_begins_too_late(first: int, severity: str) -> None:
    """The cup slides along the table from a frame on; the label starts there, or as soon as there is anything."""
    world = room()
    qpos = still(world)
    qpos[:, world.object_slice("cup").start] += np.clip(np.arange(FRAMES) - first, 0, None) / 100
    start_s = 0.0 if first < 10 else 0.5
    findings = of_small(qpos, label=replace(LABEL, start_s=start_s))
    (finding,) = (each for each in findings if "unknown:" not in each.problem)
    assert finding.severity == severity
    assert ("begins too late" in finding.problem) == (severity == "warning")
    if severity == "note":
        assert "cup is already moving at the start, since 0.40 s" in finding.problem
        assert "--start 0.10" in finding.remedy


def test_the_file_ends_with_the_label() -> None:
    (finding,) = of_small(label=replace(LABEL, end_s=0.95))
    assert (finding.severity, finding.about) == ("warning", "label")
    assert finding.problem == "the recording ends 0.05 s after it, less than the 0.2 s that confirm"
    assert of_small(label=replace(LABEL, end_s=0.8)) == []


def test_the_file_ends_before_it_is_done() -> None:
    """The recording of a cup that is carried stops in the midst of it."""
    whole = recording("hide_a")
    part = whole.times_s <= 5.2
    cut = Recording(
        whole.scene,
        whole.times_s[part],
        whole.qpos[part],
        {name: flags[part] for name, flags in whole.tracked.items()},
        replace(label("hide_a"), end_s=5.1),
        whole.provenance,
    )
    findings = label_findings(cut, Observer(cut.scene, cut), DEFAULT)
    (finding,) = (each for each in findings if "unknown:" not in each.problem)
    assert finding.severity == "unfit"
    assert finding.problem == "the recording ends 0.10 s after it, while P1 still moves cup"
