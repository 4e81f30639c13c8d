"""The neutral manipulations that are shipped: explained effects of what people do for nobody.

    python -m tools.neutral_background --pool neutral.json.gz
    python -m tools.neutral_background --count 3 -o few.json.gz

The pool keeps the demonstrations, so that it can be run again; without it they are made anew, which takes a quarter of
an hour. What happens to fulfil a task of the paper, such as what falls into a bin and is hidden there, is left out. So
are the kinds of manipulations that are for judging only (``JUDGING_ONLY`` in ``evaluation.pool``).
"""

from __future__ import annotations

import argparse
import gzip
import json
from pathlib import Path

from taskgist.common.files import writing
from taskgist.learning.background import SHIPPED, Background
from taskgist_lab.evaluation.pool import BACKGROUND, Pool, Wanted, kept_pool
from taskgist_lab.evaluation.values import CLEAN

SEED, COUNT = 500, 60
"""Seed, and demonstrations of each manipulation."""


def main() -> None:
    """Write the file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pool", type=Path, help="file of judged demonstrations: reused, extended, made if missing")
    parser.add_argument("--count", type=int, default=COUNT, help=f"demonstrations of each manipulation ({COUNT})")
    parser.add_argument("-o", "--output", type=Path, default=SHIPPED, help="file that is written (the shipped one)")
    asked = parser.parse_args()
    pool = kept_pool(asked.pool, Wanted(BACKGROUND, SEED, asked.count, (CLEAN,)))
    background = neutral(pool)
    write(background, asked.output)
    count = sum(map(len, background.manipulations.values()))
    print(f"{asked.output}: {count} of {len(pool.samples)} manipulations")


def neutral(pool: Pool) -> Background:
    """The background of a pool: all samples that fulfil no other task than the one that they were played as."""
    rows: dict[str, list[dict[str, str]]] = {}
    for each in pool.samples:
        if each.fulfilled == (each.task,):
            known = {node: value for node, value in zip(pool.nodes, each.values, strict=True) if value}
            rows.setdefault(each.task, []).append(known)
    return Background.of(pool.context, rows)


def write(background: Background, path: Path) -> None:
    """Write a background; the same one gives the same bytes."""
    text = json.dumps(background.to_json(), ensure_ascii=False, separators=(",", ":"))
    with writing(path, replace=True) as stream:
        stream.write(gzip.compress(text.encode(), mtime=0))


if __name__ == "__main__":
    main()
