"""Who may import whom: the rooms of the house (docs/architecture.md)."""

import ast
from pathlib import Path

import pytest

SOURCE = Path(__file__).parent.parent / "src" / "taskgist"

CORE = {"errors", "settings"}
FACTS = CORE | {"facts"}
LEARNING = FACTS | {"learning"}
WORLD = CORE | {"world"}
OBSERVE = WORLD | {"facts", "perspective", "observe"}
RECORDING = WORLD | {"recording"}
STUDY = OBSERVE | LEARNING | RECORDING | {"files", "demonstrator", "store", "language", "study", "workers"}

ROOMS: dict[str, set[str]] = {
    "errors": set(),
    "settings": {"errors"},
    "files": set(),
    "workers": {"errors"},
    "facts": FACTS,
    "learning": LEARNING,
    "world": WORLD | {"files"},
    "perspective": WORLD | {"perspective"},
    "observe": OBSERVE,
    "recording": RECORDING | {"files"},
    "demonstrator": RECORDING | {"demonstrator", "workers"},
    "store": LEARNING | {"store"},
    "language": LEARNING | {"language"},
    "study": STUDY,
    "view": STUDY | {"view"},
    "cli": STUDY | {"view", "cli"},
}
THIRD_PARTY: dict[str, set[str]] = {
    "errors": set(),
    "settings": set(),
    "files": set(),
    "workers": set(),
    "facts": set(),
    "learning": set(),
    "language": set(),
    "store": {"sqlalchemy"},
    "world": {"numpy", "numba", "mujoco", "mink", "coacd"},
    "perspective": {"numpy"},
    "observe": {"numpy"},
    "recording": {"numpy", "mcap", "zstandard"},
    "demonstrator": {"numpy"},
    "study": {"numpy"},
    "view": {"numpy", "matplotlib"},
    "cli": {"typer", "rich"},
}


def modules() -> list[Path]:
    return sorted(SOURCE.rglob("*.py"))


def room_of(path: Path) -> str:
    return path.relative_to(SOURCE).parts[0].removesuffix(".py")


def imports_of(path: Path) -> set[str]:
    """Every imported module, at the top or lazily inside functions."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            assert node.level == 0, f"{path}: relative import"
            names |= {
                f"{node.module}.{alias.name}" if node.module == "taskgist" else node.module for alias in node.names
            }
    return names


@pytest.mark.parametrize("path", modules(), ids=lambda path: str(path.relative_to(SOURCE)))
def test_imports_are_allowed(path: Path) -> None:
    room = room_of(path)
    if room == "__init__":
        return
    for name in imports_of(path):
        top, _, rest = name.partition(".")
        if top == "taskgist":
            assert rest.partition(".")[0] in ROOMS[room], f"{room} may not import {name}"
        elif top not in _standard_library():
            assert top in THIRD_PARTY[room], f"{room} may not import {name}"


def test_every_room_is_listed() -> None:
    assert {room_of(path) for path in modules()} - {"__init__"} == set(ROOMS)


def _standard_library() -> frozenset[str]:
    import sys

    return sys.stdlib_module_names | {"__future__"}
