"""The pages keep their word: links lead somewhere, commands parse, tables are those of the code."""

from __future__ import annotations

import ast
import json
import os
import pkgutil
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import taskgist
from taskgist.facts import STANDARD_TREE, parse_facts
from tests.command_lines import commands, parse
from tests.test_architecture import CORE, ROOMS, THIRD_PARTY
from tools.reference_pages import pages

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]


def text_of(page: str) -> str:
    return (ROOT / page).read_text(encoding="utf-8")


def blocks(text: str) -> str:
    """Everything in fences or indented by four blanks."""
    fenced = re.findall(r"^```[^\n]*\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)
    indented = re.findall(r"^ {4,}(\S.*)$", text, flags=re.MULTILINE)
    return "\n".join([*fenced, *indented])


def command_lines(text: str) -> list[str]:
    return [line.strip() for line in re.findall(COMMAND, blocks(text), re.MULTILINE)]


COMMAND = r"^\W*(taskgist [a-z-](?:\"[^\"\n]*\"|[^|>;\"\n])*)"
"""From the program's name to the end of the line, or to where its output goes."""
LINES = [(page.name, line) for page in PAGES for line in command_lines(page.read_text(encoding="utf-8"))]


def named(page: Path) -> str:
    """The name of a page in a list of tests."""
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_links_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8"))
    for link in links:
        if not link.startswith(("http://", "https://", "#")):
            assert (page.parent / link.partition("#")[0]).exists(), link


@pytest.mark.parametrize(("page", "line"), LINES)
def test_commands_parse(page: str, line: str) -> None:
    assert page
    parse(line[line.index("taskgist ") :])


def test_the_parser_of_command_lines_is_not_too_kind() -> None:
    assert parse("taskgist label X.mcap --propose [--task give]  # a comment")["task"] == "give"
    assert parse("taskgist learn X.mcap... -k k.db")["knowledge"] == "k.db"
    for wrong in (
        "taskgist fly",
        "taskgist see x.toml --agnt P1",
        "taskgist label x.mcap --start soon",
        "taskgist check",
    ):
        with pytest.raises(Exception, match=r"fly|No such option|not a valid|valid number|Missing parameter"):
            parse(wrong)


def test_every_command_is_written_about() -> None:
    known = {name.split()[0] for name in commands()}
    assert {line.split()[1] for page, line in LINES if page != "commands.md"} >= known


def test_modules_of_the_papers_sections_exist() -> None:
    found = re.findall(r"`([\w/]+\.py)`", text_of("docs/how/paper.md"))
    assert len(found) > 20
    for module in found:
        assert any((folder / module).is_file() for folder in (ROOT, ROOT / "src" / "taskgist", ROOT / "src")), module


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_files_that_pages_name_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for module in re.findall(r"`((?:\w+/)+\w+\.(?:py|toml))`", text):
        assert any((folder / module).is_file() for folder in (ROOT, ROOT / "src" / "taskgist", ROOT / "src")), module
    for path in re.findall(r"\bsrc/taskgist/[\w/.]*\w", text):
        assert (ROOT / path).exists(), path


DOTTED = re.compile(r"\btaskgist(?:_lab)?(?:\.[A-Za-z_]\w*)+")
FILES = (".mcap", ".facts", ".commands", ".predicates", ".db", ".md")
"""Ends of what looks like a name in Python and is none: files, schemas, groups of entry points."""


@pytest.mark.parametrize("page", [page for page in PAGES if page.name != "CHANGELOG.md"], ids=named)
def test_names_in_python_that_pages_give_exist(page: Path) -> None:
    for name in DOTTED.findall(page.read_text(encoding="utf-8")):
        if not name.endswith(FILES):
            assert pkgutil.resolve_name(name) is not None, name


def test_upgrade_notes_lead_to_what_there_is() -> None:
    rows = re.findall(r"^\| (.*) \| (.*taskgist.*) \|$", text_of("CHANGELOG.md"), re.MULTILINE)
    assert len(rows) > 15
    for before, now in rows:
        homes = [pkgutil.resolve_name(name) for name in DOTTED.findall(now)]
        for name in re.findall(r"`([A-Za-z_]+)`", before):
            assert name == "taskgist" or hasattr(homes[0], name), f"{name} is not in {now}"


def test_the_quick_tests_exist() -> None:
    (listed,) = re.findall(r"^QUICK := \$\(addprefix tests/, (.*?)\)$", text_of("Makefile"), re.DOTALL | re.MULTILINE)
    paths = listed.replace("\\", " ").split()
    assert len(paths) > 5
    assert [path for path in paths if not (ROOT / "tests" / path).exists()] == []


def test_one_version_everywhere() -> None:
    project = tomllib.loads(text_of("pyproject.toml"))["project"]["version"]
    assert re.findall(r"^version: (.*)$", text_of("CITATION.cff"), re.MULTILINE) == [project]
    assert re.findall(r"^## (\S+)", text_of("CHANGELOG.md"), re.MULTILINE)[0] == project


def test_the_table_of_rooms_is_the_one_that_is_enforced() -> None:
    rows = [
        [cell.strip() for cell in row.strip("|").split("|")]
        for row in re.findall(r"^\| `.*\|$", text_of("docs/how/architecture.md"), flags=re.MULTILINE)
    ]
    rooms = [row[0].strip("`") for row in rows]
    assert set(rooms) == set(ROOMS)
    for number, (room, (_, _, ours, others)) in enumerate(zip(rooms, rows, strict=True)):
        assert rooms_in(ours, set(rooms[:number])) | {room} == ROOMS[room] | {room}, room
        assert set(re.findall(r"\w+", others)) == THIRD_PARTY[room], room


def rooms_in(cell: str, above: set[str]) -> set[str]:
    """The rooms in a cell; "+" adds them to what every room may import."""
    if cell.startswith("all above"):
        return above - set(cell.removeprefix("all above").removeprefix(" but ").split(", "))
    core = CORE if cell.startswith("+") else set()
    return core | {room.strip() for room in cell.strip("+-").split(",")} - {""}


def test_facts_from_elsewhere_are_as_the_page_shows_them() -> None:
    document = re.search(r"^    \{$.*?^    \}$", text_of("docs/howto/extending.md"), flags=re.DOTALL | re.MULTILINE)
    assert document
    episode = parse_facts(json.loads(document[0]), STANDARD_TREE, where="docs/howto/extending.md")
    assert (episode.task, episode.demonstration) == ("show", "annotated 1")
    assert episode.end["see.effort"].evidence == {"source": "annotator A"}


def test_the_table_of_attributes_names_them_all() -> None:
    page = text_of("docs/howto/extending.md")
    for name, attribute in STANDARD_TREE.attributes.items():
        kind = name.partition(".")[2]
        assert f"`{name}`" in page or (kind in ("state", "action") and f"`reach.{kind}`" in page), name
        for value in getattr(attribute, "values", None) or ():
            assert f"`{value}`" in page, value


def test_the_predicate_of_the_page_works() -> None:
    page = text_of("docs/howto/extending.md")
    (code,) = re.findall(r"^    from taskgist import Predicate.*?\n\n(?=[^ ])", page, re.DOTALL | re.M)
    space: dict[str, object] = {}
    exec(re.sub(r"^    ", "", code, flags=re.MULTILINE), space)
    assert "on_white_box.class" in {node.name for node in STANDARD_TREE.extended(space["ON_WHITE_BOX"].subtree).nodes}  # type: ignore[attr-defined]


@pytest.mark.parametrize("page", pages(), ids=named)
def test_reference_pages_say_what_the_code_says(page: Path) -> None:
    assert page.read_text(encoding="utf-8") == pages()[page], "python -m tools.reference_pages"


def test_the_pages_that_the_code_names_exist() -> None:
    for folder in ("src", "tests", "tools", "benchmarks", "examples"):
        for path in (ROOT / folder).rglob("*.py"):
            for page in re.findall(r"docs/[\w/]+\.md", path.read_text(encoding="utf-8")):
                assert (ROOT / page).is_file(), f"{path}: {page}"


def test_the_errors_of_the_page_are_real() -> None:
    said = [
        node.value
        for path in (ROOT / "src" / "taskgist").rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    ]
    headings = re.findall(r"^### .*$", text_of("docs/reference/errors.md"), re.MULTILINE)
    messages = re.findall(r"`(.+?)`", "\n".join(headings))
    assert len(messages) > 15
    for message in messages:
        for piece in message.partition(" (got")[0].split("…"):
            assert any(piece.strip() in each for each in said), message


FROM_THE_NETWORK = r"<(?:script|link|img)\b[^>]*(?:src|href)=\"(?:https?:)?//[^\"]*"


def test_the_site_is_built_without_a_warning(tmp_path: Path) -> None:
    """Strictly: no broken link or anchor, no page that the navigation lacks, no docstring that cannot be read."""
    site = tmp_path / "site"
    words = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(site)]
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    environment = os.environ | {"PYTHONPATH": path, "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout + done.stderr) == (0, "")
    face = (site / "reference" / "api" / "taskgist.html").read_text(encoding="utf-8")
    assert [name for name in taskgist.__all__ if f">{name}<" not in face] == []
    for room, name in (("perspective", "NO_ACTION"), ("maps", "ability_map"), ("taskgist_lab", "demonstrate")):
        text = (site / "reference" / "api" / f"{room}.html").read_text(encoding="utf-8")
        assert re.search(rf"id=\"taskgist[\w.]*\.{name}\"", text), name
    for page in site.rglob("*.html"):
        loaded = re.findall(FROM_THE_NETWORK, page.read_text(encoding="utf-8"))
        assert not loaded, f"{page} loads {loaded}"
