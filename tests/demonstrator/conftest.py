"""Recordings of the study, made once."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from taskgist.demonstrator import STUDIES
from taskgist.recording import Recording


@pytest.fixture(scope="session")
def recorded() -> Callable[[str], Recording]:
    demonstrations = {d.name: d for study in STUDIES.values() for d in study}
    made: dict[str, Recording] = {}

    def get(name: str) -> Recording:
        if name not in made:
            made[name] = demonstrations[name].record(seed=1)
        return made[name]

    return get
