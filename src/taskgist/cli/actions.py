"""Actions of a recording as ``taskgist facts --actions`` tells them."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from rich.text import Text

from taskgist.cli.common import console, progress_bar
from taskgist.observe.observer import Observer
from taskgist.recognition.actions import Action, actions_of
from taskgist.recording.recording import Recording


def tell_actions(recording: Recording, agent: str | None, name: str | None, *, quiet: bool) -> dict[str, Any]:
    """Print what was done, a line for each action.

    Args:
        recording: The recording.
        agent: Only what this agent did.
        name: Only what was done with this object.
        quiet: Print nothing.

    Returns:
        The document that says the same.

    Raises:
        UnknownNameError: There is no such agent or object.
    """
    if agent is not None:
        recording.scene.agent(agent)
    observer = Observer(recording.scene, recording)
    with progress_bar(quiet=quiet) as progress:
        found = actions_of(recording, observer, names=None if name is None else (name,), progress=progress)
    own = [each for each in found if agent in (None, each.agent)]
    if not quiet:
        for each in own:
            console.print(Text(f"  {_when(each):>17}  {each}"))
        if not own:
            console.print("nothing that could be told: was nothing done, or were hands and things not tracked?")
    return {"actions": [_document(each) for each in own]}


def _when(action: Action) -> str:
    if action.start_s == action.end_s:
        return f"{action.start_s:6.2f} s"
    return f"{action.start_s:6.2f} - {action.end_s:6.2f} s"


def _document(action: Action) -> dict[str, Any]:
    times = {"start_s": round(action.start_s, 4), "end_s": round(action.end_s, 4)}
    return {**asdict(action), **times}
