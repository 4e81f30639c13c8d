"""The page on ordinary rooms has a place for every table, and its figures are those of the default seed."""

from __future__ import annotations

import re

from benchmarks.ordinary_rooms import ROOMS, SEED
from tests.lab.ordinary import judged
from tests.lab.ordinary.judged import found
from tools.markdown import filled
from tools.ordinary_page import PAGE, parts

TEXT = PAGE.read_text(encoding="utf-8")


def test_the_page_has_a_place_for_every_table() -> None:
    page = filled(TEXT, parts(found()))
    for name in parts(found()):
        assert f"<!-- {name} -->\n" in TEXT
        (part,) = re.findall(rf"<!-- {name} -->\n(.*?)<!-- end -->", page, re.DOTALL)
        assert part.count("\n| ") >= 2
    assert f"Seed {judged.SEED}, " in page


def test_the_figures_are_those_of_the_default_seed() -> None:
    assert f"Seed {SEED}, " in TEXT
    assert f"{ROOMS} ordinary rooms" in TEXT
