"""A standpoint: one agent in one state, and all that it might do from there (5.1.4).

What does not depend on the object is found once here: which contacts are usual, which torso angles, postures and
places are within reach. Stances come level by level, from the least amount to the greatest; each level moves only its
own joints:

====== =============================== ==========================================================================
level  effort (Fig. 6)                 stances
====== =============================== ==========================================================================
0, 1   none; head, or arm              the current one
2      and torso                       turns and leans of the torso
3      whole body                      the other posture, with turns and leans of the torso
4      displacement                    standing, on every place of the floor that can be got to, the chest turned to
                                       the object, with leans of the torso (a turn would repeat that of the base)
====== =============================== ==========================================================================

What an agent holds stays where it is in all of them: a held object can be reached and grasped without effort anyway,
and arms can keep it in place while the torso moves.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array
from taskgist.perspective.actions import MOVE, SIT, STAND, TURN, Bend, Stance, bends_of, checked_actions, seat_height_m
from taskgist.perspective.candidates import Bent, Frames, Stances, Walk
from taskgist.perspective.collisions import Blocking, Collisions, Consulted, Region, held_by
from taskgist.perspective.effort import Miss
from taskgist.perspective.floor import NOTHING, Floor, Place
from taskgist.settings import DEFAULT, Settings
from taskgist.world.bodies.agent import Agent
from taskgist.world.bodies.profile import Posture
from taskgist.world.contacts import object_points
from taskgist.world.geometry.transforms import yaw_of
from taskgist.world.holding import objects_near
from taskgist.world.postures import posture_of, with_posture
from taskgist.world.stage import Stage
from taskgist.world.state import State

# --- The object that an ability is asked about, as it is in one state: what its judges need of it, found once.

SIGNS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)


class Sought(NamedTuple):
    """An object that is looked for, as compiled functions take it.

    Attributes:
        shapes: Its seen shapes, (n,).
        centers: Their centres, metres, (n, 3).
        radii_m: Radii of balls about these that hold the shapes, (n,).
        corners: Corners of the boxes around them, metres, (8 n, 3).
        middle: Mean of the centres, (3,).
    """

    shapes: NDArray[np.intp]
    centers: Array
    radii_m: Array
    corners: Array
    middle: Array


class Target:
    """An object where it is. It may be asked while the stage shows other states of some agent: objects stay.

    Args:
        stage: The scene.
        name: The object.
        settings: Size of the cells.
    """

    def __init__(self, stage: Stage, name: str, settings: Settings) -> None:
        self._stage, self.name, self._settings = stage, name, settings
        self.shapes = stage.scene.seen_geoms(name)

    @cached_property
    def centers(self) -> Array:
        """Centres of its seen shapes, metres, (n, 3)."""
        return self._stage.geom_centers(self.shapes)

    @cached_property
    def radii_m(self) -> Array:
        """Radii of balls about these that hold the shapes, (n,)."""
        return np.asarray(self._stage.scene.model.geom_rbound[self.shapes])

    @cached_property
    def middle(self) -> Array:
        """Mean of the centres, metres, (3,)."""
        return np.asarray(self.centers.mean(axis=0))

    @cached_property
    def points(self) -> Array:
        """Points of its cells, metres, (k, 3)."""
        return object_points(self._stage, self.name, self._settings.reach.cell_m)

    @cached_property
    def corners(self) -> Array:
        """Corners of the boxes around its seen shapes, metres, (8 n, 3)."""
        bounds = self._stage.scene.model.geom_aabb[self.shapes]
        local = bounds[:, None, :3] + SIGNS * bounds[:, None, 3:]
        positions, matrices = self._stage.geoms(self.shapes)
        turned = local @ matrices.reshape(-1, 3, 3).transpose(0, 2, 1)
        return np.asarray((turned + positions[:, None]).reshape(-1, 3))

    @cached_property
    def sought(self) -> Sought:
        """For those who look for it."""
        return Sought(self.shapes, self.centers, self.radii_m, self.corners, self.middle)

    @cached_property
    def others(self) -> NDArray[np.intp]:
        """All other seen shapes of the scene, (m,)."""
        counted = self._stage.seen.copy()
        counted[self.shapes] = False
        return np.flatnonzero(counted)


AROUND_M = 0.6
"""How far around an agent a seat may be, at most: a thigh behind its feet."""
NO_STANCE = {2: "the torso does not move", 3: "no other posture to take", 4: "cannot move about"}
"""Why an effort level has nothing to try."""


class Standpoint:
    """An agent in the state that a stage shows.

    Things and agents that were not tracked stand where their fillers in the state put them.

    Args:
        stage: The scene in a state. It is borrowed for trying other states, and always shows the same one afterwards.
        agent: Name of the agent.
        settings: All settings.
        actions: The virtual actions that the agent may use; all that it has if left out.
        known_floor: Where it is known already that the agent could stand, or not, by cell of its ``Floor``.
        targets: Objects as they are now, by name, as far as others of this stage asked for them.

    Attributes:
        held: The side of the hand that holds each object that the agent holds.
        sights: What the agent sees of objects in its state, by name, as far as it was asked.
        consulted: Where all was looked or felt for since ``consult_anew``, but for the floor.
        walked: Whether the floor was asked for since then.

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
        known_floor: Mapping[tuple[float, float], bool] = NOTHING,
        targets: dict[str, Target] | None = None,
    ) -> None:
        self.stage, self.settings = stage, settings
        self.agent: Agent = stage.scene.agent(agent)
        self.state: State = stage.state
        self.actions = checked_actions(self.agent, actions)
        self._targets = {} if targets is None else targets
        near = objects_near(stage, self.agent, settings.contact)
        self.held: Mapping[str, str] = held_by(stage, self.agent, near, settings.contact)
        self.collisions = Collisions(stage, self.agent, settings, self.held)
        self.sights: dict[str, Any] = {}
        self._frames: dict[tuple[str, ...], Frames] = {}
        self._own = self._own_region(near)
        self._known_floor = known_floor
        self.consulted, self.walked = Consulted(self._own), False
        self.posture: Posture | None = posture_of(stage, self.agent, settings.contact)

    def consult_anew(self) -> None:
        """Begin a new answer: ``consulted`` is the region in which it will have been found."""
        self.consulted, self.walked = Consulted(self._own), False

    def _own_region(self, near: Iterable[str]) -> Region:
        """Where the agent is, and what it holds or might hold: with whose contacts others are compared."""
        region, own, contact = Region(), self.agent.geoms, self.settings.contact
        region.add_balls(self.stage.geom_centers(own), self.stage.scene.model.geom_rbound[own])
        region.grow(contact.grip_m)
        for name in near:
            thing = self.target(name)
            region.add_balls(thing.centers, thing.radii_m + contact.container_m)
        return region

    def _seat_region(self) -> Region:
        """Where a seat is looked for."""
        region = Region()
        region.add_points(self.stage.show(self.state).geom_centers(self.agent.geoms), AROUND_M)
        return region

    def blocked(self, state: State) -> Blocking | None:
        """What the agent would push into in a state; None if nothing. The stage shows that state afterwards."""
        self.stage.show(state)
        region = Region()
        self.collisions.add_to(region)
        self.consulted.add_body(region)
        return self.collisions.find()

    def stances(self, level: int, target: Array) -> Iterator[Stances]:
        """Stances of an effort level, by increasing amount, in batches.

        Args:
            level: Effort level, 0 to 4.
            target: Where the object is, metres, (3,): agents that walk turn to it.
        """
        if level <= 1:
            yield self._here_alone
        elif level == 2:
            yield self._bent_here
        elif level == 3:
            self.consulted.add_body(self._seat_region())
            if self.other_posture is not None:
                yield self._bent_other
        elif level == 4:
            yield from self._displaced(target)

    def no_stance(self, level: int) -> Miss:
        """Why an effort level has no stances."""
        if level == 4 and MOVE in self.actions and self.posture == "sitting" and self.other_posture is not None:
            blocking = self.blocked(self.other_posture.state)
            return Miss(math.inf, f"{STAND} is blocked: {blocking}", blocking.as_miss if blocking else dict)
        return Miss(math.inf, NO_STANCE[level])

    def target(self, name: str) -> Target:
        """An object as it is now."""
        if name not in self._targets:
            self._targets[name] = Target(self.stage, name, self.settings)
        return self._targets[name]

    @cached_property
    def here(self) -> Stance:
        """Where the agent is."""
        return Stance(self.state)

    @cached_property
    def is_own(self) -> NDArray[np.bool_]:
        """Whether each shape of the scene is the agent's, (ngeom,)."""
        own = np.zeros(self.stage.scene.model.ngeom, dtype=np.bool_)
        own[self.agent.geoms] = True
        return own

    @property
    def first_shoulder(self) -> int:
        """Which of the agent's frames is the first arm's shoulder."""
        return self._frames_of(self.here).first_shoulder

    @cached_property
    def other_posture(self) -> Stance | None:
        """The agent after standing up, or sitting down if there is a seat; None if it cannot. It may collide."""
        if self.posture == "sitting" and STAND in self.actions:
            return Stance(with_posture(self._shown(), self.agent, "standing"), (STAND,))
        if self.posture == "standing" and SIT in self.actions:
            seat = seat_height_m(self._shown(), self.agent, self.settings.efforts)
            if seat is not None:
                return Stance(with_posture(self._shown(), self.agent, "sitting", seat_height_m=seat), (SIT,))
        return None

    @cached_property
    def upright(self) -> Stance | None:
        """The agent standing, free of collisions, ready to walk; None if it cannot be."""
        if self.posture == "standing":
            return self.here
        standing = self.other_posture
        return standing if standing is not None and self.blocked(standing.state) is None else None

    @cached_property
    def _here_alone(self) -> Stances:
        return Stances(self._bent(self.here, [Bend()]))

    @cached_property
    def _bent_here(self) -> Stances:
        bends = [bend for bend in self._bends(self.actions) if bend.actions]
        return Stances(self._bent(self.here, bends))

    @cached_property
    def _bent_other(self) -> Stances:
        assert self.other_posture is not None
        return Stances(self._bent(self.other_posture, self._bends(self.actions)))

    def _displaced(self, target: Array) -> Iterator[Stances]:
        if MOVE not in self.actions:
            return
        if self.other_posture is not None and self.posture == "sitting":
            self.consulted.add_body(self._filled(self.other_posture))
        if self.walk is not None:
            self.walked = True
            yield from self.walk.stances(target)

    @cached_property
    def walk(self) -> Walk | None:
        """Where the agent can go; None if it cannot walk."""
        if MOVE not in self.actions or self.upright is None:
            return None
        agent, state, axis = self.agent, self.upright.state, self.agent.profile.turn
        bent = self._bent(self.upright, self._bends(self.actions - {TURN}))
        self.stage.show(state)
        floor = Floor(state, agent, self.settings.efforts, self.collisions.footprint(), self._known_floor)
        turned_rad = float(self.state.qpos[agent.joints[axis.joint]]) if axis else 0.0
        return Walk(bent, yaw_of(state.qpos[agent.base][3:]) + turned_rad, floor)

    @property
    def floor_places(self) -> tuple[Place, ...]:
        """All places that the agent can get to; none if it cannot walk."""
        return () if self.walk is None else self.walk.places

    def floor_after(self, moved: Array) -> dict[tuple[float, float], bool]:
        """What is known of the floor and stays so when something moved within boxes, (k, 2, 3)."""
        if self.__dict__.get("walk") is None or self.upright is None:
            return {}
        assert self.walk is not None
        return self.walk.floor.known_after(self._filled(self.upright).bounds, moved)

    def _filled(self, stance: Stance) -> Region:
        """What the agent's head, torso and base fill in a stance."""
        region = Region()
        self.stage.show(stance.state)
        self.collisions.add_to(region)
        return region

    def _bends(self, actions: frozenset[str]) -> list[Bend]:
        return bends_of(self.agent, self.state, self.settings.efforts, actions)

    def _bent(self, start: Stance, bends: Sequence[Bend]) -> Bent:
        return Bent.of(self.agent, start, self._frames_of(start), bends)

    def _frames_of(self, stance: Stance) -> Frames:
        key = stance.actions
        if key not in self._frames:
            self._frames[key] = Frames(self.stage.show(stance.state), self.agent)
        return self._frames[key]

    def _shown(self) -> Stage:
        return self.stage.show(self.state)
