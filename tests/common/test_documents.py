"""Strict JSON: what the standard library lets pass and nobody means is refused with a clause."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskgist.common.documents import DEEPEST, DocumentError, parse_json

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


@given(VALUES)
def test_what_is_sound_is_read_as_the_standard_library_does(value: object) -> None:
    text = json.dumps(value)
    assert parse_json(text) == json.loads(text) == value
    assert parse_json(text.encode()) == value


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("[NaN]", "NaN is no number"),
        ("[-Infinity]", "-Infinity is no number"),
        ("1e999", "1e999 is no finite number"),
        ('{"a": 1, "b": 2, "a": 3}', "'a' is given twice"),
        ('["\\ud800"]', "no Unicode"),
        ("{", "not JSON"),
        (b"\xff\xfe\xff", "not JSON"),
        ("[" * (DEEPEST + 2) + "]" * (DEEPEST + 2), "nested deeper than"),
        ("[" * 200_000, "nested deeper than"),
        ('{"a":' * 100_000, "nested deeper than"),
        ("9" * 10_000, "not JSON"),
    ],
)
def test_what_nobody_means_is_refused(text: str | bytes, problem: str) -> None:
    with pytest.raises(DocumentError, match=problem):
        parse_json(text)


def test_the_deepest_that_is_read() -> None:
    assert parse_json("[" * DEEPEST + "]" * DEEPEST)


def test_numbers_that_the_caller_checks() -> None:
    assert parse_json("[1e999, Infinity]", any_number=True) == [float("inf")] * 2
