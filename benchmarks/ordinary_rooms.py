"""Are facts about people what any person would say? In ordinary furnished rooms, beside what follows from their plan.

    python -m benchmarks.ordinary_rooms [--rooms 24] [--seed 1000] [--json] [--picture FILE]

The default seed is held out: smaller ones are for development. Of what an able adult gets at, it counts what is called
impossible; of what nobody gets at, what is called possible; by ability, by place and by what it takes.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from taskgist.cli.common import print_json, progress_bar
from taskgist.perspective.effort import ABILITIES
from taskgist_lab.cli.evaluate import print_sheet
from taskgist_lab.evaluation.ordinary_rooms import judged_room, judged_rooms, sheets
from taskgist_lab.ordinary.furnishing import furnished

SEED, ROOMS = 1000, 24


def main() -> None:
    """Measure; print tables or JSON; draw one room."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rooms", type=int, default=ROOMS, help="how many")
    parser.add_argument("--seed", type=int, default=SEED, help="seed of the rooms")
    parser.add_argument("--processes", type=int, default=None, help="default: one for each core")
    parser.add_argument("--json", action="store_true", help="plain data, with every pair that is answered wrongly")
    parser.add_argument("--picture", type=Path, help="PNG file of one room in plan view, coloured by the answers")
    parser.add_argument("--draw", type=int, default=0, metavar="NUMBER", help="which room is drawn")
    parser.add_argument("--ability", choices=ABILITIES, default="reach", help="whose answers are drawn")
    chosen = parser.parse_args()
    with progress_bar(quiet=chosen.json) as progress:
        found = judged_rooms(count=chosen.rooms, seed=chosen.seed, processes=chosen.processes, progress=progress)
    if chosen.picture:
        from taskgist_lab.view import ordinary_room_picture  # with matplotlib, which only pictures should wait for

        room = furnished(chosen.seed, chosen.draw)
        ordinary_room_picture(room, list(judged_room(room)), chosen.ability, chosen.picture)
    if chosen.json:
        print_json(found.to_json())
        return
    for sheet in sheets(found):
        print_sheet(sheet)


if __name__ == "__main__":
    main()
