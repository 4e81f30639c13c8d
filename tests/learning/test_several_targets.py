"""Several target agents and objects (9.6, 9.7): one explanation for each pair, one merged; asked where they differ."""

from __future__ import annotations

import itertools
import json
import random
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskgist.errors import KnowledgeError, UnknownNameError
from taskgist.facts import UNKNOWN
from taskgist.language import asked, indifference, meaning, why
from taskgist.learning import (
    Experience,
    Explanation,
    Knowledge,
    Verdict,
    clause_of,
    explain,
    explanation_from_json,
    merged,
    questions_of,
    understand,
)
from tests.learning.learning_samples import SNAPSHOTS, STUDY, Told, episode, explained

FEW = settings(max_examples=25, deadline=None, derandomize=True)
HIDDEN, AS_BEFORE = Told("21", "03", "l0"), Told("21", "00", "l0")
NOON = "2024-05-01T12:00:00+00:00"


def part(told: Told, agent: str, name: str = "cup", *, task: str = "hide", index: int = 1) -> Explanation:
    return replace(explained(task, index, told), target_agents=(agent,), target_objects=(name,))


def both(first: Told, second: Told, *, index: int = 1) -> Explanation:
    """Hidden from two: what was observed for each of them."""
    return merged([part(first, "P2", index=index), part(second, "P3", index=index)])


@st.composite
def of_several(draw: st.DrawFn) -> list[Explanation]:
    """The explanation of each of two agents with each of up to two things, with holes in what was observed."""
    names = ("pen", "paper")[: draw(st.integers(1, 2))]
    pairs = list(itertools.product(("P2", "P3"), names))
    ends = [draw(st.tuples(SNAPSHOTS, SNAPSHOTS)) for _ in pairs]
    return [
        replace(explain(episode("give", "one", *end)), target_agents=(agent,), target_objects=(name,), source="one")
        for (agent, name), end in zip(pairs, ends, strict=True)
    ]


@FEW
@given(of_several(), st.randoms(use_true_random=False))
def test_the_order_of_the_targets_changes_nothing(parts: list[Explanation], chance: random.Random) -> None:
    whole = merged(parts)
    chance.shuffle(parts)
    assert merged(parts) == whole
    assert merged(parts).digest == whole.digest
    again = replace(whole, target_agents=whole.target_agents[::-1], target_objects=whole.target_objects[::-1])
    assert again == whole


@FEW
@given(of_several())
def test_a_node_has_the_value_that_all_pairs_have(parts: list[Explanation]) -> None:
    whole = merged(parts)
    for name, node in whole.nodes.items():
        values = {each.nodes[name].value for each in parts}
        assert node.value == (values.pop() if len(values) == 1 else UNKNOWN)
        known = {each.nodes[name].value for each in parts} - {UNKNOWN}
        assert set(whole.differing(name)) == (known if len(known) > 1 else set())


@FEW
@given(of_several())
def test_each_part_is_as_it_was(parts: list[Explanation]) -> None:
    whole = merged(parts)
    for each in parts:
        assert whole.part(each.target_agents[0], each.target_objects[0]) == each
    assert json.loads(json.dumps(whole.to_json()["parts"])) == [each.to_json() for each in whole.parts]


@FEW
@given(of_several())
def test_json_keeps_everything(parts: list[Explanation]) -> None:
    whole = merged(parts)
    back = explanation_from_json(json.loads(json.dumps(whole.to_json())))
    assert (back, back.digest, back.content) == (whole, whole.digest, whole.content)


def test_one_pair_is_no_more_than_it_was() -> None:
    alone = explained("hide", 1, HIDDEN)
    assert merged([alone]) is alone
    assert alone.part("P2", "cup") is alone
    assert {"target_agent": "P2", "target_object": "cup"}.items() <= alone.to_json().items()
    assert "parts" not in alone.to_json()


def test_what_differs_names_who_had_which() -> None:
    whole = both(HIDDEN, AS_BEFORE)
    assert whole.nodes["see.class"].value is UNKNOWN
    reason = "differs: Becomes_Difficult for P2; Remains_Same for P3"
    assert whole.nodes["see.class"].to_json()["evidence"] == {
        "reason": reason,
        "differs": {"Becomes_Difficult": ["P2"], "Remains_Same": ["P3"]},
    }
    things = merged([part(HIDDEN, "P2", "pen"), part(AS_BEFORE, "P2", "paper")])
    assert things.differing("see.class")["Becomes_Difficult"] == (part(HIDDEN, "P2", "pen"),)
    assert [things.called(each) for each in things.parts] == ["paper", "pen"]
    pairs = merged(part(HIDDEN, *pair) for pair in itertools.product(("P2", "P3"), ("pen", "paper")))
    assert [pairs.called(each) for each in pairs.parts] == ["P2 and paper", "P2 and pen", "P3 and paper", "P3 and pen"]


