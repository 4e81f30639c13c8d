"""Take the marks off ordinary scenes whose answers are right by now: ``python -m tools.scene_marks``.

The table is ``tests/perspective/test_ordinary_rooms.py``. What is wrong without a mark is listed; the exit status says
whether there is any.
"""

from __future__ import annotations

import sys
from pathlib import Path

from taskgist.perspective.effort import ABILITIES
from tests.ordinary import Line
from tests.perspective import test_ordinary_rooms as table


def main() -> int:
    """Rewrite the table, and list what is wrong."""
    path, unmarked = Path(table.__file__), 0
    source = path.read_text(encoding="utf-8")
    for number, line in enumerate(table.LINES):
        texts = []
        for ability in ABILITIES:
            effort = table.efforts(number).effort("P", "thing", ability)
            expected, text = line.expected(ability), line.text(ability)
            is_right = effort.level in expected.levels
            texts.append(text.partition("!")[0].strip() if is_right else text)
            if is_right and expected.wrong:
                print(f"right by now: {line.what}, {ability}: {effort.level}")
            if not is_right and not expected.wrong:
                unmarked += 1
                print(f"wrong: {line.what}, {ability}: {effort.level}, right is {text}: {effort.reason}")
        source = rewritten(source, line, texts)
    path.write_text(source, encoding="utf-8")
    return int(unmarked > 0)


def rewritten(source: str, line: Line, texts: list[str]) -> str:
    """The table's source with other expected levels in a line."""
    start = source.index(f'    Line("{line.what}",')
    end = source.index("\n", start)
    before, after = (", ".join(f'"{each}"' for each in group) for group in (map(line.text, ABILITIES), texts))
    head, found, tail = source[start:end].rpartition(before)
    assert found, line.what
    return source[:start] + head + after + tail + source[end:]


if __name__ == "__main__":
    sys.exit(main())
