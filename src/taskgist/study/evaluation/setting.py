"""Settings: what is wrong with the demonstrations that are learned from."""

from __future__ import annotations

from dataclasses import dataclass

from taskgist.study.evaluation.conditions import CONDITIONS
from taskgist.study.evaluation.sample import CLEAN

WRONG_PERCENT = (5, 10, 20)


@dataclass(frozen=True)
class Setting:
    """What is wrong with the demonstrations.

    Args:
        name: Its name.
        text: In a few words.
        condition: Under which they are watched.
        wrong_share: Probability of each to be a wrong one.
    """

    name: str
    text: str
    condition: str = CLEAN
    wrong_share: float = 0.0


SETTINGS = (
    *(Setting(each.name, each.text, each.name) for each in CONDITIONS.values()),
    *(
        Setting(f"wrong-{percent}", f"{percent} % wrong demonstrations", wrong_share=percent / 100)
        for percent in WRONG_PERCENT
    ),
)
"""All settings, the clean one first."""
