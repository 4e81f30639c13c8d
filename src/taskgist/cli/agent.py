"""``taskgist agent``: profiles of bodies, human and robot."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from taskgist.cli.body_report import found_in, print_found
from taskgist.cli.files import check_target
from taskgist.cli.output import FAILED, OK, JsonOption, command, print_json
from taskgist.errors import InputError
from taskgist.world import Stage
from taskgist.world.body.check import BODY, check_body

agent_app = typer.Typer(help="Bodies: check an agent profile, human or robot.", no_args_is_help=True)


@agent_app.callback()
def agent() -> None:
    """Bodies: check an agent profile, human or robot."""


@agent_app.command("check")
@command
def check(
    profile: Annotated[str, typer.Argument(help="A built-in profile, or a file (.toml).", show_default=False)],
    out: Annotated[Path | None, typer.Option("--out", "-o", help="A PNG file for a picture of the body.")] = None,
    as_json: JsonOption = False,
) -> int:
    """Say whether an agent profile is fit to use, and what it has.

    Every problem is named, and what is doubtful: an eye that looks aside, a joint about the wrong axis. The picture
    shows the body from the side and from above, with its eye, shoulders, hands, reach and field of view. The exit code
    is 1 if the profile cannot be used.

    Example: taskgist agent check pr2 -o pr2.png

    Example: taskgist agent check my_robot.toml
    """
    if out is not None:
        check_target(out, "--out")
        if out.suffix.lower() != ".png":
            raise InputError("pictures are PNG", where=out, field="--out", hint="name it .png")
    result = check_body(profile)
    found = found_in(result)
    if out is not None and result.scene is not None:
        from taskgist.view.agent_card import agent_card  # with matplotlib, which only pictures should wait for

        found["picture"] = str(agent_card(Stage(result.scene), BODY, out, title=str(found["name"])))
    if as_json:
        print_json(found)
    else:
        print_found(result, found)
    return FAILED if result.problems else OK
