"""Experience: the laws of merging, and what is refused."""

from __future__ import annotations

import dataclasses
import pickle
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskgist.common.frozen import FrozenMap
from taskgist.errors import KnowledgeError, UnknownNameError
from taskgist.facts import UNKNOWN, Observation
from taskgist.learning import Context, Experience, Explanation, Knowledge, clause_of, understand
from tests.learning.learning_samples import STUDY, Told, explained, explanations, study

FEW = settings(max_examples=40, deadline=None, derandomize=True)


@FEW
@given(explanations(), st.randoms(use_true_random=False), st.data())
def test_experiences_merge_in_any_order_and_grouping(
    demonstrations: list[Explanation], chance: random.Random, data: st.DataObject
) -> None:
    whole = Experience.of("show", demonstrations)
    parts = [
        Experience.of("show", data.draw(st.lists(st.sampled_from(demonstrations)))) if demonstrations else whole
        for _ in range(3)
    ]
    parts += [Experience.of("show", [each]) for each in demonstrations]  # shared with the parts above
    chance.shuffle(parts)
    merged = Experience("show")
    for part in parts:
        merged = merged.merge(part) if chance.random() < 0.5 else part.merge(merged)
    assert merged == whole
    assert (merged.counts, merged.contexts) == (whole.counts, whole.contexts)
    assert understand(merged) == understand(whole)


@FEW
@given(explanations())
def test_adding_one_by_one_is_merging_at_once(demonstrations: list[Explanation]) -> None:
    added = Experience("show")
    for each in demonstrations:
        added = added.add(each).add(each)
    assert added == Experience.of("show", reversed(demonstrations))
    assert added.counts == Experience.of("show", demonstrations).counts


@FEW
@given(explanations(), st.data())
def test_removing_and_adding_again_changes_nothing(demonstrations: list[Explanation], data: st.DataObject) -> None:
    whole = Experience.of("show", demonstrations)
    if not demonstrations:
        return
    one = data.draw(st.sampled_from(demonstrations))
    less = whole.remove(one.digest)
    assert less == Experience.of("show", [each for each in demonstrations if each != one])
    assert less.counts == Experience.of("show", less.explanations.values()).counts
    again = less.add(one)
    assert (again, again.counts, again.contexts) == (whole, whole.counts, whole.contexts)


@FEW
@given(explanations())
def test_counts_are_those_of_the_known_values(demonstrations: list[Explanation]) -> None:
    counts = Experience.of("show", demonstrations).counts
    for name in {name for each in demonstrations for name in each.nodes}:
        known = [each.values[name] for each in demonstrations if each.values[name] is not UNKNOWN]
        assert counts.get(name, {}) == {value: known.count(value) for value in known}


@FEW
@given(explanations())
def test_a_clause_without_dissent_holds_where_it_came_from(demonstrations: list[Explanation]) -> None:
    understanding = understand(Experience.of("show", demonstrations))
    if any(len(each.counts) > 1 for each in understanding.kept):
        return
    clause = clause_of(understanding)
    for each in demonstrations:
        expected: object = True
        if any(each.nodes[literal.node].value is UNKNOWN for literal in clause.literals):
            expected = UNKNOWN
        assert clause.holds(each.nodes) is expected


@FEW
@given(explanations())
def test_what_is_kept_hangs_together(demonstrations: list[Explanation]) -> None:
    understanding = understand(Experience.of("show", demonstrations))
    kept = {each.node.name for each in understanding.kept}
    assert all(each.node.parent is None or each.node.parent in kept for each in understanding.kept)


class Poison(FrozenMap[str, Observation[str]]):
    """Nodes that must not be looked at."""

    def __getitem__(self, key: str) -> Observation[str]:
        raise AssertionError(key)

    def __iter__(self) -> object:  # type: ignore[override]
        raise AssertionError


def test_adding_looks_at_no_other_demonstration() -> None:
    experience = study("show", 3)
    for each in experience.explanations.values():
        object.__setattr__(each, "nodes", Poison())
    assert len(experience.add(explained("show", 4, STUDY["show"][3])).explanations) == 4


def test_a_demonstration_is_known_by_recording_label_settings_and_tree() -> None:
    one = explained("show", 1, STUDY["show"][0])
    renamed = dataclasses.replace(one, demonstration="another name")
    assert renamed.digest == one.digest
    changes: list[dict[str, object]] = [
        {"task": "hide"},
        {"performing_agent": "P3"},
        {"target_agents": ("P3",)},
        {"target_objects": ("book",)},
        {"source": "another"},
        {"context": Context("another", one.context.tree_version)},
        {"context": Context(one.context.settings_digest, "another")},
    ]
    digests = {dataclasses.replace(one, **change).digest for change in changes}  # type: ignore[arg-type]
    assert len(digests - {one.digest}) == len(changes)


def test_the_digest_is_the_same_on_every_machine() -> None:
    one = dataclasses.replace(explained("show", 1, STUDY["show"][0]), context=Context("settings", "tree"))
    assert one.digest == "a80407d4099ae060"


def test_two_accounts_of_the_same_demonstration_must_agree() -> None:
    one, contrary = explained("show", 1, STUDY["show"][0]), explained("show", 1, Told("21", "20", "ph", ends="In_Hand"))
    with pytest.raises(
        KnowledgeError, match=r"show 1: digest: .* differ at see\.action\.1, see\.effort\.1 .*remove the"
    ):
        Experience.of("show", [one, contrary])
    renamed = dataclasses.replace(one, demonstration="a name")
    assert Experience.of("show", [one, renamed]) == Experience.of("show", [renamed, one])


def test_other_tasks_and_contexts_are_refused_unless_asked_for() -> None:
    first = explained("show", 1, STUDY["show"][0])
    with pytest.raises(KnowledgeError, match="this is the experience of 'hide'; add it to that of 'show'"):
        Experience("hide").add(first)
    other = dataclasses.replace(explained("show", 2, STUDY["show"][1]), context=Context("other", "tree"))
    with pytest.raises(KnowledgeError) as caught:
        Experience.of("show", [first]).add(other)
    assert first.context.settings_digest in str(caught.value)
    assert "settings other, tree tree" in str(caught.value)
    assert "learn anew" in str(caught.value)
    mixed = Experience.of("show", [first]).add(other, allow_mixed=True)
    assert len(mixed.contexts) == 2
    assert mixed.remove(other.digest) == Experience.of("show", [first])
    with pytest.raises(UnknownNameError, match="no explanation 'gone'"):
        mixed.remove("gone")


@FEW
@given(explanations(most=3), explanations("hide", most=3))
def test_knowledge_merges_in_any_order(shown: list[Explanation], hidden: list[Explanation]) -> None:
    one, other = Knowledge().add(*shown, *hidden[:1]), Knowledge().add(*hidden, *shown[:1])
    assert one.merge(other) == other.merge(one) == Knowledge().add(*hidden, *shown)
    assert pickle.loads(pickle.dumps(one)) == one


def test_knowledge_forgets_a_task_with_its_last_demonstration() -> None:
    knowledge = Knowledge().add(*study("show", 1).explanations.values())
    digest = knowledge.explanations[0].digest
    assert knowledge.understand("show").task == "show"
    assert knowledge.remove("show", digest) == Knowledge()
    with pytest.raises(UnknownNameError, match=r"no task 'shwo'; did you mean 'show'\?"):
        knowledge.experience("shwo")
