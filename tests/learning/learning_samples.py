"""Samples for the tests of learning: the study of the paper as values, and random explanations.

The values are one set from which all six clauses of Eq. 36-42 follow; the paper does not print its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hypothesis import strategies as st

from taskgist.facts import NO_ACTION, REACH_EFFORTS, SEE_EFFORTS, STANDARD_TREE, Episode, Observation, Raw
from taskgist.learning import Experience, Explanation, explain

# "q" is a score in the field of view that is lower than "p".
SCORES = {"0": 0.0, "q": 0.0008, "p": 0.003, "l": 0.0125, "m": 0.05, "h": 0.2}
FREE: Mapping[str, str] = {"left": "Free_of_Object", "right": "Free_of_Object"}
LEFT_GETS: Mapping[str, str] = {**FREE, "left": "Holding_Object"}
RIGHT_RESTS: Mapping[str, str] = {**FREE, "right": "Resting_on_Support"}
RIGHT_GETS: Mapping[str, str] = {**FREE, "right": "Holding_Object"}


@dataclass(frozen=True)
class Told:
    """One demonstration: initial and final effort to reach and to see, visibility; the rest."""

    reach: str
    see: str
    score: str
    posture: str = "Sitting"
    ends: str = "On_Support"
    hands: tuple[Mapping[str, str], Mapping[str, str]] = (FREE, FREE)


STUDY: dict[str, list[Told]] = {
    "show": [
        Told("21", "10", "ph", ends="In_Hand"),
        Told("31", "30", "0h", ends="In_Hand"),
        Told("14", "10", "pm", ends="In_Hand"),
        Told("22", "10", "pm", "Standing"),
    ],
    "hide": [Told("21", "03", "l0"), Told("12", "14", "p0"), Told("11", "03", "m0")],
    "make accessible": [
        Told("43", "30", "0l"),
        Told("41", "30", "0h"),
        Told("42", "30", "0m"),
        Told("21", "00", "lm", "Standing"),
        Told("41", "00", "lh", "Standing"),
    ],
    "give": [
        Told("20", "10", "ph", ends="In_Hand", hands=(FREE, LEFT_GETS)),
        Told("40", "20", "0h", "Standing", ends="In_Hand", hands=(FREE, LEFT_GETS)),
        Told("20", "00", "lm", ends="In_Hand", hands=(RIGHT_RESTS, RIGHT_GETS)),
    ],
    "put away": [
        Told("12", "00", "hl"),
        Told("24", "11", "pq", "Standing"),
        Told("14", "00", "ml", "Standing"),
        Told("23", "11", "pq"),
    ],
    "hide away": [
        Told("14", "04", "m0"),
        Told("14", "04", "l0", "Standing"),
        Told("23", "13", "p0"),
        Told("12", "03", "h0"),
    ],
}


def study(task: str, count: int | None = None) -> Experience:
    """Experience of the first demonstrations of a task of the paper's study."""
    return Experience.of(task, [explained(task, i, told) for i, told in enumerate(STUDY[task][:count], start=1)])


def explained(task: str, index: int, told: Told) -> Explanation:
    start, end = _snapshot(told, 0, f"{task} {index} start"), _snapshot(told, 1, f"{task} {index} end")
    return explain(episode(task, f"{task} {index}", start, end))


def episode(task: str, name: str, start: Mapping[str, Raw], end: Mapping[str, Raw]) -> Episode:
    initial, final = ({key: Observation(raw) for key, raw in snapshot.items()} for snapshot in (start, end))
    return Episode(task, name, "P1", "P2", "cup", start=initial, end=final, source=f"test:{name}")


def _snapshot(told: Told, instant: int, state: str) -> dict[str, Raw]:
    """States differ in each demonstration; actions vary as efforts; grasping is as hard as reaching."""
    reach, see = int(told.reach[instant]), int(told.see[instant])
    values: dict[str, Raw] = {
        "visibility.score": SCORES[told.score[instant]],
        "posture": told.posture,
        "hands": told.hands[instant],
        "placement": told.ends if instant else "On_Support",
        "motion": "Static",
    }
    for ability, level, ladder in (
        ("reach", reach, REACH_EFFORTS),
        ("grasp", reach, REACH_EFFORTS),
        ("see", see, SEE_EFFORTS),
    ):
        values[f"{ability}.effort"] = ladder[level]
        values[f"{ability}.state"] = f"{state} {ability}"
        values[f"{ability}.action"] = NO_ACTION if level == 0 else f"Actions of {ladder[level]}"
    return values


def _raw(name: str) -> st.SearchStrategy[Raw]:
    attribute = STANDARD_TREE.attributes[name]
    if name == "visibility.score":
        return st.sampled_from(sorted(SCORES.values()))
    if name == "hands":
        status = st.sampled_from([*attribute.values, None])
        return st.fixed_dictionaries({"left": status, "right": status})
    return st.sampled_from(attribute.values or ("one", "other"))


SNAPSHOTS = st.fixed_dictionaries({}, optional={name: _raw(name) for name in STANDARD_TREE.attributes})


@st.composite
def explanations(draw: st.DrawFn, task: str = "show", most: int = 6) -> list[Explanation]:
    """Up to ``most`` explanations of different demonstrations, with holes in what was observed."""
    ends = draw(st.lists(st.tuples(SNAPSHOTS, SNAPSHOTS), max_size=most))
    return [explain(episode(task, f"demonstration {i}", start, end)) for i, (start, end) in enumerate(ends)]