def test_what_is_unknown_for_one_is_unknown_and_no_difference() -> None:
    blind = replace(part(HIDDEN, "P3"), nodes=explain(episode("hide", "hide 1", {}, {})).nodes)
    whole = merged([part(HIDDEN, "P2"), replace(blind, source=part(HIDDEN, "P2").source)])
    assert whole.nodes["see.class"].value is UNKNOWN
    assert whole.nodes["see.class"].evidence == {"reason": "unknown for P3"}
    assert not whole.differing("see.class")


WRONG: dict[str, tuple[Callable[[], list[Explanation]], str]] = {
    "none": (list, "no pair of target agent and object"),
    "another": (lambda: [part(HIDDEN, "P2"), part(HIDDEN, "P3", index=2)], "demonstration: is another demonstration"),
    "twice": (lambda: [part(HIDDEN, "P2"), part(AS_BEFORE, "P2")], "parts: not one explanation for each pair"),
    "not all": (
        lambda: [part(HIDDEN, "P2", "pen"), part(HIDDEN, "P3", "pen"), part(HIDDEN, "P2", "paper")],
        "parts: not one explanation for each pair",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_belongs_not_together_is_refused(case: str) -> None:
    parts, message = WRONG[case]
    with pytest.raises(KnowledgeError, match=message):
        merged(parts())


def test_nobody_else_is_explained() -> None:
    with pytest.raises(UnknownNameError, match="no agent 'P4'"):
        both(HIDDEN, HIDDEN).part("P4", "cup")


def _node(document: Any) -> None:
    document["nodes"]["see.class"] = {"value": "Becomes_Difficult", "evidence": {}}


def _fewer(document: Any) -> None:
    del document["parts"][1]


def _none(document: Any) -> None:
    del document["parts"]


def _nested(document: Any) -> None:
    document["parts"][0] = json.loads(json.dumps(document))


def _one(document: Any) -> None:
    document["target_agent"] = ["P2"]


@pytest.mark.parametrize("damage", [_node, _fewer, _none, _nested, _one])
def test_damage_is_seen(damage: Callable[[Any], None]) -> None:
    document = json.loads(json.dumps(both(HIDDEN, AS_BEFORE).to_json()))
    damage(document)
    with pytest.raises(KnowledgeError, match=r"(damaged|not an) explanation"):
        explanation_from_json(document, where="k.db")


# --- Learning from them.


def hidden_from_two(count: int) -> list[Explanation]:
    return [both(told, told, index=i) for i, told in enumerate(STUDY["hide"][:count], start=1)]


def test_what_is_the_same_for_all_is_learned_as_of_one() -> None:
    of_one = understand(Experience.of("hide", [explained("hide", i, t) for i, t in enumerate(STUDY["hide"], start=1)]))
    of_two = understand(Experience.of("hide", hidden_from_two(3)))
    assert clause_of(of_two).literals == clause_of(of_one).literals
    assert clause_of(of_two).each_of == ("target agents",)
    assert str(clause_of(of_two)).startswith("Task(hide, each of the target agents) ← (")
    assert str(clause_of(of_one)).startswith("Task(hide) ← (")
    assert meaning(of_two) == meaning(of_one).replace("the target agent:", "each of the target agents:")


def test_single_and_several_targets_are_learned_from_together() -> None:
    mixed = Experience.of("hide", [explained("hide", 1, STUDY["hide"][0]), *hidden_from_two(3)[1:]])
    understanding = understand(mixed)
    assert clause_of(understanding).each_of == ("target agents",)
    assert (
        clause_of(understanding).literals == clause_of(understand(Experience.of("hide", hidden_from_two(3)))).literals
    )


def test_each_of_the_objects() -> None:
    understanding = understand(
        Experience.of(
            "give",
            [
                merged([part(told, "P2", name, task="give", index=index) for name in ("pen", "paper")])
                for index, told in enumerate(STUDY["give"])
            ],
        )
    )
    assert clause_of(understanding).each_of == ("target objects",)
    sentence = meaning(understanding)
    assert "for the target agent: " in sentence
    assert "it gets each of the objects into its hand" in sentence
    assert "the object " not in sentence


def test_where_targets_differ_it_is_asked() -> None:
    understanding = understand(Experience.of("hide", [explained("hide", 2, HIDDEN), both(HIDDEN, AS_BEFORE)]))
    judgement = understanding.judgements["see.nature"]
    assert (judgement.estimate.N, judgement.estimate.verdict) == (1, Verdict.RELEVANT)
    assert (judgement.verdict, judgement.kept) == (Verdict.CONFUSING, False)
    assert [each.demonstration for each in judgement.divided] == ["hide 1"]
    (question,) = (each for each in questions_of(understanding) if each.node.name.startswith("see."))
    assert question.node.name == "see.nature", "what is below follows from it"
    assert [(each.value, each.demonstrations, each.targets) for each in question.choices] == [
        ("Not_Supportive", ("hide 2",), (("P2", "hide 1"),)),
        ("Supportive", (), (("P3", "hide 1"),)),
    ]
    assert asked(question) == (
        "What does “hide” mean: that seeing the object becomes harder (in hide 2; for P2 in hide 1) or that seeing the "
        "object becomes no harder (for P3 in hide 1); or does Nature_Effort_Class_to_See not matter?"
    )
    assert (
        "In hide 1 targets differ, which speaks against each value: Not_Supportive for P2, Supportive for P3."
        in why(understanding, "see.nature")
    )


def test_an_answer_settles_it_and_leads_to_what_is_below() -> None:
    experience = Experience.of("hide", [both(HIDDEN, AS_BEFORE)])
    understanding = understand(experience)
    assert understanding.judgements["see.nature"].estimate.verdict is Verdict.UNOBSERVED
    assert "Not clear yet is how hard the object is to see." in indifference(understanding)
    (question,) = (each for each in questions_of(understanding) if each.node.name.startswith("see."))
    relevant = question.answer(Verdict.RELEVANT, author="ann", time=NOON, value="Not_Supportive")
    after = understand(experience, answers=[relevant])
    assert after.judgements["see.nature"].kept
    assert [each.node.name for each in questions_of(after) if each.node.name.startswith("see.")] == ["see.class"]
    irrelevant = question.answer(Verdict.IRRELEVANT, author="ann", time=NOON)
    nothing = understand(experience, answers=[irrelevant])
    assert not [each for each in questions_of(nothing) if each.node.name.startswith("see.")]


def test_joint_angles_in_which_bodies_differ_are_not_meant_and_not_asked_about() -> None:
    second = replace(part(HIDDEN, "P3"), nodes=explained("hide", 2, HIDDEN).nodes)
    whole = merged([part(HIDDEN, "P2"), replace(second, demonstration="hide 1", source=part(HIDDEN, "P2").source)])
    assert whole.differing("see.state.1")
    assert not questions_of(understand(Experience.of("hide", [whole])))
    with_one = understand(Experience.of("hide", [whole, explained("hide", 3, HIDDEN)]))
    assert with_one.judgements["see.state.1"].verdict is Verdict.IRRELEVANT, "though one demonstration has one value"
    assert not questions_of(with_one)


@pytest.mark.parametrize(("others", "verdict"), [(19, Verdict.CONFUSING), (20, Verdict.RELEVANT)])
def test_many_others_outvote_one_demonstration_in_which_targets_differ(others: int, verdict: Verdict) -> None:
    """As they outvote one that dissents: 19 of 20 lie on the band's edge."""
    single = [explained("hide", index, HIDDEN) for index in range(2, 2 + others)]
    judgement = understand(Experience.of("hide", [both(HIDDEN, AS_BEFORE), *single])).judgements["see.class"]
    assert (judgement.verdict, len(judgement.divided)) == (verdict, 1)


def test_a_recording_learned_for_one_of_the_targets_is_a_rival() -> None:
    whole, alone = both(HIDDEN, HIDDEN), part(HIDDEN, "P3")
    known = Knowledge().add(alone)
    assert known.rivals(whole) == (alone,)
    assert not known.rivals(part(HIDDEN, "P2"))
    assert not known.rivals(merged([part(HIDDEN, "P2", "pen"), part(HIDDEN, "P3", "pen")]))
    assert not Knowledge().add(whole).rivals(whole)
