"""One case of the fuzzer: a spoiled input, a command that is given it in a fork of this process, and a verdict.

A fork has all modules and machine code loaded, costs some milliseconds, and takes what it breaks down with it. It
works in a folder of its own, says what it says into files, and may use so much memory and time.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import random
import re
import resource
import shutil
import signal
import stat
import sys
import time
import traceback
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from taskgist.cli import main
from taskgist.errors import TaskgistError
from taskgist.maps.ability_map import read_maps
from taskgist_lab.evaluation.pool import read_pool
from taskgist_lab.paper.displacements import read_displacements
from tools.fuzz_mutations import mutated
from tools.fuzz_names import renamed
from tools.fuzz_seeds import Command, Seed
from tools.fuzz_tokens import NUMBERS, WORDS

READERS: dict[str, Callable[[Path], object]] = {
    "read-maps": read_maps,
    "read-pool": read_pool,
    "read-displacements": read_displacements,
}
"""What no command reads, or only after minutes."""
LIMIT_S = 20
"""Time on a processor after which a case hangs; on the clock thrice that, for the processor is shared."""
LIMIT_BYTES = 2 * 2**30
"""Memory that a case may take beyond what this process has."""
RESERVED_BYTES = 16 * 2**30
"""Addresses that a case may reserve beyond that; libraries reserve more than they use."""
GUARDED = 3
"""Exit status of a command that ends in an error that nobody expected."""
UNEXPECTED = 70
"""Exit status of a fork that ends in an error that nobody caught."""
OUT, ERR, WRONG = "out", "err", "wrong"
"""Names of the files that hold what a command says, and what a check found."""
READING = ("query", "explain", "facts", "check", "agent")
"""Commands that write nothing."""


@dataclass(frozen=True)
class Case:
    """One input and what is done with it: the same for the same numbers, whatever else runs.

    Attributes:
        seed: The fuzzer's.
        number: The case's.
        base: What is spoiled.
    """

    seed: int
    number: int
    base: Seed

    def prepared(self, folder: Path) -> tuple[Command, tuple[str, ...], frozenset[str]]:
        """Write the files; tell the command, how they were spoiled, and their names."""
        rng = random.Random(f"{self.seed}/{self.number}")
        command = rng.choice(self.base.commands)
        write_files(folder, self.base.files)
        if self.base.kind == "option":
            command, used = _options_spoiled(rng, command)
            return command, used, frozenset()
        if self.base.kind == "name":
            changed, command = renamed(rng, self.base.files, self.base.mutated, command)
            write_files(folder, changed)
            return command, ("renamed",), frozenset(changed)
        spoiled = rng.choice(self.base.mutated)
        if self.base.kind == "path":
            return *_path_spoiled(rng, folder, spoiled, command), frozenset({spoiled})
        data, used = mutated(rng, spoiled, self.base.files[spoiled])
        (folder / spoiled).write_bytes(data)
        return command, used, frozenset({spoiled})


@dataclass(frozen=True)
class Outcome:
    """What came of a case.

    Attributes:
        case: The case.
        command: The command.
        used: How its input was spoiled.
        fault: What is wrong, in a few words; empty if nothing is.
        room: Where an unexpected error was raised: file and line in the packages.
        told: The end of what was said on standard error.
        status: Exit status, or minus the signal that ended it.
        seconds: Time on a processor.
        mebibytes: Memory taken beyond this process's own.
    """

    case: Case
    command: Command
    used: tuple[str, ...]
    fault: str
    room: str
    told: str
    status: int
    seconds: float
    mebibytes: float


def write_files(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write files by their paths."""
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)


MEANT = (
    *(
        "P1",
        "P2",
        "R",
        "cup",
        "box",
        "mug",
        "table",
        "see",
        "reach",
        "grasp",
        "show",
        "hide",
        "narrow",
        "--json",
        "--why",
    ),
    *(
        "0",
        "0.05",
        "0.4",
        "1",
        "2",
        "0.1,0.1,0.2",
        "room.toml",
        "csv.toml",
        "show_a.mcap",
        "knowledge.db",
        "facts.json",
    ),
)
"""Arguments that mean something, here or elsewhere."""


