"""Relations in set questions, beside efforts: ``P1 reaches and P2 looks_at and not P2 touches``.

``parse_question(text, agents, RELATION_VERBS)`` reads them; ``Related`` is one of them as a value.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

from taskgist.errors import UnknownNameError
from taskgist.observe.attention import looks_at, sight
from taskgist.observe.relations import Side, carried_by, direction, distance, facing, touching
from taskgist.perspective.effort import Ability
from taskgist.perspective.queries import MoreVerbs, Question
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.settings import Settings
from taskgist.world.stage import Stage

Relation = Callable[[Stage, str, str, Settings], bool | None]
"""Whether something is so of an agent and an object; None is unknown."""


def _in_sight(stage: Stage, agent: str, name: str, settings: Settings) -> bool | None:
    found = sight(stage, agent, name, settings)
    return None if found is None else found.value != "blocked"


def _near(stage: Stage, agent: str, name: str, settings: Settings) -> bool | None:
    found = distance(stage, agent, name, settings)
    return None if found is None else found.value == "near"


def _carries(stage: Stage, agent: str, name: str, settings: Settings) -> bool | None:
    found = carried_by(stage, name, settings)
    return None if found is None else agent in found


def _at_side(side: Side, stage: Stage, agent: str, name: str, settings: Settings) -> bool | None:
    found = direction(stage, agent, name, settings=settings)
    return None if found is None else side in found.sides


RELATIONS: Mapping[str, Relation] = MappingProxyType(
    {
        "has_in_sight": _in_sight,
        "looks_at": looks_at,
        "faces": facing,
        "is_near": _near,
        "touches": touching,
        "carries": _carries,
        "has_left": partial(_at_side, "left"),
        "has_right": partial(_at_side, "right"),
        "has_in_front": partial(_at_side, "front"),
        "has_behind": partial(_at_side, "behind"),
    }
)
"""What can be asked of an agent and an object, by verb."""


@dataclass(frozen=True)
class Related(Question):
    """An agent and an object are in a relation.

    Attributes:
        agent: The agent.
        verb: The relation, one of ``RELATIONS``.

    Raises:
        UnknownNameError: There is no such relation.
    """

    agent: str
    verb: str

    def __post_init__(self) -> None:
        if self.verb not in RELATIONS:
            raise UnknownNameError("relation", self.verb, RELATIONS)

    def holds(self, efforts: SceneEfforts, name: str) -> bool | None:
        """Whether it is so; None is unknown."""
        with efforts.stage.showing(efforts.state) as stage:
            return RELATIONS[self.verb](stage, self.agent, name, efforts.settings)

    @property
    def abilities(self) -> tuple[tuple[str, Ability], ...]:
        """None: it asks for no effort."""
        return ()


def _related(verb: str) -> Callable[[str], Question]:
    return lambda agent: Related(agent, verb)


RELATION_VERBS: MoreVerbs = MappingProxyType({verb: _related(verb) for verb in RELATIONS})
"""The verbs of relations, for ``parse_question``."""
