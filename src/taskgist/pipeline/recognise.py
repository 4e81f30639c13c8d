"""From recordings to tasks: what was done in each episode, for whom, with which thing.

An episode is told by a label, whose task plays no part: when something is done, by whom, for whom and with what. The
facts at both ends are explained as a demonstration's are, and the known tasks are asked for with them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import dataclass, field

from taskgist.common.frozen import FrozenMap
from taskgist.common.workers import Progress, silent
from taskgist.errors import KnowledgeError
from taskgist.facts.predicates import Predicate, known_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import TREES_OF, HypothesisTree, TreeOf, tree_of
from taskgist.learning.background import Background
from taskgist.learning.explanation import Explanation
from taskgist.learning.knowledge import Knowledge
from taskgist.observe.observer import Observer
from taskgist.pipeline.explain import explain_recording
from taskgist.recognition.label_proposal import propose_label
from taskgist.recognition.tasks import Recognised, Recogniser
from taskgist.recording.recording import Label, Recording
from taskgist.settings import DEFAULT, Settings

UNNAMED = "something"
"""What an episode is called whose task nobody named."""


@dataclass(frozen=True)
class RecognisedEpisode:
    """What was done in one episode.

    Args:
        label: When, by whom, for whom, with what; and the task, where somebody named it.
        proposed: Whether the label was proposed from the facts.
        explanation: The facts.
        recognised: Which of the known tasks it is.
        learned_from: Whether the knowledge was learned from this very recording.
    """

    label: Label
    proposed: bool
    explanation: Explanation
    recognised: Recognised
    learned_from: bool

    @property
    def named(self) -> str | None:
        """The task that the recording's label names; none where there is no label."""
        return None if self.proposed else self.label.task


@dataclass(frozen=True)
class TaskRecogniser:
    """What is known, learned once, to recognise any number of recordings with.

    Args:
        by_tree: By whose trees: target agents', or performing agents' own.
        recordings: Those that were learned from.
        tree: Of which nodes facts are.
        refused: Of trees in which tasks are known and none can be asked for: why.
    """

    by_tree: Mapping[TreeOf, Recogniser]
    recordings: frozenset[tuple[str, ...]]
    tree: HypothesisTree
    refused: Mapping[TreeOf, KnowledgeError] = field(default_factory=FrozenMap)

    @classmethod
    def of(
        cls, knowledge: Knowledge, tree: HypothesisTree = STANDARD_TREE, background: Background | None = None
    ) -> TaskRecogniser:
        """Learn each known task.

        Args:
            knowledge: What is known.
            tree: The tree that it was explained with.
            background: Neutral manipulations to compare with; the shipped ones by default.

        Raises:
            KnowledgeError: No task is known, or one alone and nothing to compare it with.
            ContradictionError: Answers about each task contradict each other.
        """
        known = [of for of in TREES_OF if any(whose == of for _, whose in knowledge.experiences)]
        if not known:
            raise KnowledgeError("nothing has been learned yet", hint="learn tasks first: taskgist learn RECORDINGS")
        recordings = frozenset(each.recording for each in knowledge.explanations)
        by_tree: dict[TreeOf, Recogniser] = {}
        refused: dict[TreeOf, KnowledgeError] = {}
        for of in known:
            try:
                by_tree[of] = Recogniser.of(knowledge, tree, of, background)
            except KnowledgeError as error:
                refused[of] = error
        if not by_tree:
            raise refused[known[0]]
        return cls(by_tree, recordings, tree, refused)

    @property
    def left_out(self) -> tuple[tuple[str, TreeOf], ...]:
        """Tasks that are not asked for, and in whose trees: answers about them contradict each other."""
        return tuple((task, of) for of, each in self.by_tree.items() for task in each.left_out)

    def check(self, of: TreeOf) -> None:
        """Refuse trees in which tasks are known and none can be asked for.

        Raises:
            KnowledgeError: They are such; says why.
        """
        if of in self.refused:
            raise copy(self.refused[of])  # each time with a trace of its own

    def recognise(
        self,
        recording: Recording,
        *,
        of: TreeOf = "target",
        settings: Settings = DEFAULT,
        predicates: Iterable[Predicate] | None = None,
        progress: Progress = silent,
    ) -> tuple[RecognisedEpisode, ...]:
        """Which known tasks are performed in a recording.

        Args:
            recording: With a label, whose task plays no part, or without.
            of: For whom: target agents, or who performs. Where somebody is alone, that is meant by both.
            settings: All settings.
            predicates: A user's own predicates; by default all that are known.
            progress: Told how far it is.

        Raises:
            LabelError: It has no label, and too little speaks for what happens.
            KnowledgeError: No task is known in the trees of these agents.
        """
        predicates = known_predicates() if predicates is None else tuple(predicates)
        observer = Observer(recording.scene, recording, settings)
        found = []
        for label in episodes_of_interest(recording, observer):
            whose: TreeOf = tree_of(of) if label.target_agents else "performer"
            self.check(whose)
            if whose not in self.by_tree:
                raise KnowledgeError(
                    "no task is known for target agents" if whose == "target" else "no task is known for who performs",
                    where=recording.name,
                    field="of",
                    value=whose,
                    hint="learn tasks in these trees: taskgist learn --of performer"
                    if whose == "performer"
                    else "learn tasks from recordings that have target agents, or ask with --of performer",
                )
            explanation = explain_recording(
                recording,
                label=label,
                of=whose,
                settings=settings,
                predicates=predicates,
                observer=observer,
                progress=progress,
            )
            recognised = self.by_tree[whose].recognise(explanation.nodes)
            known = explanation.recording in self.recordings
            found.append(RecognisedEpisode(label, recording.label is None, explanation, recognised, known))
        return tuple(found)


def episodes_of_interest(recording: Recording, observer: Observer) -> tuple[Label, ...]:
    """When something is done, by whom, for whom and with what: the recording's label, or else the proposed one.

    Args:
        recording: The recording.
        observer: One of this recording.

    Raises:
        LabelError: It has no label, and too little speaks for what happens.
    """
    return (recording.label or propose_label(recording, observer, task=UNNAMED),)
