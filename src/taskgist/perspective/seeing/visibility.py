"""Visibility: how much of an object an agent sees from its current state, and what stands in the way (5.1.1)."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.seeing.glimpse import off_gaze
from taskgist.perspective.seeing.image import lens_of
from taskgist.perspective.seeing.sight import Sight, look, sight_now
from taskgist.perspective.target import Target
from taskgist.settings import DEFAULT, Settings
from taskgist.world import Agent, Stage


@dataclass(frozen=True)
class Visibility:
    """How much of an object is visible, from one state.

    Attributes:
        visible_px: Pixels of the object in the image of the whole field of view.
        image_px: Pixels of that image.
        unoccluded_px: Pixels that the object would have if nothing stood in the way.
        gaze_px: Those of the visible pixels that lie in the gaze cone.
        occluders: What covers the object's pixels, and how many of them, most first.
        nearest_m: Distance from the eye to the nearest point seen, in metres; None where nothing is seen.
        off_gaze_rad: Angle between the gaze and the object's middle.
    """

    visible_px: int
    image_px: int
    unoccluded_px: int
    gaze_px: int
    occluders: tuple[tuple[str, int], ...]
    nearest_m: float | None
    off_gaze_rad: float

    @property
    def score(self) -> float:
        """ViS: pixels of the object / pixels of the image (5.1.1)."""
        return self.visible_px / self.image_px

    @property
    def visible_share(self) -> float:
        """Occlusion ratio: visible pixels / pixels if nothing stood in the way; 0 out of the field of view."""
        return self.visible_px / self.unoccluded_px if self.unoccluded_px else 0.0

    @property
    def in_gaze_cone(self) -> bool:
        """Whether something of the object is seen in the gaze cone."""
        return self.gaze_px > 0

    @property
    def evidence(self) -> dict[str, object]:
        """Plain data, fit for JSON."""
        return {
            "score": self.score,
            "visible_px": self.visible_px,
            "image_px": self.image_px,
            "unoccluded_px": self.unoccluded_px,
            "gaze_px": self.gaze_px,
            "occluders": [[owner, count] for owner, count in self.occluders],
            "nearest_m": self.nearest_m,
            "off_gaze_rad": self.off_gaze_rad,
        }


def visibility(
    stage: Stage,
    agent: str,
    name: str,
    settings: Settings = DEFAULT,
) -> Visibility | None:
    """How much of an object an agent sees from its current state.

    Args:
        stage: The scene in a state.
        agent: Whose eye.
        name: The object.
        settings: All settings.

    Returns:
        None where the object or the agent's head was not tracked: that is unknown, not invisible.

    Raises:
        UnknownNameError: There is no such agent or object.
    """
    body = stage.scene.agent(agent)
    stage.scene.object_body(name)
    if not stage.state.known([name, f"{agent}/head"]):
        return None
    target = Target(stage, name, settings)
    return measured(stage, body, target, look(stage, body, target))


def visibility_from(here: Standpoint, name: str) -> Visibility | None:
    """As ``visibility``, from a standpoint."""
    here.stage.scene.object_body(name)
    if not here.state.known([name, f"{here.agent.name}/head"]):
        return None
    target = here.target(name)
    return measured(here.stage, here.agent, target, sight_now(here, target))


def measured(stage: Stage, agent: Agent, target: Target, sight: Sight) -> Visibility:
    """What a sight of an object comes to."""
    owners = stage.scene.owners
    others = Counter(owners[geom] for geom in sight.geoms[~sight.visible].tolist())
    width, height = agent.profile.eye.image_px
    in_cone = sight.rays_in_eye[:, 0] >= lens_of(agent.profile.eye).cone_cos
    near = sight.distances_m[sight.visible]
    return Visibility(
        visible_px=int(sight.visible.sum()),
        image_px=width * height,
        unoccluded_px=len(sight.geoms),
        gaze_px=int((sight.visible & in_cone).sum()),
        occluders=tuple(sorted(others.items(), key=lambda item: (-item[1], item[0]))),
        nearest_m=float(near.min()) if len(near) else None,
        off_gaze_rad=off_gaze(sight.eye, target.middle, 0.0),
    )
