"""What a task under way will be: how situations like this one went on, and which task that would make it.

Known tasks are known by their effects, and a task that is under way has none yet. So the question is asked in two
steps, of which only the second is about tasks:

1. *How will this end?* Of many handlings that were watched to their end the shipped ``Case`` keeps the cues of a moment
   on the way (``observe.under_way``), the facts as they would have been if it had ended then, and as they were in the
   end. Cases whose moment is like the present one tell how it may go on: each with a weight that falls with what
   differs. What a case changed until its end is changed here; what was then as it is in the end stays as it is here.
2. *Which task would that be?* The facts of each such end are recognised as those of any episode, by what is known
   (``tasks``). The probability of a task is the mean over the ends, by weight.

So users' own tasks are foreseen, too: no case knows which task it was. An example: P1 carries a cup towards P2, whose
hand comes to meet it. Nothing is given yet; but in nine of ten cases like it the cup was in the other's hand in the
end, and in those ends a *give* is recognised.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from taskgist.common.documents import read_packed_json
from taskgist.common.frozen import FrozenMap
from taskgist.errors import KnowledgeError
from taskgist.facts.tree import Nodes
from taskgist.facts.values import UNKNOWN, Observation, Unknown, Value
from taskgist.learning.explanation import Context
from taskgist.learning.literals import SetLiteral
from taskgist.observe.under_way import Cues
from taskgist.recognition.tasks import Recogniser
from taskgist.settings import DEFAULT

WORDS: Mapping[str, float] = FrozenMap(
    {
        "stage": 0.03,
        "handled": 0.1,
        "blocked": 0.5,
        "blocked_ahead": 0.4,
        "performer_regards": 0.7,
        "target_regards": 0.7,
    }
)
"""By what factor the weight of a case falls where a cue that is a word, or a truth, differs."""
SCALES: Mapping[str, float] = FrozenMap(
    {
        "nearing_m": 0.15,
        "nearing_m_s": 0.25,
        "own_nearing_m": 0.2,
        "own_nearing_m_s": 0.3,
        "rise_m": 0.12,
        "rise_m_s": 0.2,
        "target_hand_m": 0.12,
        "distance_m": 0.5,
        "other_gap_m": 0.2,
        "other_nearing_m": 0.15,
        "hidden_ahead": 0.25,
    }
)
"""Of each cue that is a number: what difference counts as one standard deviation."""
MOST_APART = 2.0
"""No number alone makes a case less like than this, in natural logarithms."""
FACTS: Mapping[str, float] = FrozenMap(
    {
        "see.effort.1": 0.4,
        "reach.effort.1": 0.5,
        "grasp.effort.1": 0.5,
        "placement.status.1": 0.3,
        "hands.status.1": 0.8,
        "see.class": 0.5,
        "reach.class": 0.5,
        "grasp.class": 0.6,
        "visibility.class": 0.6,
    }
)
"""By what factor it falls where one of these facts differs: those of the start, and what has changed by now."""
SHARPNESS = 1.2
"""Exponent of weights."""
MOST_CASES = 40
"""As many cases count, those that are most like it."""
FORMAT = "taskgist cases 1"
SHIPPED = Path(__file__).parent.parent / "data" / "under_way.json.gz"
HINT = "install taskgist anew, or make it again: python -m tools.under_way_cases"


@dataclass(frozen=True)
class Case:
    """One moment of a handling that was watched to its end.

    Attributes:
        cues: What was under way, by the names of the fields of ``Cues``.
        now: Facts as they would have been if it had ended then; what is missing was unknown.
        end: Facts in the end.
    """

    cues: Mapping[str, Any]
    now: Mapping[str, str]
    end: Mapping[str, str]

    def ends(self, nodes: Nodes) -> dict[str, Observation[Value]]:
        """Facts in the end if the present ones go on as in this case."""
        found: dict[str, Observation[Value]] = {}
        for name, observed in nodes.items():
            stays = name.endswith(".1") or self.now.get(name) == self.end.get(name)
            found[name] = observed if stays else Observation(self.end.get(name, UNKNOWN))
        return found


@dataclass(frozen=True)
class Foreseen:
    """What a task under way will be.

    Attributes:
        tasks: Each known task and its probability, the most probable first. Several may be right at once.
        none: Probability that it will be none of them.
        missing: Of the most probable task: the literals of its best clause that do not hold yet.
    """

    tasks: tuple[tuple[str, float], ...]
    none: float
    missing: tuple[SetLiteral, ...]

    @property
    def best(self) -> str | None:
        """The most probable task; None where none of them is more probable."""
        task, probability = self.tasks[0]
        return task if probability > self.none else None


def foresee(recogniser: Recogniser, cues: Cues, nodes: Nodes, cases: Sequence[Case] | None = None) -> Foreseen:
    """What it will be, as far as is known now.

    Args:
        recogniser: The known tasks.
        cues: What is under way.
        nodes: Facts as they would be if it ended now.
        cases: How other handlings went on; the shipped ones by default.
    """
    cases = shipped_cases() if cases is None else cases
    own = cues.as_dict()
    facts = {name: value for name in FACTS if (value := _value(nodes, name)) is not None}
    weighed = sorted(
        ((SHARPNESS * likeness(own, facts, case), number) for number, case in enumerate(cases)), reverse=True
    )[:MOST_CASES]
    # Without any case, it is recognised as if it ended now.
    ends: list[tuple[float, Nodes]] = [
        (math.exp(each - weighed[0][0]), cases[number].ends(nodes)) for each, number in weighed
    ] or [(1.0, nodes)]
    total = math.fsum(weight for weight, _ in ends)
    found = dict.fromkeys(recogniser.tasks, 0.0)
    none = 0.0
    for weight, end in _together(ends):
        recognised = recogniser.recognise(end)
        for each in recognised.tasks:
            found[each.task] += weight / total * each.probability
        none += weight / total * recognised.none
    ordered = tuple(sorted(found.items(), key=lambda each: (-each[1], each[0])))
    now = {each.task: each for each in recogniser.recognise(nodes).tasks}
    missing = tuple(each.literal for each in now[ordered[0][0]].literals if each.holds is False)
    return Foreseen(ordered, none, missing)


def _together(ends: Iterable[tuple[float, Nodes]]) -> Iterable[tuple[float, Nodes]]:
    """The same with equal ends taken together, so that each is recognised once."""
    weights: dict[tuple[Value, ...], float] = {}
    nodes_of: dict[tuple[Value, ...], Nodes] = {}
    for weight, nodes in ends:
        key = tuple(observed.value for observed in nodes.values())
        weights[key] = weights.get(key, 0.0) + weight
        nodes_of.setdefault(key, nodes)
    return [(weight, nodes_of[key]) for key, weight in weights.items()]


def likeness(cues: Mapping[str, Any], facts: Mapping[str, str], case: Case) -> float:
    """How much a case's moment is like the present one: a natural logarithm, 0 where nothing differs.

    Args:
        cues: What is under way.
        facts: The known ones of ``FACTS``.
        case: The case.
    """
    apart = math.fsum(-math.log(factor) for name, factor in WORDS.items() if cues[name] != case.cues[name])
    for name, scale in SCALES.items():
        apart += min(((cues[name] - case.cues[name]) / scale) ** 2 / 2, MOST_APART)
    apart += math.fsum(-math.log(factor) for name, factor in FACTS.items() if facts.get(name) != case.now.get(name))
    return -apart


def _value(nodes: Nodes, name: str) -> str | None:
    value = nodes[name].value if name in nodes else UNKNOWN
    return None if isinstance(value, Unknown) else value


# --- Cases as data: equal values stand in a table.


def cases_document(cases: Sequence[Case], context: Context) -> dict[str, Any]:
    """Plain data; ``cases_from`` reads it back."""
    nodes = sorted({name for case in cases for name in (*case.now, *case.end)})
    values = sorted({value for case in cases for value in (*case.now.values(), *case.end.values())})
    index = {value: number for number, value in enumerate(values)}
    fields = (*WORDS, *SCALES)
    return {
        "format": FORMAT,
        "settings_digest": context.settings_digest,
        "tree_version": context.tree_version,
        "cues": list(fields),
        "nodes": nodes,
        "values": values,
        "cases": [
            [
                [_rounded(case.cues[name]) for name in fields],
                [index[case.now[name]] if name in case.now else -1 for name in nodes],
                [index[case.end[name]] if name in case.end else -1 for name in nodes],
            ]
            for case in cases
        ],
    }


def _rounded(value: Any) -> Any:
    return round(value, 3) if isinstance(value, float) else value


def cases_from(document: Mapping[str, Any], *, where: Path | None = None) -> tuple[Case, ...]:
    """The cases of plain data.

    Raises:
        KnowledgeError: It is something else.
    """
    try:
        if document["format"] != FORMAT:
            raise ValueError(f"format {document['format']!r}")
        fields, nodes, values = document["cues"], document["nodes"], document["values"]
        if missing := {*WORDS, *SCALES} - set(fields):
            raise ValueError(f"no cues {sorted(missing)}")
        return tuple(
            Case(FrozenMap(dict(zip(fields, cues, strict=True))), *(_row(nodes, row, values) for row in (now, end)))
            for cues, now, end in document["cases"]
        )
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise KnowledgeError(f"no cases: {error!r}", where=where, hint=HINT) from error


def _row(nodes: Sequence[str], row: Sequence[int], values: Sequence[str]) -> FrozenMap[str, str]:
    return FrozenMap({name: values[code] for name, code in zip(nodes, row, strict=True) if code >= 0})


@cache
def shipped_cases() -> tuple[Case, ...]:
    """The cases that are shipped.

    Raises:
        KnowledgeError: The file is missing or damaged.
    """
    document = read_packed_json(
        SHIPPED, most_bytes=DEFAULT.limits.document_bytes, problem="no cases", hint=HINT, error=KnowledgeError
    )
    return cases_from(document, where=SHIPPED)
