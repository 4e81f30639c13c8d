"""Optional packages: imported where they are used, through one door that says how to install what is missing."""

from __future__ import annotations

import importlib
from typing import Any

from taskgist.errors import InputError


def door(module: str, extra: str, *, field: str | None = None, value: object = None) -> Any:
    """An optional module.

    Args:
        module: Its name, such as "ompl.base".
        extra: The extra of taskgist that brings it.
        field: What asked for it, for the message.
        value: The choice that asked for it, for the message.

    Raises:
        InputError: It is not installed; the message says how to install it.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise absent(module, extra, field=field, value=value) from error


def absent(module: str, extra: str, *, field: str | None = None, value: object = None) -> InputError:
    """The error of an optional module that is not installed."""
    hint = f"install it: pip install 'taskgist[{extra}]'"
    return InputError(f"{module} is not installed", field=field, value=value, hint=hint)
