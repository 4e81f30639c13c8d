"""Boxes in a tree: what is in vain for a box around many trials is in vain for each of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
INNER = -1
LEAF, PAST = 0, 1


class Tree(NamedTuple):
    """A binary tree in the order in which it is walked: each node before its parts.

    Attributes:
        nodes: The box that a leaf stands for, or −1, and the node to go on with if this one is in vain, (n, 2).
        boxes: The box around all boxes under each node: least and greatest coordinates, (n, 6).
    """

    nodes: Indices
    boxes: Array


def tree_of(low: Array, high: Array) -> Tree:
    """The tree of one or more boxes, of their least and greatest coordinates, (n, 3) each."""
    return Tree(*_halved(np.hstack((low, high))))


@compiled
def _halved(boxes: Array) -> tuple[Indices, Array]:
    """Halves boxes again and again by the middle of their longest side."""
    count = len(boxes)
    order, parts = np.arange(count), np.empty((count, 2), dtype=np.intp)
    nodes, around = np.empty((2 * count - 1, 2), dtype=np.intp), np.empty((2 * count - 1, 6))
    parts[0, 0], parts[0, 1] = 0, count
    waiting = 1
    for node in range(len(nodes)):
        waiting -= 1
        start, end = parts[waiting, 0], parts[waiting, 1]
        axis = _enclose(boxes, order, start, end, around, node)
        nodes[node, LEAF] = order[start] if end - start == 1 else INNER
        nodes[node, PAST] = node + 2 * (end - start) - 1
        if end - start > 1:
            split = _parted(boxes, order, start, end, axis, around[node, axis] + around[node, 3 + axis])
            parts[waiting, 0], parts[waiting, 1] = split, end
            parts[waiting + 1, 0], parts[waiting + 1, 1] = start, split
            waiting += 2
    return nodes, around


@compiled
def _enclose(boxes: Array, order: Indices, start: int, end: int, around: Array, node: int) -> int:
    """Writes the box around some boxes; gives its longest axis."""
    longest = 0
    for axis in range(3):
        low, high = np.inf, -np.inf
        for place in range(start, end):
            low, high = min(low, boxes[order[place], axis]), max(high, boxes[order[place], 3 + axis])
        around[node, axis], around[node, 3 + axis] = low, high
        if high - low > around[node, 3 + longest] - around[node, longest]:
            longest = axis
    return longest


@compiled
def _parted(boxes: Array, order: Indices, start: int, end: int, axis: int, twice_middle: float) -> int:
    """Brings the boxes below the middle of an axis to the front; gives where the others begin, half-way if none do."""
    split = start
    for place in range(start, end):
        box = order[place]
        if boxes[box, axis] + boxes[box, 3 + axis] < twice_middle:
            order[place], order[split] = order[split], box
            split += 1
    return split if start < split < end else (start + end) // 2


@compiled
def squared_gap(boxes: Array, box: int, x: float, y: float, z: float) -> float:
    """Squared distance between a point and a box, a row of a table, m²."""
    dx = max(boxes[box, 0] - x, x - boxes[box, 3], 0.0)
    dy = max(boxes[box, 1] - y, y - boxes[box, 4], 0.0)
    dz = max(boxes[box, 2] - z, z - boxes[box, 5], 0.0)
    return float(dx * dx + dy * dy + dz * dz)
