"""taskgist: learn what a task means for another person, from one to a few demonstrations.

    from taskgist import learn, meaning, read_recording

    recordings = [read_recording(path) for path in ("give_1.mcap", "give_2.mcap")]
    knowledge = learn(recordings)
    print(meaning(knowledge.understand("give")))

What most users need, by purpose; each name is loaded when it is first used:

- A scene and its agents: `Scene`, `Stage` (a scene in one state: what everything is asked of), `AgentProfile`.
- Who sees, reaches and grasps what, with how much effort: `least_effort`, `visibility`, `SceneEfforts` (all efforts of
  a scene), `parse_question` and `objects_where` (questions about several agents).
- Where: `ability_map`, `Grid`, `places_for`.
- Demonstrations: `Recording`, `Label`, `read_recording`, `write_recording`, `load_mapping` and `import_recording` (from
  other systems' tables), `propose_label`, `check_recording`.
- Facts: `Observer` (over time, of recordings and live), `explain_recording` (between start and end), `Predicate` (your
  own).
- What tasks mean: `learn`, `Knowledge`, `load_knowledge`, `update_knowledge`, `meaning`, `why`.
- All thresholds: `Settings`. All expected errors: `TaskgistError`.

Their neighbours are in the rooms, such as `taskgist.facts` (facts from elsewhere), `taskgist.learning` (clauses and
questions), `taskgist.world` (contacts, holding) and `taskgist.view` (pictures). What neither this face nor theirs shows
may change.
"""

from __future__ import annotations

import importlib
from typing import Any

_WHERE = {
    "Scene": "world.scene:Scene",
    "Stage": "world.stage:Stage",
    "AgentProfile": "world.bodies.profile:AgentProfile",
    "least_effort": "perspective.search:least_effort",
    "visibility": "perspective.image:visibility",
    "SceneEfforts": "perspective.scene_efforts:SceneEfforts",
    "parse_question": "perspective.queries:parse_question",
    "objects_where": "perspective.queries:objects_where",
    "Grid": "maps.grid:Grid",
    "ability_map": "maps.ability_map:ability_map",
    "places_for": "maps.places:places_for",
    "Recording": "recording.recording:Recording",
    "Label": "recording.recording:Label",
    "read_recording": "recording.mcap:read",
    "write_recording": "recording.mcap:write",
    "load_mapping": "importing.mapping_file:load_mapping",
    "import_recording": "importing.build:import_recording",
    "propose_label": "recognition.label_proposal:propose_label",
    "check_recording": "pipeline.checkup:check",
    "Observer": "observe.observer:Observer",
    "explain_recording": "pipeline.explain:explain_recording",
    "Predicate": "facts.predicates:Predicate",
    "learn": "pipeline.explain:learn",
    "Knowledge": "learning.knowledge:Knowledge",
    "load_knowledge": "store.database:load",
    "update_knowledge": "store.database:update",
    "meaning": "language.sentences:meaning",
    "why": "language.sentences:why",
    "Settings": "settings:Settings",
    "TaskgistError": "errors:TaskgistError",
}
"""Where each name is defined; ``__init__.pyi`` says the same to type checkers."""

__all__ = sorted(_WHERE)


def __getattr__(name: str) -> Any:
    """Load a name when it is first used."""
    if name not in _WHERE:
        raise AttributeError(f"module 'taskgist' has no attribute {name!r}")
    module, _, attribute = _WHERE[name].partition(":")
    value = getattr(importlib.import_module(f"taskgist.{module}"), attribute)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
