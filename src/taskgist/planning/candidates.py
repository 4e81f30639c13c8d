"""Where a thing could be in the end: candidates for a planner, each a state of the scene with the thing elsewhere.

On and in everything that can carry it: tables, shelf boards, tops of other things, floors of bins and drawers; place ×
which side is down × heading. Nothing is drawn on a fixed grid: each level face has a low-discrepancy sequence of points
[Roberts 2018], from coarse to fine, so that a small face is covered as well as a large one, and faces take turns, so
that the first candidates are spread over all of them. Whoever needs more asks on. Floors and seats are last, for a
thing that lies on the floor is out of many people's sight and reach::

    for candidate in candidates(stage, "tape", "PR2", "P2"):
        judge(candidate.state)

A candidate rests (``placing``). In the air, held up before somebody's face or handed over, it is where hands would
hold it (``in_air``).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import islice

import numpy as np

from taskgist.errors import InputError, UnknownNameError
from taskgist.maps.places import Ground
from taskgist.planning.in_air import handed_over, held_up
from taskgist.planning.placing import HEADINGS, NEAR_M, Asking, Candidate, Means, Put, carried, free
from taskgist.planning.resting import Face, level_faces, tiers
from taskgist.settings import DEFAULT, Settings
from taskgist.world.stage import Stage

__all__ = ["MEANS", "NEAR_M", "Candidate", "Means", "candidates"]

MEANS: tuple[Means, ...] = ("put_on", "put_in", "hold_up", "hand_over")
"""How a thing may get to a candidate."""


def candidates(
    stage: Stage,
    thing: str,
    performer: str,
    target: str,
    settings: Settings = DEFAULT,
    *,
    allow: Collection[str] | None = None,
    prefer: Collection[str] = (),
    means: Collection[Means] = ("put_on", "put_in"),
    seed: int = 0,
) -> Iterator[Candidate]:
    """Where a thing could be in the end, well spread, the same for the same question.

    Where it is now, or nearly, is none of them. What stands or lies on the thing stays where it is: move that first.

    Args:
        stage: The scene in the state from which to start; it is left as it is.
        thing: The thing.
        performer: Who is to bring it there: what is too high above its shoulders is left aside.
        target: Before whose face it is held up, or to whom it is handed over.
        settings: For what a container is, and what reach.
        allow: The only supports and containers, the floor and seats among them if they are named; None: all.
        prefer: Supports and containers that come first.
        means: How it may get there; those asked for take turns.
        seed: Shifts all sequences.

    Yields:
        Candidates; with supports, without an end that anybody would wait for.

    Raises:
        InputError: There is no such means, or it is not known where the thing is.
        UnknownNameError: There is no such thing, agent, support or container.
    """
    scene = stage.scene
    scene.object_body(thing), scene.agent(performer), scene.agent(target)
    for each in means:
        if each not in MEANS:
            raise InputError("no such means", field="means", value=each, hint=f"one of {', '.join(MEANS)}")
    if not stage.state.known([thing]):
        raise InputError("nobody knows where it is", field="thing", value=thing, hint="a thing that is tracked")
    asking = Asking.of(Stage(scene, stage.state), thing, performer, target, settings, seed)
    ways: list[Iterator[Candidate]] = []
    if {"put_on", "put_in"} & set(means):
        known = level_faces(asking.stage, thing)
        check_supports((*(allow or ()), *prefer), known)
        faces = [face for face in known if face.height_m < asking.highest_m]
        ways.append(
            _on_supports(
                asking, tiers(asking.stage, faces, performer, settings, allow=allow, prefer=prefer), frozenset(means)
            )
        )
    if "hold_up" in means:
        ways.append(held_up(asking))
    if "hand_over" in means:
        ways.append(handed_over(asking))
    return in_turn(ways)


def check_supports(names: Iterable[str], faces: Sequence[Face]) -> None:
    """See that names are those of supports or containers.

    Args:
        names: The names.
        faces: What could carry something.

    Raises:
        UnknownNameError: Nothing of that name could.
    """
    known = {face.owner for face in faces}
    for name in names:
        if name not in known:
            raise UnknownNameError("support", name, known)


def in_turn(ways: list[Iterator[Candidate]]) -> Iterator[Candidate]:
    """One of each, again and again, until all have come to their end."""
    while ways:
        for way in list(ways):
            found = next(way, None)
            if found is None:
                ways.remove(way)
            else:
                yield found


# --- Candidates on faces.

PLASTIC = 1.324717957244746
R2 = np.array([1 / PLASTIC, 1 / PLASTIC**2])
"""Steps of a sequence of points that covers a square evenly [Roberts 2018]."""
SPACING_M, LEAST_SPOTS = 0.02, 64
"""Points of a face are so dense in the end, and so many at least."""
BATCH, TRIES = 32, 64
"""Places that are tried at once; a face on which so many in a row were carried, but nowhere free, has no room."""
BURSTS = (1000, 1000, 200, 200)
"""After so many that are preferred, and of others, come some on seats and floors, then others again."""


def _on_supports(asking: Asking, tiers: list[list[Face]], means: frozenset[str]) -> Iterator[Candidate]:
    """Candidates on faces, tier after tier; on demand again, where there are more."""
    ground = Ground(asking.stage.show(asking.start), asking.settings, but=asking.thing)
    streams = [_spread(asking, ground, faces, means) for faces in tiers]
    going = [True] * len(streams)
    while any(going):
        for number, (stream, most) in enumerate(zip(streams, BURSTS, strict=True)):
            found = 0
            for candidate in islice(stream, most):
                found += 1
                yield candidate
            going[number] = found == most


def _spread(asking: Asking, ground: Ground, faces: list[Face], means: frozenset[str]) -> Iterator[Candidate]:
    """Candidates on some faces, which take turns: all once, then large ones more often.

    What has four times the area gets twice the turns, shared by its faces as they share the area.
    """
    places = [_Places(asking, ground, face, means) for face in faces]
    areas_m2: dict[str, float] = {}
    for face in faces:
        areas_m2[face.owner] = areas_m2.get(face.owner, 0.0) + face.area_m2
    waits = [math.sqrt(areas_m2[face.owner]) / face.area_m2 for face in faces]
    due, met = np.zeros(len(faces)), [False] * len(faces)
    while len(due) and np.isfinite(due.min()):
        turn = int(due.argmin())
        found = places[turn].one()
        met[turn] |= found is not None
        # Small faces wait long for their turns, but not for their first candidate.
        wait = waits[turn] if met[turn] else min(waits)
        due[turn] = math.inf if places[turn].exhausted else due[turn] + wait
        if found is not None:
            yield found


class _Places:
    """Candidates on one face, from coarse to fine, first with one heading and side at each point, then with others.

    Attributes:
        exhausted: Whether there are no more.
    """

    def __init__(self, asking: Asking, ground: Ground, face: Face, means: frozenset[str]) -> None:
        self._asking, self._ground, self._face, self._means = asking, ground, face, means
        self._turns = [(side, heading) for heading in HEADINGS for side in range(len(asking.sides))]
        self._spots = max(LEAST_SPOTS, math.ceil(face.area_m2 / SPACING_M**2))
        self._next, self._ready, self._in_vain, self._uncarried = 0, list[Put](), 0, 0
        self.exhausted = False

    def one(self) -> Candidate | None:
        """The next candidate; None if there is none among the next places, though later ones may have one."""
        asking = self._asking
        if not self._ready:
            self._ready = self._carried()
        while self._ready:
            found = free(asking, self._face, self._ready.pop(0), self._means)
            if found is not None:
                self._in_vain = 0
                return found
            self._in_vain += 1
        self.exhausted = (
            self._next >= self._spots * len(self._turns) or self._in_vain >= TRIES or self._uncarried >= self._spots
        )
        return None

    def _carried(self) -> list[Put]:
        """Of the next places those at which the thing is carried."""
        asking, face = self._asking, self._face
        numbers = np.arange(self._next, min(self._next + BATCH, self._spots * len(self._turns)))
        self._next += len(numbers)
        if not len(numbers):
            return []
        spots = numbers % self._spots
        points = face.points((asking.shift[:2] + np.outer(spots, R2)) % 1.0)
        turns = [self._turns[k] for k in (spots + numbers // self._spots) % len(self._turns)]
        found = carried(self._ground, face, points, [(asking.sides[side], turn) for side, turn in turns])
        self._uncarried = 0 if found else self._uncarried + len(numbers)
        return found
