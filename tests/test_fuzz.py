"""A part of the fuzzer, with a seed of its own: ``make fuzz`` runs 10,000 cases."""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
from pathlib import Path

import pytest

from tools.fuzz_mutations import OF_SUFFIX, mutated
from tools.fuzz_tokens import OF_BYTES, OF_TEXT, Mutation

ROOT = Path(__file__).parent.parent
CASES, SEED = 500, 11

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
