"""Signals hit the processes of a run at any moment, and the run must end as documented.

`make chaos` runs 500 cases at random moments, and compares their ends with those in docs/ends.md.
tests/fleet/test_chaos.py runs a sample.
"""

from __future__ import annotations

import argparse
import random
import signal
import sys
import tempfile
import threading
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path
from typing import Final

import pytest
import zenoh

from tests.conftest import Command, Log, Outcome, command, read_log, run, wait_until
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.session import open_session
from zenvoy.bus.topics import CLOCK
from zenvoy.fleet.guests import read_endpoints

CYCLES: Final = {"each": 400, "shared": 800, "realtime": 100}
STALL_LIMIT_S: Final = 5.0
PAUSE_S: Final = 3.0  # how long a process is stopped before it goes on
LOST_S: Final = 0.5  # wall time that a log may lose at its end if its world is killed
SIZE: Final = 4

VICTIMS: Final = ("vehicle", "channel", "world", "command")
BLOWS: Final = ("KILL", "TERM", "INT", "HUP", "STOP 3 s", "STOP")
MODES: Final = tuple(CYCLES)
MOMENTS: Final = ("start", "middle", "last")

KEPT: Final = "interrupted; the log up to here is kept"
COMPLETE_BY_THEN: Final = "interrupted; the run was complete by then"

# In the last cycle the victim may have finished already, and be gone or not be needed.
_SCENARIO: Final = """
duration_s: {duration_s}
stall_limit_s: {limit_s}
clock: {clock}
fleet: {{size: {size}}}
control: {{v2v_wait_ms: 25, system_delay_ms: 50}}
channel: {{loss: {{p: 0.1}}}}
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A victim, a signal, a kind of run and a moment. `at` in [0, 1) is the place in the moment."""

    victim: str
    blow: str
    mode: str
    moment: str
    at: float = 0.5

    def __str__(self) -> str:
        return f"{self.victim}, {self.blow}, {self.mode}, {self.moment} {self.at:.3f}"

    @property
    def process(self) -> str:
        """Return the name of the process that is hit."""
        if self.victim != "vehicle":
            return self.victim
        return "vehicles-03-04" if self.mode == "shared" else "vehicle-03"

    @property
    def others(self) -> set[str]:
        """Return the names of all processes but the command."""
        shared = self.mode == "shared"
        vehicles = {"vehicles-01-02", "vehicles-03-04"} if shared else set(_NAMES)
        return {"world", "channel", *vehicles}


_NAMES: Final = tuple(f"vehicle-{vehicle:02d}" for vehicle in range(1, SIZE + 1))


@dataclass(frozen=True, slots=True, kw_only=True)
class ExpectedEnd:
    """The allowed ends of a run: exit codes, each with the first line on stderr, and a limit, s."""

    ends: dict[int, str]
    within_s: float = 2.0
    cut: bool = False
    """Whether the log may be cut."""


def expected_of(case: Case) -> ExpectedEnd:
    """Return the end that docs/ends.md gives for a case."""
    if case.victim == "command":
        return _expected_of_command(case.blow)
    complete = {0: ""}
    if case.blow in {"INT", "HUP"}:
        return ExpectedEnd(ends=complete, within_s=30.0)
    if case.blow == "STOP 3 s":
        return ExpectedEnd(ends=complete, within_s=30.0 + PAUSE_S)
    died = {"KILL": "died: killed by SIGKILL", "TERM": "died: ended by SIGTERM"}
    how = died.get(case.blow, "stalled: a signal or a debugger has stopped it")
    line = f"{case.process} {how}"
    within_s = 2.0 if case.blow in died else STALL_LIMIT_S + 2.0
    if case.mode == "realtime" and case.victim == "vehicle":
        if case.moment == "start":  # a run needs every process until it has begun
            return ExpectedEnd(ends={3: line, 0: f"{line}; the run goes on"}, within_s=30.0)
        at_end = case.blow == "STOP" and case.moment == "last"
        message = "" if at_end else f"{line}; the run goes on"
        return ExpectedEnd(ends={0: message}, within_s=30.0)
    ends = {3: line}
    if case.moment == "last":
        ends[0] = ""
    return ExpectedEnd(
        ends=ends, within_s=within_s, cut=case.process == "world" and case.blow == "KILL"
    )


