"""Robots perform what tasks mean, in a room that no demonstration showed, and the facts say so."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from taskgist.common import extras
from taskgist.common.workers import Progress
from taskgist.errors import InputError
from taskgist.facts import vocabulary as v
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.values import NEGLIGIBLE
from taskgist.language.performing import as_shown, chosen, not_had, refused, steps
from taskgist.learning.literals import SetLiteral
from taskgist.learning.understanding import Clause, Literal
from taskgist.performing.audit import audit
from taskgist.performing.findings import Audit
from taskgist.pipeline import performing
from taskgist.pipeline.performing import Outcome, perform
from taskgist.planning.one_by_one import OneByOne
from taskgist.planning.plan import Plan
from taskgist.planning.requests import Request
from taskgist.world import Scene, Stage
from taskgist_lab.simulator.room import TABLE, Person, Room, Thing, on_table

AT_REST = {"placement.status.1": v.ON_SUPPORT, "motion.status.2": v.STATIC}
FREE_HANDS = {"hands.class": v.MANIP_AVOIDED}
TASKS = {
    "show": AT_REST | FREE_HANDS | {"visibility.class": v.INCREASED, "see.action.2": v.NO_ACTION},
    "hide": AT_REST
    | FREE_HANDS
    | {"visibility.score.2": NEGLIGIBLE, "see.class": v.BECOMES_DIFFICULT, "placement.status.2": v.ON_SUPPORT},
    "make accessible": AT_REST
    | FREE_HANDS
    | {"reach.class": v.BECOMES_EASIER, "grasp.class": v.BECOMES_EASIER, "placement.status.2": v.ON_SUPPORT},
    "give": AT_REST | {"hands.class": v.MANIP_GAINED, "placement.status.2": v.IN_HAND},
    "put away": AT_REST
    | FREE_HANDS
    | {"reach.class": v.BECOMES_DIFFICULT, "grasp.class": v.BECOMES_DIFFICULT, "placement.status.2": v.ON_SUPPORT},
    "hide away": AT_REST
    | FREE_HANDS
    | {
        "reach.class": v.BECOMES_DIFFICULT,
        "see.class": v.BECOMES_DIFFICULT,
        "visibility.score.2": NEGLIGIBLE,
        "placement.status.2": v.ON_SUPPORT,
    },
}
"""What the six tasks mean, roughly as the study teaches it."""


def clause(task: str) -> Clause:
    nodes = [STANDARD_TREE.node(name) for name in TASKS[task]]
    values = TASKS[task].values()
    return Clause(
        task,
        tuple(Literal(node.name, node.title, value, node.instant) for node, value in zip(nodes, values, strict=True)),
    )


@cache
def scene(robot: str) -> Scene:
    people = (
        Person("R", 1.5, (-1.6, 0.0), 0.0, "standing", profile=robot),
        Person("P2", 1.7, (0.75, 0.0), math.pi, "sitting"),
    )
    return Room("room", people, (on_table("cup", -0.2, 0.3), on_table("white_box", 0.0, -0.2)), TABLE).scene()


@cache
def performed(robot: str, task: str) -> Outcome:
    return perform(scene(robot), Request(clause(task), "R", "P2", "cup"))


@pytest.mark.parametrize("task", TASKS)
def test_a_robot_performs_every_task(task: str) -> None:
    (found,) = performed("jido", task).performances
    assert found.audit.clean
    assert found.strict is True
    assert found.explanation.nodes["posture.class"].value == v.MAINTAINED
    assert [action.side for action in found.plan.actions] == ["right"]
    last = found.execution.recording.qpos[-1]
    column = scene("jido").object_slice("cup")
    assert np.linalg.norm(last[column][:3] - found.plan.candidate.pose[:3]) < 0.010, "where it was planned"


def test_so_does_another_robot() -> None:
    (found,) = performed("pr2", "hide").performances
    assert found.strict is True


def test_only_the_performer_its_load_and_a_takers_arm_move() -> None:
    (found,) = performed("jido", "give").performances
    qpos, room = np.array(found.execution.recording.qpos), scene("jido")
    moving = np.flatnonzero(np.ptp(qpos, axis=0) > 1e-9)
    robot, taker = room.agent("R"), room.agent("P2")
    robots = {*range(robot.base.start, robot.base.stop), *robot.joints.values()}
    takers = {taker.joints[name] for name in taker.joints if "hip" not in name and "knee" not in name}
    cup = room.object_slice("cup")
    assert set(moving.tolist()) <= robots | takers | set(range(cup.start, cup.stop))
    assert {hold.agent for hold in found.execution.holds[-1]} == {"P2"}


def test_what_is_given_is_held_by_nobody_else_in_the_end() -> None:
    (found,) = performed("jido", "give").performances
    stage = Stage(scene("jido"), found.execution.recording.state(-1))
    assert "cup" not in {hold.object for hold in found.execution.holds[0]}
    assert stage.scene.agent("P2").name == found.plan.target


def test_the_same_request_has_the_same_plan() -> None:
    first = performed("jido", "hide").performances[0].execution.recording
    again = perform(scene("jido"), Request(clause("hide"), "R", "P2", "cup")).performances[0].execution.recording
    assert np.array_equal(first.qpos, again.qpos)


def test_different_ways_end_at_different_places() -> None:
    outcome = perform(scene("jido"), Request(clause("put away"), "R", "P2", "cup"), ways=2)
    one, other = (found.plan.candidate.pose[:3] for found in outcome.performances)
    assert np.linalg.norm(one - other) > 0.03


def test_sentences_say_what_was_chosen() -> None:
    (found,) = performed("jido", "put away").performances
    assert chosen(found.plan).startswith(f"R puts the cup on the {found.plan.candidate.carrier}, its middle at (")
    assert steps(found.plan)[0].startswith("drives to the cup (")


def test_what_cannot_be_is_told_at_once() -> None:
    nobody = Clause("lift", (Literal("motion.status.2", "Object_Final_Motion_Status", v.MOVING, 2),))
    outcome = perform(scene("jido"), Request(nobody, "R", "P2", "cup"))
    assert not outcome.performances
    assert outcome.search.places == 0
    told = refused(outcome.request, outcome.goal, outcome.search, outcome.spoiled, STANDARD_TREE)
    assert told == ("what is performed ends at rest: (Object_Final_Motion_Status = Moving) cannot be",)


def test_a_refusal_counts_every_place_once() -> None:
    outcome = perform(scene("jido"), Request(clause("hide"), "R", "P2", "cup", allow=("white_box",)))
    search = outcome.search
    assert not outcome.performances
    assert search.places == sum(search.missed.values()) + search.out_of_hand + search.unknown + search.wanted
    assert search.tried == sum(search.refusals.values()) + len(outcome.spoiled)
    told = refused(outcome.request, outcome.goal, search, outcome.spoiled, STANDARD_TREE)
    assert told[0] == f"{search.wanted} of {search.places} places would do"
    assert "sees next to nothing" in told[1]


# --- Clauses of sets of values, as whole clauses have them, and usual circumstances.


def among(node: str, *values: str, but: bool = False, bound: str = "") -> SetLiteral:
    found = STANDARD_TREE.node(node)
    return SetLiteral(found.name, found.title, values, but, bound, instant=found.instant)


ON_SUPPORT, MOVING = among("placement.status.2", v.ON_SUPPORT), among("motion.status.2", v.MOVING)
HARDER_TO_SEE = (
    among("placement.status.2", v.IN_HAND, but=True),
    among("hands.class", v.MANIP_GAINED, but=True),
    among("see.effort.2", *v.SEE_EFFORTS[2:], bound="≥"),
)


def test_sets_of_values_are_performed_and_usual_circumstances_respected() -> None:
    meaning = Clause("hide", HARDER_TO_SEE, usual=(ON_SUPPORT, MOVING), rule="bayes")
    outcome = perform(scene("jido"), Request(meaning, "R", "P2", "cup"))
    (found,) = outcome.performances
    nodes = found.explanation.nodes
    assert found.audit.clean
    assert found.strict is True
    assert nodes["see.effort.2"].value in v.SEE_EFFORTS[2:]
    assert nodes["placement.status.2"].value == v.ON_SUPPORT
    assert found.circumstances == {ON_SUPPORT: True, MOVING: False}
    assert outcome.goal.controllable == HARDER_TO_SEE
    (dropped,) = outcome.dropped
    assert not_had(outcome.dropped, STANDARD_TREE) == (
        f"in all demonstrations the object ends moving, which is not asked for here: {dropped.why}",
    )
    told = (
        "for P2, as in all demonstrations the object ends on a support; "
        "otherwise than in all demonstrations, where the object ends moving"
    )
    assert as_shown(found.circumstances, ("P2",), STANDARD_TREE) == told
    assert found.plan.clause == meaning


def test_other_planners_are_told_what_it_is_about(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("taskgist.planning.pddl.MOST", 20)
    meaning = Clause("hide", HARDER_TO_SEE, usual=(ON_SUPPORT,), rule="bayes")
    request = Request(meaning, "R", "P2", "cup", allow=("white_box",), means=("move",))
    told = OneByOne(scene("jido"), scene("jido").initial, request).pddl().problem
    assert told.isascii()
    assert told.startswith(
        "; Task(hide) <- by whole clauses\n;   (Object_Final_Status != In_Hand)\n"
        ";   (Relative_Hand_Status != Manip_Gained)\n;   (Effort_to_See >= Head_Torso_Effort)\n"
        ";   usually (Object_Final_Status = On_Support)\n(define "
    )


def test_usual_circumstances_are_left_where_nothing_is_found_with_them() -> None:
    """There is no container here."""
    inside = among("placement.status.2", v.INSIDE_CONTAINER)
    meaning = Clause("put away", (among("reach.class", v.BECOMES_DIFFICULT),), usual=(inside,))
    outcome = perform(scene("jido"), Request(meaning, "R", "P2", "cup", means=("move",)))
    (found,) = outcome.performances
    assert found.strict is True
    assert found.circumstances == {inside: False}
    assert [(each.literal, each.why) for each in outcome.dropped] == [(inside, "no way was found in which it is so")]
    assert not outcome.goal.circumstances


def test_what_was_always_so_is_left_before_what_is_usual() -> None:
    inside, free = among("placement.status.2", v.INSIDE_CONTAINER), among("hands.status.2", v.FREE_OF_OBJECT)
    meaning = Clause("put away", (among("reach.class", v.BECOMES_DIFFICULT),), usual=(free,), always=(inside,))
    outcome = perform(scene("jido"), Request(meaning, "R", "P2", "cup", means=("move",)))
    assert outcome.goal.circumstances == (free,)
    assert [each.literal for each in outcome.dropped] == [inside]
    assert outcome.performances[0].circumstances == {free: True, inside: False}


def watched_searches(monkeypatch: pytest.MonkeyPatch) -> list[OneByOne]:
    searches, plans = list[OneByOne](), OneByOne.plans

    def watched(self: OneByOne, progress: Progress) -> Iterator[Plan]:
        searches.append(self)
        return plans(self, progress)

    monkeypatch.setattr(OneByOne, "plans", watched)
    return searches


def test_circumstances_are_left_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is harder to reach is not grasped without effort: only that is left, though most places are not hidden."""
    hidden, at_hand = among("visibility.score.2", NEGLIGIBLE), among("grasp.effort.2", v.REACH_EFFORTS[0])
    harder = among("reach.class", v.BECOMES_DIFFICULT)
    meaning = Clause("put away", (harder,), usual=(ON_SUPPORT,), always=(hidden, at_hand))
    monkeypatch.setattr("taskgist.planning.planner.MOST_PLACES", 300)
    searches = watched_searches(monkeypatch)
    outcome = perform(scene("jido"), Request(meaning, "R", "P2", "cup", means=("move",)))
    (found,) = outcome.performances
    assert found.circumstances == {ON_SUPPORT: True, hidden: True, at_hand: False}
    assert [(each.literal, each.why) for each in outcome.dropped] == [(at_hand, performing.NONE_BESIDE)]
    first, _ = (each.search for each in searches)
    assert first.refused_by(hidden) > first.refused_by(at_hand) > 0
    assert first.wanted == 0


