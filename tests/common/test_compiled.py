"""Compiled functions: whoever waits for them is told, and machine code is as new as its sources."""

import os
import pickle
import shutil
import stat
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numba
import pytest

from taskgist.common.compiled import compiled, compiled_part

FRESH = """
from taskgist.common.compile_notice import when_compiling
from taskgist.world.geometry.linkage import rotated
told = []
when_compiling(told.append)
assert not told
assert rotated(0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0) == (0.0, 1.0, 0.0)
print(len(told), rotated._cache._cache_file._source_stamp)
"""


def run(cache: Path, package: Path) -> list[str]:
    """How often somebody was told, and the stamp of the sources, of a new process."""
    environment = {"NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(package)}
    done = subprocess.run([sys.executable, "-c", FRESH], env=environment, capture_output=True, text=True, check=True)
    return done.stdout.split()


EACH_ANEW = f"""
import os, sys
import numba
for cache in sys.argv[1:]:
    if (child := os.fork()) == 0:
        numba.config.CACHE_DIR = cache
        exec({FRESH!r})
        sys.stdout.flush()
        os._exit(0)
    assert os.waitpid(child, 0) == (child, 0)
"""
"""A new process for each cache, but for numba itself, which takes longer to load than all else."""


SOURCE = Path(__file__).parents[2] / "src"


@dataclass(frozen=True)
class Filled:
    """A cache in which a first process left what it compiled, and what that process said."""

    folder: Path
    said: list[str]


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Filled:
    folder = tmp_path_factory.mktemp("filled")
    return Filled(folder, run(folder, SOURCE))


def test_who_waits_is_told_once_and_only_when_something_is_compiled(filled: Filled) -> None:
    second = run(filled.folder, SOURCE)
    assert (filled.said[0], second[0]) == ("1", "0")
    assert filled.said[1] == second[1]


def test_a_constant_from_another_file_makes_machine_code_anew(tmp_path: Path) -> None:
    copied = tmp_path / "src"
    shutil.copytree(SOURCE, copied)
    before = run(tmp_path / "cache", copied)
    transforms = copied / "taskgist/world/geometry/transforms.py"  # holds no compiled function itself
    assert "@compiled" not in transforms.read_text(encoding="utf-8")
    transforms.write_text(transforms.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    after = run(tmp_path / "cache", copied)
    assert (before[0], after[0]) == ("1", "1")
    assert before[1] != after[1]


def index_of_a_module_that_is_gone() -> bytes:
    """What numba keeps when a function's signature names a type whose module was moved since."""
    return pickle.dumps(numba.__version__) + b"ctaskgist.no_such_room\nThing\n."


LEFT_BEHIND = {
    "of a moved module": ("nbi", index_of_a_module_that_is_gone()),
    "empty index": ("nbi", b""),
    "cut index": ("nbi", b"\x80cut off"),
    "cut code": ("nbc", b"\x80cut off"),
}


@pytest.fixture(scope="module")
def told_again(filled: Filled, tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[str]]:
    """By what was left behind: how often somebody was told by a first process, and by a second one."""
    folder = tmp_path_factory.mktemp("left")
    for name, (suffix, content) in LEFT_BEHIND.items():
        kept = list(shutil.copytree(filled.folder, folder / name).rglob(f"*.{suffix}"))
        assert kept
        for path in kept:
            path.write_bytes(content)
    caches = [str(folder / name) for name in LEFT_BEHIND for _ in range(2)]
    command, environment = [sys.executable, "-c", EACH_ANEW, *caches], {"PYTHONPATH": str(SOURCE)}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    counts = [line.split()[0] for line in done.stdout.splitlines()]
    return dict(zip(LEFT_BEHIND, map(list, zip(counts[::2], counts[1::2], strict=True)), strict=True))


@pytest.mark.parametrize("name", LEFT_BEHIND)
def test_what_an_earlier_version_left_behind_is_made_anew(name: str, told_again: dict[str, list[str]]) -> None:
    assert told_again[name] == ["1", "0"]


NOWHERE_ELSE = """
import sys, tempfile
tempfile.tempdir = sys.argv[1]
from taskgist.common.compile_notice import when_compiling
from taskgist.world.geometry.linkage import rotated
told = []
when_compiling(told.append)
assert rotated(0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0) == (0.0, 1.0, 0.0)
print(told)
"""


def told_where_only_a_temporary_folder_may_be_written_to(tmp_path: Path, folder: Path) -> str:
    (tmp_path / "file").touch()
    environment = {
        "NUMBA_CACHE_DIR": str(tmp_path / "file/below"),
        "NUMBA_CACHE_LOCATOR_CLASSES": "UserProvidedCacheLocator",  # as if the others had found nothing to write to
        "PYTHONPATH": str(SOURCE),
    }
    line = [sys.executable, "-c", NOWHERE_ELSE, str(folder)]
    return subprocess.run(line, env=environment, capture_output=True, text=True, check=True).stdout.strip()


def test_machine_code_is_kept_in_a_temporary_folder_where_nothing_else_can_be_written_to(tmp_path: Path) -> None:
    assert told_where_only_a_temporary_folder_may_be_written_to(tmp_path, tmp_path) == "[True]"
    assert stat.S_IMODE((tmp_path / f"taskgist-{os.getuid()}").stat().st_mode) == 0o700
    assert told_where_only_a_temporary_folder_may_be_written_to(tmp_path, tmp_path) == "[]"


@pytest.mark.parametrize("kind", ["open to others", "a link", "a file"])
def test_what_others_may_have_put_there_is_not_run(tmp_path: Path, kind: str) -> None:
    folder = tmp_path / f"taskgist-{os.getuid()}"
    if kind == "a link":
        (tmp_path / "elsewhere").mkdir()
        folder.symlink_to("elsewhere")
    elif kind == "a file":
        folder.touch()
    else:
        folder.mkdir()
        folder.chmod(0o777)
    assert told_where_only_a_temporary_folder_may_be_written_to(tmp_path, tmp_path) == "[False]"


def test_without_a_folder_to_write_to_functions_are_compiled_for_this_run_only(tmp_path: Path) -> None:
    assert told_where_only_a_temporary_folder_may_be_written_to(tmp_path, tmp_path / "file/below") == "[False]"


SHARED = """
import gc, numpy as np
from taskgist.common.compiled import compiled

@compiled
def scaled(row, by): return row[0] * by

@compiled
def both(row, by): return scaled(row, 2) + scaled(row, by) + scaled(row, 3)

assert both(np.array([5.0]), 1) == 30.0
print(len(scaled.overloads), gc.isenabled())
"""


def test_numbers_that_are_written_in_a_call_need_no_machine_code_of_their_own(tmp_path: Path) -> None:
    (tmp_path / "shared.py").write_text(SHARED, encoding="utf-8")
    environment = {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(SOURCE)}
    command = [sys.executable, str(tmp_path / "shared.py")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout == "1 True\n", "one machine code; the collector of garbage works again afterwards"


@compiled_part
def _doubled(number: float) -> float:
    return 2.0 * number


@compiled
def _doubled_twice(number: float) -> float:
    return _doubled(_doubled(number))


def test_a_part_works_within_a_compiled_function_and_refuses_any_other_call() -> None:
    with pytest.raises(TypeError, match="_doubled has no entry for Python"):
        _doubled(1.5)
    assert _doubled_twice(1.5) == 6.0
    with pytest.raises(TypeError, match="_doubled has no entry for Python"):  # now that there is machine code, too
        _doubled(1.5)
