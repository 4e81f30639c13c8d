"""The demonstrations of *give* (7.6): held out, and taken by the other's left or right hand."""

from __future__ import annotations

from taskgist.demonstrator.living_room import CLOSE_M, STANDING_M, TABLE, left, on_table, right
from taskgist.demonstrator.means import Roles
from taskgist.demonstrator.offering import hand_over
from taskgist.demonstrator.room import Room
from taskgist.demonstrator.study.demonstration import Demonstration

GIVE = (
    Demonstration(  # both sit; the other looks up from a book and takes it with the left hand
        Room(
            "give_a",
            (left(1.76, CLOSE_M + 0.03), right(1.68, CLOSE_M)),
            (
                on_table("cup", -0.26, 0.44),
                on_table("book", 0.20, -0.11, 20),
                on_table("bottle", -0.05, -0.52),
                on_table("white_box", -0.20, -0.22, 90),
            ),
            TABLE,
        ),
        hand_over(Roles("P1", "P2", "cup", "left", "book"), taking="left", distance_m=0.46),
    ),
    Demonstration(  # both stand; it was behind the box, and the other stood back from the table
        Room(
            "give_b",
            (left(1.82, STANDING_M + 0.05, posture="standing"), right(1.70, 0.90, 0.10, posture="standing")),
            (
                on_table("wooden_cube", -0.22, 0.05),
                on_table("white_box", -0.02, 0.05),
                on_table("tape", -0.20, 0.45),
                on_table("book", 0.05, -0.45, -10),
            ),
            TABLE,
        ),
        hand_over(Roles("P1", "P2", "wooden_cube", "left", "book"), taking="left", distance_m=0.60),
    ),
    Demonstration(  # both sit; the other watches it all the time, and takes it with the hand that lay on the table
        Room(
            "give_c",
            (left(1.80, CLOSE_M + 0.04), right(1.66, CLOSE_M)),
            (
                on_table("cup", -0.18, -0.15),
                on_table("book", 0.10, -0.50, 35),
                on_table("white_box", 0.0, 0.50),
                on_table("tape", 0.22, -0.30),
            ),
            TABLE,
        ),
        hand_over(
            Roles("P1", "P2", "cup", "right", "cup"),
            taking="right",
            distance_m=0.50,
            rests_m=(0.22, 0.20, TABLE.height_m),
        ),
    ),
)
