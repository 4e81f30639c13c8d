"""Peers: other learners that tell a task's demonstrations from others. CN2 of Orange runs in a process of its own.

Orange is licensed under the GPL. taskgist neither imports nor ships it: ``cn2_process`` is run as a program of its
own, if the user has installed Orange, and the two exchange lines of JSON.
"""

from __future__ import annotations

import json
import subprocess
import sys
from importlib import util
from types import ModuleType
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from taskgist.common import extras
from taskgist.common.arrays import Mask
from taskgist.errors import InputError
from taskgist_lab.evaluation.learner import Codes

# --- What a peer is: somebody who learns to tell a task's demonstrations from others, from values of nodes.

EXTRAS = {"sklearn": "peers", "Orange": "orange"}
"""The extra of taskgist that brings a module."""


class Peer(Protocol):
    """A learner of one concept.

    Attributes:
        name: Its name.
        text: What it is, in a few words.
    """

    name: str
    text: str

    def judge(self, positives: Codes, negatives: Codes, tests: Codes) -> Mask:
        """Learn, and say in which tests the concept holds.

        Args:
            positives: Codes of the task's demonstrations, (demonstrations, nodes).
            negatives: Codes of demonstrations of other tasks; may be empty.
            tests: Codes of demonstrations to judge.

        Returns:
            Whether it holds, (tests,).
        """

    def close(self) -> None:
        """Let go of whatever it holds."""


def door(module: str, peer: str) -> ModuleType:
    """An optional module.

    Raises:
        InputError: It is not installed.
    """
    loaded: ModuleType = extras.door(module, EXTRAS[module.partition(".")[0]], field="peer", value=peer)
    return loaded


PROGRAM = "taskgist_lab.evaluation.cn2_process"


class Cn2:
    """Orange's CN2 with its defaults.

    Raises:
        InputError: Orange is not installed.
    """

    name = "CN2"
    text = "Orange's CN2 rules, one task against the others, its defaults"

    def __init__(self) -> None:
        if util.find_spec("Orange") is None:
            raise extras.absent("Orange", EXTRAS["Orange"], field="peer", value=self.name)
        self._process = subprocess.Popen(
            [sys.executable, "-m", PROGRAM], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def judge(self, positives: Codes, negatives: Codes, tests: Codes) -> Mask:
        """Learn and judge; without negatives everything is of the one class that it knows."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        job = {"positives": positives.tolist(), "negatives": negatives.tolist(), "tests": tests.tolist()}
        self._process.stdin.write(json.dumps(job) + "\n")
        self._process.stdin.flush()
        answer = self._process.stdout.readline()
        if not answer:
            hint = "what it wrote above says why; leave it out, or mend the installation of Orange"
            raise InputError("the process of CN2 ended", field="peer", value=self.name, hint=hint)
        return np.array(json.loads(answer), dtype=bool)

    def close(self) -> None:
        """End the process."""
        self._process.communicate()


# --- A decision tree of scikit-learn: one task against the others.


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

    def judge(self, positives: Codes, negatives: Codes, tests: Codes) -> Mask:
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
