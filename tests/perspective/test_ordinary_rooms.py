"""Ordinary scenes, a line each: who sees, reaches and grasps what, as any person would say.

Body, furniture, thing, and the right effort levels to see, reach and grasp it: 0 none, 1 head or arm, 2 torso, 3 whole
body, 4 displacement, 5 none known. Where the answer is wrong today, ``!`` and a word say why; whoever mends that kind
takes the marks away, for a mark on a right answer is a failure, too.
"""

# ruff: noqa: E501 - a scene is a line

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import pytest

from taskgist.perspective.effort import ABILITIES, Ability
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.world import Stage
from taskgist_lab.ordinary.furniture import Box, bed, bench, cabinet, chair, drawer, sofa, table, wall
from tests.bodies import needs
from tests.ordinary import (
    GLASS,
    Expected,
    Line,
    Mug,
    PlaneWall,
    a,
    ball,
    block,
    board,
    case,
    pen,
    robot,
    sits,
    stands,
    tube,
)

WRONG_TODAY = {
    "crouch": "bending at the hips, crouching",
    "chair": "pushing the chair back to stand up",
    "walk": "walks end at 8 m",
    "closed": "what is shut in is reached",
    "wall": "what is behind walls or boards is reached",
    "flat": "thin flat things are not grasped",
    "two hands": "wide things take two hands",
    "small": "small things fall between rays",
    "glass": "glass is looked through, and no way for hands",
    "plane": "planes hide from their front only",
    "neck": "heads bend as far as necks do",
}
"""Why answers are wrong today, by the word that marks them."""

HALF_TURN = math.pi
TOP = 0.74
"""Height of tables."""
TABLE = (table("table", (0.7, 0.0)),)
"""Its near edge is 30 cm before the middle of who stands or sits before it."""
CHAIR = chair("chair", (0.0, 0.0))
DINING = (*TABLE, CHAIR)
WIDE = (table("table", (0.8, 0.0), size_m=(1.0, 3.0, TOP)),)
BAR = (table("bar", (0.55, 0.0), size_m=(0.5, 1.2, 1.05)),)
SOFA = (sofa("sofa", (0.0, 0.0)),)
LOW = (*SOFA, table("low table", (1.0, 0.0), size_m=(0.5, 1.0, 0.42)))
NARROW = (*SOFA, table("low table", (0.86, 0.0), size_m=(0.5, 1.2, 0.42)))
HEMMED = (
    table("table", (0.75, 0.0)),
    CHAIR,
    board("carton", (0.22, 0.3, 0.2), 0.5, 0.0, TOP + 0.1),
    board("screen", (0.05, 1.0, 1.0), -0.46, 0.0, 0.5),
)
BENCH = (bench("bench", (0.0, 0.0)),)
SHELF = (cabinet("shelf", (0.6, 0.0), HALF_TURN, boards_m=(0.4, 0.8, 1.2, 1.6), high_m=2.0),)
HIGH_SHELF = (cabinet("shelf", (0.6, 0.0), HALF_TURN, low_m=2.3, high_m=2.8),)
CUPBOARD = (cabinet("cupboard", (0.6, 0.0), HALF_TURN, size_m=(0.4, 0.9), boards_m=(0.5, 1.0), high_m=1.5, shut=True),)
OPEN_CUPBOARD = (cabinet("cupboard", (0.6, 0.0), HALF_TURN, size_m=(0.4, 0.9), boards_m=(0.5, 1.0), high_m=1.5),)
COUNTER = (cabinet("counter", (0.6, 0.0), HALF_TURN, size_m=(0.6, 1.6), high_m=0.87, shut=True, top_m=0.04),)
WALL_CUPBOARD = (cabinet("hung", (0.75, 0.0), HALF_TURN, size_m=(0.3, 1.2), low_m=1.42, high_m=1.95),)
CLOSED_WALL_CUPBOARD = (cabinet("hung", (0.75, 0.0), HALF_TURN, size_m=(0.3, 1.2), low_m=1.42, high_m=1.95, shut=True),)
DRAWER, OPEN_DRAWER = (drawer("drawer", (0.6, 0.0), HALF_TURN),), (drawer("drawer", (0.7, 0.0), HALF_TURN, out_m=0.3),)
BED = (bed("bed", (0.8, 0.0), HALF_TURN),)
LONG_WALL = (wall("wall", (0.8, -6.0), (0.8, 6.0)),)
SHORT_WALL = (wall("wall", (0.8, -1.0), (0.8, 1.0)),)
CELL = (
    wall("wall north", (1.0, 1.0), (3.0, 1.0)),
    wall("wall south", (1.0, -1.0), (3.0, -1.0)),
    wall("wall west", (1.0, -1.0), (1.0, 1.0)),
    wall("wall east", (3.0, -1.0), (3.0, 1.0)),
)
DOOR = (wall("wall left", (1.5, 0.5), (1.5, 6.0)), wall("wall right", (1.5, -6.0), (1.5, -0.5)))
FENCE = (board("fence", (0.03, 3.0, 0.9), 0.45, 0.0, 0.45),)
HEDGE = (board("screen", (0.03, 3.0, 1.4), 1.0, 0.0, 0.7),)
BARS = case("cage", (0.3, 0.3, 0.3), 0.55, 0.0, 1.02, without=("front",))
CAGE = replace(BARS, boxes=(*BARS.boxes, *(Box((0.01, 0.01, 0.3), (-0.15, 0.035 * n, 1.17)) for n in range(-4, 5))))
MUG = Mug("thing", (0.09, 0.10), (0.45, -0.15, TOP))
PANE = board("pane", (0.006, 1.2, 0.72), 0.35, 0.0, 1.1, GLASS)

