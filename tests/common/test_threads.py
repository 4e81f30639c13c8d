"""Threads: every part is done once, and what one of them raises is not lost."""

from __future__ import annotations

import os
import threading

import pytest

from taskgist.common import workers
from taskgist.common.workers import cores, on_threads


def test_every_part_is_done_once() -> None:
    done: list[int] = []
    on_threads(done.append, range(100))
    assert sorted(done) == list(range(100))


def test_what_a_part_raises_arrives() -> None:
    with pytest.raises(ZeroDivisionError):
        on_threads(lambda part: 1 // part, [1, 0, 2])


@pytest.mark.skipif(cores() == 1, reason="needs two cores")
def test_parts_are_done_at_the_same_time() -> None:
    both = threading.Barrier(2, timeout=10)
    on_threads(lambda _: both.wait(), range(2))


def test_on_one_core_no_thread_is_started(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "cores", lambda: 1)
    names: set[str] = set()
    on_threads(lambda _: names.add(threading.current_thread().name), range(os.cpu_count() or 2))
    assert names == {threading.current_thread().name}
