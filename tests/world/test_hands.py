"""Hands: kinds, boxes, and what a profile may say of them."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskgist.common.toml import TomlTable
from taskgist.errors import SceneError, UnknownNameError
from taskgist.world import HAND_KINDS, Hand, HandBox, HandKind, distances_outside_m, hand_boxes, spans_m
from taskgist.world.bodies.hands import FINGER_WIDTH_M, SPREAD_M, read_hand
from taskgist.world.bodies.profile import builtin_profile_text
from tests.meshes import mesh_scene

TABLE = "opening_m = 0.1\nfinger_length_m = 0.09\nfinger_thickness_m = 0.018\npalm_m = [0.085, 0.028]\n"


def parsed(text: str) -> Hand:
    kind = "" if "kind" in text else 'kind = "human"\n'
    hand = read_hand(TomlTable.parse(f"[hand]\n{kind}{text}", "arm.toml", most_bytes=1000).table("hand"))
    assert isinstance(hand, Hand)
    return hand


def corners(box: HandBox, side_m: float) -> np.ndarray:
    """Corners of a box in the hand's frame, its fingers that far from the middle."""
    middle = np.array([-box.behind_m, box.side * side_m, box.across_m])
    return middle + np.array(list(itertools.product((-1, 1), repeat=3))) * box.half_m


def test_the_kinds_have_their_fingers() -> None:
    names = {kind: [box.name for box in hand_boxes(parsed(f'{TABLE}kind = "{kind}"'))] for kind in HAND_KINDS}
    assert names == {
        "human": ["palm", "fingers", "thumb"],
        "parallel": ["palm", "fingers", "thumb"],
        "three_finger": ["palm", "first_finger", "second_finger", "thumb"],
    }


@pytest.mark.parametrize("kind", HAND_KINDS)
def test_widths_are_the_kinds_own_where_the_profile_is_silent(kind: HandKind) -> None:
    hand = parsed(f'{TABLE}kind = "{kind}"')
    assert hand.width_m == FINGER_WIDTH_M.get(kind, 0.085)
    assert hand.spread_m == SPREAD_M
    assert parsed(f'{TABLE}kind = "{kind}"\nfinger_width_m = 0.03').width_m == 0.03


def test_two_fingers_lie_side_by_side_opposite_the_thumb() -> None:
    _, first, second, thumb = hand_boxes(parsed(f'{TABLE}kind = "three_finger"\nspread_m = 0.08'))
    assert (first.across_m, second.across_m, thumb.across_m) == (-0.04, 0.04, 0.0)
    assert (first.side, second.side, thumb.side) == (1, 1, -1)


@given(
    st.sampled_from(HAND_KINDS),
    st.floats(0.02, 0.3),
    st.floats(0.03, 0.2),
    st.floats(0.005, 0.029),
    st.floats(0.01, 0.1),
)
def test_the_palm_and_its_way_stay_behind_the_tips(
    kind: HandKind, opening: float, length: float, thick: float, palm: float
) -> None:
    hand = Hand(opening, length, thick, (0.08, palm), kind)
    tip, way = hand.tips_m, length - thick + hand.tips_m
    palm_box, *fingers = hand_boxes(hand)
    palm_x = corners(palm_box, 0.0)[:, 0]
    assert palm_x.max() == pytest.approx(tip - length)  # between palm and tips a finger fits
    assert np.ptp(palm_x) == pytest.approx(palm + way)  # and it sweeps most of a finger's length
    for finger in fingers:
        x = corners(finger, 0.1)[:, 0]
        assert x.max() == pytest.approx(tip)
        assert x.min() >= palm_x.min() - 1e-12


