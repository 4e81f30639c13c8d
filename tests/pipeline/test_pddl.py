"""The same problem for other planners: a reader of unified-planning takes it, and Aries finds what we found."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from taskgist.pipeline.performing import Outcome, perform
from taskgist.planning.pddl import Names
from taskgist.planning.requests import Request
from tests.pipeline.test_means import cleared, covered, parted, relayed, slid
from tests.pipeline.test_performing import clause

ROOT = Path(__file__).parent.parent.parent


def _carried(plan: list[str]) -> list[list[str]]:
    """Who carries what; which of two covers that cost the same is up to the planner, to whom motions are unknown."""
    covers = {"dome": "a cover", "bin": "a cover"}
    return [[covers.get(word, word) for word in line.split()[1:3]] for line in plan]


@pytest.mark.parametrize("performed", [relayed, covered, cleared, slid])
def test_another_planner_solves_the_same_problem(performed: Callable[[], Outcome], tmp_path: Path) -> None:
    outcome = performed()
    pddl = outcome.pddl()
    paths = [tmp_path / name for name in ("domain.pddl", "problem.pddl", "plan.txt")]
    for path, text in zip(paths, (pddl.domain, pddl.problem, pddl.plans[0]), strict=True):
        path.write_text(text, encoding="utf-8")
    command = [sys.executable, "-m", "tests.pipeline.aries", *map(str, paths)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    *theirs, ours_is = done.stdout.splitlines()
    ours = pddl.plans[0].splitlines()
    assert ours_is == "VALID", "our plan, by their validator"
    assert len(theirs) == len(ours) == len(outcome.performances[0].plan.actions)
    assert _carried(theirs) == _carried(ours), "who carries what"


def test_its_places_are_those_of_the_plan() -> None:
    outcome = relayed()
    pddl, (found,) = outcome.pddl(), outcome.performances
    for line, action in zip(pddl.plans[0].splitlines(), found.plan.actions, strict=True):
        place = pddl.places[line.strip("()").split()[-1]]
        assert (place["object"], place["carrier"], place["means"]) == ("tape", action.candidate.carrier, "put_on")
        assert place["position_m"] == pytest.approx(action.candidate.pose[:3], abs=1e-5)


def test_what_lies_flat_is_carried_only_from_where_it_was_slid() -> None:
    pddl = slid().pddl()
    slide, carry = (line.strip("()").split() for line in pddl.plans[0].splitlines())
    kind = slide[0].removeprefix("slide-")
    assert (carry[0], slide[1:4], carry[3]) == (f"carry-{kind}", ["r", "tape", "tape-here"], slide[4])
    assert "r tape tape-here)" not in pddl.problem, "nobody gets at it there"
    facts = [line.split()[-1].strip(")") for line in pddl.problem.splitlines() if f"(slides-{kind} r tape" in line]
    assert slide[4] in facts
    assert {pddl.places[name]["means"] for name in facts} == {"slide_out"}
    assert all(f"(gets-{kind} r tape {name})" in pddl.problem for name in facts)


def test_what_nobody_gets_at_has_no_plan() -> None:
    request = Request(clause("hide"), "R1", "P2", "tape", allow=("shelf",), means=("relay",), helpers=())
    outcome = perform(parted(), request)
    assert not outcome.performances
    pddl = outcome.pddl()
    assert not pddl.plans
    goals = pddl.problem.partition("(:goal")[2]
    there = [name for name in pddl.places if f"(at tape {name})" in goals]
    assert there, "places on the shelf would do"
    assert not any(f"r1 tape {name})" in pddl.problem for name in there), "which the robot does not get at"


def test_names_are_such_as_pddl_has() -> None:
    names = Names()
    told = [names.of("thing", name) for name in ("White Box", "white_box", "2 cups", "place", "é")]
    assert told == ["white-box", "white-box-2", "thing-2-cups", "place-2", "thing-2"]
    assert names.of("thing", "White Box") == "white-box"
