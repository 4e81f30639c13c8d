"""Spoil inputs of every kind, and look what the commands make of them: ``make fuzz``.

    python -m tools.fuzz --seed 7                  # 10,000 cases on all cores
    python -m tools.fuzz --seed 7 --case 1234      # one of them again, and what it says

Nothing may end in an unexpected error, hang, take memory without bound, change what is only read, or bring control
characters to the terminal; what is refused is refused by name. ``fuzz_seeds`` and ``fuzz_rooms`` have the inputs,
``fuzz_tokens``, ``fuzz_mutations`` and ``fuzz_names`` how they are spoiled, ``fuzz_cases`` and ``fuzz_checks`` how a
case is run and judged.
"""

from __future__ import annotations

import argparse
import contextlib
import gc
import io
import itertools
import json
import os
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # a process with threads cannot be forked safely

from tools.fuzz_cases import Outcome, chosen, outcomes, run, write_files
from tools.fuzz_rooms import CONCAVE
from tools.fuzz_seeds import Command, Seed, seeds


def main() -> int:
    """Fuzz; the exit status says whether all is as promised."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=10_000, help="how many")
    parser.add_argument("--seed", type=int, default=0, help="other seeds, other cases")
    parser.add_argument("--case", type=int, help="only this one")
    parser.add_argument("--only", action="append", help="only this kind of inputs")
    parser.add_argument("--skip", action="append", default=[], help="all kinds of inputs but this one")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="cases at a time")
    parser.add_argument("--keep", type=Path, help="folder for the inputs of cases that fail")
    parser.add_argument("--json", action="store_true", help="print one document instead of text")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="taskgist-fuzz-") as name:
        bases = warmed(Path(name))
        known = dict.fromkeys(base.kind for base in bases)
        if unknown := {*(options.only or ()), *options.skip} - known.keys():
            parser.error(f"no kind {', '.join(unknown)}; known are {', '.join(known)}")
        kinds = set(options.only or known) - set(options.skip)
        numbers: Iterable[int] = itertools.count() if options.case is None else [options.case]
        cases = itertools.islice(chosen(options.seed, numbers, bases, kinds), options.cases)
        started, found = time.monotonic(), []
        for outcome in outcomes(cases, Path(name) / "cases", options.jobs, options.keep):
            found.append(outcome)
            if not options.json and (outcome.fault or options.case is not None):
                print(described(outcome, whole=options.case is not None), flush=True)
        seconds = time.monotonic() - started
    print(json.dumps(document(found, seconds), indent=1) if options.json else summary(found, seconds))
    return 1 if any(outcome.fault for outcome in found) else 0


def warmed(folder: Path) -> tuple[Seed, ...]:
    """The seeds, after all their commands have run in this process: what they load and compile, forks have.

    Concave meshes are cut in a fork, for that starts threads. The parts are kept in a cache, which each case gets.

    Args:
        folder: An empty one, to work in.

    Raises:
        RuntimeError: A command refuses a seed, or has left a thread behind.
    """
    made = folder / "made"
    made.mkdir()
    os.environ["XDG_CACHE_HOME"] = str(folder / "cache")
    bases, done = seeds(made), set()
    for base in bases:
        for command in base.commands:
            if (same := (command, base.check, frozenset(base.files.items()))) in done:
                continue
            done.add(same)
            work = Path(tempfile.mkdtemp(dir=folder))
            write_files(work, base.files)
            if CONCAVE.intersection(base.files.values()):
                if (pid := os.fork()) == 0:
                    try:
                        _refused(work, base, command)
                    finally:
                        os._exit(0)
                os.waitpid(pid, 0)  # the parts are kept now
            if refused := _refused(work, base, command):
                raise RuntimeError(f"{base.kind}: {' '.join(command)}: {refused}")
    if len(list(Path("/proc/self/task").iterdir())) > 1:
        raise RuntimeError("a process with threads cannot be forked safely")
    gc.collect()
    gc.freeze()
    return bases


def _refused(work: Path, base: Seed, command: Command) -> str | None:
    """Why a command does not do what it should with files that are right; None if it does."""
    before, said = Path.cwd(), io.StringIO()
    os.chdir(work)
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
            wrong = base.check(command) if base.check else str
            status = run(command)
            return (wrong() or None) if status in (0, 1) else f"ends with {status}: {said.getvalue()}"
    finally:
        os.chdir(before)


def described(outcome: Outcome, *, whole: bool = False) -> str:
    """A case in a line, or with all that it said."""
    line = " ".join(word if word.isprintable() and len(word) < 80 else ascii(word)[:80] for word in outcome.command)
    by = ", ".join(outcome.used)
    text = f"{outcome.fault or 'as promised'} [{outcome.case.base.kind}; {by}] taskgist {line} {outcome.room}"
    text += f"\n    python -m tools.fuzz --seed {outcome.case.seed} --case {outcome.case.number}"
    if whole:
        text += (
            f"\n    exit status {outcome.status}, {outcome.seconds:.2f} s, {outcome.mebibytes:.0f} MiB\n{outcome.told}"
        )
    return text.encode("utf-8", "backslashreplace").decode()


def summary(found: Sequence[Outcome], seconds: float) -> str:
    """What was found, by kind, by place and by mutation."""
    failed = [outcome for outcome in found if outcome.fault]
    lines = [f"{len(found)} cases in {seconds:.0f} s, {len(failed)} not as promised"]
    kinds = Counter(outcome.case.base.kind for outcome in found)
    for kind, count in kinds.items():
        of_kind = [outcome for outcome in found if outcome.case.base.kind == kind]
        statuses = Counter(outcome.status for outcome in of_kind)
        faults = Counter(outcome.fault for outcome in of_kind if outcome.fault)
        seconds_each = sum(outcome.seconds for outcome in of_kind) / count
        line = f"  {kind}: {count}, {seconds_each:.3f} s each, exit status {dict(sorted(statuses.items()))}"
        lines.append(f"{line} {dict(faults)}" if faults else line)
    lines += [f"  {count} x {fault} {room}" for (fault, room), count in _groups(failed).most_common()]
    lines += [f"  {name}: {bad} of {count}" for name, (bad, count) in _by_mutation(found).items() if bad]
    slowest = max(found, key=lambda outcome: outcome.seconds)
    largest = max(found, key=lambda outcome: outcome.mebibytes)
    lines.append(f"  longest: {slowest.seconds:.1f} s (case {slowest.case.number})")
    lines.append(f"  most memory: {largest.mebibytes:.0f} MiB (case {largest.case.number})")
    return "\n".join(lines)


def document(found: Sequence[Outcome], seconds: float) -> dict[str, object]:
    """The same as plain data."""
    return {
        "cases": len(found),
        "seconds": seconds,
        "faults": [
            {
                "case": outcome.case.number,
                "seed": outcome.case.seed,
                "kind": outcome.case.base.kind,
                "command": [ascii(word)[1:-1][:200] for word in outcome.command],
                "mutations": outcome.used,
                "fault": outcome.fault,
                "raised": outcome.room,
                "status": outcome.status,
                "told": outcome.told.encode("utf-8", "backslashreplace").decode(),
            }
            for outcome in found
            if outcome.fault
        ],
        "mutations": _by_mutation(found),
    }


def _groups(failed: Sequence[Outcome]) -> Counter[tuple[str, str]]:
    return Counter((outcome.fault, outcome.room or outcome.case.base.kind) for outcome in failed)


def _by_mutation(found: Sequence[Outcome]) -> dict[str, tuple[int, int]]:
    """By mutation: cases with a fault in which it had a part, and all cases in which it had."""
    all_, bad = Counter[str](), Counter[str]()
    for outcome in found:
        all_.update(set(outcome.used))
        bad.update(set(outcome.used) if outcome.fault else ())
    return {name: (bad[name], count) for name, count in all_.most_common()}


if __name__ == "__main__":
    sys.exit(main())
