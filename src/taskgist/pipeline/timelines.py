"""The timeline of a recording: every attribute of one agent and object, as intervals of equal value.

What is confirmed over time (posture, hands, placement, motion) is exact to the frame; abilities, predicates and
visibility are sampled.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from taskgist.common.workers import Progress, silent
from taskgist.facts.predicates import Predicate, with_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree
from taskgist.facts.values import Unknown, Value
from taskgist.observe.attributes import Snapshot, snapshot, status_observations
from taskgist.observe.frames import Interval
from taskgist.observe.observer import Observer
from taskgist.recording.recording import Recording
from taskgist.settings import DEFAULT, Settings
from taskgist.world.stage import Stage
from taskgist.world.state import EyeTurn

Samples = dict[str, list[tuple[float, str | None]]]
"""By attribute: when it became what; equal samples behind each other are one."""


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
    """
    predicates = tuple(predicates)
    whole = with_predicates(tree, predicates)
    stage = Stage(recording.scene)
    first, last = float(recording.times_s[0]), float(recording.times_s[-1])
    times = [*np.arange(first, last, every_s).tolist(), last]
    exact: Samples = {}
    for number, time_s in enumerate(recording.times_s.tolist(), start=1):
        _collect(exact, time_s, symbols(whole, status_observations(observer, agent, name, time_s), settings))
        progress("watching", number / len(recording))
    samples, turns = Samples(), list[EyeTurn | None]()
    for number, time_s in enumerate(times, start=1):
        stage.show(recording.at(time_s))
        observed = snapshot(stage, observer, agent=agent, name=name, settings=settings, predicates=predicates)
        _collect(samples, time_s, symbols(whole, observed, settings))
        turns.append(stage.state.eyes.get(agent))
        progress("taking perspective", number / len(times))
    rows = {key: _intervals(row, last) for key, row in (samples | exact).items()}
    return Timeline(agent, name, every_s, rows, _assumed(times, turns))


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


def _collect(samples: Samples, time_s: float, found: Mapping[str, str | None]) -> None:
    for attribute, symbol in found.items():
        row = samples.setdefault(attribute, [])
        if not row or row[-1][1] != symbol:
            row.append((time_s, symbol))


def symbols(tree: HypothesisTree, observed: Snapshot, settings: Settings) -> dict[str, str | None]:
    """The symbol of each attribute of a snapshot, in the tree's order; None is unknown."""
    nodes = tree.instantiate(observed, observed, settings)
    return {
        attribute: _text(nodes[node].value)
        for attribute, node in attribute_nodes(tree).items()
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
