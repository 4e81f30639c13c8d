"""Collisions of a whole robot and of what it holds, in any configuration: with the room, with others, with itself.

Perspective asks whether head, torso and base push into something, for anybody who might do something. Who plans a
motion asks it of every link, a thousand times: boxes are held against boxes first, for all pairs at once, and MuJoCo
measures what they leave.

Some links overlap without anybody doing anything, for links are collided as their convex hulls, which are larger than
they are. Therefore a pair of the robot's own shapes counts

- never, if nothing moves one against the other, a joint joins them, or both are of one hand;
- never, if they overlap at the neutral configuration and in most of 300 drawn over the joints' ranges;
- else, where they are deeper by more than a tolerance than at the model's neutral configuration, and than at rest.

A robot that begins in something is bad input: no way leads out of it. So is a thing that is deeper than ``SUNK_M`` in
what carries it: things do not lie like that.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.common.compiled import compiled
from taskgist.errors import SceneError
from taskgist.perspective.constraints import part_of
from taskgist.perspective.effort import Blocking
from taskgist.world.bodies.agent import Agent, subtree
from taskgist.world.geometry.distances import may_be_near
from taskgist.world.geometry.transforms import Pose, matrix_from_wxyz, wxyz_from_matrix
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State

TOLERANCE_M = 0.001
"""What overlaps deeper than usual by more than this collides (ours: half of what an audit of motions lets pass)."""
ROUNDING_M = 2e-4
"""By how much more than that a robot may begin in something."""
SUNK_M = 0.003
"""How deep a thing may be in what carries it (ours: audits let 4 mm pass, and planning needs one of them)."""
IN_HAND_M = 0.005
"""How deep a hand may be in what it holds (measured: fingers that close on a thing by their pads are, as the hulls that
they are collided as, up to 4.5 mm in it: those of a PR2 on cubes; those of grasps through a wall 20 mm and more)."""
SAMPLES, MOST_SHARE, SEED, NAMED = 300, 0.5, 0, 3
Pair = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Grip:
    """A thing in a hand, to which it is fixed.

    Attributes:
        thing: Its name.
        side: The hand's side.
        in_palm: The thing's body in the palm's frame: position in metres, and matrix.
        usual_m: How deep its shapes are in others where it lies before or after, metres, by pairs of shapes.
    """

    thing: str
    side: str
    in_palm: Pose
    usual_m: Mapping[Pair, float] = field(default_factory=dict)


class WholeBody:
    """Finds what a robot, and what it holds, would push into.

    Args:
        scene: The scene.
        agent: The robot.
        start: How it begins.

    Attributes:
        scene: As given.
        agent: As given.
        start: As given.
        stage: The scene as it was shown last.
        own: The robot's solid shapes, (n,).

    Raises:
        SceneError: It begins in something.
    """

    def __init__(self, scene: Scene, agent: Agent, start: State) -> None:
        self.scene, self.agent = scene, agent
        self.stage = stage = Stage(scene, start)
        self.start = stage.state
        self.own: Indices = np.intersect1d(agent.geoms, scene.solid_geoms)
        self._others = np.setdiff1d(stage.solid_geoms(), agent.geoms)
        self._things = {name: scene.solid_geoms_of(name) for name in scene.objects}
        others = (scene.agent(name) for name in scene.agents if name != agent.name)
        hands = [arm.hand_geoms for other in others for arm in other.arms]
        self._others_hands = np.concatenate([np.empty(0, dtype=np.intp), *hands])
        possible, usual_m = own_pairs(scene, agent, self.own)
        self._own_pairs = possible
        self._usual_m: dict[Pair, float] = {
            (int(self.own[a]), int(self.own[b])): depth_m for (a, b), depth_m in usual_m.items()
        }
        stage.show(self.start)
        self._refuse_a_start_in_something()
        planes = [int(geom) for geom in self._others if stage.is_plane(int(geom))]
        self._on_floor = self._always_level(planes)

    def _refuse_a_start_in_something(self) -> None:
        deep: dict[tuple[str, str], float] = {}
        others, things = self.stage.near_pairs(self.own, self._others, limit_m=0.0), self.scene.objects_geoms
        hands = np.concatenate([arm.hand_geoms for arm in self.agent.arms])
        for geom, other in (*others, *map(tuple, self._near_own().tolist())):
            depth_m = -self.stage.distance(geom, other, limit_m=0.0)
            if geom in hands and other in things and 0.0 < depth_m <= IN_HAND_M:
                self._usual_m[geom, other] = depth_m
            elif depth_m > self._usual_m.get((geom, other), 0.0) + TOLERANCE_M + ROUNDING_M:
                pair = part_of(self.stage, self.agent, geom), self.called(other)
                deep[pair] = max(depth_m, deep.get(pair, 0.0))
        if deep:
            worst = sorted(deep.items(), key=lambda each: (-each[1], each[0]))[:NAMED]
            texts = [f"{part} is {1000 * depth_m:.0f} mm deep in {other}" for (part, other), depth_m in worst]
            own = all(other.startswith(f"{self.agent.name}/") for _, other in deep)
            raise SceneError(
                f"{self.agent.name} begins in {'itself' if own else 'something'}: {', '.join(texts)}",
                where=self.scene.name,
                field=f"agents.{self.agent.name}",
                hint="give its arms other joint values" if own else "place it elsewhere, or what it stands in",
            )

    def blocking(self, qpos: Array, grip: Grip | None = None, *, taken_by: Indices | None = None) -> Blocking | None:
        """The first pair that collides in a configuration; None if it is free.

        Args:
            qpos: Positions of the whole scene, (nq,).
            grip: What the robot holds: that goes where the hand goes, wherever ``qpos`` has it.
            taken_by: Shapes of another hand, which comes to what the robot holds.
        """
        self.show(qpos, grip)
        return self._first(grip, taken_by)

    def show(self, qpos: Array, grip: Grip | None = None) -> Stage:
        """The stage in a configuration, with the thing in the hand that holds it."""
        stage = self.stage.show(State(qpos, untracked=self.start.untracked))
        return stage if grip is None else stage.show(State(self.carried(stage, grip), untracked=self.start.untracked))

    def carried(self, stage: Stage, grip: Grip) -> Array:
        """The positions that the stage shows, (nq,), but with the thing in the hand that holds it."""
        palm = stage.site(self.agent.arm(grip.side).palm_site)
        qpos = np.array(stage.state.qpos)
        turn = wxyz_from_matrix(palm.matrix @ grip.in_palm.matrix)
        qpos[self.scene.object_slice(grip.thing)] = (*palm.to_world(grip.in_palm.position), *turn)
        return qpos

    def grip(self, qpos: Array, thing: str, side: str) -> Grip:
        """The thing, where it is, in a hand, where that is; what it touches there is usual.

        Args:
            qpos: Positions of the whole scene, (nq,).
            thing: Its name.
            side: The hand's side.
        """
        stage = self.show(qpos)
        palm, body = stage.site(self.agent.arm(side).palm_site), stage.body(self.scene.object_body(thing))
        in_palm = Pose(palm.to_local(body.position), palm.matrix.T @ body.matrix)
        return Grip(thing, side, in_palm, self.touches(qpos, thing))

    def touches(self, qpos: Array, thing: str) -> dict[Pair, float]:
        """How deep a thing, where it is, overlaps with all that is not the robot, metres, by pairs of shapes.

        What is deeper than ``SUNK_M`` counts as no deeper: a thing that is to lie like that is in something. Somebody
        else's hand that holds it may be ``IN_HAND_M`` in it.
        """
        stage = self.show(qpos)
        rest = np.setdiff1d(self._others, self._things[thing])
        overlaps = stage.overlaps(self._things[thing], rest, deeper_than_m=0.0)
        return {(geom, other): min(depth_m, self._sunk_m(other)) for geom, other, depth_m in overlaps}

    def _sunk_m(self, other: int) -> float:
        """How deep a thing may be in another shape where it is."""
        return IN_HAND_M if other in self._others_hands else SUNK_M

    def refuse_sunk(self, qpos: Array, thing: str) -> None:
        """See that a thing lies as things lie, or is held as things are held.

        Raises:
            SceneError: It is deeper than ``SUNK_M`` in something, or than ``IN_HAND_M`` in a hand.
        """
        stage = self.show(qpos)
        rest = np.setdiff1d(self._others, self._things[thing])
        for _, other, depth_m in stage.overlaps(self._things[thing], rest, deeper_than_m=SUNK_M):
            if depth_m <= self._sunk_m(other):
                continue
            raise SceneError(
                f"the {thing} is {1000 * depth_m:.1f} mm deep in {self.called(other)}",
                where=self.scene.name,
                field=thing,
                hint="place it on or beside that",
            )

    def in_hand_m(self, qpos: Array, thing: str, side: str) -> float:
        """How deep a hand is in a thing where both are, metres."""
        stage, hand = self.show(qpos), self.agent.arm(side).hand_geoms
        return max((depth_m for *_, depth_m in stage.overlaps(hand, self._things[thing])), default=0.0)

    def geoms_of(self, thing: str) -> Indices:
        """Solid shapes of a thing."""
        return self._things[thing]

    def pairs(self, moving: Indices, grip: Grip | None) -> tuple[Indices, Indices, Array]:
        """Pairs of shapes that may collide as some of the robot's, and its load's, move.

        Args:
            moving: The shapes that move.
            grip: What the robot holds.

        Returns:
            All shapes that they are of, (n,); the pairs, by their places among these, (k, 2); how deep each may be,
            metres, (k,).
        """
        load = np.empty(0, dtype=np.intp) if grip is None else self._things[grip.thing]
        others = np.setdiff1d(self._others, load)
        links = np.intersect1d(self.own, moving)
        with_others = [(int(g), int(o)) for g in links for o in others if (int(g), int(o)) not in self._on_floor]
        with_others += [(int(g), int(o)) for g in np.intersect1d(load, moving) for o in others]
        possible = self.own[self._own_pairs]
        with_own = possible[np.isin(possible, moving).any(axis=1)].tolist()
        if grip is not None:
            free_of = np.setdiff1d(self.own, self.agent.arm(grip.side).hand_geoms)
            with_own += [(int(g), int(o)) for g in load for o in free_of]
        found = np.array([*with_others, *with_own], dtype=np.intp).reshape(-1, 2)
        usual_m = np.zeros(len(found))
        for (geom, other), depth_m in {**self._usual_m, **({} if grip is None else grip.usual_m)}.items():
            usual_m[(found[:, 0] == geom) & (found[:, 1] == other)] = depth_m
        geoms, rows = np.unique(found, return_inverse=True)
        return geoms, rows.reshape(-1, 2).astype(np.intp), usual_m

    def met(self, geom: int, other: int, depth_m: float) -> Blocking:
        """What collides, by names: a part of the robot or its load, and the other."""
        owner = self.scene.owners[geom]
        part = part_of(self.stage, self.agent, geom) if owner == self.agent.name else owner
        return Blocking(part, self.called(other), depth_m)

    def _first(self, grip: Grip | None, taken_by: Indices | None) -> Blocking | None:
        stage, agent = self.stage, self.agent
        others = self._others
        if grip is not None:
            load = self._things[grip.thing]
            others = np.setdiff1d(others, load, assume_unique=True)
            free_of = np.setdiff1d(self.own, agent.arm(grip.side).hand_geoms, assume_unique=True)
            met = others if taken_by is None else np.setdiff1d(others, taken_by, assume_unique=True)
            for rest in (met, free_of):
                for geom, other in stage.near_pairs(load, rest, limit_m=-TOLERANCE_M / 2):
                    depth_m = self._too_deep((geom, other), grip.usual_m)
                    if depth_m is not None:
                        return Blocking(grip.thing, self.called(other), depth_m)
        for geom, other in stage.near_pairs(self.own, others, limit_m=-TOLERANCE_M / 2):
            if (geom, other) not in self._on_floor:
                depth_m = self._too_deep((geom, other), self._usual_m)
                if depth_m is not None:
                    return Blocking(part_of(stage, agent, geom), self.called(other), depth_m)
        for geom, other in self._near_own():
            depth_m = self._too_deep((int(geom), int(other)), self._usual_m)
            if depth_m is not None:
                return Blocking(part_of(stage, agent, int(geom)), self.called(int(other)), depth_m)
        return None

    def _near_own(self) -> Indices:
        """Pairs of the robot's own shapes, (n, 2), whose boxes overlap."""
        near = near_of(self.stage.boxes(self.own), self._own_pairs, -TOLERANCE_M / 2)
        return np.asarray(self.own[near])

    def _too_deep(self, pair: Pair, usual_m: Mapping[Pair, float]) -> float | None:
        depth_m = -self.stage.distance(*pair, limit_m=0.0)
        return depth_m if depth_m > usual_m.get(pair, 0.0) + TOLERANCE_M else None

    def called(self, geom: int) -> str:
        """Name of what a shape belongs to: a thing, a piece of furniture, or a part of an agent."""
        owner = self.scene.owners[geom]
        if owner not in self.scene.agents:
            return owner
        return f"{owner}/{part_of(self.stage, self.scene.agent(owner), geom)}"

    def _always_level(self, planes: Iterable[int]) -> frozenset[Pair]:
        """Own shapes and level planes between which no joint changes anything: the base stays on its floor."""
        model, root = self.scene.model, self.agent.root_body
        fixed = [int(geom) for geom in self.own if int(model.body_weldid[model.geom_bodyid[geom]]) == root]
        turning = [int(geom) for geom in self.own if self._turns_upright(int(geom))]
        level = [plane for plane in planes if self.stage.geom(plane).matrix[2, 2] > 1.0 - 1e-9]
        return frozenset((geom, plane) for geom in {*fixed, *turning} for plane in level)

    def _turns_upright(self, geom: int) -> bool:
        """Whether all joints between the root and a shape turn about the vertical, or are no arm's and no lift's."""
        model, body = self.scene.model, int(self.scene.model.geom_bodyid[geom])
        moved = {*self.agent.arm_positions.tolist(), *(self.agent.joints[name] for name in self.agent.lifts)}
        while body not in (self.agent.root_body, 0):
            joints = range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body])
            if any(int(model.jnt_qposadr[joint]) in moved for joint in joints):
                return False
            body = int(model.body_parentid[body])
        return True


