"""Files: whole or not at all, nothing lost, nothing waited for."""

from __future__ import annotations

import os
import signal
import socket
import stat
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from taskgist.common.files import (
    changing,
    check_no_input,
    check_replaceable,
    keeping_inputs,
    read_whole,
    reading,
    writing,
)
from taskgist.errors import InputError, RecordingError


def put(target: Path, content: bytes, *, replace: bool = False) -> None:
    with writing(target, replace=replace) as stream:
        stream.write(content)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture
def umask() -> object:
    before = os.umask(0o027)
    yield
    os.umask(before)


@pytest.mark.usefixtures("umask")
def test_a_new_file_has_what_the_umask_leaves(tmp_path: Path) -> None:
    put(tmp_path / "new", b"1")
    assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == 0o640


@pytest.mark.usefixtures("umask")
@pytest.mark.parametrize("mode", [0o600, 0o664, 0o444])
def test_a_file_that_replaces_another_has_its_mode(tmp_path: Path, mode: int) -> None:
    target = tmp_path / "kept"
    target.write_bytes(b"old")
    target.chmod(mode)
    put(target, b"new", replace=True)
    assert (target.read_bytes(), stat.S_IMODE(target.stat().st_mode)) == (b"new", mode)


def test_what_is_there_is_not_replaced_unasked(tmp_path: Path) -> None:
    target = tmp_path / "there"
    target.write_bytes(b"old")
    with pytest.raises(InputError, match="there already"):
        put(target, b"new")
    assert target.read_bytes() == b"old"
    assert names(tmp_path) == ["there"]


def test_what_appears_meanwhile_is_not_replaced_unasked(tmp_path: Path) -> None:
    target = tmp_path / "late"

    def slowly() -> None:
        with writing(target, replace=False) as stream:
            stream.write(b"ours")
            target.write_bytes(b"theirs")

    with pytest.raises(InputError, match="there already"):
        slowly()
    assert target.read_bytes() == b"theirs"
    assert names(tmp_path) == ["late"]


def test_links_are_followed(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "data").write_bytes(b"old")
    (tmp_path / "link").symlink_to("real/data")
    put(tmp_path / "link", b"new", replace=True)
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real" / "data").read_bytes() == b"new"
    (tmp_path / "dangling").symlink_to("real/made")
    put(tmp_path / "dangling", b"new")
    assert (tmp_path / "real" / "made").read_bytes() == b"new"


def test_what_is_no_file_is_refused_by_name(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind(str(tmp_path / "socket"))
    kinds = {
        tmp_path / "pipe": "a pipe",
        tmp_path / "folder": "a folder",
        tmp_path / "socket": "a socket|No such device",
        Path("/dev/null"): "a device",
        tmp_path / "loop": "loop|symbolic links",
        tmp_path / "nul\0": "null",
    }
    for path, kind in kinds.items():
        with pytest.raises(InputError, match=kind):
            put(path, b"", replace=True)
        with pytest.raises(InputError, match=kind):
            check_replaceable(path, replace=True)
        with pytest.raises(InputError, match=kind), reading(path):
            pass
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)


def test_an_error_on_the_way_leaves_nothing(tmp_path: Path) -> None:
    def broken() -> None:
        with writing(tmp_path / "half", replace=False) as stream:
            stream.write(b"1")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        broken()
    assert names(tmp_path) == []


def test_a_full_disk_is_told_and_leaves_what_was(tmp_path: Path) -> None:
    """A limit on the size of files stands for a disk that is full."""
    (tmp_path / "data").write_bytes(b"old")
    script = f"""
import resource, signal
from pathlib import Path
from taskgist.common.files import writing
from taskgist.errors import RecordingError
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
try:
    with writing(Path({str(tmp_path / "data")!r}), replace=True, error=RecordingError) as stream:
        stream.write(bytes(1_000_000))
except RecordingError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert f"{tmp_path / 'data'}: cannot be written: File too large" in done.stdout
    assert names(tmp_path) == ["data"]
    assert (tmp_path / "data").read_bytes() == b"old"


def test_the_next_takes_away_what_a_killed_process_left_and_no_more(tmp_path: Path) -> None:
    script = f"""
