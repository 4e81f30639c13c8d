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
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from taskgist.common.workers import Progress, in_order, silent
from taskgist.perspective.effort import ABILITIES, NO_KNOWN_LEVEL, Ability
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.world.stage import Stage
from taskgist_lab.evaluation.sheets import Sheet
from taskgist_lab.evaluation.values import Result, rounded
from taskgist_lab.ordinary.rooms import FurnishedRoom, furnished
from taskgist_lab.ordinary.truth import Truth, Truths, needs

LEVELS = range(NO_KNOWN_LEVEL + 1)
UNKNOWN = "unknown"


@dataclass(frozen=True)
class Pair:
    """What perspective says of one person and one thing, beside what any person says.

    Attributes:
        room: Name of the room.
        person: Name of the person.
        thing: Name of the thing.
        spot: Where it lies, by what people call that.
        needs: What it takes, beside an arm.
        truth: What any person says, by ability.
        levels: Effort levels, by ability; None is unknown.
        reasons: Why an answer that is wrong was given, by ability.
        taken_ms: Time on the processor that each answer took, milliseconds, by ability.
    """

    room: str
    person: str
    thing: str
    spot: str
    needs: tuple[str, ...]
    truth: dict[Ability, Truth]
    levels: dict[Ability, int | None]
    reasons: dict[Ability, str]
    taken_ms: dict[Ability, float] = field(compare=False)

    def is_wrong(self, ability: Ability) -> bool:
        """Whether the answer is not what any person says; what is debatable never is."""
        impossible = self.levels[ability] == NO_KNOWN_LEVEL
        return self.truth[ability] is (Truth.ABLE if impossible else Truth.NOBODY)


@dataclass(frozen=True)
class Share:
    """How many of some pairs are answered wrongly."""

    wrong: int
    of: int

    @staticmethod
    def among(pairs: Iterable[Pair], ability: Ability) -> Share:
        """Of pairs."""
        wrong = [pair.is_wrong(ability) for pair in pairs]
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
        return [pair for pair in self.pairs if pair.truth[ability] is truth]

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

    def reasons(self, ability: Ability) -> Counter[str]:
        """Why what an able adult gets at is called impossible."""
        return Counter(pair.reasons[ability] for pair in self.of(Truth.ABLE, ability) if pair.is_wrong(ability))

    def levels(self, ability: Ability) -> dict[str, int]:
        """How often each effort level was found for what an able adult gets at."""
        counts = Counter(pair.levels[ability] for pair in self.of(Truth.ABLE, ability))
        known = {str(level): counts[level] for level in LEVELS}
        return known | ({UNKNOWN: counts[None]} if counts[None] else {})

    def times_ms(self, truth: Truth, ability: Ability) -> tuple[float, float, float]:
        """Median, 95 % quantile and most of the time that an answer takes, milliseconds; not a number for none."""
        times = [pair.taken_ms[ability] for pair in self.of(truth, ability)] or [math.nan]
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
            "wrong": [_plain_pair(pair) for pair in self.pairs if any(map(pair.is_wrong, ABILITIES))],
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
            asked, taken_ms = {}, {}
            for ability in ABILITIES:
                start_s = time.process_time()
                asked[ability] = efforts.effort(person.name, placed.thing.name, ability)
                taken_ms[ability] = 1000 * (time.process_time() - start_s)
            truth = {ability: truths.of(person, placed, ability) for ability in ABILITIES}
            levels = {ability: effort.level for ability, effort in asked.items()}
            names = (room.name, person.name, placed.thing.name, placed.spot.name)
            pair = Pair(*names, needs(room, person, placed), truth, levels, {}, taken_ms)
            for ability in filter(pair.is_wrong, ABILITIES):
                told = asked[ability].evidence.told
                pair.reasons[ability] = told.reason.value if told else asked[ability].reason
            yield pair


def _warm_up(stage: Stage) -> None:
    """Have compiled what is compiled once."""
    efforts, scene = SceneEfforts(stage), stage.scene
    for ability in ABILITIES:
        efforts.effort(scene.agents[0], scene.objects[0], ability)


def _plain(shares: dict[str, dict[Ability, Share]]) -> dict[str, dict[Ability, dict[str, float]]]:
    return {name: {ability: share.plain for ability, share in each.items()} for name, each in shares.items()}


def _plain_pair(pair: Pair) -> dict[str, Any]:
    truth = {ability: value.name.lower() for ability, value in pair.truth.items()}
    return {**vars(pair), "needs": list(pair.needs), "truth": truth}


# --- As tables of text.


def sheets(found: RoomsFound) -> Iterator[Sheet]:
    """All that was found, as tables."""
    rows = tuple(
        (
            ability,
            found.missed(ability).text,
            found.invented(ability).text,
            str(len(found.of(Truth.DEBATABLE, ability))),
            *(str(number) for number in list(found.levels(ability).values())[: len(LEVELS)]),
        )
        for ability in ABILITIES
    )
    header = ("ability", "able, called impossible", "nobody, called possible", "debatable", *map(str, LEVELS))
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
