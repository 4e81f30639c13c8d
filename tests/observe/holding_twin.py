"""The slow, obvious twin of who carries a thing: every carrier in every frame, with scipy's densities."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import combinations, pairwise, product

import numpy as np
from scipy import stats

from taskgist.observe.holding import Carrier, Evidence, Hand, NearHand, NoHand
from taskgist.settings import Carrying


def deviations(frames: Sequence[Evidence], settings: Carrying) -> tuple[float, float]:
    """Of gaps and slips, from the frames in which the thing travels and a hand is near."""
    under_way = [f for f in frames if f.tracked and f.near and not f.falls and (f.speed_m_s or 0.0) > 0.1]
    gaps = [max(0.0, min(near.gap_m for near in frame.near)) for frame in under_way]
    slips = [[near.slip_m_s for near in frame.near if near.slip_m_s is not None] for frame in under_way]
    return (
        _deviation(gaps, 75, 1.15, settings.gap_noise_m),
        _deviation([min(each) for each in slips if each], 50, 1.54, settings.slip_noise_m_s),
    )


def _deviation(values: Sequence[float], percent: float, of_one: float, within: tuple[float, float]) -> float:
    if len(values) < 5:
        return float(np.sqrt(np.prod(within)))
    return float(np.clip(np.percentile(values, percent) / of_one, *within))


@lru_cache(maxsize=100_000)
def log_ratio(near: NearHand, speed_m_s: float, gap_noise_m: float, slip_noise: float, settings: Carrying) -> float:
    """ln of how much likelier gap and slip are of a hand that holds than of one that does not."""
    outside_m, inside_m = max(near.gap_m, 0.0), min(near.gap_m, 0.0)
    other = math.exp(-outside_m / settings.near_m) / settings.near_m
    other *= math.exp(max(inside_m, -settings.pressed_most_m) / settings.pressed_m)
    ratio = math.log(stats.t.pdf(outside_m, 3, scale=gap_noise_m) / other)
    if near.slip_m_s is None:
        return ratio
    if speed_m_s < settings.still_m_s and near.slip_m_s > settings.passes_m_s and near.slip_m_s > 3 * slip_noise:
        return -settings.passes
    idle = slip_noise**2 + (settings.idle_m_s**2 + speed_m_s**2) / 3
    there = np.array([near.slip_m_s, 0.0, 0.0])
    held, not_held = (
        stats.multivariate_t.pdf(there, np.zeros(3), variance * np.eye(3), df=3) for variance in (slip_noise**2, idle)
    )
    return ratio + settings.slip_weight * math.log(0.5 + 0.5 * held / not_held)


def gains(frames: Sequence[Evidence], settings: Carrying) -> tuple[list[Carrier], np.ndarray]:
    """All carriers, and what each frame says of each, (frames, carriers); −∞ where it cannot be."""
    gap_noise_m, slip_noise = deviations(frames, settings)
    hands = sorted({near.hand for frame in frames for near in frame.near})
    sets = [frozenset(some) for count in (1, 2, 3) if count <= settings.hands for some in combinations(hands, count)]
    carriers: list[Carrier] = [NoHand.SUPPORT, *sets, NoHand.UNSEEN, NoHand.NOBODY]
    table = np.full((len(frames), len(carriers)), -np.inf)
    possible: frozenset[Hand] = frozenset()
    for row, frame in enumerate(frames):
        near = {each.hand: each for each in frame.near}
        if frame.tracked:
            possible = frozenset(near) | (possible & frame.lost)
        for column, carrier in enumerate(carriers):
            table[row, column] = _gain(frame, carrier, near, possible, gap_noise_m, slip_noise, settings)
        table[row] *= min(1.0, frame.dt_s / settings.independent_s)
    return carriers, table


def _gain(
    frame: Evidence,
    carrier: Carrier,
    near: dict[Hand, NearHand],
    possible: frozenset[Hand],
    gap_noise_m: float,
    slip_noise: float,
    settings: Carrying,
) -> float:
    if frame.tracked and frame.rests:
        return 0.0 if carrier is NoHand.SUPPORT else -math.inf
    if carrier is NoHand.SUPPORT:
        return 0.0 if frame.touches or not frame.tracked else -math.inf
    if carrier is NoHand.UNSEEN:
        return 0.0 if frame.lost or not frame.tracked else -math.inf
    if carrier is NoHand.NOBODY:
        if not frame.tracked:
            return 0.0
        if frame.falls:
            return settings.falls
        return -settings.nobody_travels if (frame.speed_m_s or 0.0) > 0.1 else -settings.nobody
    assert isinstance(carrier, frozenset)
    if not carrier <= possible:
        return -math.inf
    speed = frame.speed_m_s or 0.0
    known = [near[hand] for hand in carrier if hand in near] if frame.tracked else []
    total = sum(log_ratio(each, speed, gap_noise_m, slip_noise, settings) for each in known)
    persons = {agent for agent, _ in carrier}
    return total - settings.further_person * (len(persons) - 1) - settings.further_hand * (len(carrier) - len(persons))


def cost(before: Carrier, after: Carrier, settings: Carrying) -> float:
    """Of a change: so much for each hand, less at a support, more for nobody."""
    one, other = (set(each) if isinstance(each, frozenset) else set() for each in (before, after))
    if before == after:
        return 0.0
    if NoHand.NOBODY in (before, after):
        return settings.change_nobody + settings.change_hand * len(one ^ other)
    if one and other:
        return settings.change_hand * len(one ^ other)
    return settings.change_rest * max(len(one ^ other), 1)


def value(story: Sequence[Carrier], frames: Sequence[Evidence], settings: Carrying) -> float:
    """How likely a story is, as a logarithm."""
    carriers, table = gains(frames, settings)
    said = sum(float(table[row, carriers.index(carrier)]) for row, carrier in enumerate(story))
    return said - sum(cost(one, other, settings) for one, other in pairwise(story))


def best_of_all(frames: Sequence[Evidence], settings: Carrying) -> float:
    """The value of the likeliest of all stories, each of which is tried: for a few frames."""
    carriers, _ = gains(frames, settings)
    return max(value(story, frames, settings) for story in product(carriers, repeat=len(frames)))


def likeliest(frames: Sequence[Evidence], settings: Carrying) -> list[Carrier]:
    """The likeliest story, by all changes between all carriers."""
    carriers, table = gains(frames, settings)
    costs = np.array([[cost(one, other, settings) for other in carriers] for one in carriers])
    best, ways = table[0], []
    for row in table[1:]:
        reached = best[:, None] - costs
        ways.append(reached.argmax(axis=0))
        best = row + reached.max(axis=0)
    at = int(best.argmax())
    story = [at]
    for way in reversed(ways):
        at = int(way[at])
        story.append(at)
    return [carriers[each] for each in reversed(story)]
