"""What stands beside the performer, a small table or a shelf, and the means of putting something there."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.body import Body
from taskgist.demonstrator.furniture import Table
from taskgist.demonstrator.generator.arrangement import Arrangement
from taskgist.demonstrator.generator.furnishing import Shelf, on_top
from taskgist.demonstrator.generator.setting import Setting
from taskgist.demonstrator.generator.shelving import DrawBack, PutOnBoard
from taskgist.demonstrator.generator.sight import would_be_hidden
from taskgist.demonstrator.generator.spots import beside
from taskgist.demonstrator.hand import SIGNS
from taskgist.demonstrator.means import Means
from taskgist.demonstrator.putting import Place, Putting
from taskgist.demonstrator.script import Script
from taskgist.demonstrator.steps import PutDown, Withdraw
from taskgist.errors import SceneError
from taskgist.world import Scene

Array = NDArray[np.float64]

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
EDGE_M, ROOM_M, GRID_M = 0.03, 0.06, 0.04
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
            raise SceneError("the board is out of reach", where=scene.name, hint="draw another room")
        if hidden != would_be_hidden(putting.stage, roles.target, roles.thing, points, but=(roles.performer,)):
            problem = "would be in view" if hidden else "would be hidden"
            raise SceneError(f"what is on the board {problem}", where=scene.name, hint="draw another room")
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
        reached, around=np.zeros((1, 3)), room_m=ROOM_M, suits=lambda place: putting.in_view(place, roles.target)
    )
    if found is None:
        raise SceneError(
            f"no place on {table.name!r} within reach and in view", where=scene.name, hint="draw another room"
        )
    return found


def _grid(table: Table) -> list[Array]:
    half = math.hypot(*table.size_m[:2]) / 2
    offsets = np.arange(-half, half, GRID_M)
    x, y = table.centre_m
    return [np.array([x + dx, y + dy, table.height_m]) for dx, dy in product(offsets, offsets)]
