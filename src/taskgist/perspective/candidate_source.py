"""The states that an agent might take from its current one, by effort level (5.1.4).

Which torso angles, postures and places are within reach is found once for all objects. Candidates come level by level,
from the least amount to the greatest; each level moves only its own joints:

====== =============================== ==========================================================================
level  effort (Fig. 6)                 candidates
====== =============================== ==========================================================================
0, 1   none; head, or arm              the current state
2      and torso                       turns and leans of the torso, shoulders thrust forward with them
3      whole body                      other postures, with turns and leans of the torso: standing up or sitting down,
                                       bending at the hips, crouching (``postures``)
4      displacement                    standing, bent or crouched, on every place of the floor that can be got to, the
                                       chest turned to the object, with leans of the torso (a turn would repeat that
                                       of the base)
====== =============================== ==========================================================================
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Protocol

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.perspective.candidates import (
    Candidate,
    Candidates,
    Frames,
    TorsoPose,
    TorsoPoses,
    Walk,
    torso_poses,
)
from taskgist.perspective.constraints import Collisions
from taskgist.perspective.effort import LEAN, MOVE, SIT, STAND, TURN, Amount, Miss, Reason
from taskgist.perspective.floor import Floor, Place
from taskgist.perspective.postures import bends, leaving_seat, seat_height_m
from taskgist.perspective.target import Recorder, Region, ball_around, touched
from taskgist.settings import Settings
from taskgist.world.bodies.agent import Agent
from taskgist.world.bodies.profile import Posture
from taskgist.world.geometry.transforms import yaw_of
from taskgist.world.stage import Stage, seat_position, with_posture
from taskgist.world.state import State

CLOSE_M = 1.0
"""Who gets no farther than this is shut in where he stands up (ours: a sofa and its table are as long, or longer)."""
AROUND_M, DEEP_M = 0.05, 100.0
"""How far around a line, and down to where, a seat is looked for."""
NO_CANDIDATE: Mapping[int, Miss] = {
    2: Miss(Reason.NO_TORSO, "the torso does not move"),
    3: Miss(Reason.NO_POSTURE, "no other posture to take"),
    4: Miss(Reason.NO_WALKING, "cannot move about"),
}
"""Why an effort level has nothing to try."""


class Situation(Protocol):
    """An agent in its current state, as ``viewpoint.Viewpoint`` has it."""

    stage: Stage
    agent: Agent
    state: State
    settings: Settings
    actions: frozenset[str]
    posture: Posture | None
    on_body: frozenset[str]
    recorder: Recorder

    @property
    def own(self) -> Indices:
        """Indices into qpos of where the agent is, and of its joints, (n,)."""

    def collisions_of(self, candidate: Candidate) -> Collisions:
        """What the agent would push into in states that a candidate leads to."""


class CandidateSource:
    """The states that an agent might take from its current one, by effort level.

    Args:
        here: The agent in its current state.

    Attributes:
        felt: Where was looked and felt for what stands in the way of other postures.
        shut: Where it was found out that an agent that sits does not get away from where it stands up; empty if it
            does.
        start: From where the agent walks, and
        floor: where it gets from there; None as long as nobody asked.
    """

    def __init__(self, here: Situation) -> None:
        self._here = here
        self._frames: dict[Candidate, Frames] = {}
        self._bent: dict[Candidate, list[Candidate]] = {}
        self._balls: dict[int, tuple[Array, float]] = {}
        self.felt, self.shut = Region(), Region()
        self.start: Candidate | None = None
        self.floor: Floor | None = None
        self._gets_away = True

    def follow(self, before: CandidateSource, moved: Array) -> bool:
        """Take over what was found in an earlier state, in which the agent was where it is.

        Args:
            before: The candidates of that state.
            moved: Boxes in which something else has moved, (k, 2, 3).

        Returns:
            Whether the agent can take the same postures as then; otherwise nothing is taken over.
        """
        known, here = before.__dict__, self._here
        if not touched(before.felt.bounds[None], moved)[0]:
            self.felt = before.felt
        elif not self._stands_as(known):
            return False
        starts = [*known.get("other_postures", ()), *before._frames, *before._bent]
        starts += [each for bent in before._bent.values() for each in bent]
        starts += [known[name] for name in ("other_posture", "upright") if known.get(name) is not None]
        starts += [before.start] if before.start is not None else []
        as_now = {id(each): self._now(each) for each in starts}
        as_now[id(known.get("current"))] = self.current
        for name in ("other_posture", "upright"):
            if name in known:
                self.__dict__[name] = as_now.get(id(known[name])) if known[name] is not None else None
        if "other_postures" in known:
            self.__dict__["other_postures"] = tuple(as_now[id(each)] for each in known["other_postures"])
        self._bent = {as_now[id(start)]: [as_now[id(each)] for each in bent] for start, bent in before._bent.items()}
        if before.floor is not None and not touched(before.shut.bounds[None], moved)[0]:
            self.start, self.floor = as_now[id(before.start)], before.floor
            self.shut, self._gets_away = before.shut, before._gets_away
            self.floor.note = here.recorder.add_ways
        self._frames = {as_now[id(start)]: frames for start, frames in before._frames.items()}
        self._balls = before._balls
        return True

    def _stands_as(self, known: Mapping[str, Candidate | None]) -> bool:
        """Whether the agent stands up and sits down as in an earlier state, as far as that is known."""
        own = self._here.own
        for name in ("other_posture", "upright"):
            if name in known and not _same(known[name], getattr(self, name), own):
                return False
        return "upright" not in known or self.upright is not None  # what keeps it from standing is told

    def _now(self, each: Candidate) -> Candidate:
        """A candidate of an earlier state in the present one, in which others are elsewhere."""
        here = self._here
        qpos = np.array(here.state.qpos)
        qpos[here.own] = each.state.qpos[here.own]
        return replace(each, state=here.state.replace(at=slice(None), to=qpos))

    def of_level(self, level: int, target: Array) -> Iterator[Candidates]:
        """Candidates of an effort level, by increasing amount, in batches.

        Args:
            level: Effort level, 0 to 4.
            target: Where the object is, metres, (3,): agents that walk turn to it.
        """
        if level <= 1:
            yield self._current
        elif level == 2:
            yield self._with_torso
        elif level == 3:
            self._here.recorder.postures = True
            yield from self._in_other_postures
        elif level == 4 and MOVE in self._here.actions:
            self._here.recorder.postures = True
            if self.walk is not None:
                self._note_start()
                yield from self.walk.candidates(target)

    def shoulders_ball(self, level: int) -> tuple[Array, float]:
        """A ball that holds the shoulders in all candidates of a level from 1 to 3: middle, (3,), and radius."""
        if level not in self._balls:
            batches = ([self._current], [self._with_torso], self._in_other_postures)[level - 1]
            frames = [each.torso.rows[:, each.torso.frames.first_shoulder :, :3].reshape(-1, 3) for each in batches]
            self._balls[level] = ball_around(np.concatenate([*frames, np.empty((0, 3))]))
        return self._balls[level]

    def why_none(self, level: int) -> Miss:
        """Why an effort level has no candidates."""
        here = self._here
        if level == 4 and MOVE in here.actions and here.posture == "sitting" and self.other_posture is not None:
            blocking = here.collisions_of(self.other_posture).blocking(self.other_posture.state)
            return Miss(Reason.NO_STANDING, f"{STAND} is blocked: {blocking}", hindrance=blocking)
        return NO_CANDIDATE[level]

    @cached_property
    def current(self) -> Candidate:
        """The current state."""
        return Candidate(self._here.state)

    @cached_property
    def other_posture(self) -> Candidate | None:
        """The agent after standing up, or sitting down if there is a seat; None if it cannot. It may collide."""
        here = self._here
        stage = here.stage.show(here.state)
        if here.posture == "sitting" and STAND in here.actions:
            return Candidate(with_posture(stage, here.agent, "standing"), (STAND,), aside=here.on_body)
        if here.posture == "standing" and SIT in here.actions:
            seat = seat_height_m(stage, here.agent, here.settings.efforts)
            x, y = seat_position(stage, here.agent).tolist()
            self.felt.add_points(np.array([(x, y, here.settings.efforts.seat_height_m[1]), (x, y, -DEEP_M)]), AROUND_M)
            if seat is not None:
                state = with_posture(stage, here.agent, "sitting", seat_height_m=seat)
                lowered_m = float(here.state.qpos[here.agent.base][2] - state.qpos[here.agent.base][2])
                return Candidate(state, (SIT,), Amount(lowered_m=lowered_m), here.on_body)
        return None

    @cached_property
    def upright(self) -> Candidate | None:
        """The agent standing, free of collisions, ready to walk; None if it cannot be."""
        here, standing = self._here, self.other_posture
        if here.posture == "standing":
            return Candidate(here.state, aside=here.on_body) if here.on_body else self.current
        with here.recorder.apart() as tried:
            found = standing
            if standing is not None and here.collisions_of(standing).blocking(standing.state) is not None:
                self.felt.add(self._seat_region())
                found = next(self._ways_out(), None)
        self.felt.add(tried)
        return found

    def _ways_out(self) -> Iterator[Candidate]:
        """The agent after getting up where it does not simply stand up, if it is free there; the least way first."""
        here = self._here
        for way in leaving_seat(here.stage.show(here.state), here.agent, here.settings.efforts, here.actions):
            there = replace(way, aside=way.aside | here.on_body)
            if here.collisions_of(there).blocking(there.state) is None:
                yield there

    def _bends(self, start: Candidate) -> list[Candidate]:
        """What the agent does standing."""
        if start not in self._bent:
            here = self._here
            self._bent[start] = list(bends(here.stage, here.agent, start, here.settings.efforts, here.actions))
        return self._bent[start]

    @cached_property
    def other_postures(self) -> tuple[Candidate, ...]:
        """All other postures, the least first; they may collide."""
        here, upright = self._here, self.upright
        found = [self.other_posture] if self.other_posture else []
        if upright is not None:
            found += [upright] if here.posture == "sitting" and upright is not self.other_posture else []
            found += self._bends(upright)
        return tuple(sorted(found, key=lambda posture: posture.amount.key))

    @cached_property
    def walk(self) -> Walk | None:
        """Where the agent can go; None if it cannot walk."""
        here = self._here
        if MOVE not in here.actions or self.upright is None:
            return None
        if self.floor is None or self._leads_on(self.floor) != self._gets_away:
            self._choose_start(self.upright)
        assert self.start is not None
        assert self.floor is not None
        agent, start, axis = here.agent, self.start, here.agent.profile.turn
        poses = self._poses(here.actions - {TURN})
        torso = [self._torso(each, poses) for each in (start, *self._bends(start))]
        turned_rad = float(here.state.qpos[agent.joints[axis.joint]]) if axis else 0.0
        return Walk(torso, yaw_of(start.state.qpos[agent.base][3:]) + turned_rad, self.floor)

    def _choose_start(self, upright: Candidate) -> None:
        """Find out from where the agent walks: from where it stands up, unless it is shut in there.

        As between a sofa and its table: people move along the seat to where they get away.
        """
        here, self.shut = self._here, Region()
        start, floor = upright, self._floor(upright)
        self._gets_away = self._leads_on(floor)
        if not self._gets_away:
            self.shut.add(self._seat_region())
            self.shut.add(self._tried_over(start, floor))
            with here.recorder.apart() as tried:
                for way in self._ways_out():
                    beside = self._floor(way)
                    if self._leads_on(beside):
                        start, floor, self._gets_away = way, beside, True
                        break
                    self.shut.add(self._tried_over(way, beside))
            self.shut.add(tried)
        self.start, self.floor = start, floor
        self.floor.note = here.recorder.add_ways

    def _leads_on(self, floor: Floor) -> bool:
        """Whether an agent gets away over a floor; who stands stays there."""
        return self._here.posture != "sitting" or floor.first_beyond(CLOSE_M) is not None

    def _note_start(self) -> None:
        """Note what it depends on from where the agent walks."""
        here = self._here
        if here.posture == "sitting" and self.floor is not None:
            shut = Region()
            shut.add(self.shut)
            here.recorder.add_body(shut)
            beyond = self.floor.first_beyond(CLOSE_M)
            if beyond is not None:
                here.recorder.found_after(beyond.way_m)

    def _floor(self, start: Candidate) -> Floor:
        """Where the agent can get to, once it stands."""
        here = self._here
        here.stage.show(start.state)
        return Floor(start.state, here.agent, here.settings.efforts, here.collisions_of(start).footprint())

    def _tried_over(self, start: Candidate, floor: Floor) -> Region:
        """Where it was felt for what stands in the way over a floor."""
        region = self._here.collisions_of(start).filled(start.state)
        offsets = np.array([floor.offset_m(*cell) for cell in floor.free_at]).reshape(-1, 2)
        region.bounds[0, :2] += offsets.min(axis=0, initial=0.0)
        region.bounds[1, :2] += offsets.max(axis=0, initial=0.0)
        return region

    @property
    def untried(self) -> str | None:
        """What was left out of the candidates that were made; None if nothing was."""
        if self.__dict__.get("walk") is None or self.walk is None or not self.walk.floor.goes_on:
            return None
        return f"going farther than {self._here.settings.efforts.move_radius_m:g} m"

    @property
    def places(self) -> tuple[Place, ...]:
        """All places that the agent can get to; none if it cannot walk."""
        return () if self.walk is None else tuple(place for batch in self.walk.floor.batches() for place in batch)

    def floor_goes_on(self, moved: Array) -> float:
        """Find out how the floor changed that was taken over when something moved within boxes, (k, 2, 3).

        Returns:
            How far the nearest change is, metres; infinite if there is none.
        """
        here = self._here
        if self.floor is None or self.start is None:
            return math.inf
        collisions = here.collisions_of(self.start)
        filled = collisions.filled(self.start.state).bounds
        here.stage.show(self.start.state)
        return self.floor.go_on(collisions.footprint(), filled, moved)

    def _seat_region(self) -> Region:
        """Where it is tried to leave a seat."""
        region, here = Region(), self._here
        efforts = here.settings.efforts
        around_m = efforts.sliding_seat_m + efforts.leaving_seat_m
        region.add_points(here.stage.show(here.state).geom_centers(here.agent.geoms), around_m)
        return region

    @cached_property
    def _current(self) -> Candidates:
        return Candidates(self._torso(self.current, [TorsoPose()], thrusts=False))

    @cached_property
    def _with_torso(self) -> Candidates:
        return Candidates(self._torso(self.current, [pose for pose in self._poses(self._here.actions) if pose.actions]))

    @cached_property
    def _in_other_postures(self) -> list[Candidates]:
        poses = self._poses(self._here.actions)
        return [Candidates(self._torso(posture, poses)) for posture in self.other_postures]

    def _poses(self, actions: frozenset[str]) -> list[TorsoPose]:
        return torso_poses(self._here.agent, self._here.state, self._here.settings.efforts, actions)

    def _torso(self, start: Candidate, poses: Sequence[TorsoPose], *, thrusts: bool = True) -> TorsoPoses:
        here = self._here
        thrusts = thrusts and not here.actions.isdisjoint((TURN, LEAN))
        if start not in self._frames:
            self._frames[start] = Frames(here.stage.show(start.state), here.agent)
        return TorsoPoses.of(here.agent, start, self._frames[start], poses, thrusts=thrusts)


def _same(one: Candidate | None, other: Candidate | None, own: Indices) -> bool:
    """Whether two candidates of two states are the same for the agent, whose positions are ``own``."""
    if one is None or other is None:
        return one is other
    told = [(each.actions, each.amount, each.aside) for each in (one, other)]
    return told[0] == told[1] and np.array_equal(one.state.qpos[own], other.state.qpos[own])
