"""Knowledge: the experience of each task, with the answers that people gave."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from taskgist.common.frozen import FrozenMap
from taskgist.errors import KnowledgeError, UnknownNameError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import TREES_OF, HypothesisTree, TreeOf
from taskgist.learning.answers import Answer
from taskgist.learning.experience import Experience, mixed
from taskgist.learning.explanation import Context, Explanation
from taskgist.learning.understanding import Understanding, understand
from taskgist.settings import DEFAULT, Learning


@dataclass(frozen=True)
class Knowledge:
    """All that has been learned. Immutable: each change gives a new one."""

    experiences: FrozenMap[tuple[str, TreeOf], Experience] = field(default_factory=FrozenMap)
    """By task and by whose trees they are: what is known of performers stands apart. None is empty."""
    wrong: FrozenMap[tuple[str, TreeOf], Experience] = field(default_factory=FrozenMap)
    """The same of demonstrations that were done wrong: they say what must not hold, and count for nothing."""
    answers: frozenset[Answer] = frozenset()

    @property
    def tasks(self) -> tuple[str, ...]:
        """Names of the tasks of which a right demonstration is known, sorted."""
        return tuple(sorted({task for task, _ in self.experiences}))

    def trees_of(self, task: str) -> tuple[TreeOf, ...]:
        """Whose trees are known of a task; none if the task is not known."""
        return tuple(of for of in TREES_OF if (task, of) in self.experiences)

    @property
    def contexts(self) -> frozenset[Context]:
        """Settings and trees under which its explanations were made."""
        return frozenset(context for each in self._all for context in each.contexts)

    @property
    def explanations(self) -> tuple[Explanation, ...]:
        """All explanations: by task, by whose tree it is, and by digest; those of wrong demonstrations follow."""
        return tuple(each.explanations[digest] for each in self._all for digest in sorted(each.explanations))

    @property
    def _all(self) -> tuple[Experience, ...]:
        """The experiences of right and then of wrong demonstrations, by task and by whose trees they are."""
        return tuple(kept[key] for kept in (self.experiences, self.wrong) for key in sorted(kept))

    def experience(self, task: str, of: TreeOf = "target") -> Experience:
        """Experience of a task.

        Args:
            task: Its name.
            of: For whom: its target agents, or who performs it. Where it is only known of who performs it, as it is
                performed for nobody else, that is meant by both.

        Raises:
            UnknownNameError: The task is not known.
            KnowledgeError: It is not known of who performs it, or by wrong demonstrations alone.
        """
        known = self.trees_of(task)
        if not known and any(name == task for name, _ in self.wrong):
            hint = "show how it is done right, and learn that without --wrong"
            raise KnowledgeError("known by demonstrations that were done wrong alone", where=f"task {task}", hint=hint)
        if not known:
            raise UnknownNameError("task", task, self.tasks)
        if of == "performer" and of not in known:
            hint = "learn it so from recordings: taskgist learn --of performer, or of='performer' in Python"
            raise KnowledgeError("known of target agents alone", where=f"task {task}", field="of", value=of, hint=hint)
        return self.experiences[task, of if of in known else known[0]]

    def understand(
        self,
        task: str,
        tree: HypothesisTree = STANDARD_TREE,
        settings: Learning = DEFAULT.learning,
        of: TreeOf = "target",
    ) -> Understanding:
        """What a task means for its target agents, or for who performs it; see ``understand`` and ``experience``.

        Raises:
            UnknownNameError: The task is not known.
            KnowledgeError: It is not known of who performs it.
        """
        return understand(self.experience(task, of), tree, settings, self.answers)

    def add(self, *explanations: Explanation, allow_mixed: bool = False) -> Knowledge:
        """This knowledge and further demonstrations, of any task and in the trees of any agents.

        Raises:
            KnowledgeError: As ``Experience.add``.
        """
        kept = {False: dict(self.experiences), True: dict(self.wrong)}
        for wrong, task, of in {(each.wrong, each.task, each.tree_of) for each in explanations}:
            own = (each for each in explanations if (each.wrong, each.task, each.tree_of) == (wrong, task, of))
            known = kept[wrong].get((task, of), Experience(task))
            kept[wrong][task, of] = known.extended(own, allow_mixed=allow_mixed)
            contexts = {one for each in kept.values() if (task, of) in each for one in each[task, of].contexts}
            if len(contexts) > 1 and not allow_mixed:
                raise mixed(task, contexts)
        return replace(self, experiences=FrozenMap(kept[False]), wrong=FrozenMap(kept[True]))

    def rivals(self, explanation: Explanation) -> tuple[Explanation, ...]:
        """Explanations of the same recording, for an agent and object of its own, with another label or times."""
        return tuple(each for each in self.explanations if each.is_rival_of(explanation))

    def remove(self, task: str, digest: str) -> Knowledge:
        """This knowledge without one demonstration; a task without any is forgotten, its answers are not.

        Raises:
            UnknownNameError: There is no such task or explanation.
        """
        kept = {False: self.experiences, True: self.wrong}
        for wrong, of in ((wrong, of) for wrong in kept for of in TREES_OF):
            if (task, of) in kept[wrong] and digest in kept[wrong][task, of].explanations:
                left = kept[wrong][task, of].remove(digest)
                without = kept[wrong].without((task, of))
                kept[wrong] = without.set((task, of), left) if left.explanations else without
                return replace(self, experiences=kept[False], wrong=kept[True])
        known = [one for each in self._all if each.task == task for one in each.explanations]
        raise UnknownNameError("explanation", digest, known) if known else UnknownNameError("task", task, self.tasks)

    def answer(self, *answers: Answer) -> Knowledge:
        """This knowledge and further answers."""
        return replace(self, answers=self.answers | frozenset(answers))

    def merge(self, other: Knowledge, *, allow_mixed: bool = False) -> Knowledge:
        """Union of both, in any order and grouping the same.

        Raises:
            KnowledgeError: As ``Experience.merge``.
        """
        return self.add(*other.explanations, allow_mixed=allow_mixed).answer(*other.answers)
