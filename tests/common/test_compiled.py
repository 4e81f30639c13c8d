"""Compiled functions: whoever waits for them is told, and machine code is as new as its sources."""

import shutil
import subprocess
import sys
from pathlib import Path

FRESH = """
from taskgist.common.compiled import when_compiling
from taskgist.world.geometry.linkage import rotated
told = []
when_compiling(lambda: told.append(1))
assert not told
assert rotated(0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0) == (0.0, 1.0, 0.0)
print(len(told), rotated._cache._cache_file._source_stamp)
"""


def run(cache: Path, package: Path) -> list[str]:
    """How often somebody was told, and the stamp of the sources, of a new process."""
    environment = {"NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(package)}
    done = subprocess.run([sys.executable, "-c", FRESH], env=environment, capture_output=True, text=True, check=True)
    return done.stdout.split()


def test_who_waits_is_told_once_and_only_when_something_is_compiled(tmp_path: Path) -> None:
    source = Path(__file__).parents[2] / "src"
    first, second = run(tmp_path, source), run(tmp_path, source)
    assert (first[0], second[0]) == ("1", "0")
    assert first[1] == second[1]


def test_a_constant_from_another_file_makes_machine_code_anew(tmp_path: Path) -> None:
    copied = tmp_path / "src"
    shutil.copytree(Path(__file__).parents[2] / "src", copied)
    before = run(tmp_path / "cache", copied)
    transforms = copied / "taskgist/world/geometry/transforms.py"  # holds no compiled function itself
    assert "@compiled" not in transforms.read_text(encoding="utf-8")
    transforms.write_text(transforms.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    after = run(tmp_path / "cache", copied)
    assert (before[0], after[0]) == ("1", "1")
    assert before[1] != after[1]
