"""Who carries a thing over time: one inference for all hands, supports and moments together.

In a single frame of a real tracker little is sure: a hand that holds a cup is seen 4 cm beside it, a hand that only
passes is nearer. Over time it is another matter: a thing that travels is carried by somebody, hands do not take and let
go ten times a second, and what stands on a table stands there until somebody lifts it. So the question is not asked for
each hand and each frame. Of all stories that can be told of the thing, the likeliest is taken (Viterbi's algorithm):

- A *story* says for each frame which *carrier* the thing has: a set of hands (two people while it changes hands); a
  *support*; *nobody*, while it falls, flies or rolls; or a hand that is *unseen*, where hands were not tracked.
- Each frame speaks for or against each carrier (``scores``): by the gap between hand and thing, held against gaps of
  hands that have nothing to do with it; and by the slip, the speed of the palm in the thing's own frame. How large gaps
  and slips of holding hands are on this tracker is estimated first, where the thing travels (``Noise``).
- Each change of carrier costs something (``change_cost``), so that nothing changes for a flicker.
- Hands are around a thing before they press, and still are when they have let go. So a hand that comes beside another
  that holds the thing holds it a little later, and one that leaves it to another lets go a little sooner; where these
  moments cross, the thing changes hands in the middle (``pressed``).

An example: P1's hand is at the cup at first, P2's comes to it and takes it along::

    speaks for P1   + + + + + + + + - - -
    speaks for P2   - - - - + + + + + + +
    likeliest       1 1 1 1 b b b b 2 2 2        b: both
    pressed         1 1 1 1 1 1 2 2 2 2 2

The whole of a recording is decided at once; live, each frame is decided half a second later, by the same steps: see
``Story``. Natural logarithms throughout; a score is a log-likelihood ratio against "nobody knows".
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import lru_cache
from itertools import combinations

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.settings import Carrying

Hand = tuple[str, str]
"""Agent and side."""


class NoHand(Enum):
    """Carriers that are no hands that were seen."""

    SUPPORT = "support"
    UNSEEN = "a hand that was not tracked"
    NOBODY = "nobody"

    def __repr__(self) -> str:
        return self.name


Carrier = NoHand | frozenset[Hand]
TRAVELS_M_S = 0.1
"""Speed above which a thing travels."""
FREEDOM = 3.0
"""Degrees of freedom of Student's distributions: errors of trackers have long tails."""
UPPER_QUARTILE, MEDIAN_3D = 1.15, 1.54
"""The 75 % quantile of |x|, and the median length of a vector in space, where each coordinate has deviation 1."""
FEWEST = 5
"""As many frames at least tell how large errors are."""


@dataclass(frozen=True)
class NearHand:
    """A tracked hand near a thing in one frame.

    Attributes:
        hand: Whose, and which.
        gap_m: Signed gap between hand and thing in metres; negative: how deep they overlap.
        slip_m_s: Speed of the palm in the thing's frame, metres per second; None is unknown.
    """

    hand: Hand
    gap_m: float
    slip_m_s: float | None = None


@dataclass(frozen=True)
class Evidence:
    """What one frame says of who carries a thing.

    Attributes:
        dt_s: Time since the frame before, seconds.
        tracked: Whether the thing was; if not, nothing else counts.
        touches: Whether there is something at the thing that may carry it: a support beneath, a container about it.
        rests: Whether it also stays there: then that carries it, whatever else is near.
        speed_m_s: The thing's speed, metres per second; None is unknown.
        falls: Whether it falls freely.
        near: The hands near to it.
        lost: All hands that were not tracked.
    """

    dt_s: float
    tracked: bool = True
    touches: bool = False
    rests: bool = False
    speed_m_s: float | None = None
    falls: bool = False
    near: tuple[NearHand, ...] = ()
    lost: frozenset[Hand] = frozenset()

    @property
    def travels(self) -> bool:
        """Whether the thing is under way."""
        return self.speed_m_s is not None and self.speed_m_s > TRAVELS_M_S


@dataclass
class Noise:
    """How large the gaps and slips of holding hands are here: where the thing travels, the nearest hand holds it.

    Attributes:
        gaps_m: Least gap of each frame in which the thing travels, in order of size.
        slips_m_s: Least slip of each of them.
    """

    settings: Carrying
    gaps_m: list[float] = field(default_factory=list)
    slips_m_s: list[float] = field(default_factory=list)

    def add(self, evidence: Evidence) -> None:
        """Take a frame into account."""
        if not evidence.tracked or not evidence.travels or evidence.falls or not evidence.near:
            return
        bisect.insort(self.gaps_m, max(min(near.gap_m for near in evidence.near), 0.0))
        slips = [near.slip_m_s for near in evidence.near if near.slip_m_s is not None]
        if slips:
            bisect.insort(self.slips_m_s, min(slips))

    @property
    def gap_m(self) -> float:
        """Deviation of a holding hand's gap, metres."""
        return _deviation(self.gaps_m, 0.75, UPPER_QUARTILE, self.settings.gap_noise_m)

    @property
    def slip_m_s(self) -> float:
        """Deviation of each coordinate of a holding hand's slip, metres per second."""
        return _deviation(self.slips_m_s, 0.5, MEDIAN_3D, self.settings.slip_noise_m_s)


