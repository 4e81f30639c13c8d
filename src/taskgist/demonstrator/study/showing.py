"""The demonstrations of *show* (7.3): three are held up before the face, one is put on top of the white box."""

from __future__ import annotations

from taskgist.demonstrator.furniture import Table
from taskgist.demonstrator.living_room import BACK_M, CLOSE_M, STANDING_M, TABLE, left, on_table, right
from taskgist.demonstrator.means import Roles, hold_up, put_on_top
from taskgist.demonstrator.room import Room
from taskgist.demonstrator.study.demonstration import Demonstration

WIDE_TABLE = Table("table", size_m=(0.90, 1.40, TABLE.height_m))

SHOW = (
    Demonstration(  # from the middle of the table to right before the face
        Room(
            "show_a",
            (left(1.80, CLOSE_M), right(1.66, CLOSE_M)),
            (
                on_table("cup", -0.20, -0.44),
                on_table("book", 0.22, 0.34, 20),
                on_table("bottle", -0.25, 0.30),
                on_table("white_box", 0.0, 0.55, 90),
            ),
            TABLE,
        ),
        hold_up(Roles("P1", "P2", "cup", "right")),
    ),
    Demonstration(  # from behind the box, far from somebody who sits back
        Room(
            "show_b",
            (left(1.74, BACK_M), right(1.82, CLOSE_M)),
            (
                on_table("wooden_cube", 0.22, 0.0),
                on_table("white_box", -0.04, 0.0),
                on_table("tape", -0.20, 0.35),
                on_table("book", 0.05, -0.45, -10),
            ),
            TABLE,
        ),
        hold_up(Roles("P2", "P1", "wooden_cube", "right")),
    ),
    Demonstration(  # from under the eyes of somebody who looks elsewhere, to beyond its reach
        Room(
            "show_c",
            (left(1.84, CLOSE_M + 0.10, 0.15), right(1.66, CLOSE_M + 0.10)),
            (
                on_table("wooden_cube", 0.21, 0.32),
                on_table("book", 0.35, -0.44, 35),
                on_table("white_box", -0.20, -0.50, 90),
                on_table("bottle", -0.05, -0.20),
            ),
            WIDE_TABLE,
        ),
        hold_up(Roles("P1", "P2", "wooden_cube", "left", "book"), distance_m=0.95),
    ),
    Demonstration(  # both stand; from behind the box to its top
        Room(
            "show_d",
            (left(1.82, STANDING_M, posture="standing"), right(1.70, STANDING_M, posture="standing")),
            (
                on_table("wooden_cube", -0.19, -0.08),
                on_table("white_box", -0.02, -0.05),
                on_table("cup", 0.20, 0.35),
                on_table("book", -0.05, 0.45, 15),
            ),
            TABLE,
        ),
        put_on_top(Roles("P1", "P2", "wooden_cube", "right"), of="white_box"),
    ),
)
"""In order."""
