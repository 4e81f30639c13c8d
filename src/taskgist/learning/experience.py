"""Experience: the explanations of one task in the trees of the same agents, and the counts that follow from them (6.3).

Experience is a set: explanations are known by their digest, so that experiences merge in any order and grouping,
and a demonstration that two of them share counts once. Counts are carried along; adding a demonstration touches
each node of the tree once and looks at no other demonstration.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from taskgist.common.frozen import FrozenMap, canonical_text
from taskgist.errors import KnowledgeError, UnknownNameError
from taskgist.facts.tree import TreeOf
from taskgist.facts.values import Unknown
from taskgist.learning.explanation import Context, Explanation

Counts = FrozenMap[str, FrozenMap[str, int]]
"""Demonstrations by node and value. What was unknown is not counted."""

_NONE: FrozenMap[str, int] = FrozenMap()


@dataclass(frozen=True)
class Experience:
    """What has been seen of one task, in trees of its target agents or of its performing agents, done right or wrong.

    Immutable: each change gives a new one.

    Args:
        task: Name of the task.
    """

    task: str
    explanations: FrozenMap[str, Explanation] = field(default_factory=FrozenMap)
    """By digest. To be filled by ``of``, ``add`` or ``merge``."""
    counts: Counts = field(default_factory=FrozenMap, compare=False, repr=False)
    contexts: FrozenMap[Context, int] = field(default_factory=FrozenMap, compare=False, repr=False)
    """Explanations by context; one context, unless mixing was asked for."""

    @property
    def tree_of(self) -> TreeOf:
        """Whose trees they are; that of the target agents if there are none yet."""
        return next((each.tree_of for each in self.explanations.values()), "target")

    @property
    def wrong(self) -> bool:
        """Whether it is of demonstrations that were done wrong."""
        return any(each.wrong for each in self.explanations.values())

    @staticmethod
    def of(task: str, explanations: Iterable[Explanation], *, allow_mixed: bool = False) -> Experience:
        """Experience of these explanations.

        Raises:
            KnowledgeError: As ``add``.
        """
        return Experience(task).extended(explanations, allow_mixed=allow_mixed)

    def add(self, explanation: Explanation, *, allow_mixed: bool = False) -> Experience:
        """This experience and one more demonstration; one that is already in it changes nothing.

        Args:
            explanation: Of this task.
            allow_mixed: Count it even if it was made with other settings or another tree.

        Raises:
            KnowledgeError: It explains another task, is the tree of another agent (the performing one's beside those
                of target agents), is wrong beside right ones, was made under another context, or contradicts an
                explanation of the very same demonstration.
        """
        return self.extended((explanation,), allow_mixed=allow_mixed)

    def merge(self, other: Experience, *, allow_mixed: bool = False) -> Experience:
        """Union of both; what they share counts once.

        Raises:
            KnowledgeError: As ``add``.
        """
        return self.extended(other.explanations.values(), allow_mixed=allow_mixed)

    def extended(self, explanations: Iterable[Explanation], *, allow_mixed: bool = False) -> Experience:
        """This experience and further demonstrations; the one way in for all of them.

        Raises:
            KnowledgeError: As ``add``.
        """
        index = self.explanations.to_dict()
        fresh: list[Explanation] = []
        for explanation in explanations:
            _check_task(self.task, explanation)
            _check_alike(next(iter(index.values()), explanation), explanation)
            known = index.get(explanation.digest)
            if known is None:
                fresh.append(explanation)
            index[explanation.digest] = explanation if known is None else _agreed(known, explanation)
        contexts = _context_counts(self.contexts, fresh, +1)
        if len(contexts) > 1 and not allow_mixed:
            raise mixed(self.task, contexts)
        return Experience(self.task, FrozenMap(index), _shifted(self.counts, fresh, +1), contexts)

    def remove(self, digest: str) -> Experience:
        """This experience without one demonstration.

        Raises:
            UnknownNameError: There is none of this digest.
        """
        if digest not in self.explanations:
            raise UnknownNameError("explanation", digest, self.explanations)
        gone = self.explanations[digest]
        return Experience(
            self.task,
            self.explanations.without(digest),
            _shifted(self.counts, (gone,), -1),
            _context_counts(self.contexts, (gone,), -1),
        )

    def behind(self, node: str, value: str) -> tuple[Explanation, ...]:
        """The demonstrations in which a node had a value, by name."""
        found = (each for each in self.explanations.values() if node in each.nodes and each.nodes[node].value == value)
        return tuple(sorted(found, key=lambda each: (each.demonstration, each.digest)))


def _shifted(counts: Counts, explanations: Iterable[Explanation], step: int) -> Counts:
    """Counts with these explanations counted once more, or once less; no value is left with a count of zero."""
    touched: dict[str, dict[str, int]] = {}
    for name, value in (known for explanation in explanations for known in _known(explanation)):
        if name not in touched:
            touched[name] = counts.get(name, _NONE).to_dict()
        values = touched[name]
        values[value] = values.get(value, 0) + step
        if values[value] == 0:
            del values[value]
    shifted = counts.to_dict() | {name: FrozenMap(values) for name, values in touched.items()}
    return FrozenMap({name: values for name, values in shifted.items() if values})


def _known(explanation: Explanation) -> Iterator[tuple[str, str]]:
    for name, node in explanation.nodes.items():
        if not isinstance(node.value, Unknown):
            yield name, node.value


def _context_counts(
    contexts: FrozenMap[Context, int], explanations: Iterable[Explanation], step: int
) -> FrozenMap[Context, int]:
    shifted = contexts.to_dict()
    for explanation in explanations:
        shifted[explanation.context] = shifted.get(explanation.context, 0) + step
    return FrozenMap({context: n for context, n in shifted.items() if n})


def _agreed(known: Explanation, given: Explanation) -> Explanation:
    """One of two explanations of the same demonstration; the choice does not depend on which came first."""
    if known.values != given.values:
        different = sorted(name for name in known.values if known.values[name] != given.values.get(name))
        raise KnowledgeError(
            f"two explanations of the same demonstration differ at {', '.join(different) or 'further nodes'}",
            where=known.demonstration,
            field="digest",
            value=known.digest,
            hint="remove the outdated one, then add the other",
        )
    return min(known, given, key=lambda each: (each.actions is None, canonical_text(each.to_json())))


def _check_task(task: str, explanation: Explanation) -> None:
    if explanation.task != task:
        hint = f"this is the experience of {task!r}; add it to that of {explanation.task!r}"
        raise KnowledgeError(
            "another task", where=explanation.demonstration, field="task", value=explanation.task, hint=hint
        )


def _check_alike(known: Explanation, explanation: Explanation) -> None:
    """Refuse another agent's tree, and a wrong demonstration among right ones."""
    hint = "keep an experience of each, as Knowledge does"
    if explanation.tree_of != known.tree_of:
        raise KnowledgeError(
            f"the {explanation.tree_of}'s tree beside the {known.tree_of}'s: they tell of different agents",
            where=explanation.demonstration,
            field="tree_of",
            value=explanation.tree_of,
            hint=hint,
        )
    if explanation.wrong != known.wrong:
        raise KnowledgeError(
            "one was done right and one was done wrong: they do not speak for the same",
            where=explanation.demonstration,
            field="wrong",
            value=explanation.wrong,
            hint=hint,
        )


def mixed(task: str, contexts: Iterable[Context]) -> KnowledgeError:
    """What is raised where explanations of several contexts would be counted together."""
    listed = "; ".join(sorted(str(context) for context in contexts))
    hint = "learn anew from the recordings with one of them, or allow mixing (allow_mixed=True)"
    return KnowledgeError(f"made under different contexts: {listed}", where=f"task {task}", hint=hint)
