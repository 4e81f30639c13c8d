"""The command line starts at once: commands load what they need, and what others add breaks nothing."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest

from taskgist.cli.app import GROUP, OWN
from taskgist.facts import STANDARD_TREE, parse_facts
from taskgist.learning import explain
from taskgist.store import update
from tests.command_lines import commands

HEAVY = ("mujoco", "numba", "numpy", "matplotlib", "sqlalchemy", "rich")
LOADED = f"""
import sys, json
sys.argv = ["taskgist", *sys.argv[1:]]
from taskgist.cli import main
try:
    main()
except SystemExit:
    ours = [name for name in sys.modules if name.split(".")[0] in ("taskgist", "taskgist_lab")]
    print(json.dumps([len(ours), [name for name in {HEAVY} if name in sys.modules]]))
"""
BLOCKED = """
import sys
sys.modules.update(dict.fromkeys(("mujoco", "numba", "numpy")))  # importing one raises ImportError
"""
RUN = "from taskgist.cli import main; main()"
FACTS = {
    "schema": "taskgist.facts/1",
    "task": "show",
    "demonstration": "annotated",
    "performing_agent": "P1",
    "target_agent": "P2",
    "target_object": "cup",
    "start": {"see.effort": "Head_Effort"},
    "end": {"see.effort": "No_Effort_Required"},
}


def python(code: str, *words: str, path: str = "", status: int = 0) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([path, *sys.path])}
    done = subprocess.run(
        [sys.executable, "-c", code, *words], env=environment, capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == status, done.stderr
    return done


@pytest.mark.parametrize("option", ["--version", "--help"])
def test_few_modules_are_loaded(option: str) -> None:
    ours, heavy = json.loads(python(LOADED, option).stdout.splitlines()[-1])
    assert ours <= 60
    assert heavy == []


@pytest.fixture
def knowledge(tmp_path: Path) -> str:
    update(tmp_path / "knowledge.db", [explain(parse_facts(FACTS, STANDARD_TREE, where="here"))])
    return str(tmp_path / "knowledge.db")


@pytest.mark.parametrize(
    "words", [(), ("show",), ("show", "--why", "see.class"), ("show", "--json"), ("show", "--rule", "bayes")]
)
def test_explaining_needs_neither_mujoco_nor_numba_nor_numpy(knowledge: str, words: tuple[str, ...]) -> None:
    assert python(BLOCKED + RUN, "explain", *words, "-k", knowledge).stdout


def test_learning_from_knowledge_and_facts_needs_them_neither(knowledge: str, tmp_path: Path) -> None:
    (tmp_path / "told.json").write_text(json.dumps(FACTS | {"demonstration": "told"}), encoding="utf-8")
    words = ("learn", knowledge, str(tmp_path / "told.json"), "-k", str(tmp_path / "other.db"))
    assert "by the paper's rule, from 2 demonstrations" in python(BLOCKED + RUN, *words).stdout


@pytest.mark.parametrize("room", ["facts", "learning", "store", "language"])
def test_the_symbolic_rooms_need_neither_mujoco_nor_numba_nor_numpy(room: str) -> None:
    python(f"{BLOCKED}import taskgist.{room} as room\nassert [getattr(room, name) for name in room.__all__]")


def test_ours_are_the_commands_of_the_engine_and_those_that_the_lab_adds() -> None:
    groups = {name.partition(" ")[0] for name in commands()}
    assert groups == {entry.name for entry in OWN} | {"simulate", "paper", "evaluate"}


def package(folder: Path, source: str, *entries: str) -> None:
    """An installed package with one module, and the commands that it adds."""
    (folder / "others.py").write_text(source, encoding="utf-8")
    about = folder / "others-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: others\nVersion: 1.0\n", encoding="utf-8")
    (about / "entry_points.txt").write_text("\n".join([f"[{GROUP}]", *entries, ""]), encoding="utf-8")


OTHERS = '''
import sys
sys.stdout.write("imported\\n")
import typer
from taskgist.cli.common import JsonOption, command, print_json
from taskgist.errors import InputError


@command
def count(number: int, as_json: JsonOption = False) -> int:
    """Count.

    As far as asked.
    """
    if number < 0:
        raise InputError("too few", field="NUMBER", value=number)
    print_json(number)
    return 1


made = (lambda function: function)(count)
group = typer.Typer(help="A group of commands.")


@group.command()
def first() -> None:
    """Be the first."""


@group.command()
def second() -> None:
    """Be the second."""
'''


def test_other_packages_add_commands(tmp_path: Path) -> None:
    package(tmp_path, OTHERS, "count = others:count", "group = others:group", "learn = others:count")
    path = str(tmp_path)
    listed = python(RUN, "--help", path=path).stdout
    assert "  count      Count.\n" in listed
    assert "  group      A group of commands.\n" in listed
    assert "imported" not in listed, "a help that its source tells needs no import"
    assert listed.count("  learn ") == 1, "a name of ours is ours"
    assert python(RUN, "count", "3", "--json", path=path, status=1).stdout == "imported\n3\n"
    assert python(RUN, "count", "--", "-3", path=path, status=2).stderr.startswith("error: NUMBER: too few")
    assert "As far as asked." in python(RUN, "count", "--help", path=path).stdout
    assert "second  Be the second." in python(RUN, "group", "--help", path=path).stdout


def test_a_help_that_its_source_does_not_tell_is_asked_from_the_command(tmp_path: Path) -> None:
    package(tmp_path, OTHERS, "made = others:made")
    assert "  made       Count.\n" in python(RUN, "--help", path=str(tmp_path)).stdout


BROKEN = "import no_such_module\nmade = no_such_module.command\n\n\ndef count() -> None:\n    '''Count.'''\n"


def test_what_is_broken_elsewhere_breaks_nothing_here(tmp_path: Path) -> None:
    entries = ("count = others:count", "made = others:made", "gone = no_such_package.cli:gone")
    package(tmp_path, BROKEN, *entries)
    path = str(tmp_path)
    assert python(RUN, "--version", path=path).stdout == f"taskgist {metadata.version('taskgist')}\n"
    listed = " ".join(python(RUN, "--help", path=path).stdout.split())
    for name, module in (("made", "no_such_module"), ("gone", "no_such_package")):
        told = f"command {name!r} of package 'others' cannot be loaded: ModuleNotFoundError: No module named {module!r}"
        assert f"{name} {told}" in listed
        assert python(RUN, name, path=path, status=2).stderr.startswith(f"error: {told}")
    assert "explain Explain what a task means, and why." in listed
    called = python(RUN, "count", path=path, status=2)
    assert called.stderr.startswith("error: command 'count' of package 'others' cannot be loaded: ModuleNotFoundError")
    assert "Traceback" not in called.stderr


def test_a_command_that_is_misspelt_leads_to_the_one_that_was_meant() -> None:
    assert "Did you mean 'learn'?" in python(RUN, "lear", status=2).stderr
