"""Means besides moving the thing: it is covered, the way to it is cleared, another agent helps; and why not, else."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from taskgist.facts.standard import STANDARD_TREE
from taskgist.language.performing import chosen, refused, steps
from taskgist.pipeline.performing import Outcome, perform
from taskgist.planning.requests import Request
from taskgist.world import Scene
from taskgist_lab.generator.things import OpenBox
from taskgist_lab.simulator.room import TABLE, Person, Room, Thing
from tests.pipeline.test_performing import clause

TOP = 0.72
IT = Thing("tape", (0.05, 0.04, 0.03), (-0.1, 0.3, TOP))
P2 = Person("P2", 1.7, (0.75, 0.0), math.pi, "sitting")


def robot(name: str, x: float, y: float = 0.0, yaw: float = 0.0, profile: str = "jido") -> Person:
    return Person(name, 1.5, (x, y), yaw, "standing", profile=profile)


def why_not(outcome: Outcome) -> str:
    assert not outcome.performances
    told = refused(outcome.request, outcome.goal, outcome.search, outcome.spoiled, STANDARD_TREE)
    return "; ".join(told)


# --- Covered.


@cache
def with_covers() -> Scene:
    dome = OpenBox("dome", (0.075, 0.075, 0.10), (-0.1, -0.1, TOP), upside_down=True)
    bin_ = OpenBox("bin", (0.074, 0.074, 0.10), (-0.1, -0.35, TOP))
    return Room("room", (robot("R", -1.6), P2), (IT, dome, bin_), TABLE).scene()


def test_a_thing_is_hidden_beneath_a_cover() -> None:
    scene = with_covers()
    (found,) = perform(scene, Request(clause("hide"), "R", "P2", "tape", means=("cover",))).performances
    (action,) = found.plan.actions
    assert (action.purpose, action.thing, action.candidate.means) == ("cover", "dome", "put_over")
    assert found.audit.clean
    assert found.strict is True
    qpos = np.array(found.execution.recording.qpos)
    tape, dome = (scene.object_slice(name) for name in ("tape", "dome"))
    assert np.abs(qpos[:, tape] - qpos[0, tape]).max() < 1e-6, "what is covered stays where it is"
    assert np.linalg.norm(qpos[-1, dome][:2] - qpos[0, tape][:2]) < 0.02
    assert chosen(found.plan).startswith("R puts the dome over the tape, its middle at (-0.10, 0.30, ")
    assert steps(found.plan)[0].startswith("drives to the dome (")


def test_why_nothing_covers_it() -> None:
    small = OpenBox("small", (0.05, 0.05, 0.09), (-0.1, -0.1, TOP), upside_down=True)
    scene = Room("room", (robot("R", -1.6), P2), (IT, small), TABLE).scene()
    outcome = perform(scene, Request(clause("hide"), "R", "P2", "tape", means=("cover",)))
    assert why_not(outcome) == "R covers the tape with the small: there is no place for it"


# --- Cleared.


def screen(deep_m: float) -> Thing:
    return Thing("screen", (deep_m, 0.30, 0.26), (0.05, 0.3, TOP))


def test_what_hides_a_thing_is_cleared_to_show_it() -> None:
    scene = Room("room", (robot("R", -1.6), P2), (IT, screen(0.04)), TABLE).scene()
    (found,) = perform(scene, Request(clause("show"), "R", "P2", "tape", means=("clear",))).performances
    (action,) = found.plan.actions
    assert (action.purpose, action.thing) == ("clear", "screen")
    assert found.audit.clean
    assert found.strict is True
    assert found.explanation.nodes["visibility.class"].value == "Increased"
    assert chosen(found.plan).endswith(" m, out of the way")


def test_why_what_hides_a_thing_is_not_cleared() -> None:
    scene = Room("room", (robot("R", -1.6), P2), (IT, screen(0.10)), TABLE).scene()
    outcome = perform(scene, Request(clause("show"), "R", "P2", "tape", means=("clear",)))
    assert why_not(outcome) == "R clears the screen out of the way: R does not get hold of the screen"


def test_what_keeps_the_performers_hand_off_is_cleared_first() -> None:
    dome = OpenBox("dome", (0.075, 0.075, 0.09), (-0.1, 0.3, TOP), upside_down=True)
    scene = Room("room", (robot("R", -1.6), P2), (IT, dome), TABLE).scene()
    outcome = perform(scene, Request(clause("give"), "R", "P2", "tape"))
    (found,) = outcome.performances
    assert [(each.purpose, each.thing) for each in found.plan.actions] == [("clear", "dome"), ("move", "tape")]
    assert found.plan.cost.actions == 2
    assert found.audit.clean
    assert found.strict is True
    assert {hold.agent for hold in found.execution.holds[-1]} == {"P2"}
    assert all(settled.stays for settled in found.execution.settled), "physics has the dome before the tape is taken"
    assert outcome.search.out_of_hold == "R cannot grasp the tape: shut in by dome and table", "alone was asked first"


@cache
def beneath_a_laden_dome(wide_m: float) -> Scene:
    dome = OpenBox("dome", (0.075, 0.075, 0.09), (-0.1, 0.3, TOP), upside_down=True)
    on_top = Thing("book", (wide_m, wide_m, 0.09), (-0.1, 0.3, TOP + 0.09))
    return Room("room", (robot("R", -1.6), P2), (IT, dome, on_top), TABLE).scene()


def test_what_lies_on_what_is_in_the_way_is_cleared_before_that() -> None:
    (found,) = perform(beneath_a_laden_dome(0.05), Request(clause("give"), "R", "P2", "tape")).performances
    cleared = [("clear", "book"), ("clear", "dome"), ("move", "tape")]
    assert [(each.purpose, each.thing) for each in found.plan.actions] == cleared
    assert found.audit.clean
    assert found.strict is True


def test_why_nothing_is_cleared_that_carries_what_no_hand_takes() -> None:
    outcome = perform(beneath_a_laden_dome(0.12), Request(clause("give"), "R", "P2", "tape", means=("move", "clear")))
    told = why_not(outcome)
    assert "R cannot grasp the tape: shut in by dome and table" in told
    assert "R clears the dome out of the way, R brings the tape there: on the dome, or in it, there is the book" in told
    assert "R clears the book out of the way" in told
    assert "R does not get hold of the book" in told
