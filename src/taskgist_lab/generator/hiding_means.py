"""Means of hiding and putting away that need more than a place: inside, under, behind the back, onto a shelf."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import SceneError
from taskgist.moving.acting import Acting
from taskgist.moving.body import Body
from taskgist.moving.hand_pose import SIGNS, UP, HandPose, sampled, upright
from taskgist.moving.steps import (
    CLOSING_S,
    OPEN_ASIDE_M,
    PASSING_M,
    POINT_SPACING_M,
    HoldUp,
    PutDown,
    Take,
    Withdraw,
    half_height_m,
    lift_m,
)
from taskgist.moving.steps_from_above import PutInto, cornered, goal_at
from taskgist.world.contacts import object_points
from taskgist.world.geometry.transforms import normalized, rotate
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist_lab.generator.arrangement import Arrangement, Setting, beside
from taskgist_lab.generator.furnishing import Shelf, on_top
from taskgist_lab.generator.outcomes import would_be_hidden
from taskgist_lab.generator.things import WALL_M
from taskgist_lab.simulator.demonstration import Script, Step
from taskgist_lab.simulator.means import HELD_S, Means, Roles
from taskgist_lab.simulator.places import Place, Putting
from taskgist_lab.simulator.room import Table
from taskgist_lab.simulator.throwing import LetFall

# --- Hiding places inside things and under things, and the means that use them.

HIDING_PLACES_ROOM_M = 0.015
"""Gap between a thing and the walls around it."""
OFFSETS_M = tuple(0.02 * step for step in range(-4, 5))
"""Offsets from the middle of a bin that are tried."""
TOWARDS_M = 0.05
"""How far from its middle towards the target agent a thing is best put."""
OVER_RIM_M, HIDING_HELD_S = 0.01, 0.1
"""How high above the rim of a bin the underside of a thing is when the hand opens, and how long it is there."""


def script_of(roles: Roles, task: str, means: str, steps: tuple[Step, ...]) -> Script:
    """A script of roles in which the performer need not take the thing first, or not at all."""
    return Script(
        task,
        roles.performer,
        roles.target,
        roles.thing,
        steps,
        roles.target_watches,
        means,
        roles.target_returns_to,
        roles.also_for,
    )


def put_inside(roles: Roles, task: str, *, container: str) -> Means:
    """Let fall into an open bin whose walls hide the thing from the target agent."""

    def script(scene: Scene) -> Script:
        place, rim_m = inside(scene, roles, container)
        x, y, _ = place
        held = (x, y, rim_m + OVER_RIM_M + half_height_m(Stage(scene), roles.thing))
        steps = (HoldUp(held, HIDING_HELD_S), LetFall(dropped=False), Withdraw())
        return roles.script(task, f"put into {container}", *steps)

    return script


def inside(scene: Scene, roles: Roles, container: str) -> tuple[Place, float]:
    """A place in a bin where its walls hide the thing from the target agents' eyes, and the height of its rim.

    Raises:
        SceneError: There is none.
    """
    putting = Putting.of(scene, roles.thing)
    points = object_points(putting.stage, container, POINT_SPACING_M)
    low, high = points.min(axis=0), points.max(axis=0)
    middle = np.array([*((low + high) / 2)[:2], low[2] + WALL_M])
    walls = np.abs(points[:, :2] - middle[:2])
    room = float(np.linalg.norm(walls[points[:, 2] > low[2] + 2 * WALL_M], axis=1).min()) - WALL_M
    eye = np.mean([putting.stage.eye(scene.agent(name)).position for name in roles.targets], axis=0)
    best = TOWARDS_M * normalized((eye - middle)[:2])  # there the wall hides most, and arms have room
    for offset in sorted(product(OFFSETS_M, OFFSETS_M), key=lambda each: float(np.linalg.norm(each - best))):
        fits = np.linalg.norm(offset) + putting.radius_m + HIDING_PLACES_ROOM_M <= room
        place = middle + (*offset, 0.0)
        if fits and all(
            would_be_hidden(putting.stage, name, roles.thing, putting.shape + place, but=(roles.performer,))
            for name in roles.targets
        ):
            return (float(place[0]), float(place[1]), float(place[2])), float(high[2])
    raise SceneError(
        f"{container!r} does not hide {roles.thing!r} from {' and '.join(map(repr, roles.targets))}",
        where=scene.name,
        hint="take a deeper one",
    )


def put_under(roles: Roles, *, cover: str) -> Means:
    """Hide by putting a cover, which is open below, over the thing; the thing itself is not touched."""

    def script(scene: Scene) -> Script:
        putting = Putting.of(scene, roles.thing)
        place = tuple(putting.lies.tolist())
        steps = (Take(cover, roles.side), PutInto(place), Withdraw())
        assert half_height_m(putting.stage, cover) > putting.middle[2]
        return script_of(roles, "hide", f"{cover} put over it", steps)

    return script


# --- Behind the own back: a step that takes what the hand holds there, and the means of hiding so.

ASIDE_SHARE, WAIST_SHARE = 0.23, 0.02
"""How far beside the pelvis the hand passes, and how far above it, as shares of the stature."""
BACK_SHARE, PAST_SHARE = 0.115, 0.05
"""How far behind the pelvis the hand is then, and how far to its own side."""
DOWN_RAD = np.radians(-50.0)
"""How far the fingers rise while the hand passes the hip: they point down."""


@dataclass(frozen=True)
class HoldBehindBack:
    """Take what the hand holds behind the own back and keep it there.

    Attributes:
        seconds: For how long.
    """

    seconds: float

    def play(self, acting: Acting) -> None:
        """Take it round the hip, look at the target agent, hold still."""
        carry, body = acting.holding(), acting.body
        start = body.hand(acting.state, carry.side)
        lifted = start.moved(0.08 * UP)
        way = sampled([start, lifted, *_round_the_hip(acting, carry.side)])[1:]
        acting.look(acting.target)
        acting.move(carry.side, way, torso_rad=np.zeros(2), phase="over")
        acting.wait(self.seconds)


def _round_the_hip(acting: Acting, side: str) -> tuple[HandPose, ...]:
    agent = acting.body.agent
    pelvis = acting.state.qpos[agent.base]
    ahead, inwards = rotate(pelvis[3:], (1.0, 0.0, 0.0)), rotate(pelvis[3:], (0.0, SIGNS[side], 0.0))
    stature = agent.stature_m
    waist = pelvis[:3] + WAIST_SHARE * stature * UP
    beside = waist - ASIDE_SHARE * stature * inwards
    passing = upright(side, beside + 0.10 * stature * ahead, ahead + inwards, rise_rad=DOWN_RAD)
    past = upright(side, beside - BACK_SHARE * stature * ahead, inwards, rise_rad=DOWN_RAD / 2)
    behind = waist - BACK_SHARE * stature * ahead - PAST_SHARE * stature * inwards
    return passing, past, upright(side, behind, inwards, rise_rad=DOWN_RAD / 2)


def hold_behind_back(roles: Roles) -> Means:
    """Hide by holding behind the own back."""

    def script(_scene: Scene) -> Script:
        steps = (Take(roles.thing, roles.side), HoldBehindBack(HELD_S))
        return script_of(roles, "hide", "held behind the own back", steps)

    return script


# --- Shelving: steps that put the thing in the hand onto a board between others, from the front.

BEFORE_M = 0.22
"""How far before its place a thing is brought to its height."""
FAR_TURN_S = 0.7
"""How long heads turn that turn from one side to the other."""
OVER_BOARD_M = 0.03
"""How high above the board it is moved in."""


@dataclass(frozen=True)
class PutOnBoard:
    """Put the thing in the hand on a board of a shelf.

    Attributes:
        place_m: Where the middle of its underside shall be, (3,).
        front_rad: Where the shelf's open front faces.
    """

    place_m: tuple[float, float, float]
    front_rad: float

    def play(self, acting: Acting) -> None:
        """Carry it before the shelf, move it in, set it down."""
        carry, body = acting.holding(), acting.body
        start = body.hand(acting.state, carry.side)
        x, y = np.array(self.place_m[:2]) - body.shoulder(acting.state, carry.side)[:2]
        goal, rest = goal_at(acting, self.place_m, heading_rad=math.atan2(y, x))
        outwards = BEFORE_M * np.array([math.cos(self.front_rad), math.sin(self.front_rad), 0.0])
        inside = goal.moved((0.0, 0.0, OVER_BOARD_M))
        before = inside.moved(outwards)
        lift = lift_m(Stage(acting.scene), carry.thing, start=start.palm, end=start.palm) + PASSING_M
        raised = start.moved((0.0, 0.0, max(lift, before.palm[2] - start.palm[2])))
        acting.look(carry.thing)
        torso = body.torso_for(acting.state, carry.side, goal.palm)
        over = before.moved((0.0, 0.0, max(0.0, raised.palm[2] - before.palm[2])))
        way = sampled(cornered([start, raised, over, before, inside, goal]))[1:]
        acting.move(carry.side, way, torso_rad=torso, phase="over")
        acting.release(rest)
        acting.wait(CLOSING_S)


@dataclass(frozen=True)
class DrawBack:
    """Take the empty hand straight back out, then to rest."""

    def play(self, acting: Acting) -> None:
        """Open it, draw it back, take it home; look at the target agent."""
        body, side = acting.body, acting.acting_side
        hand = body.hand(acting.state, side)
        opened = hand.off(aside_m=OPEN_ASIDE_M / 2, back_m=OPEN_ASIDE_M, up_m=OVER_BOARD_M / 2)
        out = hand.off(aside_m=OPEN_ASIDE_M / 2, back_m=BEFORE_M, up_m=OVER_BOARD_M)
        way = sampled([hand, opened, out, *reversed(body.raising(side))])[1:]
        acting.look(acting.target, turn_s=FAR_TURN_S)
        acting.move(side, way, torso_rad=np.zeros(2), phase="back")


TABLE_M = ((0.36, 0.36), (0.46, 0.60))
"""Least and largest top of a side table."""
TABLE_SHARE = (0.42, 0.58)
"""How high it is, as a share of the stature of who puts something there, standing."""
CLEAR_M, AHEAD_M = (0.42, 0.50), (-0.05, 0.12)
"""How far beside the performer's pelvis its near edge is, and how far before it its middle."""
SHELF_M = ((0.24, 0.36), (0.30, 0.48))
"""Least and largest depth and width of a shelf."""
SHELF_AHEAD_M, IN_M = (0.0, 0.15), (-0.06, -0.01)
"""How far before the performer a shelf is, and how far behind the middle of the board something is put."""
TOWARDS_RAD, AWAY_RAD = np.radians((-5.0, 20.0)), np.radians((10.0, 35.0))
"""How far its front is turned towards the target agent, or away from it."""
BOARD_SHARE = (0.50, 0.66)
"""How high the board is, as a share of the stature."""
BETWEEN_M = (0.36, 0.44)
"""Height between two boards."""
SKEW_RAD = math.radians(15.0)
"""How far a side table is turned from where the performer faces."""
STRETCHED_SHARE = 0.95
"""How far an arm is stretched out sideways, at most."""
EDGE_M, ASIDE_ROOM_M, GRID_M = 0.03, 0.06, 0.04
"""Things on it are so far from its edge and from others, and places so far apart are tried."""


