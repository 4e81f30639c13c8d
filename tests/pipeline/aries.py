"""Aries as a program of its own: reads a domain and a problem, prints a plan's actions, and whether another is valid.

python -m tests.pipeline.aries domain.pddl problem.pddl plan.txt
"""

from __future__ import annotations

import sys
import warnings

from unified_planning.engines import CompilationKind
from unified_planning.io import PDDLReader
from unified_planning.shortcuts import AnytimePlanner, Compiler, PlanValidator, get_environment

SECONDS = 5.0
"""How long it looks for cheaper plans."""


def main(domain: str, text: str, ours: str) -> None:
    warnings.simplefilter("ignore")
    get_environment().credits_stream = None
    problem = read = PDDLReader().parse_problem(domain, text)
    compiled = []  # Aries knows no quantifiers
    for kind in (CompilationKind.QUANTIFIERS_REMOVING, CompilationKind.DISJUNCTIVE_CONDITIONS_REMOVING):
        with Compiler(problem_kind=problem.kind, compilation_kind=kind) as compiler:
            compiled.append(compiler.compile(problem, kind))
            problem = compiled[-1].problem
    with AnytimePlanner(name="aries") as planner:  # better and better ones
        *_, plan = (each.plan for each in planner.get_solutions(problem, timeout=SECONDS) if each.plan is not None)
    for each in reversed(compiled):
        plan = plan.replace_action_instances(each.map_back_action_instance)
    lines = [f"({each.action.name} {' '.join(map(str, each.actual_parameters))})" for each in plan.actions]
    known = PDDLReader().parse_plan(read, ours)
    with PlanValidator(problem_kind=read.kind, plan_kind=known.kind) as validator:
        lines.append(validator.validate(read, known).status.name)
    sys.stdout.write("\n".join(lines))


if __name__ == "__main__":
    main(*sys.argv[1:])
