"""The demonstrations of *put away* (7.7): four, in different situations.

The paper tells no more than that. Ours differ in who sits and stands, what is put away with which hand, from how near
and to how far, on which table, and in whether the target agent watches what is put away or is busy with something else.
"""

from __future__ import annotations

from taskgist.demonstrator.living_room import BACK_M, CLOSE_M, HIGH_TABLE, STANDING_M, TABLE, left, on_table, right
from taskgist.demonstrator.means import Roles
from taskgist.demonstrator.removing import put_far_from
from taskgist.demonstrator.room import Room
from taskgist.demonstrator.study.demonstration import Demonstration

PUT_AWAY = (
    Demonstration(  # from beside somebody's hands to the other side of the table, under its eyes
        Room(
            "put_away_a",
            (left(1.80, CLOSE_M), right(1.66, CLOSE_M)),
            (
                on_table("cup", 0.14, -0.10),
                on_table("book", 0.20, 0.45, 20),
                on_table("bottle", -0.20, -0.50),
                on_table("white_box", 0.0, 0.55, 90),
            ),
            TABLE,
        ),
        put_far_from(Roles("P1", "P2", "cup", "right", "cup"), distance_m=0.92),
    ),
    Demonstration(  # somebody stands and is busy; who sits puts it to its own side
        Room(
            "put_away_b",
            (left(1.74, CLOSE_M, 0.35), right(1.70, STANDING_M, -0.25, posture="standing")),
            (
                on_table("cup", 0.12, 0.24),
                on_table("bottle", -0.22, -0.50),
                on_table("book", 0.22, -0.42, 20),
                on_table("tape", 0.20, 0.55),
            ),
            TABLE,
        ),
        put_far_from(Roles("P1", "P2", "cup", "left", "bottle", "bottle"), distance_m=1.17),
    ),
    Demonstration(  # both stand at a high table; from within arm's reach to its far corner, under the other's eyes
        Room(
            "put_away_c",
            (left(1.82, STANDING_M, 0.35, posture="standing"), right(1.70, STANDING_M, -0.25, posture="standing")),
            (
                on_table("wooden_cube", 0.15, -0.10, table=HIGH_TABLE),
                on_table("book", 0.20, -0.50, 20, table=HIGH_TABLE),
                on_table("bottle", -0.20, -0.45, table=HIGH_TABLE),
                on_table("tape", 0.10, 0.50, table=HIGH_TABLE),
            ),
            HIGH_TABLE,
        ),
        put_far_from(Roles("P1", "P2", "wooden_cube", "left", "wooden_cube"), distance_m=1.17),
    ),
    Demonstration(  # from near somebody who sits back, busy with a book, to where it had to stand up
        Room(
            "put_away_d",
            (left(1.78, CLOSE_M, 0.05), right(1.82, BACK_M, -0.15)),
            (
                on_table("bottle", 0.12, 0.18),
                on_table("book", 0.26, -0.42, 20),
                on_table("cup", -0.20, -0.50),
                on_table("wooden_cube", 0.10, 0.58),
            ),
            TABLE,
        ),
        put_far_from(Roles("P1", "P2", "bottle", "right", "book", "book"), distance_m=1.22),
    ),
)
"""In order."""
