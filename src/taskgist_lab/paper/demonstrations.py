"""The paper's study: six tasks, 23 demonstrations, each a room and what is done in it (7.3–7.8)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from taskgist.recording.recording import Recording
from taskgist_lab.simulator.demonstration import demonstrate
from taskgist_lab.simulator.means import (
    Means,
    Roles,
    hand_over,
    hold_up,
    lift_onto,
    put_behind,
    put_behind_far,
    put_far_from,
    put_on_top,
    put_within_reach,
)
from taskgist_lab.simulator.room import (
    CLOSE_M,
    GREEN,
    HIGH_TABLE,
    LIVING_ROOM_BACK_M,
    STANDING_M,
    TABLE,
    Room,
    Table,
    Thing,
    left,
    on_table,
    right,
)

# --- A demonstration of the study: a room, and what is done in it.


@dataclass(frozen=True)
class Demonstration:
    """One demonstration of the study.

    Attributes:
        room: Where it takes place; named after the task and the letter of the paper's figure.
        means: What is done in the room's scene.
    """

    room: Room
    means: Means

    @property
    def name(self) -> str:
        """Its name."""
        return self.room.name

    def record(self, seed: int, *, distance_m: float = 0.0, angle_rad: float = 0.0) -> Recording:
        """Play and record it.

        Args:
            seed: Seed of all variation.
            distance_m: How far people and things are displaced at most, in x and y.
            angle_rad: How far they are turned at most.

        Raises:
            SceneError: The displaced arrangement leaves no way to do it.
        """
        room = self.room.varied(np.random.default_rng(seed), distance_m=distance_m, angle_rad=angle_rad)
        scene = room.scene()
        return demonstrate(self.means(scene), scene, seed=seed, name=self.name)


# --- The demonstrations of *give* (7.6): held out, and taken by the other's left or right hand.

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


# --- The demonstrations of *hide* (7.4): put behind the white box or the screen, as the target agent sees them.

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
    Demonstration(  # from under somebody's eyes to behind a screen over which a short person does not see
        Room(
            "hide_b",
            (left(1.78, CLOSE_M), right(1.58, CLOSE_M)),
            (
                on_table("wooden_cube", 0.18, -0.34),
                on_table("screen", -0.13, 0.05),
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


# --- The demonstrations of *hide away* (7.8): four, in different situations.
#
# The paper tells no more than that. In ours, things end behind the screen or the box, where the target agent neither
# sees them nor gets at them as easily as before; people, things, hands and the effort that it would take differ.

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
            (left(1.82, STANDING_M, 0.30, posture="standing"), right(1.62, STANDING_M, -0.25, posture="standing")),
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


# --- The demonstrations of *make accessible* (7.5): put to where it takes less to have it.
#
# The first three are those of Fig. 2b-d: a green bottle, which stood out of reach behind a box, is put to where
# somebody who sits back from the table gets it by standing up and leaning, by stretching out an arm, or by leaning. In
# the other two the target agent stands, and sees the bottle from the beginning.


def bottle(x: float, y: float) -> Thing:
    """A small bottle on the table, lower than the white box: who stands sees it behind the box, who sits does not."""
    return Thing("bottle", (0.065, 0.20), (x, y, TABLE.height_m), rgba=GREEN)


ACCESSIBLE = (
    Demonstration(  # Fig. 2b: to the middle of the table
        Room(
            "accessible_a",
            (left(1.78, CLOSE_M), right(1.68, LIVING_ROOM_BACK_M + 0.07, 0.30)),
            (
                bottle(-0.25, -0.46),
                on_table("white_box", -0.10, -0.36, 32),
                on_table("book", 0.20, 0.50, 20),
                on_table("cup", 0.20, -0.45),
            ),
            TABLE,
        ),
        put_within_reach(Roles("P1", "P2", "bottle", "right"), distance_m=1.05),
    ),
    Demonstration(  # Fig. 2c: to the edge of the table before the other
        Room(
            "accessible_b",
            (left(1.84, 0.60, posture="standing"), right(1.70, LIVING_ROOM_BACK_M, 0.30)),
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
            (left(1.80, CLOSE_M, 0.05), right(1.66, LIVING_ROOM_BACK_M + 0.05, 0.30)),
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


# --- The demonstrations of *put away* (7.7): four, in different situations.
#
# The paper tells no more than that. Ours differ in who sits and stands, what is put away with which hand, from how
# near and to how far, on which table, and in whether the target agent watches what is put away or is busy with
# something else.

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
            (left(1.78, CLOSE_M, 0.05), right(1.82, LIVING_ROOM_BACK_M, -0.15)),
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


# --- The demonstrations of *show* (7.3): three are held up before the face, one is put on top of the white box.

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
            (left(1.74, LIVING_ROOM_BACK_M), right(1.82, CLOSE_M)),
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


# --- The demonstrations of the paper's study: six tasks, 23 demonstrations (7.3-7.8).
#
# The paper tells who sits, what is shown, how each demonstration ends, and that arrangements differ; sizes and places
# are ours. What differs between the demonstrations is staged by geometry: how far from the target agent the object
# begins and ends, what stands in the line of sight, whether a table over the thighs keeps somebody from standing up,
# what the target agent looks at before.

STUDY: Mapping[str, tuple[Demonstration, ...]] = {
    "show": SHOW,
    "hide": HIDE,
    "make accessible": ACCESSIBLE,
    "give": GIVE,
    "put away": PUT_AWAY,
    "hide away": HIDE_AWAY,
}
"""By task, in the paper's order."""

__all__ = ["STUDY", "Demonstration"]
