"""Kill ``taskgist learn`` again and again: nothing acknowledged may be lost, nothing half-written.

    python -m tools.kill --kills 300                 # a knowledge file in a temporary folder
    python -m tools.kill --kills 300 --url postgresql://postgres@/empty?host=/tmp

Several commands learn into the same knowledge at once, each from three files of facts. Each is killed (SIGKILL) at a
random time of its life; with files, every other one as soon as somebody's journal is there, that is, in the middle of
a transaction. Every round begins without knowledge, so that the first use is killed, too. After each round the
knowledge must be whole: all demonstrations of every command that ended well, and of one that was killed all or none.
Exit code 1 if it is not, or if a command that was not killed was refused.
"""

from __future__ import annotations

import argparse
import json
import random
import signal
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from taskgist.common.files import DRAFT
from taskgist.facts import read_facts
from taskgist.learning import explain
from taskgist.store import load, shown, tables
from taskgist.store.connecting import transact

COMMAND = (sys.executable, "-c", "from taskgist.cli import main; main()", "learn")
TOGETHER = 3
"""Demonstrations that one command adds: all, or none."""
FACTS = {
    "schema": "taskgist.facts/1",
    "task": "show",
    "performing_agent": "P1",
    "target_agent": "P2",
    "target_object": "cup",
    "start": {"see.effort": "Head_Effort", "posture": "Sitting", "motion": "Static"},
    "end": {"see.effort": "No_Effort_Required", "posture": "Sitting", "motion": "Static"},
}


@dataclass
class Attempt:
    """One command, and what became of it."""

    number: int
    digests: frozenset[str]
    exit_code: int = 0
    said: str = ""

    @property
    def outcome(self) -> str:
        """How it ended, in one word."""
        return {0: "acknowledged", -signal.SIGKILL: "killed"}.get(self.exit_code, "refused")


@dataclass
class Trial:
    """Rounds of commands that learn into one address and are killed."""

    address: str
    seed: int
    writers: int
    lasts_s: float = 0.0
    """How long a command takes that is not killed."""
    outcomes: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)

    def round(self, folder: Path, number: int, kills: int) -> None:
        """Kill so many commands that learn into knowledge that is not there yet, then look at the knowledge."""
        attempts: list[Attempt] = []
        killed, lock = [0], threading.Lock()

        def work(writer: int) -> None:
            chance = random.Random(f"{self.seed} {number} {writer}")
            while killed[0] < kills:
                with lock:
                    attempt, files = self._attempt(folder, 1000 * number + len(attempts))
                    attempts.append(attempt)
                self._run(attempt, files, chance)
                with lock:
                    killed[0] += attempt.outcome == "killed"

        if not self.lasts_s:
            self._measure(folder)
        self._forget()
        with ThreadPoolExecutor(self.writers) as pool:
            list(pool.map(work, range(self.writers)))
        self.outcomes.update(each.outcome for each in attempts)
        self.faults += self._looked_at(attempts)

    def _attempt(self, folder: Path, number: int) -> tuple[Attempt, list[Path]]:
        files = [folder / f"{number}_{part}.json" for part in range(TOGETHER)]
        for path in files:
            path.write_text(json.dumps({**FACTS, "demonstration": path.stem}), encoding="utf-8")
        return Attempt(number, frozenset(explain(read_facts(path)).digest for path in files)), files

    def _measure(self, folder: Path) -> None:
        """As many commands at once as are to be killed, left alone."""
        begun = time.monotonic()
        started = [self._started(self._attempt(folder, -number)[1]) for number in range(1, 1 + self.writers)]
        for process in started:
            process.communicate()
        self.lasts_s = time.monotonic() - begun

    def _started(self, files: list[Path]) -> subprocess.Popen[str]:
        words = [*COMMAND, *map(str, files), "-k", self.address, "--json"]
        return subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    def _run(self, attempt: Attempt, files: list[Path], chance: random.Random) -> None:
        """Start a command, and kill it unless it has ended by then."""
        begun = time.monotonic()
        process, journal = self._started(files), Path(f"{self.address}-journal")
        aimed = "://" not in self.address and chance.random() < 0.5
        aim_s = begun + 0.5 * self.lasts_s  # not at the journal of those who began before
        end_s = begun + self.lasts_s * (2.0 if aimed else chance.uniform(0.0, 1.2))
        while process.poll() is None and time.monotonic() < end_s:
            if aimed and time.monotonic() > aim_s and journal.exists():
                time.sleep(chance.uniform(0.0, 0.003))
                break
            time.sleep(0.0005 if aimed else 0.005)
        process.kill()
        attempt.said = process.communicate()[1]
        attempt.exit_code = process.returncode

    def _forget(self) -> None:
        if "://" in self.address:
            transact(self.address, tables.METADATA.drop_all)
        else:
            Path(self.address).unlink(missing_ok=True)

    def _looked_at(self, attempts: list[Attempt]) -> Iterator[str]:
        """What is wrong with the knowledge after these."""
        kept = self._kept()
        for each in attempts:
            there = each.digests & kept
            if each.outcome == "refused":
                yield f"{each.number}: exit code {each.exit_code}: {each.said.strip()}"
            if each.outcome == "acknowledged" and there != each.digests:
                yield f"{each.number}: acknowledged, but {len(each.digests - kept)} are lost"
            elif there not in (frozenset(), each.digests):
                yield f"{each.number}: half-written: {len(there)} of {len(each.digests)}"
            self.outcomes["killed, yet written"] += each.outcome == "killed" and there == each.digests
        if kept - frozenset().union(*(each.digests for each in attempts)):
            yield "knowledge that nobody added"

    def _kept(self) -> set[str]:
        """Digests of what the knowledge holds, after it has been looked at as a whole."""
        if "://" in self.address:
            if not transact(self.address, tables.exist, writing=False):
                return set()
        elif not Path(self.address).exists():
            return set()
        else:
            with sqlite3.connect(self.address) as connection:
                sound = connection.execute("PRAGMA integrity_check").fetchall()
            connection.close()
            if sound != [("ok",)]:
                self.faults.append(f"integrity: {sound}")
        return {each.digest for each in load(self.address).explanations}


