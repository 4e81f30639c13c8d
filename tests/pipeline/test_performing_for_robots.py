"""A robot as target agent: it takes what it is given, and things are shown to it and hidden from it."""

from __future__ import annotations

import math
from functools import cache

import mujoco
import numpy as np
import pytest

from taskgist.facts import vocabulary as v
from taskgist.facts.standard import STANDARD_TREE
from taskgist.language.performing import chosen, refused, steps
from taskgist.performing.outputs import robot_trajectory
from taskgist.pipeline.performing import Outcome, Performance, perform
from taskgist.planning.plan import Phase
from taskgist.planning.requests import Request
from taskgist.settings import DEFAULT
from taskgist.world import Scene
from taskgist_lab.simulator.room import TABLE, Room, on_table
from taskgist_lab.simulator.room import Person as Somebody
from tests.pipeline.test_performing import clause
from tests.planning.rooms import TABLE_M, box, table
from tests.schemas import hold_to_schema
from tools.rooms import Person, Thing
from tools.rooms import Room as Plain

SCREEN = Thing("screen", (0.02, 0.15, 0.15), (0.05, -0.15, TABLE_M + 0.15), free=False)


def between(giver: str, taker: str, *things: Thing) -> Scene:
    """A table, a giver ``R`` on one side, a taker ``R2`` on the other."""
    people = (
        Person("R", (-1.4, 0.0), 0.0, profile=giver),
        Person("R2", (1.6, 0.0), math.pi, profile=taker),
    )
    built = Plain((table("table", 0.0), *things), people)
    spec = mujoco.MjSpec.from_string(built.files()["room.xml"].decode())
    return Scene.from_spec(spec, [person.entry() for person in built.people])


def why_not(outcome: Outcome) -> str:
    assert not outcome.performances
    return "; ".join(refused(outcome.request, outcome.goal, outcome.search, outcome.spoiled, STANDARD_TREE))


def handed(found: Performance, giver: str, taker: str) -> tuple[Phase, ...]:
    """The phases of a handover, from the first in which both hold the thing, which is checked."""
    phases = found.plan.phases
    who = ["".join(sorted(hold.agent for hold in phase.holds)) for phase in phases]
    both = "".join(sorted((giver, taker)))
    order = list(dict.fromkeys(who))
    assert order[order.index(giver) :] == [giver, both, taker], "the giver, then both, then the taker"
    return phases[who.index(both) :]


# --- Given.


@cache
def given() -> Performance:
    outcome = perform(between("pr2", "jido", box(-0.1, 0.2)), Request(clause("give"), "R", "R2", "box"))
    (found,) = outcome.performances
    return found


def test_a_robot_takes_what_another_one_hands_over() -> None:
    found = given()
    assert found.audit.clean
    assert found.strict is True
    assert {hold.agent for hold in found.execution.holds[-1]} == {"R2"}
    assert chosen(found.plan).startswith("R hands the box over to R2, its middle at ")
    assert any(step.startswith("waits until R2 has taken it (") for step in steps(found.plan))


def test_both_hold_it_for_a_moment_and_it_stays_where_it_is_as_the_giver_goes() -> None:
    found = given()
    scene = found.execution.recording.scene
    shared, *after = handed(found, "R", "R2")
    assert 0.2 < shared.duration_s < 1.0
    assert [phase.name for phase in after][:2] == ["open", "retreat"]
    box_slice = scene.object_slice("box")
    rows = np.concatenate([phase.qpos for phase in (shared, *after)])
    assert np.abs(rows[:, box_slice] - rows[0, box_slice]).max() < 1e-6


def test_the_taker_stays_where_it_stands_and_moves_within_its_limits() -> None:
    recording = given().execution.recording
    qpos, agent = np.array(recording.qpos), recording.scene.agent("R2")
    assert np.ptp(qpos[:, agent.base], axis=0).max() < 1e-9
    joints = [agent.joints[f"arm_{number}"] for number in range(1, 8)]
    speeds = np.abs(np.diff(qpos[:, joints], axis=0)) / np.diff(recording.times_s)[:, None]
    assert 0.1 < speeds.max() <= DEFAULT.planning.joint_rad_s * 1.02


def test_the_takers_controllers_get_a_trajectory_too() -> None:
    found = given()
    document = robot_trajectory(found.plan, found.execution)
    hold_to_schema("perform_trajectory", document)
    assert document["robot"] == "R"
    (taker,) = document["helpers"]
    assert taker["robot"] == "R2"
    assert len(taker["joint_trajectories"]["right_arm"]["points"]) > 30


def test_why_a_robot_cannot_take_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("taskgist.planning.planner.MOST_PLACES", 150)
    wide = box(-0.1, 0.2, (0.0415, 0.0415, 0.0415))
    outcome = perform(between("pr2", "jido", wide), Request(clause("give"), "R", "R2", "box", means=("move",)))
    told = why_not(outcome)
    assert f"at {outcome.search.out_of_hand} of them R2 could not take it: the box is too wide for the hand (" in told
    assert outcome.search.out_of_hand == sum(outcome.search.not_taken.values()) > 0


# --- Shown, and hidden: by what its camera sees.


def test_a_thing_is_shown_to_a_robot() -> None:
    scene = between("jido", "pr2", box(-0.1, 0.2))
    (found,) = perform(scene, Request(clause("show"), "R", "R2", "box")).performances
    assert found.audit.clean
    assert found.strict is True
    assert found.plan.candidate.means == "hold_up"
    assert found.explanation.nodes["visibility.class"].value == v.INCREASED


def test_a_thing_is_hidden_from_a_robot() -> None:
    scene = between("jido", "pr2", box(-0.1, 0.2), SCREEN)
    (found,) = perform(scene, Request(clause("hide"), "R", "R2", "box")).performances
    assert found.audit.clean
    assert found.strict is True
    assert found.plan.candidate.carrier == "table"
    assert found.plan.candidate.pose[0] < SCREEN.place[0], "behind the screen, as R2 sees it"


# --- By a person.


def test_a_person_hands_something_over_to_a_robot() -> None:
    people = (
        Somebody("P1", 1.75, (-0.7, 0.0), 0.0, "sitting"),
        Somebody("R2", 1.5, (0.9, 0.0), math.pi, "standing", profile="jido"),
    )
    scene = Room("room", people, (on_table("wooden_cube", -0.2, 0.12), on_table("white_box", 0.0, -0.2)), TABLE).scene()
    (found,) = perform(scene, Request(clause("give"), "P1", "R2", "wooden_cube")).performances
    assert found.audit.clean
    assert found.strict is True
    _, *after = handed(found, "P1", "R2")
    assert [phase.name for phase in after] == ["retreat"]
    recording = found.execution.recording
    qpos, agent = np.array(recording.qpos), recording.scene.agent("P1")
    arms = agent.arm_positions
    assert np.abs(qpos[-1, arms] - qpos[0, arms]).max() < 0.05, "its hand is back where it was, but for its breathing"
