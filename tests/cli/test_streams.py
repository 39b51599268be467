"""If output cannot be written or shown, the work is still done, and one line reports it."""

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
    """Return the exit code, the standard error and the output of a bash command line."""
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
    ("line", "code", "message"),
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
def test_a_failed_write_of_output_is_reported_in_one_line(
    tmp_path: Path, line: str, code: int, message: str
) -> None:
    assert shell(tmp_path, line)[:2] == (code, message)


@pytest.mark.parametrize(
    ("end", "code", "message"),
    [
        ("<&- >&- 2>&-", 1, ""),
        ("> /dev/full", 1, FULL),
        ("2>&-", 0, ""),
        ("| head -c 1; exit ${PIPESTATUS[0]}", 0, ""),
    ],
)
def test_a_run_without_standard_streams_writes_all_its_files(
    tmp_path: Path, end: str, code: int, message: str
) -> None:
    (tmp_path / "s.yaml").write_text(SHORT)
    assert shell(tmp_path, f"zenvoy run s.yaml --out o {end}")[:2] == (code, message)
    left = {path.name for path in (tmp_path / "o").iterdir()}
    assert left == {"run.mcap", "summary.json", "effective.json", "logs"}
    logs = {path.name: path.read_text() for path in (tmp_path / "o" / "logs").iterdir()}
    assert logs.keys() == {"world.log", "channel.log", *(f"vehicle-0{n}.log" for n in (1, 2, 3))}
    assert set(logs.values()) == {""}


def test_files_are_written_before_output(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(SHORT)
    read_one_line = "(read -r; ls o/channel.html)"
    line = f"set -o pipefail; zenvoy channel s.yaml --out o | {read_one_line}"
    assert shell(tmp_path, line) == (0, "", b"o/channel.html\n")


def test_a_terminal_without_width_still_gets_output(tmp_path: Path) -> None:
    code, err, out = shell(tmp_path, "zenvoy technologies", COLUMNS="0")
    assert (code, err) == (0, "")
    assert b"640 MHz" in b" ".join(out.split())


@pytest.fixture
def streams() -> Iterator[None]:
    """Restore the streams of Python after a test that replaces them."""
    before = sys.stdout, sys.stderr
    yield
    sys.stdout, sys.stderr = before


def text_to(number: int) -> io.TextIOWrapper:
    """Return a text stream over an outlet."""
    return io.TextIOWrapper(io.BufferedWriter(Outlet(number)), encoding="utf-8")


@pytest.mark.usefixtures("streams")
@pytest.mark.parametrize("name", ["stdout", "stderr"])
@pytest.mark.parametrize(("code", "expected"), [(0, 1), (3, 3)])
def test_a_failed_write_turns_exit_code_0_into_1(name: str, code: int, expected: int) -> None:
    with Path("/dev/full").open("wb", buffering=0) as full, Path("/dev/null").open("wb") as null:
        sys.stdout = text_to((full if name == "stdout" else null).fileno())
        sys.stderr = text_to((full if name == "stderr" else null).fileno())
        print("a text", file=getattr(sys, name))
        assert flush(code) == expected
        assert flush(code) == expected


@pytest.mark.usefixtures("streams")
def test_a_reader_that_closes_the_pipe_is_no_failure() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    sys.stdout = text_to(writer)
    print("a text")
    assert flush(0) == 0
    assert flush(2) == 2
    os.close(writer)


def test_all_output_is_written_to_a_non_blocking_pipe() -> None:
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
def test_characters_that_an_encoding_lacks_are_written_in_ascii(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(io.BytesIO(), encoding="latin-1"))
    install()
    assert isinstance(sys.stdout, io.TextIOWrapper)
    assert (sys.stdout.encoding, sys.stderr.encoding) == ("latin-1", "utf-8")
    shown = "Größe ≥ 2 m/s², −3 σ: 模 \udcff".encode("latin-1", str(sys.stdout.errors))
    assert shown == b"Gr\xf6\xdfe >= 2 m/s\xb2, -3 sigma: \\u6a21 \\udcff"
    assert "×".encode("ascii", str(sys.stdout.errors)) == b"x"
