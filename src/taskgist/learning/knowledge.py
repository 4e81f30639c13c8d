"""Knowledge: the experience of each task, with the answers that people gave."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from taskgist.common.frozen import FrozenMap
from taskgist.errors import UnknownNameError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree
from taskgist.learning.experience import Experience
from taskgist.learning.explanation import Context, Explanation
from taskgist.learning.understanding import Answer, Understanding, understand
from taskgist.settings import DEFAULT, Learning


@dataclass(frozen=True)
class Knowledge:
    """All that has been learned. Immutable: each change gives a new one."""

    experiences: FrozenMap[str, Experience] = field(default_factory=FrozenMap)
    """By task. None is empty."""
    answers: frozenset[Answer] = frozenset()

    @property
    def tasks(self) -> tuple[str, ...]:
        """Names of the tasks, sorted."""
        return tuple(sorted(self.experiences))

    @property
    def contexts(self) -> frozenset[Context]:
        """Settings and trees under which its explanations were made."""
        return frozenset(context for each in self.experiences.values() for context in each.contexts)

    @property
    def explanations(self) -> tuple[Explanation, ...]:
        """All explanations, by task and digest."""
        return tuple(
            self.experiences[task].explanations[digest]
            for task in self.tasks
            for digest in sorted(self.experiences[task].explanations)
        )

    def experience(self, task: str) -> Experience:
        """Experience of a task.

        Raises:
            UnknownNameError: There is none.
        """
        if task not in self.experiences:
            raise UnknownNameError("task", task, self.experiences)
        return self.experiences[task]

    def understand(
        self, task: str, tree: HypothesisTree = STANDARD_TREE, settings: Learning = DEFAULT.learning
    ) -> Understanding:
        """What a task means; see ``understand``.

        Raises:
            UnknownNameError: The task is not known.
        """
        return understand(self.experience(task), tree, settings, self.answers)

    def add(self, *explanations: Explanation, allow_mixed: bool = False) -> Knowledge:
        """This knowledge and further demonstrations, of any task.

        Raises:
            KnowledgeError: As ``Experience.add``.
        """
        experiences = dict(self.experiences)
        for task in {explanation.task for explanation in explanations}:
            own = (explanation for explanation in explanations if explanation.task == task)
            known = experiences.get(task, Experience(task))
            experiences[task] = known.extended(own, allow_mixed=allow_mixed)
        return replace(self, experiences=FrozenMap(experiences))

    def rivals(self, explanation: Explanation) -> tuple[Explanation, ...]:
        """Explanations of the same recording, for an agent and object of its own, with another label or times."""
        return tuple(each for each in self.explanations if each.is_rival_of(explanation))

    def remove(self, task: str, digest: str) -> Knowledge:
        """This knowledge without one demonstration; a task without any is forgotten, its answers are not.

        Raises:
            UnknownNameError: There is no such task or explanation.
        """
        left = self.experience(task).remove(digest)
        without = self.experiences.without(task)
        return replace(self, experiences=without.set(task, left) if left.explanations else without)

    def answer(self, *answers: Answer) -> Knowledge:
        """This knowledge and further answers."""
        return replace(self, answers=self.answers | frozenset(answers))

    def merge(self, other: Knowledge, *, allow_mixed: bool = False) -> Knowledge:
        """Union of both, in any order and grouping the same.

        Raises:
            KnowledgeError: As ``Experience.merge``.
        """
        return self.add(*other.explanations, allow_mixed=allow_mixed).answer(*other.answers)
