"""A recording without a label as a list of tasks: what was done when, by whom, for whom, with which thing.

Each time that a thing is handled (``recognition.episodes``) is read for each other agent as the one for whom it may be
done, and each reading is explained as a demonstration is, and recognised. So is each thing beside it that comes into
somebody's view thereby, or goes out of it: who puts a cover over a cup moves the cover, and hides the cup.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from taskgist.common.workers import Progress, silent
from taskgist.facts.predicates import Predicate, known_predicates
from taskgist.facts.tree import TreeOf
from taskgist.observe.observer import Observer
from taskgist.perspective.viewpoint import Viewpoint
from taskgist.pipeline.explain import explain_recording
from taskgist.pipeline.recognise import RecognisedEpisode, TaskRecogniser
from taskgist.recognition.episodes import Handling, handlings_of
from taskgist.recording.recording import Label, Recording
from taskgist.settings import DEFAULT, Settings
from taskgist.world.stage import Stage

BESIDE_M = 1.0
"""So near to where a thing was, or is put, others may come into view or go out of it."""
MARGIN_S = 1.0
"""Facts are looked at so long before a handling starts and after it ends, if nothing else is done with the thing: when
hands have not come yet, and are gone again."""


@dataclass(frozen=True)
class RecognisedHandling:
    """What was done when a thing was handled once.

    Attributes:
        handling: When, by whom, with what, and how sure that is.
        readings: What it is for each agent for whom, and each thing with which it may have been done: the likeliest
            first. None where nobody is seen to handle it, or no task is known in the trees of who is there.
    """

    handling: Handling
    readings: tuple[RecognisedEpisode, ...]

    @property
    def best(self) -> RecognisedEpisode | None:
        """The likeliest reading; None where nothing known is likelier than something else."""
        first = next(iter(self.readings), None)
        return first if first and first.recognised.best else None

    @property
    def told(self) -> tuple[RecognisedEpisode, ...]:
        """The readings in which something known was done; several may be right at once."""
        return tuple(each for each in self.readings if each.recognised.best)


def recognise_handlings(
    recogniser: TaskRecogniser,
    recording: Recording,
    *,
    of: TreeOf = "target",
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] | None = None,
    observer: Observer | None = None,
    progress: Progress = silent,
) -> tuple[RecognisedHandling, ...]:
    """What was done each time that a thing was handled in a recording; its label, if it has one, plays no part.

    Args:
        recogniser: What is known.
        recording: The recording.
        of: For whom: the other agents, or who performs. Who is alone performs for nobody else in any case.
        settings: All settings.
        predicates: A user's own predicates; by default all that are known.
        observer: One of this recording, if there is one.
        progress: Told how far it is.

    Returns:
        All handlings whose confidence is enough to propose a label (``settings.checks.least_confidence``), in order.
    """
    known = known_predicates() if predicates is None else tuple(predicates)
    observer = observer or Observer(recording.scene, recording, settings)
    every = handlings_of(recording, observer, settings=settings)
    handlings = [each for each in every if each.confidence >= settings.checks.least_confidence]
    found = []
    for number, handling in enumerate(handlings):
        progress("recognising", number / len(handlings))
        span = _with_margins(recording, handling, every)
        readings = _readings(recogniser, recording, observer, handling, span, of, settings, known)
        found.append(RecognisedHandling(handling, readings))
    progress("done", 1.0)
    return tuple(found)


def untracked_hands(recording: Recording) -> tuple[tuple[str, str], ...]:
    """Agents and sides of hands that are tracked in no frame: what these move nobody is seen to handle."""
    hands = ((name, arm.profile.side) for name in recording.scene.agents for arm in recording.scene.agent(name).arms)
    lost = {name for name, flags in recording.tracked.items() if not flags.any()}
    return tuple((name, side) for name, side in hands if not lost.isdisjoint((name, f"{name}/{side}_arm")))


def _with_margins(recording: Recording, handling: Handling, every: Sequence[Handling]) -> tuple[float, float]:
    """From when to when facts are looked at: a little before and after, up to what else is done with the thing."""
    first_s, last_s = float(recording.times_s[0]), float(recording.times_s[-1])
    others = [each for each in every if each.thing == handling.thing]
    before = max((each.end_s for each in others if each.end_s <= handling.start_s), default=first_s)
    after = min((each.start_s for each in others if each.start_s >= handling.end_s), default=last_s)
    start_s = max(handling.start_s - MARGIN_S, min(before, handling.start_s), first_s)
    end_s = min(handling.end_s + MARGIN_S, max(after, handling.end_s), last_s)
    return start_s, (end_s if handling.ending == "rests" else handling.end_s)


def _readings(
    recogniser: TaskRecogniser,
    recording: Recording,
    observer: Observer,
    handling: Handling,
    span: tuple[float, float],
    of: TreeOf,
    settings: Settings,
    predicates: tuple[Predicate, ...],
) -> tuple[RecognisedEpisode, ...]:
    if handling.performing_agent is None:
        return ()
    pairs: list[tuple[str | None, str]] = [(None, handling.thing)]
    if of == "target" and handling.target_agents:
        beside = _beside(recording, observer, handling, span, settings)
        pairs = [(agent, handling.thing) for agent in handling.target_agents]
        pairs += [(agent, name) for agent in handling.target_agents for name in beside.get(agent, ())]
    found = []
    for agent, name in pairs:
        whose: TreeOf = "target" if agent else "performer"
        if whose not in recogniser.by_tree:
            continue
        told = handling.label(agent, name)
        label = Label(told.task, told.performing_agent, told.target_agents, name, *span, told.how)
        explanation = explain_recording(
            recording, label=label, of=whose, settings=settings, predicates=predicates, observer=observer
        )
        recognised = recogniser.by_tree[whose].recognise(explanation.nodes)
        learned_from = explanation.recording in recogniser.recordings
        found.append(RecognisedEpisode(told, True, explanation, recognised, learned_from))
    # Of equally likely readings the first is the one that was named first: who takes the thing, or looks at it.
    return tuple(sorted(found, key=lambda each: each.recognised.none))


def _beside(
    recording: Recording, observer: Observer, handling: Handling, span: tuple[float, float], settings: Settings
) -> dict[str, list[str]]:
    """By agent: the things that are not moved, and come into its view or go out of it, where this thing is moved."""
    stage = Stage(recording.scene)
    own = recording.scene.object_slice(handling.thing)
    seen: list[dict[tuple[str, str], float | None]] = []
    places = []
    for time_s in span:
        state = recording.at(time_s)
        places.append({name: state.qpos[recording.scene.object_slice(name)][:3] for name in recording.scene.objects})
        seen.append({})
        near = _near(places, state.qpos[own][:3], handling.thing)
        for agent in handling.target_agents:
            stage.show(observer.as_confirmed(state, gaze_of=agent))
            here = Viewpoint(stage, agent, settings)
            for name in near if len(seen) == 2 else places[0]:
                if name != handling.thing:
                    visible = here.visibility(name)
                    seen[-1][agent, name] = None if visible is None else visible.score
    least, found = settings.vision.negligible_score, dict[str, list[str]]()
    for (agent, name), after in seen[1].items():
        before = seen[0].get((agent, name))
        if before is not None and after is not None and (before < least) != (after < least):
            found.setdefault(agent, []).append(name)
    return found


def _near(places: Sequence[dict[str, np.ndarray]], now: np.ndarray, thing: str) -> list[str]:
    """The things that stayed where they were, near to where this one was at first, or is now."""
    return [
        name
        for name, place in places[0].items()
        if name != thing
        and np.linalg.norm(places[-1][name] - place) < 0.02
        and min(np.linalg.norm(place - places[0][thing]), np.linalg.norm(place - now)) < BESIDE_M
    ]
