"""Facts about people beside what any person would say, in ordinary furnished rooms.

Of what an able adult gets at: how much is called "no possible known effort"? Of what nobody gets at, since it is shut
in or behind walls: how much is called possible? By ability, by furniture, and by what it takes. What is debatable is
left out and counted::

    found = judged_rooms(count=24, seed=1000)
    found.missed("reach").share

"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from taskgist.common.workers import Progress, in_order, silent
from taskgist.perspective.effort import ABILITIES, NO_KNOWN_LEVEL, Ability, Effort
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.world.stage import Stage
from taskgist_lab.evaluation.sheets import Sheet
from taskgist_lab.evaluation.values import Result, rounded
from taskgist_lab.ordinary.furnishing import furnished
from taskgist_lab.ordinary.rooms import FurnishedRoom
from taskgist_lab.ordinary.truth import Truth, Truths, needs

LEVELS = range(NO_KNOWN_LEVEL + 1)
UNKNOWN = "unknown"


@dataclass(frozen=True)
class Answer:
    """What perspective says of one ability, beside what any person says.

    Attributes:
        truth: What any person says.
        level: The effort level; None is unknown.
        reason: Why that level is told, where it is wrong; else empty.
        taken_ms: Time on the processor that it took, milliseconds.
    """

    truth: Truth
    level: int | None
    reason: str = field(default="", compare=False)
    taken_ms: float = field(default=0.0, compare=False)

    @property
    def is_wrong(self) -> bool:
        """Whether it is not what any person says; never where that is debatable, or the level unknown."""
        impossible = self.level == NO_KNOWN_LEVEL
        return self.level is not None and self.truth is (Truth.ABLE if impossible else Truth.NOBODY)


@dataclass(frozen=True)
class Pair:
    """One person and one thing.

    Attributes:
        room: Name of the room.
        person: Name of the person.
        thing: Name of the thing.
        spot: Where it lies, by what people call that.
        needs: What it takes, beside an arm.
        answers: One for each ability.
    """

    room: str
    person: str
    thing: str
    spot: str
    needs: tuple[str, ...]
    answers: Mapping[Ability, Answer]


@dataclass(frozen=True)
class Share:
    """How many of some pairs are answered wrongly."""

    wrong: int
    of: int

    @staticmethod
    def among(pairs: Iterable[Pair], ability: Ability) -> Share:
        """Of pairs."""
        wrong = [pair.answers[ability].is_wrong for pair in pairs]
        return Share(sum(wrong), len(wrong))

    @property
    def share(self) -> float:
        """Wrong ones of all; 0 where there are none."""
        return self.wrong / self.of if self.of else 0.0

    @property
    def text(self) -> str:
        """For people."""
        return f"{self.wrong} of {self.of} ({100 * self.share:.1f} %)" if self.of else "-"

    @property
    def plain(self) -> dict[str, float]:
        """Fit for JSON."""
        return {"wrong": self.wrong, "of": self.of, "share": rounded(self.share)}


@dataclass(frozen=True)
class RoomsFound(Result):
    """What was found in some rooms.

    Attributes:
        seed: Seed of the rooms.
        rooms: How many.
        pairs: Every pair of person and thing.
    """

    seed: int
    rooms: int
    pairs: tuple[Pair, ...]

    def of(self, truth: Truth, ability: Ability) -> list[Pair]:
        """Pairs of which any person says this."""
        return [pair for pair in self.pairs if pair.answers[ability].truth is truth]

    def missed(self, ability: Ability) -> Share:
        """Of what an able adult gets at, what is called impossible."""
        return Share.among(self.of(Truth.ABLE, ability), ability)

    def invented(self, ability: Ability) -> Share:
        """Of what nobody gets at, what is called possible."""
        return Share.among(self.of(Truth.NOBODY, ability), ability)

    def by(self, key: Callable[[Pair], Iterable[str]], truth: Truth = Truth.ABLE) -> dict[str, dict[Ability, Share]]:
        """Shares by ability for each key that pairs have, in alphabetical order; a pair counts for each of its keys."""
        names = sorted({name for pair in self.pairs for name in key(pair)})
        found = {
            name: {
                ability: Share.among((pair for pair in self.of(truth, ability) if name in key(pair)), ability)
                for ability in ABILITIES
            }
            for name in names
        }
        return {name: shares for name, shares in found.items() if any(share.of for share in shares.values())}

    def answers(self, truth: Truth, ability: Ability) -> list[Answer]:
        """Answers where any person says this."""
        return [pair.answers[ability] for pair in self.of(truth, ability)]

    def reasons(self, ability: Ability) -> Counter[str]:
        """Why what an able adult gets at is called impossible."""
        return Counter(answer.reason for answer in self.answers(Truth.ABLE, ability) if answer.is_wrong)

    def levels(self, ability: Ability) -> dict[str, int]:
        """How often each effort level was found for what an able adult gets at."""
        counts = Counter(answer.level for answer in self.answers(Truth.ABLE, ability))
        return {str(level): counts[level] for level in LEVELS} | {UNKNOWN: counts[None]}

    def times_ms(self, truth: Truth, ability: Ability) -> tuple[float, float, float]:
        """Median, 95 % quantile and most of the time that an answer takes, milliseconds; not a number for none."""
        times = [answer.taken_ms for answer in self.answers(truth, ability)] or [math.nan]
        median, most, worst = np.quantile(times, (0.5, 0.95, 1.0)).tolist()
        return median, most, worst

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "seed": self.seed,
            "rooms": self.rooms,
            "pairs": len(self.pairs),
            "abilities": {
                ability: {
                    "debatable": len(self.of(Truth.DEBATABLE, ability)),
                    "able_called_impossible": self.missed(ability).plain,
                    "nobody_called_possible": self.invented(ability).plain,
                    "levels_of_able": self.levels(ability),
                    "reasons": dict(self.reasons(ability).most_common()),
                    "taken_ms": {
                        truth.name.lower(): [rounded(each) for each in self.times_ms(truth, ability)]
                        for truth in Truth
                        if self.of(truth, ability)
                    },
                }
                for ability in ABILITIES
            },
            "able_called_impossible_by_place": _plain(self.by(spot_of)),
            "able_called_impossible_by_need": _plain(self.by(needs_of)),
            "nobody_called_possible_by_place": _plain(self.by(spot_of, Truth.NOBODY)),
            "wrong": [_plain_pair(pair) for pair in self.pairs if any(each.is_wrong for each in pair.answers.values())],
        }


def spot_of(pair: Pair) -> tuple[str, ...]:
    """The key of a pair by where its thing lies."""
    return (pair.spot,)


def needs_of(pair: Pair) -> tuple[str, ...]:
    """The keys of a pair by what it takes."""
    return pair.needs


def judged_rooms(*, count: int, seed: int, processes: int | None = None, progress: Progress = silent) -> RoomsFound:
    """Ask all efforts in some rooms.

    Args:
        count: How many rooms.
        seed: Their seed.
        processes: Processes; None: one for each core.
        progress: Told how far it is.

    Raises:
        InputError: The number of processes is less than one.
    """
    pairs: list[Pair] = []
    rooms = in_order(partial(_judged_number, seed), count, processes)
    for number, found in enumerate(rooms, start=1):
        pairs += found
        progress(f"room {number} of {count}", number / count)
    return RoomsFound(seed, count, tuple(pairs))


def _judged_number(seed: int, number: int) -> list[Pair]:
    return list(judged_room(furnished(seed, number)))


def judged_room(room: FurnishedRoom) -> Iterator[Pair]:
    """Ask all efforts in a room."""
    stage, truths = Stage(room.scene()), Truths(room)
    _warm_up(stage)
    efforts = SceneEfforts(stage)
    for person in room.people:
        for placed in room.placed:
            answers: dict[Ability, Answer] = {}
            for ability in ABILITIES:
                start_s = time.process_time()
                effort = efforts.effort(person.name, placed.thing.name, ability)
                taken_ms = 1000 * (time.process_time() - start_s)
                answer = Answer(truths.of(person, placed, ability), effort.level, taken_ms=taken_ms)
                answers[ability] = replace(answer, reason=_reason(effort)) if answer.is_wrong else answer
            names = (room.name, person.name, placed.thing.name, placed.spot.name)
            yield Pair(*names, needs(room, person, placed), answers)


def _reason(effort: Effort) -> str:
    told = effort.evidence.told
    return told.reason.value if told else effort.reason


def _warm_up(stage: Stage) -> None:
    """Have compiled what is compiled once."""
    efforts, scene = SceneEfforts(stage), stage.scene
    for ability in ABILITIES:
        efforts.effort(scene.agents[0], scene.objects[0], ability)


def _plain(shares: dict[str, dict[Ability, Share]]) -> dict[str, dict[Ability, dict[str, float]]]:
    return {name: {ability: share.plain for ability, share in each.items()} for name, each in shares.items()}


def _plain_pair(pair: Pair) -> dict[str, Any]:
    answers = {
        ability: {"truth": each.truth.name.lower(), "level": each.level, "wrong": each.is_wrong, "reason": each.reason}
        for ability, each in pair.answers.items()
    }
    return {**vars(pair), "needs": list(pair.needs), "answers": answers}


# --- As tables of text.


def sheets(found: RoomsFound) -> Iterator[Sheet]:
    """All that was found, as tables."""
    rows = tuple(
        (
            ability,
            found.missed(ability).text,
            found.invented(ability).text,
            str(len(found.of(Truth.DEBATABLE, ability))),
            *map(str, found.levels(ability).values()),
        )
        for ability in ABILITIES
    )
    header = ("ability", "able, called impossible", "nobody, called possible", "debatable", *map(str, LEVELS), UNKNOWN)
    note = "On the right: how often each effort level was found for what an able adult gets at."
    title = f"{found.rooms} ordinary rooms, {len(found.pairs)} pairs of person and thing"
    yield Sheet(title, header, rows, note)
    counted = "A pair counts in each of its lines."
    yield _shares("Able, called impossible: by what it takes", "what it takes", found.by(needs_of), counted)
    yield _shares("Able, called impossible: by place", "where it lies", found.by(spot_of))
    yield _shares("Nobody, called possible: by place", "where it lies", found.by(spot_of, Truth.NOBODY))
    yield _times(found)
    reasons = tuple((ability, why, str(n)) for ability in ABILITIES for why, n in found.reasons(ability).most_common())
    if reasons:
        yield Sheet("Able, called impossible: the reason told", ("ability", "reason", "pairs"), reasons)


def _times(found: RoomsFound) -> Sheet:
    rows = tuple(
        (truth.value, *(" / ".join(f"{each:.1f}" for each in found.times_ms(truth, ability)) for ability in ABILITIES))
        for truth in Truth
    )
    note = (
        "Time on the processor; whatever is computed once for a person counts for the first thing that is asked about."
    )
    return Sheet("Milliseconds of an answer: median / 95 % / most", ("truth", *ABILITIES), rows, note)


def _shares(title: str, first: str, shares: dict[str, dict[Ability, Share]], note: str = "") -> Sheet:
    rows = tuple((name, *(each[ability].text for ability in ABILITIES)) for name, each in shares.items())
    return Sheet(title, (first, *ABILITIES), rows, note)
