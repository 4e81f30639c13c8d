"""``taskgist map``: where agents see and reach, as pictures and arrays."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from taskgist.cli.common import (
    FAILED,
    OK,
    AtOption,
    JsonOption,
    ReplaceOption,
    WhereArgument,
    about,
    check_target,
    command,
    console,
    open_stage,
    print_json,
)
from taskgist.common.files import writing
from taskgist.errors import InputError, UnknownNameError
from taskgist.maps.ability_map import JUDGES, AbilityMap, ability_map, write_maps
from taskgist.maps.grid import Zone
from taskgist.maps.places import Place, places_for, zone_where
from taskgist.perspective.effort import EFFORT_NAMES, Ability
from taskgist.perspective.queries import parse_question
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.world.stage import Stage


@command
def map_(
    where: WhereArgument,
    agent: Annotated[str | None, typer.Option(help="Whose ability.")] = None,
    ability: Annotated[str, typer.Option(help="see or reach.")] = "reach",
    level: Annotated[int, typer.Option(min=0, max=4, help="The greatest effort level shown.")] = 4,
    question: Annotated[str | None, typer.Option("--where", help="Instead: a question about several agents.")] = None,
    size: Annotated[
        str | None, typer.Option(help="Mark places where an object so large could stand: metres, as 0.1,0.1,0.2.")
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="The PNG file to write.")] = None,
    npz: Annotated[Path | None, typer.Option(help="A file to write the arrays to, for numpy.")] = None,
    at: AtOption = None,
    replace: ReplaceOption = False,
    as_json: JsonOption = False,
) -> int:
    """Map where agents see and reach, and with what effort.

    Every cell of the workspace has the least effort for a point there. --where asks as in taskgist query, for places
    instead of objects; --size looks for places on supports in it. The exit code is 1 if there is no such cell or place.

    Example: taskgist map room.toml --agent P1 --level 2 -o map.png

    Example: taskgist map room.toml --where "P1 reaches and not P2 sees"
    """
    if out is not None:
        check_target(out, "--out", replace=replace, suffix=".png", what="pictures", inputs=[where])
    if npz is not None:
        check_target(npz, "--npz", replace=replace, suffix=".npz", what="arrays", inputs=[where])
    box_m = None if size is None else _size_m(size)
    stage = open_stage(where, at)
    with about(where, {"where": "--where", "size_m": "--size"}):
        asked = _Asked.question(stage, question, agent) if question is not None else None
        asked = asked or _Asked.map(stage, _named(agent), _mapped(ability), level)
        places = None if box_m is None else places_for(stage, box_m, asked.zone)
    if npz is not None:
        with writing(npz, replace=replace) as stream:
            write_maps(stream, asked.maps)
    if out is not None:
        _draw(stage, asked, places or (), out)
    _report(asked, places, out, npz, as_json=as_json)
    return OK if (asked.zone.count if places is None else places) else FAILED


@dataclass(frozen=True)
class _Asked:
    """What was asked for: the maps, the zone in question, and what is unknown."""

    title: str
    maps: tuple[AbilityMap, ...]
    zone: Zone
    unknown: Zone
    level: int | None = None

    @classmethod
    def map(cls, stage: Stage, agent: str, ability: Ability, level: int) -> _Asked:
        found = ability_map(stage, agent, ability)
        title = f"where {agent} {'sees' if ability == 'see' else 'reaches'}, effort level {level} at most"
        return cls(title, (found,), found.at_most(level), found.unknown, level)

    @classmethod
    def question(cls, stage: Stage, text: str, agent: str | None) -> _Asked:
        if agent is not None:
            raise InputError("does not go with --where", field="--agent", value=agent, hint="say it in the question")
        answered = zone_where(SceneEfforts(stage), parse_question(text, stage.scene.agents))
        return cls(text, answered.maps, answered.yes, answered.unknown)


def _draw(stage: Stage, asked: _Asked, places: tuple[Place, ...], path: Path) -> None:
    from taskgist.view.maps import Layers, map_picture  # with matplotlib, which only pictures should wait for

    if asked.level is None:
        layers = Layers.of_zone(asked.zone, asked.title, places)
    else:
        (found,) = asked.maps
        layers = Layers.of_map(found, EFFORT_NAMES[found.ability], max_level=asked.level, places=places)
    map_picture(stage, layers, path, title=asked.title)


def _report(
    asked: _Asked, places: tuple[Place, ...] | None, out: Path | None, npz: Path | None, *, as_json: bool
) -> None:
    files = {"picture": out, "arrays": npz}
    if as_json:
        print_json(_document(asked, places, files))
        return
    console.print(f"{asked.title}: {asked.zone.count} cells, {asked.zone.volume_m3:.2f} m³")
    if asked.unknown.count:
        console.print(f"  unknown: {asked.unknown.count} cells, for want of tracking")
    for found in asked.maps:
        names = (*EFFORT_NAMES[found.ability], "unknown")
        counts = ", ".join(f"{names[level]} {count}" for level, count in found.counts.items())
        console.print(f"  cells of {found.agent} to {found.ability}: {counts}")
    if places is not None:
        supports = Counter(place.support for place in places)
        listed = ", ".join(f"{count} on {support}" for support, count in supports.items()) or "none"
        console.print(f"  places to stand: {listed}")
    for path in files.values():
        if path is not None:
            console.print(f"saved {path}")


def _document(asked: _Asked, places: tuple[Place, ...] | None, files: dict[str, Path | None]) -> dict[str, Any]:
    grid = asked.zone.grid
    return {
        "title": asked.title,
        "cells": asked.zone.count,
        "volume_m3": asked.zone.volume_m3,
        "unknown_cells": asked.unknown.count,
        "grid": {"origin_m": grid.origin_m, "yaw_rad": grid.yaw_rad, "cell_m": grid.cell_m, "shape": grid.shape},
        "maps": [{"agent": m.agent, "ability": m.ability, "cells_by_level": m.counts} for m in asked.maps],
        "places": None if places is None else [{"position_m": p.position_m, "support": p.support} for p in places],
        **{name: None if path is None else str(path) for name, path in files.items()},
    }


def _named(agent: str | None) -> str:
    if agent is None:
        raise InputError("whose map is not said", field="--agent", hint="name --agent, or ask with --where")
    return agent


def _mapped(text: str) -> Ability:
    if text not in JUDGES:
        raise UnknownNameError("ability to map", text, JUDGES, where="--ability")
    return "see" if text == "see" else "reach"


def _size_m(text: str) -> tuple[float, float, float]:
    try:
        width, depth, height = (float(part) for part in text.split(","))
    except ValueError as error:
        hint = "width, depth and height in metres, as 0.1,0.1,0.2"
        raise InputError("needs three numbers", field="--size", value=text, hint=hint) from error
    return width, depth, height
