"""The command and the log of a run are compared with the end that docs/ends.md gives."""

from __future__ import annotations

import signal
import tempfile
from functools import cache
from pathlib import Path
from typing import Final

from tests.chaos.cases import PATIENT_S, scenario_of
from tests.chaos.ends import COMPLETE_BY_THEN, expected_of
from tests.chaos.found import Found
from tests.conftest import Command, Outcome, run
from tests.streamed_log import Log, read_log
from zenvoy.bus import messages_pb2 as pb

LOST_S: Final = 0.5  # wall time that a log may lose at its end if its world is killed


@cache
def undisturbed(mode: str, times: int) -> str:
    """Return the fingerprint of an undisturbed run in lock-step, `times` as long as usual."""
    with tempfile.TemporaryDirectory(prefix="chaos-") as folder:
        log = run(
            Path(folder) / "alone", scenario_of(mode, PATIENT_S, times), "--bus", "in-process"
        )
        return log.result["fingerprint"]


def judge_end(found: Found, outcome: Outcome, started: Command) -> None:
    """Check the exit code, stderr and the time that the end took, and that no process is left."""
    case, expected = found.case, expected_of(found.case)
    first = found.message
    if outcome.code not in expected.ends:
        found.wrong.append(f"exit code {outcome.code}, allowed: {sorted(expected.ends)}")
    elif case.moment == "last" and _completed_anyway(found):
        pass
    elif first != expected.ends[outcome.code] and not (outcome.code == 0 and not first):
        found.wrong.append(f"stderr says {first!r}, not {expected.ends[outcome.code]!r}")
    if "Traceback" in outcome.err:
        found.wrong.append("a traceback")
    if found.took_s > expected.within_s and outcome.code:
        found.wrong.append(f"took {found.took_s:.1f} s, allowed: {expected.within_s:g} s")
    patience_s = 10.0 if case.victim == "command" and case.blow == "KILL" else 0.0
    found.wrong += [f"left behind: {name}" for name in started.left(patience_s)]


def _completed_anyway(found: Found) -> bool:
    """Return whether the command reports that the victim had finished."""
    if found.code == 0:
        name = f"{found.case.process} "
        return found.message.startswith(name) and found.message.endswith("the run is complete")
    return found.code == 130 and found.message == COMPLETE_BY_THEN


def judge_log(found: Found, path: Path, clock: pb.Clock) -> None:
    """Check that the log is readable and has the end of the run, and measure what it has lost."""
    case = found.case
    if not path.exists() or not path.stat().st_size:  # the log starts with the first cycle
        if case.moment != "start" or found.code == 0:
            found.wrong.append("no log")
        return
    log = read_log(path)
    cycles = [pb.FleetTruth.FromString(one.data).cycle for one in log.of("/fleet/truth")]
    if cycles != list(range(len(cycles))):
        found.wrong.append("a cycle is missing in the log")
    if not log.whole:
        if not expected_of(case).cut and case.moment != "start":
            found.wrong.append("the log is cut")
        clocks = [pb.Clock.FromString(one.data) for one in log.of("/clock")]
        found.lost_s = (clock.wall_ns - (clocks[-1].wall_ns if clocks else 0)) * 1e-9
        if case.moment != "start" and found.lost_s > LOST_S:
            found.wrong.append(f"{found.lost_s:.2f} s are lost")
    else:
        _judge_result(found, log)


def _judge_result(found: Found, log: Log) -> None:
    """Check that the log is complete if the command says so, with the undisturbed fingerprint."""
    complete = log.result["end"] == "complete"
    killed = found.code == -signal.SIGKILL
    asked_late = found.code == 130 and found.message == COMPLETE_BY_THEN
    if complete != (found.code == 0 or asked_late) and not (killed and found.case.moment == "last"):
        found.wrong.append(f"exit code {found.code}, but the log says {log.result['end']!r}")
    repeatable = complete and found.case.mode != "realtime"
    if repeatable and log.result["fingerprint"] != undisturbed(found.case.mode, found.times):
        found.wrong.append("another fingerprint")