def test_where_it_ends_is_left_last_and_searches_are_few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("taskgist.planning.planner.MOST_PLACES", 20)
    in_hand, hidden = among("placement.status.2", v.IN_HAND), among("visibility.score.2", NEGLIGIBLE)
    seen, far = among("see.effort.2", v.SEE_EFFORTS[0]), among("reach.effort.2", v.REACH_EFFORTS[3])
    nowhere = among("grasp.effort.2", v.REACH_EFFORTS[-1])
    meaning = Clause("put away", (nowhere,), usual=(in_hand,), always=(hidden, seen, far))
    searches = watched_searches(monkeypatch)
    monkeypatch.setattr(OneByOne, "helps", lambda _: ())
    outcome = perform(scene("jido"), Request(meaning, "R", "P2", "cup", allow=("white_box",), means=("move",)))
    assert not outcome.performances
    kept = [each.goal.circumstances for each in searches]
    assert kept == [(in_hand, hidden, seen, far), (in_hand, seen, far), (in_hand, seen), (in_hand,), ()]
    assert [each.literal for each in outcome.dropped] == [hidden, far, seen, in_hand]
    assert len(searches) <= performing.LEFT_ONE_BY_ONE + 3


def test_a_set_that_fails_everywhere_is_told_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("taskgist.planning.planner.MOST_PLACES", 100)
    meaning = Clause("hide", HARDER_TO_SEE)
    outcome = perform(scene("jido"), Request(meaning, "R", "P2", "cup", allow=("white_box",), means=("move",)))
    assert not outcome.performances
    told = refused(outcome.request, outcome.goal, outcome.search, outcome.spoiled, STANDARD_TREE)
    said = "seeing the object takes turning head and torso afterwards, or more, or is not possible"
    assert f"it fails that {said}, the nearest with effort level" in told[1]


