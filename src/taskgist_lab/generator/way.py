"""A way: one means of one task."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from taskgist.recording.recording import Recording
from taskgist_lab.generator.arrangement import Setting
from taskgist_lab.simulator.means import Means

Check = Callable[[Recording], None]


def contented(_recording: Recording) -> None:
    """Find nothing wrong."""


@dataclass(frozen=True)
class Way:
    """One means of one task.

    Attributes:
        task: Name of the task.
        name: Name of the means, as users give it: lower case, words joined by hyphens.
        stage: Chooses a setting in which the means makes sense; raises a SceneError where something has no room.
        means: What the performer does in a setting.
        check: What the performer sees when it looks at the outcome: raises a SceneError where its intention is not
            reached.
    """

    task: str
    name: str
    stage: Callable[[np.random.Generator], Setting]
    means: Callable[[Setting], Means]
    check: Check = contented
