"""Several things, one after the other: what is done stays done, what was given stays in the hand, all is judged."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from taskgist.errors import InputError
from taskgist.language.performing import acted, chosen
from taskgist.performing.outputs import plan_document
from taskgist.pipeline.performing import Outcome, Performance, perform
from taskgist.planning.requests import Request
from taskgist.world import Hold, Scene
from taskgist_lab.simulator.room import TABLE, Person, Room, on_table
from tests.pipeline.test_performing import clause
from tests.schemas import hold_to_schema


@cache
def scene() -> Scene:
    people = (
        Person("R", 1.5, (-1.6, 0.0), 0.0, "standing", profile="jido"),
        Person("P2", 1.7, (0.75, 0.0), math.pi, "sitting"),
    )
    things = (on_table("cup", -0.25, 0.0), on_table("wooden_cube", -0.25, 0.35), on_table("white_box", 0.0, -0.2))
    return Room("room", people, things, TABLE).scene()


@cache
def outcome(task: str, *things: str) -> Outcome:
    return perform(scene(), Request(clause(task), "R", "P2", things[0], also_with=things[1:]))


def performed(task: str, *things: str) -> Performance:
    (found,) = outcome(task, *things).performances
    return found


@pytest.mark.parametrize("task", ["hide", "give", "put away"])
def test_it_holds_for_each_thing_in_the_end(task: str) -> None:
    found = performed(task, "cup", "wooden_cube")
    assert found.audit.clean
    assert found.strict is True
    assert [action.thing for action in found.plan.actions] == ["cup", "wooden_cube"]
    assert found.explanation.target_objects == ("cup", "wooden_cube")
    assert [clause(task).holds(part.nodes) for part in found.explanation.parts] == [True, True]
    label = found.execution.recording.label
    assert label is not None
    assert label.target_objects == ("cup", "wooden_cube")


def test_what_was_given_first_stays_in_its_hand_wherever_that_moves() -> None:
    execution = performed("give", "cup", "wooden_cube").execution
    taken = [frozenset(hold for hold in holds if hold.agent == "P2") for holds in execution.holds]
    assert {hold.object for hold in taken[-1]} == {"cup", "wooden_cube"}
    assert len({hold.side for hold in taken[-1]}) == 2, "each in a hand of its own"
    (cup,) = (hold for hold in taken[-1] if hold.object == "cup")
    since = next(frame for frame, holds in enumerate(taken) if cup in holds)
    assert all(cup in holds for holds in taken[since:])
    places = np.array(execution.recording.qpos)[since:, scene().object_slice("cup")][:, :3]
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() < 0.05, "metres from frame to frame"


@cache
def between_people(task: str) -> Performance:
    people = (
        Person("P1", 1.75, (-0.7, 0.0), 0.0, "sitting"),
        Person("P2", 1.7, (0.75, 0.0), math.pi, "sitting"),
    )
    room = Room("room", people, (on_table("cup", -0.2, 0.3), on_table("wooden_cube", -0.2, 0.12)), TABLE).scene()
    outcome = perform(room, Request(clause(task), "P1", "P2", "cup", also_with=("wooden_cube",)))
    assert not outcome.spoiled, "what people push into is known before anything is carried out"
    (found,) = outcome.performances
    return found


@pytest.mark.parametrize("task", ["give", "show", "make accessible"])
def test_a_person_performs_with_one_thing_after_the_other(task: str) -> None:
    found = between_people(task)
    assert found.audit.clean
    assert found.strict is True
    assert [action.thing for action in found.plan.actions] == ["cup", "wooden_cube"]


def test_who_has_taken_the_first_draws_it_near_before_the_next_comes() -> None:
    found = between_people("give")
    recording = found.execution.recording
    first, second = found.plan.actions
    assert first.phases[-1].name == "draw near"
    assert {hold.agent for hold in first.phases[-1].holds} == {"P2"}
    assert "draw near" not in {phase.name for phase in second.phases}, "then nothing more is to follow"
    column, base = recording.scene.object_slice("cup"), recording.scene.agent("P2").base
    taken, drawn = (phase.qpos[-1] for phase in first.phases[-2:])
    away_m = [float(np.linalg.norm(qpos[column][:2] - qpos[base][:2])) for qpos in (taken, drawn)]
    assert away_m[1] < away_m[0] - 0.05
    assert {hold.side for hold in found.execution.holds[-1]} == {"left", "right"}


def test_the_other_way_round_is_another_order() -> None:
    found = performed("hide", "wooden_cube", "cup")
    assert [action.thing for action in found.plan.actions] == ["wooden_cube", "cup"]
    assert found.explanation.target_objects == ("cup", "wooden_cube")
    assert chosen(found.plan).count("; then R puts the cup ") == 1


def test_the_same_request_has_the_same_plan() -> None:
    first = performed("put away", "cup", "wooden_cube").execution.recording
    request = Request(clause("put away"), "R", "P2", "cup", also_with=("wooden_cube",))
    again = perform(scene(), request).performances[0].execution.recording
    assert np.array_equal(first.qpos, again.qpos)


def test_hands_are_empty_before_the_next_thing_is_taken() -> None:
    """One thing after the other cannot both be held up with one hand: the first is put down."""
    found = performed("show", "cup", "wooden_cube")
    first, second = found.plan.actions
    assert first.candidate.means in {"put_on", "put_in"}
    assert not {hold.object for hold in second.phases[0].holds}
    assert Hold("R", first.side, "cup") not in second.phases[-1].holds


def test_sentences_and_documents_tell_of_each_thing() -> None:
    found = performed("hide", "cup", "wooden_cube")
    first, second = found.plan.actions
    assert (first.about, second.about) == ("cup", "wooden_cube")
    box = replace(second.candidate, thing="white_box", means="put_over")
    covered = replace(second, candidate=box, purpose="cover")
    told = acted(replace(found.plan, actions=(first, covered)), covered)
    assert told.startswith("R puts the white_box over the wooden_cube, ")
    document = plan_document(found.plan, found.execution)
    hold_to_schema("perform_plan", document)
    last = np.array(found.execution.recording.qpos)[-1]
    for name, attained in zip(document["object"], document["attained"], strict=True):
        assert np.allclose(attained["position_m"], last[scene().object_slice(name)][:3], atol=1e-6)


def test_efforts_of_whoever_takes_each_thing_are_counted() -> None:
    found = performed("give", "cup", "wooden_cube")
    alone = [performed("give", name).plan.cost for name in ("cup", "wooden_cube")]
    efforts = found.plan.cost.efforts
    assert set(efforts) == {"R", "P2"}
    assert efforts["R"] == sum(action.level for action in found.plan.actions)
    assert efforts["P2"] == sum(each.efforts["P2"] for each in alone)
    assert found.plan.cost.actions == len(found.plan.actions) == 2


def test_several_things_are_no_one_problem_for_other_planners() -> None:
    with pytest.raises(InputError, match=r"pddl: several things are no one problem \(got 'cup wooden_cube'\)"):
        outcome("hide", "cup", "wooden_cube").pddl()