@cache
def table_for_two() -> Scene:
    people = (Person("P1", 1.75, (-0.67, 0.2), 0.0), Person("P2", 1.7, (0.75, 0.0), math.pi))
    return Room("room", people, (on_table("cup", -0.1, 0.3), on_table("white_box", 0.05, -0.2)), TABLE).scene()


@pytest.mark.parametrize("task", ["give", "hide"])
def test_so_does_a_person(task: str) -> None:
    (found,) = perform(table_for_two(), Request(clause(task), "P1", "P2", "cup")).performances
    assert found.audit.clean
    assert found.strict is True


def test_a_person_who_stands_reaches_across() -> None:
    """An upper arm is pressed against the chest, as flesh lets it."""
    people = (Person("P1", 1.75, (-0.75, 0.2), 0.0, "standing"), Person("P2", 1.7, (0.75, 0.0), math.pi))
    room = Room("room", people, (Thing("cup", (0.05,) * 3, (-0.1, 0.3, TABLE.height_m)),), TABLE).scene()
    (found,) = perform(room, Request(clause("make accessible"), "P1", "P2", "cup")).performances
    assert found.audit.clean
    assert found.strict is True


@pytest.mark.parametrize("performer", ["P1", "R"])
def test_things_slip_softly_in_the_hands_of_people_who_perform(performer: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not in those of a robot, nor of whoever takes something from them."""
    asked = dict[str, object]()

    def watched(*args: object, **given: object) -> Audit:
        asked.update(given, moving=args[4])
        return audit(*args, **given)  # type: ignore[arg-type]

    monkeypatch.setattr(performing, "audit", watched)
    room = table_for_two() if performer == "P1" else scene("jido")
    assert perform(room, Request(clause("give"), performer, "P2", "cup")).performances
    assert asked["soft"] == [name for name in ("P1",) if name == performer]
    assert list(asked["moving"]) == [performer, "P2"]  # type: ignore[call-overload]


def test_without_planners_it_says_so_before_robots_are_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Who performs, or may help: not where people do all by themselves."""

    def missing(name: str) -> object:
        raise ModuleNotFoundError(name=name)

    people = (Person("P1", 1.75, (-0.67, 0.2), 0.0), Person("P2", 1.7, (0.75, 0.0), math.pi))
    robot = Person("R", 1.5, (0.0, -2.0), math.pi / 2, "standing", profile="jido")
    scene = Room("room", (*people, robot), (on_table("cup", -0.1, 0.3),), TABLE).scene()
    request = Request(clause("make accessible"), "P1", "P2", "cup")
    monkeypatch.setattr(extras, "importlib", type("none", (), {"import_module": staticmethod(missing)}))
    install = r"ompl is not installed; install it: pip install 'taskgist\[planning\]'"
    for asked in (replace(request, performer="R"), request, replace(request, helpers=("R",))):
        with pytest.raises(InputError, match=install):
            perform(scene, asked)
    for alone in (replace(request, helpers=()), replace(request, means=("move",))):
        assert perform(scene, alone).performances


def test_a_person_does_not_get_to_the_sideboard(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("taskgist.planning.planner.MOST_PLACES", 100)
    outcome = perform(table_for_two(), Request(clause("put away"), "P1", "P2", "cup", allow=("sideboard",)))
    assert not outcome.performances
    assert outcome.search.tried == 0
    assert outcome.search.out_of_reach == outcome.search.wanted > 0
