"""Efforts and their evidence as values: which miss is told, what becomes JSON, and that neither needs geometry."""

from __future__ import annotations

import itertools
import json
import math
import pickle
import subprocess
import sys

import pytest

from taskgist.language.efforts import why
from taskgist.perspective.effort import (
    TOLD_FIRST,
    Amount,
    BlockedApproaches,
    Blocking,
    Effort,
    Evidence,
    Grasped,
    GraspedByBoth,
    Held,
    Hindrance,
    Miss,
    Occlusion,
    OutOfReach,
    Quantity,
    Reached,
    Reason,
    Visibility,
    evidence_document,
    nearest_miss,
)

TABLE = Blocking("torso", "table", 0.02)


def by(reason: Reason, text: str, value: float | None = None, unit: str = "m") -> Miss:
    return Miss(reason, text, None if value is None else Quantity(value, unit))  # type: ignore[arg-type]


HAND = [
    by(Reason.TOO_WIDE, "too wide (0.18 m > 0.10 m)"),
    by(Reason.COLLISION, "Lean_Torso is blocked: torso against table, 0.02 m deep"),
    by(Reason.COLLISION, "Make_Standing is blocked: legs against table, 0.01 m deep"),
    by(Reason.NO_FREE_GRASP, "every approach blocked by box"),
    by(Reason.FROM_BEHIND, "could only be grasped from behind"),
    by(Reason.ONE_HAND, "it takes both hands, and only one gets there"),
    by(Reason.OUT_OF_SECTOR, "outside the sector of the left arm"),
    by(Reason.TOO_FAR, "0.71 m from the right shoulder, 1.0 mm beyond the arm", 0.001),
    by(Reason.TOO_FAR, "1.70 m from the left shoulder, 1.00 m beyond the arm", 1.0),
    by(Reason.NO_STANDING, "Make_Standing is blocked: legs against table, 0.01 m deep"),
    by(Reason.NO_WALKING, "cannot move about"),
    by(Reason.NO_ARM, "no arm may be stretched out"),
    by(Reason.NO_POSTURE, "no other posture to take"),
    by(Reason.NOT_HELD, "not held"),
    by(Reason.NO_TORSO, "the torso does not move"),
]
EYE = [
    by(Reason.COLLISION, "Pan_Head is blocked: head against lamp, 0.03 m deep"),
    by(Reason.TOO_SMALL, "smaller than a pixel", 0.01, "rad"),
    by(Reason.OCCLUDED, "occluded by box", 0.02, "rad"),
    by(Reason.OCCLUDED, "occluded by wall", 0.02, "rad"),
    by(Reason.BESIDE_GAZE, "in view, but 40° beside the gaze (cone 30°)", 0.7, "rad"),
    by(Reason.OUT_OF_VIEW, "out of view, 170° beside the gaze (cone 30°)", 2.97, "rad"),
    by(Reason.BEYOND_NECK, "no nearer than 31° to the gaze", 0.54, "rad"),
    by(Reason.BEYOND_NECK, "no nearer than 90° to the gaze", math.pi / 2, "rad"),
    by(Reason.NO_WALKING, "cannot move about"),
    by(Reason.NO_TORSO, "the torso does not move"),
]


@pytest.mark.parametrize("misses", [HAND, EYE], ids=["hand", "eye"])
def test_of_any_two_misses_the_nearer_one_is_told(misses: list[Miss]) -> None:
    """Nearest first: what nothing helps, what only a collision stops, then by how far the ability is."""
    for near, far in itertools.combinations(misses, 2):
        assert nearest_miss([near, far]) is near
        assert nearest_miss([far, near]) is near


def test_every_reason_has_one_rank_and_each_rank_one_unit() -> None:
    assert sorted(reason.name for reasons in TOLD_FIRST for reason in reasons) == sorted(each.name for each in Reason)
    for reasons in TOLD_FIRST:
        assert len({miss.quantity and miss.quantity.unit for miss in HAND + EYE if miss.reason in reasons}) <= 1


