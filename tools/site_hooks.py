"""What the documentation site shows beyond docs/: the API by rooms, the examples, and the two pages at the root.

MkDocs calls these hooks (``mkdocs.yml``). The API's pages are made from what the code says: the rooms from the table in
docs/how/architecture.md, each room's names from its face (``__init__.pyi``), or from its modules where it has none;
their text is that of the docstrings, through mkdocstrings.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parent.parent
SOURCE, ENGINE, LAB = ROOT / "src", "taskgist", "taskgist_lab"
API = "reference/api"
HIDDEN = {"common", "cli"}
"""Rooms that are nobody's to import: what every room needs once, and the command line."""
ROOT_PAGES = {"contributing.md": "CONTRIBUTING.md", "changes.md": "CHANGELOG.md"}


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Put a page for each room where the navigation says ``API``."""
    config["nav"] = [_with_api(entry) for entry in config["nav"]]
    return config


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the pages that are made."""
    for uri, text in made_pages():
        files.append(File.generated(config, uri, content=text))
    return files


def made_pages() -> Iterator[tuple[str, str]]:
    """Path and text of each page that is made rather than written."""
    yield from ((f"{API}/{name}.md", text) for name, text in api_pages().items())
    yield "examples.md", examples_page()
    for uri, name in ROOT_PAGES.items():
        yield uri, (ROOT / name).read_text(encoding="utf-8").replace("](docs/", "](")


def _with_api(entry: Any) -> Any:
    if not isinstance(entry, dict):
        return entry
    ((title, inside),) = entry.items()
    if inside == "API":
        return {title: [f"{API}/{name}.md" for name in api_pages()]}
    return {title: [_with_api(each) for each in inside]} if isinstance(inside, list) else entry


# --- The API


def api_pages() -> dict[str, str]:
    """The API's pages by name: the face of the package, a page for each room, and one for the lab."""
    rooms = {name: (names_of(SOURCE / ENGINE / name, f"{ENGINE}.{name}"), job) for name, job in open_rooms().items()}
    lab_names = [
        each
        for name in jobs()
        if name.startswith("lab ") and name != "lab cli"
        for each in names_of(SOURCE / LAB / name.removeprefix("lab "), f"{LAB}.{name.removeprefix('lab ')}")
    ]
    documented = {each for names, _ in rooms.values() for each in names}
    pages = {ENGINE: face_page(documented)}
    pages |= {name: room_page(f"{ENGINE}.{name}", job, names) for name, (names, job) in rooms.items()}
    return pages | {LAB: room_page(LAB, "simulates, reproduces the paper and measures", lab_names)}


def jobs() -> Mapping[str, str]:
    """What each room is for, by the table of rooms, in its order."""
    table = (ROOT / "docs" / "how" / "architecture.md").read_text(encoding="utf-8")
    return dict(re.findall(r"^\| `([\w ]+)` \| (.*?) \|", table, flags=re.MULTILINE))


def open_rooms() -> Mapping[str, str]:
    """The engine's rooms that others import from."""
    return {name: job for name, job in jobs().items() if " " not in name and name not in HIDDEN}


def names_of(room: Path, package: str) -> list[str]:
    """Where each name of a room's face is defined, in the face's order; the room's modules if it has no face."""
    if room.with_suffix(".py").exists():
        return [package]
    stub = room / "__init__.pyi"
    if stub.exists():
        return list(defined_in(stub, package).values())
    return [
        f"{package}.{'.'.join(path.relative_to(room).with_suffix('').parts)}"
        for path in sorted(room.rglob("*.py"))
        if not path.name.startswith("_")
    ]


def defined_in(stub: Path, package: str) -> dict[str, str]:
    """The names of a face, each with the full name of what it stands for."""
    imports = [node for node in ast.parse(stub.read_text(encoding="utf-8")).body if isinstance(node, ast.ImportFrom)]
    return {
        alias.asname or alias.name: ".".join(filter(None, (_absolute(node, package), alias.name)))
        for node in imports
        for alias in node.names
        if node.level or (node.module or "").startswith(ENGINE)
    }


def _absolute(node: ast.ImportFrom, package: str) -> str:
    base = package.split(".")[: len(package.split(".")) - (node.level - 1)] if node.level else []
    return ".".join([*base, *filter(None, [node.module])])


def room_page(package: str, job: str, names: Iterable[str]) -> str:
    """The docstrings of a room."""
    head = f"# {package}\n\n{job[:1].upper()}{job[1:]}.\n"
    return "\n".join([head, *map(docstrings, names)])


def docstrings(name: str) -> str:
    """Where the docstrings of a name are put: a module under its whole name, what a room shows under its own."""
    is_module = SOURCE.joinpath(*name.split(".")).with_suffix(".py").exists()
    return f"::: {name}\n    options: {{ heading: {name if is_module else name.rpartition('.')[2]} }}\n"


def face_page(documented: set[str]) -> str:
    """What ``import taskgist`` gives: each name with a link to its room, or its docstring; and the rooms."""
    names = defined_in(SOURCE / ENGINE / "__init__.pyi", ENGINE)
    lines = [
        "# taskgist",
        "",
        f"::: {ENGINE}",
        "    options: { members: false, show_root_heading: false, heading_level: 2 }",
        "",
    ]
    shown = {name: full for name, full in names.items() if documented & {full, full.rpartition(".")[0]}}
    lines += [" · ".join(f"[`{name}`][{full}]" for name, full in sorted(shown.items())), ""]
    lines += ["| from | what it is for |", "| --- | --- |"]
    lines += [f"| [`taskgist.{name}`]({name}.md) | {job} |" for name, job in open_rooms().items()]
    lines += ["", *(docstrings(full) for name, full in names.items() if name not in shown)]
    return "\n".join(lines) + "\n"


# --- Examples


def examples_page() -> str:
    """Every example, whole, under its idea."""
    lines = ["# Examples", "", "Each is one idea, and runs as it stands; all of them run in the tests.", ""]
    for path in sorted((ROOT / "examples").glob("*.py")):
        text = path.read_text(encoding="utf-8")
        idea = (ast.get_docstring(ast.parse(text)) or "").splitlines()[0]
        lines += [f"## {path.name}", "", idea, "", "```python", text.partition('"""\n')[2].strip(), "```", ""]
    return "\n".join(lines)
