"""Tables that come row by row give what an array of all rows gives."""

from __future__ import annotations

import pickle
import tracemalloc

import numpy as np
import pytest

from taskgist.common.arrays import Array
from taskgist.recording.columns import ROWS, Columns, PackedRows

WIDTH = 5
SCALE = np.array([1e4, 1e4, 1e5, 1e5, 1.0])


def decimals(count: int, seed: int = 0) -> Array:
    return np.asarray(np.rint(np.random.default_rng(seed).normal(size=(count, WIDTH)) * SCALE) / SCALE + 0.0)


def packed(rows: Array) -> PackedRows:
    table = PackedRows(SCALE)
    for row in rows:
        table.append(row)
    return table


@pytest.mark.parametrize("count", [0, 1, 7, ROWS, ROWS + 1, 2 * ROWS + 9])
def test_packed_rows_are_read_as_the_array_is(count: int) -> None:
    rows = decimals(count)
    table = packed(rows)
    assert table.shape == rows.shape
    assert len(table) == count
    np.testing.assert_array_equal(np.asarray(table), rows)
    keys = [
        slice(None),
        slice(3, 5),
        slice(-5, None),
        slice(ROWS - 2, ROWS + 2),
        slice(None, None, 2),
        (slice(None), 2),
    ]
    keys += [(slice(None), slice(1, 3)), (slice(None), [0, 4]), np.arange(count) % 2 == 0, [0, -1][:count]]
    for key in keys:
        np.testing.assert_array_equal(table[key], rows[key], err_msg=str(key))  # type: ignore[call-overload]
    for index in {0, 1, count // 2, count - 1, -1, -count}:
        if -count <= index < count:
            np.testing.assert_array_equal(table[index], rows[index])
    with pytest.raises(IndexError):
        table[count]


def test_other_numbers_are_kept_as_they_are() -> None:
    """What is finer than its decimals, or larger than whole numbers hold, comes back unharmed, too."""
    rows = np.concatenate([decimals(ROWS), np.random.default_rng(1).normal(size=(ROWS, WIDTH)) * 1e8, decimals(9)])
    np.testing.assert_array_equal(np.asarray(packed(rows)), rows)


def test_packed_rows_calculate_and_travel_as_arrays_do() -> None:
    rows = decimals(ROWS + 3)
    table = packed(rows)
    np.testing.assert_array_equal(table + 1.0, rows + 1.0)
    np.testing.assert_array_equal(np.ptp(table[:, 1:3], axis=0), np.ptp(rows[:, 1:3], axis=0))
    np.testing.assert_array_equal(table.mean(axis=0), rows.mean(axis=0))
    np.testing.assert_array_equal(np.asarray(pickle.loads(pickle.dumps(table))), rows)
    with pytest.raises(TypeError):
        table[0] = 0.0


def test_columns_grow_in_place() -> None:
    flags, pairs = Columns(None, np.bool_), Columns(2, np.float64)
    for number in range(ROWS + 5):
        flags.append(number % 3 == 0)
        pairs.append((number, -number))
    numbers = np.arange(ROWS + 5)
    np.testing.assert_array_equal(flags.finished(), numbers % 3 == 0)
    np.testing.assert_array_equal(pairs.finished(), np.column_stack((numbers, -numbers)))
    assert not pairs.finished().flags.writeable


def test_packed_rows_take_half_the_memory() -> None:
    rows = decimals(8 * ROWS)
    tracemalloc.start()
    table = packed(rows)
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(table) == len(rows)
    assert held < 0.7 * rows.nbytes
