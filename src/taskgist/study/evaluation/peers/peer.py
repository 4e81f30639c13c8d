"""What a peer is: somebody who learns to tell a task's demonstrations from others, from values of nodes."""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from taskgist.errors import InputError
from taskgist.study.evaluation.coded import Codes

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

    def judge(self, positives: Codes, negatives: Codes, tests: Codes) -> NDArray[np.bool_]:
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
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise absent(module, peer) from error


def absent(module: str, peer: str) -> InputError:
    """The error of a peer that is not installed."""
    root = module.partition(".")[0]
    hint = f"install it: pip install 'taskgist[{EXTRAS[root]}]'"
    return InputError(f"{module} is not installed", field="peer", value=peer, hint=hint)
