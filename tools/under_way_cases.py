"""The cases that are shipped: moments of handlings that were watched to their end.

    python -m tools.under_way_cases --kept cases.jsonl

Tasks under way are foreseen by them (``recognition.completion``). Demonstrations of tasks, and neutral manipulations,
are made by the generator; each gives a case at 25, 50, 75 and 90 % of the labelled time. A case does not know which
task it was. What is made is kept in a file, a line for each demonstration, so that it can be run again; made anew, it
takes half an hour.
"""

from __future__ import annotations

import argparse
import gzip
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from taskgist.common.files import writing
from taskgist.errors import SceneError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import Nodes
from taskgist.facts.values import Unknown
from taskgist.learning.explanation import Context
from taskgist.learning.literals import vocabularies
from taskgist.pipeline.explain import explain_recording
from taskgist.pipeline.under_way import moment_of
from taskgist.recognition.completion import FACTS, SCALES, SHIPPED, WORDS, Case, cases_document
from taskgist.recording.recording import Recording
from taskgist_lab.evaluation.pool import JUDGING_ONLY, NEUTRAL, is_held_out
from taskgist_lab.evaluation.under_way import SHARES
from taskgist_lab.generator.simulation import TASKS, name_of, simulate

SEED = 101
COUNTS = {True: 8, False: 29}
"""Demonstrations of each neutral manipulation, and of each task; those that are held out for judging are left out."""


def main() -> None:
    """Write the file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kept", type=Path, help="file of cases: reused, extended, made if missing")
    cases = [case for row in rows(parser.parse_args().kept) for case in cases_of(row)]
    text = json.dumps(cases_document(cases, Context.of()), ensure_ascii=False, separators=(",", ":"))
    with writing(SHIPPED, replace=True) as stream:
        stream.write(gzip.compress(text.encode(), mtime=0))
    print(f"{SHIPPED}: {len(cases)} cases")


def rows(kept: Path | None) -> Iterator[dict[str, Any]]:
    """What was seen in each demonstration: by name, its moments and its end."""
    lines = kept.read_text().splitlines() if kept and kept.exists() else []
    known = {row["name"]: row for row in map(json.loads, lines)}
    for task in (each for each in TASKS if each not in JUDGING_ONLY):
        for number in range(COUNTS[task in NEUTRAL]):
            if is_held_out(number):
                continue
            name = name_of(task, SEED, number)
            if name not in known:
                try:
                    known[name] = row_of(simulate(task, seed=SEED, number=number))
                except SceneError:
                    continue
                if kept:
                    with kept.open("a") as stream:
                        stream.write(json.dumps(known[name]) + "\n")
            yield known[name]


def row_of(recording: Recording) -> dict[str, Any]:
    """What was seen in a demonstration."""
    label = recording.label
    assert label is not None
    moments = []
    for share in SHARES:
        span = (label.start_s, label.start_s + share * (label.end_s - label.start_s))
        pair = (label.target_agent, label.target_object)
        moment = moment_of(recording, span, label.performing_agent, *pair, STANDARD_TREE)
        assert moment.cues is not None
        moments.append({"cues": moment.cues.as_dict(), "now": _values(moment.nodes)})
    return {"name": recording.name, "at": moments, "end": _values(explain_recording(recording).nodes)}


def cases_of(row: dict[str, Any]) -> Iterator[Case]:
    """The cases of a demonstration."""
    for moment in row["at"]:
        cues = {name: moment["cues"][name] for name in (*WORDS, *SCALES)}
        yield Case(cues, moment["now"], row["end"])


def _values(nodes: Nodes) -> dict[str, str]:
    """The known values of nodes that clauses or the likeness of cases are about."""
    told = {*(each.node.name for each in vocabularies(STANDARD_TREE)), *FACTS}
    values = {name: nodes[name].value for name in sorted(told)}
    return {name: value for name, value in values.items() if not isinstance(value, Unknown)}


if __name__ == "__main__":
    main()
