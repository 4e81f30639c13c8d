"""What a frame costs in memory does not grow with what is written of it: hours fit where minutes do."""

from __future__ import annotations

import dataclasses
import itertools
import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from taskgist.observe import Observer, carrying, observer
from taskgist.observe import frames as frames_module
from taskgist.pipeline import check
from taskgist.recording import Recording, columns, container, foxglove, mcap, read, relabel, write
from taskgist.recording import recording as recorded
from tests.importing.recordings import LABEL, recording, room

SHORT, LONG = 320, 960


@pytest.fixture(scope="module", autouse=True)
def small_blocks() -> Iterator[None]:
    """So that a minute has as many of them as hours have of ordinary ones."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mcap, "_CHUNK_BYTES", 2**16)
        patch.setattr(container, "_PIECE_BYTES", 2**12)
        for module, name in [(columns, "ROWS"), (foxglove, "BLOCK"), (mcap, "BLOCK"), (recorded, "BLOCK")]:
            patch.setattr(module, name, 32)
        for module in (carrying, frames_module, observer):
            patch.setattr(module, "KEPT_FRAMES", 32)
        yield


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    folder = tmp_path_factory.mktemp("long")
    paths = {frames: folder / f"{frames}.mcap" for frames in (SHORT, LONG)}
    for frames, path in paths.items():
        write(repeated(frames), path)
    return paths


def repeated(frames: int) -> Recording:
    """A short recording over and over, each time a little different."""
    once = recording(label=LABEL)
    rng = np.random.default_rng(0)
    qpos = np.tile(np.asarray(once.qpos), (-(-frames // len(once)), 1))[:frames]
    for agent in room().agents:
        joints = room().joint_indices(agent)
        qpos[:, joints] += 0.01 * rng.normal(size=(frames, len(joints)))
    return Recording(room(), np.arange(frames) / 30, qpos, label=LABEL, name="long")


def bytes_per_frame(work: Callable[[int], object]) -> float:
    """How much more memory is taken at most for each frame more."""
    work(SHORT)  # what is loaded and kept once
    most = {}
    for frames in (SHORT, LONG):
        tracemalloc.start()
        work(frames)
        _, most[frames] = tracemalloc.get_traced_memory()
        tracemalloc.stop()
    return (most[LONG] - most[SHORT]) / (LONG - SHORT)


def test_reading_holds_half_a_number_for_each(files: dict[int, Path]) -> None:
    """A message has some 6 kB of text, a frame nq numbers; packed they have four bytes each."""
    assert bytes_per_frame(lambda frames: read(files[frames])) < 4 * room().nq + 300


def test_writing_holds_nothing_but_the_index(tmp_path: Path) -> None:
    long = {frames: repeated(frames) for frames in (SHORT, LONG)}
    assert bytes_per_frame(lambda frames: write(long[frames], tmp_path / "out.mcap")) < 400


def test_labelling_holds_what_reading_holds(files: dict[int, Path]) -> None:
    tasks = itertools.count()

    def renamed(frames: int) -> None:
        relabel(files[frames], lambda _: dataclasses.replace(LABEL, task=f"task {next(tasks)}"))

    assert bytes_per_frame(renamed) < 4 * room().nq + 300


def test_watching_holds_times_and_no_more(files: dict[int, Path]) -> None:
    opened = {frames: read(path) for frames, path in files.items()}

    def watch(frames: int) -> None:
        watching = Observer(opened[frames].scene, opened[frames])
        assert watching.motion("cup").intervals
        assert watching.hand("P1", "left").intervals

    assert bytes_per_frame(watch) < 1000


def test_checking_and_digests_hold_blocks(files: dict[int, Path]) -> None:
    """A check asks who has things at any time, so for every hand: what was found of 4,096 frames is kept, no more."""
    opened = {frames: read(path) for frames, path in files.items()}
    assert bytes_per_frame(lambda frames: (check(opened[frames]), opened[frames].digest)) < 3000
