"""Timelines: intervals that follow each other without gaps and say what the observer and the snapshots say."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from taskgist.errors import UnknownNameError
from taskgist.facts import STANDARD_TREE, Predicate, predicate_subtree
from taskgist.observe import Observer, snapshot
from taskgist.pipeline import Timeline, attribute_nodes, timeline, timelines
from taskgist.settings import DEFAULT
from taskgist.world import Stage
from tests.pipeline.small import FRAMES, small
from tests.shipped import excerpt, label

NAME = "handover_1"


@pytest.fixture(scope="module")
def line() -> Timeline:
    short = excerpt(NAME, 1.2, 4.2)
    return timeline(short, Observer(short.scene, short), agent="P2", name="baton", every_s=0.6)


def test_every_attribute_has_a_row(line: Timeline) -> None:
    assert set(line.rows) == set(STANDARD_TREE.attributes) == set(attribute_nodes(STANDARD_TREE))
    assert (line.agent, line.name, line.every_s) == ("P2", "baton", 0.6)


def test_rows_cover_the_recording_without_gaps(line: Timeline) -> None:
    times = excerpt(NAME, 1.2, 4.2).times_s
    for attribute, intervals in line.rows.items():
        assert intervals[0].start_s == times[0], attribute
        assert intervals[-1].end_s == times[-1], attribute
        for before, after in pairwise(intervals):
            assert before.end_s == after.start_s
            assert before.value != after.value, f"{attribute}: equal neighbours are one interval"


def test_rows_say_what_snapshots_say(line: Timeline) -> None:
    short = excerpt(NAME, 1.2, 4.2)
    watching = Observer(short.scene, short)
    for time_s in (float(short.times_s[0]), float(short.times_s[0]) + 1.2, float(short.times_s[-1])):
        observed = snapshot(Stage(short.scene, short.at(time_s)), watching, agent="P2", name="baton")
        for attribute in ("reach.effort", "see.action", "placement", "posture", "motion"):
            (symbol,) = [i.value for i in line.rows[attribute] if i.start_s <= time_s < i.end_s] or [
                line.rows[attribute][-1].value
            ]
            assert symbol == observed[attribute].value, (attribute, time_s)


def test_a_handover_is_seen_in_it(line: Timeline) -> None:
    assert [i.value for i in line.rows["placement"]] == ["On_Support", "In_Hand"]
    assert line.rows["hands"][-1].value == "left: Free_of_Object, right: Holding_Object"
    assert line.rows["hands"][0].value == "Free_of_Object"
    taken_s = line.rows["hands"][-1].start_s
    assert label(NAME).start_s < taken_s < label(NAME).end_s


def test_unknown_is_a_value() -> None:
    lost = small(tracked={"cup": np.arange(FRAMES) > 15})
    rows = timeline(lost, Observer(lost.scene, lost), agent="P2", name="cup", every_s=0.25).rows
    assert [i.value for i in rows["placement"]] == [None, "On_Support"]
    assert rows["see.effort"][0].value is None
    assert rows["see.effort"][-1].value is not None
    assert [i.value for i in rows["posture"]] == ["Standing"]


def test_an_own_predicate_has_a_row_of_its_own() -> None:
    near = Predicate(predicate_subtree("early"), lambda stage, _agent, _name: stage.state.time_s < 0.5)
    still = small()
    told: list[float] = []
    rows = timeline(
        still,
        Observer(still.scene, still),
        agent="P1",
        name="cup",
        every_s=0.25,
        predicates=[near],
        progress=lambda _what, share: told.append(share),
    ).rows
    assert [(i.value, i.start_s) for i in rows["early"]] == [("True", 0.0), ("False", 0.5)]
    assert set(rows) == {*STANDARD_TREE.attributes, "early"}
    assert told[-1] == 1.0


def test_unknown_agents() -> None:
    still = small()
    with pytest.raises(UnknownNameError, match="no agent 'P3'; did you mean 'P2'"):
        timeline(still, Observer(still.scene, still), agent="P3", name="cup")


def test_parts_that_are_watched_at_once_join_to_the_same_timeline(monkeypatch: pytest.MonkeyPatch) -> None:
    """Parts begin and end anywhere: in the middle of intervals, between samples, right when something changes."""
    short = excerpt(NAME, 1.2, 4.2)
    lines = []
    for part_s, processes in ((100.0, 1), (0.3, 1), (0.35, 2)):
        monkeypatch.setattr(timelines, "PART_S", part_s)
        observer = Observer(short.scene, short)
        lines.append(
            timeline(short, observer, agent="P2", name="baton", every_s=0.2, processes=processes),
        )
    assert len(lines[0].rows["hands"]) > 1
    assert list(lines[0].rows) == list(lines[1].rows) == list(lines[2].rows)
    assert lines[0] == lines[1] == lines[2]


def test_what_was_assumed_of_eyes_is_in_it(line: Timeline) -> None:
    """P2's eyes are at the baton from half a second before its hand is; sampled every 0.6 s."""
    (gaze,) = line.gaze
    taken_s = line.rows["hands"][-1].start_s
    assert gaze.towards == "baton"
    assert taken_s - 1.0 <= gaze.start_s <= taken_s + 0.1, "its hand touches it a little before it holds it"
    assert gaze.end_s == line.rows["hands"][-1].end_s
    least_rad, most_rad = gaze.turned_rad
    assert 0.0 < least_rad <= most_rad <= DEFAULT.gaze.range_rad + 1e-9
