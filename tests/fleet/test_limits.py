"""If the system refuses a resource, the run ends with that cause and blames no process."""

from __future__ import annotations

import os
import resource
import tempfile
from pathlib import Path

import pytest
from zstandard import ZstdError

from tests.conftest import zenvoy
from zenvoy.fleet import limits, sockets
from zenvoy.fleet.ends import shortage_of

SHORT = """
duration_s: 2
fleet: {size: 3}
"""


def run_with(folder: Path, tmpdir: Path) -> tuple[str, list[str]]:
    """Run with TMPDIR set to a folder. Return stderr, and what the run leaves in the folder."""
    (folder / "s.yaml").write_text(SHORT)
    outcome = zenvoy(folder, "run", "s.yaml", "--out", "out", env={"TMPDIR": str(tmpdir)})
    assert outcome.code == 0, outcome
    return outcome.err, os.listdir(tmpdir)


@pytest.mark.parametrize("name", ["a#b", "a?b", "long-" * 30])
def test_sockets_are_never_outside_their_folder(tmp_path: Path, name: str) -> None:
    """Zenoh ends a path at `#` and `?`, and Linux ends one of a socket after 107 bytes."""
    odd = tmp_path / name
    odd.mkdir()
    before = set(os.listdir(tmp_path))
    assert run_with(tmp_path, odd) == ("", [])
    assert set(os.listdir(tmp_path)) == before | {"s.yaml", "out"}


def test_without_a_usable_folder_nothing_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sockets, "_FALLBACKS", ())
    monkeypatch.setattr(tempfile, "gettempdir", lambda: "/nowhere#")
    monkeypatch.delenv("XDG_RUNTIME_DIR", raising=False)
    with pytest.raises(OSError, match=r"no folder for Unix sockets, .*; tried /nowhere#"):
        sockets.socket_folder()


def test_a_folder_that_others_may_read_is_refused(tmp_path: Path) -> None:
    sockets.make_private(tmp_path / "own")
    sockets.make_private(tmp_path / "own")  # the channel, after the world
    assert (tmp_path / "own").stat().st_mode & 0o777 == 0o700
    (tmp_path / "open").mkdir(mode=0o755)
    with pytest.raises(FileExistsError):
        sockets.make_private(tmp_path / "open")
    (tmp_path / "link").symlink_to(tmp_path / "own")
    with pytest.raises(FileExistsError):
        sockets.make_private(tmp_path / "link")


def test_too_few_file_descriptors_are_reported_before_anything_starts(tmp_path: Path) -> None:
    limit = (resource.RLIMIT_NOFILE, 40)
    outcome = zenvoy(tmp_path, "run", "quickstart", "--out", "o", limit=limit)
    assert outcome.code == 1
    assert outcome.err == (
        "the run cannot go on: file descriptors are limited to 40 (ulimit -n); "
        "22 processes need 46 each\n"
    )
    assert list((tmp_path / "o" / "logs").iterdir()) == []


def test_a_soft_limit_is_raised(tmp_path: Path) -> None:
    """No system has a default of 40 descriptors, but some have soft limits below the need."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (40, hard))
        limits.require_room_for(42)
        assert resource.getrlimit(resource.RLIMIT_NOFILE) == (66, hard)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def test_too_few_processes_are_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    """The limit does not apply to root, who may run this test."""
    monkeypatch.setattr(os, "geteuid", lambda: 12345)
    at_most = {resource.RLIMIT_NPROC: (100, 100)}
    unlimited = (resource.RLIM_INFINITY, resource.RLIM_INFINITY)
    monkeypatch.setattr(resource, "getrlimit", lambda which: at_most.get(which, unlimited))
    with pytest.raises(limits.LimitError, match=r"limited to 100 \(ulimit -u\), and 0 exist"):
        limits.require_room_for(10)


def test_too_little_memory_is_reported_at_once(tmp_path: Path) -> None:
    """The import of scipy never ends with 200 MB."""
    limit = (resource.RLIMIT_AS, 200_000 * 1024)
    outcome = zenvoy(tmp_path, "run", "quickstart", "--out", "o", limit=limit)
    assert (outcome.code, outcome.err) == (
        1,
        "memory is limited to 200000 KiB (ulimit -v); at least 393216 KiB are needed\n",
    )


def test_processes_need_more_memory_than_arrays(tmp_path: Path) -> None:
    """With less, a thread of Zenoh may die in silence, and the others wait for it."""
    (tmp_path / "s.yaml").write_text(SHORT)
    limit = (resource.RLIMIT_AS, 500_000 * 1024)
    refused = zenvoy(tmp_path, "run", "s.yaml", "--out", "o", limit=limit)
    assert (refused.code, refused.err) == (
        1,
        "the run cannot go on: memory is limited to 500000 KiB (ulimit -v); at least "
        "2097152 KiB are needed for processes on Zenoh, less for the engine arrays\n",
    )
    assert list((tmp_path / "o" / "logs").iterdir()) == []
    options = ("--engine", "arrays", "--out", "arrays")
    assert zenvoy(tmp_path, "run", "s.yaml", *options, limit=limit).code == 0


@pytest.mark.parametrize(
    ("error", "expected"),
    [
        (OSError(24, "Too many open files"), "Too many open files (ulimit -n)"),
        (OSError(28, "No space left", "/a/b"), "No space left: /a/b"),
        (OSError("no number"), "no number"),
        (MemoryError(), "out of memory"),
        (
            ZstdError("cannot compress: Allocation error : not enough memory"),
            "out of memory",
        ),
        (RuntimeError("LZ4F_compressBegin failed: ERROR_allocation_failed"), "out of memory"),
        (ImportError("libx.so: failed to map segment from shared object"), "out of memory"),
        (ImportError("No module named 'x'"), None),
        (ZstdError("Unknown frame descriptor"), None),
        (ValueError("a mistake"), None),
        (RuntimeError("a mistake"), None),
    ],
)
def test_a_shortage_is_distinguished_from_a_mistake(error: Exception, expected: str | None) -> None:
    assert shortage_of(error) == expected