def side_table_beside(arrangement: Arrangement, side: str) -> Table:
    """A small table beside the performer."""
    rng, person = arrangement.rng, arrangement.performer
    deep, wide = rng.uniform(*TABLE_M)
    height = person.stature_m * rng.uniform(*TABLE_SHARE)
    place = beside(person, side, aside_m=rng.uniform(*CLEAR_M) + wide / 2, ahead_m=rng.uniform(*AHEAD_M))
    yaw = person.yaw_rad + rng.uniform(-SKEW_RAD, SKEW_RAD)
    return Table("side_table", place, (round(deep, 3), round(wide, 3), round(height, 3)), yaw)


def shelf_beside(arrangement: Arrangement, side: str, *, closed: bool) -> tuple[Shelf, Place]:
    """A shelf or cupboard beside the performer, its front towards the performer, and a handy place on a board.

    The front of a shelf is turned a little towards the target agent, that of a cupboard away from it.
    """
    rng, person = arrangement.rng, arrangement.performer
    deep, wide = rng.uniform(*SHELF_M)
    board = person.stature_m * rng.uniform(*BOARD_SHARE)
    boards = tuple(round(float(height), 3) for height in (0.12, board, board + rng.uniform(*BETWEEN_M)))
    turned = rng.uniform(*AWAY_RAD) if closed else -rng.uniform(*TOWARDS_RAD)
    aside = rng.uniform(*CLEAR_M) + (deep * math.cos(turned) + wide * abs(math.sin(turned))) / 2
    place = beside(person, side, aside_m=aside, ahead_m=rng.uniform(*SHELF_AHEAD_M))
    front = person.yaw_rad + SIGNS[side] * (math.pi / 2 + turned)
    shelf = Shelf("shelf", place, front, (round(deep, 3), round(wide, 3)), boards, closed)
    return shelf, shelf.place(1, in_m=rng.uniform(*IN_M))


