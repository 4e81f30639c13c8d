"""Means besides moving the thing: it is covered, the way to it is cleared, another agent helps; and why not, else."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from functools import cache
from itertools import groupby, islice
from typing import Any

import mujoco
import numpy as np
import pytest

from taskgist.errors import InputError, UnknownNameError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.language.performing import chosen, refused, steps
from taskgist.performing.execution import phase_frames
from taskgist.performing.outputs import plan_document, robot_trajectory
from taskgist.pipeline.performing import Outcome, perform
from taskgist.planning.actions import Actions
from taskgist.planning.aims import aims_of
from taskgist.planning.endings import Endings
from taskgist.planning.judging import Reason
from taskgist.planning.plan import Action, Purpose
from taskgist.planning.requests import Request, Spared
from taskgist.planning.sequences import MOST_IN_ALL
from taskgist.settings import DEFAULT
from taskgist.world import Scene, State
from taskgist_lab.evaluation.performing.second_audit import second_audit
from taskgist_lab.generator.things import OpenBox
from taskgist_lab.simulator.room import TABLE, Person, Room, Table, Thing
from tests.bodies import needs
from tests.pipeline.test_performing import clause
from tests.schemas import hold_to_schema

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


@cache
def covered() -> Outcome:
    return perform(with_covers(), Request(clause("hide"), "R", "P2", "tape", means=("cover",)))


def test_a_thing_is_hidden_beneath_a_cover() -> None:
    scene = with_covers()
    (found,) = covered().performances
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


# --- Slid over an edge.

DISC = Thing("tape", (0.11, 0.035), (-0.1, 0.3, TOP))


@cache
def with_disc(profile: str = "jido") -> Scene:
    return Room("room", (robot("R", -1.6, profile=profile), P2), (DISC,), TABLE).scene()


@cache
def slid(profile: str = "jido") -> Outcome:
    return perform(with_disc(profile), Request(clause("show"), "R", "P2", "tape"))


@pytest.mark.parametrize("profile", ["jido", pytest.param("pr2", marks=needs("pr2"))])
def test_what_lies_flat_is_slid_over_an_edge_first(profile: str) -> None:
    scene, (found,) = with_disc(profile), slid(profile).performances
    slide, move = found.plan.actions
    assert (slide.purpose, slide.candidate.means, move.purpose) == ("slide", "slide_out", "move")
    assert found.audit.clean
    times_s, qpos = found.execution.recording.times_s, np.array(found.execution.recording.qpos)
    assert second_audit(scene, "R", "tape", times_s, qpos, found.execution.holds) == ()
    assert found.strict is True
    assert all(settled.stays for settled in found.execution.settled), "it does not tip over the edge"
    assert chosen(found.plan).startswith("R slides the tape out over an edge of the table, its middle at (")
    assert "presses its fingers on the tape (" in " ".join(steps(found.plan))
    assert "slides the tape (" in " ".join(steps(found.plan))
    hold_to_schema("perform_plan", plan_document(found.plan, found.execution))


def test_fingers_press_on_what_they_slide_and_draw_it_straight_out() -> None:
    """By MuJoCo's distances alone: the hand touches the thing and nothing of it is below the thing's top."""
    scene, (found,) = with_disc(), slid().performances
    action, column = found.plan.actions[0], scene.object_slice("tape")
    (rows,) = (phase.qpos for phase in action.phases if phase.name == "slide")
    model, data = scene.model, mujoco.MjData(scene.model)
    hand, thing = scene.agent("R").arm(action.side).hand_geoms, scene.solid_geoms_of("tape")
    way = rows[-1, column][:2] - rows[0, column][:2]
    for row in rows:
        data.qpos[:] = row
        mujoco.mj_kinematics(model, data)
        apart_m = min(mujoco.mj_geomDistance(model, data, a, b, 0.1, None) for a in hand for b in thing)
        assert -0.002 < apart_m < 0.003
        lowest = min(mujoco.mj_geomDistance(model, data, a, scene.solid_geoms_of("table")[0], 0.1, None) for a in hand)
        assert lowest > DISC.height_m - 0.002, "above the thing's top"
        moved = row[column][:2] - rows[0, column][:2]
        assert abs(moved[0] * way[1] - moved[1] * way[0]) < 0.001 * np.linalg.norm(way)
        assert np.abs(row[column][2:] - rows[0, column][2:]).max() < 0.001
    half = np.array(TABLE.size_m[:2]) / 2
    out_m = float((np.abs(rows[-1, column][:2] - TABLE.centre_m) - half).max()) + 0.11 / 2
    assert 0.02 < out_m < 0.11 / 2, "it sticks out, and its middle is over the table"


def test_what_cannot_be_slid_is_told() -> None:
    """Things stand all around it, so that no edge is got to."""
    walls = [
        Thing(f"wall {n}", (0.04, 0.2, 0.2), (-0.1 + x, 0.3 + y, TOP), yaw)
        for n, (x, y, yaw) in enumerate(
            [(0.12, 0.0, 0.0), (-0.12, 0.0, 0.0), (0.0, 0.14, math.pi / 2), (0.0, -0.14, math.pi / 2)]
        )
    ]
    scene = Room("room", (robot("R", -1.6), P2), (DISC, *walls), TABLE).scene()
    outcome = perform(scene, Request(clause("show"), "R", "P2", "tape", means=("move", "slide")))
    assert "slid" not in why_not(outcome)
    assert "R cannot grasp the tape" in why_not(outcome)


@pytest.mark.parametrize("high_m", [0.003, 0.012])
def test_nothing_is_slid_over_an_object_which_would_be_drawn_along(high_m: float) -> None:
    """Of a disc on a sheet, and on a tray, whose edges are no edges of what stays where it is."""
    tray = Thing("tray", (0.3, 0.3, high_m), (-0.15, 0.3, TOP))
    disc = replace(DISC, position_m=(-0.15, 0.3, TOP + high_m))
    scene = Room("room", (robot("R", -1.6), P2), (tray, disc), TABLE).scene()
    told = why_not(perform(scene, Request(clause("show"), "R", "P2", "tape", means=("move", "slide"))))
    why = "the tape lies on the tray, which would be drawn along"
    assert f"R slides the tape out over an edge, R brings the tape there: {why}" in told


def test_nothing_is_slid_by_a_robot_that_is_not_to_slide() -> None:
    scene = with_disc()
    outcome = perform(scene, Request(clause("show"), "R", "P2", "tape", means=("move", "cover", "relay")))
    told = "R cannot pick the tape up: the tape would have to be slid over the edge before it is grasped"
    assert why_not(outcome) == told
    alone = perform(scene, Request(clause("show"), "R", "P2", "tape", means=("slide",)))
    assert why_not(alone) == "what is slid out over an edge must be brought somewhere, too"


def test_why_not_where_no_means_could_even_be_tried() -> None:
    scene = Room("room", (robot("R", -1.6), P2), (IT,), TABLE).scene()
    outcome = perform(scene, Request(clause("hide"), "R", "P2", "tape", means=("cover", "clear", "relay")))
    assert why_not(outcome) == (
        "there is nothing to cover the tape with; nothing is in the way that could be cleared; "
        "there is nobody who could help"
    )


@pytest.mark.parametrize("name", ["R", "P2"])
def test_who_takes_part_already_is_no_helper(name: str) -> None:
    with pytest.raises(InputError, match=rf"helpers: takes part already \(got '{name}'\)"):
        Request(clause("hide"), "R", "P2", "tape", helpers=(name,))


def test_people_are_told_by_their_names() -> None:
    """Of a disc in a lap."""
    scene = Room("room", (robot("R", -1.6), P2), (replace(DISC, position_m=(0.45, 0.0, 0.62)),), TABLE).scene()
    told = why_not(perform(scene, Request(clause("show"), "R", "P2", "tape", means=("move",))))
    assert "are blocked by P2;" in told


def test_a_literal_that_fails_by_another_means_is_told_in_words() -> None:
    scene = with_disc()
    told = why_not(perform(scene, Request(clause("hide"), "R", "P2", "tape", means=("move", "slide"))))
    assert "R brings the tape there: it fails that it sees next to nothing of the object afterwards" in told


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


def test_what_is_cleared_goes_where_things_may_go() -> None:
    """What is preferred comes first; what is not allowed never, though a thing may stay on what it is on already."""
    shelf, bench = Table("shelf", (-2.2, 1.2), (0.4, 1.0, TOP)), Table("bench", (-2.2, -1.2), (0.4, 1.0, TOP))
    scene = Room("room", (robot("R", -1.6), P2), (IT, screen(0.04)), TABLE, (shelf, bench)).scene()
    request = Request(clause("show"), "R", "P2", "tape", means=("clear",), prefer=("shelf",))
    (found,) = perform(scene, request).performances
    assert (found.plan.actions[0].thing, found.plan.candidate.carrier) == ("screen", "shelf")

    def carriers(asked: Request) -> set[str]:
        aims = aims_of(scene, scene.initial, asked.clause, ["P2"], "tape", STANDARD_TREE, DEFAULT)
        put = Endings(scene, scene.initial, asked, aims, DEFAULT, ()).put(scene.initial, "R", "screen")
        return {candidate.carrier for candidate in islice(put, 60)}

    anywhere = replace(request, prefer=())
    assert carriers(anywhere) >= {"table", "shelf", "bench"}
    assert carriers(replace(anywhere, allow=("shelf",))) == {"table", "shelf"}
    with pytest.raises(UnknownNameError, match="no support 'shelve'; did you mean 'shelf'"):
        perform(scene, replace(request, allow=("shelve",)))


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


def test_what_stands_on_the_thing_is_cleared_before_it_is_moved() -> None:
    """A thin plate with a small block on it, which would be left in the air: it is told before any place is judged."""
    plate, block = (
        Thing("tape", (0.06, 0.05, 0.03), (-0.1, 0.3, TOP)),
        Thing("block", (0.04, 0.04, 0.04), (-0.1, 0.3, TOP + 0.03)),
    )
    scene = Room("room", (robot("R", -1.6), P2), (plate, block), TABLE).scene()
    request = Request(clause("give"), "R", "P2", "tape", means=("move",))
    alone = perform(scene, request)
    assert why_not(alone) == "on the tape, or in it, there is the block"
    assert alone.search.places == 0
    (found,) = perform(scene, replace(request, means=("move", "clear"))).performances
    assert [(each.purpose, each.thing) for each in found.plan.actions] == [("clear", "block"), ("move", "tape")]


@cache
def cleared() -> Outcome:
    request = Request(clause("make accessible"), "R", "P2", "tape", means=("clear",))
    return perform(beneath_a_laden_dome(0.05), request)


def test_what_lies_on_what_is_in_the_way_is_cleared_before_that() -> None:
    (found,) = cleared().performances
    assert [(each.purpose, each.thing) for each in found.plan.actions] == [("clear", "book"), ("clear", "dome")]
    assert found.audit.clean
    assert found.strict is True


def test_why_nothing_is_cleared_that_carries_what_no_hand_takes() -> None:
    outcome = perform(beneath_a_laden_dome(0.12), Request(clause("give"), "R", "P2", "tape", means=("move", "clear")))
    told = why_not(outcome)
    assert "R cannot grasp the tape: shut in by dome and table" in told
    assert "R clears the dome out of the way, R brings the tape there: on the dome, or in it, there is the book" in told
    assert "R clears the book out of the way" in told
    assert "R does not get hold of the book" in told


# --- Helped.


@cache
def parted(thing_m: float = 0.05) -> Scene:
    """A counter that nobody gets around parts the room; the shelf is on the other side."""
    counter, shelf = Table("counter", (0.0, 0.0), (1.2, 19.0, TOP)), Table("shelf", (2.2, 1.2), (0.4, 1.0, TOP))
    people = (
        robot("R1", -1.6),
        robot("R2", 1.6, 0.8, math.pi),
        replace(P2, position_m=(1.0, -0.6), posture="standing"),
    )
    things = (
        Thing("tape", (thing_m,) * 3, (-0.45, 0.2, TOP)),
        Thing("screen", (0.3, 0.06, 0.3), (2.2, 1.2, TOP)),
    )
    return Room("room", people, things, counter, (shelf,)).scene()


@cache
def relayed() -> Outcome:
    return perform(parted(), Request(clause("hide"), "R1", "P2", "tape", allow=("shelf",), means=("relay",)))


def test_another_robot_brings_a_thing_where_the_performer_does_not_get() -> None:
    (found,) = relayed().performances
    one, other = found.plan.actions
    assert [(each.performer, each.purpose, each.thing) for each in (one, other)] == [
        ("R1", "relay", "tape"),
        ("R2", "move", "tape"),
    ]
    assert (one.candidate.carrier, other.candidate.carrier) == ("counter", "shelf")
    assert found.audit.clean
    assert found.strict is True
    assert dict(found.plan.cost.efforts) == {"R1": 4, "R2": 4}
    assert found.plan.cost.total == 2 + 8 / 5
    assert "m, where R2 takes it; then R2 puts the tape on the shelf" in chosen(found.plan)
    assert [step for step in steps(found.plan) if step.startswith("R2 ")] == [steps(found.plan)[len_of(one)]]


def test_a_way_is_given_up_before_every_place_in_between_was_tried_with_every_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tried, plan = Counter[str](), Actions.plan

    def planned(
        actions: Actions, state: State, name: str, purpose: Purpose, *rest: Any, **more: Any
    ) -> Action | Reason:
        tried[purpose] += 1
        return "no" if purpose == "move" else plan(actions, state, name, purpose, *rest, **more)

    monkeypatch.setattr(Actions, "plan", planned)
    request = Request(clause("hide"), "R1", "P2", "tape", allow=("shelf",), means=("relay",))
    assert "R1 brings the tape to where R2 takes it, R2 brings the tape there: no" in why_not(
        perform(parted(), request)
    )
    assert tried["relay"] > 1
    assert tried["move"] > tried["relay"]
    assert tried.total() <= MOST_IN_ALL + 1


def len_of(action: Action) -> int:
    return len([name for name, _ in groupby(action.phases, key=lambda phase: phase.name)])


def test_one_acts_after_the_other_and_gives_way() -> None:
    (found,) = relayed().performances
    recording = found.execution.recording
    qpos, frames = np.array(recording.qpos), phase_frames(found.plan)
    switch = frames[len(found.plan.actions[0].phases)].start
    for name, there in (("R1", slice(switch, None)), ("R2", slice(None, switch))):
        agent = recording.scene.agent(name)
        columns = np.r_[agent.base, sorted(agent.joints.values())]
        assert np.ptp(qpos[there][:, columns], axis=0).max() < 1e-9, name
    base = recording.scene.agent("R1").base
    assert np.linalg.norm(qpos[switch, base][:2] - qpos[0, base][:2]) < 0.01, "back where it was"


def test_documents_tell_of_both() -> None:
    (found,) = relayed().performances
    plan, trajectory = plan_document(found.plan, found.execution), robot_trajectory(found.plan, found.execution)
    hold_to_schema("perform_plan", plan)
    hold_to_schema("perform_trajectory", trajectory)
    assert [each["performer"] for each in plan["actions"]] == ["R1", "R2"]
    ends = [each["phases"][-1]["end_s"] for each in plan["actions"]]
    assert plan["actions"][1]["phases"][0]["start_s"] == ends[0] < ends[1]
    (helper,) = trajectory["helpers"]
    assert (trajectory["robot"], helper["robot"]) == ("R1", "R2")
    assert len(helper["base_trajectory"]["points"]) > 10


def test_why_nobody_helps() -> None:
    request = Request(clause("hide"), "R1", "P2", "tape", allow=("shelf",), means=("relay",))
    nobody = perform(parted(), replace(request, helpers=()))
    assert not nobody.performances
    assert not nobody.search.others
    told = why_not(perform(parted(0.12), request))
    assert "R1 brings the tape to where R2 takes it, R2 brings the tape there: R1 does not get hold of the tape" in told
    assert "R2 brings the tape to where R1 takes it, R1 brings the tape there: R2 does not get hold of the tape" in told


@cache
def corner() -> Scene:
    """The same counter; behind it a person in a corner, who gets at both the counter and a shelf, and walks nowhere."""
    counter, shelf = Table("counter", (0.0, 0.0), (0.8, 19.0, TOP)), Table("shelf", (1.0, 0.72), (1.0, 0.5, TOP))
    people = (
        robot("R1", -1.6),
        Person("P3", 1.75, (0.8, 0.0), 0.75 * math.pi, "standing"),
        Person("P2", 1.7, (1.2, 2.2), -0.5 * math.pi, "standing"),
    )
    things = (Thing("tape", (0.05, 0.05, 0.05), (-0.2, 0.2, TOP)), Thing("screen", (0.4, 0.03, 0.3), (0.9, 0.85, TOP)))
    return Room("room", people, things, counter, (shelf,)).scene()


def test_a_person_who_is_named_carries_on_what_a_robot_hands_over() -> None:
    request = Request(clause("hide"), "R1", "P2", "tape", allow=("shelf",), means=("relay",), helpers=("P3",))
    (found,) = perform(corner(), request).performances
    one, other = found.plan.actions
    assert [(each.performer, each.purpose, each.candidate.means) for each in (one, other)] == [
        ("R1", "relay", "hand_over"),
        ("P3", "move", "put_on"),
    ]
    assert one.taker == "P3"
    assert other.candidate.carrier == "shelf"
    assert found.audit.clean
    assert found.strict is True
    holders = [tuple(sorted(hold.agent for hold in holds)) for holds, _ in groupby(found.execution.holds)]
    assert holders == [(), ("R1",), ("P3", "R1"), ("P3",), ()]
    assert "m, where P3 takes it; then P3 puts the tape on the shelf" in chosen(found.plan)


def test_people_help_only_if_they_are_named() -> None:
    request = Request(clause("hide"), "R1", "P2", "tape", allow=("shelf",), means=("relay",))
    outcome = perform(corner(), request)
    assert not outcome.performances
    assert not outcome.search.others


@cache
def with_a_person() -> Scene:
    """The counter of ``parted``, with a person on this side instead of a robot."""
    counter, shelf = Table("counter", (0.0, 0.0), (0.8, 19.0, TOP)), Table("shelf", (2.0, 1.2), (0.4, 1.0, TOP))
    people = (
        Person("P1", 1.75, (-0.7, 0.1), 0.0, "standing"),
        robot("R2", 1.4, 0.8, math.pi),
        replace(P2, position_m=(0.8, -0.6), posture="standing"),
    )
    things = (Thing("tape", (0.05, 0.05, 0.05), (-0.2, 0.2, TOP)), Thing("screen", (0.3, 0.06, 0.3), (2.0, 1.2, TOP)))
    return Room("room", people, things, counter, (shelf,)).scene()


def test_a_robot_carries_on_what_a_person_puts_down() -> None:
    request = Request(clause("hide"), "P1", "P2", "tape", allow=("shelf",), means=("relay",))
    (found,) = perform(with_a_person(), request).performances
    assert [(each.performer, each.candidate.carrier) for each in found.plan.actions] == [
        ("P1", "counter"),
        ("R2", "shelf"),
    ]
    assert found.audit.clean
    assert found.strict is True


# --- Whose effort (Fig. 2): at a wide table one of them has to bend, or both.


@cache
def across(deep_m: float) -> Scene:
    half_m = deep_m / 2
    people = (
        Person("P1", 1.75, (-half_m - 0.3, 0.0), 0.0),
        Person("P2", 1.7, (half_m + 0.3, 0.0), math.pi),
    )
    cup = Thing("cup", (0.08, 0.10), (0.2 - half_m, 0.25, TOP))
    return Room("room", people, (cup,), Table("table", (0.0, 0.0), (deep_m, 1.4, TOP))).scene()


@pytest.mark.parametrize(
    ("deep_m", "spare", "efforts"),
    [
        (1.3, "performer", {"P1": 1, "P2": 3}),  # b: the giver stretches an arm, the taker stands up and leans
        (1.1, "target", {"P1": 2, "P2": 1}),  # c: the giver leans
        (1.3, "both", {"P1": 2, "P2": 2}),  # d: both lean
    ],
)
def test_who_bends_can_be_chosen(deep_m: float, spare: Spared, efforts: dict[str, int]) -> None:
    request = Request(clause("make accessible"), "P1", "P2", "cup", allow=("table",), spare=spare)
    (found,) = perform(across(deep_m), request).performances
    assert dict(found.plan.cost.efforts) == efforts
    assert found.plan.cost.total == pytest.approx(1 + sum(efforts.values()) / 5)
    assert found.strict is True
