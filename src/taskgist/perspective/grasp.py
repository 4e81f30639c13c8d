"""Grasp: the object is reachable, and at least one collision-free grasp of that hand exists (5.1.3).

A grasp is tried with the shapes of a hand before it closes, and all that they sweep on their last way. They must be
free of everything solid: the support, other agents' hands, the agent's own head, torso and legs, and the object itself;
only what the fingers close on is touched by design. The agent's own arms do not count, they are where the virtual
action brings them.

What one hand cannot take as it lies, people tilt, people and robots slide over an edge, and both take between their two
hands. The ways are asked in the order of their trouble, and of two candidates the one of the least amount counts.

Tracked things sink into what carries them, or float above it, by millimetres: they are grasped as if they lay on it.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from taskgist.perspective.candidates import Candidates
from taskgist.perspective.effort import Miss, Prepared, Reason, nearest_miss
from taskgist.perspective.grasp_flat import LyingThing, closes_sideways, is_flat
from taskgist.perspective.grasp_sampling import SIDES, TOUCH_M, Grasps, grasps_in_object
from taskgist.perspective.grasp_ways import ONLY_ONE, OneHanded, TwoHanded
from taskgist.perspective.reach import ArmJudge, ReachScreening
from taskgist.perspective.viewpoint import FindMiss, Hit, Screening
from taskgist.world.bodies.hands import Hand, Palms
from taskgist.world.geometry.transforms import Pose

SEAT_M = 0.1
"""How far around an object what it lies on is looked for, at most."""


class Impossible:
    """An ability that no candidate can give, for one and the same reason."""

    def __init__(self, why: Miss) -> None:
        self._why = why

    def next(self, start: int, stop: int) -> int:  # noqa: ARG002 - as all screenings
        """None."""
        return stop

    def results(self, index: int) -> Iterator[Hit | FindMiss]:  # noqa: ARG002 - as all screenings
        """Never."""
        yield self.miss

    def miss(self) -> Miss:
        """The reason."""
        return self._why


class Grasp(ArmJudge):
    """Judges the ability to grasp one object.

    Args:
        here: Whose, and from where.
        target: The object.
    """

    failed = False
    """Whether no grasp was free somewhere from where arms get to one."""

    def screen(self, candidates: Candidates) -> Screening:
        """What the arms can grasp from some candidates."""
        if self.here.agent.profile.hand is not None:
            surface = ReachScreening(self, candidates, self.surface)
            if surface.beyond(self.farther_m):
                return surface  # no grasp is farther from the surface than this: spares sampling them
        if self._impossible is not None:
            return Impossible(self._impossible)
        return GraspScreening(self, candidates)

    @property
    def farther_m(self) -> float:
        """How much farther than the object's surface a grasp may be."""
        hand = self.here.agent.profile.hand
        return 0.0 if hand is None else hand.opening_m / 2 + self.here.settings.reach.cell_m

    @cached_property
    def _impossible(self) -> Miss | None:
        """Why no hand of the agent closes on the object at all."""
        hand = self.here.agent.profile.hand
        if hand is None:
            return Miss(Reason.NO_HAND, "no hand that grasps")
        narrowest_m = self._in_object.narrowest_m
        if narrowest_m is None:
            return Miss(Reason.NO_OPPOSITE_FACES, "no two opposite faces to close on")
        if len(self._in_object) or (self._between is not None and len(self._between)):
            return None
        widest_m = hand.opening_m if self._palms is None else self._palms.opening_m
        if narrowest_m > widest_m:
            return Miss(Reason.TOO_WIDE, f"too wide ({narrowest_m:.2f} m > {widest_m:.2f} m)")
        return Miss(Reason.TOO_NARROW, "too narrow for both fingers to meet it")

    @property
    def hopeless(self) -> bool:
        """Whether nothing the agent does helps, as far as is known by now; more is found out where something failed."""
        if super().hopeless or self.__dict__.get("_impossible") is not None:
            return True
        return (self.failed or self.looked) and self._all_blocked

    @cached_property
    def _all_blocked(self) -> bool:
        """Whether others are in the way of all grasps, by any way."""
        ways = (lambda: self.plain, lambda: self.between, lambda: self.tilted, lambda: self.slid, lambda: self.drawn)
        with self.here.stage.showing(self.here.state):
            return all(way is None or way.all_blocked() for way in (find() for find in ways))

    @property
    def _hand(self) -> Hand:
        assert self.here.agent.profile.hand is not None
        return self.here.agent.profile.hand

    @cached_property
    def _palms(self) -> Palms | None:
        """Both hands of the agent together, if it has two that are free and may use them."""
        sides = {self.arm(index).profile.side for index in self.arms}
        return self._hand.palms if sides >= set(SIDES) and not self.here.held else None

    @cached_property
    def _in_object(self) -> Grasps:
        """Grasps by one hand, in the object's frame."""
        return grasps_in_object(self.here.stage, self.target.name, self._hand, self.here.settings.grasp)

    @cached_property
    def _between(self) -> Grasps | None:
        """Grasps between both hands, in the object's frame; None if nothing of it is wider than a hand opens."""
        if self._palms is None or float(np.ptp(self.target.corners, axis=0).max(initial=0.0)) <= self._hand.opening_m:
            return None
        return grasps_in_object(self.here.stage, self.target.name, self._palms, self.here.settings.grasp)

    @cached_property
    def _pose(self) -> Pose:
        """Where the object is, lying on what carries it."""
        stage, up_m = self.here.stage, self.target.seat_m or 0.0
        self.here.recorder.target.add_balls(self.target.centers, self.target.radii_m + SEAT_M)
        pose = stage.body(stage.scene.object_body(self.target.name))
        return Pose(pose.position + (0.0, 0.0, up_m), pose.matrix) if abs(up_m) > TOUCH_M else pose

    @cached_property
    def plain(self) -> OneHanded:
        """With one hand, as it lies."""
        return OneHanded(self.here, self.target, self._pose, self._in_object, self._hand)

    @cached_property
    def between(self) -> TwoHanded | None:
        """Between both hands, where one closes on it from above and beneath at most; None if both do not, either."""
        if closes_sideways(self.plain.grasps, self.here.settings.grasp) or self._between is None or self._palms is None:
            return None
        if not len(self._between):
            return None
        return TwoHanded(self.here, self.target, self._pose, self._between, self._palms, kind=self._hand.kind)

    @cached_property
    def _lying(self) -> LyingThing | None:
        """The object, if it lies on something."""
        if self.target.seat_m is None:
            return None
        return LyingThing(self.here, self.target, self._pose, self._in_object)

    @cached_property
    def _is_flat(self) -> bool:
        return is_flat(self.plain.grasps, self.here.settings.grasp)

    def _prepared(self, grasps: Grasps, prepared: Prepared) -> OneHanded:
        return OneHanded(self.here, self.target, self._pose, grasps, self._hand, prepared=prepared)

    @cached_property
    def tilted(self) -> OneHanded | None:
        """With one hand, after tilting it, as people do."""
        if self._lying is None or self._hand.kind != "human" or not self._is_flat:
            return None
        return self._prepared(self._lying.tilted(), "tilted")

    @cached_property
    def slid(self) -> OneHanded | None:
        """With one hand, after sliding it over an edge."""
        if self._lying is None or not self._is_flat:
            return None
        return self._prepared(self._lying.slid(), "slid over the edge")

    @cached_property
    def drawn(self) -> OneHanded | None:
        """With one hand, after drawing it away from what it lies against, as people do."""
        if self._lying is None or self._hand.kind != "human":
            return None
        return self._prepared(self._lying.drawn(), "drawn aside")