def put_on_side_table(setting: Setting, task: str) -> Means:
    """Put on the small table beside the performer, in the target agent's view."""
    table = next(each for each in setting.room.furniture or () if getattr(each, "name", "") == setting.props["table"])
    assert isinstance(table, Table)

    def script(scene: Scene) -> Script:
        steps = (PutDown(_place_on(scene, setting, table)), Withdraw())
        return setting.roles.script(task, "put on the side table", *steps)

    return script


def put_on_board(setting: Setting, task: str, *, hidden: bool) -> Means:
    """Put on the board of a shelf, where the target agent sees it, or where it does not."""
    place, roles = setting.places["board"], setting.roles

    def script(scene: Scene) -> Script:
        putting, body = Putting.of(scene, roles.thing), Body(scene, roles.performer)
        points, goal = putting.shape + place, np.array(place) + putting.middle
        reach = STRETCHED_SHARE * body.agent.arm(roles.side).profile.length_m
        if np.linalg.norm(goal - body.shoulder(scene.initial, roles.side)) > reach:
            raise SceneError("the board is out of reach", where=scene.name, hint="try another room")
        if hidden != would_be_hidden(putting.stage, roles.target, roles.thing, points, but=(roles.performer,)):
            problem = "would be in view" if hidden else "would be hidden"
            raise SceneError(f"what is on the board {problem}", where=scene.name, hint="try another room")
        steps = (PutOnBoard(place, setting.amounts["front"]), DrawBack())
        return roles.script(task, "put into the shelf", *steps)

    return script


