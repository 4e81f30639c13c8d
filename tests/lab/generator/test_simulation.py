"""A demonstration follows from task, seed and number alone."""

import pytest

from taskgist.errors import InputError, SceneError, UnknownNameError
from taskgist_lab.generator import WAYS, Series, note, simulate, simulate_all
from taskgist_lab.generator.simulation import MOST_ATTEMPTS, name_of

TASK, SEED = "show", 3


def test_the_same_alone_among_others_and_on_several_cores() -> None:
    together = list(simulate_all(TASK, count=2, seed=SEED, means="turn", processes=2))
    alone = simulate(TASK, seed=SEED, number=1, means="turn")
    assert [recording.name for recording in together] == ["show-3-000000", "show-3-000001"]
    assert together[1].digest == alone.digest
    assert together[1].label == alone.label
    assert together[1].provenance == alone.provenance
    assert together[0].digest != together[1].digest


def test_a_means_that_is_asked_for_is_the_one_that_is_drawn() -> None:
    drawn = simulate(TASK, seed=SEED, number=0)
    means = note(drawn, "means")
    assert simulate(TASK, seed=SEED, number=0, means=means).digest == drawn.digest


def test_another_seed_is_another_demonstration() -> None:
    assert (
        simulate(TASK, seed=4, number=0, means="turn").digest != simulate(TASK, seed=3, number=0, means="turn").digest
    )


def test_notes_say_how_it_came_about() -> None:
    recording = simulate(TASK, seed=SEED, number=0, means="turn")
    assert recording.provenance.simulated
    assert [note(recording, name) for name in ("means", "seed", "number")] == ["turn", "3", "0"]
    assert 0 <= int(note(recording, "attempt")) < MOST_ATTEMPTS
    with pytest.raises(InputError, match="no note on its weather"):
        note(recording, "weather")


def test_progress_is_told() -> None:
    told: list[tuple[str, float]] = []
    made = simulate_all(
        TASK, count=1, seed=SEED, means="turn", processes=1, progress=lambda what, share: told.append((what, share))
    )
    assert [recording.name for recording in made] == ["show-3-000000"]
    assert told == [("show-3-000000", 1.0)]


def test_names() -> None:
    assert name_of("put away", 7, 12) == "put-away-7-000012"


@pytest.mark.parametrize("task", WAYS)
def test_each_means_has_a_name_of_its_own(task: str) -> None:
    names = [way.name for way in WAYS[task]]
    assert len(set(names)) == len(names)
    assert {way.task for way in WAYS[task]} == {task}


def test_unknown_tasks_and_means() -> None:
    with pytest.raises(UnknownNameError, match="no task 'shwo'; did you mean 'show'"):
        simulate("shwo", seed=0, number=0)
    with pytest.raises(UnknownNameError, match="no means to show 'tunr'; did you mean 'turn'"):
        simulate("show", seed=0, number=0, means="tunr")
    with pytest.raises(UnknownNameError, match="no task"):
        simulate_all("shwo", seed=0, count=1)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"seed": -1}, r"seed: too small \(got -1\); give a whole number from 0 on"),
        ({"count": 0}, r"count: too small \(got 0\); give a whole number from 1 on"),
        ({"processes": 0}, r"processes: too small \(got 0\)"),
    ],
)
def test_numbers_that_cannot_be_are_refused_before_any_work(wrong: dict[str, int], message: str) -> None:
    numbers = {"seed": 0, "count": 1, "processes": 1, **wrong}
    with pytest.raises(InputError, match=message):
        simulate_all(TASK, seed=numbers["seed"], count=numbers["count"], processes=numbers["processes"])
    with pytest.raises(InputError, match="number: too small"):
        simulate(TASK, seed=0, number=-1)


def test_the_performer_does_not_try_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("taskgist_lab.generator.simulation.attempted", _never)
    with pytest.raises(
        SceneError, match=r"show-0-000005: no way to show \(turn\) in 100 rooms; the last one: too small"
    ):
        simulate(TASK, seed=0, number=5, means="turn")


def test_a_series_is_checked_when_it_is_made() -> None:
    with pytest.raises(UnknownNameError):
        Series("show", 0, "tunr")


def _never(*_: object) -> None:
    raise SceneError("too small")