# fmt: off
LINES = (
    # --- Nothing but a floor, standing.
    Line("cup on the floor half a metre ahead", stands(), (), a("cup", 0.5, 0.0), "<=2", "3", "3"),
    Line("cup on the floor, 1.55 m tall", stands(tall=1.55), (), a("cup", 0.5, 0.0), "<=2", "3", "3"),
    Line("cup on the floor, 1.90 m tall", stands(tall=1.90), (), a("cup", 0.5, 0.0), "<=2", "3", "3"),
    Line("cup on the floor beside the right foot", stands(), (), a("cup", 0.2, -0.4), "<=3", "3..4", "3..4"),
    Line("cup on the floor a metre ahead", stands(), (), a("cup", 1.0, 0.0), "<=1", "3..4", "3..4"),
    Line("cup on the floor three metres ahead", stands(), (), a("cup", 3.0, 0.0), "<=1", "4", "4"),
    Line("cup on the floor six metres ahead", stands(), (), a("cup", 6.0, 0.0), "<=1", "4", "4"),
    Line("cup on the floor half a metre behind", stands(), (), a("cup", -0.5, 0.0), "2..4", "3..4", "3..4"),
    Line("cup on the floor four metres behind", stands(), (), a("cup", -4.0, 0.3), "2..4", "4", "4"),
    Line("pen on the floor", stands(), (), pen(0.5, 0.0), "<=2", "3", "3"),
    Line("keys on the floor", stands(), (), a("keys", 0.45, 0.1), "<=2", "3", "3"),
    Line("book on the floor", stands(), (), a("book", 0.5, 0.0), "<=2", "3", "3"),
    Line("carton on the floor", stands(), (), a("carton", 0.55, 0.0), "<=2", "3", "3..4"),
    Line("ball of 22 cm on the floor", stands(), (), ball(0.22, 0.5, 0.0), "<=2", "3", "3"),
    Line("pot on the floor two metres off", stands(), (), a("pot", 2.0, 0.5), "<=1", "4", "4"),
    # --- Held up in the air, standing: the arm alone.
    Line("cup at the chest, 45 cm ahead", stands(), (), a("cup", 0.45, -0.1, 1.25), "<=1", "1", "1"),
    Line("cup at the chest, 1.55 m tall", stands(tall=1.55), (), a("cup", 0.40, -0.1, 1.10), "<=1", "1", "1"),
    Line("cup at the chest, 1.90 m tall", stands(tall=1.90), (), a("cup", 0.50, -0.1, 1.35), "<=1", "1", "1"),
    Line("cup at the chest, to the right", stands(), (), a("cup", 0.2, -0.6, 1.25), "<=1", "1", "1"),
    Line("cup at the chest, to the left", stands(), (), a("cup", 0.2, 0.6, 1.25), "<=1", "1", "1"),
    Line("cup at the hip, right beside it", stands(), (), a("cup", 0.1, -0.45, 0.85), "<=2", "1", "<=2"),
    Line("cup at the chest, 85 cm ahead", stands(), (), a("cup", 0.90, -0.2, 1.2), "<=1", "2..3", "2..3"),
    Line("cup at the chest, 1.5 m ahead", stands(), (), a("cup", 1.5, 0.0, 1.2), "<=1", "4", "4"),
    Line("cup at the chest, 5 m ahead", stands(), (), a("cup", 5.0, 0.0, 1.2), "<=1", "4", "4"),
    Line("cup at the chest, half a metre behind", stands(), (), a("cup", -0.5, -0.2, 1.2), "2..4", "2..4", "2..4"),
    Line("cup at the knee, 40 cm ahead", stands(), (), a("cup", 0.4, 0.0, 0.45), "<=2", "2..3", "2..3"),
    Line("cup over the head at 1.9 m", stands(), (), a("cup", 0.3, -0.2, 1.85), "<=2", "1", "1"),
    Line("cup at 1.7 m, 1.55 m tall", stands(tall=1.55), (), a("cup", 0.2, -0.15, 1.70), "<=2", "1..2", "1..2"),
    Line("cup under the ceiling at 2.5 m", stands(), (), a("cup", 0.5, 0.0, 2.5), "<=2", "5", "5"),
    # --- A table, standing before it.
    Line("cup near the edge", stands(), TABLE, a("cup", 0.40, 0.0, TOP), "<=2", "<=2", "<=2"),
    Line("cup in the middle of the table", stands(), TABLE, a("cup", 0.70, 0.0, TOP), "<=1", "2..3", "2..3"),
    Line("cup at the far edge", stands(), TABLE, a("cup", 1.0, 0.2, TOP), "<=1", "2..4", "2..4"),
    Line("cup on the corner to the right", stands(), TABLE, a("cup", 0.45, -0.5, TOP), "<=2", "2..4", "2..4"),
    Line("cup a metre and a half along the table", stands(), WIDE, a("cup", 0.6, 1.4, TOP), "<=1", "4", "4"),
    Line("cup on a bar", stands(), BAR, a("cup", 0.45, -0.1, 1.05), "<=2", "1..2", "1..2"),
    Line("cup on a table four metres off", stands(-4.0), TABLE, a("cup", 0.5, 0.0, TOP), "<=1", "4", "4"),
    Line("cup on a table behind", stands(-0.3, 0.0, 180), TABLE, a("cup", 0.45, 0.0, TOP), "2..4", "2..4", "2..4"),
    Line("cup on the table, 1.55 m tall", stands(tall=1.55), TABLE, a("cup", 0.45, -0.1, TOP), "<=2", "<=2", "<=2"),
    Line("cup on the table, 1.90 m tall", stands(tall=1.90), TABLE, a("cup", 0.45, -0.1, TOP), "<=2", "<=2", "<=2"),
    Line("cup beneath the table, 25 cm in", stands(), TABLE, a("cup", 0.55, 0.0), "<=3", "3..4", "3..4"),
    Line("cup on a low table", stands(-0.1), (table("low table", (0.5, 0.0), size_m=(0.5, 1.0, 0.42)),), a("cup", 0.4, 0.0, 0.42), "<=2", "2..3", "2..3"),
    Line("bottle on the kitchen counter", stands(), COUNTER, a("bottle", 0.5, 0.0, 0.91), "<=1", "1..2", "1..2"),
    Line("tin at the back of the counter", stands(), COUNTER, a("tin", 0.8, 0.1, 0.91), "<=1", "2..3", "2..3"),
    Line("cup on a bed", stands(), BED, a("cup", 0.6, 0.0, 0.50), "<=2", "2..3", "2..3"),
    Line("glass of glass on the table", stands(), TABLE, tube(0.065, 0.13, 0.5, 0.0, TOP, GLASS), "<=2", "<=2", "<=2"),
    # --- A table, sitting at it.
    Line("cup before the diner", sits(), DINING, a("cup", 0.45, 0.0, TOP), "<=1", "1", "1"),
    Line("cup before the diner, to the left", sits(), DINING, a("cup", 0.45, 0.35, TOP), "<=1", "1..2", "1..2"),
    Line("cup in the middle of the table, sitting", sits(), DINING, a("cup", 0.70, 0.0, TOP), "<=1", "1..2", "1..2"),
    Line("cup at the far edge, sitting", sits(), DINING, a("cup", 1.0, 0.0, TOP), "<=1", "2..3", "2..3"),
    Line("cup before the diner, 1.55 m tall", sits(tall=1.55), DINING, a("cup", 0.45, 0.0, TOP), "<=1", "1..2", "1..2"),
    Line("cup before the diner, 1.90 m tall", sits(tall=1.90), DINING, a("cup", 0.45, 0.0, TOP), "<=1", "1", "1"),
    Line("cup a metre and a half along, sitting", sits(), (*WIDE, CHAIR), a("cup", 0.7, 1.4, TOP), "<=1", "3..4", "3..4"),
    Line("cup on the floor beside the chair", sits(), DINING, a("cup", 0.0, -0.5), "<=3", "2..4", "2..4"),
    Line("cup on the floor beside the chair, no table", sits(), (CHAIR,), a("cup", 0.1, -0.5), "<=3", "2..4", "2..4"),
    Line("cup on the floor before the feet", sits(), (CHAIR,), a("cup", 0.8, 0.0), "<=2", "2..4", "2..4"),
    Line("cup on the floor two metres from the chair", sits(), (CHAIR,), a("cup", 2.0, 0.0), "<=1", "4", "4"),
    Line("cup on a board four metres behind the diner", sits(), (*DINING, board("board", (0.4, 0.8, 0.8), -4.0, 0.0, 0.4)), a("cup", -3.9, 0.0, 0.8), "2..4", "4", "4"),
    Line("cup on another table, out of the diner's reach", sits(), (*DINING, board("board", (0.6, 0.6, TOP), 1.5, 0.0, TOP / 2)), a("cup", 1.35, 0.0, TOP), "<=1", "3..4", "3..4"),
    Line("cup beneath the table at the knees", sits(), DINING, a("cup", 0.7, 0.1), "<=4", "2..4", "2..4"),
    # --- Sofa, bench, bed.
    Line("cup on the low table before the sofa", sits(0.05), LOW, a("cup", 0.85, 0.0, 0.42), "<=1", "1..2", "1..2"),
    Line("cup at the far end of the low table", sits(0.05), LOW, a("cup", 1.15, 0.4, 0.42), "<=1", "2..4", "2..4"),
    Line("cup on the sofa beside", sits(0.05), SOFA, a("cup", 0.1, -0.45, 0.43), "<=3", "1..2", "1..2"),
    Line("cup three metres from the sofa", sits(0.05), LOW, a("cup", 3.2, 0.0), "<=1", "4", "4"),
    Line("cup three metres from the sofa, nothing before it", sits(0.05), SOFA, a("cup", 3.2, 0.0), "<=1", "4", "4"),
    Line("cup on the bench beside", sits(), BENCH, a("cup", 0.0, 0.4, 0.45), "<=3", "1..2", "1..2"),
    Line("cup a step from the bench", sits(), BENCH, a("cup", 1.2, 0.0), "<=1", "3..4", "3..4"),
    Line("cup on the chair opposite", stands(), (chair("chair", (0.5, 0.0), HALF_TURN),), a("cup", 0.5, 0.0, 0.45), "<=2", "2..3", "2..3"),
    Line("cup in the corner, a sofa and its table as close as that", sits(0.05), NARROW, a("cup", 2.5, -1.4), "<=2", "4", "4"),
    Line("cup three metres off, somebody behind the chair, a carton before the chest", sits(), HEMMED, a("cup", 0.5, 3.0), "<=2", "4", "4"),
    # --- Shelves.
    Line("cup on the lowest board", stands(), SHELF, a("cup", 0.6, 0.0, 0.02), "<=3", "3..4", "3..4"),
    Line("cup on the board at 0.4 m", stands(), SHELF, a("cup", 0.55, 0.0, 0.4), "<=3", "2..4", "2..4"),
    Line("cup on the board at 0.8 m", stands(), SHELF, a("cup", 0.55, 0.0, 0.8), "<=2", "1..2", "1..2"),
    Line("cup on the board at 1.2 m", stands(), SHELF, a("cup", 0.55, 0.0, 1.2), "<=1", "1..2", "1..2"),
    Line("cup on the board at 1.6 m", stands(), SHELF, a("cup", 0.55, 0.0, 1.6), "<=1", "1..2", "1..2"),
    Line("cup on a board at 2.3 m", stands(), HIGH_SHELF, a("cup", 0.6, 0.0, 2.32), "?", "5", "5"),
    Line("book on the board at 0.8 m", stands(), SHELF, a("book", 0.55, 0.0, 0.8), "<=2", "1..2", "1..2"),
    Line("cup on a shelf beyond arm's length", stands(-1.5), SHELF, a("cup", 0.55, 0.0, 1.2), "<=1", "4", "4"),
    Line("cup on a shelf, coming from behind it", stands(1.5, 0.0, 180), SHELF, a("cup", 0.55, 0.0, 1.2), "4", "4", "4"),
    Line("cup in an open cupboard, low", stands(), OPEN_CUPBOARD, a("cup", 0.55, 0.0, 0.02), "<=4", "3..4", "3..4"),
    Line("cup in an open cupboard at 1 m", stands(), OPEN_CUPBOARD, a("cup", 0.55, 0.0, 1.0), "<=2", "1..2", "1..2"),
    Line("cup in an open wall cupboard", stands(), WALL_CUPBOARD, a("cup", 0.72, 0.0, 1.44), "<=1", "1..3", "1..3"),
    Line("cup in an open wall cupboard, 1.55 m tall", stands(tall=1.55), WALL_CUPBOARD, a("cup", 0.70, 0.0, 1.44), "<=1", "1..4", "1..4"),
    # --- Closed.
    Line("cup in a closed cupboard", stands(), CUPBOARD, a("cup", 0.6, 0.0, 1.0), "5", "5", "5"),
    Line("cup at the bottom of a closed cupboard", stands(), CUPBOARD, a("cup", 0.6, 0.0, 0.02), "5", "5", "5"),
    Line("cup right behind the closed door", stands(), CUPBOARD, a("cup", 0.45, 0.0, 1.0), "5", "5", "5"),
    Line("cup in a closed wall cupboard", stands(), CLOSED_WALL_CUPBOARD, a("cup", 0.72, 0.0, 1.44), "5", "5", "5"),
    Line("pen in a closed drawer", stands(), DRAWER, pen(0.6, 0.0, 0.34), "5", "5", "5"),
    Line("cup in the closed counter", stands(), COUNTER, a("cup", 0.5, 0.0, 0.02), "5", "5", "5"),
    Line("ball in a closed crate on the floor", stands(), (case("crate", (0.3, 0.3, 0.3), 0.5, 0.0, 0.02),), ball(0.08, 0.5, 0.0, 0.02), "5", "5", "5"),
    Line("apple in a closed box on the table", stands(), (*TABLE, case("box", (0.2, 0.2, 0.15), 0.5, 0.0, TOP + 0.02)), a("apple", 0.5, 0.0, TOP + 0.02), "5", "5", "5"),
    Line("apple under a cover on the table, sitting", sits(), (*DINING, case("cover", (0.2, 0.2, 0.15), 0.5, 0.0, TOP, without=("bottom",))), a("apple", 0.5, 0.0, TOP), "5", "5", "5"),
    Line("cup in a room without a door", stands(), CELL, a("cup", 2.0, 0.0), "5", "5", "5"),
    Line("cup just behind the wall of that room", stands(0.6), CELL, a("cup", 1.25, 0.0, 1.0), "5", "5", "5"),
    Line("cup in an open crate on the floor", stands(), (case("crate", (0.3, 0.3, 0.25), 0.5, 0.0, 0.02, without=("top",)),), a("cup", 0.5, 0.0, 0.02), "<=3", "3..4", "3..4"),
    Line("apple in an open box on the table", stands(), (*TABLE, case("box", (0.2, 0.2, 0.12), 0.5, 0.0, TOP + 0.02, without=("top",))), a("apple", 0.5, 0.0, TOP + 0.02), "<=4", "<=2", "<=3"),
    Line("pen in an open drawer", stands(), OPEN_DRAWER, pen(0.4, 0.0, 0.34), "<=3", "2..3", "2..3"),
    Line("apple in an open drawer", stands(), OPEN_DRAWER, a("apple", 0.4, 0.0, 0.34), "<=3", "2..3", "2..3"),
    Line("cup in a cubby open to the front", stands(), (case("cubby", (0.3, 0.35, 0.3), 0.55, 0.0, 1.1, without=("front",)),), a("cup", 0.5, 0.0, 1.1), "<=1", "1..2", "1..2"),
    Line("cup in a cubby open to the back", stands(), (case("cubby", (0.3, 0.35, 0.3), 0.55, 0.0, 1.1, without=("back",)),), a("cup", 0.5, 0.0, 1.1), "4", "4", "4"),
    Line("cup in a closed cupboard on the wall", stands(), (case("cupboard", (0.38, 0.68, 0.58), 0.6, 0.0, 0.76),), a("cup", 0.58, 0.0, 0.76), "5", "5", "5"),
    Line("the same with its front taken away", stands(), (case("cupboard", (0.38, 0.68, 0.58), 0.6, 0.0, 0.76, without=("front",)),), a("cup", 0.58, 0.0, 0.76), "<=2", "1..2", "1..2"),
    Line("ball in a bin of half a metre", stands(), (case("bin", (0.35, 0.35, 0.5), 0.5, 0.0, 0.02, without=("top",)),), ball(0.08, 0.5, 0.0, 0.02), "<=4", "3..4", "3..4"),
    Line("cup in a cage", stands(), (CAGE,), a("cup", 0.55, 0.0, 1.02), "<=1", "5 !closed", "5 !closed"),
    # --- Walls, doors, fences, screens.
    Line("cup behind a wall of 12 m", stands(), LONG_WALL, a("cup", 1.3, 0.0, 0.0), "4", "4", "4"),
    Line("cup at arm's length behind a short wall", stands(0.3), SHORT_WALL, a("cup", 1.0, 0.0, 1.2), "4", "4", "4"),
    Line("cup through the open door", stands(), DOOR, a("cup", 3.5, 0.0), "<=1", "4", "4"),
    Line("cup in the next room, beside the door", stands(), DOOR, a("cup", 2.2, 2.0), "4", "4", "4"),
    Line("cup on the floor behind a fence of 0.9 m", stands(), FENCE, a("cup", 0.6, 0.0, 0.0), "?", "4", "4"),
    Line("cup behind a fence at 0.9 m", stands(), FENCE, a("cup", 0.6, 0.0, 0.85), "<=2", "1..2", "1..2"),
    Line("cup behind a screen of 1.4 m, sitting", sits(), (CHAIR, *HEDGE), a("cup", 2.0, 0.0, 0.5), "3..4", "4", "4"),
    Line("cup behind a box on the table, sitting", sits(), (*DINING, board("box", (0.1, 0.6, 0.3), 0.65, 0.0, TOP + 0.15)), a("cup", 0.85, 0.0, TOP), "2..4", "2..4", "2..4"),
    Line("cup behind a milk carton on the table", stands(), (*TABLE, board("milk", (0.07, 0.07, 0.2), 0.5, 0.0, TOP + 0.1)), a("cup", 0.62, 0.0, TOP), "<=2", "2..4", "2..4"),
    Line("cup between two cartons", stands(), (*TABLE, board("c1", (0.2, 0.2, 0.2), 0.5, 0.19, TOP + 0.1), board("c2", (0.2, 0.2, 0.2), 0.5, -0.19, TOP + 0.1)), a("cup", 0.5, 0.0, TOP), "<=2", "<=2", "<=3"),
    Line("a plane before the cup, seen from its back", stands(), (PlaneWall("screen", "screen", (1.0, 0.0), 0.0, ()),), a("cup", 1.5, 0.0, 1.55), "4", "4", "4"),
    # --- Flat things on a table.
    Line("pen on the table", stands(), TABLE, pen(0.45, 0.0, TOP), "<=2", "<=2", "<=2"),
    Line("pen on the table, sitting", sits(), DINING, pen(0.45, 0.0, TOP), "<=1", "<=2", "<=2"),
    Line("phone on the table", stands(), TABLE, a("phone", 0.45, 0.0, TOP), "<=2", "<=2", "<=2"),
    Line("phone on the table, sitting", sits(), DINING, a("phone", 0.45, 0.0, TOP), "<=1", "<=2", "<=2"),
    Line("plate on the table, sitting", sits(), DINING, a("plate", 0.50, 0.0, TOP), "<=1", "<=2", "<=2"),
    Line("coin on the table, sitting", sits(), DINING, tube(0.023, 0.002, 0.45, -0.1, TOP), "<=1", "<=2", "<=2"),
    Line("book on the table", stands(), TABLE, a("book", 0.45, 0.0, TOP), "<=2", "<=2", "<=2"),
    Line("book on the table, sitting", sits(), DINING, a("book", 0.45, 0.1, TOP), "<=1", "<=2", "<=2"),
    Line("keys on the table, sitting", sits(), DINING, a("keys", 0.45, 0.1, TOP), "<=1", "<=2", "<=2"),
    Line("cube of 1 cm on the table", stands(), TABLE, block((0.01, 0.01, 0.01), 0.45, 0.0, TOP), "<=2", "<=2", "<=2"),
    Line("ruler on the table, sitting", sits(), DINING, block((0.03, 0.30, 0.003), 0.45, 0.0, TOP), "<=1", "<=2", "<=2"),
    Line("card over the edge of the table, sitting", sits(), DINING, block((0.085, 0.055, 0.002), 0.31, 0.0, TOP), "<=1", "<=2", "<=2"),
    Line("plate over the edge of the table", stands(), TABLE, a("plate", 0.36, 0.0, TOP), "<=2", "<=2", "<=2"),
    Line("tray of 40 × 30 cm on the table", stands(), TABLE, block((0.30, 0.40, 0.02), 0.5, 0.0, TOP), "<=2", "<=2", "<=2"),
    Line("pen that sticks out over the edge", stands(), TABLE, pen(0.34, 0.0, TOP, 90), "<=2", "<=2", "<=2"),
    Line("ball that is tracked 3 mm above the table", stands(), TABLE, ball(0.06, 0.45, 0.0, TOP + 0.003), "<=2", "<=2", "<=2"),
    Line("cup that is tracked 1 cm within the table", stands(), TABLE, a("cup", 0.45, 0.0, TOP - 0.01), "<=2", "<=2", "<=2"),
    Line("cup that is tracked 1 cm above the table, sitting", sits(), DINING, a("cup", 0.45, 0.0, TOP + 0.01), "<=1", "1", "1"),
    # --- Wide things: two hands.
    Line("carton of 30 cm on the table, sitting", sits(), DINING, block((0.3, 0.3, 0.3), 0.50, 0.0, TOP), "<=1", "1..2", "1..2"),
    Line("carton of 30 cm on the table", stands(), TABLE, block((0.3, 0.3, 0.3), 0.50, 0.0, TOP), "<=1", "1..2", "1..2"),
    Line("ball of 15 cm on the table", stands(), TABLE, ball(0.15, 0.45, 0.0, TOP), "<=2", "1..2", "1..2"),
    Line("jar of 11 cm on the table, sitting", sits(), DINING, tube(0.11, 0.12, 0.45, -0.2, TOP), "<=1", "1..2", "1..2"),
    Line("pot on the counter", stands(), COUNTER, a("pot", 0.5, 0.0, 0.91), "<=1", "1..2", "1..2"),
    Line("ball of 30 cm held up before the chest", stands(), (), ball(0.3, 0.45, 0.0, 1.0), "<=1", "1..2", "1..2"),
    Line("block of 1.2 × 1.2 × 2 m", stands(-1.0), (), block((1.2, 1.2, 2.0), 0.5, 0.0), "<=1", "1..4", "5"),
    Line("mug of 9 cm with a handle, sitting", sits(), DINING, MUG, "<=1", "1..2", "1..2"),
    # --- The own lap.
    Line("cup on the own lap", sits(), (CHAIR,), tube(0.07, 0.06, 0.22, 0.0, 0.57), "1", "1", "1"),
    Line("cup on the own lap, 1.55 m tall", sits(tall=1.55), (CHAIR,), tube(0.07, 0.06, 0.22, 0.0, 0.55), "1", "1", "1"),
    Line("plate on the knees", sits(), (CHAIR,), a("plate", 0.38, 0.0, 0.58), "1", "1", "1"),
    # --- Small, far, seen through.
    Line("key of 2 cm three metres ahead", stands(), (), ball(0.02, 3.1, 0.1, 1.59), "<=1", "4", "4"),
    Line("ball of 8 cm six metres ahead", stands(), (), ball(0.08, 6.1, 0.35, 1.56), "<=1", "4", "4"),
    Line("coin on a table two metres off", stands(-1.7), TABLE, tube(0.023, 0.002, 0.45, 0.0, TOP), "<=1", "4", "4"),
    Line("pen on the floor three metres ahead", stands(), (), pen(3.0, 0.2), "<=1", "4", "4"),
    Line("cup nine metres ahead", stands(), (), a("cup", 9.0, 0.4, 1.0), "<=1", "4", "4 !walk"),
    Line("cup behind a pane of glass, sitting", sits(-0.05), (*DINING, PANE), a("cup", 0.65, 0.0, TOP), "<=1", "2..4", "2..4"),
    Line("cup in a case of glass", stands(), (*TABLE, case("case", (0.3, 0.3, 0.3), 0.55, 0.0, TOP + 0.02, rgba=GLASS, thick=0.006)), a("cup", 0.55, 0.0, TOP + 0.02), "<=2", "5", "5"),
    Line("cup behind a glass wall", stands(), (board("glass", (0.01, 4.0, 2.5), 0.4, 0.0, 1.25, GLASS),), a("cup", 0.7, 0.0, 1.2), "<=1", "4", "4"),
    # --- Necks.
    Line("cup on the wall at 2.3 m, a metre off", stands(), (), a("cup", 1.0, 0.0, 2.3), "<=1", "5", "5"),
    Line("cup beside, at the height of the eyes", stands(), (), a("cup", 0.0, -0.5, 1.6), "<=2", "1..2", "1..2"),
    Line("cup aslant behind, at the height of the eyes", stands(), (), a("cup", -1.0, -1.0, 1.6), "2", "4", "4"),
    Line("cup beneath the bed, 60 cm in", stands(-0.9), (board("bed", (1.0, 2.0, 0.2), 0.8, 0.0, 0.45),), a("cup", 0.9, 0.0), "3..4", "?", "?"),
    # --- Robots.
    Line("pr2: cup before it at 0.9 m", robot("pr2"), (), a("cup", 0.75, -0.2, 0.9), "<=1", "1..2", "1..2"),
    Line("pr2: cup on a table", robot("pr2"), (table("table", (0.95, 0.0)),), a("cup", 0.72, -0.2, TOP), "<=1", "1..2", "1..2"),
    Line("pr2: cup three metres off", robot("pr2"), (), a("cup", 3.0, 0.0, 0.9), "<=1", "4", "4"),
    Line("pr2: cup at 2.4 m", robot("pr2"), (), a("cup", 0.6, 0.0, 2.4), "?", "5", "5"),
    Line("pr2: cup in a closed cupboard", robot("pr2", -0.3), CUPBOARD, a("cup", 0.6, 0.0, 1.0), "5", "5", "5"),
    Line("pr2: cup in a room without a door", robot("pr2"), CELL, a("cup", 2.0, 0.0, 0.8), "5", "5", "5"),
    Line("pr2: carton of 30 cm before it", robot("pr2"), (), block((0.3, 0.3, 0.3), 0.75, 0.0, 0.75), "<=1", "1..2", "1..2"),
    Line("talos: cup on a table", robot("talos"), (table("table", (0.85, 0.0)),), a("cup", 0.55, -0.2, TOP), "<=1", "1..2", "1..2"),
    Line("talos: cup three metres off", robot("talos"), (), a("cup", 3.0, 0.0, 0.9), "<=1", "4", "4"),
    Line("talos: cup in a closed cupboard", robot("talos", -0.1), CUPBOARD, a("cup", 0.6, 0.0, 1.0), "5", "5", "5"),
    Line("hrp2: cup before it at 1 m", robot("hrp2"), (), tube(0.05, 0.1, 0.45, -0.2, 0.95), "<=1", "1..2", "1..2"),
    Line("hrp2: cup four metres off", robot("hrp2"), (), tube(0.05, 0.1, 4.0, 0.0, 0.95), "<=1", "4", "4"),
    Line("jido: cup before it at 0.9 m", robot("jido"), (), tube(0.05, 0.1, 0.75, 0.0, 0.85), "?", "1", "1"),
    Line("jido: carton of 30 cm, with its one arm", robot("jido"), (), block((0.3, 0.3, 0.3), 0.75, 0.0, 0.75), "?", "1..4", "5"),
)
# fmt: on


