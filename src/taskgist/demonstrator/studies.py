"""The demonstrations of the study: *show* and *hide* (7.3, 7.4), as rooms and means.

The paper tells who sits, what is shown, how each demonstration ends, and that arrangements differ; sizes and places are
ours. What differs between the demonstrations is staged by geometry: how far from the target agent the object begins
and ends, what stands in the line of sight, whether a table over the thighs keeps somebody from standing up, what the
target agent looks at before.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from taskgist.demonstrator.demonstration import demonstrate
from taskgist.demonstrator.furniture import Table
from taskgist.demonstrator.living_room import TABLE, left, on_table, right
from taskgist.demonstrator.means import Means, Roles, hold_up, put_behind, put_on_top
from taskgist.demonstrator.room import Room
from taskgist.recording import Recording

CLOSE_M, BACK_M, STANDING_M = 0.67, 0.93, 0.63
"""Distances of a pelvis from the middle of the table: sitting with the thighs under it, sitting back with the knees
before it (room to stand up), standing at it."""
WIDE_TABLE = Table("table", size_m=(0.90, 1.40, TABLE.height_m))


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
                on_table("wooden_cube", 0.17, 0.0),
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

STUDIES: Mapping[str, tuple[Demonstration, ...]] = {"show": SHOW, "hide": HIDE}
"""The demonstrations by task, in the paper's order."""
