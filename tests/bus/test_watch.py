"""A request to end takes effect at a wait, and interrupts nothing else.

The signals and the timer of a watch belong to a process, so each test has one of its own.
"""

from __future__ import annotations

import subprocess
import sys
from typing import Final

from tests.as_child import as_child

_HEAD: Final = """
import os, signal, sys, threading
from zenvoy.bus.errors import StoppedError
from zenvoy.bus.watch import Watch

def wait_for_ever():
    threading.Event().wait()

def ask_to_end():
    os.kill(os.getpid(), signal.SIGTERM)

done = []
"""


def child(program: str) -> subprocess.CompletedProcess[str]:
    """Run a program with what `_HEAD` defines, and return how it has ended."""
    command = as_child(sys.executable, "-c", _HEAD + program)
    return subprocess.run(command, check=False, capture_output=True, text=True)


def test_a_request_during_idle_work_takes_effect_after_it() -> None:
    """Idle work writes to the log. A record that is written in part would cut the log."""
    ended = child("""
def idle():
    done.append("begun")
    ask_to_end()
    for _ in range(1000):
        pass  # the handler of the signal has run by now
    done.append("ended")

try:
    with Watch(None, lambda _: None, idle) as watch:
        watch.wait(wait_for_ever)
except StoppedError:
    done.append("stopped")
print(*done)
""")
    assert (ended.stdout, ended.stderr, ended.returncode) == ("begun ended stopped\n", "", 0)


def test_a_request_takes_effect_in_a_wait_of_idle_work() -> None:
    ended = child("""
def idle():
    ask_to_end()
    watch.wait(wait_for_ever)

try:
    with Watch(None, lambda _: None, idle) as watch:
        watch.wait(wait_for_ever)
except StoppedError:
    print("stopped")
""")
    assert (ended.stdout, ended.stderr, ended.returncode) == ("stopped\n", "", 0)


def test_idle_work_is_not_entered_while_it_goes_on() -> None:
    """It may take longer than the time between two alarms."""
    ended = child("""
def idle():
    done.append("begun")
    signal.raise_signal(signal.SIGALRM)
    done.append("ended")
    ask_to_end()

try:
    with Watch(None, lambda _: None, idle) as watch:
        watch.wait(wait_for_ever)
except StoppedError:
    print(*done)
""")
    assert (ended.stdout, ended.stderr, ended.returncode) == ("begun ended\n", "", 0)


def test_no_alarm_of_the_watch_ends_a_process_that_was_asked_to_end() -> None:
    """Once an alarm ends the process, the next one is that of the time to end in."""
    ended = child("""
def look(_frame, event, _called):
    if event == "c_return" and signal.getsignal(signal.SIGALRM) is signal.SIG_DFL:
        left_s, _ = signal.getitimer(signal.ITIMER_REAL)
        done.append(left_s > 1)

try:
    with Watch(None, lambda _: None) as watch:
        sys.setprofile(look)
        ask_to_end()
        watch.wait(wait_for_ever)
except StoppedError:
    sys.setprofile(None)
print(len(done) > 0, set(done))
""")
    assert (ended.stdout, ended.stderr, ended.returncode) == ("True {True}\n", "", 0)
