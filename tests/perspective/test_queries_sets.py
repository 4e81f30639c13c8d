"""Set questions between agents: as values and as text, and what they leave unknown."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskgist.errors import InputError, UnknownNameError
from taskgist.perspective import ABILITIES, Ability, Viewpoint, able, least_effort
from taskgist.perspective import scene_efforts as queries_module
from taskgist.perspective.queries import Condition, Question, objects_where, parse_question
from taskgist.perspective.scene_efforts import Chosen, SceneEfforts, able_by, becoming_able_by
from taskgist.world import Stage, State
from tools.rooms import COARSE, Person, Room, Thing, chair, wall

HIGH = Thing("high", (0.03, 0.05), (0.5, 0.2, 1.75), "cylinder")
NEAR = Thing("near", (0.03, 0.05), (0.5, -0.2, 1.1), "cylinder")
FAR = Thing("far", (0.1,), (5.0, 4.0, 3.0), "sphere")
BEHIND = Thing("behind", (0.03, 0.05), (1.7, 0.1, 1.45), "cylinder")
PEOPLE = (Person("P1", (0, 0), 0.0, "sitting"), Person("P2", (2.4, 0.1), 3.1))
ROOM = Room((chair(0.0), wall("wall", 1.2, half=(0.02, 4.0, 1.25)), HIGH, NEAR, FAR, BEHIND), PEOPLE)
NAMES = ("high", "near", "far", "behind")


def perspectives(*untracked: str) -> SceneEfforts:
    stage = ROOM.stage()
    state = stage.state
    return SceneEfforts(Stage(stage.scene, State(state.qpos, untracked=frozenset(untracked))), COARSE)


KNOWN = perspectives()
LEVELS = {
    (agent, name, ability): KNOWN.effort(agent, name, ability).level
    for agent in ("P1", "P2")
    for name in NAMES
    for ability in ABILITIES
}


def conditions() -> st.SearchStrategy[Question]:
    """Conditions on the room's agents."""
    bounds = st.tuples(st.integers(0, 5), st.integers(0, 5)).map(sorted)
    return st.builds(
        lambda agent, ability, bound: Condition(agent, ability, max_level=bound[1], min_level=bound[0]),
        st.sampled_from(["P1", "P2"]),
        st.sampled_from(ABILITIES),
        bounds,
    )


@given(conditions(), conditions(), conditions())
def test_questions_are_set_algebra(a: Question, b: Question, c: Question) -> None:
    def yes(question: Question) -> set[str]:
        return set(objects_where(KNOWN, question).yes)

    assert yes(a & b) == yes(a) & yes(b)
    assert yes(a | b) == yes(a) | yes(b)
    assert yes(~a) == set(NAMES) - yes(a)
    assert yes(a & (b | c)) == yes((a & b) | (a & c))
    assert set(objects_where(KNOWN, [a, ~b]).yes) == yes(a) - yes(b)


@pytest.mark.parametrize("ability", ABILITIES)
@pytest.mark.parametrize("agent", ["P1", "P2"])
@pytest.mark.parametrize("bound", ["", "<= 0", "<= 2", "< 4", "= 1", ">= 3", "> 1", "= 5", ">= 0"])
def test_bounds_are_those_of_the_levels(agent: str, ability: Ability, bound: str) -> None:
    chosen = objects_where(KNOWN, parse_question(f"{agent} {ability}s {bound}".replace("reachs", "reaches"), PEOPLE_))
    test = (bound or "<= 4").replace("= ", "== ").replace("<==", "<=").replace(">==", ">=")
    assert chosen.yes == tuple(name for name in NAMES if eval(f"{LEVELS[agent, name, ability]} {test}"))
    assert set(chosen.yes) | set(chosen.no) == set(NAMES)


PEOPLE_ = ("P1", "P2")


def test_the_room_is_worth_asking_about() -> None:
    assert set(LEVELS.values()) >= {0, 1, 3, 5}