@compiled
def near_of(table: Array, pairs: Indices, limit_m: float) -> Indices:
    """Those of some pairs of boxes, by rows of a table (n, 18), that may come nearer than a limit, (k, 2)."""
    found, count = np.empty_like(pairs), 0
    for row in range(len(pairs)):
        i, j = pairs[row]
        if may_be_near(table, i, table, j, limit_m):
            found[count] = pairs[row]
            count += 1
    return found[:count]


# --- Which of a robot's own shapes may collide with one another.


def own_pairs(scene: Scene, agent: Agent, own: Indices) -> tuple[Indices, Mapping[Pair, float]]:
    """Pairs of own shapes, by their places among them, that count, (n, 2); and what is usual at the neutral one.

    They are found once for each form of a robot.
    """
    form = _Form(scene, agent, own)
    return _sampled_pairs(form)


class _Form:
    """A robot by its shapes, joints and sizes alone: equal ones have equal pairs."""

    def __init__(self, scene: Scene, agent: Agent, own: Indices) -> None:
        self.scene, self.agent, self.own = scene, agent, own
        model, digest = scene.model, hashlib.sha256()
        bodies = agent.bodies
        joints = np.flatnonzero(np.isin(model.jnt_bodyid, bodies))
        meshes = [int(mesh) for mesh in model.geom_dataid[own] if mesh >= 0]
        vertices = [model.mesh_vert[model.mesh_vertadr[m] :][: model.mesh_vertnum[m]] for m in meshes]
        for array in (
            *(model.geom_type[own], model.geom_size[own], model.geom_pos[own], model.geom_quat[own]),
            *(model.body_pos[bodies[1:]], model.body_quat[bodies[1:]], np.searchsorted(bodies, model.geom_bodyid[own])),
            *(model.jnt_type[joints], model.jnt_axis[joints], model.jnt_pos[joints], model.jnt_range[joints]),
            np.array([value for _, value in (*agent.profile.rest_rad, *agent.profile.rest_m)]),
            *vertices,
        ):
            digest.update(np.ascontiguousarray(array).tobytes())
        self._digest = digest.digest()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Form) and other._digest == self._digest

    def __hash__(self) -> int:
        return hash(self._digest)