def _deviation(values: Sequence[float], share: float, of_one: float, within: tuple[float, float]) -> float:
    """A deviation from a quantile of sorted values; from few values, the geometric middle of what is believed."""
    if len(values) < FEWEST:
        return math.sqrt(within[0] * within[1])
    at = share * (len(values) - 1)
    below = int(at)
    above = min(below + 1, len(values) - 1)
    quantile = values[below] + (at - below) * (values[above] - values[below])
    return min(max(quantile / of_one, within[0]), within[1])


def student(distance: float, scale: float, dimensions: int) -> float:
    """Density of Student's distribution at a distance from its middle, in so many dimensions (ν = 3)."""
    constant = math.gamma((FREEDOM + dimensions) / 2) / math.gamma(FREEDOM / 2)
    constant /= (FREEDOM * math.pi) ** (dimensions / 2) * scale**dimensions
    return float(constant * (1.0 + distance**2 / (FREEDOM * scale**2)) ** (-(FREEDOM + dimensions) / 2))


def hand_score(near: NearHand, speed_m_s: float, noise: Noise) -> float:
    """How much one frame speaks for a hand that holds the thing, against a hand that has nothing to do with it.

    ln T₁(g⁺; σg) − ln p(g) + w · ln(½ + ½ · T₃(r; σr) / T₃(r; σb)), with g the gap and r the slip. p is exponential in
    the gap, and falls with the depth of an overlap. The slip of a hand that has nothing to do with the thing has the
    deviation σb, for it goes as fast as the thing goes away from it: σb² = σr² + (0.1² + u²) / 3. A hand that goes
    along a thing that stands still does not hold it.

    Args:
        near: The hand.
        speed_m_s: The thing's speed u, metres per second.
        noise: The deviations σg and σr.
    """
    settings = noise.settings
    gap_m = max(near.gap_m, 0.0)
    score = math.log(student(gap_m, noise.gap_m, 1)) + math.log(settings.near_m) + gap_m / settings.near_m
    score += min(max(-near.gap_m, 0.0), settings.pressed_most_m) / settings.pressed_m
    if near.slip_m_s is None:
        return score
    held = noise.slip_m_s
    if speed_m_s < settings.still_m_s and near.slip_m_s > max(settings.passes_m_s, 3.0 * held):
        return -settings.passes  # it goes, and the thing stays
    idle = math.sqrt(held**2 + (settings.idle_m_s**2 + speed_m_s**2) / 3.0)
    ratio = student(near.slip_m_s, held, 3) / student(near.slip_m_s, idle, 3)
    return score + settings.slip_weight * math.log(0.5 + 0.5 * ratio)


def scores(evidence: Evidence, hands: frozenset[Hand], noise: Noise) -> dict[Carrier, float]:
    """How much one frame speaks for each carrier that is possible in it, (carriers,).

    Args:
        evidence: The frame.
        hands: Hands that may hold the thing; those that are not among the near ones were lost, and nothing is known.
        noise: How large gaps and slips of holding hands are.
    """
    if evidence.tracked and evidence.rests:
        return {NoHand.SUPPORT: 0.0}
    settings = noise.settings
    if evidence.tracked:
        speed_m_s = evidence.speed_m_s or 0.0
        of_hand = {near.hand: hand_score(near, speed_m_s, noise) for near in evidence.near}
        nobody = -settings.nobody_travels if evidence.travels else -settings.nobody
        nobody = settings.falls if evidence.falls else nobody
    else:
        of_hand, nobody = {}, 0.0
    found: dict[Carrier, float] = {}
    if evidence.touches or not evidence.tracked:
        found[NoHand.SUPPORT] = 0.0
    for count in range(1, settings.hands + 1):
        for several in combinations(sorted(hands), count):
            persons = len({agent for agent, _ in several})
            against = settings.further_hand * (count - persons) + settings.further_person * (persons - 1)
            found[frozenset(several)] = sum(of_hand.get(hand, 0.0) for hand in several) - against
    if evidence.lost or not evidence.tracked:
        found[NoHand.UNSEEN] = 0.0
    found[NoHand.NOBODY] = nobody
    weight = min(evidence.dt_s / settings.independent_s, 1.0)
    return {carrier: weight * score for carrier, score in found.items()}


