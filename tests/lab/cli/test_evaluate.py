"""``taskgist evaluate``: on a pool that is there already; nothing is played."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner, Result

from taskgist_lab.cli.evaluate import EXPERIMENTS, HELD_OUT_SEED, evaluate
from taskgist_lab.evaluation.pool import write_pool
from tests.lab.evaluation.pools import study_pool
from tests.schemas import hold_to_schema

app = typer.Typer(rich_markup_mode=None, add_completion=False, pretty_exceptions_enable=False)
app.command("evaluate")(evaluate)


@pytest.fixture(scope="module")
def pool(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("pools") / "pool.json.gz"
    write_pool(study_pool(12), path)
    return path


def run(*words: object) -> Result:
    outcome = CliRunner().invoke(app, [str(word) for word in words], env={"COLUMNS": "120"})
    assert outcome.exception is None or isinstance(outcome.exception, SystemExit), repr(outcome.exception)
    return outcome


def on(pool: Path, *words: object) -> Result:
    return run(*words, "--pool", pool, "--source", "study", "-n", 12, "--runs", 5)


def document(pool: Path, *words: object) -> dict[str, Any]:
    outcome = on(pool, *words, "--json")
    assert (outcome.exit_code, outcome.stderr) == (0, "")
    found: dict[str, Any] = json.loads(outcome.stdout)
    hold_to_schema("evaluate", found)
    return found


def test_tables_say_what_was_measured(pool: Path) -> None:
    outcome = on(pool, "needed", "transfer")
    assert (outcome.exit_code, outcome.stderr) == (0, "")
    for words in ("make accessible", "hide away", "the paper's study", "recall, clause", "seed 1000: "):
        assert words in outcome.stdout


def test_json_is_one_document_with_everything(pool: Path) -> None:
    found = document(pool, "needed", "transfer")
    assert found["pool"]["demonstrations"]["hide"] == 12
    assert {"pool", "runs", "pictures", "needed", "transfer"} == found.keys()
    assert {row["task"] for row in found["needed"]["rows"]} == set(found["pool"]["demonstrations"])
    assert {table["after"] for table in found["transfer"]["tables"]} == {1, 2, 3, 5}  # eight to learn from


def test_the_same_call_gives_the_same_answer_and_leaves_the_pool_alone(pool: Path) -> None:
    before = pool.read_bytes()
    assert document(pool, "needed") == document(pool, "needed")
    assert pool.read_bytes() == before


def test_order_of_experiments_is_theirs(pool: Path) -> None:
    names = [name for name in document(pool, "transfer", "needed") if name in EXPERIMENTS]
    assert names == ["needed", "transfer"]


def test_pictures_are_saved_where_asked(pool: Path, tmp_path: Path) -> None:
    found = document(pool, "needed", "transfer", "-o", tmp_path)
    assert found["pictures"] == [str(tmp_path / f"evaluation_{name}.png") for name in ("needed", "transfer")]
    assert all(Path(path).read_bytes().startswith(b"\x89PNG") for path in found["pictures"])


def test_help_names_experiments_seed_and_an_example() -> None:
    text = run("--help").stdout
    for words in (*EXPERIMENTS, str(HELD_OUT_SEED), "held out", "Example: taskgist evaluate", "--pool"):
        assert words in text


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("sleep",), "no experiment 'sleep'"),
        (("needed", "-n", 2), "--demonstrations"),
        (("needed", "--runs", 0), "--runs"),
        (("needed", "--source", "dreams"), "no source 'dreams'"),
        (("needed", "--pool", "nowhere/pool.json.gz"), "--pool: cannot be written: there is no folder"),
        (("needed", "--processes", 0), "--processes"),
        (("needed", "--seed", -1), "--seed: negative"),
        (("perform", "--rooms", 0), "--rooms"),
        (("perform", "--robot", "r2d2"), "no robot that is measured 'r2d2'"),
        (("perform", "--task", "sleep"), "no task of the study 'sleep'"),
    ],
)
def test_misuse_is_refused(words: tuple[object, ...], message: str) -> None:
    outcome = run(*words)
    assert (outcome.exit_code, outcome.stdout) == (2, "")
    assert outcome.stderr.count("error:") == 1
    assert message in outcome.stderr


def test_a_pool_of_another_source_or_of_nothing_is_refused(pool: Path, tmp_path: Path) -> None:
    outcome = run("needed", "--pool", pool, "--source", "generator")
    assert outcome.exit_code == 2
    assert "source: the pool is another one" in outcome.stderr
    nothing = tmp_path / "pool.json.gz"
    nothing.write_text("nothing")
    outcome = run("needed", "--pool", nothing)
    assert (outcome.exit_code, nothing.read_text()) == (2, "nothing")
    assert "not a pool" in outcome.stderr


def test_the_pool_may_be_larger_than_what_is_asked_for(pool: Path) -> None:
    outcome = run("needed", "--pool", pool, "--source", "study", "-n", 6, "--runs", 2, "--json")
    assert set(json.loads(outcome.stdout)["pool"]["demonstrations"].values()) == {6}


def test_neutral_manipulations_are_no_source_to_learn_tasks_from() -> None:
    outcome = run("needed", "--source", "neutral")
    assert outcome.exit_code == 2
    assert "no source 'neutral'" in outcome.stderr
    assert "generator, study" in outcome.stderr


def test_whole_clauses_are_measured_beside_the_papers_rule(pool: Path, tmp_path: Path) -> None:
    words = ("clauses", "--pool", pool, "--source", "study", "-n", 6, "--runs", 1, "-o", tmp_path)
    outcome = run(*words)
    assert (outcome.exit_code, outcome.stderr) == (0, "")
    for told in ("clauses, no other tasks", "clauses, 5 other tasks", "the paper's rule", "one wrong in ten"):
        assert told in outcome.stdout
    assert (tmp_path / "evaluation_clauses.png").exists()
