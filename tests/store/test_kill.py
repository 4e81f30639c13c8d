"""A short form of ``python -m tools.kill``: commands that learn are killed, and the knowledge is whole."""

from __future__ import annotations

from tools.kill import Attempt, Trial, killed


def test_nothing_acknowledged_is_lost_when_commands_are_killed() -> None:
    trial = killed(4, seed=1, writers=2, each_round=2)
    assert trial.faults == []
    assert trial.outcomes["killed"] >= 4


def test_the_same_on_a_server(database: str) -> None:
    trial = killed(3, seed=2, url=database, writers=2, each_round=3)
    assert trial.faults == []
    assert trial.outcomes["killed"] >= 3


def test_the_tool_sees_what_is_lost_and_what_is_half_there(tmp_path: object) -> None:
    trial = Trial(f"{tmp_path}/knowledge.db", seed=0, writers=1)
    lost = Attempt(1, frozenset({"a", "b"}))
    half = Attempt(2, frozenset({"c", "d"}), exit_code=-9)
    refused = Attempt(3, frozenset({"e"}), exit_code=2, said="locked")
    trial._kept = lambda: {"c", "x"}  # type: ignore[method-assign]
    assert list(trial._looked_at([lost, half, refused])) == [
        "1: acknowledged, but 2 are lost",
        "2: half-written: 1 of 2",
        "3: exit code 2: locked",
        "knowledge that nobody added",
    ]
