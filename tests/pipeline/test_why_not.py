"""Rooms in which a task cannot be performed: each of five kinds is told by what is in the way, and what would help."""

from __future__ import annotations

import math
from dataclasses import replace

import mujoco
import pytest

from taskgist.facts.standard import STANDARD_TREE
from taskgist.language.performing import refused, would_help
from taskgist.language.phrases import phrase_of
from taskgist.pipeline.performing import Outcome, perform
from taskgist.planning.actions import Actions, WhyNot
from taskgist.planning.endings import Endings
from taskgist.planning.helping import Help
from taskgist.planning.judging import EndFails
from taskgist.planning.requests import Request
from taskgist.settings import DEFAULT
from taskgist.world import Scene, State
from tests.pipeline.test_performing import clause
from tests.planning.rooms import TABLE_M, box, cover, table
from tools.rooms import Person, Room, Thing

WIDE_TABLE = Thing("table", (1.0, 1.2, 0.02), (1.9, 0.0, TABLE_M - 0.02), free=False)
TABLE = table("table", 1.7)
TRAY = Thing("tray", (0.03, 0.03, 0.005), (1.5, 0.0, TABLE_M + 0.005), free=False)


def screen(x: float, y: float = 0.0, width: float = 0.25) -> Thing:
    return Thing("screen", (0.02, width, 0.10), (x, y, TABLE_M + 0.10))


def wall(name: str, x: float, y: float, depth: float, width: float) -> Thing:
    return Thing(name, (depth, width, 0.4), (x, y, 0.4), free=False)


def room(*things: Thing, target_at: float = 2.6, people: tuple[Person, ...] = ()) -> Scene:
    """Jido before a table, and somebody who stands behind it, among others."""
    people = (Person("R", (0.0, 0.0), 0.0, profile="jido"), Person("P2", (target_at, 0.0), math.pi), *people)
    built = Room(things, people)
    spec = mujoco.MjSpec.from_string(built.files()["room.xml"].decode())
    return Scene.from_spec(spec, [person.entry() for person in built.people])


def asked(scene: Scene, task: str, **request: object) -> Outcome:
    return perform(scene, Request(clause(task), "R", "P2", "box", means=("move",), **request))  # type: ignore[arg-type]


def told(outcome: Outcome) -> tuple[str, ...]:
    assert not outcome.performances
    return refused(outcome.request, outcome.goal, outcome.search, outcome.spoiled, STANDARD_TREE)


def test_an_end_that_fails_with_the_robot_where_it_is_then_is_told_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    def why_not(_endings: Endings, _state: State, agent: str) -> WhyNot:
        return lambda _end: EndFails(agent, clause("show").literals[0])

    monkeypatch.setattr(Endings, "why_not", why_not)
    monkeypatch.setattr("taskgist.planning.planner.MOST_TRIED", 1)
    outcome = asked(room(TABLE, box(1.5)), "show")
    said = phrase_of(STANDARD_TREE.node(clause("show").literals[0].node), clause("show").literals[0])
    why = f"with R where it is in the end, it fails that {said}"
    assert f"1 of the 1 that R tried it does not bring about: {why}" in told(outcome)


def test_nothing_hides_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("taskgist.planning.planner.MOST_PLACES", 140)
    outcome = asked(room(TABLE, box(1.7)), "hide", allow=("table",))
    first, second = told(outcome)
    assert first == "0 of 140 places would do"
    assert second.startswith(
        "at 140 of them it fails that it sees next to nothing of the object afterwards, the nearest"
    )
    assert not outcome.helps


def test_it_is_out_of_reach_for_everybody_already() -> None:
    outcome = asked(room(TABLE, box(1.7, 0.2), cover(1.7, 0.2)), "put away")
    assert told(outcome) == tuple(
        f"{ability} is at level 5 already: it cannot become more difficult" for ability in ("reach", "grasp")
    )
    assert outcome.search.places == 0


@pytest.mark.parametrize(
    ("things", "task", "reason"),
    [
        ((TABLE, box(1.7, 0.2, (0.12, 0.12, 0.12))), "show", "too wide (0.24 m > 0.08 m)"),
        ((table("board", 1.7, 0.0, 2.2), replace(box(1.7), place=(1.7, 0.0, 2.225))), "give", "beyond the arm"),
        (
            (
                *(TABLE, box(1.7, 0.2)),
                *(wall("ahead", 0.55, 0.0, 0.02, 0.6), wall("behind", -0.55, 0.0, 0.02, 0.6)),
                *(wall("left", 0.0, 0.6, 0.57, 0.02), wall("right", 0.0, -0.6, 0.57, 0.02)),
            ),
            "put away",
            "beyond the arm",
        ),
    ],
    ids=["too wide", "too high", "walled in"],
)
def test_the_robot_does_not_get_hold_of_it(things: tuple[Thing, ...], task: str, reason: str) -> None:
    """Which is asked first, before any place is looked for."""
    (sentence,) = told(outcome := asked(room(*things), task))
    assert sentence.startswith("R cannot grasp the box: ")
    assert reason in sentence
    assert outcome.search.places == 0


def test_what_is_said_to_bring_it_within_reach_does() -> None:
    outcome = asked(room(WIDE_TABLE, box(1.85), target_at=3.3), "put away")
    (found,) = outcome.helps
    assert (found.what, found.nearer, found.whom, found.so) == ("box", True, "R", "grasped")
    (said,) = would_help(outcome.helps)
    assert said == f"the box could be grasped if it stood {100 * found.shift_m:.0f} cm nearer to R"
    for shift_m, able in ((0.0, False), (found.shift_m - 0.02, False), (found.shift_m, True)):
        scene = room(WIDE_TABLE, box(1.85 - shift_m), target_at=3.3)
        assert (
            Actions(scene, scene.initial, DEFAULT, thing="box", target="P2").grasps(scene.initial, "R", "box") is able
        )


def test_what_is_said_to_hide_it_does() -> None:
    """A low screen hides a box from somebody who stands only if it stands near the box."""
    things = (TABLE, TRAY, box(1.45, 0.4))
    outcome = asked(room(*things, screen(1.8)), "hide", allow=("tray",))
    assert "the nearest with a score of" in told(outcome)[1]
    (found,) = outcome.helps
    assert found == Help("screen", found.shift_m, False, "P2", "place", "tray")
    assert would_help(outcome.helps)[0].endswith(f"the screen stood {100 * found.shift_m:.0f} cm farther from P2")
    assert asked(room(*things, screen(1.8 - found.shift_m)), "hide", allow=("tray",)).performances


def test_what_would_help_is_asked_of_each_target() -> None:
    """Somebody at the side sees nothing behind a block; it is the other, named last, from whom the screen must go."""
    block = Thing("block", (0.15, 0.02, 0.3), (1.5, 0.14, TABLE_M + 0.3), free=False)
    things = (TABLE, TRAY, block, box(1.45, 0.4), screen(1.8, width=0.1))
    scene = room(*things, people=(Person("P3", (1.6, 2.4), -math.pi / 2),))
    request = Request(clause("hide"), "R", "P3", "box", means=("move",), allow=("tray",), also_for=("P2",))
    (found,) = perform(scene, request).helps
    assert found == Help("screen", found.shift_m, False, "P2", "place", "tray")