import sys, time
from pathlib import Path
from taskgist.common.files import writing
with writing(Path({str(tmp_path / "data")!r}), replace=True) as stream:
    stream.write(b"half")
    print("writing", flush=True)
    time.sleep(60)
"""
    writers = [subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE) for _ in range(2)]
    for writer in writers:
        assert writer.stdout is not None
        assert writer.stdout.readline() == b"writing\n"
    writers[0].send_signal(signal.SIGKILL)
    writers[0].wait()
    assert len(names(tmp_path)) == 2
    put(tmp_path / "data", b"whole")
    assert len(names(tmp_path)) == 2, "the draft of the one that still writes is left alone"
    writers[1].send_signal(signal.SIGKILL)
    writers[1].wait()
    put(tmp_path / "data", b"whole", replace=True)
    assert names(tmp_path) == ["data"]
    for writer in writers:
        writer.stdout.close()  # type: ignore[union-attr]


def test_an_input_is_no_target_by_whatever_name(tmp_path: Path) -> None:
    (tmp_path / "in").write_bytes(b"1")
    (tmp_path / "link").symlink_to("in")
    (tmp_path / "hard").hardlink_to(tmp_path / "in")
    for name in ("in", "link", "hard"):
        with pytest.raises(RecordingError, match="read by the same command"):
            check_no_input(tmp_path / name, [tmp_path / "in"], RecordingError)
    check_no_input(tmp_path / "new", [tmp_path / "in"])


def test_what_a_command_read_it_does_not_overwrite(tmp_path: Path) -> None:
    (tmp_path / "in").write_bytes(b"1")
    (tmp_path / "link").symlink_to("in")
    (tmp_path / "extended").write_bytes(b"1")
    with keeping_inputs():
        assert read_whole(tmp_path / "in", most_bytes=10) == b"1"
        with pytest.raises(InputError, match="read by the same command"):
            put(tmp_path / "link", b"2", replace=True)
        with reading(tmp_path / "extended", is_input=False) as stream:
            assert stream.read() == b"1"
        put(tmp_path / "extended", b"2", replace=True)
        with changing(tmp_path / "extended"):
            put(tmp_path / "extended", b"3", replace=True)
    assert (tmp_path / "in").read_bytes() == b"1"
    put(tmp_path / "in", b"2", replace=True)


def test_what_is_too_large_is_not_read(tmp_path: Path) -> None:
    with (tmp_path / "large").open("wb") as stream:
        stream.truncate(2**40)
    with pytest.raises(InputError, match=r"1,099,511,627,776 bytes.*at most 10 bytes"):
        read_whole(tmp_path / "large", most_bytes=10)


def test_who_changes_a_file_waits_for_others(tmp_path: Path) -> None:
    """Each adds a letter to what it reads; none is lost."""
    target = tmp_path / "log"
    target.write_bytes(b"")

    def add() -> None:
        with changing(target) as stream:
            content = stream.read()
            time.sleep(0.005)
            put(target, content + b"x", replace=True)

    threads = [threading.Thread(target=add) for _ in range(12)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert target.read_bytes() == b"x" * 12


def test_drafts_of_nobody_and_what_others_named_alike_are_left_alone(tmp_path: Path) -> None:
    (tmp_path / ".data.notes.draft").write_bytes(b"mine")
    os.mkfifo(tmp_path / ".data.0123456789ab.draft")
    put(tmp_path / "data", b"1")
    assert names(tmp_path) == [".data.0123456789ab.draft", ".data.notes.draft", "data"]


def test_a_name_may_be_as_long_as_file_systems_allow(tmp_path: Path) -> None:
    long = tmp_path / ("\u624b" * 80 + ".mcap")
    put(long, b"1")
    assert names(tmp_path) == [long.name]
