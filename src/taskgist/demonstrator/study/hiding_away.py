"""The demonstrations of *hide away* (7.8): four, in different situations.

The paper tells no more than that. In ours, things end behind the screen or the box, where the target agent neither sees
them nor gets at them as easily as before; people, things, hands and the effort that it would take differ.
"""

from __future__ import annotations

from taskgist.demonstrator.living_room import CLOSE_M, HIGH_TABLE, STANDING_M, TABLE, left, on_table, right
from taskgist.demonstrator.means import Roles
from taskgist.demonstrator.removing import put_behind_far
from taskgist.demonstrator.room import Room
from taskgist.demonstrator.study.demonstration import Demonstration

NEARER_M = 0.88
"""Distance of a pelvis from the middle of the table: sitting with the knees right before it."""

HIDE_AWAY = (
    Demonstration(  # from somebody's own edge of the table to the far corner
        Room(
            "hide_away_a",
            (left(1.84, CLOSE_M, -0.08), right(1.66, NEARER_M, -0.20)),
            (
                on_table("wooden_cube", 0.27, -0.08),
                on_table("white_box", -0.03, 0.44, -25),
                on_table("book", -0.10, -0.50, 10),
                on_table("tape", 0.20, 0.55),
            ),
            TABLE,
        ),
        put_behind_far(Roles("P1", "P2", "wooden_cube", "left", "wooden_cube"), occluder="white_box"),
    ),
    Demonstration(  # both stand at a high table
        Room(
            "hide_away_b",
            (left(1.82, STANDING_M, 0.30, posture="standing"), right(1.70, STANDING_M, -0.25, posture="standing")),
            (
                on_table("wooden_cube", 0.16, -0.03, table=HIGH_TABLE),
                on_table("screen", -0.08, 0.25, -8, table=HIGH_TABLE),
                on_table("bottle", -0.15, -0.45, table=HIGH_TABLE),
                on_table("book", 0.22, -0.50, 5, table=HIGH_TABLE),
            ),
            HIGH_TABLE,
        ),
        put_behind_far(Roles("P1", "P2", "wooden_cube", "right", "wooden_cube"), occluder="screen"),
    ),
    Demonstration(  # from beside somebody who looks elsewhere to where it had to stand up
        Room(
            "hide_away_c",
            (left(1.76, CLOSE_M, -0.10), right(1.62, NEARER_M, -0.14)),
            (
                on_table("bottle", 0.13, -0.51),
                on_table("screen", 0.05, 0.20),
                on_table("cup", 0.25, 0.50),
                on_table("book", -0.20, -0.40, 5),
            ),
            TABLE,
        ),
        put_behind_far(Roles("P1", "P2", "bottle", "right"), occluder="screen"),
    ),
    Demonstration(  # from under somebody's eyes to behind a near screen
        Room(
            "hide_away_d",
            (left(1.80, CLOSE_M, -0.05), right(1.74, NEARER_M, -0.20)),
            (
                on_table("cup", 0.29, -0.28),
                on_table("screen", 0.20, 0.0),
                on_table("bottle", 0.20, 0.50),
                on_table("book", -0.15, 0.55, 5),
            ),
            TABLE,
        ),
        put_behind_far(Roles("P1", "P2", "cup", "right", "cup"), occluder="screen"),
    ),
)
"""In order."""
