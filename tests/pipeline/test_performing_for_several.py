"""What is done for several at once holds for each of them, and what cannot be is told at once."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from itertools import islice

import pytest

from taskgist.errors import InputError
from taskgist.facts import vocabulary as v
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.values import UNKNOWN, Observation
from taskgist.language.performing import assumed, chosen, refused
from taskgist.learning.understanding import Literal
from taskgist.observe.attributes import resting_snapshot
from taskgist.pipeline.performing import Outcome, perform
from taskgist.planning.aims import Aim
from taskgist.planning.endings import Endings
from taskgist.planning.goal import Goal
from taskgist.planning.requests import Request
from taskgist.settings import DEFAULT
from taskgist.world import Scene, Stage
from taskgist_lab.generator.outcomes import share_in_view
from taskgist_lab.simulator.room import TABLE, Person, Room, on_table
from tests.pipeline.test_performing import clause


@cache
def scene() -> Scene:
    people = (
        Person("R", 1.5, (-1.6, 0.0), 0.0, "standing", profile="jido"),
        Person("P2", 1.7, (0.75, -0.38), math.pi, "sitting"),
        Person("P3", 1.65, (0.75, 0.38), math.pi, "sitting"),
    )
    things = (on_table("cup", -0.2, 0.3), on_table("white_box", 0.0, -0.2), on_table("screen", -0.02, 0.45))
    return Room("room", people, things, TABLE).scene()


@cache
def performed(task: str, *targets: str) -> Outcome:
    return perform(scene(), Request(clause(task), "R", targets[0], "cup", also_for=targets[1:]))


@pytest.mark.parametrize("task", ["hide", "show", "make accessible"])
def test_it_holds_for_each(task: str) -> None:
    (found,) = performed(task, "P2", "P3").performances
    assert found.audit.clean
    assert found.strict is True
    assert found.explanation.target_agents == ("P2", "P3")
    assert [clause(task).holds(part.nodes) for part in found.explanation.parts] == [True, True]
    label = found.execution.recording.label
    assert label is not None
    assert label.target_agents == ("P2", "P3")


def test_what_is_hidden_from_one_is_not_hidden_from_both() -> None:
    """The place for both is another one, for straight lines from both eyes, too."""
    (one,), (both,) = performed("hide", "P2").performances, performed("hide", "P2", "P3").performances
    stage = Stage(scene(), one.execution.recording.state(-1))
    assert share_in_view(stage, "P2", "cup") == 0.0 < share_in_view(stage, "P3", "cup")
    stage.show(both.execution.recording.state(-1))
    assert share_in_view(stage, "P2", "cup") == share_in_view(stage, "P3", "cup") == 0.0


def test_the_order_of_the_targets_changes_nothing_that_is_asked_of_the_end() -> None:
    (found,) = performed("hide", "P3", "P2").performances
    assert found.explanation.target_agents == ("P2", "P3")
    assert [clause("hide").holds(part.nodes) for part in found.explanation.parts] == [True, True]


def test_nobody_gives_one_thing_to_two() -> None:
    outcome = performed("give", "P2", "P3")
    assert not outcome.performances
    assert outcome.search.places == 0, "told before any search"
    told = refused(outcome.request, outcome.goal, outcome.search, outcome.spoiled, STANDARD_TREE)
    assert told == ("the cup cannot be in the hands of P2 and of P3 at once",)


def test_sentences_name_all() -> None:
    outcome = performed("show", "P2", "P3")
    assert assumed(outcome.request) == "P2 and P3 are assumed to look at the cup once it is there"
    assert chosen(outcome.performances[0].plan).startswith("R holds the cup up for P2 and P3, its middle at (")


@pytest.mark.parametrize(
    ("further", "message"),
    [
        ({"also_for": ("P2",)}, r"Request: also_for: stands twice \(got 'P2'\)"),
        ({"also_for": ("R",)}, r"Request: also_for: stands twice \(got 'R'\)"),
        ({"also_with": ("cup",)}, r"Request: also_with: stands twice \(got 'cup'\)"),
    ],
)
def test_names_that_stand_twice(further: dict[str, tuple[str, ...]], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Request(clause("hide"), "R", "P2", "cup", **further)  # type: ignore[arg-type]


def test_hands_of_each_decide_who_is_handed_the_thing() -> None:
    """Whether the hands of the first are free is not known; those of the other are to end so: it is handed nothing."""
    free = Literal("hands.status.2", STANDARD_TREE.node("hands.status.2").title, v.FREE_OF_OBJECT, 2)
    request = Request(replace(clause("hide"), literals=(free,)), "R", "P2", "cup", also_for=("P3",))
    stage, aims = Stage(scene()), []
    for name in request.targets:
        known = resting_snapshot(stage, agent=name, name="cup", settings=DEFAULT)
        known = {**known, "hands": Observation(UNKNOWN)} if name == "P2" else known
        aims.append(Aim(name, "cup", Goal.of(request.clause, known, STANDARD_TREE)))
    found = Endings(scene(), scene().initial, request, aims, DEFAULT, ()).moved(scene().initial, "R")
    means = [each.candidate for each in islice(found, 8)]
    assert {each.carrier for each in means if each.means == "hand_over"} == {"P2"}