def _place_on(scene: Scene, setting: Setting, table: Table) -> Place:
    """The place on a table that is nearest to the performer's shoulder and in the target agent's view."""
    roles, body = setting.roles, Body(scene, setting.roles.performer)
    putting, shoulder = Putting.of(scene, roles.thing), body.shoulder(scene.initial, roles.side)
    reach = STRETCHED_SHARE * body.agent.arm(roles.side).profile.length_m
    margin = putting.radius_m + EDGE_M
    tops = [place for place in _grid(table) if on_top(table, place, margin)]
    near = sorted(tops, key=lambda place: float(np.linalg.norm(place - shoulder)))
    reached = (place for place in near if np.linalg.norm(place + putting.middle - shoulder) < reach)
    found = putting.first(
        reached, around=np.zeros((1, 3)), room_m=ASIDE_ROOM_M, suits=lambda place: putting.in_view(place, roles.target)
    )
    if found is None:
        raise SceneError(
            f"no place on {table.name!r} within reach and in view",
            where=scene.name,
            hint="try another room",
        )
    return found


def _grid(table: Table) -> list[Array]:
    half = math.hypot(*table.size_m[:2]) / 2
    offsets = np.arange(-half, half, GRID_M)
    x, y = table.centre_m
    return [np.array([x + dx, y + dy, table.height_m]) for dx, dy in product(offsets, offsets)]
