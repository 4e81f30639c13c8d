"""The paper's study: every published result beside ours, with a verdict (7.3-8.4)."""

from taskgist.study.paper.demonstrations import Judged, judge_study, understanding_of
from taskgist.study.paper.draws import Draws, digest_of, measure
from taskgist.study.paper.draws_file import outdated, read_draws, shipped_draws, write_draws
from taskgist.study.paper.report import Report, report
from taskgist.study.paper.result import Goal, Result, Section, Verdict, tally
from taskgist.study.paper.survival import Survival, survival, wilson

__all__ = [
    "Draws",
    "Goal",
    "Judged",
    "Report",
    "Result",
    "Section",
    "Survival",
    "Verdict",
    "digest_of",
    "judge_study",
    "measure",
    "outdated",
    "read_draws",
    "report",
    "shipped_draws",
    "survival",
    "tally",
    "understanding_of",
    "wilson",
    "write_draws",
]
