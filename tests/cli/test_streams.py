"""Output that cannot be written or shown: the work is done all the same, and a line says so."""

from __future__ import annotations

import io
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import pytest

from tests.conftest import LIMIT_S
from zenvoy.cli.streams import Outlet, flush, install

ZENVOY: Final = f"{sys.executable} -m zenvoy.cli"
SHORT: Final = "{duration_s: 1, fleet: {size: 3}}"
FULL: Final = "cannot write to standard output: No space left on device\n"
CLOSED: Final = "cannot write to standard output: Bad file descriptor\n"


def shell(cwd: Path, line: str, **env: str) -> tuple[int, str, bytes]:
    """Exit code of a command line of bash, its standard error, and its output."""
    done = subprocess.run(
        ["bash", "-c", line.replace("zenvoy ", f"{ZENVOY} ")],
        cwd=cwd,
        env={**os.environ, "COLUMNS": "200", **env},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=3 * LIMIT_S,
        check=False,
    )
    return done.returncode, done.stderr.decode(), done.stdout


@pytest.mark.parametrize(
    ("line", "code", "said"),
    [
        ("zenvoy show quickstart > /dev/full", 1, FULL),
        ("zenvoy technologies >&-", 1, CLOSED),
        ("zenvoy -h > /dev/full", 1, FULL),
        ("zenvoy scenarios >&- 2>&-", 1, ""),
        ("zenvoy check quickstart 2>&-", 0, ""),
        ("zenvoy check missing 2>/dev/full", 2, ""),
        ("zenvoy check missing 2>&-", 2, ""),
    ],
)
def test_output_that_cannot_be_written_is_told_in_a_line(
    tmp_path: Path, line: str, code: int, said: str
) -> None:
    assert shell(tmp_path, line)[:2] == (code, said)


@pytest.mark.parametrize(
    ("end", "code", "said"),
    [
        ("<&- >&- 2>&-", 1, ""),
        ("> /dev/full", 1, FULL),
        ("2>&-", 0, ""),
        ("| head -c 1; exit ${PIPESTATUS[0]}", 0, ""),
    ],
)
def test_a_run_without_its_streams_leaves_all_its_files(
    tmp_path: Path, end: str, code: int, said: str
) -> None:
    (tmp_path / "s.yaml").write_text(SHORT)
    assert shell(tmp_path, f"zenvoy run s.yaml --out o {end}")[:2] == (code, said)
    left = {path.name for path in (tmp_path / "o").iterdir()}
    assert left == {"run.mcap", "summary.json", "effective.json", "logs"}
    logs = {path.name: path.read_text() for path in (tmp_path / "o" / "logs").iterdir()}
    assert logs.keys() == {"world.log", "channel.log", *(f"vehicle-0{n}.log" for n in (1, 2, 3))}
    assert set(logs.values()) == {""}


def test_files_are_written_before_anything_is_told(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(SHORT)
    read_one_line = "(read -r; ls o/channel.html)"
    line = f"set -o pipefail; zenvoy channel s.yaml --out o | {read_one_line}"
    assert shell(tmp_path, line) == (0, "", b"o/channel.html\n")


def test_a_terminal_without_width_is_told_all_the_same(tmp_path: Path) -> None:
    code, said, told = shell(tmp_path, "zenvoy technologies", COLUMNS="0")
    assert (code, said) == (0, "")
    assert b"640 MHz" in b" ".join(told.split())


@pytest.fixture
def streams() -> Iterator[None]:
    """Those of Python again, after a test that has put others in their place."""
    before = sys.stdout, sys.stderr
    yield
    sys.stdout, sys.stderr = before


def text_to(number: int) -> io.TextIOWrapper:
    """A text stream over an outlet."""
    return io.TextIOWrapper(io.BufferedWriter(Outlet(number)), encoding="utf-8")


@pytest.mark.usefixtures("streams")
@pytest.mark.parametrize("name", ["stdout", "stderr"])
@pytest.mark.parametrize(("code", "expected"), [(0, 1), (3, 3)])
def test_a_failed_write_ends_what_went_well_with_1(name: str, code: int, expected: int) -> None:
    with Path("/dev/full").open("wb", buffering=0) as full, Path("/dev/null").open("wb") as null:
        sys.stdout = text_to((full if name == "stdout" else null).fileno())
        sys.stderr = text_to((full if name == "stderr" else null).fileno())
        print("a text", file=getattr(sys, name))
        assert flush(code) == expected
        assert flush(code) == expected


@pytest.mark.usefixtures("streams")
def test_a_reader_that_has_had_enough_is_no_failure() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    sys.stdout = text_to(writer)
    print("a text")
    assert flush(0) == 0
    assert flush(2) == 2
    os.close(writer)


def test_all_is_written_where_the_pipe_does_not_block() -> None:
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    text, got = "0123456789" * 100_000, bytearray()

    def read() -> None:
        while part := os.read(reader, 65_536):
            got.extend(part)

    thread = threading.Thread(target=read)
    thread.start()
    stream = text_to(writer)
    stream.write(text)
    stream.flush()
    os.close(writer)
    thread.join()
    os.close(reader)
    assert got.decode() == text


@pytest.mark.usefixtures("streams")
def test_what_an_encoding_has_not_is_told_in_ascii(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(io.BytesIO(), encoding="latin-1"))
    install()
    assert isinstance(sys.stdout, io.TextIOWrapper)
    assert (sys.stdout.encoding, sys.stderr.encoding) == ("latin-1", "utf-8")
    shown = "Größe ≥ 2 m/s², −3 σ: 模 \udcff".encode("latin-1", str(sys.stdout.errors))
    assert shown == b"Gr\xf6\xdfe >= 2 m/s\xb2, -3 sigma: \\u6a21 \\udcff"
    assert "×".encode("ascii", str(sys.stdout.errors)) == b"x"
