"""The files that ``taskgist perform`` writes: what each option asks for, checked before any long work.

Of several ways the first has the name that was given, the others get a number: done.mcap, done_2.mcap, ...
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from taskgist.cli.common import check_target
from taskgist.common.files import writing
from taskgist.errors import InputError

if TYPE_CHECKING:  # with MuJoCo, which a wrong name should not wait for
    from taskgist.pipeline.performing import Outcome, Performance


class Kind(NamedTuple):
    """One kind of file.

    Attributes:
        name: Of one of them, in documents.
        plural: Of many, in messages.
        suffixes: How their names end.
    """

    name: str
    plural: str
    suffixes: tuple[str, ...]


KINDS: Mapping[str, Kind] = {
    "--out": Kind("recording", "recordings", (".mcap",)),
    "--trajectory": Kind("trajectory", "trajectories", (".json",)),
    "--plan": Kind("plan", "plans", (".json",)),
    "--positions": Kind("positions", "positions", (".npz",)),
    "--picture": Kind("picture", "pictures", (".png",)),
    "--film": Kind("film", "films", (".webp", ".gif")),
}
"""By the option that asks for it, in the order in which they are written: films, which take longest, last."""


def check_files(asked: Mapping[str, Path], ways: int, *, replace: bool, inputs: Sequence[Path]) -> None:
    """Refuse files that could not be written.

    Args:
        asked: By option.
        ways: Of how many ways there may be one.
        replace: Whether they may be there already.
        inputs: Files that the command reads.

    Raises:
        InputError: As ``check_target``, or two options name one file.
    """
    taken: dict[Path, str] = {}
    for option, path in asked.items():
        kind = KINDS[option]
        for each in numbered(path, ways):
            check_target(each, option, replace=replace, inputs=inputs)
            if each.suffix.lower() not in kind.suffixes:
                formats = " or ".join(suffix[1:].upper() for suffix in kind.suffixes)
                hint = f"name it {' or '.join(kind.suffixes)}"
                raise InputError(f"{kind.plural} are {formats}", where=each, field=option, hint=hint)
            other = taken.setdefault(each.resolve(), option)
            if other != option:
                raise InputError(f"is named by {other}, too", where=each, field=option, hint="name another file")


def write_files(
    asked: Mapping[str, Path],
    performances: Sequence[Performance],
    *,
    replace: bool,
    progress: Callable[[str, float], None],
) -> list[dict[str, Path]]:
    """Write what was asked for, one of each kind for each way; each appears whole or not at all.

    Args:
        asked: By option.
        performances: The ways.
        replace: Whether files that are there already may be replaced.
        progress: Told how far it is.

    Returns:
        For each way the files by their kind's name.
    """
    return [
        {KINDS[option].name: _written(option, path, found, replace, progress) for option, path in _of_way(asked, way)}
        for way, found in enumerate(performances)
    ]


def _of_way(asked: Mapping[str, Path], way: int) -> Iterable[tuple[str, Path]]:
    return [(option, numbered(asked[option], way + 1)[way]) for option in KINDS if option in asked]


def _written(
    option: str, path: Path, found: Performance, replace: bool, progress: Callable[[str, float], None]
) -> Path:
    from taskgist.performing.outputs import plan_document, robot_trajectory, write_document, write_positions
    from taskgist.recording.mcap import write

    plan, execution = found.plan, found.execution
    match option:
        case "--out":
            write(execution.recording, path, replace=replace)
        case "--trajectory":
            write_document(robot_trajectory(plan, execution), path, replace=replace)
        case "--plan":
            write_document(plan_document(plan, execution), path, replace=replace)
        case "--positions":
            with writing(path, replace=replace) as stream:
                write_positions(execution.recording, stream)
        case "--picture":
            from taskgist.view.performance import performance_picture  # with matplotlib

            performance_picture(plan, execution, path)
        case "--film":
            from taskgist.view.performance import performance_film

            performance_film(plan, execution, path, progress=progress)
    return path


PDDL_FILES = ("domain.pddl", "problem.pddl", "places.json", "plan.txt")
"""What is written for other planners; of several plans the first, as the files of ways."""


def check_pddl(folder: Path | None, *, replace: bool) -> None:
    """Refuse a folder for PDDL that could not be written, before any long work.

    Raises:
        InputError: It is not there and cannot be made, or what would be written is there already.
    """
    if folder is not None:
        check_target(folder / "domain.pddl" if folder.is_dir() else folder, "--pddl", replace=replace, inputs=[])
        for name in PDDL_FILES if folder.is_dir() else ():
            check_target(folder / name, "--pddl", replace=replace, inputs=[])


def write_pddl(outcome: Outcome, folder: Path, *, replace: bool) -> Path:
    """Write the same problem for other planners: domain, problem, what its places are, and the plan if there is one.

    Raises:
        InputError: A file cannot be written, or is there already and not to be replaced.
    """
    found = outcome.pddl()
    folder.mkdir(exist_ok=True)
    texts = (
        found.domain,
        found.problem,
        json.dumps(found.places, ensure_ascii=False, indent=1) + "\n",
        *found.plans[:1],
    )
    for name, text in zip(PDDL_FILES, texts, strict=False):
        with writing(folder / name, replace=replace) as stream:
            stream.write(text.encode())
    return folder


def numbered(path: Path, ways: int) -> tuple[Path, ...]:
    """One file, or one for each way: done.mcap, done_2.mcap, ..."""
    return tuple(path if way == 1 else path.with_stem(f"{path.stem}_{way}") for way in range(1, ways + 1))
