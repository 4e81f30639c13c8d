"""Run all benchmarks; print a table and write benchmarks.json."""

from __future__ import annotations

import json
from pathlib import Path

from rich.console import Console
from rich.table import Table

from benchmarks.cases import CASES

OUT = Path("benchmarks.json")


def main() -> None:
    """Run all benchmarks."""
    results = [case() for case in CASES]
    table = Table(box=None)
    for column in ("what", "taskgist", "beside", "by", "ratio"):
        table.add_column(column, overflow="fold")
    for r in results:
        beside = f"{1000 * r.peer_s:.3g} ms" if r.peer_s is not None else "-"
        share = f"{r.ratio:.3g}" if r.ratio is not None else "-"
        table.add_row(r.what, f"{1000 * r.ours_s:.3g} ms", beside, r.peer, share)
    Console().print(table)
    OUT.write_text(json.dumps([vars(r) for r in results], indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
