"""Rooms to perform in, what can be solved there, the second auditor, and what trials come to."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import mujoco
import numpy as np
import pytest

from taskgist.common.arrays import Array
from taskgist.common.files import keeping_inputs
from taskgist.errors import InputError
from taskgist.facts import vocabulary as v
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.values import NEGLIGIBLE
from taskgist.learning.understanding import Clause, Literal
from taskgist.perspective.effort import NO_KNOWN_LEVEL
from taskgist.perspective.image import visibility
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.planning.covering import covers
from taskgist.planning.plan import Purpose
from taskgist.world import Hold, Scene, Stage
from taskgist.world.contacts import overlaps
from taskgist_lab.evaluation.performing.means_rooms import TASK_OF, room_for
from taskgist_lab.evaluation.performing.rooms import ROBOT, TARGET, THING, room_to_perform_in
from taskgist_lab.evaluation.performing.second_audit import Fault, second_audit
from taskgist_lab.evaluation.performing.solvable import Solvable, solvable
from taskgist_lab.evaluation.performing.trials import (
    Share,
    Tally,
    Trial,
    TrialsFound,
    _keep,
    performed_trials,
    sheets,
    trial,
    tried,
)
from taskgist_lab.simulator.room import TABLE, Person, Room, Thing, on_table, right
from tests.planning.rooms import box, cover, table
from tools.performing_page import PAGE, parts
from tools.rooms import Person as Somebody
from tools.rooms import Room as PlainRoom

MARK = re.compile(r"^<!-- (?!end)(.+) -->$", re.MULTILINE)
DEVELOPED_ON = 5
"""Seed of the rooms that may be looked at."""


def literal(node: str, value: str) -> Literal:
    found = STANDARD_TREE.node(node)
    return Literal(found.name, found.title, value, found.instant)


PUT_AWAY = Clause(
    "put away",
    (literal("placement.status.2", v.ON_SUPPORT), literal("reach.class", v.BECOMES_DIFFICULT)),
)

PUT_DOWN = Clause("put down", (literal("placement.status.2", v.ON_SUPPORT),))

# --- Rooms.


@pytest.mark.parametrize("means", TASK_OF)
@pytest.mark.parametrize("number", range(3))
def test_rooms_for_means_are_made_for_them(means: Purpose, number: int) -> None:
    of = room_for(means, "jido", DEVELOPED_ON, number)
    stage = Stage(of)
    assert not {pair for pair in overlaps(stage, deeper_than_m=0.002) if THING in pair}
    if means == "cover":
        assert next(covers(stage, THING, "dome", ROBOT, TARGET), None) is not None
    elif means == "clear":
        found = visibility(stage, TARGET, THING)
        assert found is not None
        assert "carton" in {name for name, _ in found.occluders}
    else:
        efforts = SceneEfforts(stage)
        assert efforts.effort(ROBOT, THING, "grasp").level != NO_KNOWN_LEVEL
        assert efforts.effort(ROBOT, "screen", "reach").level == NO_KNOWN_LEVEL
        assert efforts.effort("R2", "screen", "reach").level != NO_KNOWN_LEVEL


def test_a_means_is_measured_as_a_task_is() -> None:
    hide = Clause("hide", (literal("visibility.score.2", NEGLIGIBLE), literal("placement.status.2", v.ON_SUPPORT)))
    found = trial("cover", hide, "jido", seed=DEVELOPED_ON, number=0)
    assert (found.task, found.robot, found.gate, found.means) == ("cover", "jido", "found", "put_over")
    assert found.clean
    assert found.controllable is True


def test_a_room_follows_from_its_numbers() -> None:
    assert room_to_perform_in(DEVELOPED_ON, 0, 1) == room_to_perform_in(DEVELOPED_ON, 0, 1)
    first, again = room_to_perform_in(DEVELOPED_ON, 0, 0), room_to_perform_in(DEVELOPED_ON, 0, 1)
    assert (first.table, first.pieces, first.robot_at) == (again.table, again.pieces, again.robot_at)
    assert first.things != again.things


@pytest.mark.parametrize("number", range(4))
def test_nothing_stands_in_anything_else(number: int) -> None:
    room = room_to_perform_in(DEVELOPED_ON, number, near=bool(number % 2))
    assert 2 <= len(room.things) <= 8
    assert {THING, TARGET} <= {*(thing.name for thing in room.things), room.target.name}
    scene = room.scene("jido")
    data = mujoco.MjData(scene.model)
    data.qpos[:] = scene.initial.qpos
    mujoco.mj_forward(scene.model, data)
    owners = [[scene.owners[geom] for geom in contact.geom] for contact in data.contact if contact.dist < -1e-3]
    seated = {f"chair_{TARGET}", TARGET}
    assert not [pair for pair in owners if len(set(pair)) > 1 and set(pair) != seated]


# --- The second auditor.


@cache
def scene() -> Scene:
    people = (Person(ROBOT, 1.5, (-1.6, 0.0), 0.0, "standing", profile="jido"), right(1.7, 0.75))
    return Room("room", people, (replace(on_table("cup", -0.2, 0.3), name=THING),), TABLE).scene()


def still(seconds: float) -> tuple[Array, Array]:
    times = np.arange(0.0, seconds, 1 / 30)
    return times, np.tile(scene().initial.qpos, (len(times), 1))


def audited(times: Array, qpos: Array, holds: dict[int, Hold] | None = None) -> tuple[Fault, ...]:
    held = [frozenset({holds[k]}) if holds and k in holds else frozenset[Hold]() for k in range(len(times))]
    return second_audit(scene(), ROBOT, THING, times, qpos, held)


def test_who_stands_still_has_no_fault() -> None:
    assert audited(*still(1.0)) == ()


def test_a_planted_penetration_is_found_between_frames() -> None:
    """The base is in the table in no frame, and swings through a leg of it between two."""
    times, qpos = still(2.0)
    base = scene().base_slice(ROBOT)
    qpos[30:, base.start] += 1.3
    found = audited(times, qpos)
    assert {fault.kind for fault in found} == {"penetration", "jump"}
    deep = [fault for fault in found if "table" in (fault.what, fault.other)]
    assert deep
    assert all(0.9 < fault.time_s < 2.0 and fault.amount > 0.002 for fault in deep)


def test_a_load_that_is_carried_through_the_table_is_found() -> None:
    times, qpos = still(1.0)
    column = scene().object_slice(THING)
    qpos[:, column.start + 2] -= 0.06 * np.minimum(times / 0.5, 1.0)
    found = {fault.kind: fault for fault in audited(times, qpos)}
    assert found["penetration"].amount == pytest.approx(0.06, abs=0.012)
    assert found["stray"].what == THING
    assert {"rest"} <= found.keys(), "physics throws it out again"


def test_a_thing_that_hangs_in_the_air_does_not_rest() -> None:
    times, qpos = still(1.0)
    qpos[:, scene().object_slice(THING).start + 2] += 0.2
    (fault,) = audited(times, qpos)
    assert (fault.kind, fault.other) == ("rest", "under gravity")
    assert fault.amount > 0.15


@pytest.mark.parametrize(("aside_m", "kinds"), [(0.0, []), (0.03, ["rest"])])
def test_a_heavy_thing_stands_on_a_light_one_but_not_on_its_edge(aside_m: float, kinds: list[str]) -> None:
    """It sinks in by nothing that counts, however much heavier it is than what carries it."""
    tin = Thing("tin", (0.063, 0.089), (0.0, 0.3, TABLE.height_m))
    plate = Thing(
        "plate", (0.03, 0.20, 0.16), (0.006 + aside_m, 0.305, TABLE.height_m + tin.height_m), math.radians(24)
    )
    people = (Person("R", 1.5, (-1.6, 0.0), 0.0, "standing", profile="jido"),)
    room = Room("room", people, (tin, plate), TABLE).scene()
    times = np.arange(30) / 30
    faults = second_audit(room, "R", "plate", times, np.tile(room.initial.qpos, (30, 1)), [frozenset[Hold]()] * 30)
    assert [fault.kind for fault in faults] == kinds


def test_a_hand_that_holds_what_is_elsewhere_and_a_joint_beyond_its_limit() -> None:
    times, qpos = still(1.0)
    hold = dict.fromkeys(range(5, 10), Hold(ROBOT, "right", THING))
    qpos[:, scene().agent(ROBOT).joints["arm_7"]] += 3.5 * times
    found = {fault.kind: fault for fault in audited(times, qpos, hold)}
    assert set(found) == {"grip", "joint limit"}
    assert found["joint limit"].what == "R/arm_7"


# --- What can be solved.


def test_what_is_under_a_fixed_closed_cover_cannot_be_got_at() -> None:
    people = (Somebody(ROBOT, (0.0, 0.0), profile="jido"), Somebody(TARGET, (2.6, 0.0), np.pi))
    things = (table("table", 1.3), box(1.1), cover(1.1))
    built = PlainRoom(things, people)
    spec = mujoco.MjSpec.from_string(built.files()["room.xml"].decode())
    covered = Scene.from_spec(spec, [person.entry() for person in built.people])
    found = solvable(covered, PUT_DOWN, ROBOT, TARGET, "box")
    assert found == Solvable(False, "the performer cannot grasp the thing where it is")
    assert solvable(scene(), PUT_DOWN, ROBOT, TARGET, THING).possible


def test_a_room_is_solved_from_end_to_end() -> None:
    possible = solvable(scene(), PUT_AWAY, ROBOT, TARGET, THING)
    assert possible.possible
    assert possible.wanted >= 1
    found = tried(0, "room", scene(), "put away", PUT_AWAY, "jido", possible)
    assert (found.gate, found.faults, found.controllable) == ("found", (), True)
    assert found.cpu_s > 0.0


# --- What trials come to.


def test_an_interval_is_wilsons() -> None:
    assert Share(0, 0).interval == (0.0, 1.0)
    assert Share(8, 10).interval == pytest.approx((0.4902, 0.9433), abs=1e-4)
    assert Share(0, 10).interval == pytest.approx((0.0, 0.2775), abs=1e-4)


def test_trials_are_tallied_by_what_can_be_solved() -> None:
    of = partial(Trial, 0, "perform-1-0000-0", "hide", "jido")
    trials = (
        of(True, "", "found", controllable=True, strict=True, is_task=True, as_shown=False, cpu_s=2.0),
        of(True, "", "found", controllable=True, is_task=False, faults=("jump of it: 1",), cpu_s=4.0),
        of(True, "", "performer", why=("3 × blocked",), cpu_s=9.0),
        of(False, "", "start", cpu_s=0.1),
    )
    tally = Tally.of(trials)
    assert (tally.solvable, tally.found, tally.clean, tally.strict) == (
        Share(3, 4),
        Share(2, 3),
        Share(1, 2),
        Share(1, 2),
    )
    assert (tally.is_task, tally.as_shown) == (Share(1, 2), Share(0, 1))
    assert (tally.cpu_s, tally.refusal_s) == ((3.0, 3.9), (4.55, 9.0))
    assert TrialsFound.of_json(json.loads(json.dumps(TrialsFound(1, trials).to_json()))) == TrialsFound(1, trials)
    assert set(MARK.findall(PAGE.read_text(encoding="utf-8"))) == parts(TrialsFound(1, trials)).keys()
    shown, task, _, gates, faults = sheets(TrialsFound(1, trials))
    assert "2 of 3, 67%" in shown.rows[0][3]
    assert "1 of 2, 50%" in task.rows[0][2]
    assert gates.rows[0][gates.header.index("performer")] == "1"
    assert faults.rows == (("jido: jump of it", "1"),)


def test_trials_that_are_kept_are_not_made_anew(tmp_path: Path) -> None:
    made = Trial(0, "perform-5-0000-0", "hide", "jido", True, "", "performer", why=("3 × blocked",))
    kept = tmp_path / "trials.json"
    kept.write_text(json.dumps({"perform": TrialsFound(5, (made,)).to_json()}))
    with keeping_inputs():
        found = performed_trials(count=1, seed=5, tasks=("hide",), robots=("jido",), kept=kept)
        _keep(found, kept)  # what a command extends is no input of it
    assert found.trials == (made,)
    with pytest.raises(InputError, match="another seed"):
        performed_trials(count=1, seed=6, tasks=("hide",), robots=("jido",), kept=kept)
    with pytest.raises(InputError, match=r"by another rule .* give --rule paper"):
        performed_trials(count=1, seed=5, tasks=("hide",), robots=("jido",), rule="bayes", kept=kept)
    kept.write_text("[]")
    with pytest.raises(InputError, match="holds no trials"):
        performed_trials(count=1, seed=5, tasks=("hide",), robots=("jido",), kept=kept)
