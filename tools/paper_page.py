"""Put the paper's study into docs/research/study.md, with pictures: ``python -m tools.paper_page [--no-pictures]``."""

from __future__ import annotations

import argparse
import io
from collections.abc import Iterable
from pathlib import Path

from PIL import Image

from taskgist.pipeline import shipped_study
from taskgist.recording import read
from taskgist_lab.paper import Report, judge_study, report, shipped_displacements, understanding_of
from taskgist_lab.view import demonstration_picture, task_picture, tree_picture
from tools import paper_lines as lines
from tools.markdown import filled
from tools.paper_lines import JudgedStudy

PAGE, PICTURES = Path("docs/research/study.md"), Path("docs/pictures")
CLOSE_UP = ("hide", 0)
"""The demonstration that is shown from everybody's perspective."""
COLOURS = 256
"""Of each picture: enough for plain surfaces, and a third of the bytes."""


def main() -> None:
    """Judge the study, displacement the pictures, and rewrite the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--no-pictures", action="store_true", help="only rewrite the page, which is much faster")
    options = parser.parse_args()
    judged = judge_study()
    if not options.no_pictures:
        draw_pictures(judged)
    found = report(judged, shipped_displacements())
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), parts(found, judged)), encoding="utf-8")
    print(f"{PAGE}: {' '.join(lines.verdicts(found))}")


def parts(found: Report, judged: JudgedStudy) -> dict[str, Iterable[str]]:
    """All that is measured, as lines of the page."""
    sections = {section.name: section for section in found.sections}
    return {
        "verdicts": lines.verdicts(found),
        "demonstrations": lines.demonstrations(judged),
        "meanings": lines.meanings(judged),
        "clauses": lines.clauses(sections["clauses"], sections["draws"]),
        "displacement": lines.displacement(sections["draws"]),
        "figures": lines.plain(sections["figures"].results),
        "table 2": lines.table_2(sections["table_2"]),
        "question": [f"> {sections['table_2'].details['question']}"],
        "table 3": lines.table_3(sections["table_3"]),
        "table 4": lines.table_4(sections["table_4"]),
        "smaller trees": lines.plain(sections["ablations"].results),
        "lost": lines.lost(sections["ablations"]),
        "differences": lines.differences(found),
    }


def draw_pictures(judged: JudgedStudy) -> None:
    """Scenes of all tasks, one demonstration from everybody's perspective, and the tree of *show* as it is pruned."""
    PICTURES.mkdir(exist_ok=True)
    paths = shipped_study()
    for task, of_task in paths.items():
        slim(task_picture([read(path) for path in of_task], PICTURES / f"study_{task.replace(' ', '_')}.png"))
    task, number = CLOSE_UP
    slim(demonstration_picture(read(paths[task][number]), PICTURES / "study_perspectives.png"))
    stages = {str(count): understanding_of("show", judged["show"][:count]) for count in (2, 3, 4)}
    title = "show: what is understood after 2, 3 and 4 demonstrations"
    slim(tree_picture(stages, PICTURES / "study_tree_show.png", title=title))


def slim(path: Path) -> None:
    """Write a picture anew with few colours."""
    with Image.open(path) as image:
        few = image.convert("RGB").quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=3, dither=Image.Dither.NONE)
    buffer = io.BytesIO()
    few.save(buffer, format="PNG", optimize=True)
    path.write_bytes(buffer.getvalue())


if __name__ == "__main__":
    main()
