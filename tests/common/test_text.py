"""One name has one spelling, whoever wrote it."""

from __future__ import annotations

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskgist.common.text import LONGEST_NAME, clean_name, fault_of_name


@pytest.mark.parametrize(
    ("given_text", "cleaned"),
    [
        ("  show  ", "show"),
        ("show\n", "show"),
        ("caf\u0065\u0301", "caf\u00e9"),
        ("\x1b[31mred", "[31mred"),
        ("put away", "put away"),
        ("\u202eevig", "evig"),
        ("\u2003show\u00a0", "show"),
        ("\t\n", ""),
    ],
)
def test_what_people_see_as_one_name_is_one(given_text: str, cleaned: str) -> None:
    assert clean_name(given_text) == cleaned


@given(st.text())
def test_a_clean_name_is_seen_composed_and_stays(text: str) -> None:
    name = clean_name(text)
    assert (fault_of_name(name) is None) == (0 < len(name) <= LONGEST_NAME)
    assert unicodedata.is_normalized("NFC", name)
    assert name == name.strip() == clean_name(name)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("put away", None),
        ("a\x00b", "holds a character that is not seen"),
        (" \u00a0", "is empty"),
        ("s" * LONGEST_NAME, None),
        ("s" * (LONGEST_NAME + 1), "is longer than 200 characters"),
    ],
)
def test_what_is_no_name_says_why(text: str, fault: str | None) -> None:
    assert fault_of_name(text) == fault