def _expected_of_command(blow: str) -> ExpectedEnd:
    if blow == "KILL":
        return ExpectedEnd(ends={-signal.SIGKILL: ""}, cut=False)
    if blow.startswith("STOP"):
        return ExpectedEnd(ends={0: ""}, within_s=60.0)
    return ExpectedEnd(ends={130: KEPT, 0: ""})


@dataclass(slots=True)
class Found:
    """The observed end of a case: what is wrong, its duration, and what the log has lost, s."""

    case: Case
    wrong: list[str] = field(default_factory=list)
    took_s: float = 0.0
    lost_s: float = 0.0
    code: int = 0
    message: str = ""
    """The first line on stderr."""


class Watcher:
    """Receives the clock of a run, as any observer may."""

    def __init__(self) -> None:
        self.newest = pb.Clock()
        self.changed = threading.Condition()

    def hear(self, sample: zenoh.Sample) -> None:
        """Keep the newest clock message."""
        with self.changed:
            self.newest = pb.Clock.FromString(sample.payload.to_bytes())
            self.changed.notify_all()

    def wait_for(self, cycle: int, limit_s: float) -> bool:
        """Return whether the run reaches a cycle within the limit."""
        with self.changed:
            return self.changed.wait_for(lambda: self.newest.cycle >= cycle, limit_s)


@contextmanager
def watching(out: Path) -> Iterator[Watcher]:
    """Watch the clock of the run in a folder."""
    watcher = Watcher()
    met = read_endpoints(out)
    with open_session([], met.world[:1], realtime=True) as session:
        session.declare_subscriber(CLOCK.key(met.run), watcher.hear)
        yield watcher


def scenario_of(mode: str) -> str:
    """Return the scenario of a mode, as YAML."""
    clock = "realtime" if mode == "realtime" else "lock-step"
    return _SCENARIO.format(
        duration_s=CYCLES[mode] / 10, limit_s=STALL_LIMIT_S, clock=clock, size=SIZE
    )


@cache
def undisturbed(mode: str) -> str:
    """Return the fingerprint of an undisturbed run in lock-step."""
    with tempfile.TemporaryDirectory(prefix="chaos-") as folder:
        log = run(Path(folder) / "alone", scenario_of(mode), "--bus", "in-process")
        return log.result["fingerprint"]


def try_case(case: Case, folder: Path) -> Found:
    """Run a case in a new folder."""
    folder.mkdir()
    (folder / "s.yaml").write_text(scenario_of(case.mode))
    options = ("--vehicles-per-process", "2") if case.mode == "shared" else ()
    found = Found(case)
    with command(folder, "run", "s.yaml", "--out", "out", *options) as started:
        clock = _strike(started, case, folder / "out")
        hit_s = time.monotonic()
        if case.blow.startswith("STOP"):
            _go_on_later(started, case)
        outcome = started.wait(120.0)
        found.took_s = time.monotonic() - hit_s
        found.code = outcome.code
        found.message = outcome.err.partition("\n")[0]
        _judge_end(found, outcome, started)
        if case.victim == "command" and case.blow == "KILL":
            wait_until(lambda: not _temporary(started), "the folder of sockets is gone", 10.0)
        found.wrong += [f"left in the temporary folder: {name}" for name in _temporary(started)]
    _judge_log(found, folder / "out" / "run.mcap", clock)
    return found


def _strike(started: Command, case: Case, out: Path) -> pb.Clock:
    """Wait for the moment, hit, and return the newest clock message by then."""
    if case.moment == "start":
        first = "world" if case.victim == "command" else case.process
        started.wait_for_children({first})
        # The sleep waits for nothing: it spreads the signals over the start of the fleet.
        # No assertion depends on the progress of the start at the signal.
        time.sleep(0.3 * case.at)
        if case.victim == "command":  # it may be gone at once, and its children have other parents
            started.wait_for_children(set())
        _hit(started, case)
        if case.victim != "command":
            started.wait_for_children(set())
        return pb.Clock()
    started.wait_for_children(case.others)
    with watching(out) as watcher:
        cycles = CYCLES[case.mode]
        most = 0.35 if case.mode == "realtime" else 0.8  # so a stall limit passes before the end
        share = (0.02 + most * case.at) if case.moment == "middle" else 1.0
        watcher.wait_for(max(1, round(share * cycles) - (case.moment == "last")), 60.0)
        _hit(started, case)
        return watcher.newest


