"""A viewpoint: one agent in one state, with what does not depend on the object that it is asked about.

That is which contacts are usual, what it holds and wears, and the states that it might take from there
(``candidate_source``).

What an agent holds stays where it is in all of them: a held object can be reached and grasped without effort anyway,
and arms can keep it in place while the torso moves.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np

from taskgist.common.arrays import Indices, Mask
from taskgist.perspective.candidate_source import CandidateSource
from taskgist.perspective.candidates import Candidate, Candidates, checked_actions
from taskgist.perspective.constraints import Collisions, held_by, near_body, wears
from taskgist.perspective.effort import Attained, Miss, Visibility, stretch
from taskgist.perspective.image import Sight, look, measured
from taskgist.perspective.target import Recorder, Target
from taskgist.settings import DEFAULT, Settings
from taskgist.world.bodies.agent import Agent
from taskgist.world.bodies.profile import Posture
from taskgist.world.contacts import holding_of, objects_near
from taskgist.world.stage import Stage, posture_of
from taskgist.world.state import State


class Viewpoint:
    """An agent in the state that a stage shows, with what its abilities towards all objects share.

    Things and agents that were not tracked stand where their fillers in the state put them.

    Args:
        stage: The scene in a state. It is borrowed for trying other states, and always shows the same one afterwards.
        agent: Name of the agent.
        settings: All settings.
        actions: The virtual actions that the agent may use; all that it has if left out.
        targets: Objects as they are now, by name, as far as others of this stage asked for them.

    Attributes:
        posture: Standing or sitting; None if unknown.
        held: The side of the hand that holds each object that the agent holds.
        recorder: Where all was looked or felt for since it was told to ``begin``.
        collisions: What the agent would push into in other states.

    Raises:
        UnknownNameError: There is no such agent, or it has no such action.
    """

    def __init__(
        self,
        stage: Stage,
        agent: str,
        settings: Settings = DEFAULT,
        *,
        actions: Iterable[str] | None = None,
        targets: dict[str, Target] | None = None,
    ) -> None:
        self.stage, self.settings = stage, settings
        self.agent: Agent = stage.scene.agent(agent)
        self.state: State = stage.state
        self.actions = checked_actions(self.agent, actions)
        self._targets = {} if targets is None else targets
        self._sights: dict[str, Sight] = {}
        near = objects_near(stage, self.agent, settings.contact)
        self.held: Mapping[str, str] = held_by(stage, self.agent, near, settings.contact)
        touching = near_body(stage, self.agent, settings.contact)
        self.on_body = frozenset(name for name in touching if wears(stage, self.agent, name, settings.contact))
        self.recorder = Recorder()
        self.collisions = Collisions(stage, self.agent, settings, self.held, self.recorder)
        self._without: dict[frozenset[str], Collisions] = {}
        self.posture: Posture | None = posture_of(stage, self.agent, settings.contact)

    @property
    def contacts(self) -> tuple[Mapping[str, str], frozenset[str], Mapping[tuple[int, int], float], Posture | None]:
        """What the agent holds and wears, what it touches how deep, and its posture: all answers stand on these."""
        return self.held, self.on_body, self.collisions.usual_m, self.posture

    def collisions_of(self, candidate: Candidate) -> Collisions:
        """What the agent would push into in states that a candidate leads to."""
        aside = candidate.aside
        if not aside:
            return self.collisions
        if aside not in self._without:
            stage, out = self.stage.show(self.state), {*self.held, *aside}
            self._without[aside] = Collisions(stage, self.agent, self.settings, out, self.recorder)
        return self._without[aside]

    @cached_property
    def candidates(self) -> CandidateSource:
        """The states that the agent might take."""
        return CandidateSource(self)

    @cached_property
    def own(self) -> Indices:
        """Indices into qpos of where the agent is, and of its joints, (n,)."""
        joints = np.array(list(self.agent.joints.values()), dtype=np.intp)
        return np.concatenate((np.arange(self.agent.base.start, self.agent.base.stop), joints))

    @cached_property
    def is_own(self) -> Mask:
        """Whether each shape of the scene is the agent's, (ngeom,)."""
        own = np.zeros(self.stage.scene.model.ngeom, dtype=np.bool_)
        own[self.agent.geoms] = True
        return own

    def target(self, name: str) -> Target:
        """An object as it is now."""
        if name not in self._targets:
            self._targets[name] = Target(self.stage, name, self.settings)
        return self._targets[name]

    def untracked(self, parts: tuple[str, ...]) -> str | None:
        """Sentence about those parts of the agent that were not tracked; None if all were."""
        if not self.state.untracked:
            return None
        if "head" in parts and not self.agent.profile.eye.sees:
            return f"{self.agent.name} has no eye"
        lost = [part for part in parts if not self.state.known([f"{self.agent.name}/{part}"])]
        return f"{self.agent.name}'s {' and '.join(lost)} not tracked" if lost else None

    def look(self, target: Target, state: State, *, cone_rad: float = math.pi) -> Sight:
        """Look at an object in a state of the agent; the stage shows that state afterwards.

        Args:
            target: The object.
            state: The state.
            cone_rad: Half-angle of a cone about the gaze outside of which nothing is looked at.
        """
        return self._noted(target, look(self.stage.show(state), self.agent, target, cone_rad=cone_rad))

    def sight(self, target: Target) -> Sight:
        """What the agent sees of an object in its current state; looked at once."""
        if target.name not in self._sights:
            self._sights[target.name] = look(self.stage.show(self.state), self.agent, target)
        return self._noted(target, self._sights[target.name])

    def _noted(self, target: Target, sight: Sight) -> Sight:
        self.recorder.target.add_balls(target.centers, target.radii_m)
        self.recorder.eyes.add_points(sight.eye[None, :3])
        return sight

    def visibility(self, name: str) -> Visibility | None:
        """How much of an object the agent sees from its current state.

        Returns:
            None where the object or the agent's head was not tracked: that is unknown, not invisible.

        Raises:
            UnknownNameError: There is no such object.
        """
        self.stage.scene.object_body(name)
        if not self.state.known([name, f"{self.agent.name}/head"]):
            return None
        target = self.target(name)
        return measured(self.stage, self.agent, target, self.sight(target))

    def is_supported(self, target: Target) -> bool:
        """Whether an object is known to rest on something, or to lie in something."""
        contact = self.settings.contact
        self.recorder.target.add_balls(target.centers, target.radii_m + contact.container_m)
        holding = holding_of(self.stage.show(self.state), target.name, contact)
        return holding is not None and bool(holding.support or holding.container)


