"""A decision tree of scikit-learn: one task against the others."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskgist.study.evaluation.coded import Codes
from taskgist.study.evaluation.peers.peer import door


class DecisionTree:
    """A tree of tests on single values, of any depth, as the package sets it by default.

    Each value of each node is a feature that is there or not; what is unknown has none.

    Args:
        seed: Decides between splits that are equally good.

    Raises:
        InputError: scikit-learn is not installed.
    """

    name = "decision tree"
    text = "scikit-learn's, one task against the others, its defaults"

    def __init__(self, seed: int) -> None:
        self._trees = door("sklearn.tree", self.name)
        self._seed = seed

    def judge(self, positives: Codes, negatives: Codes, tests: Codes) -> NDArray[np.bool_]:
        """Learn and judge; without negatives everything is of the one class that it knows."""
        seen = np.concatenate((positives, negatives))
        values = [np.unique(column[column >= 0]) for column in seen.T]
        classes = np.repeat((1, 0), (len(positives), len(negatives)))
        tree = self._trees.DecisionTreeClassifier(random_state=self._seed).fit(_features(seen, values), classes)
        return np.asarray(tree.predict(_features(tests, values)) == 1)

    def close(self) -> None:
        """Nothing to let go of."""


def _features(codes: Codes, values: list[NDArray[np.int32]]) -> NDArray[np.float32]:
    """One column for each value of each node, (demonstrations, features); a value that was never seen has none."""
    columns = [codes[:, [node]] == of_node for node, of_node in enumerate(values)]
    return np.concatenate(columns, axis=1).astype(np.float32)
