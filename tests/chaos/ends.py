"""The ends of runs that docs/ends.md allows for each case."""

from __future__ import annotations

import signal
from dataclasses import dataclass
from typing import Final

from tests.chaos.cases import PAUSE_S, STALL_LIMIT_S, Case

KEPT: Final = "interrupted; the log up to here is kept"
COMPLETE_BY_THEN: Final = "interrupted; the run was complete by then"


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
    if case.moment == "last":  # the victim may have finished already, or not be needed
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