def _hit(started: Command, case: Case) -> None:
    number = signal.Signals[f"SIG{case.blow.split()[0]}"]
    if case.victim == "command":
        started.send(number)
        return
    try:
        started.send_to_child(case.process, number)
    except ProcessLookupError:  # it has finished
        return


def _go_on_later(started: Command, case: Case) -> None:
    """Let a stopped process go on, if the case says so."""
    if case.victim == "command":
        time.sleep(PAUSE_S if case.blow == "STOP 3 s" else STALL_LIMIT_S + 2.0)
        started.send(signal.SIGCONT)
    elif case.blow == "STOP 3 s":
        time.sleep(PAUSE_S)
        try:
            started.send_to_child(case.process, signal.SIGCONT)
        except ProcessLookupError:
            return


def _completed_anyway(found: Found) -> bool:
    """Return whether the command reports that the victim had finished."""
    if found.code == 0:
        name = f"{found.case.process} "
        return found.message.startswith(name) and found.message.endswith("the run is complete")
    return found.code == 130 and found.message == COMPLETE_BY_THEN


def _judge_end(found: Found, outcome: Outcome, started: Command) -> None:
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


def _temporary(started: Command) -> list[str]:
    return [path.name for path in Path(started.sockets.name).iterdir()]


def _judge_log(found: Found, path: Path, clock: pb.Clock) -> None:
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
    if repeatable and log.result["fingerprint"] != undisturbed(found.case.mode):
        found.wrong.append("another fingerprint")


def all_kinds() -> list[Case]:
    """Return one case of every kind."""
    return [
        Case(victim=victim, blow=blow, mode=mode, moment=moment)
        for victim in VICTIMS
        for blow in BLOWS
        for mode in MODES
        for moment in MOMENTS
    ]


def random_cases(count: int, seed: int) -> list[Case]:
    """Return `count` cases at random moments: all kinds in turn, in a random order."""
    rng, kinds = random.Random(seed), all_kinds()
    found: list[Case] = []
    while len(found) < count:
        rng.shuffle(kinds)
        for kind in kinds:
            at = rng.random()
            found.append(
                Case(victim=kind.victim, blow=kind.blow, mode=kind.mode, moment=kind.moment, at=at)
            )
    return found[:count]


def table(results: Sequence[Found]) -> str:
    """Return a row for each victim, signal and mode: runs, exit codes, time, loss, wrong ends."""
    rows: dict[tuple[str, str, str], list[Found]] = defaultdict(list)
    for one in results:
        rows[one.case.victim, one.case.blow, one.case.mode].append(one)
    lines = ["victim   signal    mode      runs  took s  lost s  wrong  exit codes"]
    for (victim, blow, mode), found in sorted(rows.items()):
        codes = [one.code for one in found]
        exits = ", ".join(f"{code}: {codes.count(code)}" for code in sorted(set(codes)))
        took_s = max((one.took_s for one in found if one.code), default=0.0)
        lost_s = max(one.lost_s for one in found)
        wrong = sum(bool(one.wrong) for one in found)
        lines.append(
            f"{victim:8} {blow:9} {mode:9} {len(found):4} {took_s:7.2f} {lost_s:7.2f} {wrong:6}  "
            + exits
        )
    return "\n".join(lines)


def main() -> int:
    """Run cases and print the table. Return 1 if any end is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    cases = random_cases(options.runs, options.seed)
    with tempfile.TemporaryDirectory(prefix="chaos-") as name:
        folders = [Path(name) / str(number) for number in range(len(cases))]
        with ThreadPoolExecutor(options.jobs) as pool:
            results = list(pool.map(partial(_try_and_print, len(cases)), cases, folders))
    print(table(results))
    wrong = [one for one in results if one.wrong]
    for one in wrong:
        print(f"{one.case}: {'; '.join(one.wrong)}")
    print(f"{len(results)} runs, {len(wrong)} wrong")
    return bool(wrong)


def _try_and_print(count: int, case: Case, folder: Path) -> Found:
    try:
        found = try_case(case, folder)
    except pytest.fail.Exception as error:  # a wait has timed out
        found = Found(case, [str(error)])
    print(
        f"{int(folder.name) + 1} of {count}: {case}: {found.wrong or 'as documented'}", flush=True
    )
    return found


if __name__ == "__main__":
    sys.exit(main())
