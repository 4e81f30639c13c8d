"""What known tasks mean by whole clauses, and which demonstrations look odd."""

from __future__ import annotations

from dataclasses import replace

import pytest

from taskgist.errors import UnknownNameError
from taskgist.learning import RULES, Answer, Context, Knowledge, Verdict, clause_of, learned_clause
from taskgist.learning.background import shipped_background
from taskgist.learning.task_clauses import evidence_by_task, learn_task, odd_demonstrations, task_evidence
from tests.learning.learning_samples import STUDY, explained, study


def knowledge(*tasks: str) -> Knowledge:
    return Knowledge().add(*(each for task in tasks for each in study(task).explanations.values()))


def test_a_first_task_is_compared_with_neutral_manipulations_and_a_second_with_the_first() -> None:
    first = learn_task(knowledge("hide"), "hide")
    assert first.compared == {name: len(rows) for name, rows in shipped_background().kinds.items()}
    assert first.best.literals
    second = learn_task(knowledge("hide", "give"), "hide")
    assert second.compared == {**first.compared, "give": 3}


def test_a_background_of_another_context_is_left_aside() -> None:
    other = replace(shipped_background(), context=Context("other", "tree"))
    assert learn_task(knowledge("hide", "give"), "hide", background=other).compared == {"give": 3}


def test_other_tasks_of_another_context_are_left_aside() -> None:
    others = [replace(each, context=Context("other", "tree")) for each in study("give").explanations.values()]
    known = knowledge("hide", "show")
    assert learn_task(known.add(*others), "hide") == learn_task(known, "hide")


def test_evidence_of_all_tasks_is_that_of_each() -> None:
    other = [replace(each, context=Context("other", "tree")) for each in study("give").explanations.values()]
    wrong = [each.marked_wrong() for each in study("put away").explanations.values()]
    known = knowledge("hide", "show", "put away").add(*other, *wrong, allow_mixed=True)
    by_task = evidence_by_task(known)
    assert by_task == {task: task_evidence(known, task) for task in ("give", "hide", "put away", "show")}
    assert by_task["hide"] is by_task["show"]


def test_answers_fix_literals_until_they_are_withdrawn() -> None:
    known = knowledge("hide", "give")
    node = learn_task(known, "hide").best.literals[0].node

    def answered(verdict: Verdict | None, hour: int) -> Answer:
        return Answer("hide", node, verdict, "Ann", f"2026-01-01T{hour:02}:00:00+00:00")

    irrelevant = known.answer(answered(Verdict.IRRELEVANT, 1))
    assert node not in {each.node for each in learn_task(irrelevant, "hide").best.literals}
    relevant = irrelevant.answer(answered(Verdict.RELEVANT, 2))
    assert all(node in {each.node for each in one.literals} for one in learn_task(relevant, "hide").clauses)
    assert learn_task(relevant.answer(answered(None, 3)), "hide") == learn_task(known, "hide")


def test_both_rules_give_one_shape_of_meaning() -> None:
    known = knowledge("hide", "give")
    paper, bayes = (learned_clause(known, "hide", rule) for rule in RULES)
    assert paper == clause_of(known.understand("hide"))
    assert (paper.rule, paper.usual) == ("paper", ())
    learned = learn_task(known, "hide")
    assert bayes.literals == learned.best.literals
    assert bayes.usual == tuple(each.literal for each in learned.usual)
    assert bayes.circumstances == (*bayes.usual, *(each.literal for each in learned.always))
    assert (bayes.rule, bayes.head, bayes.preconditions) == ("bayes", paper.head, ())
    for each in known.explanations:
        assert bayes.holds(each.nodes) is learned.best.holds(each.nodes)
    document = bayes.to_json()
    assert [each["text"] for each in document["effects"]] == [str(each) for each in learned.best.literals]
    with pytest.raises(UnknownNameError, match=r"no rule 'bays'; did you mean 'bayes'\?"):
        learned_clause(known, "hide", "bays")


def test_nothing_is_learned_where_there_is_nothing_to_compare_with() -> None:
    known = Knowledge().add(
        *(replace(each, context=Context("other", "tree")) for each in knowledge("hide").explanations)
    )
    assert not learned_clause(known, "hide", "bayes").literals


def test_a_mislabelled_demonstration_is_odd_and_looks_like_what_it_is() -> None:
    wrong = replace(explained("hide", 9, STUDY["hide"][0]), task="give", demonstration="give 9")
    known = knowledge(*STUDY).add(wrong)
    (odd,) = odd_demonstrations(known, learn_task(known, "give"))
    assert odd.explanation == wrong
    assert odd.probability < 0.5
    assert "hide" in odd.looks_like


def test_none_of_two_demonstrations_is_odd_nor_is_one_that_is_as_the_others() -> None:
    known = knowledge(*STUDY)
    assert odd_demonstrations(known, learn_task(known, "give")) == ()
    one = study("hide", 1).explanations
    two = Knowledge().add(*one.values(), replace(explained("give", 1, STUDY["give"][0]), task="hide"))
    assert odd_demonstrations(two, learn_task(two, "hide")) == ()
