"""Put the figures of an evaluation into docs/research/evaluation.md: ``python -m tools.evaluation_page --pool FILE``.

What the pool lacks is made first, on all cores. The page's text stays; tables stand
between marks, and pictures in docs/pictures.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from taskgist_lab.evaluation.experiments import CLAUSE, EFFECTS, Needs, Transfer, demonstrations_needed, transfer
from taskgist_lab.evaluation.learner import Coded
from taskgist_lab.evaluation.noise import CONDITIONS
from taskgist_lab.evaluation.pool import SOURCES, Pool, Wanted, kept_pool
from taskgist_lab.evaluation.robustness import Comparison, Robustness, compared, makers, robustness
from taskgist_lab.evaluation.sheets import (
    Sheet,
    curve_sheet,
    misses_sheet,
    needed_sheet,
    peers_sheet,
    robustness_sheet,
    rules_sheet,
    scores_sheet,
    single_sheet,
    table_sheet,
)
from taskgist_lab.evaluation.values import CLEAN
from taskgist_lab.view import picture_of
from tools.markdown import filled

PAGE, PICTURES = Path("docs/research/evaluation.md"), Path("docs/pictures")
SEED, RUNS, COUNT, STUDY_COUNT = 1000, 200, 150, 30


def main() -> None:
    """Make what is missing, measure, rewrite the page."""
    wishes = arguments()
    wanted = Wanted("generator", wishes.seed, wishes.demonstrations, tuple(CONDITIONS))
    pool = kept_pool(wishes.pool, wanted, processes=wishes.processes, progress=told)
    coded = Coded.of(pool)
    needs = demonstrations_needed(coded, runs=wishes.runs, seed=wishes.seed)
    found = transfer(coded, runs=wishes.runs, seed=wishes.seed)
    rules = robustness(coded, runs=wishes.runs, seed=wishes.seed, progress=told)
    peers = compared(coded, runs=wishes.runs, seed=wishes.seed, peers=makers(wishes.seed), progress=told)
    for name, result in {"needed": needs, "transfer": found, "robustness": rules, "peers": peers}.items():
        picture_of(result, PICTURES / f"evaluation_{name}.png")
    parts = {"pool": about(pool, wishes.runs), **dict(tables(needs, found, rules, peers)), "study": study(wishes)}
    lines = {name: text.splitlines() for name, text in parts.items()}
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), lines), encoding="utf-8")


def arguments() -> argparse.Namespace:
    """What was asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pool", type=Path, required=True, help="file of judged demonstrations, made if missing")
    parser.add_argument("--study-pool", type=Path, default=None, help="the same of the paper's study, displaced")
    parser.add_argument("--demonstrations", type=int, default=COUNT, help="of each task")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--runs", type=int, default=RUNS)
    parser.add_argument("--processes", type=int, default=None)
    return parser.parse_args()


def told(what: str, share: float) -> None:
    """One line of progress that is written over."""
    print(f"\r{share:4.0%} {what:60}", end="" if share < 1.0 else "\n", flush=True)


def study(wishes: argparse.Namespace) -> str:
    """Demonstrations needed of the paper's own study, displaced: where they are made, and the table."""
    wanted = Wanted("study", wishes.seed, STUDY_COUNT, (CLEAN,))
    pool = kept_pool(wishes.study_pool, wanted, processes=wishes.processes, progress=told)
    needs = demonstrations_needed(Coded.of(pool), runs=wishes.runs, seed=wishes.seed)
    return f"{about(pool, wishes.runs, 'needed')}\n{markdown(needed_sheet(needs))}"


def about(pool: Pool, runs: int, experiments: str = "needed transfer robustness peers") -> str:
    """What was measured on, and the command that measures it again."""
    clean = [each.task for each in pool.samples if each.condition == CLEAN]
    counts = ", ".join(f"{clean.count(task)} of *{task}*" for task in pool.tasks)
    numbers = [each.number for each in pool.samples] + [each.number for each in pool.failures]
    count = max(numbers) + 1
    missed = len([each for each in pool.failures if not each.condition])
    return (
        f"Measured on {SOURCES[pool.source].text}, seed {pool.seed}: {counts} ({missed} more could not be played); "
        f"{runs} runs; settings {pool.context.settings_digest}, tree {pool.context.tree_version}:\n\n"
        f"    taskgist evaluate {experiments} --source {pool.source} -n {count} --seed {pool.seed} --runs {runs}\n"
    )


def tables(needs: Needs, found: Transfer, rules: Robustness, peers: Comparison) -> Iterator[tuple[str, str]]:
    """Name and text of each table of the page."""
    best = next(iter(rules.scores))
    yield "needed", markdown(needed_sheet(needs))
    yield "single", markdown(single_sheet(needs))
    yield "curve", markdown(curve_sheet(needs))
    yield "scores", markdown(scores_sheet(found))
    for after in found.sizes:
        yield f"after {after}", markdown(table_sheet(found.table(after, CLAUSE)))
    yield "effects", markdown(table_sheet(found.table(found.sizes[-1], EFFECTS)))
    yield "misses", markdown(misses_sheet(found))
    yield "robustness", markdown(robustness_sheet(rules, "paper"))
    yield "robustness of the best", markdown(robustness_sheet(rules, best))
    yield "rules", markdown(rules_sheet(rules))
    yield "peers", markdown(peers_sheet(peers))
    tree = [each for each in peers.learners if each.name == "decision tree" and each.negatives]
    yield "tree", markdown(table_sheet(tree[0].tables[-1])) if tree else "Not measured here.\n"


def markdown(sheet: Sheet) -> str:
    """A table in Markdown, its note below."""
    lines = [f"**{sheet.title}**", "", row(sheet.header), row(["---"] + ["---:"] * (len(sheet.header) - 1))]
    lines += [row(cells) for cells in sheet.rows]
    if sheet.note:
        lines += ["", f"*{sheet.note}*"]
    return "\n".join(lines) + "\n"


def row(cells: tuple[str, ...] | list[str]) -> str:
    """One line of a table."""
    return f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"


if __name__ == "__main__":
    main()
