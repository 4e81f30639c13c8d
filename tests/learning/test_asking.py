"""Questions about sets of values: their worth, what answers fix, what contradicts, and what to show next."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest

from taskgist.errors import KnowledgeError
from taskgist.facts import STANDARD_TREE
from taskgist.learning import (
    Answer,
    Knowledge,
    OtherEnd,
    OtherStart,
    Reply,
    SetLiteral,
    Verdict,
    answer_from_json,
    learn_task,
    lessons_of,
    open_questions,
    understand,
)
from taskgist.learning.answers import in_force, replies_in_force
from taskgist.learning.entailment import entailment_of
from taskgist.learning.literals import vocabularies
from tests.learning.learning_samples import study

KNOWN = {each.node.name: each for each in vocabularies(STANDARD_TREE)}
ENTAILMENT = entailment_of(STANDARD_TREE)


def knowledge(*tasks: str, count: int = 2) -> Knowledge:
    return Knowledge().add(*(each for task in tasks for each in study(task, count).explanations.values()))


def said(reply: Reply | None, node: str, *values: str, author: str = "ann", hour: int = 1, but: bool = False) -> Answer:
    return Answer("hide", node, None, author, f"2026-01-01T{hour:02}:00:00+00:00", among=values, reply=reply, but=but)


HARDER = ("see.class", "Becomes_Difficult")
VERDICTS = ((Verdict.RELEVANT, "ann", 3), (Verdict.IRRELEVANT, "bob", 4))


def entails(one: SetLiteral, other: SetLiteral) -> bool:
    first, second = ENTAILMENT.worlds(one), ENTAILMENT.worlds(other)
    return first.space == second.space and not first.bits & ~second.bits


@pytest.mark.parametrize(
    ("one", "other", "follows"),
    [
        (("see.class", "Becomes_Difficult"), ("see.nature", "Not_Supportive"), True),
        (("see.nature", "Supportive"), ("see.class", "Becomes_Easier"), False),
        (("placement.status.2", "On_Support"), ("placement.nature", "Supportive(On_Support)"), True),
        (("placement.nature", "Supportive(On_Support)"), ("placement.status.2", "On_Support"), True),
        (("hands.class", "Manip_Gained"), ("hands.nature", "Manip_Desired"), True),
        (("see.effort.2", "No_Effort_Required"), ("see.nature", "Supportive"), True),
        (("see.effort.2", "No_Possible_Known_Effort"), ("see.nature", "Not_Supportive"), False),
        (("see.class", "Becomes_Difficult"), ("reach.class", "Becomes_Difficult"), False),
    ],
)
def test_what_follows_from_what(one: tuple[str, str], other: tuple[str, str], *, follows: bool) -> None:
    first, second = (KNOWN[node].literal((value,)) for node, value in (one, other))
    assert entails(first, second) == follows


def test_a_literal_and_its_complement_part_the_worlds() -> None:
    for vocabulary in KNOWN.values():
        rng = random.Random(vocabulary.node.name)
        for _ in range(5):
            values = rng.sample(vocabulary.values, rng.randint(1, len(vocabulary.values) - 1))
            literal = vocabulary.literal(values, but=rng.random() < 0.5)
            both = [ENTAILMENT.worlds(each) for each in (literal, vocabulary.complement(literal))]
            assert both[0].bits & both[1].bits == 0
            assert both[0].bits | both[1].bits == ENTAILMENT.all(both[0].space)


def test_probabilities_are_a_distribution_and_the_first_question_is_worth_most() -> None:
    asking = open_questions(knowledge("hide", "show"), "hide")
    questions = asking.questions()
    for each in questions:
        assert sum(each.expected.values()) == pytest.approx(1.0)
        assert 0.0 < each.gain <= 1.0
        assert each.contrast <= each.gain + 1e-12, "an answer by doing tells no more than one in words"
    assert str(questions[0].literal) == "(Nature_Effort_Class_to_See = Not_Supportive)"


def test_questions_do_not_depend_on_the_order_of_demonstrations() -> None:
    known = knowledge("hide", "show")
    turned = Knowledge().add(*reversed(known.explanations))
    assert open_questions(known, "hide").questions() == open_questions(turned, "hide").questions()


def test_yes_is_in_each_clause_and_no_is_its_opposite() -> None:
    known = knowledge("hide", "show")
    yes = learn_task(known.answer(said(Reply.YES, *HARDER)), "hide")
    assert all("(Relative_Effort_Class_to_See = Becomes_Difficult)" in map(str, each.literals) for each in yes.clauses)
    no = learn_task(known.answer(said(Reply.NO, *HARDER)), "hide")
    assert all("(Relative_Effort_Class_to_See ≠ Becomes_Difficult)" in map(str, each.literals) for each in no.clauses)


def test_either_leaves_no_clause_that_says_it_or_its_opposite_in_any_words() -> None:
    free = KNOWN["see.class"].literal(("Becomes_Difficult",))
    opposite = KNOWN["see.class"].complement(free)
    known = knowledge("hide", "show")
    assert any(entails(one, free) for each in learn_task(known, "hide").clauses for one in each.literals)
    learned = learn_task(known.answer(said(Reply.EITHER, *HARDER)), "hide")
    assert not any(entails(one, each) for c in learned.clauses for one in c.literals for each in (free, opposite))


@pytest.mark.parametrize("reply", Reply)
def test_what_was_asked_is_not_asked_again_in_other_words(reply: Reply) -> None:
    known = knowledge("hide", "show")
    first = open_questions(known, "hide").questions()[0].literal
    answered = known.answer(said(reply, first.node, *first.values, but=first.but))
    worlds = ENTAILMENT.worlds(first)
    for each in open_questions(answered, "hide").questions():
        other = ENTAILMENT.worlds(each.literal)
        alike = (worlds.bits, ENTAILMENT.all(worlds.space) & ~worlds.bits)
        assert other.space != worlds.space or other.bits not in alike
    if reply is Reply.UNKNOWN:
        assert learn_task(answered, "hide") == learn_task(known, "hide")
    withdrawn = answered.answer(said(None, first.node, *first.values, but=first.but, hour=2, author="bob"))
    assert open_questions(withdrawn, "hide").questions() == open_questions(known, "hide").questions()


def test_asking_comes_to_an_end() -> None:
    known = knowledge("hide", "show")
    for hour in range(60):
        questions = open_questions(known, "hide").questions()
        if not questions:
            break
        first = questions[0].literal
        time = f"2026-01-02T00:{hour:02}:00+00:00"
        known = known.answer(replace(said(Reply.UNKNOWN, first.node, *first.values, but=first.but), time=time))
    assert not questions


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (said(Reply.YES, *HARDER), said(Reply.NO, *HARDER, author="bob", hour=2)),
        (said(Reply.YES, *HARDER), said(Reply.YES, "see.class", "Becomes_Easier", hour=2)),
        (said(Reply.YES, *HARDER), said(Reply.YES, "see.nature", "Supportive", hour=2)),
        (said(Reply.YES, *HARDER), said(Reply.EITHER, "see.nature", "Not_Supportive", hour=2)),
        (
            said(Reply.YES, *HARDER),
            Answer("hide", "see.class", Verdict.IRRELEVANT, "bob", "2026-01-01T03:00:00+00:00"),
        ),
    ],
)
def test_contradictions_name_both_and_lose_nothing(one: Answer, other: Answer) -> None:
    known = knowledge("hide", "show").answer(one, other)
    with pytest.raises(KnowledgeError) as refused:
        learn_task(known, "hide")
    assert all(each.about in str(refused.value) and each.author in str(refused.value) for each in (one, other))
    assert "--withdraw" in str(refused.value)
    assert known.answers == {one, other}
    assert known.understand("hide").judgements, "the paper's rule takes the later one"


def test_who_withdraws_their_own_answer_leaves_those_of_others() -> None:
    given = [said(Reply.YES, *HARDER), said(Reply.NO, *HARDER, author="bob", hour=2)]
    given += [
        Answer("hide", "see.nature", each, who, f"2026-01-01T0{hour}:00:00+00:00") for each, who, hour in VERDICTS
    ]
    for who, other in (("ann", "bob"), ("bob", "ann")):
        own = [
            replace(said(None, *HARDER, author=who, hour=5), own=True),
            Answer("hide", "see.nature", None, who, "2026-01-01T05:00:00+00:00", own=True),
        ]
        assert [answer_from_json(each.to_json()) for each in own] == own
        assert {each.author for each in replies_in_force([*given, *own])} == {other}
        assert {each.author for each in in_force([*given, *own]).values()} == {other}
        everybody = [replace(each, own=False) for each in own]
        assert not replies_in_force([*given, *everybody])
        assert not in_force([*given, *everybody])
    with pytest.raises(KnowledgeError, match="withdraws nothing"):
        replace(given[0], own=True)


def test_who_changes_their_mind_replaces_their_answer() -> None:
    known = knowledge("hide", "show")
    later = said(Reply.NO, *HARDER, hour=2)
    both = known.answer(said(Reply.YES, *HARDER), later)
    assert learn_task(both, "hide") == learn_task(known.answer(later), "hide")


@pytest.mark.parametrize(
    ("answer", "verdict", "value"),
    [
        (said(Reply.YES, *HARDER), Verdict.RELEVANT, "Becomes_Difficult"),
        (said(Reply.EITHER, *HARDER), Verdict.IRRELEVANT, None),
        (said(Reply.NO, "see.nature", "Not_Supportive"), Verdict.RELEVANT, "Supportive"),
        (said(Reply.YES, "see.nature", "Supportive", but=True), Verdict.RELEVANT, "Not_Supportive"),
    ],
)
def test_the_papers_rule_takes_what_settles_one_value(answer: Answer, verdict: Verdict, value: str | None) -> None:
    judgement = understand(study("hide"), answers=[answer]).judgements[answer.node]
    assert judgement.verdict is verdict
    assert value is None or judgement.value == value


@pytest.mark.parametrize(
    "answer",
    [
        said(Reply.YES, "see.class", "Becomes_Difficult", "Remains_Same"),
        said(Reply.NO, *HARDER),
        said(Reply.UNKNOWN, *HARDER),
    ],
)
def test_the_papers_rule_leaves_the_rest_as_it_is(answer: Answer) -> None:
    assert understand(study("hide"), answers=[answer]) == understand(study("hide"))


@pytest.mark.parametrize("reply", [*Reply, None])
def test_answers_read_back(reply: Reply | None) -> None:
    answer = said(reply, "see.effort.2", "Head_Effort", "No_Effort_Required", but=True)
    assert answer_from_json(answer.to_json()) == answer


def test_answers_of_earlier_releases_are_written_as_they_were() -> None:
    plain = Answer("hide", "see.class", Verdict.IRRELEVANT, "ann", "2026-01-01T00:00:00+00:00").to_json()
    assert plain.keys() == {"task", "node", "verdict", "author", "time", "value"}


@pytest.mark.parametrize(
    "wrong", [{"among": []}, {"among": "x"}, {"but": 1}, {"reply": "maybe"}, {"reply": 3}, {"among": [1]}]
)
def test_strange_answers_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(KnowledgeError, match=r"not an answer|reply without|verdict on"):
        answer_from_json({**said(Reply.YES, *HARDER).to_json(), **wrong})


def test_a_start_that_was_never_shown_is_proposed_where_it_would_tell() -> None:
    asking = open_questions(knowledge("hide", "put away", "show"), "hide")
    found = [each for each in lessons_of(asking, asking.questions()) if isinstance(each, OtherStart)]
    assert ("posture.value.1", "Standing") in {(each.node.name, each.value) for each in found}
    for each in found:
        assert each.bits > 0.0
        assert each.value not in each.always


def test_a_contrast_parts_what_always_was_so() -> None:
    known = knowledge("show", "hide")
    asking = open_questions(known, "show")
    found = [each for each in lessons_of(asking, asking.questions()) if isinstance(each, OtherEnd)]
    assert found
    for each in found:
        for explanation in known.experience("show").explanations.values():
            assert each.fails.holds(explanation.nodes) is True
            assert each.holds is None or ENTAILMENT.worlds(each.holds).space != ENTAILMENT.worlds(each.fails).space


def test_what_demonstrations_contradict_is_believed_and_what_they_have_in_common_besides_is_not_lost() -> None:
    """All demonstrations end with somebody who sits; told that nobody must, seeing still becomes harder."""
    known = knowledge("hide", "give", "show", count=3)
    before = learn_task(known, "hide").best
    told = known.answer(said(Reply.NO, "posture.value.2", "Sitting"))
    after = learn_task(told, "hide").best
    assert [each for each in after.literals if each.node != "posture.value.2"] == list(before.literals)
    assert [str(each) for each in after.literals if each.node == "posture.value.2"] == ["(Final_Posture ≠ Sitting)"]
    assert after.support.k == 0, "no demonstration shows all of it"
    assert learn_task(told, "hide").probability(next(iter(study("hide", 3).explanations.values())).nodes) < 0.5


@pytest.mark.parametrize("task", ["hide", "show", "make accessible"])
def test_no_answer_leaves_a_clause_that_cannot_hold(task: str) -> None:
    """Who says that seeing must not become harder is not told that it must, though it did in all demonstrations."""
    known = knowledge("hide", "show", "give", "make accessible", count=3)
    asked = tuple(open_questions(known, task).literals())
    assert asked
    for literal in asked:
        no = replace(said(Reply.NO, literal.node, *literal.values, but=literal.but), task=task)
        learned = learn_task(known.answer(no), task)
        for clause in learned.clauses:
            assert all(ENTAILMENT.together(clause.literals).values()), f"no to {literal}: {clause}"
        for also in (*learned.usual, *learned.always):
            assert all(ENTAILMENT.together((KNOWN[literal.node].complement(literal), also.literal)).values())
