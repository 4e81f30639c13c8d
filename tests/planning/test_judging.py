"""Final states judged: lazily and in full, as a still recording would be explained, with every kind of attention."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from taskgist.errors import InputError, UnknownNameError
from taskgist.facts import STANDARD_TREE, UNKNOWN, Predicate, predicate_subtree
from taskgist.learning import Clause, Literal
from taskgist.observe import Observer, resting_snapshot, snapshot
from taskgist.perspective.effort import ABILITIES, Ability
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.perspective.search import effort_from, level_from
from taskgist.perspective.viewpoint import Viewpoint
from taskgist.planning import ATTENTIONS, Attention, Goal, Judge
from taskgist.world import Scene, Stage, State
from tests.observe.states import States
from tests.planning.judged_rooms import JudgedRoom, raws, room
from tests.scenes import agent, cylinder, scene

COUNTS = {"show": 50, "hide": 50, "make accessible": 8, "give": 12, "put away": 5, "hide away": 9}
"""States judged lazily and in full, by task; ``tools.verdicts`` judges more."""


@pytest.mark.parametrize("task", COUNTS)
def test_lazy_verdicts_are_those_in_full(task: str) -> None:
    each = room(task, 1)
    attention: Attention = "thing" if task in ("show", "hide") else "stays"
    lazily, in_full = each.judge(attention), each.judge(attention)
    held = set()
    for state in each.candidates(COUNTS[task], seed=1):
        lazy, full = lazily.verdict(state), in_full.verdict(state, lazily=False)
        assert (lazy.holds, lazy.failed) == (full.holds, full.failed)
        assert lazy.values.items() <= full.values.items()
        held.add(full.holds)
    assert False in held


def test_some_states_satisfy_each_goal() -> None:
    """Else the tests above would compare refusals alone."""
    holding = {task for task in ("show", "hide", "make accessible", "hide away") if satisfied(room(task, 1))}
    assert holding == {"show", "hide", "make accessible", "hide away"}


def satisfied(each: JudgedRoom) -> bool:
    judge = each.judge("thing")
    return any(judge.verdict(state).holds is True for state in each.candidates(150))


@pytest.mark.parametrize(("task", "number"), [("give", 1), ("hide", 1)])
def test_a_resting_state_is_explained_as_a_still_recording(task: str, number: int) -> None:
    each = room(task, number)
    kinds = set()
    for state in each.candidates(4, seed=5):
        still = [replace_time(state.with_holding(None), time_s) for time_s in np.arange(0.0, 1.01, 0.1)]
        observer, stage = Observer(each.scene, States(still)), Stage(each.scene)
        seen = snapshot(stage.show(still[6]), observer, agent=each.target, name=each.thing)
        alone = resting_snapshot(stage.show(state), agent=each.target, name=each.thing)
        assert alone == seen
        kinds.add(alone["placement"].value)
    assert len(kinds) > 1


def replace_time(state: State, time_s: float) -> State:
    return replace(state, time_s=float(time_s))


def test_values_of_a_full_verdict_are_what_explains() -> None:
    each = room("make accessible", 1)
    judge = each.judge()
    for state in each.candidates(2, seed=2):
        found = judge.verdict(state, lazily=False).values
        expected = raws(resting_snapshot(Stage(each.scene, state), agent=each.target, name=each.thing))
        assert found
        assert dict(found) == {name: expected[name] for name in found}


def test_what_was_observed_comes_with_its_evidence() -> None:
    each = room("hide", 1)
    judge, state = each.judge(), each.candidates(1, seed=3)[0]
    expected = resting_snapshot(Stage(each.scene, state), agent=each.target, name=each.thing)
    for name in ("placement", "hands", "visibility.score", "see.effort", "reach.action"):
        assert judge.observed(state, name) == expected[name]
    for name in ("sound", "see.colour"):
        with pytest.raises(UnknownNameError, match=r"no attribute that is observed in a state"):
            judge.observed(state, name)


def test_who_holds_what_at_the_start_is_no_longer_so_elsewhere() -> None:
    """A state to be judged often is the start with the thing elsewhere, and says what was decided over time there."""
    each = room("give", 1)
    judge, (state,) = each.judge(), each.candidates(1, seed=4)
    decided = state.with_holding([])
    assert judge.verdict(decided, lazily=False) == judge.verdict(state, lazily=False)


@pytest.mark.parametrize("ability", ABILITIES)
def test_levels_are_told_as_far_as_they_are_asked_for(ability: Ability) -> None:
    each = room("make accessible", 1)
    for state in each.candidates(4, seed=7):
        here = Viewpoint(Stage(each.scene, state), each.target)
        level = effort_from(here, each.thing, ability).level
        assert level is not None
        efforts = SceneEfforts(Stage(each.scene, state))
        for up_to in range(-1, 5):
            expected = min(level, up_to + 1)
            assert level_from(here, each.thing, ability, up_to=up_to) == expected
            assert efforts.level(each.target, each.thing, ability, up_to=up_to) == expected


def test_what_was_not_tracked_stays_unknown_however_lazily_it_is_asked() -> None:
    each = room("make accessible", 1)
    lost = {f"{each.target}/head", f"{each.target}/left_arm", f"{each.target}/torso", each.target, each.thing}
    states = each.candidates(10, seed=1)
    unknown = 0
    for name in sorted(lost):
        lazily, in_full = each.judge(), each.judge()
        for state in (each.start, *states[:3]):
            lazy = lazily.verdict(state.without([name]))
            full = in_full.verdict(state.without([name]), lazily=False)
            assert (lazy.holds, lazy.failed) == (full.holds, full.failed)
            here = Viewpoint(Stage(each.scene, state.without([name])), each.target)
            for ability in ABILITIES if state is each.start else ():
                level = effort_from(here, each.thing, ability).level
                levels = [level_from(here, each.thing, ability, up_to=up_to) for up_to in range(-1, 5)]
                assert levels == [None if level is None else min(level, up_to + 1) for up_to in range(-1, 5)]
            unknown += full.holds is UNKNOWN
    assert unknown


# --- Attention.


def watcher(profile: str = "human") -> tuple[Scene, Judge]:
    """P2 looks along y; the cup is before it to the right, P1 to the left."""
    room_ = scene(
        cylinder("cup", 1.0, 1.2, 0.9),
        '<body name="shelf" pos="1.0 1.2 0.83"><geom type="box" size="0.2 0.2 0.02"/></body>',
        agents=agent("P1", -1.2, 1.2, -90) + agent("P2", 0, 0, 90, extra=f'profile = "{profile}"'),
    )
    return room_, Judge(room_, room_.initial, "P2", "cup", goal_of(room_, "P2"))


def goal_of(where: Scene, target: str) -> Goal:
    wanted = STANDARD_TREE.node("see.effort.2")
    clause = Clause("look", (Literal(wanted.name, wanted.title, "No_Effort_Required", wanted.instant),))
    return Goal.of(clause, resting_snapshot(Stage(where), agent=target, name="cup"), STANDARD_TREE)


@pytest.mark.parametrize(("attention", "seen"), [("stays", False), ("thing", True), ("performer", False)])
def test_attention_turns_the_head(attention: Attention, *, seen: bool) -> None:
    where, _ = watcher()
    judge = Judge(where, where.initial, "P2", "cup", goal_of(where, "P2"), attention=attention, performer="P1")
    assert judge.verdict(where.initial).holds is seen
    stage, body = Stage(where), where.agent("P2")
    eye = stage.show(judge.assumed(where.initial)).eye(body)
    ahead = {"thing": stage.body_position(where.object_body("cup")), "performer": stage.eye(where.agent("P1")).position}
    if attention == "stays":
        assert np.array_equal(judge.assumed(where.initial).qpos, where.initial.qpos)
    else:
        line = ahead[attention] - eye.position
        assert eye.matrix[:, 0] @ line / np.linalg.norm(line) > np.cos(np.radians(3.0))
    changed = np.flatnonzero(judge.assumed(where.initial).qpos != where.initial.qpos)
    profile = body.profile
    assert profile.pan is not None
    assert profile.tilt is not None
    assert {*changed.tolist()} <= {body.joints[profile.pan.joint], body.joints[profile.tilt.joint]}


@pytest.mark.parametrize("profile", ["jido", "hrp2"])
def test_robots_turn_their_heads_as_well(profile: str) -> None:
    where, _ = watcher(profile)
    judge = Judge(where, where.initial, "P2", "cup", goal_of(where, "P2"), attention="thing")
    stage = Stage(where)
    cup = stage.body_position(where.object_body("cup"))

    def off_rad(state: State) -> float:
        eye = stage.show(state).eye(where.agent("P2"))
        line = cup - eye.position
        return float(np.arccos(np.clip(eye.matrix[:, 0] @ line / np.linalg.norm(line), -1.0, 1.0)))

    assert off_rad(judge.assumed(where.initial)) < np.radians(5.0) < off_rad(where.initial)


def test_a_head_turns_no_farther_than_heads_do() -> None:
    where, _ = watcher()
    judge = Judge(where, where.initial, "P2", "cup", goal_of(where, "P2"), attention="thing")
    behind = where.initial.replace(at=where.object_slice("cup"), to=(-0.1, -1.5, 0.9, 1, 0, 0, 0))
    assert judge.verdict(behind).holds is False
    pan = where.agent("P2").profile.pan
    assert pan is not None
    angle = judge.assumed(behind).qpos[where.agent("P2").joints[pan.joint]]
    assert abs(angle) == pytest.approx(min(np.radians(60), pan.range_rad[1]))


def test_wrong_attention_is_refused() -> None:
    where, judge = watcher()
    with pytest.raises(InputError, match="nobody to look at"):
        Judge(where, where.initial, "P2", "cup", judge.goal, attention="performer")
    with pytest.raises(UnknownNameError, match="no kind of attention 'cup'"):
        Judge(where, where.initial, "P2", "cup", judge.goal, attention="cup")  # type: ignore[arg-type]
    for names in (("P9", "cup"), ("P2", "cap")):
        with pytest.raises(UnknownNameError, match="did you mean"):
            Judge(where, where.initial, *names, judge.goal)
    with pytest.raises(UnknownNameError, match="no agent 'P9'"):
        Judge(where, where.initial, "P2", "cup", judge.goal, attention="performer", performer="P9")
    assert ATTENTIONS == ("stays", "thing", "performer")


# --- What cannot be, and predicates of one's own.


def test_the_impossible_fails_without_a_look() -> None:
    where, _ = watcher()
    node = STANDARD_TREE.node("reach.class")
    clause = Clause("take back", (Literal(node.name, node.title, "Becomes_Easier", None),))
    cup = where.initial.replace(at=where.object_slice("cup"), to=(*palm_of(where), 1, 0, 0, 0))
    goal = Goal.of(clause, resting_snapshot(Stage(where, cup), agent="P2", name="cup"), STANDARD_TREE)
    judge = Judge(where, cup, "P2", "cup", goal)
    for lazily in (True, False):
        verdict = judge.verdict(where.initial, lazily=lazily)
        assert (verdict.holds, verdict.failed, dict(verdict.values)) == (False, clause.literals[0], {})


def palm_of(where: Scene) -> tuple[float, ...]:
    return tuple(Stage(where).site(where.agent("P2").arms[0].palm_site).position.tolist())


def high(stage: Stage, _agent: str, name: str) -> bool:
    return bool(stage.body_position(stage.scene.object_body(name))[2] > 1.0)


def test_predicates_of_ones_own_are_judged_if_somebody_observes_them() -> None:
    where, _ = watcher()
    own = Predicate(predicate_subtree("high"), high)
    tree = STANDARD_TREE.extended(own.subtree, predicate_subtree("lucky"))
    literals = tuple(Literal(f"{name}.value.2", name, "True", 2) for name in ("high", "lucky"))
    start = resting_snapshot(Stage(where), agent="P2", name="cup", predicates=[own])
    goal = Goal.of(Clause("raise", literals), start, tree)
    assert [each.literal.node for each in goal.unjudged] == ["lucky.value.2"]
    judge = Judge(where, where.initial, "P2", "cup", goal, predicates=[own])
    up = where.initial.replace(at=where.object_slice("cup"), to=(1.0, 1.2, 1.3, 1, 0, 0, 0))
    assert judge.verdict(where.initial).failed == literals[0]
    assert judge.verdict(up).holds is True
    with pytest.raises(UnknownNameError, match="that is observed in a state 'high'"):
        Judge(where, where.initial, "P2", "cup", goal)