@lru_cache(maxsize=32)
def _sampled_pairs(form: _Form) -> tuple[Indices, Mapping[Pair, float]]:
    scene, agent, own = form.scene, form.agent, form.own
    pairs = _movable_pairs(scene, agent, own)
    stage, rng = Stage(scene), np.random.default_rng(SEED)
    positions, low, high = _ranges(scene, agent)
    overlaps = np.zeros((len(own), len(own)), dtype=np.intp)
    state = scene.initial
    for _ in range(SAMPLES):
        drawn = rng.uniform(low, high)
        stage.show(state.replace(dict(zip(positions.tolist(), drawn.tolist(), strict=True))))
        for a, b in near_of(stage.boxes(own), pairs, -TOLERANCE_M).tolist():
            if -stage.distance(int(own[a]), int(own[b]), limit_m=0.0) > TOLERANCE_M:
                overlaps[a, b] += 1
    neutral = np.clip(scene.model.qpos0[positions], low, high)
    usual_m: dict[Pair, float] = {}
    for at_ease in (neutral, np.clip(_resting(agent, positions, neutral), low, high)):
        stage.show(state.replace(dict(zip(positions.tolist(), at_ease.tolist(), strict=True))))
        for a, b in near_of(stage.boxes(own), pairs, 0.0).tolist():
            depth_m = -stage.distance(int(own[a]), int(own[b]), limit_m=0.0)
            if depth_m > usual_m.get((a, b), 0.0):
                usual_m[a, b] = depth_m
                if at_ease is neutral and overlaps[a, b] > MOST_SHARE * SAMPLES:
                    usual_m[a, b] = math.inf
    counting = [pair for pair in map(tuple, pairs.tolist()) if usual_m.get(pair, 0.0) < math.inf]
    left = {pair: depth_m for pair, depth_m in usual_m.items() if depth_m < math.inf}
    return np.array(counting, dtype=np.intp).reshape(-1, 2), left


