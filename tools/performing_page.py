"""Measure performing, or read what was measured; figures for docs/research/performing.md.

python -m tools.performing_page --rooms 6
taskgist evaluate perform --rooms 6 --kept found.json; python -m tools.performing_page found.json
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping
from pathlib import Path

from taskgist.cli.common import progress_bar
from taskgist.settings import DEFAULT
from taskgist_lab.cli.evaluate import HELD_OUT_SEED
from taskgist_lab.evaluation.performing.trials import TrialsFound, performed_trials, sheets
from taskgist_lab.evaluation.sheets import Sheet
from tools.markdown import filled, sheet_lines

PAGE = Path(__file__).parents[1] / "docs" / "research" / "performing.md"
NAMES = ("shares", "task", "times", "gates", "faults")
"""Names of the tables' places on the page, in their order."""


def main() -> None:
    """Measure or read, and rewrite the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "found", nargs="?", type=Path, help="what taskgist evaluate perform --kept wrote, or --json printed"
    )
    parser.add_argument("--rooms", type=int, default=6)
    parser.add_argument("--seed", type=int, default=HELD_OUT_SEED)
    chosen = parser.parse_args()
    if chosen.found:
        found = TrialsFound.of_json(json.loads(chosen.found.read_text(encoding="utf-8"))["perform"])
    else:
        with progress_bar() as progress:
            found = performed_trials(count=chosen.rooms, seed=chosen.seed, progress=progress)
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), parts(found)), encoding="utf-8")


def parts(found: TrialsFound) -> Mapping[str, Iterator[str]]:
    """The measured parts of the page by name."""
    tables = dict(zip(NAMES, sheets(found), strict=False))
    return {"what": about(found), **{name: table(tables[name]) if name in tables else iter(()) for name in NAMES}}


def about(found: TrialsFound) -> Iterator[str]:
    """What was measured."""
    yield f"Seed {found.seed}, settings {DEFAULT.digest}, {len(found.trials)} trials."


def table(sheet: Sheet) -> Iterator[str]:
    """A table in Markdown, its title above."""
    yield f"**{sheet.title}**"
    yield ""
    yield from sheet_lines(sheet)


if __name__ == "__main__":
    main()
