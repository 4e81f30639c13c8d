"""The surface of the command line: commands, options, help. Changing it is a decision, not an accident."""

from __future__ import annotations

import re
from importlib import metadata

import pytest

from taskgist.errors import UnknownNameError
from tests.cli.running import Result, run
from tests.command_lines import commands, parse

SURFACE: dict[str, set[str]] = {
    "demo": {"--out", "-o", "--replace"},
    "import": {"sources", "--out", "-o", "--replace", "--data", "--set", "--each"},
    "label": {
        *("recordings", "--task", "--performer", "--target", "--object", "--start", "--end"),
        *("--propose", "--dry-run"),
    },
    "check": {"recordings"},
    "facts": {"recording", "--agent", "--object", "--at", "--every", "--relations", "--actions", "--of"},
    "learn": {"demonstrations", "--knowledge", "-k", "--replace", "--of", "--wrong", "--actions"},
    "perform": {
        *("task", "where", "--knowledge", "-k", "--robot", "--for", "--object", "--out", "-o", "--ways"),
        *("--attention", "--allow", "--prefer", "--means", "--helpers", "--spare", "--seed", "--at", "--replace"),
        *("--trajectory", "--plan", "--positions", "--picture", "--film", "--pddl", "--rule"),
    },
    "explain": {"task", "--knowledge", "-k", "--why", "--of", "--band", "--rule", "--contrast", "--actions"},
    "recognise": {"recordings", "--knowledge", "-k", "--why", "--contrast", "--of", "--episodes", "--at"},
    "offer": {"where", "--knowledge", "-k", "--at", "--for", "--object", "--ability", "--rule"},
    "ask": {"task", "--knowledge", "-k", "--answer", "--question", "--withdraw", "--author", "--list", "--of"},
    "agent check": {"profile", "--out", "-o", "--replace"},
    "agent draft": {"model", "--out", "-o", "--replace"},
    "see": {"where", "--agent", "--at", "--object", "--out", "-o", "--replace"},
    "query": {"where", "--agent", "--ability", "--object", "--actions", "--where", "--why", "--at"},
    "paper": {"--displacements", "--save", "--out", "-o", "--replace"},
    "simulate": {
        *("task", "--count", "-n", "--seed", "-s", "--means", "--out", "-o"),
        *("--replace", "--processes", "--picture", "--list"),
    },
    "evaluate": {
        *("experiments", "--pool", "--demonstrations", "-n", "--seed", "--runs"),
        *("--source", "--unfamiliar", "--condition", "--processes", "--out", "-o", "--replace", "--rooms", "--robot"),
        *("--task", "--kept", "--rule"),
    },
    "map": {
        *("where", "--agent", "--ability", "--level", "--where", "--size"),
        *("--out", "-o", "--npz", "--at", "--replace"),
    },
}


def test_commands_and_options() -> None:
    found = {name: {text for each in command.params for text in each.opts} for name, command in commands().items()}
    assert found == {name: options | {"--json"} for name, options in SURFACE.items()}


@pytest.mark.parametrize("name", SURFACE)
def test_help_names_every_option_and_explains_it(name: str) -> None:
    text = run(f"{name} --help")
    for parameter in commands()[name].params:
        assert getattr(parameter, "help", None), parameter.name
        shown = parameter.opts if parameter.param_type_name == "option" else [parameter.metavar or parameter.name]
        for option in shown:
            assert re.search(rf"(^|[\s,]){re.escape(option)}\b", text), option


@pytest.mark.parametrize("name", SURFACE)
def test_help_has_examples_that_parse(name: str) -> None:
    lines = re.findall(r"Example: (taskgist .*)", str(commands()[name].help))
    assert lines
    for line in lines:
        assert line in run(f"{name} --help"), "an example is never wrapped"
        assert f"{line} ".startswith(f"taskgist {name} ")
        assert parse(line)


@pytest.mark.parametrize("name", SURFACE)
def test_the_list_of_commands_says_in_one_whole_sentence_what_each_is_for(name: str) -> None:
    sentence = str(commands()[name].help).partition("\n")[0]
    assert len(sentence) <= 60
    assert re.fullmatch(r"[A-Z][^.]*\.", sentence)
    group, _, last = f" {name}".rpartition(" ")
    assert re.search(rf"^  {last} +{re.escape(sentence)}$", run(f"{group} --help"), flags=re.MULTILINE)


def test_version() -> None:
    assert run("--version") == f"taskgist {metadata.version('taskgist')}\n"


def test_no_command_shows_the_help_and_fails() -> None:
    result = Result("")
    assert result.exit_code == 2
    assert "Commands:" in result.stdout + result.stderr


@pytest.mark.parametrize("line", ["nonsense", "see", "check", "facts x.mcap --every 0", "label x.mcap --start soon"])
def test_misuse_points_to_the_help(line: str) -> None:
    result = Result(line)
    assert (result.exit_code, result.stdout) == (2, "")
    assert "--help" in result.stderr


@pytest.mark.parametrize(
    ("name", "known", "meant"),
    [
        ("P3", ("P1", "P2"), "P2"),
        ("p1", ("P1", "P2"), "P1"),
        ("CUP", ("cup", "tape"), "cup"),
        ("cub", ("cup", "tape"), "cup"),
        ("whitebox", ("white_box", "book"), "white_box"),
        ("P3", ("giver", "taker"), None),
        ("z", ("x", "y"), None),
        ("tape", ("cup", "book"), None),
        ("robot", ("book", "cup"), None),
        ("", ("cup",), None),
    ],
)
def test_a_wrong_name_leads_to_the_one_that_was_meant(name: str, known: tuple[str, ...], meant: str | None) -> None:
    guess = f"; did you mean {meant!r}?" if meant else ""
    listed = ", ".join(sorted(known))
    assert str(UnknownNameError("agent", name, known)) == f"no agent {name!r}{guess} (known: {listed})"
