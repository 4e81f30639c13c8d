"""Laws of who carries a thing: what holds whatever trackers bring."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskgist.observe.holding import (
    Carrier,
    Evidence,
    Hand,
    NearHand,
    NoHand,
    Noise,
    Story,
    change_cost,
    likeliest,
    pressed,
    scores,
)
from taskgist.settings import Carrying
from tests.observe import holding_twin as twin

LIMITS = Carrying()
GIVER, GIVERS_LEFT, TAKER = ("P1", "right"), ("P1", "left"), ("P2", "right")
HANDS = (GIVER, GIVERS_LEFT, TAKER)
RATE_S = 1 / 30
SUPPORT = Evidence(RATE_S, touches=True, rests=True)


def frame(
    gaps_m: dict[Hand, float],
    *,
    slips_m_s: dict[Hand, float] | None = None,
    speed_m_s: float = 0.4,
    lost: frozenset[Hand] = frozenset(),
    falls: bool = False,
    dt_s: float = RATE_S,
) -> Evidence:
    """A frame in which the thing touches nothing but hands."""
    slips = slips_m_s or {}
    near = tuple(NearHand(hand, gap_m, slips.get(hand, 0.0)) for hand, gap_m in gaps_m.items())
    return Evidence(dt_s, speed_m_s=speed_m_s, falls=falls, near=near, lost=lost)


@st.composite
def frames(draw: st.DrawFn, most: int = 25, hands: tuple[Hand, ...] = HANDS) -> list[Evidence]:
    """Whatever may come: each stretch of equal tracking lasts a few frames, gaps and slips are anything."""
    found = list[Evidence]()
    while len(found) < most and (not found or draw(st.integers(0, 4))):
        lost = frozenset(draw(st.sets(st.sampled_from(hands), max_size=1)))
        near = [hand for hand in hands if hand not in lost and draw(st.booleans())]
        what = draw(st.sampled_from(["carried", "carried", "carried", "touches", "rests", "falls", "untracked"]))
        for _ in range(min(draw(st.integers(1, 6)), most - len(found))):
            found.append(
                Evidence(
                    draw(st.sampled_from([1 / 120, RATE_S, 0.2])),
                    tracked=what != "untracked",
                    touches=what in ("touches", "rests"),
                    rests=what == "rests",
                    speed_m_s=draw(st.none() | st.floats(0.0, 1.5)),
                    falls=what == "falls",
                    near=tuple(
                        NearHand(hand, draw(st.floats(-0.08, 0.3)), draw(st.none() | st.floats(0.0, 1.0)))
                        for hand in near
                    )
                    if what not in ("untracked", "rests")
                    else (),
                    lost=lost if what != "untracked" else frozenset(),
                )
            )
    return found


@settings(max_examples=150)
@given(frames())
def test_the_story_is_as_likely_as_that_of_the_twin(seen: list[Evidence]) -> None:
    found, expected = likeliest(seen, LIMITS), twin.likeliest(seen, LIMITS)
    assert twin.value(found, seen, LIMITS) == pytest.approx(twin.value(expected, seen, LIMITS), abs=1e-6)


@settings(max_examples=40)
@given(frames(most=4, hands=(GIVER, TAKER)))
def test_no_other_story_is_likelier(seen: list[Evidence]) -> None:
    assert twin.value(likeliest(seen, LIMITS), seen, LIMITS) == pytest.approx(twin.best_of_all(seen, LIMITS), abs=1e-6)


@given(frames())
def test_what_rests_is_carried_by_nothing_else(seen: list[Evidence]) -> None:
    for evidence, carrier in zip(seen, likeliest(seen, LIMITS), strict=True):
        assert not evidence.rests or carrier is NoHand.SUPPORT
        assert carrier is not NoHand.SUPPORT or evidence.touches or not evidence.tracked


@given(frames())
def test_frames_in_which_it_rests_part_the_story(seen: list[Evidence]) -> None:
    """What comes before one says nothing of what comes after it, but for how large errors are."""
    noise = Noise(LIMITS)
    for evidence in seen:
        noise.add(evidence)

    def told(some: list[Evidence]) -> float:
        story = Story(LIMITS)
        for evidence in some:
            story.add(evidence, noise)
        return _value(story.latest(len(some)), some, noise)

    for at, evidence in enumerate(seen):
        if evidence.rests:
            assert told(seen) == pytest.approx(told(seen[: at + 1]) + told(seen[at:]), abs=1e-6)


def _value(story: list[Carrier], some: list[Evidence], noise: Noise) -> float:
    said = 0.0
    hands: frozenset[Hand] = frozenset()
    for evidence, carrier in zip(some, story, strict=True):
        near = frozenset(each.hand for each in evidence.near)
        hands = near | (hands & evidence.lost) if evidence.tracked else hands
        said += scores(evidence, hands, noise)[carrier]
    return said - sum(change_cost(one, other, LIMITS) for one, other in itertools.pairwise(story))


@given(frames(), st.permutations(HANDS))
def test_names_do_not_matter(seen: list[Evidence], renamed: list[Hand]) -> None:
    """Hands that change their names change them in the story; persons stay together."""
    new = dict(zip(("P1", "P2"), ("P2", "P1"), strict=True)) if renamed[0] == TAKER else {"P1": "P3", "P2": "P0"}

    def other(hand: Hand) -> Hand:
        return new[hand[0]], hand[1]

    mirrored = [
        replace(
            evidence,
            near=tuple(replace(each, hand=other(each.hand)) for each in evidence.near),
            lost=frozenset(map(other, evidence.lost)),
        )
        for evidence in seen
    ]
    back = [
        frozenset((next(a for a in new if new[a] == agent), side) for agent, side in carrier)
        if isinstance(carrier, frozenset)
        else carrier
        for carrier in likeliest(mirrored, LIMITS)
    ]
    assert twin.value(back, seen, LIMITS) == pytest.approx(twin.value(likeliest(seen, LIMITS), seen, LIMITS), abs=1e-6)


def handover(noise_m: float, correlated_s: float, seed: int) -> list[Evidence]:
    """P1 lifts a thing, P2's hand comes, both are at it from 2.3 to 2.7 s, P1's hand goes; gaps with errors."""
    rng, kept = np.random.default_rng(seed), np.exp(-RATE_S / correlated_s) if correlated_s else 0.0
    error, seen = rng.normal(0.0, noise_m, 2), [SUPPORT] * 10
    for time_s in np.arange(0.4, 4.0, RATE_S):
        error = kept * error + np.sqrt(1 - kept**2) * rng.normal(0.0, noise_m, 2)
        away_m = np.array([max(time_s - 2.7, 0.0), max(2.3 - time_s, 0.0)])
        gaps_m = np.hypot(away_m, error)
        slips = np.where(away_m > 0.0, 1.0, 0.0) + np.abs(rng.normal(0.0, 2 * noise_m, 2))
        near = {hand: k for k, hand in enumerate((GIVER, TAKER)) if gaps_m[k] < LIMITS.near_m}
        seen.append(
            frame(
                {hand: float(gaps_m[k]) for hand, k in near.items()},
                slips_m_s={hand: float(slips[k]) for hand, k in near.items()},
            )
        )
    return seen


@pytest.mark.parametrize("correlated_s", [0.0, 0.15])
@pytest.mark.parametrize("noise_m", [0.0, 0.02, 0.05])
def test_a_thing_changes_hands_once(noise_m: float, correlated_s: float) -> None:
    for seed in range(10):
        seen = handover(noise_m, correlated_s, seed)
        times_s = [0.4 + RATE_S * (index - 10) for index in range(len(seen))]
        story = pressed(likeliest(seen, LIMITS), times_s, LIMITS.closing_s)
        changes = [carrier for before, carrier in zip([None, *story], story, strict=False) if carrier != before]
        assert changes == [NoHand.SUPPORT, frozenset({GIVER}), frozenset({TAKER})]
        assert times_s[story.index(frozenset({TAKER}))] == pytest.approx(2.5, abs=0.3)


def test_a_thing_that_travels_is_held_by_the_hand_that_goes_with_it_however_far_beside_it_is_tracked() -> None:
    """The tracker has the hand 15 cm beside the thing; another hand, that stands still, is passed by at 5 cm."""
    seen = [frame({GIVER: 0.15}, speed_m_s=0.5)] * 60
    seen[28:32] = [frame({GIVER: 0.15, TAKER: 0.05}, slips_m_s={GIVER: 0.0, TAKER: 0.5}, speed_m_s=0.5)] * 4
    assert set(likeliest(seen, LIMITS)) == {frozenset({GIVER})}


def test_what_falls_is_held_by_nobody() -> None:
    seen = [frame({GIVER: 0.0})] * 20 + [frame({GIVER: 0.1}, speed_m_s=1.5, falls=True)] * 8 + [SUPPORT] * 5
    assert likeliest(seen, LIMITS) == [frozenset({GIVER})] * 20 + [NoHand.NOBODY] * 8 + [NoHand.SUPPORT] * 5


def test_a_hand_that_is_lost_for_a_while_goes_on_holding() -> None:
    seen = [frame({GIVER: 0.0})] * 20 + [frame({}, lost=frozenset({GIVER}))] * 10 + [frame({GIVER: 0.0})] * 20
    assert set(likeliest(seen, LIMITS)) == {frozenset({GIVER})}


def test_what_moves_with_no_hand_near_is_held_by_one_that_was_not_seen_if_there_is_any() -> None:
    assert set(likeliest([frame({}, lost=frozenset({TAKER}))] * 20, LIMITS)) == {NoHand.UNSEEN}
    assert set(likeliest([frame({})] * 20, LIMITS)) == {NoHand.NOBODY}


@given(frames(most=60), st.integers(0, 15))
def test_asked_late_enough_what_is_said_live_is_the_beginning_of_the_story(seen: list[Evidence], later: int) -> None:
    """The end of the story that is told after all frames is the story of all."""
    noise, story = Noise(LIMITS), Story(LIMITS)
    for evidence in seen:
        noise.add(evidence)
    for evidence in seen:
        story.add(evidence, noise)
    whole = story.latest(len(seen))
    assert whole == likeliest(seen, LIMITS)
    assert story.latest(min(later, len(seen))) == whole[len(seen) - min(later, len(seen)) :]


# --- Hands that are around a thing and do not press.

CARRIERS = st.sampled_from([NoHand.SUPPORT, *map(frozenset, ([GIVER], [TAKER], [GIVER, TAKER], [GIVER, GIVERS_LEFT]))])


@given(st.lists(st.tuples(CARRIERS, st.integers(1, 30)), min_size=1, max_size=8), st.floats(0.0, 0.5))
def test_pressing_takes_hands_away_from_where_others_hold(runs: list[tuple[Carrier, int]], closing_s: float) -> None:
    story = [carrier for carrier, count in runs for _ in range(count)]
    times_s = [RATE_S * index for index in range(len(story))]
    for before, after in zip(story, pressed(story, times_s, closing_s), strict=True):
        if isinstance(before, frozenset):
            assert isinstance(after, frozenset)
            assert after <= before
            assert after
        else:
            assert after is before
    assert pressed(story, times_s, 0.0) == story
    back = pressed(story[::-1], times_s, closing_s)[::-1]
    differ = sum(one != other for one, other in zip(back, pressed(story, times_s, closing_s), strict=True))
    assert differ <= 2 * len(runs), "backwards it is the same, but for the frame at each end of a run"


def test_a_thing_changes_hands_in_the_middle_of_the_time_that_both_are_at_it() -> None:
    one, both, other = frozenset({GIVER}), frozenset({GIVER, TAKER}), frozenset({TAKER})
    times_s = [0.1 * index for index in range(20)]
    assert pressed([one] * 8 + [both] * 4 + [other] * 8, times_s, 0.3) == [one] * 10 + [other] * 10
    assert pressed([one] * 5 + [both] * 10 + [other] * 5, times_s, 0.3) == [one] * 8 + [both] * 4 + [other] * 8
    assert pressed([one] * 8 + [both] * 4 + [one] * 8, times_s, 0.3) == [one] * 20


def test_two_hands_lift_and_put_down_at_once() -> None:
    story = [NoHand.SUPPORT] * 5 + [frozenset({GIVER, GIVERS_LEFT})] * 10 + [NoHand.SUPPORT] * 5
    assert pressed(story, [0.1 * index for index in range(20)], 0.3) == story
