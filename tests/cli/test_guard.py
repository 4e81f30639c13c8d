"""What every command promises: no traceback, no warning of a library, nothing overwritten, nothing hidden in text."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from taskgist.common.text import COMMANDS, escaped, escaped_in_json
from tests.cli.running import refusal, run
from tests.shipped import PATHS

SHOW = PATHS["show_a"]
FAULTY = """
import sys, logging, warnings
from taskgist.cli import main
from taskgist.cli import check
def broken(*_, **__):
    warnings.warn("deprecated")
    logging.getLogger("library").warning("odd")
    raise ZeroDivisionError("a \\x1b[31mfault\\nin two lines")
check.read = broken
main()
"""


def taskgist(script: str, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    line = [sys.executable, "-c", script, *arguments]
    return subprocess.run(line, capture_output=True, text=True, check=False, env={**os.environ, **environment})


def test_a_fault_of_ours_is_one_line_and_has_a_code_of_its_own() -> None:
    done = taskgist(FAULTY, "check", str(SHOW))
    assert done.returncode == 3
    assert done.stderr == (
        "unexpected: ZeroDivisionError: a \\x1b[31mfault in two lines; "
        "this is our fault, please report it with --debug's output\n"
    )


@pytest.mark.parametrize("line", [["--debug", "check", str(SHOW)], ["check", str(SHOW), "--debug"]])
def test_debug_shows_where_a_fault_arises(line: list[str]) -> None:
    done = taskgist(FAULTY, *line)
    assert done.returncode == 3
    assert "Traceback" in done.stderr
    assert "in broken" in done.stderr
    assert "deprecated" in done.stderr
    assert "\x1b" not in done.stderr


def test_debug_shows_where_bad_input_was_noticed() -> None:
    done = taskgist("from taskgist.cli import main; main()", "check", "nowhere.mcap", "--debug")
    assert done.returncode == 2
    assert "Traceback" in done.stderr
    assert "error: nowhere.mcap: " in done.stderr


HEARING = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
"""A shell in the background starts its programs deaf to interrupts."""


def test_an_interrupt_that_a_callback_drops_ends_the_command_all_the_same() -> None:
    script = f"""
{HEARING}
import signal, time, weakref
from taskgist.cli import main, label
class Thing: pass
def slow(*_, **__):
    weakly = weakref.ref(thing := Thing(), lambda _: signal.raise_signal(signal.SIGINT))
    del thing
    print("dropped")
    time.sleep(20)
    print("went on")
label.read = slow
main()
"""
    done = taskgist(script, "label", str(SHOW))
    assert (done.returncode, done.stdout, done.stderr) == (130, "dropped\n", "interrupted\n")


def test_an_interrupted_command_says_so_and_leaves_nothing(tmp_path: Path) -> None:
    script = f"""
{HEARING}
import time
from taskgist.cli import main, label
from taskgist.common.files import writing
def slow(*_, **__):
    with writing({str(tmp_path / "new")!r} and __import__("pathlib").Path({str(tmp_path / "new")!r}), replace=False):
        print("writing", flush=True)
        time.sleep(60)
label.read = slow
main()
"""
    process = subprocess.Popen(
        [sys.executable, "-c", script, "label", str(SHOW)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "writing\n"
    time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    assert process.communicate()[1] == "interrupted\n"
    assert process.returncode == 130
    assert list(tmp_path.iterdir()) == []


COARSE_MAPS = """
from taskgist.cli import main
from taskgist.maps.grid import Grid
from taskgist.settings import Maps
around = Grid.around
Grid.around = staticmethod(lambda *names, **_: around(*names, settings=Maps(cell_m=0.4)))
main()
"""


def test_a_home_that_cannot_be_written_to_is_no_matter(tmp_path: Path) -> None:
    picture = tmp_path / "a.png"
    line = ["map", str(SHOW), "--agent", "P2", "--level", "1", "-o", str(picture)]
    nowhere = dict.fromkeys(("HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "MPLCONFIGDIR"), "/dev/null/home")
    done = taskgist(COARSE_MAPS, *line, **nowhere)
    assert (done.returncode, done.stderr) == (0, "")
    assert picture.stat().st_size


def test_orders_to_the_terminal_are_shown_as_text(tmp_path: Path) -> None:
    name = "a\x1b]0;title\x07\x9b31m\u202eb.mcap"
    said = refusal(f"check '{tmp_path / name}'", tmp_path)
    assert "a\\x1b]0;title" in said
    assert "\\x9b31m\\u202eb.mcap" in said
    assert not COMMANDS.search(said)


def test_escaped_text_means_the_same_in_json() -> None:
    import json

    text = "a\x1b\x7f\x9b\u202e\u2028 é\U0001f600"
    shown = escaped_in_json(json.dumps({"name": text}, ensure_ascii=False))
    assert not COMMANDS.search(shown)
    assert json.loads(shown) == {"name": text}
    assert escaped("line\n\ttab é") == "line\n\ttab é"


@pytest.mark.usefixtures("coarse_maps")
@pytest.mark.parametrize(
    ("line", "target"),
    [
        ("see {show} --agent P2 -o {target}", "a.png"),
        ("map {show} --agent P2 --level 1 -o {target}", "a.png"),
        ("map {show} --agent P2 --level 1 --npz {target}", "a.npz"),
        ("agent check human -o {target}", "a.png"),
        ("simulate show --count 1 --picture {target} -o {folder}/made", "a.png"),
    ],
)
def test_a_file_that_is_there_is_replaced_only_if_that_is_said(line: str, target: str, tmp_path: Path) -> None:
    there = tmp_path / target
    there.write_bytes(b"mine")
    given = line.format(show=SHOW, target=there, folder=tmp_path)
    assert f"{there}: --" in refusal(given, tmp_path)
    assert there.read_bytes() == b"mine"
    if not line.startswith("simulate"):
        run(f"{given} --replace")
        assert there.read_bytes() != b"mine"


@pytest.mark.parametrize("line", ["demo -o {folder}", "paper -o {folder}", "evaluate -o {folder}"])
def test_a_folder_that_holds_pictures_is_left_alone(line: str, tmp_path: Path) -> None:
    (tmp_path / "mine.png").write_bytes(b"mine")
    assert "holds mine.png already; name another folder, or add --replace" in refusal(
        line.format(folder=tmp_path), tmp_path
    )


def test_inputs_are_never_overwritten(tmp_path: Path) -> None:
    show = tmp_path / "show.png"
    show.write_bytes(SHOW.read_bytes())
    assert "read by the same command" in refusal(f"see {show} --agent P2 -o {show} --replace", tmp_path)