def change_cost(before: Carrier, after: Carrier, settings: Carrying) -> float:
    """What speaks against a change of carrier from one frame to the next."""
    if before == after:
        return 0.0
    nobody = settings.change_nobody if NoHand.NOBODY in (before, after) else 0.0
    if isinstance(before, frozenset) and isinstance(after, frozenset):
        return settings.change_hand * len(before ^ after)
    hands = before if isinstance(before, frozenset) else after
    if not isinstance(hands, frozenset):
        return nobody or settings.change_rest
    return nobody + len(hands) * (settings.change_hand if nobody else settings.change_rest)


@lru_cache(maxsize=1024)
def _change_costs(before: tuple[Carrier, ...], after: tuple[Carrier, ...], settings: Carrying) -> Array:
    """Of each change, (before, after)."""
    return np.array([[change_cost(one, other, settings) for other in after] for one in before])


class Story:
    """The likeliest carriers of a thing, frame after frame.

    ``add`` takes the next frame; ``latest`` tells the carriers of the last frames as they look by now. Asked once after
    the last frame, this is the likeliest story of all; asked for the frame half a second ago, after each, it is what
    can be known live.

    Args:
        settings: All weights.
    """

    def __init__(self, settings: Carrying) -> None:
        self._settings = settings
        self._hands: frozenset[Hand] = frozenset()
        self._carriers: list[tuple[Carrier, ...]] = []
        self._from: list[Indices] = []
        self._total = np.zeros(0)

    def __len__(self) -> int:
        return len(self._carriers)

    def add(self, evidence: Evidence, noise: Noise) -> None:
        """Take the next frame."""
        # A hand that is lost may go on with what it did when it was seen last; where the thing is lost, all may.
        near = frozenset(near.hand for near in evidence.near)
        self._hands = near | (self._hands & evidence.lost) if evidence.tracked else self._hands
        found = scores(evidence, self._hands, noise)
        carriers, gained = tuple(found), np.array([*found.values()])
        if self._carriers:
            ways = self._total[:, None] - _change_costs(self._carriers[-1], carriers, self._settings)
            best = ways.argmax(axis=0)
            gained = gained + ways[best, np.arange(len(carriers))]
        else:
            best = np.zeros(len(carriers), dtype=np.intp)
        self._carriers.append(carriers)
        self._from.append(best)
        self._total = gained - gained.max()

    def latest(self, count: int) -> list[Carrier]:
        """The likeliest carriers of the last frames, in order of time."""
        state, found = int(self._total.argmax()), list[Carrier]()
        for frame in range(len(self._carriers) - 1, len(self._carriers) - 1 - count, -1):
            found.append(self._carriers[frame][state])
            state = int(self._from[frame][state])
        return found[::-1]


def likeliest(frames: Sequence[Evidence], settings: Carrying) -> list[Carrier]:
    """The carrier in each frame, for all frames together: the errors of the tracker are estimated from all of them."""
    noise, story = Noise(settings), Story(settings)
    for evidence in frames:
        noise.add(evidence)
    for evidence in frames:
        story.add(evidence, noise)
    return story.latest(len(frames))


def pressed(carriers: Sequence[Carrier], times_s: Sequence[float], closing_s: float) -> list[Carrier]:
    """The same carriers, without hands that are around the thing and do not press yet, or do not press any more.

    It concerns hands that others hold the thing with: what is taken from a support leaves it when it is held.

    Args:
        carriers: The carrier in each frame.
        times_s: Times of the frames in seconds.
        closing_s: How long hands take to close or to open.
    """
    found, first = list(carriers), 0
    while first < len(carriers):
        held, end = carriers[first], first + 1
        while end < len(carriers) and carriers[end] == held:
            end += 1
        if isinstance(held, frozenset) and len(held) > 1:
            before = held & _hands_in(carriers[first - 1]) if first > 0 else held
            after = held & _hands_in(carriers[end]) if end < len(carriers) else held
            # What was before the first frame, and what comes after the last one, is not known: it may have lasted.
            start_s = times_s[first] if first > 0 else -math.inf
            end_s = times_s[end] if end < len(carriers) else math.inf
            within_s = min(closing_s, (end_s - start_s) / 2)
            for each in range(first, end):
                comes = before and times_s[each] < start_s + within_s
                goes = after and times_s[each] >= end_s - within_s
                found[each] = before if comes else after if goes else held
        first = end
    return found


def _hands_in(carrier: Carrier) -> frozenset[Hand]:
    return carrier if isinstance(carrier, frozenset) else frozenset()
