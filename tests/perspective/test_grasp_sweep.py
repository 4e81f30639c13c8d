"""The tables of who can grasp what hold, in part, and have no hole that a person would laugh at."""

import itertools
import re
from pathlib import Path

import pytest

from tests.bodies import needs
from tools.grasp_page import BODIES, NONE, PAGE, PLACES, SIZES_MM, SLID, TILTED, Box, Sweep, symbol

SHORT_MM = (1, 30, 300)


def cells(body: str, place: str) -> dict[Box, str]:
    """What the page says."""
    text = (Path(__file__).parents[2] / PAGE).read_text(encoding="utf-8")
    (part,) = re.findall(rf"<!-- {body} {place} -->\n(.*?)<!-- end -->", text, re.DOTALL)
    found: dict[Box, str] = {}
    for line in part.splitlines()[2:]:
        base, *row = (cell.strip() for cell in line.strip("|").split("|"))
        across, away = map(int, base.split("×"))
        found |= {Box(high, across, away): cell for high, cell in zip(SIZES_MM, row, strict=True)}
    return found


@pytest.mark.parametrize("body", ["human", "jido", pytest.param("pr2", marks=needs("pr2"))])
@pytest.mark.parametrize("place", PLACES)
def test_the_page_says_what_is_so(body: str, place: str) -> None:
    sweep, told = Sweep(body, place, SHORT_MM), cells(body, place)
    assert {box: symbol(sweep.effort(box)) for box in sweep.boxes} == {box: told[box] for box in sweep.boxes}


@pytest.mark.parametrize("place", PLACES)
def test_people_pick_up_every_box_and_small_ones_without_ado(place: str) -> None:
    told = cells("human", place)
    assert len(told) == len(SIZES_MM) ** 3
    assert NONE not in told.values()
    assert SLID not in told.values()
    # What fits a hand from above, and is thick enough for a nail, needs no tilting.
    small = {box: cell for box, cell in told.items() if min(box.across_mm, box.away_mm) <= 10 and box.height_mm >= 3}
    assert set(small.values()) == {"1"}


@pytest.mark.parametrize(("body", "place"), list(itertools.product(BODIES[1:], ("table", "edge"))))
def test_grippers_take_what_is_as_thick_as_a_finger_and_as_narrow_as_they_open(body: str, place: str) -> None:
    for box, cell in cells(body, place).items():
        assert cell != TILTED
        long = max(box.across_mm, box.away_mm, box.height_mm) >= 100  # TALOS needs something for both of its fingers
        if box.height_mm >= 10 and min(box.across_mm, box.away_mm) <= 30 and (long or body != "talos"):
            assert cell == "1", box
