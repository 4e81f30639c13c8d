"""Measure ordinary rooms; figures and a picture for docs/research/people.md: ``python -m tools.ordinary_page``."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path

from benchmarks.ordinary_rooms import ROOMS, SEED
from taskgist.cli.common import progress_bar
from taskgist.settings import DEFAULT
from taskgist_lab.evaluation.ordinary_rooms import RoomsFound, judged_room, judged_rooms, sheets
from taskgist_lab.evaluation.sheets import Sheet
from taskgist_lab.ordinary.furnishing import furnished
from taskgist_lab.view import ordinary_room_picture
from tools.markdown import filled, sheet_lines

PAGE, PICTURE = Path("docs/research/people.md"), Path("docs/pictures/ordinary_room.png")
DRAWN = 0
"""The room that is drawn."""


def main() -> None:
    """Measure, draw, rewrite the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rooms", type=int, default=ROOMS)
    parser.add_argument("--seed", type=int, default=SEED)
    chosen = parser.parse_args()
    with progress_bar() as progress:
        found = judged_rooms(count=chosen.rooms, seed=chosen.seed, progress=progress)
    room = furnished(chosen.seed, DRAWN)
    ordinary_room_picture(room, list(judged_room(room)), "reach", PICTURE)
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), parts(found)), encoding="utf-8")


def parts(found: RoomsFound) -> Mapping[str, Iterator[str]]:
    """The measured parts of the page by name: each table by what it shows."""
    first, *others = sheets(found)
    named = {sheet.title.lower(): sheet_lines(sheet) for sheet in others}
    return {"all": whole(found, first), **named}


def whole(found: RoomsFound, sheet: Sheet) -> Iterator[str]:
    """What was measured, and the first table."""
    yield f"Seed {found.seed}, settings {DEFAULT.digest}. {sheet.title}."
    yield ""
    yield from sheet_lines(sheet)


if __name__ == "__main__":
    main()
