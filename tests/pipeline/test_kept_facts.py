"""Facts that are kept: the same as were found, never of something else, and never in the way."""

from __future__ import annotations

from pathlib import Path

import pytest

from taskgist.common.frozen import Json
from taskgist.errors import RecordingError
from taskgist.observe import Observer
from taskgist.pipeline import explain_recording, kept_facts, timeline
from taskgist.pipeline.kept_facts import FactsOverTime, facts_from_json, remembered
from taskgist.recording import write
from tests.shipped import excerpt

ASKED: dict[str, Json] = {"agent": "P2", "every_s": 1.0}


@pytest.fixture(scope="module")
def facts() -> FactsOverTime:
    short = excerpt("handover_1", 1.2, 4.2)
    observer = Observer(short.scene, short)
    line = timeline(short, observer, agent="P2", name="baton", every_s=1.0)
    return FactsOverTime((line,), explain_recording(short, observer=observer))


@pytest.fixture
def recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    path = tmp_path / "short.mcap"
    write(excerpt("handover_1", 1.2, 4.2), path)
    return path


class Watch:
    """Counts how often it has to be watched."""

    def __init__(self, facts: FactsOverTime) -> None:
        self.facts, self.times = facts, 0

    def __call__(self) -> FactsOverTime:
        self.times += 1
        return self.facts


def kept(tmp_path: Path) -> list[Path]:
    return sorted((tmp_path / "cache" / "taskgist" / "facts").glob("*"))


def test_facts_come_back_as_they_were(facts: FactsOverTime) -> None:
    again = facts_from_json(facts.to_json())
    assert facts.timelines[0].gaze
    assert again.timelines == facts.timelines
    assert again.effect is not None
    assert facts.effect is not None
    assert again.effect.to_json() == facts.effect.to_json()
    assert facts_from_json(FactsOverTime(facts.timelines, None).to_json()).effect is None


def test_the_second_time_nothing_is_watched(recording: Path, facts: FactsOverTime) -> None:
    watch = Watch(facts)
    first, second = remembered(recording, ASKED, watch), remembered(recording, ASKED, watch)
    assert watch.times == 1
    assert first.timelines == second.timelines == facts.timelines


def test_another_file_question_or_version_is_watched(
    recording: Path, facts: FactsOverTime, monkeypatch: pytest.MonkeyPatch
) -> None:
    watch = Watch(facts)
    remembered(recording, ASKED, watch)
    remembered(recording, {**ASKED, "every_s": 0.5}, watch)
    assert watch.times == 2
    changed = recording.with_name("longer.mcap")
    write(excerpt("handover_1", 1.2, 4.3), changed)
    remembered(changed, ASKED, watch)
    assert watch.times == 3
    monkeypatch.setattr(kept_facts, "_sources", lambda: "of tomorrow")
    remembered(recording, ASKED, watch)
    assert watch.times == 4


def test_a_copy_by_another_name_is_the_same_recording(recording: Path, facts: FactsOverTime) -> None:
    watch, copy = Watch(facts), recording.with_name("copy.mcap")
    copy.write_bytes(recording.read_bytes())
    remembered(recording, ASKED, watch)
    remembered(copy, ASKED, watch)
    assert watch.times == 1


@pytest.mark.parametrize("damage", [b"", b"{", b"[]", b'{"timelines": [{}], "effect": null}', b"\xff", b"[" * 100_000])
def test_what_is_damaged_is_found_anew(recording: Path, facts: FactsOverTime, tmp_path: Path, damage: bytes) -> None:
    watch = Watch(facts)
    remembered(recording, ASKED, watch)
    (file,) = kept(tmp_path)
    file.write_bytes(damage)
    assert remembered(recording, ASKED, watch).timelines == facts.timelines
    assert watch.times == 2
    remembered(recording, ASKED, watch)
    assert watch.times == 2, "what was damaged is replaced"


def test_what_cannot_be_written_is_not_kept(recording: Path, facts: FactsOverTime, tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("a file where the folder would be")
    watch = Watch(facts)
    assert remembered(recording, ASKED, watch).timelines == facts.timelines
    remembered(recording, ASKED, watch)
    assert watch.times == 2


def test_a_file_that_changes_meanwhile_is_not_kept(recording: Path, facts: FactsOverTime, tmp_path: Path) -> None:
    def watch() -> FactsOverTime:
        write(excerpt("handover_1", 1.2, 4.3), recording)
        return facts

    remembered(recording, ASKED, watch)
    assert not kept(tmp_path)


def test_what_was_not_asked_for_longest_makes_room(
    recording: Path, facts: FactsOverTime, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kept_facts, "MOST_FILES", 3)
    watch = Watch(facts)
    for every_s in (1.0, 2.0, 3.0):
        remembered(recording, {"every_s": every_s}, watch)
    remembered(recording, {"every_s": 1.0}, watch)
    remembered(recording, {"every_s": 4.0}, watch)
    assert (len(kept(tmp_path)), watch.times) == (3, 4)
    remembered(recording, {"every_s": 1.0}, watch)
    assert watch.times == 4
    remembered(recording, {"every_s": 2.0}, watch)
    assert watch.times == 5
    monkeypatch.setattr(kept_facts, "MOST_BYTES", 2.5 * kept(tmp_path)[0].stat().st_size)
    remembered(recording, {"every_s": 5.0}, watch)
    assert len(kept(tmp_path)) == 2
    monkeypatch.setattr(kept_facts, "LARGEST_BYTES", 10)
    remembered(recording, {"every_s": 6.0}, watch)
    remembered(recording, {"every_s": 6.0}, watch)
    assert watch.times == 8, "what is too large is not kept"


def test_no_recording_no_facts(tmp_path: Path, facts: FactsOverTime) -> None:
    with pytest.raises(RecordingError, match=r"nowhere\.mcap: cannot be read"):
        remembered(tmp_path / "nowhere.mcap", ASKED, Watch(facts))
