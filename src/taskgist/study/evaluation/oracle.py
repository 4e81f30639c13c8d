"""Somebody who answers questions: who knows the clauses that the paper printed, and no demonstration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.study.evaluation.coded import UNKNOWN_CODE, Coded, Codes
from taskgist.study.paper.published import CLAUSES


@dataclass(frozen=True, eq=False)
class Oracle:
    """Somebody who knows what a task means and answers questions.

    Attributes:
        kept: Whether each node is part of the task, (nodes,).
        values: Code of the value that each must have, (nodes,); -1: whichever was seen most often.
    """

    kept: NDArray[np.bool_]
    values: Codes


def published_oracle(task: str, coded: Coded) -> Oracle:
    """Who has read the paper's clause of a task (Eq. 37 to 42).

    Its predicates are relevant, with their values; what stands above them in the tree is relevant, too, with whichever
    value was seen most often; everything else is irrelevant.

    Raises:
        KeyError: The paper has no clause of this task.
    """
    names = coded.pool.nodes
    kept = np.zeros(len(names), dtype=bool)
    values = np.full(len(names), UNKNOWN_CODE, dtype=np.int32)
    for predicate in CLAUSES[task].predicates:
        column = coded.index(predicate.node)
        if predicate.value in coded.values[column]:  # else no demonstration ever shows it
            values[column] = coded.code(predicate.node, predicate.value)
        name: str | None = predicate.node
        while name is not None:
            kept[coded.index(name)] = True
            name = coded.nodes[coded.index(name)].parent
    return Oracle(kept, values)
