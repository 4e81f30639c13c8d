"""A part of the fuzzer, with a seed of its own: ``make fuzz`` runs 10,000 cases."""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
from pathlib import Path

import pytest

from taskgist.pipeline.shipped import shipped_study
from taskgist.world.scene import Scene
from tools import fuzz_checks
from tools.fuzz_cases import write_files
from tools.fuzz_mutations import OF_SUFFIX, copied, mutated
from tools.fuzz_names import NAMES, renamed
from tools.fuzz_rooms import rooms
from tools.fuzz_seeds import with_foreign_records
from tools.fuzz_tokens import OF_BYTES, OF_TEXT, Mutation

ROOT = Path(__file__).parent.parent
CASES, SEED = 40, 15

MUTATIONS = {name: each for group in (OF_BYTES, OF_TEXT, *OF_SUFFIX.values()) for name, each in group.items()}


def test_spoiled_inputs_break_nothing() -> None:
    """In a process of its own: one with threads, as those of tests are, cannot be forked safely."""
    command = [sys.executable, "-m", "tools.fuzz", "--cases", str(CASES), "--seed", str(SEED), "--json"]
    ran = subprocess.run(command, cwd=ROOT, env=os.environ, capture_output=True, text=True)
    assert ran.returncode in (0, 1), ran.stderr
    found = json.loads(ran.stdout)
    assert found["cases"] == CASES
    faults = [
        f"{each['fault']} {each['raised']}: python -m tools.fuzz --seed {each['seed']} --case {each['case']}"
        for each in found["faults"]
    ]
    assert not faults, "\n".join(faults)


@pytest.mark.parametrize("name", MUTATIONS)
def test_mutations_are_seeded_and_change_something(name: str) -> None:
    spoil: Mutation = MUTATIONS[name]
    text = b'{"name": "cup", "size_m": [0.1, 0.2], "at": {"x": 1}}\n# a line\n<body name="x" pos="0 0 1"/>\n' * 3
    if name in ("flipped", *OF_TEXT, *OF_BYTES):
        changed = [spoil(random.Random(seed), text) for seed in range(30)]
        assert changed == [spoil(random.Random(seed), text) for seed in range(30)]
        assert sum(each != text for each in changed) > 15


def test_what_cannot_be_taken_apart_is_spoiled_all_the_same() -> None:
    for name in ("a.npz", "a.json.gz", "a.mcap", "a.db", "a.json"):
        for seed in range(20):
            data, used = mutated(random.Random(seed), name, b"nothing of the kind")
            assert isinstance(data, bytes)
            assert used


@pytest.mark.parametrize(
    ("room", "scene", "taken", "by"),
    [
        ("crowded", "urdf.toml", "a/m.stl", "a_m.stl"),
        ("crowded", "urdf.toml", "a_m.stl", "a/m.stl"),
        ("crowded", "urdf.toml", "R_a_m.stl", "robot/a/m.stl"),
        ("crowded", "urdf.toml", "robot/a/m.stl", "a/m.stl"),
        ("many", "many.toml", "shapes/a/m.obj", "shapes/a_m.obj"),
        ("many", "many.toml", "shapes/R_a.obj", "a.obj"),
        ("many", "many.toml", "a.obj", "shapes/R_a.obj"),
        ("many", "many.toml", "shapes/hills.png", "colours/m.png"),
        ("composed", "room.toml", "shelf.obj", "wedge.obj"),
        ("composed", "room.toml", "m.stl", "a/m.stl"),
        ("composed", "room.toml", "a/m.stl", "m.stl"),
        ("composed", "room.toml", "stone.obj", "shelf.obj"),
    ],
)
def test_a_file_in_the_place_of_another_is_noticed(
    room: str, scene: str, taken: str, by: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    right, load = rooms()[room], Scene.load
    swapped = {**right, taken: right[by]}
    for folder, files in (("right", right), ("swapped", swapped)):
        write_files(tmp_path / folder, files)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path / "right")
    wrong = fuzz_checks.own_files(("query", scene))
    assert not wrong()
    monkeypatch.setattr(Scene, "load", lambda path: load(tmp_path / "swapped" / path))
    assert "another file in the place of" in wrong()


def test_records_of_others_that_are_lost_are_noticed(tmp_path: Path) -> None:
    ours, path = shipped_study()["show"][0].read_bytes(), tmp_path / "a.mcap"
    shared = with_foreign_records(ours)
    path.write_bytes(shared)
    wrong = fuzz_checks.others_records(("label", str(path)))
    path.write_bytes(copied(shared, lambda _: None))
    assert not wrong()
    path.write_bytes(ours)
    assert wrong().startswith("lost ")


@pytest.mark.parametrize("room", ["plain", "crowded"])
def test_names_are_others_in_files_and_command_alike(room: str) -> None:
    files, command = rooms()[room], ("query", "--agent", "P1", "--object", "cup")
    followed = 0
    for seed in range(40):
        changed, asked = renamed(random.Random(seed), files, ("P1",), command)
        assert (changed, asked) == renamed(random.Random(seed), files, ("P1",), command)
        assert all(b"[agents.P1]" not in content for name, content in changed.items() if name.endswith(".toml"))
        followed += asked != command
    assert 20 < followed < 40
    assert max(map(len, NAMES)) >= 100_000
