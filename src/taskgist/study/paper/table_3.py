"""Table 3: time per demonstration. Theirs is of another computer and another system; ours was measured just now."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import mean, median

from taskgist.facts import EFFORT_LEVELS, Unknown
from taskgist.learning import Explanation
from taskgist.study.paper.demonstrations import Judged
from taskgist.study.paper.machine import machine
from taskgist.study.paper.result import Result, Section, Verdict, compared

PRINTED: Mapping[str, tuple[int, float]] = {
    "make accessible": (5, 0.56),
    "hide": (3, 0.81),
    "show": (4, 0.63),
    "give": (3, 0.59),
    "put away": (4, 0.61),
    "hide away": (4, 1.2),
}
"""Number of demonstrations, and average time for learning after each in seconds, by task."""
SLOWEST = "hide away"
ABOUT = (
    "Ours is the median over a task's demonstrations, from the recording in memory to the explanation, after a "
    "warm-up, on {machine}. Theirs is as printed, on a computer that is not named: not like for like."
)


def table_3_section(judged: Mapping[str, tuple[Judged, ...]]) -> Section:
    """Put our times beside the paper's, and compare which task takes longest.

    Args:
        judged: The judged demonstrations by task.
    """
    results: list[Result] = []
    for task, (count, seconds) in PRINTED.items():
        results.append(compared(f"{task}: demonstrations", "Table 3", count, len(judged[task])))
        results.append(_time(task, seconds, judged[task]))
    results.append(_most_tried(judged))
    return Section(
        "table_3", "Table 3: time per demonstration", tuple(results), ABOUT.format(machine=machine()), _details(judged)
    )


def _time(task: str, theirs: float, judged: Sequence[Judged]) -> Result:
    ours = median(each.seconds for each in judged)
    factor = theirs / ours
    how = f"{factor:.1f} times faster" if factor >= 1 else f"{1 / factor:.1f} times slower"
    told = f"{how}, on another computer"
    return Result(f"{task}: seconds", "Table 3", theirs, round(ours, 4), Verdict.DIFFERS_EXPLAINED, told)


def _most_tried(judged: Mapping[str, tuple[Judged, ...]]) -> Result:
    """The paper's reason for its order: where more effort is needed, more virtual actions are tried (8.1).

    Compared by levels rather than by our times, which are too short and too noisy for an order.
    """
    tried = {task: mean(_levels_at_the_end(each.explanation) for each in judged[task]) for task in PRINTED}
    most = max(tried, key=tried.__getitem__)
    return compared("takes longest, as most effort levels must be tried at the end", "Table 3, 8.1", SLOWEST, most)


def _levels_at_the_end(explanation: Explanation) -> int:
    efforts = (explanation.nodes[f"{ability}.effort.2"].value for ability in ("reach", "grasp", "see"))
    return sum(EFFORT_LEVELS[effort] for effort in efforts if not isinstance(effort, Unknown))


def _details(judged: Mapping[str, tuple[Judged, ...]]) -> dict[str, dict[str, float]]:
    return {
        task: {
            "shortest_s": min(each.seconds for each in judged[task]),
            "median_s": median(each.seconds for each in judged[task]),
            "longest_s": max(each.seconds for each in judged[task]),
            "perspective_s": median(each.perspective_seconds for each in judged[task]),
            "demonstration_s": median(each.length_s for each in judged[task]),
        }
        for task in PRINTED
    }
