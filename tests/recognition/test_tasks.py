"""Which known task was performed: laws of the probabilities, and the study as a witness."""

from __future__ import annotations

import math

import pytest

from taskgist.errors import KnowledgeError
from taskgist.facts import UNKNOWN, Observation
from taskgist.learning import Answer, Context, Knowledge, Verdict
from taskgist.learning.background import Background, shipped_background
from taskgist.learning.clauses import Support
from taskgist.recognition import Recognised, Recogniser
from taskgist.recognition.tasks import PRIOR_ODDS, ln_ratio
from tests.learning.learning_samples import STUDY, study

ALL = Knowledge().add(*(each for task in STUDY for each in study(task).explanations.values()))


@pytest.fixture(scope="module")
def recogniser() -> Recogniser:
    return Recogniser.of(ALL)


def probabilities(found: Recognised) -> dict[str, float]:
    return {each.task: each.probability for each in found.tasks}


def test_a_demonstration_is_recognised_and_what_it_entails_is_probable(recogniser: Recogniser) -> None:
    for task in STUDY:
        for each in study(task).explanations.values():
            found = recogniser.recognise(each.nodes)
            assert probabilities(found)[task] > 0.5, each.demonstration
            assert found.best is not None
    hidden_away = next(iter(study("hide away").explanations.values()))
    assert [each.task for each in recogniser.recognise(hidden_away.nodes).likely] == ["hide away", "hide"]


def test_a_demonstration_that_was_left_out_is_mostly_recognised() -> None:
    right = 0
    for each in ALL.explanations:
        best = Recogniser.of(ALL.remove(each.task, each.digest)).recognise(each.nodes).best
        right += best is not None and best.task in {each.task, "hide" if each.task == "hide away" else each.task}
    assert right >= 0.8 * len(ALL.explanations)


def test_manipulations_of_a_kind_that_nobody_has_seen_are_mostly_none() -> None:
    shipped = shipped_background()
    for kind in ("drop", "throw"):
        known = Background(shipped.context, shipped.manipulations.without(kind))
        recogniser = Recogniser.of(ALL, background=known)
        rows = [{name: Observation(value) for name, value in row.items()} for row in shipped.manipulations[kind]]
        none = [recogniser.recognise(row).best is None for row in rows]
        assert sum(none) >= 0.6 * len(none), kind  # 77 and 64 %: three to five demonstrations are known


def test_none_is_never_more_than_what_the_most_probable_task_leaves(recogniser: Recogniser) -> None:
    for each in ALL.explanations:
        found = recogniser.recognise(each.nodes)
        ordered = [one.probability for one in found.tasks]
        assert ordered == sorted(ordered, reverse=True)
        assert math.prod(1.0 - one for one in ordered) <= found.none <= 1.0 - ordered[0]
        by_odds = 1.0 / (1.0 + sum(one.odds for one in found.tasks))
        assert found.none == pytest.approx(min(by_odds, 1.0 - ordered[0]))


def test_nothing_known_of_an_episode_leaves_the_prior(recogniser: Recogniser) -> None:
    prior = PRIOR_ODDS / (1.0 + PRIOR_ODDS)
    for nodes in ({}, {name: Observation(UNKNOWN) for name in ALL.explanations[0].nodes}):
        found = recogniser.recognise(nodes)
        assert list(probabilities(found).values()) == pytest.approx([prior] * len(STUDY))
        assert all(each.holds is UNKNOWN and each.least_typical is None for each in found.tasks)


def test_order_of_demonstrations_does_not_matter(recogniser: Recogniser) -> None:
    turned = Knowledge()
    for task in reversed(STUDY):
        turned = turned.add(*reversed(list(study(task).explanations.values())))
    nodes = ALL.explanations[5].nodes
    assert Recogniser.of(turned).recognise(nodes) == recogniser.recognise(nodes)


def test_what_lacks_what_always_was_so_is_less_typical(recogniser: Recogniser) -> None:
    given = next(iter(study("give").explanations.values()))
    moving = {**given.nodes, "motion.status.2": Observation("Moving"), "motion.class": Observation("motion_gained")}
    was, now = (probabilities(recogniser.recognise(nodes))["give"] for nodes in (given.nodes, moving))
    assert now < was
    found = next(each for each in recogniser.recognise(moving).tasks if each.task == "give")
    assert found.least_typical is not None
    assert found.least_typical.node.startswith("motion.")
    assert found.least_typical.weight < 0.0


def test_what_a_literal_says_is_how_much_more_often_it_holds() -> None:
    support = Support(9, 10, 0.25)
    rate = 99 / 110  # (9 + 90) / (10 + 100)
    assert ln_ratio(support, True) == pytest.approx(math.log(rate / 0.25))
    assert ln_ratio(support, False) == pytest.approx(math.log((1 - rate) / 0.75))
    assert ln_ratio(support, UNKNOWN) == 0.0
    assert ln_ratio(Support(3, 3, 1.0), True) == 0.0  # the empty clause


def test_one_task_alone_is_that_task_or_none() -> None:
    alone = Recogniser.of(Knowledge().add(*study("hide").explanations.values()))
    assert alone.tasks == ("hide",)
    hidden, given = (next(iter(study(task).explanations.values())).nodes for task in ("hide", "give"))
    assert alone.recognise(hidden).best is not None
    found = alone.recognise(given)
    assert found.best is None
    assert found.none == pytest.approx(1.0 - found.tasks[0].probability)


def test_without_a_background_two_tasks_are_told_apart_and_one_is_refused() -> None:
    both = Knowledge().add(*(each for task in ("hide", "give") for each in study(task).explanations.values()))
    other = Background(Context("other", "tree"), shipped_background().manipulations)
    given = next(iter(study("give").explanations.values()))
    best = Recogniser.of(both, background=other).recognise(given.nodes).best
    assert best is not None
    assert best.task == "give"
    with pytest.raises(KnowledgeError, match=r"nothing to compare it with.*learn another task"):
        Recogniser.of(Knowledge().add(given), background=other)


def test_no_knowledge_is_refused_with_what_to_do() -> None:
    with pytest.raises(KnowledgeError, match="learn tasks first"):
        Recogniser.of(Knowledge())
    with pytest.raises(KnowledgeError, match="no task is known in the trees of these agents"):
        Recogniser.of(ALL, of="performer")


def test_answers_of_people_count() -> None:
    answer = Answer("hide", "see.nature", Verdict.IRRELEVANT, author="P", time="2026-01-01T12:00:00+00:00")
    posterior = {each.posterior.task: each.posterior for each in Recogniser.of(ALL.answer(answer)).known}["hide"]
    assert all(literal.node != "see.nature" for clause in posterior.clauses for literal in clause.literals)
