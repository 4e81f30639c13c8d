"""How many of our files a command walks through: what somebody who follows it would have to open.

    python -m tools.walk learn demo.mcap -k /tmp/knowledge.db
    python -m tools.walk --json query room.toml --object cup
    python -m tools.walk --page          # measure the examples below, put the figures into docs/how/architecture.md

Counts the files, and the functions in them, that *run* while the command works; compiled functions count where Python
calls them. What runs while a module is imported (module and class bodies, decorators) does not count: how many of our
modules are loaded is said beside it, and which of the large libraries.
"""

from __future__ import annotations

import argparse
import contextlib
import inspect
import io
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from types import FrameType
from typing import Any

from tools.markdown import filled, header, row

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src"
PAGE = next((ROOT / "docs").rglob("architecture.md"))
RECORDINGS = SOURCE / "taskgist/data/recordings/study/show"
LEARN = "learn FOLDER/show_a.mcap"
QUERY = "query FOLDER/show_a.mcap --agent P2 --object cup"
EXPLAIN = "explain show"
EXAMPLES = ("--version", "--help", LEARN, EXPLAIN, QUERY)
KNOWING = (LEARN, EXPLAIN)
"""Commands that take the option --knowledge."""
LARGE = ("mujoco", "numba", "numpy", "matplotlib", "sqlalchemy")


@dataclass(frozen=True)
class Walk:
    """What a command went through."""

    exit_code: int
    functions: dict[str, list[str]]
    """Functions that ran, by file."""
    modules: int
    """Modules of ours that are loaded."""
    large: list[str]
    """Large libraries that are loaded."""
    compiled: bool
    """Whether something had to be compiled, for which functions of ours ran that otherwise do not."""


class _Calls:
    """Sees every call of a Python function of ours, unless it happens while some module is imported."""

    def __init__(self) -> None:
        self.seen: set[tuple[str, str]] = set()
        self._imports = 0

    def __call__(self, frame: FrameType, event: str, _argument: object) -> None:
        code = frame.f_code
        if code.co_name == "<module>":
            self._imports += {"call": 1, "return": -1}.get(event, 0)
        elif event == "call" and not self._imports and code.co_flags & inspect.CO_OPTIMIZED:  # class bodies are not
            self.seen.add((code.co_filename, code.co_qualname.partition(".<locals>")[0]))


def walk(words: Sequence[str]) -> Walk:
    """Run a command in this process, its output aside.

    Args:
        words: The command line, without ``taskgist``.
    """
    from taskgist.cli import main

    calls, code = _Calls(), 0
    sys.argv = ["taskgist", *words]
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        sys.setprofile(calls)
        try:
            main()
        except SystemExit as end:
            code = int(end.code or 0)
        finally:
            sys.setprofile(None)
    functions: dict[str, list[str]] = {}
    for file, name in sorted(calls.seen | set(_compiled_that_ran())):
        if Path(file).is_relative_to(SOURCE):
            functions.setdefault(str(Path(file).relative_to(SOURCE)), []).append(name)
    ours = [name for name in sys.modules if name.partition(".")[0] in ("taskgist", "taskgist_lab")]
    large = [name for name in LARGE if name in sys.modules]
    return Walk(code, functions, len(ours), large, any(each.stats.cache_misses for each in _dispatchers()))


def _compiled_that_ran() -> Iterator[tuple[str, str]]:
    """Compiled functions that Python called: they have machine code in this process. No profiler sees them."""
    for each in _dispatchers():
        yield each.py_func.__code__.co_filename, each.py_func.__qualname__


def _dispatchers() -> Iterator[Any]:
    """What numba made of functions of ours that have machine code in this process."""
    for module in [module for name, module in sys.modules.items() if name.startswith("taskgist")]:
        for value in vars(module).values():
            if getattr(value, "overloads", None) and hasattr(value, "py_func"):
                yield value


def measured(words: Sequence[str]) -> dict[str, Any]:
    """A walk in a process of its own, as ``--json`` says it: a second one, if the first had to compile something."""
    command = [sys.executable, "-m", "tools.walk", "--json", "--", *words]
    for _ in range(2):
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
        found = dict(json.loads(done.stdout))
        if not found["compiled"]:
            break
    return found


def page_lines() -> Iterator[str]:
    """The table of the page."""
    yield from header("files", "functions", "modules loaded", "large libraries loaded", "command")
    with tempfile.TemporaryDirectory() as folder:
        for words in EXAMPLES:
            command = words.replace("FOLDER", str(RECORDINGS))
            found = measured([*command.split(), *(("-k", f"{folder}/knowledge.db") if words in KNOWING else ())])
            large = ", ".join(found["large"]) or "none"
            yield row(len(found["functions"]), found["functions_count"], found["modules"], large, f"`taskgist {words}`")


def main() -> int:
    """Walk; print what was found. The exit code is that of the command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument("--page", action="store_true", help=f"put the figures of examples into {PAGE.name}")
    parser.add_argument("words", nargs=argparse.REMAINDER, help="the command line, without `taskgist`")
    asked = parser.parse_args()
    if asked.page:
        PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), {"walk": page_lines()}), encoding="utf-8")
        return 0
    found = walk(asked.words)
    count = sum(map(len, found.functions.values()))
    if asked.json:
        print(json.dumps({**asdict(found), "functions_count": count}, indent=2))
        return found.exit_code
    for file, names in found.functions.items():
        print(f"{len(names):5}  {file}")
    print(f"{count:5}  functions ran, in {len(found.functions)} files")
    print(f"{found.modules:5}  modules of ours are loaded, and {', '.join(found.large) or 'no large library'}")
    return found.exit_code


if __name__ == "__main__":
    sys.exit(main())
