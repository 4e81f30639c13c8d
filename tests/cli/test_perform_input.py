"""What ``taskgist perform`` is asked with: names, places and times, each refused with its way out."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from taskgist.learning import Knowledge
from taskgist.pipeline import shipped_room
from taskgist.store import save
from taskgist.world import AgentEntry, Scene
from tests.cli.running import refusal
from tests.shipped import knowledge, names_of, recording

ROOM = str(shipped_room())
ASKED = "--robot Jido --for P2 --object cup"
REFUSED = {
    f"perform hide {ROOM} {ASKED} -k k.db --at 1,2": "neither a time nor a place (got '1,2'); one time",
    f"perform hide {ROOM} {ASKED} -k k.db --at 1,2,x": "--at: no number (got '1,2,x')",
    f"perform hide {ROOM} {ASKED} -k k.db --at 1,nan,0": "--at: neither a time nor a place (got '1,nan,0')",
    f"perform hide {ROOM} {ASKED} -k k.db --at 1,2,3 --at 3,2,1": "neither a time nor a place (got '1,2,3 3,2,1')",
    f"perform hide {ROOM} {ASKED} -k k.db --at 3.5": "--at: a scene has no time (got 3.5)",
    f"perform hide {ROOM} {ASKED} -k k.db --at 1,0,90": "--robot: is in the room already, where it stays",
    f"perform hide {ROOM} --robot pr3 --for P2 --object cup -k k.db --at 1,0,90": "no profile 'pr3'; did you mean",
    f"perform hide {ROOM} --robot pr2 --for P2 --object cup -k k.db": "it is placed there by --at X,Y,YAW",
    f"perform hide {ROOM} --robot Jodi --for P2 --object cup -k k.db": "--robot: no agent 'Jodi' (known: Jido, P2)",
    f"perform hide {ROOM} --robot Jido --for P3 --object cup -k k.db": "--for: no agent 'P3'; did you mean 'P2'",
    f"perform hide {ROOM} {ASKED} -k k.db --for P3": "--for: no agent 'P3'; did you mean 'P2'",
    f"perform hide {ROOM} {ASKED} -k k.db --for Jido": "--for: a task is performed for another (got 'Jido')",
    f"perform hide {ROOM} {ASKED} -k k.db --for P2": "--for: one stands twice (got 'P2 P2'); name each once",
    f"perform hide {ROOM} {ASKED} -k k.db --object cup": "--object: one stands twice (got 'cup cup'); name each once",
    f"perform hide {ROOM} {ASKED} -k k.db --object pen": "--object: no object 'pen'",
    f"perform hide {ROOM} --robot Jido --for P2 --object cop -k k.db": "--object: no object 'cop'; did you mean 'cup'?",
    f"perform hide {ROOM} --for P2 --object cup -k k.db": "--robot: not given; one of Jido, P2",
    f"perform hide {ROOM} --robot P2 --for P2 --object cup -k k.db": "--for: a task is performed for another",
    f"perform hide {ROOM} {ASKED} -k k.db --attention tv": "no attention 'tv' (known: performer, stays,",
    f"perform hide {ROOM} {ASKED} -k k.db --allow tabel": "no support 'tabel'; did you mean 'table'?",
    f"perform hide {ROOM} {ASKED} -k k.db --rule bays": "--rule: no rule 'bays'; did you mean 'bayes'?",
    f"perform hid {ROOM} {ASKED} -k k.db --rule bayes": "no task 'hid'; did you mean 'hide'?",
    f"perform hid {ROOM} {ASKED} -k k.db": "no task 'hid'; did you mean 'hide'?",
    f"perform hide {ROOM} {ASKED} -k empty.db": "no task 'hide'",
    f"perform hide {ROOM} {ASKED} -k none.db": "none.db",
    f"perform hide room.toml {ASKED} -k k.db": "room.toml",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("asked")
    save(knowledge("hide"), path / "k.db")
    save(Knowledge(), path / "empty.db")
    return path


@pytest.mark.parametrize("line", REFUSED)
def test_refusals(line: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    told = " ".join(refusal(line, folder).split())
    assert REFUSED[line] in told, told


def test_who_comes_into_a_room_leaves_all_others_where_they_were() -> None:
    recorded = recording(names_of("hide")[0])
    before = recorded.scene
    state = recorded.at(float(recorded.times_s[-1]))
    scene, joined = before.joined_by(AgentEntry("PR2", "pr2", (-3.0, 1.0), math.radians(90.0)), state)
    assert scene.agents == (*before.agents, "PR2")
    assert scene.objects == before.objects
    there = dict(zip(scene.columns, joined.qpos.tolist(), strict=True))
    assert {name: there[name] for name in before.columns} == dict(zip(before.columns, state.qpos.tolist(), strict=True))
    assert joined.qpos[scene.agent("PR2").base][:2].tolist() == [-3.0, 1.0]
    assert (joined.time_s, joined.untracked, joined.holding) == (state.time_s, state.untracked, state.holding)
    again = Scene.from_bundle(scene.bundle)
    assert np.array_equal(again.initial.qpos, scene.initial.qpos)