@cache
def efforts(number: int) -> SceneEfforts:
    return SceneEfforts(Stage(LINES[number].scene()))


def cases() -> Iterator[object]:
    """Every line with every ability that it says something about."""
    for number, line in enumerate(LINES):
        for ability in ABILITIES:
            expected, marks = line.expected(ability), [needs(line.body.profile)]
            if expected.wrong:
                marks.append(pytest.mark.xfail(reason=WRONG_TODAY[expected.wrong], raises=AssertionError))
            if len(expected.levels) < 6:
                yield pytest.param(number, ability, marks=marks, id=f"{line.what}-{ability}")


@pytest.mark.parametrize(("number", "ability"), list(cases()))
def test_what_any_person_would_say(number: int, ability: Ability) -> None:
    effort = efforts(number).effort("P", "thing", ability)
    assert effort.level in LINES[number].expected(ability).levels, effort.reason


def test_there_are_enough_lines_and_each_has_its_name() -> None:
    assert len({line.what for line in LINES}) == len(LINES) >= 120


@pytest.mark.parametrize(
    ("text", "levels", "wrong"),
    [
        ("3", {3}, None),
        ("<=2", {0, 1, 2}, None),
        (">=4 !wall", {4, 5}, "wall"),
        ("3..4 !two hands", {3, 4}, "two hands"),
        ("?", {0, 1, 2, 3, 4, 5}, None),
    ],
)
def test_expected_levels_are_read(text: str, levels: set[int], wrong: str | None) -> None:
    assert Expected.of(text) == Expected(frozenset(levels), wrong)
