"""A trial runs a case in a folder of its own."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from tests.chaos.cases import Case, scenario_of
from tests.chaos.found import Found
from tests.chaos.judging import judge_end, judge_log
from tests.chaos.strikes import TooLateError, go_on_later, strike
from tests.conftest import Command, command, wait_until


def try_case(case: Case, folder: Path) -> Found:
    """Run a case in a new folder.

    If the run is complete before its start is seen, it is repeated, ten times as long.
    """
    folder.mkdir()
    for times in (1, 10, 100):
        attempt = folder / str(times)
        attempt.mkdir()
        try:
            return _try(Found(case, times=times), attempt)
        except TooLateError:
            continue
    pytest.fail(f"{case}: the run was complete before its start was seen, three times")


def _try(found: Found, folder: Path) -> Found:
    case = found.case
    (folder / "s.yaml").write_text(scenario_of(case.mode, case.stall_limit_s, found.times))
    options = ("--vehicles-per-process", "2") if case.mode == "shared" else ()
    with command(folder, "run", "s.yaml", "--out", "out", *options) as started:
        clock = strike(started, case, folder / "out")
        hit_s = time.monotonic()
        if case.blow.startswith("STOP"):
            go_on_later(started, case)
        outcome = started.wait(120.0)
        found.took_s = time.monotonic() - hit_s
        found.code = outcome.code
        found.message = outcome.err.partition("\n")[0]
        judge_end(found, outcome, started)
        if case.victim == "command" and case.blow == "KILL":
            wait_until(lambda: not _temporary(started), "the folder of sockets is gone", 10.0)
        found.wrong += [f"left in the temporary folder: {name}" for name in _temporary(started)]
    judge_log(found, folder / "out" / "run.mcap", clock)
    return found


def _temporary(started: Command) -> list[str]:
    return [path.name for path in Path(started.sockets.name).iterdir()]
