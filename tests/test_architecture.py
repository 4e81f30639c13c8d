"""Who may import whom: the rooms of the house (docs/how/architecture.md), no circles, one engine that knows no lab."""

from __future__ import annotations

import ast
import sys
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
SOURCE = ROOT / "src"

CORE = {"errors", "settings", "common"}
FACTS = CORE | {"facts"}
LEARNING = FACTS | {"learning"}
WORLD = CORE | {"world"}
PERSPECTIVE = WORLD | {"perspective"}
RECORDING = WORLD | {"recording"}
OBSERVE = PERSPECTIVE | {"facts", "observe"}
RECOGNITION = OBSERVE | RECORDING | {"learning", "recognition"}
PLANNING = OBSERVE | {"learning", "moving", "maps", "planning"}
PERFORMING = PLANNING | RECORDING | {"performing"}
LANGUAGE = LEARNING | PLANNING | {"recognition", "language"}
PIPELINE = RECOGNITION | LANGUAGE | PERFORMING | {"store", "importing", "pipeline"}
SIMULATOR = RECORDING | {"moving", "lab simulator"}
GENERATOR = SIMULATOR | {"lab generator"}
PAPER = PIPELINE | {"lab simulator", "lab paper"}
ORDINARY = WORLD | {"lab simulator", "lab ordinary"}
EVALUATION = PAPER | {"lab generator", "lab ordinary", "lab evaluation"}

ROOMS: dict[str, set[str]] = {
    "errors": set(),
    "settings": {"errors"},
    "common": {"errors"},
    "facts": FACTS,
    "learning": LEARNING,
    "store": LEARNING | {"store"},
    "world": WORLD,
    "moving": WORLD | {"moving"},
    "perspective": PERSPECTIVE,
    "maps": PERSPECTIVE | {"maps"},
    "observe": OBSERVE,
    "recording": RECORDING,
    "importing": RECORDING | {"importing"},
    "recognition": RECOGNITION,
    "planning": PLANNING,
    "performing": PERFORMING,
    "language": LANGUAGE,
    "pipeline": PIPELINE,
    "view": PIPELINE | {"view"},
    "cli": PIPELINE | {"view", "cli"},
    "lab simulator": SIMULATOR,
    "lab generator": GENERATOR,
    "lab paper": PAPER,
    "lab ordinary": ORDINARY,
    "lab evaluation": EVALUATION,
    "lab view": EVALUATION | {"view", "lab view"},
    "lab cli": EVALUATION | {"view", "cli", "lab view", "lab cli"},
}
THIRD_PARTY: dict[str, set[str]] = {
    "errors": set(),
    "settings": set(),
    "common": {"numpy", "numba"},
    "facts": set(),
    "learning": set(),
    "store": {"sqlalchemy", "alembic"},
    "world": {"numpy", "numba", "mujoco", "coacd", "tomli_w"},
    "moving": {"numpy", "scipy"},
    "perspective": {"numpy"},
    "maps": {"numpy"},
    "observe": {"numpy"},
    "recording": {"numpy", "mcap", "zstandard", "lz4"},
    "importing": {"numpy", "scipy", "mujoco", "rosbags"},
    "recognition": set(),
    "planning": {"numpy", "scipy", "mujoco", "ompl", "toppra"},
    "performing": {"numpy", "mujoco"},
    "language": set(),
    "pipeline": {"numpy"},
    "view": {"numpy", "matplotlib", "PIL"},
    "cli": {"typer", "rich"},
    "lab simulator": {"numpy", "mujoco"},
    "lab generator": {"numpy", "mujoco"},
    "lab paper": {"numpy"},
    "lab ordinary": {"numpy", "mujoco"},
    "lab evaluation": {"numpy", "mujoco"},
    "lab view": {"numpy", "matplotlib"},
    "lab cli": {"typer", "rich"},
}
FACES = {"lazy_loader"}
"""What a room's face is made with; it may stand in every ``__init__``."""


def modules() -> list[Path]:
    return sorted(SOURCE.rglob("*.py"))


def module_name(path: Path) -> str:
    return ".".join(path.relative_to(SOURCE).with_suffix("").parts).removesuffix(".__init__")


KNOWN = {module_name(path): path for path in modules()}


def room_of(module: str) -> str:
    """The room of a module; none for the two packages' own faces."""
    package, _, rest = module.partition(".")
    room = rest.partition(".")[0]
    return f"lab {room}" if package == "taskgist_lab" and room else room


def imports_of(path: Path) -> set[str]:
    """Every imported module, at the top, lazily inside functions, or for types alone."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            assert node.level == 0, f"{path}: relative import"
            whole = {f"{node.module}.{alias.name}" for alias in node.names}
            names |= {name if name in KNOWN else node.module for name in whole}
    return names


def is_ours(name: str) -> bool:
    return name.partition(".")[0] in ("taskgist", "taskgist_lab")


@pytest.mark.parametrize("module", sorted(KNOWN))
def test_imports_are_allowed(module: str) -> None:
    room, path = room_of(module), KNOWN[module]
    for name in imports_of(path):
        top = name.partition(".")[0]
        if is_ours(name):
            assert room, f"{module}, a face, may not import {name}"
            assert room_of(name) in ROOMS[room] | {room}, f"{room} may not import {name}"
        elif top not in sys.stdlib_module_names:
            faces = FACES if path.name == "__init__.py" else set()
            assert top in THIRD_PARTY.get(room, set()) | faces, f"{room} may not import {name}"


def test_the_engine_never_imports_the_lab() -> None:
    for module, path in KNOWN.items():
        if module.partition(".")[0] == "taskgist":
            assert not any(name.partition(".")[0] == "taskgist_lab" for name in imports_of(path)), module


def test_every_room_is_listed() -> None:
    assert {room_of(module) for module in KNOWN} - {""} == set(ROOMS) == set(THIRD_PARTY)


def test_no_imports_go_in_a_circle() -> None:
    graph = {module: imports_of(path) & set(KNOWN) for module, path in KNOWN.items()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" imports ".join(reversed(error.args[1])))


def test_benchmarks_import_nothing_from_tests() -> None:
    for path in sorted((ROOT / "benchmarks").rglob("*.py")):
        assert not any(name.partition(".")[0] == "tests" for name in imports_of(path)), path


def names_of(face: Path) -> dict[str, str]:
    """The names that a face shows, and the module that defines each."""
    return {
        alias.asname or alias.name: f"{module_name(face.with_suffix('.py'))}.{node.module}"
        for node in ast.walk(ast.parse(face.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }


def test_no_name_of_a_face_is_a_module_beside_it() -> None:
    """A loaded module would stand in the name's place."""
    for face in sorted(SOURCE.rglob("__init__.pyi")):
        assert not set(names_of(face)) & {path.stem for path in face.parent.iterdir()}, face
