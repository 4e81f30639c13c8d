"""``taskgist query``: who sees, reaches and grasps what, by which actions, and why."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Annotated, Any

import typer
from rich.text import Text

from taskgist.cli.common import (
    FAILED,
    OK,
    AtOption,
    JsonOption,
    WhereArgument,
    about,
    command,
    console,
    open_stage,
    print_json,
)
from taskgist.errors import InputError, UnknownNameError
from taskgist.language.efforts import why
from taskgist.observe.relation_questions import RELATION_VERBS
from taskgist.perspective.effort import ABILITIES, Ability, Effort
from taskgist.perspective.queries import objects_where, parse_question
from taskgist.perspective.scene_efforts import SceneEfforts, able_by, becoming_able_by
from taskgist.world.scene import Scene

WIDTH = 28
"""Columns of an answer in a table."""


@command
def query(
    where: WhereArgument,
    agent: Annotated[str | None, typer.Option(help="Whose; default: every agent's.")] = None,
    ability: Annotated[str | None, typer.Option(help="see, reach or grasp; default: all three.")] = None,
    object: Annotated[str | None, typer.Option("--object", help="For which object; default: every one.")] = None,  # noqa: A002
    actions: Annotated[str | None, typer.Option(help="Only by these virtual actions, with commas between.")] = None,
    question: Annotated[str | None, typer.Option("--where", help="A question about several agents.")] = None,
    explain: Annotated[bool, typer.Option("--why", help="One sentence per answer: why, why not with less.")] = False,
    at: AtOption = None,
    as_json: JsonOption = False,
) -> int:
    """Ask who sees, reaches and grasps what, and by which actions.

    Answers a table of efforts; with --object the least actions; with --actions what becomes possible by them; with
    --where which objects fulfil conditions on several agents, such as "P1 reaches <= 2 and not P3 sees".
    The exit code is 1 if no object does.

    Example: taskgist query room.toml --object cup --why

    Example: taskgist query room.toml --agent P1 --actions Pan_Head,Tilt_Head

    Example: taskgist query demo.mcap --at 3 --where "P1 reaches and not P2 sees"
    """
    asked = {"--agent": agent, "--ability": ability, "--object": object, "--actions": actions}
    stage = open_stage(where, at)
    answers = _Answers(SceneEfforts(stage), explain=explain, as_json=as_json)
    with about(where, {"where": "--where"}):
        _check_scene(stage.scene)
        if question is not None:
            _alone(asked)
            return answers.where(question)
        agents = stage.scene.agents if agent is None else (stage.scene.agent(agent).name,)
        abilities = ABILITIES if ability is None else (_ability(ability),)
        if object is not None:
            stage.scene.object_body(object)
        if actions is not None:
            return answers.with_actions(_one(agent), abilities, object, _split(actions))
        return answers.efforts(agents, abilities, object)


@dataclass(frozen=True)
class _Answers:
    """Prints answers, as text or as one JSON document; each gives the exit code."""

    scene_efforts: SceneEfforts
    explain: bool
    as_json: bool

    def efforts(self, agents: tuple[str, ...], abilities: tuple[Ability, ...], name: str | None) -> int:
        """The least effort (Eq. 8): of one object action by action, of all as a table."""
        names = self._names(name)
        found = [self.scene_efforts.effort(who, each, what) for who in agents for each in names for what in abilities]
        if self.as_json:
            print_json({"efforts": [self._document(effort) for effort in found]})
        elif name is None and not self.explain:
            self._print_table(found, abilities)
        else:
            for effort in found:
                self._print(effort)
        return OK

    def with_actions(
        self, agent: str, abilities: tuple[Ability, ...], name: str | None, actions: tuple[str, ...]
    ) -> int:
        """What some virtual actions bring about (Eq. 7)."""
        names = self._names(name)
        some, documents = False, {}
        for ability in abilities:
            efforts = {each: self.scene_efforts.effort(agent, each, ability, actions) for each in names}
            chosen, new = able_by(efforts), becoming_able_by(efforts)
            some = some or bool(chosen.yes)
            documents[ability] = {
                "becomes": list(new),
                **{key: list(value) for key, value in dataclasses.asdict(chosen).items()},
                "efforts": [self._document(effort) for effort in efforts.values()],
            }
            if not self.as_json:
                console.print(Text(f"{agent} with {' + '.join(actions) or 'no action'}: {ability}", style="bold"))
                for effort in efforts.values():
                    self._print(effort, actions)
        if self.as_json:
            print_json({"agent": agent, "actions": list(actions), "abilities": documents})
        return OK if some else FAILED

    def where(self, text: str) -> int:
        """A set question."""
        scene = self.scene_efforts.stage.scene
        question = parse_question(text, scene.agents, RELATION_VERBS)
        chosen = objects_where(self.scene_efforts, question)
        efforts = {
            name: [self.scene_efforts.effort(agent, name, ability) for agent, ability in question.abilities]
            for name in scene.objects
        }
        if self.as_json:
            told = {name: [self._document(effort) for effort in found] for name, found in efforts.items()}
            print_json({"where": text, **dataclasses.asdict(chosen), "efforts": told})
        else:
            for heading, names in (("yes", chosen.yes), ("unknown", chosen.unknown), ("no", chosen.no)):
                self._print_group(heading, {name: efforts[name] for name in names})
        return OK if chosen.yes else FAILED

    def _names(self, name: str | None) -> tuple[str, ...]:
        return self.scene_efforts.stage.scene.objects if name is None else (name,)

    def _document(self, effort: Effort) -> dict[str, Any]:
        told = {"why": why(effort)} if self.explain else {}
        return {**effort.document, "object": effort.target, **told}

    def _print(self, effort: Effort, actions: tuple[str, ...] | None = None) -> None:
        by = f"  {' + '.join(effort.actions)}" if effort.level else ""
        subject = effort.target if actions is not None else f"{effort.agent} {effort.ability:5} {effort.target}"
        console.print(f"  {subject:24} {_level(effort)}{by}")
        if self.explain:
            console.print(f"      {why(effort)}.")

    def _print_table(self, efforts: list[Effort], abilities: tuple[Ability, ...]) -> None:
        levels = {(each.agent, each.target, each.ability): _level(each) for each in efforts}
        for agent in dict.fromkeys(each.agent for each in efforts):
            console.print(Text(f"{agent:20}" + "".join(f"{ability:{WIDTH}}" for ability in abilities), style="bold"))
            for name in dict.fromkeys(each.target for each in efforts):
                cells = "".join(f"{levels[agent, name, ability]:{WIDTH}}" for ability in abilities)
                console.print(f"  {name:18}{cells}".rstrip())

    def _print_group(self, heading: str, efforts: dict[str, list[Effort]]) -> None:
        if not efforts:
            console.print(Text.assemble((f"{heading}: ", "bold"), "none"))
            return
        console.print(Text(f"{heading}:", style="bold"))
        for name, found in efforts.items():
            console.print(f"  {name:18}" + ", ".join(f"{e.agent} {e.ability}: {_level(e)}" for e in found))
            for effort in found if self.explain else ():
                console.print(f"      {why(effort)}.")


def _level(effort: Effort) -> str:
    return "unknown" if effort.level is None else f"{effort.level} {effort.name}"


def _ability(text: str) -> Ability:
    for ability in ABILITIES:
        if text == ability:
            return ability
    raise UnknownNameError("ability", text, ABILITIES, where="--ability")


def _split(actions: str) -> tuple[str, ...]:
    return tuple(action.strip() for action in actions.split(",") if action.strip())


def _one(agent: str | None) -> str:
    if agent is None:
        raise InputError("bodies differ in their actions", field="--actions", hint="name --agent, too")
    return agent


def _check_scene(scene: Scene) -> None:
    """Refuse a scene of which nothing can be asked."""
    if not scene.agents:
        raise InputError("no agent in this scene", field="agents", hint="add a table such as [agents.P1]")
    if not scene.objects:
        hint = "objects are bodies that move freely (in URDF, links on a `floating` joint), and those that this names"
        raise InputError("no object in this scene", field="scene.objects", hint=hint)


def _alone(options: dict[str, str | None]) -> None:
    """A set question names its agents and abilities itself."""
    for option, value in options.items():
        if value is not None:
            raise InputError("does not go with --where", field=option, value=value, hint="say it in the question")
