"""The program that runs Orange's CN2: a job of JSON on each line of standard input, an answer on each of its output.

A job holds ``positives``, ``negatives`` and ``tests``, lists of rows of codes with -1 for unknown; the answer is the
list of whether each test is positive.
"""

from __future__ import annotations

import json
import sys
import warnings
from typing import Any

import numpy as np

from taskgist.common.arrays import Array
from taskgist_lab.evaluation.peers import door


def main() -> None:
    """Answer until the input ends."""
    warnings.simplefilter("ignore")  # Orange's own, about itself
    for line in sys.stdin:
        sys.stdout.write(json.dumps(answered(json.loads(line))) + "\n")
        sys.stdout.flush()


def answered(job: dict[str, Any]) -> list[bool]:
    """Learn, and judge the tests."""
    data, rules = door("Orange.data", "CN2"), door("Orange.classification.rules", "CN2")
    width = len(job["tests"][0])
    rows = [np.array(job[name], dtype=np.float64).reshape(-1, width) for name in ("positives", "negatives", "tests")]
    positives, negatives, tests = (np.where(each < 0, np.nan, each) for each in rows)
    domain = _domain(data, np.concatenate((positives, negatives, tests)))
    classes = np.repeat((1.0, 0.0), (len(positives), len(negatives)))
    table = data.Table.from_numpy(domain, np.concatenate((positives, negatives)), classes)
    learned = rules.CN2Learner()(table)
    undecided = np.full(len(tests), np.nan)
    return [bool(each) for each in np.asarray(learned(data.Table.from_numpy(domain, tests, undecided))) == 1]


def _domain(data: Any, rows: Array) -> Any:
    """A discrete variable for each node, with a value for each code."""
    variables = [
        data.DiscreteVariable(f"node {node}", values=[str(code) for code in range(_highest(column) + 1)])
        for node, column in enumerate(rows.T)
    ]
    return data.Domain(variables, data.DiscreteVariable("task", values=["no", "yes"]))


def _highest(column: Array) -> int:
    """The highest code of a node; one that is never known still needs a value."""
    known = column[~np.isnan(column)]
    return int(known.max()) if len(known) else 0


if __name__ == "__main__":
    main()