@contextmanager
def place(url: str | None) -> Iterator[tuple[Path, str]]:
    """A folder for files of facts, and the address of the knowledge."""
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder), url or str(Path(folder) / "knowledge.db")


def killed(kills: int, *, seed: int = 0, url: str | None = None, writers: int = 4, each_round: int = 25) -> Trial:
    """Kill so many commands.

    Args:
        kills: How many.
        seed: Of the times at which they are killed.
        url: An empty database; None takes a file.
        writers: Commands at once.
        each_round: Kills until the knowledge is looked at and begun anew.
    """
    with place(url) as (folder, address):
        trial = Trial(address, seed, writers)
        begun = time.monotonic()
        for number, done in enumerate(range(0, kills, each_round)):
            trial.round(folder, number, min(each_round, kills - done))
            counts = ", ".join(f"{count} {outcome}" for outcome, count in sorted(trial.outcomes.items()))
            print(f"{time.monotonic() - begun:5.0f} s: {counts}; {len(trial.faults)} faults", file=sys.stderr)
        left = sorted(path.name for path in folder.iterdir() if path.suffix != ".json")
        # A draft is cleaned up by whoever next makes the file, a journal by whoever next opens it.
        excused = ("knowledge.db", "knowledge.db-journal")
        trial.faults += [f"left behind: {name}" for name in left if name not in excused and not name.endswith(DRAFT)]
    return trial


def main() -> int:
    """Kill as often as the options say; 1 if anything was wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--url", help="an empty database; default: a file in a temporary folder")
    parser.add_argument("--writers", type=int, default=4, help="commands at once")
    wishes = parser.parse_args()
    trial = killed(wishes.kills, seed=wishes.seed, url=wishes.url, writers=wishes.writers)
    counts = ", ".join(f"{count} {outcome}" for outcome, count in sorted(trial.outcomes.items()))
    print(f"{shown(wishes.url or 'a file')}: {counts}")
    print("\n".join(trial.faults) or "nothing acknowledged was lost, nothing was half-written, nothing was refused")
    return 1 if trial.faults else 0


if __name__ == "__main__":
    sys.exit(main())