def _options_spoiled(rng: random.Random, command: Command) -> tuple[Command, tuple[str, ...]]:
    """A command with other arguments."""
    words = list(command)
    harmless = [word for word in (*WORDS, *NUMBERS, *NUMBERS) if "/etc" not in word]  # it might be a target
    for _ in range(rng.choice((1, 1, 2))):
        at = rng.randrange(1, len(words)) if len(words) > 1 else 0
        what = rng.randrange(12)
        if what > 7:
            words[at] = rng.choice(MEANT)
        elif what == 0:
            words.pop(at)
        elif what == 1:
            words.insert(at, rng.choice((*harmless, *command, "--json", "--at", "--agent", "--every", "-o")))
        elif what == 2:
            depth = rng.choice((10, 500, 3000))
            words += ["--where", "not " * depth + "P1 sees"] if rng.random() < 0.5 else ["--where", "(" * depth]
        else:
            words[at] = rng.choice(harmless)
    plain = [word.replace("\x00", "\\0") for word in words]  # no system passes a NUL on
    return tuple(word for word in plain if len(word) < 100_000), ("arguments",)


def _circle(path: Path) -> None:
    """A circle of two links."""
    path.symlink_to("other")
    path.with_name("other").symlink_to(path.name)


def _huge(path: Path) -> None:
    path.touch()
    os.truncate(path, 8 * 2**30)


PATHS: dict[str, Callable[[Path], object]] = {
    "missing": lambda _: None,
    "folder": Path.mkdir,
    "pipe": os.mkfifo,
    "itself": lambda path: path.symlink_to(path.name),
    "circle": _circle,
    "zeros": lambda path: path.symlink_to("/dev/zero"),
    "full": lambda path: path.symlink_to("/dev/full"),
    "null": lambda path: path.symlink_to("/dev/null"),
    "huge": _huge,
    "socket": lambda path: os.mknod(path, stat.S_IFSOCK | 0o600),
    "mode": lambda path: path.touch(mode=0),
}
"""What stands in the place of a file."""
ODD_NAMES = ("\x1b[31mred", "new\nline", "\x9b5m", "a" * 200, " ", "\udcff", "-x", "x/" * 30)


def _path_spoiled(rng: random.Random, folder: Path, name: str, command: Command) -> tuple[Command, tuple[str, ...]]:
    """Something that is no regular file in the place of an input, or of what is written; or an odd name."""
    if name in command and rng.random() < 0.2:
        odd = rng.choice(ODD_NAMES) + Path(name).suffix
        if "/" not in odd:
            (folder / name).rename(folder / odd)
        return tuple(odd if word == name else word for word in command), ("odd name",)
    written = [word for word in command if word in ("out.mcap", "new.db")]
    path = folder / (written[0] if written and rng.random() < 0.3 else name)
    path.unlink(missing_ok=True)
    what = rng.choice(sorted(PATHS))
    PATHS[what](path)
    return command, (what,)


# --- Running: forks, as many at a time as there are processors, watched until they end.


def outcomes(cases: Iterator[Case], folder: Path, jobs: int, keep: Path | None = None) -> Iterator[Outcome]:
    """What comes of cases, in the order in which they end.

    Args:
        cases: The cases.
        folder: Where their folders are made, and taken away again.
        jobs: How many at a time.
        keep: Where the folders of those go that fail; nowhere if left out.
    """
    running: dict[int, _Running] = {}
    coming = enumerate(cases)
    while True:
        while len(running) < jobs and (following := next(coming, None)) is not None:
            slot = min(set(range(jobs)) - {each.slot for each in running.values()})
            started = _Running(following[1], folder / str(following[0]), slot)
            running[started.pid] = started
        if not running:
            return
        for pid, each in list(running.items()):
            if (outcome := each.ended()) is not None:
                del running[pid]
                if outcome.fault and keep is not None:
                    keep.mkdir(parents=True, exist_ok=True)
                    shutil.move(each.folder, keep / f"{outcome.case.seed}-{outcome.case.number}")
                shutil.rmtree(each.folder, ignore_errors=True)
                yield outcome
        time.sleep(0.002)


