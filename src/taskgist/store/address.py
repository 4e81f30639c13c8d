"""Where knowledge lies: the path of a file, or the URL of a database; shown without its secrets."""

from __future__ import annotations

import re
import stat
from pathlib import Path
from urllib.parse import unquote

from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError

from taskgist.common.files import KINDS, shown_path
from taskgist.errors import KnowledgeError

Address = str | Path
"""Path of a file, or a URL such as ``postgresql://user@host/name``."""

_SECRETS = (
    re.compile(r"^[\w+.-]+:/*[^:]*:(?P<secret>.*)@", re.DOTALL),  # to the last @, as passwords may hold some
    re.compile(r"^(?:[\w+.-]+:)?//[^:]*:(?P<secret>.*)@", re.DOTALL),  # without a scheme
    re.compile(r"^[\w+.-]*:?//[^:/?@]*:(?P<secret>(?!\d+(?:[/?]|$))[^/?@]+)(?=[/?]|$)"),  # without a host
    re.compile(r"\w*(?:pass|pwd|secret|token)\w*\s*(?:=|%3D)\s*(?P<secret>[^&;\s]*)", re.IGNORECASE),
    re.compile(r"[?&](?!(?:host|port|user|sslmode)=)[^=&]*=(?P<secret>[^&]*)", re.IGNORECASE),
)
_HIDDEN = "***"


def file_of(address: Address) -> Path | None:
    """The file that an address means, or None for a database server.

    Raises:
        KnowledgeError: It is no URL, or one of a database that would not last.
    """
    if not _is_url(address):
        return Path(address)
    url = url_of(str(address))
    if url.get_backend_name() != "sqlite":
        return None
    if url.database in (None, "", ":memory:"):
        hint = "give the path of a file: sqlite:///knowledge.db"
        raise KnowledgeError("would not last", where=shown(address), hint=hint)
    return Path(str(url.database))


def url_of(address: str) -> URL:
    """The parts of a URL.

    Raises:
        KnowledgeError: It is none.
    """
    try:
        url = make_url(address)
    except (ArgumentError, ValueError) as error:
        hint = "give a path, or postgresql://USER@HOST/NAME"
        raise KnowledgeError("not a URL", where=shown(address), hint=hint) from error
    if "@" in (url.host or ""):
        hint = "write @ as %40, / as %2F and : as %3A in it"
        raise KnowledgeError("a password that cannot be told from the host", where=shown(address), hint=hint)
    return url


def shown(address: Address) -> str:
    """The address as text that can be printed: without passwords, wherever they stand."""
    text = str(address)
    for pattern in _SECRETS:
        text = pattern.sub(_without_secret, text)
    return text.replace("\0", "\\0")


def _without_secret(found: re.Match[str]) -> str:
    start, end = found.start("secret") - found.start(), found.end("secret") - found.start()
    return f"{found[0][:start]}{_HIDDEN}{found[0][end:]}"


def without_secrets(text: str, address: Address) -> str:
    """What a driver says about an address, without the passwords that the address holds."""
    given = {match["secret"] for match in _secrets(str(address))}
    for secret in given | {unquote(each) for each in given}:
        text = re.sub(rf"(?<!\w){re.escape(secret)}(?!\w)", _HIDDEN, text) if secret else text
    return text


def _secrets(address: str) -> list[re.Match[str]]:
    return [match for pattern in _SECRETS for match in pattern.finditer(address)]


def is_there(path: Path) -> bool:
    """Whether a path names a file.

    The file is not opened for that: closing it would take the locks of other connections of this process away.

    Raises:
        KnowledgeError: It names something else, or cannot be looked at.
    """
    try:
        mode = path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return False
    except (OSError, ValueError) as error:
        reason = (error.strerror if isinstance(error, OSError) else None) or str(error)
        raise KnowledgeError(f"cannot be read: {reason}", where=shown_path(path), hint="check the path") from error
    kind = KINDS.get(stat.S_IFMT(mode))
    if kind:
        raise KnowledgeError(f"cannot be knowledge: it is {kind}", where=shown_path(path), hint="name a file")
    return True


def _is_url(address: Address) -> bool:
    return isinstance(address, str) and "://" in address
