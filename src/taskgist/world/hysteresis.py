"""Hysteresis: what is true of a frame may depend on what was true of the frame before it.

A hand begins to hold at a low slip and lets go at a high one; in between, all stays as it was. Who watches frames as
they come keeps the last answer. Who asks for one frame out of a whole sequence goes back to the nearest frame whose
answer is the same whatever came before it, and follows the frames from there.
"""

from __future__ import annotations

from collections.abc import Callable


def followed(answer: Callable[[int, bool], bool], index: int) -> bool:
    """What is true of a frame after all the frames before it, as if the answer before the first one were False.

    Args:
        answer: Gives what is true of a frame, by its index and what was true of the frame before it.
        index: Which frame.
    """
    start = index
    while start > 0 and answer(start, True) != answer(start, False):
        start -= 1
    state = answer(start, False)
    for each in range(start + 1, index + 1):
        state = answer(each, state)
    return state