# --- What the judges of the three abilities share: how candidates are screened, and what comes of it.


@dataclass(frozen=True, eq=False)
class Hit:
    """How the ability holds from a candidate.

    Attributes:
        angles_rad: Angles of the head, or of what thrusts shoulders forward, by index into qpos, in the attained
            state; the others are the candidate's.
        actions: Virtual actions after those of the candidate, in order.
        head_rad: How far the head turned, radians.
        cost: Decides between equal amounts: the least is taken. Less of what is seen, or farther from the shoulder.
        thrusts: Whether a shoulder is thrust forward.
        find_evidence: Finds what shows it; only asked of the hit that is chosen.
    """

    find_evidence: Callable[[], Attained]
    angles_rad: Mapping[int, float] = field(default_factory=dict)
    actions: tuple[str, ...] = ()
    head_rad: float = 0.0
    cost: float = 0.0
    thrusts: bool = False

    @property
    def order(self) -> tuple[bool, float, bool]:
        """Shoulders at rest first, then the least cost; of equal hands the right one, as with most people."""
        return self.thrusts, self.cost, stretch("left") in self.actions


FindMiss = Callable[[], Miss]
"""Finds why the ability does not hold; only asked if somebody wants to know."""


class Screening(Protocol):
    """Candidates of one batch, passed over quickly where the ability surely does not hold."""

    def next(self, start: int, stop: int) -> int:
        """The first candidate from ``start`` on from which the ability may hold; ``stop`` if none before it does."""

    def results(self, index: int) -> Iterator[Hit | FindMiss]:
        """How it holds from that candidate, best first; or why it does not."""

    def miss(self) -> Miss | None:
        """Why it does not hold from those passed over: the nearest miss; None if there were none. Asked at last."""


class Judge(Protocol):
    """Judges one ability towards one object. The stage may show anything before and after each call.

    Attributes:
        brief: Whether only the level and how it is attained are asked for, not why it is not with less.
    """

    brief: bool

    @property
    def hopeless(self) -> bool:
        """Whether no candidate gives the ability, as far as is known by now."""

    def passes_over(self, level: int) -> bool:
        """Whether the ability surely holds from no candidate of a level; false where that is not clear at once."""

    target: Target
    """The object."""

    def unknown(self, level: int) -> str | None:
        """Why nothing can be said at an effort level, for want of tracking; None if something can."""

    def without_effort(self) -> Hit | FindMiss:
        """Level 0: whether the ability holds in the current state."""

    def screen(self, candidates: Candidates) -> Screening:
        """Look through candidates."""
