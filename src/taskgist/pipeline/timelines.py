"""The timeline of a recording: every attribute of one agent and object, as intervals of equal value.

What is confirmed over time (posture, hands, placement, motion) is exact to the frame; abilities, predicates and
visibility are sampled.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from taskgist.common.workers import Progress, in_order, silent
from taskgist.facts.predicates import Predicate, with_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree, symbol_of
from taskgist.facts.values import Raw, Unknown, Value
from taskgist.observe.attributes import Snapshot, snapshot, status_observations
from taskgist.observe.frames import Interval
from taskgist.observe.observer import Observer
from taskgist.recording.recording import Recording
from taskgist.settings import DEFAULT, Settings
from taskgist.world.stage import Stage
from taskgist.world.state import EyeTurn


@dataclass(frozen=True)
class AssumedGaze:
    """A while in which the eyes were assumed to look at a thing (``observe/eyes.py``).

    Attributes:
        towards: The thing.
        start_s: The first sample of it, seconds.
        end_s: The first sample in which they are no longer, or the last of all.
        turned_rad: How far the eyes were turned in the head, least and most, radians.
    """

    towards: str
    start_s: float
    end_s: float
    turned_rad: tuple[float, float]


@dataclass(frozen=True)
class Timeline:
    """Every attribute over time, from one agent's perspective of one object.

    Attributes:
        agent: Whose perspective.
        name: Which object.
        every_s: How often abilities, predicates and visibility were sampled, in seconds.
        rows: By attribute: intervals of equal symbol, in order; None is unknown.
        gaze: When the agent's eyes were assumed to look elsewhere than its head.
    """

    agent: str
    name: str
    every_s: float
    rows: dict[str, tuple[Interval[str | None], ...]]
    gaze: tuple[AssumedGaze, ...] = ()


def timeline(
    recording: Recording,
    observer: Observer,
    *,
    agent: str,
    name: str,
    every_s: float = 0.5,
    tree: HypothesisTree = STANDARD_TREE,
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] = (),
    progress: Progress = silent,
    processes: int | None = 1,
) -> Timeline:
    """Sample every attribute through a recording.

    Args:
        recording: The recording.
        observer: One of this recording.
        agent: Whose perspective.
        name: Which object.
        every_s: Seconds between samples.
        tree: Gives the symbols; ``predicates`` extend it.
        settings: All settings.
        predicates: A user's own predicates.
        progress: Told how far it is.
        processes: How many watch parts of the recording at the same time; None: one for each core, if it is long.
    """
    predicates = tuple(predicates)
    whole, stage = with_predicates(tree, predicates), Stage(recording.scene)
    frames_s = recording.times_s.tolist()
    first, last = frames_s[0], frames_s[-1]
    times = [*np.arange(first, last, every_s).tolist(), last]
    parts = int((last - first) / PART_S) + 1
    bounds_s = [*(first + part * PART_S for part in range(parts)), math.inf]

    def watched(part: int) -> _Watched:
        """What is seen in one part: all frames, and all samples, from its beginning until the next one begins."""
        start_s, end_s = bounds_s[part : part + 2]
        exact, samples, turns = _Symbols(whole, settings), _Symbols(whole, settings), list[EyeTurn | None]()
        for time_s in frames_s[bisect_left(frames_s, start_s) : bisect_left(frames_s, end_s)]:
            exact.add(time_s, status_observations(observer, agent, name, time_s, explained=False))
        for time_s in times[bisect_left(times, start_s) : bisect_left(times, end_s)]:
            stage.show(recording.at(time_s))
            observed = snapshot(stage, observer, agent=agent, name=name, settings=settings, predicates=predicates)
            samples.add(time_s, observed)
            turns.append(stage.state.eyes.get(agent))
        return _Watched(exact.changes, samples.changes, turns)

    exact, samples, turns = _Rows(), _Rows(), list[EyeTurn | None]()
    if processes is None and parts < LONG_PARTS:
        processes = 1
    # The first part is watched here: what is compiled, or loaded, for it need not be for each worker.
    later = in_order(lambda number: watched(number + 1), parts - 1, processes)
    for number, found in enumerate(chain([watched(0)], later), start=1):
        _join(exact, found.exact)
        _join(samples, found.samples)
        turns += found.turns
        progress("watching and taking perspective", number / parts)
    rows = {key: _intervals(row, last) for key, row in (samples | exact).items()}
    return Timeline(agent, name, every_s, rows, _assumed(times, turns))


# --- Parts: what is seen in some seconds of a recording hangs on no other part, so that several are watched at once.

PART_S = 10.0
"""Duration of a part, seconds: as long as what is carried is inferred at once (``observe/carrying.py``)."""
LONG_PARTS = 3
"""Of fewer parts, workers take longer to begin than they save."""

_Rows = dict[str, list[tuple[float, str | None]]]
"""By attribute: when it became what; equal symbols behind each other are one."""


@dataclass(frozen=True)
class _Watched:
    """What was seen in a part: changes of what is exact, and of samples; and how eyes were turned in each of these."""

    exact: _Rows
    samples: _Rows
    turns: list[EyeTurn | None]


class _Symbols:
    """Changes of symbols from one snapshot to the next; most are as the one before, and the tree is not asked."""

    def __init__(self, tree: HypothesisTree, settings: Settings) -> None:
        self._tree, self._settings = tree, settings
        self._last: dict[str, Raw] = {}
        self.changes: _Rows = {}

    def add(self, time_s: float, observed: Snapshot) -> None:
        """Take the next snapshot."""
        values = {attribute: observation.value for attribute, observation in observed.items()}
        if values != self._last:
            self._last = values
            for attribute, symbol in symbols(self._tree, observed, self._settings).items():
                _change(self.changes, attribute, time_s, symbol)


def _join(rows: _Rows, later: _Rows) -> None:
    for attribute, changes in later.items():
        for time_s, symbol in changes:
            _change(rows, attribute, time_s, symbol)


def _change(rows: _Rows, attribute: str, time_s: float, symbol: str | None) -> None:
    row = rows.setdefault(attribute, [])
    if not row or row[-1][1] != symbol:
        row.append((time_s, symbol))


def _assumed(times_s: Sequence[float], turns: Sequence[EyeTurn | None]) -> tuple[AssumedGaze, ...]:
    """The whiles of equal things that eyes were assumed to look at, from samples."""
    found: list[AssumedGaze] = []
    ends_s = [*times_s[1:], times_s[-1]]
    for time_s, end_s, turn in zip(times_s, ends_s, turns, strict=True):
        if turn is None or turn.towards is None:
            continue
        start_s, turned_rad = time_s, (turn.turned_rad, turn.turned_rad)
        if found and found[-1].end_s == time_s and found[-1].towards == turn.towards:
            before = found.pop()
            start_s = before.start_s
            turned_rad = min(before.turned_rad[0], turn.turned_rad), max(before.turned_rad[1], turn.turned_rad)
        found.append(AssumedGaze(turn.towards, start_s, end_s, turned_rad))
    return tuple(found)


def symbols(tree: HypothesisTree, observed: Snapshot, settings: Settings) -> dict[str, str | None]:
    """The symbol of each attribute of a snapshot, in the tree's order; None is unknown."""
    return {
        attribute: _text(symbol_of(tree.attributes[attribute], observed, settings).value)
        for attribute in attribute_nodes(tree)
        if attribute in observed
    }


def attribute_nodes(tree: HypothesisTree) -> dict[str, str]:
    """The node of instant 2 that shows each attribute's symbol."""
    nodes: dict[str, str] = {}
    for subtree in tree.subtrees:
        leaves = [subtree.leaf] if subtree.leaf else []
        while leaves:
            leaf = leaves.pop(0)
            nodes[leaf.attribute.name] = f"{subtree.name}.{leaf.part}.2"
            leaves.extend(leaf.children)
    return nodes


def _text(value: Value) -> str | None:
    return None if isinstance(value, Unknown) else value


def _intervals(samples: list[tuple[float, str | None]], last_s: float) -> tuple[Interval[str | None], ...]:
    ends = [*(time_s for time_s, _ in samples[1:]), last_s]
    return tuple(Interval(value, time_s, end_s) for (time_s, value), end_s in zip(samples, ends, strict=True))