@pytest.mark.parametrize(
    ("text", "question"),
    [
        ("P1 reaches", Condition("P1", "reach")),
        ("P1 reach<=2", Condition("P1", "reach", max_level=2)),
        ("not P1 sees", ~Condition("P1", "see")),
        (
            "P1 sees and P2 sees or P1 grasps",
            (Condition("P1", "see") & Condition("P2", "see")) | Condition("P1", "grasp"),
        ),
        (
            "P1 sees and (P2 sees or P1 grasps)",
            Condition("P1", "see") & (Condition("P2", "see") | Condition("P1", "grasp")),
        ),
        ("not not P1 sees > 1", ~~Condition("P1", "see", min_level=2, max_level=5)),
        ('"P1" sees = 5', Condition("P1", "see", min_level=5, max_level=5)),
    ],
)
def test_text_is_read_as_the_same_value(text: str, question: Question) -> None:
    assert parse_question(text, PEOPLE_) == question


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"an agent is expected where it ends .*; as in"),
        ("P1", "an agent without a verb"),
        ("P1 and", "an agent without a verb"),
        ("P1 sees and", "an agent is expected where it ends"),
        ("P1 sees or or P2 sees", "an agent is expected where 'or' stands there"),
        ("(P1 sees", "a bracket is not closed"),
        ("P1 sees)", r"'\)' is too much .*; join conditions"),
        ("P1 sees P2 sees", "'P2' is too much"),
        ("P1 sees <= 6", "'6' is no effort level"),
        ("P1 sees <=", "'nothing' is no effort level"),
        ("P1 sees < 0", "a bound leaves no effort level"),
        ("P1 sees > 5", "a bound leaves no effort level"),
        ('P1 sees "', "is too much"),
    ],
)
def test_text_that_is_no_question(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as refused:
        parse_question(text, PEOPLE_)
    assert refused.value.field == "where"


def test_questions_are_as_long_as_a_program_makes_them() -> None:
    """Chains are read in a loop and asked flat; only brackets within brackets have a bound."""
    once = Condition("P1", "see")
    assert parse_question("not " * 3001 + "P1 sees", PEOPLE_) == ~once
    stage = Room((chair(0.0),), PEOPLE).stage()
    for word in ("and", "or"):
        assert parse_question(f" {word} ".join(["P1 sees"] * 3000), PEOPLE_).abilities == once.abilities
        assert objects_where(stage, parse_question(f" {word} ".join(["P1 sees"] * 3000), PEOPLE_)) == Chosen((), (), ())
    assert parse_question("(" * 50 + "P1 sees" + ")" * 50, PEOPLE_) == once
    with pytest.raises(InputError, match=r"brackets in brackets .*at most 50"):
        parse_question("(" * 3000 + "P1 sees" + ")" * 3000, PEOPLE_)


@pytest.mark.parametrize(
    ("text", "message"),
    [("P3 sees", "no agent 'P3'; did you mean"), ("P1 reeches", "no ability 'reeches'; did you mean 'reaches'")],
)
def test_unknown_names_lead_to_known_ones(text: str, message: str) -> None:
    with pytest.raises(UnknownNameError, match=message):
        parse_question(text, PEOPLE_)


def test_an_agent_that_does_not_exist_is_refused_even_without_objects() -> None:
    stage = Room((chair(0.0),), PEOPLE).stage()
    with pytest.raises(UnknownNameError, match="no agent 'P9'"):
        objects_where(stage, Condition("P9", "see"))
    assert objects_where(stage, Condition("P1", "see")) == Chosen((), (), ())


def test_levels_that_do_not_exist_are_refused() -> None:
    for bounds in ((0, 6), (-1, 2), (3, 2)):
        with pytest.raises(InputError, match="no effort level lies there"):
            Condition("P1", "see", min_level=bounds[0], max_level=bounds[1])


def test_what_is_not_tracked_is_listed_apart() -> None:
    lost = perspectives("near")
    assert objects_where(lost, Condition("P1", "reach")).unknown == ("near",)
    assert objects_where(lost, ~Condition("P1", "reach")).unknown == ("near",)
    assert objects_where(lost, Condition("P1", "reach", max_level=5)).yes == NAMES


def test_something_false_outweighs_what_is_unknown() -> None:
    lost = perspectives("P1/legs")
    reach = objects_where(lost, Condition("P1", "reach"))
    assert reach.yes == ("near",)
    assert set(reach.unknown) == {"high", "far", "behind"}
    assert objects_where(lost, Condition("P1", "reach", max_level=2)).no == ("high", "far", "behind")
    never = ~Condition("P2", "reach", max_level=5)
    assert objects_where(lost, [Condition("P1", "reach"), never]).unknown == ()
    assert objects_where(lost, Condition("P1", "reach") | ~never).yes == NAMES


def test_unknown_levels_are_those_of_able() -> None:
    lost = perspectives("P1/legs", "far")
    for name, level in itertools.product(NAMES, range(5)):
        expected = able(lost.stage, "P1", name, "reach", max_level=level, settings=COARSE)
        assert lost.able("P1", name, "reach", max_level=level) is expected


def test_viewpoints_and_efforts_are_made_once(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []

    class Counted(Viewpoint):
        def __init__(self, stage: Stage, agent: str, *rest: object, **named: object) -> None:
            made.append(agent)
            super().__init__(stage, agent, *rest, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(queries_module, "Viewpoint", Counted)
    asked = perspectives()
    for text in ("P1 reaches and P2 sees", "not P1 sees or P2 reaches <= 1", "P1 reaches"):
        objects_where(asked, parse_question(text, PEOPLE_))
    assert sorted(made) == ["P1", "P2"]
    assert asked.effort("P1", "near", "reach") is asked.effort("P1", "near", "reach")
    assert asked.effort("P1", "near", "reach") == least_effort(asked.stage, "P1", "near", "reach", COARSE)


def test_what_some_actions_bring_about() -> None:
    efforts = KNOWN.efforts_with("P1", "reach", ["Make_Standing", "Stretch_Out_Arm(left)"])
    assert able_by(efforts) == Chosen(yes=("high", "near"), no=("far", "behind"), unknown=())
    assert becoming_able_by(efforts) == ("high", "near")
    seen = KNOWN.efforts_with("P2", "see", [])
    assert set(able_by(seen).yes) >= {"behind"}
    assert becoming_able_by(seen) == ()
