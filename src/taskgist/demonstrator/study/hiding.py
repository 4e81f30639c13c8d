"""The demonstrations of *hide* (7.4): put behind the white box or the screen, as the target agent sees them."""

from __future__ import annotations

from taskgist.demonstrator.living_room import CLOSE_M, TABLE, left, on_table, right
from taskgist.demonstrator.means import Roles, put_behind
from taskgist.demonstrator.room import Room
from taskgist.demonstrator.study.demonstration import Demonstration

HIDE = (
    Demonstration(  # far from somebody who sits beside the table, to near but behind the box
        Room(
            "hide_a",
            (left(1.78, CLOSE_M), right(1.66, 0.70, -0.35, turned_deg=-70)),
            (
                on_table("cup", -0.22, 0.30),
                on_table("white_box", 0.25, -0.22, -5),
                on_table("book", 0.10, 0.50, 10),
                on_table("tape", -0.15, -0.45),
            ),
            TABLE,
        ),
        put_behind(Roles("P1", "P2", "cup", "right", "cup"), occluder="white_box"),
    ),
    Demonstration(  # from under the eyes to behind the screen, of somebody with a table over the thighs
        Room(
            "hide_b",
            (left(1.78, CLOSE_M), right(1.66, CLOSE_M)),
            (
                on_table("wooden_cube", 0.18, -0.34),
                on_table("screen", 0.06, 0.05),
                on_table("book", -0.15, 0.52, 5),
                on_table("bottle", 0.25, 0.50),
            ),
            TABLE,
        ),
        put_behind(Roles("P1", "P2", "wooden_cube", "right"), occluder="screen"),
    ),
    Demonstration(  # always within reach of somebody who sits beside the table, in the end behind the screen
        Room(
            "hide_c",
            (left(1.84, CLOSE_M), right(1.70, 0.70, 0.35, turned_deg=70)),
            (
                on_table("wooden_cube", 0.24, -0.10, -15),
                on_table("screen", 0.25, 0.32),
                on_table("cup", 0.0, -0.50),
                on_table("tape", -0.20, 0.45),
            ),
            TABLE,
        ),
        put_behind(Roles("P1", "P2", "wooden_cube", "left", "wooden_cube"), occluder="screen"),
    ),
)
"""In order."""