class _Running:
    """A fork at work."""

    def __init__(self, case: Case, folder: Path, slot: int) -> None:
        self.case, self.folder, self.slot = case, folder, slot
        self._work = folder / "work"
        self._work.mkdir(parents=True)
        self.command, self.used, self._spoiled = case.prepared(self._work)
        odd = {word for word in self.command if word not in case.base.files}
        self._written = {*case.base.written, *(odd if self._spoiled & set(case.base.written) else ())}
        self._before = _digests(self._work)
        self._started = time.monotonic()
        self._killed = ""
        self._from_bytes = _own_bytes(os.getpid())
        sys.stdout.flush()
        self.pid = os.fork()
        if self.pid == 0:
            self._run()

    def _run(self) -> None:
        """In the fork: run the command, and never return."""
        status = UNEXPECTED
        try:
            os.setsid()
            processors = sorted(os.sched_getaffinity(0))  # one is enough: what it forks itself would not be watched
            os.sched_setaffinity(0, {processors[self.slot % len(processors)]})
            _limit()
            for descriptor, name in ((0, os.devnull), (1, self.folder / OUT), (2, self.folder / ERR)):
                os.dup2(os.open(name, os.O_RDONLY if descriptor == 0 else os.O_WRONLY | os.O_CREAT), descriptor)
            sys.stdout = io.TextIOWrapper(open(1, "wb", closefd=False), "utf-8")  # noqa: SIM115
            sys.stderr = io.TextIOWrapper(open(2, "wb", closefd=False), "utf-8", "backslashreplace")  # noqa: SIM115
            with contextlib.suppress(FileNotFoundError):
                shutil.copytree(Path(os.environ["XDG_CACHE_HOME"]) / "taskgist", self.folder / "taskgist")
            os.environ["XDG_CACHE_HOME"] = str(self.folder)
            os.chdir(self._work)
            wrong = self.case.base.check(self.command) if self.case.base.check else str
            status = run(self.command)
            if status in (0, 1) and (found := wrong()):
                (self.folder / WRONG).write_text(found, "utf-8", "backslashreplace")
            if status == GUARDED:
                run((*self.command, "--debug"))  # again, and where it happens
        except BaseException:
            traceback.print_exc()
        finally:
            with contextlib.suppress(BaseException):
                sys.stdout.flush()
                sys.stderr.flush()
            os._exit(status)

    def ended(self) -> Outcome | None:
        """What came of it; None while it is at work. One that goes beyond its limits is ended."""
        pid, status, usage = os.wait4(self.pid, os.WNOHANG)
        if pid == 0:
            if not self._killed and _own_bytes(self.pid) - self._from_bytes > LIMIT_BYTES:
                self._kill("memory")
            if not self._killed and time.monotonic() - self._started > 3 * LIMIT_S:
                self._kill("hang")
            return None
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)  # what it may have started
        code = os.waitstatus_to_exitcode(status)
        out, told = (_read(self.folder / name) for name in (OUT, ERR))
        fault = self._fault(code, out, told)
        return Outcome(
            self.case,
            self.command,
            self.used,
            fault,
            _raised_at(told) if fault in ("traceback", "unexpected error") else "",
            told[-3000:],
            code,
            usage.ru_utime + usage.ru_stime,
            max(0.0, usage.ru_maxrss / 1024 - self._from_bytes / 2**20),
        )

    def _kill(self, why: str) -> None:
        self._killed = why
        os.killpg(self.pid, signal.SIGKILL)

    def _fault(self, code: int, out: str, told: str) -> str:
        """What is wrong, in a few words; nothing if all is as promised."""
        if self._killed:
            return self._killed
        if code in (-signal.SIGXCPU, -signal.SIGKILL):
            return "hang"
        if code < 0:
            return f"ended by {signal.Signals(-code).name}"
        if code == GUARDED:
            return "unexpected error"
        if code not in (0, 1, 2) or "Traceback (most recent call last)" in told:
            return "traceback"
        if wrong := _read(self.folder / WRONG):
            return wrong
        files = self.case.base.files.keys() | self._written
        given = [word for word in self.command if word in files or "/" in word]
        named = [Path(name).stem for name in (*self._spoiled, *given)]
        return _odd_texts(code, out, told, named if self._spoiled else [""], self.command) or self._changed(code)

    def _changed(self, code: int) -> str:
        after = _digests(self._work)
        written = set() if code == 2 or self.command[0] in READING else self._written
        for name, digest in self._before.items():
            if after.get(name) != digest and name not in written:
                return f"changed {name}"
        left = sorted(after.keys() - self._before.keys() - self._written)
        if any(name.endswith((".draft", "MUJOCO_LOG.TXT")) for name in left):
            return "left a file behind"
        return ""


