"""The face of taskgist: the names that users build on. Changing them is a decision, not an accident."""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import taskgist
from taskgist.pipeline import shipped_recordings
from tests.test_architecture import ROOMS, ROOT, SOURCE, names_of

FACE = {
    *("Scene", "Stage", "AgentProfile"),
    *("least_effort", "visibility", "SceneEfforts", "parse_question", "objects_where"),
    *("ability_map", "Grid", "places_for"),
    *("Recording", "Label", "read_recording", "write_recording", "load_mapping", "import_recording"),
    *("propose_label", "check_recording"),
    *("Observer", "explain_recording", "Predicate"),
    *("learn", "Knowledge", "load_knowledge", "update_knowledge", "meaning", "why"),
    *("Settings", "TaskgistError"),
}
SUBMODULES = {"taskgist.language.efforts", "taskgist.perspective.queries", "taskgist.perspective.scene_efforts"}
"""What examples and pages may import from besides the face and the rooms; docs/howto/queries.md describes it."""
USERS = [*sorted((ROOT / "examples").glob("*.py")), ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def test_the_names() -> None:
    assert set(taskgist.__all__) == FACE
    assert 25 <= len(FACE) <= 30
    assert set(dir(taskgist)) >= FACE


@pytest.mark.parametrize("name", sorted(FACE))
def test_a_name_is_where_the_stub_says_and_is_documented(name: str) -> None:
    found = getattr(taskgist, name)
    assert found.__module__ == names_of(SOURCE / "taskgist/__init__.pyi")[name]
    assert inspect.getdoc(found)
    assert f"`{name}`" in str(taskgist.__doc__)


def test_a_wrong_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'Scenes'"):
        _ = taskgist.Scenes  # type: ignore[attr-defined]


def test_importing_loads_nothing_else() -> None:
    code = "import sys; before = set(sys.modules); import taskgist; print(*set(sys.modules) - before)"
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "taskgist" in printed
    assert {name.partition(".")[0] for name in printed} <= {"taskgist"} | set(sys.stdlib_module_names)
    assert not [name for name in printed if name.startswith("taskgist.")]


def test_the_five_lines_of_the_docstring_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for number, path in enumerate(shipped_recordings("give")[:2], start=1):
        shutil.copy(path, tmp_path / f"give_{number}.mcap")
    monkeypatch.chdir(tmp_path)
    code = "\n".join(re.findall(r"^    (.*)$", str(taskgist.__doc__), re.MULTILINE))
    exec(compile(code, "taskgist.__doc__", "exec"), {})
    assert capsys.readouterr().out.startswith("“give” means for the target agent:")


def imports_in(text: str, *, is_python: bool) -> list[tuple[str, str]]:
    """Every name that a text imports from us, with the module that it takes it from."""
    lines = re.findall(r"^\s*(from taskgist\S* import [\w, ]+)$", text, re.MULTILINE)
    code = text if is_python else "\n".join(lines)
    return [
        (str(node.module), alias.name)
        for node in ast.walk(ast.parse(code))
        if isinstance(node, ast.ImportFrom) and str(node.module).partition(".")[0] == "taskgist"
        for alias in node.names
    ]


@pytest.mark.parametrize("path", USERS, ids=lambda path: path.name)
def test_examples_and_pages_use_the_face_and_documented_modules(path: Path) -> None:
    for module, name in imports_in(path.read_text(encoding="utf-8"), is_python=path.suffix == ".py"):
        room = module.removeprefix("taskgist").removeprefix(".")
        stub = SOURCE.joinpath(*module.split("."), "__init__.pyi")
        if module not in SUBMODULES and room not in {"errors", "settings", "cli.common"}:
            assert room == "" or room in ROOMS, module
            assert name in names_of(stub), f"{name} is no name of {module}"
        if module != "taskgist":
            found = getattr(importlib.import_module(module), name)
            assert found is not getattr(taskgist, name, None), f"{name} is a name of the face"