@pytest.mark.parametrize(
    ("change", "field"),
    [
        (("opening_m = 0.1", "opening_m = 0"), "hand.opening_m"),
        (("0.018", "-0.018"), "hand.finger_thickness_m"),
        (("0.018", "0.09"), "hand.finger_thickness_m"),
        (("[0.085, 0.028]", "[0.085, 0]"), "hand.palm_m"),
        (("opening_m", "finger_width_m = 0\nopening_m"), "hand.finger_width_m"),
        (("opening_m", "spread_m = -1\nopening_m"), "hand.spread_m"),
        (("opening_m", "tip_m = 0\nopening_m"), "hand.tip_m"),
        (("opening_m", "tip_m = 0.02\nopening_m"), "hand.tip_m"),
        (("opening_m", "thumb_width_m = -1\nopening_m"), "hand.thumb_width_m"),
        (("opening_m", "between_m = 0.1\nopening_m"), "hand.between_m"),
    ],
)
def test_sizes_that_cannot_be_are_refused_by_name(change: tuple[str, str], field: str) -> None:
    with pytest.raises(SceneError, match=f"arm.toml: {field}"):
        parsed(TABLE.replace(*change))


def test_an_unknown_kind_is_refused_with_the_known_ones() -> None:
    with pytest.raises(UnknownNameError, match="no kind of hand 'paralel'; did you mean 'parallel'"):
        parsed(f'{TABLE}kind = "paralel"')


def test_the_human_profile_has_a_human_hand() -> None:
    hand = read_hand(TomlTable.parse(builtin_profile_text("human"), "human.toml", most_bytes=100_000).table("hand"))
    assert isinstance(hand, Hand)
    assert (hand.kind, hand.one_sided, hand.opening_m) == ("human", True, 0.10)
    assert (hand.tips_m, hand.thumb_m, hand.width_m) == (0.001, 0.022, 0.085)
    assert hand.palms is not None
    assert (hand.palms.least_m, hand.palms.opening_m) == (0.10, 0.60)


@pytest.mark.parametrize("kind", HAND_KINDS)
def test_two_hands_lie_flat_on_both_sides_with_the_tips_at_the_points(kind: HandKind) -> None:
    hand = parsed(f'{TABLE}kind = "{kind}"\nbetween_m = 0.5\ntip_m = 0.003')
    assert hand.palms is not None
    left, right = hand_boxes(hand.palms)
    assert (left.name, left.side, right.name, right.side) == ("left", -1, "right", 1)
    assert left.half_m == right.half_m
    assert corners(right, 0.2)[:, 0].max() == pytest.approx(0.003)
    assert parsed(f'{TABLE}kind = "{kind}"\nbetween_m = 0').palms is None


SHAPES = (
    'type="box" size="0.1 0.05 0.2"',
    'type="sphere" size="0.1"',
    'type="ellipsoid" size="0.1 0.05 0.2"',
    'type="cylinder" size="0.1 0.2"',
    'type="capsule" size="0.1 0.2"',
)


@pytest.mark.parametrize("shape", SHAPES)
def test_points_inside_and_outside_of_solids_and_how_far_these_extend(shape: str) -> None:
    scene = mesh_scene(f'<body name="thing" pos="0 0 1"><freejoint/><geom {shape}/></body>')
    geom = int(scene.object_geoms("thing")[0])
    points, normals = scene.surface_points(geom, 0.03)
    for away_m, least, most in ((0.0, -1e-9, 1e-9), (0.01, 1e-4, 0.01 + 1e-9), (-0.01, -0.01 - 1e-9, 1e-9)):
        outside_m = distances_outside_m(scene.model, geom, points + away_m * normals)
        assert (outside_m >= least).all()
        assert (outside_m <= most).all()
        assert np.abs(outside_m - away_m).min() < 2e-3
    directions = np.random.default_rng(3).normal(size=(50, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    low, high = spans_m(scene.model, geom, directions)
    along = points @ directions.T
    assert (along.max(axis=0) <= high + 1e-9).all()
    assert (along.max(axis=0) >= high - 0.02).all()
    np.testing.assert_allclose(low, -high)
    assert math.isfinite(float(high.max()))