def run(command: Command) -> int:
    """Run a command in this process; its exit status."""
    if command and command[0] in READERS:
        try:
            READERS[command[0]](Path(command[1]))
        except TaskgistError as error:
            sys.stderr.write(f"error: {error}\n")
            return 2
        return 0
    sys.argv = ["taskgist", *command]
    try:
        main()
    except SystemExit as ending:
        return ending.code if isinstance(ending.code, int) else 0 if ending.code is None else 1
    return 0


def _limit() -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT_S, LIMIT_S + 5))
    signal.alarm(4 * LIMIT_S)  # should nobody watch it any longer
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * resource.getpagesize() + RESERVED_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_FSIZE, (2**30, 2**30))


def _own_bytes(pid: int) -> int:
    """Memory of a process that is no file's."""
    try:
        _, resident, shared, *_ = map(int, Path(f"/proc/{pid}/statm").read_text().split())
        return (resident - shared) * resource.getpagesize()
    except (OSError, ValueError):
        return 0


def _digests(folder: Path) -> dict[str, str]:
    """What is in a folder: digests of files, and what else there is."""
    found = {}
    for path in folder.rglob("*"):
        kind = path.lstat()
        plain = stat.S_ISREG(kind.st_mode) and kind.st_size < 2**26
        content = hashlib.sha256(path.read_bytes()).hexdigest() if plain else f"{kind.st_mode} {kind.st_size}"
        found[str(path.relative_to(folder))] = content
    return found


def _read(path: Path) -> str:
    try:
        with path.open("rb") as stream:
            return stream.read(10_000_000).decode("utf-8", "surrogateescape")
    except OSError:
        return ""


CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")
"""What moves the cursor, or turns the direction of writing around."""
NOISE = re.compile(r"^\S*Warning\b|: \w*Warning: |^WARNING|^WARN\b", re.MULTILINE)
USAGE = re.compile(r"^Usage: ", re.MULTILINE)


def _odd_texts(code: int, out: str, told: str, named: Sequence[str], command: Command) -> str:
    """What is wrong with what was said; a refusal must have one of some names in it."""
    if CONTROLS.search(out) or CONTROLS.search(told):
        return "control characters"
    if NOISE.search(told):
        return "warning"
    if code == 2 and not told.strip():
        return "refused without a word"
    if code == 2 and not USAGE.search(told) and not any(name in told for name in named):
        return "no file named"
    if code == 2 and len(told) > 4000:
        return "a long message"
    asked_for_json = command[-1:] == ("--json",) and not command[-2].startswith("--")  # else it is an option's value
    if code == 0 and asked_for_json and "--help" not in command and not _is_json(out):
        return "no JSON"
    return ""


def _is_json(text: str) -> bool:
    try:
        json.loads(text, parse_constant=lambda constant: float(f"no {constant}"))
    except ValueError:
        return False
    return True


def _raised_at(told: str) -> str:
    """The last line of the packages in a traceback, and the error."""
    places = re.findall(r'File "[^"]*/(taskgist(?:_lab)?/[^"]+)", line (\d+)', told)
    if not places:
        return ""
    errors = re.findall(r"^([\w.]*(?:Error|Exception|Warning))\b", told, re.MULTILINE) or ["?"]
    file, line = places[-1]
    return f"{file}:{line} {errors[-1]}"


def chosen(seed: int, numbers: Iterable[int], bases: Sequence[Seed], kinds: Collection[str]) -> Iterator[Case]:
    """Cases by number, of some kinds."""
    for number in numbers:
        base = bases[number % len(bases)]
        if base.kind in kinds:
            yield Case(seed, number, base)
