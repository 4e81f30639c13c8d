"""Knowledge: the experience of each task, with the answers that people gave."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from taskgist.common.frozen import FrozenMap
from taskgist.errors import KnowledgeError, UnknownNameError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import TREES_OF, HypothesisTree, TreeOf
from taskgist.learning.answers import Answer
from taskgist.learning.experience import Experience
from taskgist.learning.explanation import Context, Explanation
from taskgist.learning.understanding import Understanding, understand
from taskgist.settings import DEFAULT, Learning


@dataclass(frozen=True)
class Knowledge:
    """All that has been learned. Immutable: each change gives a new one."""

    experiences: FrozenMap[tuple[str, TreeOf], Experience] = field(default_factory=FrozenMap)
    """By task and by whose trees they are: what is known of performers stands apart. None is empty."""
    answers: frozenset[Answer] = frozenset()

    @property
    def tasks(self) -> tuple[str, ...]:
        """Names of the tasks, sorted."""
        return tuple(sorted({task for task, _ in self.experiences}))

    def trees_of(self, task: str) -> tuple[TreeOf, ...]:
        """Whose trees are known of a task; none if the task is not known."""
        return tuple(of for of in TREES_OF if (task, of) in self.experiences)

    @property
    def contexts(self) -> frozenset[Context]:
        """Settings and trees under which its explanations were made."""
        return frozenset(context for each in self.experiences.values() for context in each.contexts)

    @property
    def explanations(self) -> tuple[Explanation, ...]:
        """All explanations, by task, by whose tree it is, and by digest."""
        return tuple(
            self.experiences[key].explanations[digest]
            for key in sorted(self.experiences)
            for digest in sorted(self.experiences[key].explanations)
        )

    def experience(self, task: str, of: TreeOf = "target") -> Experience:
        """Experience of a task.

        Args:
            task: Its name.
            of: For whom: its target agents, or who performs it. Where it is only known of who performs it, as it is
                performed for nobody else, that is meant by both.

        Raises:
            UnknownNameError: The task is not known.
            KnowledgeError: It is not known of who performs it.
        """
        known = self.trees_of(task)
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
        experiences = dict(self.experiences)
        for key in {(each.task, each.tree_of) for each in explanations}:
            own = (each for each in explanations if (each.task, each.tree_of) == key)
            known = experiences.get(key, Experience(key[0]))
            experiences[key] = known.extended(own, allow_mixed=allow_mixed)
        return replace(self, experiences=FrozenMap(experiences))

    def rivals(self, explanation: Explanation) -> tuple[Explanation, ...]:
        """Explanations of the same recording, for an agent and object of its own, with another label or times."""
        return tuple(each for each in self.explanations if each.is_rival_of(explanation))

    def remove(self, task: str, digest: str) -> Knowledge:
        """This knowledge without one demonstration; a task without any is forgotten, its answers are not.

        Raises:
            UnknownNameError: There is no such task or explanation.
        """
        holding = (of for of in self.trees_of(task) if digest in self.experiences[task, of].explanations)
        of: TreeOf = next(holding, "target")
        left = self.experience(task, of).remove(digest)
        without = self.experiences.without((task, of))
        return replace(self, experiences=without.set((task, of), left) if left.explanations else without)

    def answer(self, *answers: Answer) -> Knowledge:
        """This knowledge and further answers."""
        return replace(self, answers=self.answers | frozenset(answers))

    def merge(self, other: Knowledge, *, allow_mixed: bool = False) -> Knowledge:
        """Union of both, in any order and grouping the same.

        Raises:
            KnowledgeError: As ``Experience.merge``.
        """
        return self.add(*other.explanations, allow_mixed=allow_mixed).answer(*other.answers)
