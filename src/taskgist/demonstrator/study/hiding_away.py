"""The demonstrations of *hide away* (7.8): four, in different situations.

The paper tells no more than that. In ours, things end behind the screen or the box, where the target agent neither sees
them nor gets at them as easily as before; people, things, hands and the effort that it would take differ.
"""

from __future__ import annotations

from taskgist.demonstrator.living_room import TABLE, left, on_table, right
from taskgist.demonstrator.means import Roles
from taskgist.demonstrator.removing import put_behind_far
from taskgist.demonstrator.room import Room
from taskgist.demonstrator.studies import CLOSE_M, STANDING_M, Demonstration
from taskgist.demonstrator.study.high_table import HIGH_TABLE, on_high_table

NEARER_M = 0.88
"""Distance of a pelvis from the middle of the table: sitting with the knees right before it."""

HIDE_AWAY = (
    Demonstration(  # from somebody's own edge of the table to the far corner; the performer stands
        Room(
            "hide_away_a",
            (left(1.84, STANDING_M + 0.05, 0.0, posture="standing"), right(1.66, NEARER_M, -0.20)),
            (
                on_table("wooden_cube", 0.27, -0.05),
                on_table("white_box", -0.07, 0.38, -20),
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
            (left(1.82, STANDING_M, 0.35, posture="standing"), right(1.70, STANDING_M, -0.25, posture="standing")),
            (
                on_high_table("wooden_cube", 0.15, -0.10),
                on_high_table("screen", -0.08, 0.25, -8),
                on_high_table("bottle", -0.15, -0.45),
                on_high_table("book", 0.22, -0.50, 5),
            ),
            HIGH_TABLE,
        ),
        put_behind_far(Roles("P1", "P2", "wooden_cube", "right", "wooden_cube"), occluder="screen"),
    ),
    Demonstration(  # from beside somebody who looks elsewhere to where it had to stand up
        Room(
            "hide_away_c",
            (left(1.76, CLOSE_M, -0.08), right(1.62, NEARER_M, -0.14)),
            (
                on_table("cup", 0.18, -0.44),
                on_table("screen", 0.05, 0.20),
                on_table("bottle", 0.25, 0.50),
                on_table("book", -0.15, -0.50, 5),
            ),
            TABLE,
        ),
        put_behind_far(Roles("P1", "P2", "cup", "right"), occluder="screen"),
    ),
    Demonstration(  # from under somebody's eyes to behind a near screen
        Room(
            "hide_away_d",
            (left(1.80, CLOSE_M, -0.05), right(1.66, NEARER_M, -0.20)),
            (
                on_table("cup", 0.28, -0.28),
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
