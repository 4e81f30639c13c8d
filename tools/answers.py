"""Keep what taskgist answers today, and compare it with what it answers after a change that should change nothing.

    python -m tools.answers FOLDER               # ask everything, keep the answers there
    python -m tools.answers AFTER --like FOLDER  # ask again, compare; exit code 1 if any answer differs

Asked is the command line, in one process per core: facts, evidence, check-ups, labels and knowledge of all shipped
recordings and of generated ones, the paper's results, queries with reasons and maps of rooms and of moments, pictures.
Of the generated demonstrations those that were kept are asked about, and those that are generated now.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import io
import json
import multiprocessing
import re
import sys
import tempfile
import time
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parent.parent
RECORDINGS = ROOT / "src" / "taskgist" / "data" / "recordings"
TASKS = (
    ["show", "hide", "make accessible", "give", "put away", "hide away"]
    + ["tap", "drop", "dump", "throw", "lift"]  # those that are no tasks of the paper's
)
SEED = 4711
NOT_COMPARED = re.compile(
    r"(seconds|duration|elapsed|knowledge|picture|folder|path|(longest|shortest|median|perspective)_s$)", re.IGNORECASE
)
"""Keys of times that were measured and of places on this machine."""
PATHS = re.compile(r"[^\s\"']*/src(?=/taskgist)|[^\s\"']*(?=/out\.(npz|png|db))")


@dataclass(frozen=True)
class Question:
    """One call of the command line, and the file that it is to write, if any."""

    name: str
    arguments: tuple[str, ...]
    writes: str | None = None  # suffix; {out} stands for it among the arguments


def questions(  # noqa: C901 - one after another
    rooms: list[Path], generated: Path, remade: Path
) -> Iterator[Question]:
    """Everything that is asked."""
    shipped = sorted(RECORDINGS.rglob("*.mcap"))
    yield Question("paper", ("paper", "--json"))
    for body in ("human", "pr2", "talos", "jido", "hrp2"):
        yield Question(f"agent {body}", ("agent", "check", body, "--json"))
    for path in shipped:
        yield from _about_recording(f"shipped {path.stem}", path)
        task = path.parent.name.replace("_", " ")
        proposal = ("label", str(path), "--propose", "--task", task, "--dry-run", "--json")
        yield Question(f"shipped {path.stem} proposal", proposal)
        yield Question(f"shipped {path.stem} check", ("check", str(path), "--json"))
        for at in ("0.5", "4"):
            yield Question(f"shipped {path.stem} query {at}", ("query", str(path), "--at", at, "--why", "--json"))
    for folder, kind in ((generated, "kept"), (remade, "made")):
        for path in sorted(folder.rglob("*.mcap")):
            yield Question(f"{kind} {path.stem} facts", ("facts", str(path), "--every", "2", "--json"))
    for folder in sorted({path.parent for path in shipped} | {path.parent for path in generated.rglob("*.mcap")}):
        yield Question(
            f"learn {folder.parent.name} {folder.name}", ("learn", str(folder), "-k", "{out}", "--json"), ".db"
        )
    for room in rooms:
        yield Question(f"room {room.parent.name} {room.stem}", ("query", str(room), "--why", "--json"))
    for number, path in enumerate((*rooms[:6], *shipped[::6])):
        yield from _maps(f"{number} {path.parent.name} {path.stem}", path)
    for path in shipped[::4]:
        label = json.loads(ask(Question("", ("label", str(path), "--json")))["text"])
        agent = label["target_agent"]
        for at in ("0.5", "5"):
            call = ("see", str(path), "--agent", agent, "--at", at, "-o", "{out}", "--json")
            yield Question(f"see {path.stem} {at}", call, ".png")


def _about_recording(name: str, path: Path) -> Iterator[Question]:
    yield Question(f"{name} facts", ("facts", str(path), "--json"))
    for at in ("0.5", "2", "5"):
        yield Question(f"{name} facts {at}", ("facts", str(path), "--at", at, "--json"))


def _maps(name: str, path: Path) -> Iterator[Question]:
    if path.suffix == ".mcap":
        label = json.loads(ask(Question("", ("label", str(path), "--json")))["text"])
        agent = label["target_agent"]
    else:
        agent = re.findall(r"\[agents\.(\w+)\]", path.read_text(encoding="utf-8"))[0]
    for ability in ("reach", "see"):
        call = ("map", str(path), "--agent", agent, "--ability", ability, "--json")
        yield Question(f"map {name} {ability}", (*call, "--npz", "{out}"), ".npz")
        yield Question(f"map picture {name} {ability}", (*call, "-o", "{out}"), ".png")


def ask(question: Question) -> dict[str, Any]:
    """What the command line answers: exit code, text, errors, and a digest of the file it wrote."""
    from taskgist.cli import main

    arguments = list(question.arguments)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / f"out{question.writes}"
        arguments = [str(out) if each == "{out}" else each for each in arguments]
        text, told = io.StringIO(), io.StringIO()
        sys.argv = ["taskgist", *arguments]
        code: Any = 0
        with contextlib.redirect_stdout(text), contextlib.redirect_stderr(told):
            try:
                main()
            except SystemExit as end:
                code = end.code
            except Exception as error:  # an answer, too
                code = repr(error)
        answer = {"code": code, "text": text.getvalue(), "errors": told.getvalue().replace(folder, "")}
        if question.writes and out.exists():
            answer |= _digests(out)
    return answer


def _digests(path: Path) -> dict[str, Any]:
    if path.suffix == ".png":
        import matplotlib.image

        pixels = np.ascontiguousarray(np.round(255 * matplotlib.image.imread(path)).astype(np.uint8))
        return {"pixels": hashlib.sha256(pixels.tobytes()).hexdigest()}
    if path.suffix == ".npz":
        with zipfile.ZipFile(path):
            arrays = np.load(path)
        return {"arrays": {name: _packed(arrays[name]) for name in arrays.files}}
    return {}


def _packed(array: np.ndarray[Any, Any]) -> dict[str, Any]:
    """Counts of levels, and all values of small whole numbers, so that differing cells can be counted."""
    flat = np.ascontiguousarray(array)
    told: dict[str, Any] = {"sha": hashlib.sha256(flat.tobytes()).hexdigest(), "shape": list(flat.shape)}
    if flat.dtype.kind in "iub" and flat.size > 1000:
        told["values"] = "".join(chr(48 + int(value) % 75) for value in flat.ravel())
    return told


def answered(question: Question) -> tuple[str, dict[str, Any]]:
    """A question's name and answer."""
    return question.name, ask(question)


