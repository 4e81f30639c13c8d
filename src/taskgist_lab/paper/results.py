"""All results of the paper beside ours."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from taskgist.common.frozen import Json
from taskgist_lab.paper.clauses_and_ablations import ablations_section, clauses_section, figures_section
from taskgist_lab.paper.displacements import NAME, Displacements, digest_of, displacements_section, outdated
from taskgist_lab.paper.judging import Judged
from taskgist_lab.paper.published import Goal, Result, Section, Verdict, machine, tally
from taskgist_lab.paper.tables import table_2_section, table_3_section, table_4_section

MEASURE = "not measured: taskgist paper --displacements 200"


@dataclass(frozen=True)
class Report:
    """Every result, section by section."""

    sections: tuple[Section, ...]
    machine: str
    """What the times were measured on."""

    @property
    def results(self) -> tuple[Result, ...]:
        """All published results."""
        return tuple(result for section in self.sections if section.name != NAME for result in section.results)

    @property
    def goals(self) -> tuple[Result, ...]:
        """What is held to a goal of ours, as the paper prints nothing of it."""
        return self.section(NAME).results

    @property
    def failed(self) -> bool:
        """Whether any result differs without an explanation, or a goal is clearly missed."""
        return any(result.verdict in (Verdict.FAILS, Goal.NOT_MET) for result in (*self.results, *self.goals))

    def section(self, name: str) -> Section:
        """The section of this name."""
        return next(section for section in self.sections if section.name == name)

    def to_json(self) -> dict[str, Json]:
        """Plain data."""
        return {
            "machine": self.machine,
            "verdicts": dict(tally(self.results)),
            "goals": dict(tally(self.goals, Goal)),
            "sections": [section.to_json() for section in self.sections],
        }


def report(judged: Mapping[str, tuple[Judged, ...]], displacements: Displacements | None = None) -> Report:
    """Compare everything that was measured with what the paper says.

    Args:
        judged: The demonstrations of the study, judged.
        displacements: The same, displaced; those made with other settings, tree or recordings do not count.
    """
    problem = "" if displacements is None else outdated(displacements, digest_of(judged))
    why_not = f"{MEASURE} ({problem} since the last time)" if problem else MEASURE
    sections = (
        clauses_section(judged),
        displacements_section(None if problem else displacements, why_not=why_not),
        figures_section(judged),
        table_2_section(judged),
        table_3_section(judged),
        table_4_section(judged),
        ablations_section(judged),
    )
    return Report(sections, machine())