@pytest.mark.parametrize(
    ("evidence", "document"),
    [
        (None, {}),
        (Held("left"), {"arm": "left", "held": True}),
        (Reached("left", (1.0, 2.0, 3.0), 0.5), {"arm": "left", "point_m": [1.0, 2.0, 3.0], "distance_m": 0.5}),
        (
            Grasped("right", "pinch", (1.0, 2.0, 3.0), 0.5, 0.06, (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)),
            {
                "arm": "right",
                "hand": "pinch",
                "point_m": [1.0, 2.0, 3.0],
                "distance_m": 0.5,
                "width_m": 0.06,
                "closing": [0.0, 1.0, 0.0],
                "approach": [1.0, 0.0, 0.0],
            },
        ),
        (
            Grasped("left", "human", (1.0, 2.0, 3.0), 0.5, 0.06, (0.0, 1.0, 0.0), (1.0, 0.0, 0.0), "tilted"),
            {
                "arm": "left",
                "hand": "human",
                "point_m": [1.0, 2.0, 3.0],
                "distance_m": 0.5,
                "width_m": 0.06,
                "closing": [0.0, 1.0, 0.0],
                "approach": [1.0, 0.0, 0.0],
                "prepared": "tilted",
            },
        ),
        (
            GraspedByBoth(
                ("left", "right"),
                "human",
                ((1.0, 0.1, 1.0), (1.0, -0.1, 1.0)),
                (0.5, 0.6),
                0.2,
                (0.0, -1.0, 0.0),
                (1.0, 0.0, 0.0),
            ),
            {
                "arms": ["left", "right"],
                "hand": "human",
                "points_m": [[1.0, 0.1, 1.0], [1.0, -0.1, 1.0]],
                "distances_m": [0.5, 0.6],
                "width_m": 0.2,
                "closing": [0.0, -1.0, 0.0],
                "approach": [1.0, 0.0, 0.0],
            },
        ),
        (
            Visibility(3, 100, 4, 2, (("box", 1),), 0.7, 0.1),
            {
                "score": 0.03,
                "visible_px": 3,
                "image_px": 100,
                "unoccluded_px": 4,
                "gaze_px": 2,
                "occluders": [["box", 1]],
                "nearest_m": 0.7,
                "off_gaze_rad": 0.1,
            },
        ),
        (
            Occlusion((("box", 5),), 5, (0.0, 0.0, 1.5), (("box", (0.4, 0.0, 1.2)),)),
            {
                "occluders": [["box", 5]],
                "unoccluded_px": 5,
                "eye_m": [0.0, 0.0, 1.5],
                "hits_m": {"box": [0.4, 0.0, 1.2]},
            },
        ),
        (OutOfReach("left"), {"arm": "left"}),
        (OutOfReach("left", 0.2), {"arm": "left", "beyond_m": 0.2}),
        (TABLE, {"blocking": {"part": "torso", "other": "table", "depth_m": 0.02}}),
        (BlockedApproaches((("box", 3), ("cup", 1))), {"approaches": {"box": 3, "cup": 1}}),
    ],
)
def test_evidence_as_a_document(
    evidence: Held | Reached | Grasped | GraspedByBoth | Visibility | Hindrance | None, document: dict[str, object]
) -> None:
    assert evidence_document(evidence) == document
    assert list(evidence_document(evidence)) == list(document)
    assert json.loads(json.dumps(document)) == document


def told(level: int, misses: list[Miss], attained: Held | Reached | None, actions: tuple[str, ...]) -> Effort:
    miss = nearest_miss(misses)
    return Effort(
        ability="reach",
        agent="P1",
        target="cup",
        level=level,
        actions=actions,
        amount=Amount(torso_rad=0.5) if attained else None,
        joints_rad={"torso_lean": 0.5},
        posture="standing",
        turns_rad={"Lean_Torso": 0.5},
        find_evidence=lambda: Evidence(miss.text, tuple(misses), miss, attained),
    )


def test_an_effort_told_without_geometry() -> None:
    reached = Reached("left", (1.0, 0.0, 1.0), 0.6)
    effort = told(2, HAND[8:9] + HAND[13:14], reached, ("Lean_Torso", "Stretch_Out_Arm(left)"))
    assert why(effort) == (
        "P1 reaches the cup by leaning forward 29° and stretching out the left arm; "
        "with less: 1.70 m from the left shoulder, 1.00 m beyond the arm"
    )
    never = told(5, [HAND[13], HAND[7], HAND[14], HAND[12], HAND[9]], None, ("No_Possible_Known_Action",))
    assert why(never) == f"P1 cannot reach the cup: {HAND[7].text}; elsewhere: {HAND[9].text}"
    copied = pickle.loads(pickle.dumps(effort))
    assert (copied, copied.document) == (effort, effort.document)


BLOCKED = """
import sys
sys.modules |= dict.fromkeys(("numpy", "numba", "mujoco"))
from taskgist.language.efforts import why
from taskgist.perspective.effort import Amount, Effort, Evidence, Held, Miss, Reason
miss = Miss(Reason.NOT_HELD, "not held")
evidence = Evidence(miss.text, (miss,), miss, Held("left"))
effort = Effort("reach", "P1", "cup", 0, ("No_Action_Required",), Amount(), {}, "standing", {}, lambda: evidence)
print(why(effort), effort.document["effort"])
"""


def test_efforts_and_their_sentences_need_neither_numpy_nor_mujoco() -> None:
    done = subprocess.run([sys.executable, "-c", BLOCKED], capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.stdout == "P1 reaches the cup without effort: it is in P1's left hand No_Effort_Required\n"
