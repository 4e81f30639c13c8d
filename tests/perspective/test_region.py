"""What was consulted for an answer: nothing that moves in it is overlooked."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from taskgist.perspective.target import BODIES, Recorder, Region, crossed

numbers = st.floats(-3.0, 3.0, allow_nan=False)
points = st.tuples(numbers, numbers, numbers).map(np.array)
shares = st.tuples(*[st.floats(0.0, 1.0)] * 3).map(np.array)
sizes = st.tuples(*[st.floats(0.0, 1.0)] * 3).map(np.array)


def box(middle: np.ndarray, half: np.ndarray) -> np.ndarray:
    return np.array((middle - half, middle + half))


def recorded(target: np.ndarray, eyes: np.ndarray | None, bodies: int = 1) -> Recorder:
    """Bodies stand far away, two metres apart."""
    regions = []
    for number in range(bodies):
        region = Region()
        region.add_points(np.array([(50.0 + 2.0 * number, 50.0, 50.0)]), 0.5)
        regions.append(region)
    found = Recorder()
    for region in regions:
        found.add_body(region)
    found.target.add_points(target)
    if eyes is not None:
        found.eyes.add_points(eyes)
    return found


def touches(asked: Recorder, moved: np.ndarray) -> bool:
    return bool(crossed(asked.bounds[None], moved[None])[0])


@given(
    eye=points, eye_half=sizes, target=points, half=sizes, at=shares, to=shares, share=st.floats(0.0, 1.0), wide=sizes
)
def test_whatever_lies_on_a_line_of_sight_is_noticed(
    eye: np.ndarray,
    eye_half: np.ndarray,
    target: np.ndarray,
    half: np.ndarray,
    at: np.ndarray,
    to: np.ndarray,
    share: float,
    wide: np.ndarray,
) -> None:
    eyes, targets = box(eye, eye_half), box(target, half)
    start, end = eyes[0] + at * (eyes[1] - eyes[0]), targets[0] + to * (targets[1] - targets[0])
    assert touches(recorded(targets, eyes), box(start + share * (end - start), wide))


@given(eye=points, target=points, away=st.floats(0.01, 5.0), axis=st.integers(0, 2), half=sizes)
def test_what_lies_beyond_both_ends_is_not(
    eye: np.ndarray, target: np.ndarray, away: float, axis: int, half: np.ndarray
) -> None:
    beyond = np.maximum(eye, target)
    beyond[axis] += away + half[axis]
    assert not touches(recorded(target[None], eye[None]), box(beyond, half))


def test_what_lies_in_the_box_of_a_slanting_line_but_beside_it_is_not() -> None:
    asked = recorded(np.array([(2.0, 2.0, 0.0)]), np.array([(0.0, 0.0, 0.0)]))
    assert touches(asked, box(np.array((1.0, 1.0, 0.0)), np.full(3, 0.1)))
    assert not touches(asked, box(np.array((0.3, 1.7, 0.0)), np.full(3, 0.1)))


def test_without_eyes_only_the_object_counts() -> None:
    asked = recorded(np.array([(2.0, 2.0, 0.0)]), None)
    assert touches(asked, box(np.array((2.0, 2.0, 0.0)), np.full(3, 0.1)))
    assert not touches(asked, box(np.array((1.0, 1.0, 0.0)), np.full(3, 0.1)))


def test_every_place_of_the_agent_counts_also_when_there_are_many() -> None:
    count = 2 * BODIES
    asked = recorded(np.zeros((1, 3)), None, count)
    for number in range(count):
        assert touches(asked, box(np.array((50.0 + 2.0 * number, 50.0, 50.0)), np.full(3, 0.1)))
    assert not touches(asked, box(np.array((51.0, 50.0, 50.0)), np.full(3, 0.1)))