def _movable_pairs(scene: Scene, agent: Agent, own: Indices) -> Indices:
    """Pairs of own shapes that are neither fixed to one another, nor joined by a joint, nor of one hand, (n, 2)."""
    model = scene.model
    hands = [set(subtree(model, arm.hand_body)) for arm in agent.arms]
    found = []
    for a, geom in enumerate(own.tolist()):
        for b in range(a + 1, len(own)):
            bodies = [int(model.geom_bodyid[g]) for g in (geom, own[b])]
            first, second = (int(model.body_weldid[body]) for body in bodies)
            parents = [int(model.body_weldid[model.body_parentid[weld]]) for weld in (first, second)]
            if first == second or first == parents[1] or second == parents[0]:
                continue
            if not any(bodies[0] in hand and bodies[1] in hand for hand in hands):
                found.append((a, b))
    return np.array(found, dtype=np.intp).reshape(-1, 2)


def _ranges(scene: Scene, agent: Agent) -> tuple[Indices, Array, Array]:
    """Positions of an agent's joints, (n,), and their ranges; a turn for those without end."""
    model, rows = scene.model, []
    for position in agent.joints.values():
        (joint,) = np.flatnonzero(model.jnt_qposadr == position)
        low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-np.pi, np.pi)
        rows.append((position, float(low), float(high)))
    positions, low_values, high_values = zip(*rows, strict=True)
    return np.array(positions, dtype=np.intp), np.array(low_values), np.array(high_values)


def _resting(agent: Agent, positions: Indices, neutral: Array) -> Array:
    """Positions of an agent's joints at rest, as its profile has them, (n,)."""
    rest = {**dict(agent.profile.rest_rad), **dict(agent.profile.rest_m)}
    names = {position: name for name, position in agent.joints.items()}
    return np.array(
        [rest.get(names[int(p)], value) for p, value in zip(positions.tolist(), neutral.tolist(), strict=True)]
    )


def pose_of(position_and_wxyz: Array) -> Pose:
    """A pose from a position in metres and a quaternion, (7,)."""
    return Pose(np.array(position_and_wxyz[:3]), matrix_from_wxyz(position_and_wxyz[3:]))
