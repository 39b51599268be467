"""`zenvoy run --watch` has the screen of a terminal during a run, and leaves it as it was."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import signal
import struct
import termios
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

import pytest

from tests.conftest import LIMIT_S, Outcome, command, zenvoy
from tests.logs import write_log
from zenvoy.analysis.view.watched import WatchedRun
from zenvoy.cli.live_table import frame

SHORT: Final = ("run", "quickstart", "--engine", "in-process", "--duration-s", "13")
OPENED: Final = b"\x1b[?1049h"  # the alternate screen
CLOSED: Final = b"\x1b[?1049l"
SHOWN: Final = b"\x1b[?25h"  # the cursor
_STYLES: Final = re.compile(rb"\x1b\[[0-9;]*m")
_CODES: Final = re.compile(rb"\x1b\[[?0-9;]*[A-Za-z]")


class Screen:
    """A terminal, and what has been written to it."""

    def __init__(self, columns: int) -> None:
        self._master, self.end = pty.openpty()
        self.resize(columns)
        self.written = b""

    def resize(self, columns: int) -> None:
        """Give the terminal so many columns, and 24 lines."""
        fcntl.ioctl(self._master, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))

    def frames(self) -> list[bytes]:
        """Return the whole frames that have been drawn on the alternate screen."""
        drawn = self.written.partition(CLOSED)[0].split(b"\x1b[H")
        return [one for one in drawn if b"\x1b[J" in one]

    def read(self) -> bool:
        """Read what comes next; return False once nobody can write any more."""
        assert select.select([self._master], [], [], LIMIT_S)[0], self.written
        try:
            new = os.read(self._master, 65_536)
        except OSError:  # the last writer has closed the terminal
            return False
        self.written += new
        return bool(new)

    def wait_for_frame(self, widths: range, after: int = 0) -> None:
        """Return once a table of a run that goes on has been drawn that is so wide."""
        while not any(b"real time" in f and widest(f) in widths for f in self.frames()[after:]):
            assert self.read(), self.written

    def close(self) -> None:
        """Close both ends."""
        self.let_go()
        os.close(self._master)

    def let_go(self) -> None:
        """Leave the terminal to the command."""
        if self.end >= 0:
            os.close(self.end)
            self.end = -1


@contextmanager
def screen(columns: int) -> Iterator[Screen]:
    made = Screen(columns)
    try:
        yield made
    finally:
        made.close()


def widest(drawn: bytes) -> int:
    """Return how many columns a frame takes."""
    return max(len(line) for line in plain(drawn).splitlines())


def plain(drawn: bytes) -> str:
    return _CODES.sub(b"", drawn).decode()


def test_a_narrow_terminal_gets_the_table_and_then_the_usual_summary(tmp_path: Path) -> None:
    quiet = zenvoy(tmp_path, *SHORT, "--out", "quiet")
    with screen(60) as terminal:
        environment = {"NO_COLOR": "1", "COLUMNS": "200", "TERM": "xterm-256color"}
        with command(
            tmp_path, *SHORT, "--watch", "--out", "seen", stdout=terminal.end, env=environment
        ) as started:
            terminal.let_go()
            while terminal.read():
                pass
            outcome = started.wait()
    assert (outcome.code, outcome.err) == (0, "")
    before, _, rest = terminal.written.partition(OPENED)
    _, _, after = rest.partition(CLOSED)
    assert (before, SHOWN in rest) == (b"", True)
    assert all(widest(drawn) < 60 for drawn in terminal.frames())
    assert not re.search(rb"\x1b\[[0-9;]*(3|4)[0-9][;m]", terminal.written)  # a colour
    (fingerprint,) = re.findall("[0-9a-f]{64}", quiet.out)
    assert fingerprint in _STYLES.sub(b"", after).decode()
    assert "written to seen" in after.decode()


def test_the_table_follows_a_resize_and_ctrl_c_leaves_a_sane_terminal(tmp_path: Path) -> None:
    with screen(100) as terminal:
        run = ("run", "quickstart", "--realtime", "--set", "fleet.size=3", "--set", "events=[]")
        environment = {"TERM": "xterm-256color"}
        with command(
            tmp_path, *run, "--watch", "--out", "r", stdout=terminal.end, env=environment
        ) as started:
            before = termios.tcgetattr(terminal.end)
            terminal.wait_for_frame(range(50, 100))
            drawn = len(terminal.frames())
            terminal.resize(50)
            terminal.wait_for_frame(range(50), drawn)
            started.wait_for_children({"watch"})
            started.send_to_group(signal.SIGINT)
            while CLOSED not in terminal.written or b"written to r" not in terminal.written:
                assert terminal.read()
            assert started.wait().code == 130
            assert started.left() == []
            assert termios.tcgetattr(terminal.end) == before
    assert terminal.written.rindex(SHOWN) > terminal.written.rindex(b"\x1b[?25l")
    assert terminal.written.count(OPENED) == terminal.written.count(CLOSED) == 1


def test_the_last_table_has_events_as_sentences_and_the_last_modes(tmp_path: Path) -> None:
    brake = "{type: brake, vehicle: 2, at_s: 1, duration_s: 1, deceleration_mps2: 2}"
    text = f"duration_s: 3\nfleet: {{size: 5}}\nevents: [{brake}]\n"
    run = WatchedRun(write_log(tmp_path / "run.mcap", text))
    while run.extend():
        pass
    shown = plain(frame(run, os.terminal_size((100, 24)), "utf-8"))
    rows = [" ".join(line.split()) for line in shown.splitlines()]
    end = ["modes PBCM: 5", "1.0 s vehicle 2 brakes, 2 m/s²", "2.0 s vehicle 2 stops braking"]
    assert rows[-3:] == end


def test_without_a_terminal_there_is_no_table(tmp_path: Path) -> None:
    refused = zenvoy(tmp_path, *SHORT, "--watch", env={"FORCE_COLOR": "1"})
    line = "--watch: standard output is no terminal with a cursor; allowed: on a terminal\n"
    assert refused == Outcome(2, "", line)
    assert list(tmp_path.glob("runs")) == []


@pytest.mark.parametrize("option", ["--view", "--foxglove"])
def test_a_table_would_hide_the_address_of_the_page(tmp_path: Path, option: str) -> None:
    with screen(80) as terminal:
        refused = zenvoy(
            tmp_path, *SHORT, "--watch", option, stdout=terminal.end, env={"TERM": "xterm"}
        )
    line = "--watch: its table would hide the address that --view or --foxglove prints; "
    assert (refused.code, refused.err) == (2, f"{line}allowed: one of them\n")
