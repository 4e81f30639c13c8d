"""Where agents looked, as far as a recording says so: simulated people as their heads do, others where signals say."""

from __future__ import annotations

import math
import pickle
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from taskgist.errors import RecordingError
from taskgist.observe import Observer
from taskgist.recording import Provenance, Recording, Signal, read, write
from taskgist.recording.signals import gaze_signals
from taskgist.world import Stage
from taskgist.world.state import AHEAD, EyeTurn
from tests.importing.recordings import FRAMES, recording

LEFT, UP = gaze_signals("P1")
DEGREES = np.array([0.0, 10.0, 20.0, math.nan, -30.0])


def looking(signals: Mapping[str, Signal], *, simulated: bool = False) -> Recording:
    return replace(recording(), signals=signals, provenance=Provenance(simulated=simulated))


def test_of_people_nothing_is_known_and_simulated_ones_look_where_their_heads_do() -> None:
    agents = recording().scene.agents
    assert dict(looking({}).state(0).eyes) == {}
    assert dict(looking({}, simulated=True).state(0).eyes) == dict.fromkeys(agents, AHEAD)


def test_signals_say_how_eyes_were_turned_and_where_they_are_unknown_so_is_the_gaze() -> None:
    told = looking({LEFT: Signal(DEGREES, "deg"), UP: Signal(np.full(FRAMES, -0.1), "rad")})
    for frame in (0, 1, 2, 4):
        assert dict(told.state(frame).eyes) == {"P1": EyeTurn(math.radians(DEGREES[frame]), -0.1)}
    assert dict(told.state(3).eyes) == {}
    alone = looking({LEFT: Signal(DEGREES, "deg")}, simulated=True)
    assert alone.state(1).eyes["P1"] == EyeTurn(math.radians(10.0), 0.0)
    assert alone.state(3).eyes["P1"] == AHEAD


def test_the_eye_turns_to_the_left_in_the_head() -> None:
    told, person = looking({LEFT: Signal(DEGREES, "deg")}), recording().scene.agent("P1")
    stage = Stage(told.scene, told.state(2))
    assert stage.eye_ahead(person).matrix.T @ stage.eye(person).matrix[:, 0] == pytest.approx(
        [math.cos(math.radians(20)), math.sin(math.radians(20)), 0.0], abs=1e-9
    )
    assert np.array_equal(stage.eye_row(person)[3:].reshape(3, 3), stage.eye(person).matrix)


def test_observers_leave_it_as_it_is() -> None:
    told = looking({LEFT: Signal(DEGREES, "deg")})
    assert Observer(told.scene, told).as_confirmed(told.state(2)).eyes["P1"] == told.state(2).eyes["P1"]


def test_it_comes_back_from_a_file_and_to_other_processes(tmp_path: Path) -> None:
    told = looking({LEFT: Signal(DEGREES + 1e-5, "deg"), UP: Signal(np.full(FRAMES, 0.12345), "rad")})
    write(told, tmp_path / "looking.mcap")
    for again in (read(tmp_path / "looking.mcap"), pickle.loads(pickle.dumps(told))):
        assert [dict(again.state(frame).eyes) for frame in range(FRAMES)] == [
            dict(told.state(frame).eyes) for frame in range(FRAMES)
        ]
        assert again.digest == told.digest
    state = told.state(2)
    assert pickle.loads(pickle.dumps(state)).eyes == state.eyes == state.without(["cup"]).with_holding(()).eyes


def test_it_is_part_of_what_was_recorded_and_other_signals_are_not() -> None:
    digests = {
        looking(signals).digest
        for signals in (
            {},
            {LEFT: Signal(DEGREES, "deg")},
            {UP: Signal(DEGREES, "deg")},
            {LEFT: Signal(DEGREES, "rad")},
            {LEFT: Signal(DEGREES + 1, "deg")},
        )
    }
    assert len(digests) == 5
    assert looking({"P1_grip": Signal(DEGREES, "N")}).digest == looking({}).digest == recording().digest


def test_a_gaze_in_newtons_is_refused() -> None:
    with pytest.raises(RecordingError, match=r"signals\['P1_gaze_left'\].unit.*got 'N'.*rad or deg"):
        looking({LEFT: Signal(DEGREES, "N")})
