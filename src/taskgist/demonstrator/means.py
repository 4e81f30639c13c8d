"""Means: ways to reach an intention, as scripts whose places are chosen in the scene at hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from taskgist.demonstrator.hiding import behind
from taskgist.demonstrator.places import COMFORTABLE_VIEW_M, before_face, on_top
from taskgist.demonstrator.putting import Place
from taskgist.demonstrator.script import Script, Step
from taskgist.demonstrator.steps import HoldUp, PutDown, Take, Withdraw
from taskgist.world import Scene, Stage

HELD_S = 1.0
"""How long something is held up before the recording ends, at least."""

Means = Callable[[Scene], Script]


@dataclass(frozen=True)
class Roles:
    """Who does it, with what, for whom.

    Attributes:
        performer: Who acts.
        target: For whom.
        thing: The object.
        side: The acting hand.
        target_watches: What the target agent looks at in the beginning; None: the performer's face.
        target_returns_to: What it is busy with, and looks at again when the thing rests; None: nothing.
    """

    performer: str
    target: str
    thing: str
    side: str
    target_watches: str | None = None
    target_returns_to: str | None = None

    def script(self, task: str, means: str, *steps: Step) -> Script:
        """A script with these roles, which begins with taking the thing."""
        return Script(
            task,
            self.performer,
            self.target,
            self.thing,
            (Take(self.thing, self.side), *steps),
            self.target_watches,
            means,
            self.target_returns_to,
        )

    def putting(self, task: str, means: str, place: Callable[[Scene], Place]) -> Means:
        """Means that are a putting down of the thing at a place, which is looked for in the scene at hand."""
        return lambda scene: self.script(task, means, PutDown(place(scene)), Withdraw())


def hold_up(roles: Roles, *, distance_m: float = COMFORTABLE_VIEW_M) -> Means:
    """Show by holding up, before the target agent's face, at a distance from its eye."""

    def script(scene: Scene) -> Script:
        place = before_face(scene, roles.performer, roles.target, roles.side, distance_m)
        return roles.script("show", "held up before the face", HoldUp(place, HELD_S))

    return script


def put_on_top(roles: Roles, *, of: str) -> Means:
    """Show by putting on top of something."""
    return roles.putting("show", f"put on top of {of}", lambda scene: on_top(Stage(scene), of))


def put_behind(roles: Roles, *, occluder: str) -> Means:
    """Hide by putting behind something, as seen by the target agent."""

    def place(scene: Scene) -> Place:
        return behind(scene, roles.thing, occluder, roles.target)

    return roles.putting("hide", f"put behind {occluder}", place)
