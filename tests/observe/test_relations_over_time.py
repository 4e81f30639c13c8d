"""Relations over time: what approaches what, what is only glimpsed, and what shipped recordings show."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from taskgist.errors import UnknownNameError
from taskgist.observe import Interval, Observer, RelationsOverTime, relations_of
from taskgist.world import Scene, Stage, State
from tests.observe.states import States
from tests.shipped import observer, recording
from tools.rooms import Person, Room, Thing

RATE_HZ = 20
BALL = Thing("ball", (0.1,), (4.0, 0.0, 1.2), "sphere")
Places = Callable[[float], tuple[float, float]]


def scene(*things: Thing) -> Scene:
    return Room(things or (BALL,), (Person("P1", (0.0, 0.0)), Person("P2", (4.0, 2.0), -math.pi / 2))).scene()


def moving(there: Scene, seconds: float, person: Places | None = None, ball: Places | None = None) -> list[State]:
    """States in which P1, or the ball, is moved to a place of the floor at each time."""
    states = []
    for time_s in np.arange(0.0, seconds, 1 / RATE_HZ):
        state = State(there.initial.qpos, float(time_s))
        for at, place in ((there.base_slice("P1"), person), (there.object_slice("ball"), ball)):
            if place is not None:
                state = state.replace(at=slice(at.start, at.start + 2), to=place(float(time_s)))
        states.append(state)
    return states


def over(there: Scene, states: list[State]) -> RelationsOverTime:
    frames = States(states)
    return RelationsOverTime(Observer(there, frames), frames)


def told(found: tuple[Interval[str | bool | None], ...]) -> list[str | bool | None]:
    return [each.value for each in found]


def walk(time_s: float) -> tuple[float, float]:
    """Stands for a second, walks ahead for two at 1 m/s, and stands again."""
    return min(max(time_s - 1.0, 0.0), 2.0), 0.0


def test_who_walks_towards_a_thing_approaches_it_from_start_to_end() -> None:
    there = scene()
    found = over(there, moving(there, 4.5, walk)).of("P1", "ball")
    assert told(found["approaching"]) == [False, True, False]
    assert found["approaching"][1].start_s == pytest.approx(1.0, abs=0.2)
    assert found["approaching"][1].end_s == pytest.approx(3.0, abs=0.3)
    assert told(found["distance"]) == ["far"]


def test_nobody_approaches_what_they_leave_pass_by_carry_or_are_brought() -> None:
    there = scene()

    def back(time_s: float) -> tuple[float, float]:
        return -walk(time_s)[0], 0.0

    def around(time_s: float) -> tuple[float, float]:
        return 4.0 - 2.0 * math.cos(0.5 * time_s), 2.0 * math.sin(0.5 * time_s)

    def carried(time_s: float) -> tuple[float, float]:
        return walk(time_s)[0] + 0.4, 0.0

    def brought(time_s: float) -> tuple[float, float]:
        return 4.0 - walk(time_s)[0], 0.0

    for states in (
        moving(there, 4.0, back),
        moving(there, 3.0, around),
        moving(there, 4.0, walk, carried),
        moving(there, 4.0, None, brought),
    ):
        assert told(over(there, states).of("P1", "ball")["approaching"]) == [False]


def test_people_are_approached_too() -> None:
    there = scene()

    def to_you(time_s: float) -> tuple[float, float]:
        share = walk(time_s)[0] / 3.0
        return 4.0 * share, 2.0 * share

    found = over(there, moving(there, 4.5, to_you))
    assert told(found.of("P1", "ball")["approaching P2"]) == [False, True, False]
    assert told(found.of("P2", "ball")["approaching P1"]) == [False], "who is come to approaches nobody"


def test_swaying_is_no_approach() -> None:
    there = scene()

    def sway(time_s: float) -> tuple[float, float]:
        return 0.02 * math.sin(2 * math.pi * 0.5 * time_s), 0.0

    assert told(over(there, moving(there, 6.0, sway)).of("P1", "ball")["approaching"]) == [False]


def test_a_glance_that_does_not_last_is_no_look() -> None:
    there = scene(replace(BALL, place=(2.0, 0.0, 1.64)))
    pan = there.agent("P1").joints["head_pan"]

    def glances(seconds: float) -> list[State]:
        states = moving(there, 3.0)
        return [each if 1.0 <= each.time_s < 1.0 + seconds else each.replace({pan: 1.2}) for each in states]

    assert told(over(there, glances(0.1)).of("P1", "ball")["gaze"]) == ["nothing"]
    found = over(there, glances(0.5)).of("P1", "ball")
    assert told(found["gaze"]) == ["nothing", "ball", "nothing"]
    assert told(found["looked_at_by"]) == ["nobody", "P1", "nobody"]
    assert found["gaze"][1].start_s == pytest.approx(1.0, abs=0.06)


def test_what_was_not_tracked_for_a_while_is_unknown_then() -> None:
    there = scene()
    states = [each.without(["ball"]) if each.time_s >= 1.5 else each for each in moving(there, 3.0)]
    found = over(there, states).of("P1", "ball")
    for row in ("sight", "distance", "direction", "facing", "touching", "carried_by", "approaching"):
        assert found[row][-1].value is None, row
        assert found[row][0].value is not None, row


def test_live_says_the_same_as_the_whole_recording() -> None:
    there = scene(BALL)
    states = moving(there, 4.5, walk)
    watching = Observer(there)
    live = RelationsOverTime(watching)
    for state in states:
        watching.append(state)
        live.append(state)
        live.at("P1", "ball", state.time_s)
    watching.finish()
    live.finish()
    whole = over(there, states)
    assert live.of("P1", "ball") == whole.of("P1", "ball")
    for time_s in (0.5, 1.5, 2.5, 4.4):
        now = whole.at("P1", "ball", time_s)
        for row, found in whole.of("P1", "ball").items():
            assert now[row] == [each.value for each in found if each.start_s <= time_s][-1], row


def test_names_that_are_not_there_are_refused() -> None:
    there = scene()
    for agent, name in (("P3", "ball"), ("P1", "bull"), ("P1", "P2")):
        with pytest.raises(UnknownNameError):
            over(there, moving(there, 0.2)).of(agent, name)


def test_hidden_behind_the_box_it_is_out_of_sight() -> None:
    found = RelationsOverTime(observer("hide_a"), recording("hide_a")).of("P2", "cup")
    assert told(found["sight"])[0] == "free"
    assert told(found["sight"])[-1] == "blocked"
    assert "P1" in told(found["carried_by"])
    assert told(found["carried_by"])[-1] == "nobody"


def test_what_is_shown_both_look_at() -> None:
    found = RelationsOverTime(observer("show_a"), recording("show_a")).of("P2", "cup")
    assert "cup" in told(found["joint_attention P1"])
    assert told(found["sight"]) == ["free"]
    assert told(found["approaching"]) == [False]


def test_a_real_handover_is_carried_by_one_by_both_by_the_other() -> None:
    found = RelationsOverTime(observer("handover_1"), recording("handover_1")).of("P2", "baton")
    assert told(found["carried_by"]) == ["nobody", "P1", "P1, P2", "P2", "nobody"]
    assert told(found["touching"])[:2] == [False, True]


def test_rows_of_a_moment_are_those_over_time() -> None:
    there = scene()
    rows = relations_of(Stage(there), "P1", "ball")
    assert [*rows, "approaching", "approaching P2"] == list(over(there, moving(there, 0.5)).of("P1", "ball"))
    assert set(rows) >= {"facing P2", "mutual_gaze P2", "joint_attention P2"}
