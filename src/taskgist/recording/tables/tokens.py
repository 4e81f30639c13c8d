"""The placeholders ``{person}`` and ``{point}``, filled for one point."""

from __future__ import annotations

from dataclasses import dataclass

from taskgist.errors import MappingError, UnknownNameError
from taskgist.recording.mapping.source_model import Columns, Name, Source


@dataclass(frozen=True)
class Tokens:
    """What the placeholders of a source stand for.

    Attributes:
        source: The source.
        person: What ``{person}`` stands for.
        point: What ``{point}`` stands for.
        where: Mapping and source, for messages.
    """

    source: Source
    person: Name
    point: Name
    where: str

    def filled(self, template: str) -> str:
        """A text with its placeholders filled."""
        return template.replace("{person}", str(self.person)).replace("{point}", self._point_name())

    def columns(self, columns: Columns) -> tuple[Name, ...]:
        """The columns of this point."""
        shift = columns.step * self.index_of("{point}") if columns.step else 0
        return tuple(self.filled(item) if isinstance(item, str) else item + shift for item in columns.items)

    def index_of(self, placeholder: str) -> int:
        """The index that "{person}" or "{point}" stands for.

        Raises:
            MappingError: A person is given by name; names have no index.
            UnknownNameError: The source does not list such a point.
        """
        token = self.person if placeholder == "{person}" else self.point
        if isinstance(token, int):
            return token
        if placeholder == "{person}":
            hint = "give person = 0, 1, ... of the array's axis"
            raise MappingError("must be an index here", where=self.where, field="person", value=token, hint=hint)
        if token not in self.source.names:
            raise UnknownNameError("point in names", token, self.source.names, where=self.where)
        return self.source.names.index(token)

    def _point_name(self) -> str:
        names = self.source.names
        known = isinstance(self.point, int) and self.point < len(names)
        return names[int(self.point)] if known else str(self.point)