def simulate(folder: Path, count: int) -> None:
    """Generate demonstrations of every task."""
    for task in TASKS:
        call = ("simulate", task, "-n", str(count), "-s", str(SEED), "-o", str(folder / task), "--json")
        if not (folder / task).exists():
            print(f"simulating {task}", ask(Question("", call))["code"], flush=True)


def differences(before: Any, after: Any, where: str = "") -> Iterator[str]:
    """Where two documents differ."""
    if isinstance(before, dict) and isinstance(after, dict):
        for key in sorted(before.keys() | after.keys(), key=str):
            if not NOT_COMPARED.search(str(key)):
                yield from differences(before.get(key), after.get(key), f"{where}/{key}")
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for number, (one, other) in enumerate(zip(before, after, strict=True)):
            yield from differences(one, other, f"{where}/{number}")
    elif before != after:
        if where.endswith("/values") and len(before) == len(after):
            cells = sum(one != other for one, other in zip(before, after, strict=True))
            yield f"{where}: {cells} of {len(before)} cells"
        else:
            yield f"{where}: {str(before)[:200]} -> {str(after)[:200]}"


def _parsed(answer: dict[str, Any]) -> dict[str, Any]:
    """An answer with its JSON read, and paths of this checkout told from its root on."""
    answer = {key: PATHS.sub("", text) if isinstance(text, str) else text for key, text in answer.items()}
    with contextlib.suppress(ValueError):
        return {**answer, "text": json.loads(answer["text"])}
    return answer


def compare(before: dict[str, Any], after: dict[str, Any]) -> int:
    """Print what differs; the number of answers that do."""
    wrong = 0
    for name in sorted(before.keys() | after.keys()):
        one, other = before.get(name, {}), after.get(name, {})
        found = list(differences(_parsed(one), _parsed(other)))
        wrong += bool(found)
        for line in found[:5]:
            print(f"{name}: {line}")
        if len(found) > 5:
            print(f"{name}: and {len(found) - 5} more")
    print(f"{len(before.keys() & after.keys())} answers compared, {wrong} differ")
    return wrong


def main() -> int:
    """Ask, keep, compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="where to keep the answers")
    parser.add_argument("--like", type=Path, help="compare with the answers kept there")
    parser.add_argument("--rooms", type=Path, help="folder of scenes (.toml) to ask about, too")
    parser.add_argument("--count", type=int, default=19, help="generated demonstrations of each of eleven tasks")
    parser.add_argument("--only", default="", help="only questions whose name holds this")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    made = options.folder / "simulated"
    if not options.only or options.only.startswith("made"):
        simulate(made, options.count)
    kept = (options.like or options.folder) / "simulated"
    rooms = sorted(options.rooms.rglob("*.toml")) if options.rooms else []
    asked = [each for each in questions(rooms, kept, made) if options.only in each.name]
    start, answers = time.time(), {}
    with multiprocessing.get_context("spawn").Pool(multiprocessing.cpu_count()) as pool:
        for number, (name, answer) in enumerate(pool.imap_unordered(answered, asked), start=1):
            answers[name] = answer
            print(f"\r{number} of {len(asked)}, {time.time() - start:.0f} s", end="", file=sys.stderr)
    print(file=sys.stderr)
    (options.folder / "answers.json").write_text(json.dumps(answers), encoding="utf-8")
    if options.like:
        before = json.loads((options.like / "answers.json").read_text(encoding="utf-8"))
        before = {name: answer for name, answer in before.items() if options.only in name}
        return int(compare(before, answers) > 0)
    return 0


if __name__ == "__main__":
    sys.exit(main())
