"""Who carries what in the frames of a recording, or live: what ``observe/holding.py`` infers, from what was tracked.

This is the one place that decides it. Placement and the hands' status ask here, frame by frame. A thing that rests on a
support, or lies in a container, is carried by that, whatever else is near: such frames stand by themselves, and nothing
but the contact is looked at. Between two of them lies a *stretch* in which hands may carry the thing; it is inferred as
a whole as soon as any of its frames is asked for::

    frames      r r r r . . . . . . . . r r r r      r: rests
                        |- a stretch -|

Live, a frame is inferred from the last one in which the thing rested up to half a second later, and what was said
stands.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, field
from functools import cache, lru_cache

from taskgist.observe.evidence import EvidenceOf, Tracked
from taskgist.observe.frames import KEPT_FRAMES, ROUNDING_S, FrameSequence
from taskgist.observe.holding import Carrier, NoHand, Noise, Story, likeliest, pressed
from taskgist.settings import Settings
from taskgist.world.contacts import Holding
from taskgist.world.stage import Stage

BLOCK_S, MARGIN_S = 10.0, 5.0
"""What is carried for longer is inferred in blocks, each with a margin before and behind it: who held a thing
five seconds ago says little of who holds it."""


class Carrying:
    """Says who carries what in the settled frames of a sequence.

    Args:
        stage: Their scene; it shows other states after each question.
        frames: The frames; live, the delay is half of their window.
        settings: Distances, speeds and weights.
    """

    def __init__(self, stage: Stage, frames: FrameSequence, settings: Settings) -> None:
        self._stage, self._frames, self._settings = stage, frames, settings
        self._tracked = Tracked(stage, frames, settings)
        self._thing = cache(self._thing_of)
        self._holding = lru_cache(KEPT_FRAMES)(self._holding_in)

    def carrier(self, index: int, name: str) -> Carrier:
        """What carries an object in a frame; where it was not tracked, what probably does."""
        return self._thing(name).carrier(index)

    def holding(self, index: int, name: str) -> Holding | None:
        """Who holds an object in a frame, and what it rests on or lies in; None if it was not tracked."""
        return self._holding(index, name)

    def held(self, index: int, agent: str, side: str) -> str | None:
        """The object that a hand holds in a frame; None if it holds none."""
        scene, (_, arm) = self._stage.scene, self._tracked.arms[agent, side]
        stage = self._stage.show(self._frames.state(index))
        pairs = stage.near_pairs(arm.hand_geoms, scene.objects_geoms, limit_m=self._settings.carrying.near_m)
        near = {scene.owners[geom] for _, geom in pairs}
        for name in scene.objects:
            if name in near and (holding := self._holding(index, name)) and (agent, side) in holding.hands:
                return name
        return None

    def _thing_of(self, name: str) -> Whole | Live:
        evidence = EvidenceOf(self._tracked, name)
        return (
            Whole(evidence, self._frames, self._settings)
            if self._frames.whole
            else Live(evidence, self._frames, self._settings)
        )

    def _holding_in(self, index: int, name: str) -> Holding | None:
        thing = self._thing(name)
        if not thing.evidence.known(index):
            return None
        carrier = thing.carrier(index)
        if carrier is NoHand.SUPPORT:
            rest = thing.evidence.look(index).rest
            return Holding((), rest.support, rest.container, complete=True)
        palms = self._tracked.palms(index)
        if isinstance(carrier, frozenset):
            hands = tuple(hand for hand in palms if hand in carrier)
            return Holding(hands, None, None, complete=bool(hands))
        scene, state = self._stage.scene, self._frames.state(index)
        sure = carrier is NoHand.NOBODY and len(palms) == len(self._tracked.arms)
        return Holding((), None, None, complete=sure and all(state.known([other]) for other in scene.objects))


class Whole:
    """What carries one thing in each frame of a whole recording.

    Args:
        evidence: What each frame says.
        frames: The frames: no more will come.
        settings: All settings.
    """

    def __init__(self, evidence: EvidenceOf, frames: FrameSequence, settings: Settings) -> None:
        self.evidence, self._frames, self._settings = evidence, frames, settings
        self._found: dict[int, Carrier] = {}

    def carrier(self, index: int) -> Carrier:
        """What carries it in a frame."""
        if index not in self._found and self.evidence.rests(index):
            return NoHand.SUPPORT
        if index not in self._found:
            first, last = self._stretch(index)
            limits, frames = self._settings.carrying, range(first, last + 1)
            carriers = likeliest([self.evidence.at(each) for each in frames], limits)
            carriers = pressed(carriers, self._frames.times_s[first : last + 1], limits.closing_s)
            self._found.update(
                (each, carrier)
                for each, carrier in enumerate(carriers, start=first)
                if self._block(each) == self._block(index)
            )
        return self._found[index]

    def _block(self, index: int) -> int:
        return int((self._frames.times_s[index] - self._frames.times_s[0]) / BLOCK_S)

    def _stretch(self, index: int) -> tuple[int, int]:
        """First and last frame of the stretch around a frame, those included in which the thing rests again."""
        times_s, rests = self._frames.times_s, self.evidence.rests
        start_s = times_s[0] + self._block(index) * BLOCK_S
        first = last = index
        while first > 0 and not rests(first) and times_s[first - 1] >= start_s - MARGIN_S:
            first -= 1
        while last < len(times_s) - 1 and not rests(last) and times_s[last + 1] <= start_s + BLOCK_S + MARGIN_S:
            last += 1
        return first, last


@dataclass
class _Chain:
    """A stretch that goes on, live.

    Attributes:
        first: Its first frame: the last one in which the thing rested, or the first of all.
        noise: Errors of the tracker, as far as they are known.
        story: What its frames say together.
        likeliest: The likeliest carrier of each frame from the first one on, as far as it is decided.
        decided: What carries the thing in each of them.
    """

    first: int
    noise: Noise
    story: Story
    likeliest: list[Carrier] = field(default_factory=list)
    decided: list[Carrier] = field(default_factory=list)


class Live:
    """What carries one thing in each frame of a sequence that grows.

    Args:
        evidence: What each frame says.
        frames: The frames; more may be appended.
        settings: All settings.
    """

    def __init__(self, evidence: EvidenceOf, frames: FrameSequence, settings: Settings) -> None:
        self.evidence, self._frames, self._settings = evidence, frames, settings.carrying
        self._chains: list[_Chain] = []

    def carrier(self, index: int) -> Carrier:
        """What carries it in a settled frame, by what was known half a second later."""
        if self.evidence.rests(index):
            return NoHand.SUPPORT
        chain = self._chain(index)
        while len(chain.decided) <= index - chain.first:
            self._decide_next(chain)
        return chain.decided[index - chain.first]

    def _chain(self, index: int) -> _Chain:
        """The stretch that a frame belongs to."""
        known = [chain for chain in self._chains if chain.first <= index]
        latest = max(known, key=lambda chain: chain.first, default=None)
        followed = latest.first + len(latest.decided) if latest else 0
        first = index
        while first > followed and not self.evidence.rests(first):
            first -= 1
        if latest is not None and (index < followed or (first == followed and not self.evidence.rests(first))):
            return latest
        self._chains.append(_Chain(first, Noise(self._settings), Story(self._settings)))
        return self._chains[-1]

    def _decide_next(self, chain: _Chain) -> None:
        index = chain.first + len(chain.decided)
        for each in range(chain.first + len(chain.story), self._horizon(index) + 1):
            evidence = self.evidence.at(each)
            chain.noise.add(evidence)
            chain.story.add(evidence, chain.noise)
            if evidence.rests and each > index:
                break
        ahead = chain.story.latest(chain.first + len(chain.story) - index)
        chain.likeliest.append(ahead[0])
        # Hands that close or open do so within the last frames and those to come.
        first = max(bisect_left(self._frames.times_s, self._frames.times_s[index] - 1.0), chain.first)
        near = [*chain.likeliest[first - chain.first : -1], *ahead]
        times_s = self._frames.times_s[first : first + len(near)]
        chain.decided.append(pressed(near, times_s, self._settings.closing_s)[index - first])

    def _horizon(self, index: int) -> int:
        """The last frame whose windows are complete by the time that a frame is decided."""
        times_s, limits = self._frames.times_s, self._settings
        until_s = times_s[index] + limits.delay_s - limits.window_s / 2 + ROUNDING_S
        last = index
        while last < len(times_s) - 1 and times_s[last + 1] <= until_s:
            last += 1
        return last
