"""How well episodes are found in recordings whose label was taken away, and which tasks are recognised in them.

A labelled demonstration is *found* if some handling of its time is by its performing agent, and about its thing: the
one that was handled, or one that came into view or went out of it thereby. Handlings beside it are *further* ones:
false, or true ones that nobody labelled, as where who was given a thing puts it down.

Scripted labels begin before the hand sets out, and end when it is back. Start and end are therefore held against the
thing's own way: when it was first away from where it was at the start of the label, and first where it is at its end.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np

from taskgist.common.workers import Progress, silent
from taskgist.pipeline.episodes import RecognisedHandling, recognise_handlings
from taskgist.pipeline.recognise import TaskRecogniser
from taskgist.recording.recording import Label, Recording
from taskgist_lab.evaluation.learner import Coded
from taskgist_lab.evaluation.replayed import Replayed
from taskgist_lab.evaluation.values import Result

AWAY_M = 0.02
"""A thing that is farther than this from where it was has been moved: trackers and settling things are as far off."""


@dataclass(frozen=True)
class FoundEpisode(Result):
    """What became of one labelled demonstration.

    Attributes:
        recording: Its name.
        task: The task that its label names.
        minutes: How long the recording lasts.
        found: Whether a handling is about it.
        start_off_s: How much later the handling starts than the thing is moved; None where another thing is moved.
        end_off_s: How much later it ends than the thing has come to where it stays; None likewise, and where it
            changes hands.
        further: Handlings that are not about it.
        recognised: Whether the likeliest task of the reading for its target agent and thing is right; None: not found.
        headline: Whether the likeliest reading of the handling is for that agent and thing, and right.
    """

    recording: str
    task: str
    minutes: float
    found: bool
    start_off_s: float | None
    end_off_s: float | None
    further: int
    recognised: bool | None
    headline: bool | None


def judged(recogniser: TaskRecogniser, recording: Recording, fulfilled: Collection[str] = ()) -> FoundEpisode:
    """Take a recording's label away, find episodes, and hold them against it.

    Args:
        recogniser: What is known.
        recording: A labelled recording.
        fulfilled: Further tasks than its label's that would be right, too.
    """
    label = recording.label
    assert label is not None
    right = {label.task, *fulfilled}
    handlings = recognise_handlings(recogniser, recording.with_label(None))
    about = [each for each in handlings if _is_about(each, label)]
    chosen = max(about, key=lambda each: each.handling.end_s - each.handling.start_s, default=None)
    minutes = recording.duration_s / 60
    further = len(handlings) - len(about)
    if chosen is None:
        return FoundEpisode(recording.name, label.task, minutes, False, None, None, further, None, None)
    reading = next(
        each
        for each in chosen.readings
        if each.label.target_objects == label.target_objects and set(each.label.target_agents) <= {*label.target_agents}
    )
    best, first = reading.recognised.best, chosen.readings[0]
    start_off_s, end_off_s = _off_s(recording, label, chosen)
    return FoundEpisode(
        recording.name,
        label.task,
        minutes,
        True,
        start_off_s,
        end_off_s,
        further,
        best is not None and best.task in right,
        first is reading and best is not None and best.task in right,
    )


def _is_about(found: RecognisedHandling, label: Label) -> bool:
    handling = found.handling
    middle_s = (handling.start_s + handling.end_s) / 2
    return (
        handling.performing_agent == label.performing_agent
        and label.start_s <= middle_s <= label.end_s
        and any(
            each.label.target_objects == label.target_objects
            and set(each.label.target_agents) <= {*label.target_agents}
            for each in found.readings
        )
    )


def _off_s(recording: Recording, label: Label, found: RecognisedHandling) -> tuple[float | None, float | None]:
    """How much later a handling starts and ends than its thing is moved, and is where it stays."""
    handling = found.handling
    if handling.thing not in label.target_objects:
        return None, None
    first, last = recording.index_at(label.start_s), recording.index_at(label.end_s)
    places = recording.qpos[first : last + 1, recording.scene.object_slice(handling.thing)][:, :3]
    times_s = recording.times_s[first : last + 1]
    away = np.linalg.norm(places - places[0], axis=1) > AWAY_M
    on_its_way = np.linalg.norm(places - places[-1], axis=1) > AWAY_M
    if not away.any() or not on_its_way.any():
        return None, None
    start_off_s = handling.start_s - float(times_s[away.argmax()])
    end_off_s = handling.end_s - float(times_s[len(on_its_way) - 1 - on_its_way[::-1].argmax()])
    return start_off_s, (None if handling.ending == "changes hands" else end_off_s)


@dataclass(frozen=True)
class EpisodeScores(Result):
    """How well episodes are found in many recordings.

    Attributes:
        recordings: How many.
        found: Share of the labelled demonstrations that are found.
        start_within: Share of starts within 0.5 s, and within 1 s, of those that are found and known.
        end_within: That of ends.
        further_per_minute: Handlings per minute that no label is about.
        recognised: Share of the found ones whose task is right, for their target agent and thing.
        headline: Share of the found ones of which the likeliest reading is the right task for the right agent.
    """

    recordings: int
    found: float
    start_within: tuple[float, float]
    end_within: tuple[float, float]
    further_per_minute: float
    recognised: float
    headline: float


def episodes(coded: Coded, *, processes: int | None = None, progress: Progress = silent) -> EpisodeScores:
    """Take the labels of held-out demonstrations away, and find what is done in them.

    Args:
        coded: A pool.
        processes: How many to use; by default one for each core.
        progress: Told how far it is.

    Raises:
        InputError: The pool has too few demonstrations.
    """
    replayed = Replayed.of(coded.pool)
    found = replayed.each(
        lambda sample: judged(replayed.recogniser, replayed.recording(sample), sample.fulfilled),
        "episodes",
        processes=processes,
        progress=progress,
    )
    return scores_of(found)


def scores_of(episodes: Iterable[FoundEpisode]) -> EpisodeScores:
    """The scores of some recordings."""
    every = list(episodes)
    found = [each for each in every if each.found]
    starts = [abs(each.start_off_s) for each in found if each.start_off_s is not None]
    ends = [abs(each.end_off_s) for each in found if each.end_off_s is not None]
    return EpisodeScores(
        len(every),
        _share([each.found for each in every]),
        (_share([off < 0.5 for off in starts]), _share([off < 1.0 for off in starts])),
        (_share([off < 0.5 for off in ends]), _share([off < 1.0 for off in ends])),
        sum(each.further for each in every) / max(sum(each.minutes for each in every), 1e-9),
        _share([bool(each.recognised) for each in found]),
        _share([bool(each.headline) for each in found]),
    )


def _share(truths: list[bool]) -> float:
    return sum(truths) / len(truths) if truths else float("nan")
