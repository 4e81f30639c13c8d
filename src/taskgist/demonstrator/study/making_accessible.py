"""The demonstrations of *make accessible* (7.5): put to where it takes less to have it.

The first three are those of Fig. 2b-d: a green bottle, which stood out of reach behind a box, is put to where somebody
who sits back from the table gets it by standing up and leaning, by stretching out an arm, or by leaning. In the other
two the target agent stands, and sees the bottle from the beginning.
"""

from __future__ import annotations

from taskgist.demonstrator.furniture import Thing
from taskgist.demonstrator.living_room import BACK_M, CLOSE_M, GREEN, STANDING_M, TABLE, left, on_table, right
from taskgist.demonstrator.means import Roles
from taskgist.demonstrator.offering import lift_onto, put_within_reach
from taskgist.demonstrator.room import Room
from taskgist.demonstrator.study.demonstration import Demonstration


def bottle(x: float, y: float) -> Thing:
    """A small bottle on the table, lower than the white box: who stands sees it behind the box, who sits does not."""
    return Thing("bottle", (0.065, 0.20), (x, y, TABLE.height_m), rgba=GREEN)


ACCESSIBLE = (
    Demonstration(  # Fig. 2b: to the middle of the table
        Room(
            "accessible_a",
            (left(1.78, CLOSE_M), right(1.68, BACK_M + 0.07, 0.30)),
            (
                bottle(-0.25, -0.46),
                on_table("white_box", -0.10, -0.36, 32),
                on_table("book", 0.20, 0.50, 20),
                on_table("cup", 0.20, -0.45),
            ),
            TABLE,
        ),
        put_within_reach(Roles("P1", "P2", "bottle", "right"), distance_m=1.15),
    ),
    Demonstration(  # Fig. 2c: to the edge of the table before the other
        Room(
            "accessible_b",
            (left(1.84, 0.60, posture="standing"), right(1.70, BACK_M, 0.30)),
            (
                bottle(-0.25, -0.46),
                on_table("white_box", -0.10, -0.36, 32),
                on_table("book", -0.20, 0.50, 20),
                on_table("tape", 0.20, -0.45),
            ),
            TABLE,
        ),
        put_within_reach(Roles("P1", "P2", "bottle", "right"), distance_m=0.60),
    ),
    Demonstration(  # Fig. 2d: half way
        Room(
            "accessible_c",
            (left(1.80, CLOSE_M, 0.05), right(1.66, BACK_M + 0.05, 0.30)),
            (
                bottle(-0.24, -0.47),
                on_table("white_box", -0.10, -0.36, 38),
                on_table("book", 0.05, 0.55, -20),
                on_table("cup", 0.25, -0.40),
            ),
            TABLE,
        ),
        put_within_reach(Roles("P1", "P2", "bottle", "right"), distance_m=0.90),
    ),
    Demonstration(  # from where the other would have to lean, onto the box
        Room(
            "accessible_d",
            (left(1.76, CLOSE_M + 0.03), right(1.64, STANDING_M, posture="standing")),
            (
                on_table("wooden_cube", -0.20, -0.25),
                on_table("white_box", 0.16, 0.02),
                on_table("book", -0.05, -0.50, 20),
                on_table("cup", 0.05, 0.45),
            ),
            TABLE,
        ),
        lift_onto(Roles("P1", "P2", "wooden_cube", "right", "wooden_cube"), of="white_box"),
    ),
    Demonstration(  # from the far corner of the table, to which the other would have to walk, onto the box
        Room(
            "accessible_e",
            (left(1.82, 0.60, posture="standing"), right(1.70, 0.72, 0.40, posture="standing")),
            (
                bottle(-0.26, -0.45),
                on_table("white_box", 0.22, 0.28, 40),
                on_table("book", -0.20, 0.50, 20),
                on_table("tape", 0.28, -0.20),
            ),
            TABLE,
        ),
        lift_onto(Roles("P1", "P2", "bottle", "left", "bottle"), of="white_box"),
    ),
)
