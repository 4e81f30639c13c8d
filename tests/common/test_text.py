"""One name has one spelling, whoever wrote it."""

from __future__ import annotations

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskgist.common.text import clean_name, unseen_in


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
    assert unseen_in(name) is None
    assert unicodedata.is_normalized("NFC", name)
    assert name == name.strip() == clean_name(name)


def test_what_is_not_seen_is_found() -> None:
    assert unseen_in("a\x00b") == "\x00"
    assert unseen_in("put away") is None
