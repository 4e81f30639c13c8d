"""What is done in a task, and in which order: the action component A of ⟨WI, A, WF⟩, over demonstrations (10).

What a task *means* are its effects; how it was done are means, of which there may be many. So both are learned apart,
from the same demonstrations and by the same learner. Its literals say here that something is done or not::

    (hand over by performer to target = yes)            it is done
    (grasp by target before release by performer = yes) both are done, and first the one for the first time

What all people do who move anything, *reach, grasp, lift, carry*, tells nothing of a task: by chance it is done in the
other tasks, too, and is among the usual circumstances. But it is how the task is done, and a robot wants to know it. So
the **sequence** is told as well: whatever is done in most demonstrations, in the order in which it mostly begins.

Demonstrations of which nobody knows what was done count neither way.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import permutations

from taskgist.errors import KnowledgeError
from taskgist.facts.tree import Node, TreeOf
from taskgist.learning.clauses import COVERAGE, ClausePosterior, learn_clauses, smoothed
from taskgist.learning.evidence import Evidence
from taskgist.learning.explanation import Explanation
from taskgist.learning.knowledge import Knowledge
from taskgist.learning.literals import Vocabulary

YES, NO = "yes", "no"


@dataclass(frozen=True)
class LearnedActions:
    """What is done in a task.

    Args:
        sequence: Names of what is done in most demonstrations, in the order in which it begins.
        support: In how many demonstrations it is all done in this order, and of how many is known what was done.
        chance: In which share of the other tasks' it is, the tasks weighing the same; None where none is known.
        posterior: What is done here and not elsewhere.
    """

    sequence: tuple[str, ...]
    support: tuple[int, int]
    chance: float | None
    posterior: ClausePosterior


def learn_actions(knowledge: Knowledge, task: str, of: TreeOf = "target") -> LearnedActions:
    """What is done in a task, compared with the other tasks whose actions are known.

    Args:
        knowledge: Explanations, some of which tell what was done.
        task: Its name.
        of: Whose explanations, as ``Knowledge.experience``.

    Raises:
        UnknownNameError: The task is not known.
        KnowledgeError: Of no demonstration of it is known what was done.
    """
    own = knowledge.experience(task, of)
    kinds = {
        name: [orders for each in experience.explanations.values() if (orders := _first_times(each)) is not None]
        for (name, whose), experience in knowledge.experiences.items()
        if whose == own.tree_of
    }
    seen = kinds[task]
    if not seen:
        hint = "learn it with --actions from its recordings, or actions=True in Python"
        raise KnowledgeError("of none of its demonstrations is known what was done", where=f"task {task}", hint=hint)
    names = sorted({name for each in seen for name in each})
    evidence = Evidence.of(
        {kind: [_told(each, names) for each in kinds[kind]] for kind in sorted(kinds) if kinds[kind]}
    )
    words = [Vocabulary(Node(name, 3, None, 2, name, (YES, NO))) for name in [*names, *map(_before, _pairs(names))]]
    sequence = _sequence(seen, names)
    shares = [_share(sequence, each) for name, each in sorted(kinds.items()) if name != task and each]
    return LearnedActions(
        sequence,
        (sum(_in_order(sequence, each) for each in seen), len(seen)),
        sum(shares) / len(shares) if shares else None,
        learn_clauses(evidence, task, words=words),
    )


def _first_times(explanation: Explanation) -> dict[str, tuple[float, int]] | None:
    """When each action was first begun, with its place among those of one moment; None where nobody looked."""
    if explanation.actions is None:
        return None
    found: dict[str, tuple[float, int]] = {}
    for number, action in enumerate(explanation.actions):
        found.setdefault(action.name, (action.start_s, number))
    return found


def _pairs(names: Iterable[str]) -> Iterable[tuple[str, str]]:
    return permutations(names, 2)


def _before(pair: tuple[str, str]) -> str:
    return f"{pair[0]} before {pair[1]}"


def _told(times: dict[str, tuple[float, int]], names: list[str]) -> dict[str, str]:
    """What was done, and before what, of what is done in a task."""
    done = {name: YES if name in times else NO for name in names}
    orders = {
        _before((a, b)): YES if a in times and b in times and times[a] < times[b] else NO for a, b in _pairs(names)
    }
    return done | orders


def _sequence(seen: list[dict[str, tuple[float, int]]], names: list[str]) -> tuple[str, ...]:
    """What is done in most demonstrations, by how much else it comes before."""
    usual = [name for name in names if sum(name in each for each in seen) >= COVERAGE * len(seen)]
    ahead = {
        name: sum(each[name] < each[other] for each in seen for other in usual if name in each and other in each)
        for name in usual
    }
    return tuple(sorted(usual, key=lambda name: (-ahead[name], name)))


def _in_order(sequence: tuple[str, ...], times: dict[str, tuple[float, int]]) -> bool:
    begun = [times[name] for name in sequence if name in times]
    return len(begun) == len(sequence) and begun == sorted(begun)


def _share(sequence: tuple[str, ...], seen: list[dict[str, tuple[float, int]]]) -> float:
    hits = sum(_in_order(sequence, each) for each in seen)
    return smoothed(hits, len(seen))