class GraspScreening:
    """Where arms reach some grasp of the object, from n candidates."""

    def __init__(self, grasp: Grasp, candidates: Candidates) -> None:
        self._grasp, self._candidates = grasp, candidates
        self._plain = ReachScreening(grasp, candidates, grasp.plain.cloud)

    @cached_property
    def _between(self) -> ReachScreening | None:
        """From where arms reach the sides that both hands press on."""
        way = self._grasp.between
        return None if way is None else ReachScreening(self._grasp, self._candidates, way.cloud)

    def next(self, start: int, stop: int) -> int:
        """The first candidate from which an arm reaches a grasp."""
        if self._grasp.brief and self._grasp.hopeless:
            return stop
        first = self._plain.next(start, stop)
        return self._between.next(start, first) if first > start and self._between is not None else first

    def results(self, index: int) -> Iterator[Hit | FindMiss]:
        """How hands can grasp the object by the way of least trouble, the nearer grasp first; or the nearest miss."""
        misses: list[Miss] = []
        for results in self._by_way(index):
            hits = [result for result in results if isinstance(result, Hit)]
            if hits:
                yield from sorted(hits, key=lambda hit: hit.order)
                return
            misses += [result for result in results if isinstance(result, Miss)]
        self._grasp.failed = True
        miss = nearest_miss(misses)
        yield lambda: miss

    def _by_way(self, index: int) -> Iterator[list[Hit | Miss]]:
        """How each way succeeds from a candidate, or why not; the way of least trouble first."""
        grasp, candidate = self._grasp, self._candidates[index]
        shoulders = self._candidates.frames(index)[self._candidates.torso.frames.first_shoulder :]
        able = [self._plain.arms[column] for column in self._plain.able(index)]
        plain = grasp.plain.results(candidate, shoulders, able)
        yield plain
        # What is done to a thing first helps hands that get to it and find something in the way.
        pairs = zip(able, plain, strict=True)
        blocked = [arm for arm, miss in pairs if isinstance(miss, Miss) and miss.reason is Reason.NO_FREE_GRASP]
        if blocked and grasp.tilted is not None:
            yield grasp.tilted.results(candidate, shoulders, blocked)
        if self._between is not None and grasp.between is not None:
            both = [self._between.arms[column] for column in self._between.able(index)]
            yield grasp.between.results(candidate, shoulders, both) if len(both) == len(SIDES) else [ONLY_ONE]
        if blocked and grasp.slid is not None:
            yield grasp.slid.results(candidate, shoulders, blocked)
        if blocked and grasp.drawn is not None:
            yield grasp.drawn.results(candidate, shoulders, blocked)

    def miss(self) -> Miss | None:
        """Why no grasp is reached from the other candidates."""
        return self._plain.miss() if self._between is None or len(self._grasp.plain.grasps) else self._between.miss()
