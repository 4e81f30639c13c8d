"""Questions and answers: asked where the band says so, fixed until withdrawn, kept for ever."""

from __future__ import annotations

import itertools

import pytest

from taskgist.errors import KnowledgeError
from taskgist.learning import (
    Answer,
    Experience,
    Question,
    Understanding,
    Verdict,
    answer_from_json,
    clause_of,
    questions_of,
    understand,
)
from taskgist.settings import Learning
from tests.learning.learning_samples import STUDY, Told, explained, study

WIDE = Learning(band="wide")
NOON, LATER = "2024-05-01T12:00:00+00:00", "2024-05-01T13:00:00+00:00"


def ask(understanding: Understanding) -> dict[str, Question]:
    return {question.node.name: question for question in questions_of(understanding)}


def test_the_narrow_band_asks_nothing_after_four_demonstrations_and_the_wide_one_does() -> None:
    assert not questions_of(understand(study("show")))
    asked = ask(understand(study("show"), settings=WIDE))
    assert "placement.status.2" in asked
    question = asked["placement.status.2"]
    assert [(each.value, each.demonstrations) for each in question.choices] == [
        ("In_Hand", ("show 1", "show 2", "show 3")),
        ("On_Support", ("show 4",)),
    ]


def test_a_question_whose_answer_changes_nothing_is_not_asked() -> None:
    # The final effort to reach is confusing, while its class contradicts itself.
    efforts = ["11", "21", "21", "41", "14", "11"]
    told = [Told(reach, "10", "ph") for reach in efforts]
    understanding = understand(
        Experience.of("show", [explained("show", i, each) for i, each in enumerate(told)]), settings=WIDE
    )
    assert understanding.judgements["reach.effort.2"].verdict is Verdict.CONFUSING
    assert understanding.judgements["reach.class"].verdict is Verdict.IRRELEVANT
    assert "reach.effort.2" not in ask(understanding)


def test_an_answer_fixes_the_verdict_until_it_is_withdrawn() -> None:
    experience = study("show")
    name = "placement.nature"
    question = ask(understand(experience, settings=WIDE))[name]
    relevant = question.answer(Verdict.RELEVANT, author="ann", time=NOON, value="Supportive(On_Support)")
    fixed = understand(experience, settings=WIDE, answers=[relevant])
    assert (fixed.judgements[name].value, fixed.judgements[name].kept) == ("Supportive(On_Support)", True)
    assert fixed.judgements[name].estimate.verdict is Verdict.CONFUSING
    assert name not in ask(fixed)
    assert "Nature_Object_Status" in {literal.title for literal in clause_of(fixed).effects}

    withdrawn = Answer("show", name, None, author="ann", time=LATER)
    assert understand(experience, settings=WIDE, answers=[withdrawn, relevant]) == understand(experience, settings=WIDE)


def test_irrelevant_prunes_what_is_below() -> None:
    answer = Answer("show", "see.nature", Verdict.IRRELEVANT, author="ann", time=NOON)
    pruned = understand(study("show"), answers=[answer])
    assert not [each for each in pruned.kept if each.node.name.startswith("see.")]


def test_relevant_without_a_value_takes_the_most_frequent() -> None:
    answer = Answer("show", "placement.nature", Verdict.RELEVANT, author="ann", time=NOON)
    assert understand(study("show"), answers=[answer]).judgements["placement.nature"].value == "Supportive(In_Hand)"
    with pytest.raises(KnowledgeError, match=r"placement\.nature: relevant without a value; answer with a value"):
        understand(Experience("show"), answers=[answer])


def test_the_latest_answer_holds_in_whatever_order_they_come() -> None:
    said = [
        Answer("show", "see.nature", Verdict.IRRELEVANT, author="bob", time="2024-05-01T14:30:00+02:00"),
        Answer("show", "see.nature", Verdict.RELEVANT, author="ann", time=NOON),
        Answer("show", "see.nature", None, author="cid", time="2024-05-01T11:59:59+00:00"),
        Answer("hide", "see.nature", None, author="ann", time=LATER),
    ]
    for order in itertools.permutations(said):
        answer = understand(study("show"), answers=order).judgements["see.nature"].answer
        assert answer is not None
        assert answer.author == "bob"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"verdict": Verdict.CONFUSING}, "no decision (got 'confusing'); say relevant or irrelevant"),
        ({"verdict": Verdict.IRRELEVANT, "value": "x"}, "value without relevance (got 'x')"),
        ({"time": "yesterday"}, "time: not a time (got 'yesterday'); write it like 2024"),
        ({"time": "2024-05-01T12:00:00"}, "time: no offset from UTC"),
    ],
)
def test_what_is_no_answer_is_refused(change: dict[str, object], message: str) -> None:
    fields: dict[str, object] = {"verdict": None, "author": "ann", "time": NOON, "task": "show", "node": "see.class"}
    with pytest.raises(KnowledgeError) as caught:
        Answer(**(fields | change))  # type: ignore[arg-type]
    assert message in str(caught.value)


def test_answers_as_json() -> None:
    for verdict, value in ((Verdict.RELEVANT, "x"), (Verdict.IRRELEVANT, None), (None, None)):
        answer = Answer("show", "see.class", verdict, author="ann", time=NOON, value=value)
        assert answer_from_json(answer.to_json()) == answer
    for document in (None, {}, {"verdict": "perhaps"}, {"verdict": None, "further": 1}):
        with pytest.raises(KnowledgeError, match="not an answer"):
            answer_from_json(document)


def test_a_pruned_node_may_come_back() -> None:
    told = [*STUDY["show"], *(Told("21", "10", "ph", ends="In_Hand") for _ in range(17))]
    whole = [explained("show", i, each) for i, each in enumerate(told)]
    verdicts = [
        understand(Experience.of("show", whole[:count])).judgements["placement.status.2"].verdict
        for count in (4, 7, 21)
    ]
    assert verdicts == [Verdict.IRRELEVANT, Verdict.CONFUSING, Verdict.RELEVANT]
