"""The user's own code may exit, hang or fail. The error names it, and the command goes on."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import command, wait_until, zenvoy
from zenvoy.analysis.log.load import load
from zenvoy.vehicles.time_limit import time_limit

LEAVES = {
    "sys.exit(0)": "SystemExit: 0",
    "sys.exit()": "SystemExit",
    "exit(3)": "SystemExit: 3",
    "raise KeyboardInterrupt": "KeyboardInterrupt",
    "raise GeneratorExit('done')": "GeneratorExit: done",
    "raise Ended('for good')": "Ended: for good",
}
LAW = """
import sys
import signal
from dataclasses import dataclass
from zenvoy.laws import Estimator, Law
class Ended(BaseException): pass
@dataclass(frozen=True)
class Parameters:
    gain: float = 1.0
    def __post_init__(self):
        if self.gain > 2.0:
            raise ValueError("a gain above 2 is not stable")
        if self.gain < 0.0:
            sys.exit(1)
def law(seen, own):
    if seen.speed < 32.0:
        {at_run}
    return -1.0
class Tracker:
    def __init__(self, model, z, R, own):
        self.steps = 0
    def step(self, inputs, z, R):
        self.steps += 1
        if self.steps > 9:
            {at_run}
        return z, R
def linear(own, setpoint, m):
    {in_linear}
{at_load}
LAW = Law(name="leaver", acceleration=law, parameters=Parameters)
TRACKER = Estimator(name="leaver", start=Tracker)
LINEAR = Law(name="leaver", acceleration=law, linear=linear)
"""
SCENARIO = """
duration_s: 20
stall_limit_s: 2
fleet: {size: 3, speed_mps: 33}
control: {desired_speed_mps: 33}
"""
OWN_LAW = ("--set", "control.model=bad:LAW")
OWN_ESTIMATOR = ("--set", "estimator.kind=bad:TRACKER")


def write(
    folder: Path, *, at_run: str = "pass", at_load: str = "pass", in_linear: str = "pass"
) -> None:
    text = LAW.format(at_run=at_run, at_load=at_load, in_linear=in_linear)
    (folder / "bad.py").write_text(text.lstrip())
    (folder / "s.yaml").write_text(SCENARIO)


@pytest.mark.parametrize("what", LEAVES)
@pytest.mark.parametrize("own", [OWN_LAW, OWN_ESTIMATOR], ids=["law", "estimator"])
def test_a_file_that_exits_while_it_is_loaded_is_refused(
    tmp_path: Path, what: str, own: tuple[str, str]
) -> None:
    write(tmp_path, at_load=what)
    outcome = zenvoy(tmp_path, "check", "s.yaml", *own)
    key, _, name = own[1].partition("=")
    assert outcome.code == 2
    message = f"bad.py cannot be run: {LEAVES[what]} (bad.py, line 28)"
    assert outcome.err == f"{key}: '{name}': {message}  (--set {own[1]})\n"


@pytest.mark.parametrize("bus", ["in-process", "zenoh"])
@pytest.mark.parametrize("what", ["sys.exit(0)", "raise KeyboardInterrupt", "raise Ended('x')"])
@pytest.mark.parametrize(("own", "line"), [(OWN_LAW, 16), (OWN_ESTIMATOR, 24)])
def test_code_that_exits_in_a_run_is_named_and_the_log_is_kept(
    tmp_path: Path, own: tuple[str, str], line: int, what: str, bus: str
) -> None:
    write(tmp_path, at_run=what)
    outcome = zenvoy(tmp_path, "run", "s.yaml", *own, "--bus", bus, "--out", "out")
    assert outcome.code == 3, outcome.err
    kind = "law" if own is OWN_LAW else "estimator"
    message = {"sys.exit(0)": "SystemExit: 0", "raise Ended('x')": "Ended: x"}.get(what, what[6:])
    first = outcome.err.splitlines()[0]
    assert first.startswith("vehicle-0")
    assert first.partition(" died: ")[2] == f"{kind} leaver raised {message} (bad.py, line {line})"
    assert load(tmp_path / "out" / "run.mcap").cycles > 0


# Code of a user that hangs, in a system call and in Python. No test waits for it.
HANGS = ["signal.pause()", "while True: pass"]


@pytest.mark.parametrize("bus", ["in-process", "zenoh"])
@pytest.mark.parametrize("what", HANGS)
def test_an_estimator_that_hangs_is_named_with_its_line(
    tmp_path: Path, what: str, bus: str
) -> None:
    write(tmp_path, at_run=what)
    outcome = zenvoy(tmp_path, "run", "s.yaml", *OWN_ESTIMATOR, "--bus", bus, "--out", "out")
    assert outcome.code == 3, outcome.err
    first = outcome.err.splitlines()[0]
    assert first.startswith("vehicle-0")
    assert first.partition(" died: ")[2] == (
        "estimator leaver raised TimeoutError: took longer than 2 s (bad.py, line 24)"
    )
    assert load(tmp_path / "out" / "run.mcap").cycles > 0


def test_a_dataclass_may_refuse_its_parameters(tmp_path: Path) -> None:
    write(tmp_path)
    for gain, message in (
        ("3.0", "ValueError: a gain above 2 is not stable (bad.py, line 11)"),
        ("-1.0", "SystemExit: 1 (bad.py, line 13)"),
    ):
        changes = (*OWN_LAW, "--set", f"control.parameters.gain={gain}")
        outcome = zenvoy(tmp_path, "check", "s.yaml", *changes)
        assert outcome.code == 2
        assert outcome.err.startswith(f"control.parameters: Parameters raised {message}  (--set")
        assert len(outcome.err.splitlines()) == 1


@pytest.mark.parametrize(
    ("what", "message"),
    [
        ("sys.exit(1)", "SystemExit: 1 (bad.py, line 27)"),
        ("return 1 / 0", "ZeroDivisionError: division by zero (bad.py, line 27)"),
        ("return None", "TypeError: 'NoneType' object is not iterable (bad.py, line 26)"),
    ],
)
def test_a_linear_form_that_fails_is_found_before_the_run(
    tmp_path: Path, what: str, message: str
) -> None:
    write(tmp_path, in_linear=what)
    outcome = zenvoy(tmp_path, "check", "s.yaml", "--set", "control.model=bad:LINEAR")
    assert outcome.code == 2
    message = f"linear form of law leaver raised {message}"
    assert outcome.err == f"control.model: {message}  (--set control.model=bad:LINEAR)\n"


def test_ctrl_c_is_not_blamed_on_the_code(tmp_path: Path) -> None:
    """Ctrl-C ends the command as usual while a file is loaded, and the file is not blamed."""
    # The file waits for the signal, so that it comes while the file is loaded.
    write(tmp_path, at_load="open('loads', 'w').close(); signal.pause()")
    with command(tmp_path, "check", "s.yaml", *OWN_LAW) as started:
        wait_until((tmp_path / "loads").exists, "the file is being loaded")
        started.send(signal.SIGINT)
        outcome = started.wait()
    assert outcome.code == 130
    assert "bad.py" not in outcome.err


def test_a_limit_restores_the_alarm_of_its_process() -> None:
    """A process may watch itself with the same timer."""
    before = signal.signal(signal.SIGALRM, signal.SIG_IGN)
    try:
        signal.setitimer(signal.ITIMER_REAL, 900.0, 800.0)
        with time_limit(50.0):
            assert signal.getitimer(signal.ITIMER_REAL)[0] <= 50.0
        left, every = signal.getitimer(signal.ITIMER_REAL)
        assert 100.0 < left <= 900.0
        assert every == 800.0
        assert signal.getsignal(signal.SIGALRM) == signal.SIG_IGN
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def test_an_alarm_that_comes_late_is_not_taken_for_the_limit() -> None:
    """The signal of the timer before may be on its way, received by another thread."""
    rung: list[int] = []
    before = signal.signal(signal.SIGALRM, lambda number, _: rung.append(number))
    try:
        with time_limit(50.0):
            signal.raise_signal(signal.SIGALRM)
        assert rung == [signal.SIGALRM]
    finally:
        signal.signal(signal.SIGALRM, before)


def test_the_alarm_of_a_process_is_not_taken_for_the_limit() -> None:
    """The timer with which a process watches itself may go off at any moment.

    The process is one of its own: a thread of the tests' process may receive an alarm so late that
    its handler is gone.
    """
    script = """if True:
        import signal
        from zenvoy.vehicles.time_limit import time_limit
        rung = []
        signal.signal(signal.SIGALRM, lambda number, _: rung.append(number))
        signal.setitimer(signal.ITIMER_REAL, 2e-5, 2e-5)
        for _ in range(20_000):
            with time_limit(50.0):
                pass
        assert signal.getitimer(signal.ITIMER_REAL)[1] > 0.0
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        assert rung
    """
    command = (sys.executable, "-c", script)
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
