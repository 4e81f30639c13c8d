"""Tasks that are done with others: learned from demonstrations with one label each, and no competitors."""

from __future__ import annotations

import pytest

from taskgist.common.frozen import FrozenMap
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import Nodes
from taskgist.learning import Evidence, Knowledge
from taskgist.learning.clauses import Support, WeighedClause
from taskgist.learning.literals import vocabulary_by_node
from taskgist.recognition import Recogniser
from taskgist.recognition.entailed import ENTAILS, MOST, entailed_tasks, raised
from taskgist.recognition.tasks import NEARLY
from tests.learning.learning_samples import STUDY, study

ALL = Knowledge().add(*(each for task in STUDY for each in study(task).explanations.values()))


def test_who_hides_away_hides_and_nobody_is_said_to_do_the_reverse() -> None:
    recogniser = Recogniser.of(ALL)
    assert set(recogniser.entailed) == {("hide away", "hide")}
    away = next(iter(study("hide away").explanations.values()))
    by_task = {each.task: each for each in recogniser.recognise(away.nodes).tasks}
    assert by_task["hide"].entailed_by == "hide away"
    assert by_task["hide"].probability > by_task["hide"].odds / (1.0 + by_task["hide"].odds)
    assert by_task["hide away"].entailed_by is None


def test_of_two_that_are_nearly_as_probable_the_one_that_says_more_is_named_first() -> None:
    recogniser = Recogniser.of(ALL)
    for task in ("hide away", "hide"):
        for each in study(task).explanations.values():
            found = recogniser.recognise(each.nodes)
            assert found.best is not None
            by_task = {one.task: one.probability for one in found.tasks}
            nearly = by_task["hide away"] >= NEARLY * by_task["hide"]
            assert found.best.task == ("hide away" if nearly else "hide")
    away = [recogniser.recognise(each.nodes).best for each in study("hide away").explanations.values()]
    assert [each.task for each in away if each] == ["hide away"] * len(away)


def test_a_probability_is_raised_by_the_law_of_total_probability_and_never_lowered() -> None:
    entailed = FrozenMap({("stow", "hide"): 0.9, ("hide", "show"): 0.8})
    assert raised({"stow": 0.7, "hide": 0.4, "show": 0.3}, entailed) == {
        "stow": (0.7, None),
        "hide": (pytest.approx(0.9 * 0.7 + 0.3 * 0.4), "stow"),
        "show": (0.3, None),  # by itself a hide is not recognised: nothing is handed on
    }
    assert raised({"stow": 0.6, "hide": 0.99, "show": 0.0}, entailed)["hide"] == (0.99, None)
    assert raised({"stow": 0.5, "hide": 0.5, "show": 0.5}, entailed)["hide"] == (0.5, None)


@pytest.mark.parametrize(("count", "hits"), [(3, 3), (3, 2), (10, 10), (400, 400)])
def test_shares_are_smoothed_and_few_demonstrations_are_enough(count: int, hits: int) -> None:
    """The facts tell which demonstrations count as recognised: no more than ``MOST`` of them are looked at."""
    rows = [{"see.nature": "Not_Supportive", "hands": "free" if i < hits else "full"} for i in range(count)]
    evidence = Evidence.of({"stow": rows, "hide": [{"see.nature": "Not_Supportive", "hands": "free"}] * 5})
    literal = vocabulary_by_node(STANDARD_TREE)["see.nature"].literal(("Not_Supportive",))
    clause = WeighedClause((literal,), Support(5, 5, 0.1), 1.0, 1.0)
    looked: list[str] = []

    def probability(task: str, nodes: Nodes) -> float:
        looked.append(task)
        return 1.0 if nodes["hands"].value == "free" else 0.0

    by_task = {"stow": evidence, "hide": evidence}
    found = entailed_tasks(by_task, dict.fromkeys(by_task, clause), probability)
    seen = min(count, MOST)
    share = (seen * hits / count + 0.5) / (seen + 1)
    assert looked.count("hide") == seen
    assert found.get(("stow", "hide"), 0.0) == pytest.approx(share if share >= ENTAILS else 0.0)
