"""How many generated demonstrations meet the paper's clauses, by means, into docs/research/generator.md.

    python -m tools.generator_page --pool POOL

The pool is that of ``taskgist evaluate``; nothing is played.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from taskgist_lab.evaluation.pool import Pool, read_pool
from taskgist_lab.evaluation.values import CLEAN, Sample
from taskgist_lab.paper.published import CLAUSES
from tools.markdown import filled, header, row

PAGE = Path("docs/research/generator.md")
POSTURES = ("posture.value.1", "posture.value.2")
"""Where a clause names postures, the class stands for them: generated people sit or stand as it comes."""


def main() -> None:
    """Rewrite the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pool", type=Path, required=True, help="file of judged demonstrations")
    pool = read_pool(parser.parse_args().pool)
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), {"clauses": table(pool)}), encoding="utf-8")


def table(pool: Pool) -> Iterator[str]:
    """Seed and table, as lines."""
    yield f"Measured with seed {pool.seed}:"
    yield ""
    yield from header("task", "means", "demonstrations", "all predicates hold", "those that do not, in how many")
    for task in CLAUSES:
        wanted = predicates(task)
        for means, samples in by_means(pool, task).items():
            lost = [_lost(pool, sample, wanted) for sample in samples]
            counts = Counter(each for of_one in lost for each in of_one)
            told = "; ".join(f"`{node} = {value}` {count}" for (node, value), count in counts.most_common())
            yield row(task, f"`{means}`", len(samples), sum(not each for each in lost), told)


def predicates(task: str) -> Mapping[str, str]:
    """What the paper's clause asks of a demonstration: values by node."""
    wanted = {each.node: each.value for each in CLAUSES[task].predicates if each.node not in POSTURES}
    return {**wanted, "posture.class": "Maintained"}


def by_means(pool: Pool, task: str) -> Mapping[str, list[Sample]]:
    """The clean demonstrations of a task, by their means in alphabetical order."""
    found = [each for each in pool.samples if each.task == task and each.condition == CLEAN]
    return {means: [each for each in found if each.means == means] for means in sorted({each.means for each in found})}


def _lost(pool: Pool, sample: Sample, wanted: Mapping[str, str]) -> Iterable[tuple[str, str | None]]:
    """Nodes that have not the value that is wanted, with the one that they have."""
    values = dict(zip(pool.nodes, sample.values, strict=True))
    return [(node, values[node]) for node, value in wanted.items() if values[node] != value]


if __name__ == "__main__":
    main()
