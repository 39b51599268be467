"""`zenvoy serve` starts a run whose vehicles other machines drive, and `zenvoy join` drives them.

Here the machines are commands of this one, which connect over TLS.
"""

from __future__ import annotations

import re
import signal
from pathlib import Path
from typing import Final

import pytest

from tests.conftest import wait_until, zenvoy
from tests.fleet.hosts import host, serving
from tests.fleet.slow_machine import hold_up
from tests.streamed_log import read_log

STEPPED: Final = """
duration_s: 20
fleet: {size: 8}
channel: {loss: {p: 0.1}}
"""
LONG: Final = STEPPED.replace("duration_s: 20", "duration_s: 100000")


@pytest.mark.parametrize("per_process", ["1", "2"])
def test_two_machines_write_the_log_of_one(tmp_path: Path, per_process: str) -> None:
    shared = ("--vehicles-per-process", per_process)
    (tmp_path / "s.yaml").write_text(STEPPED)
    assert zenvoy(tmp_path, "run", "s.yaml", "--bus", "in-process", "--out", "alone").code == 0
    with serving(tmp_path, STEPPED, *shared) as (served, there):
        with host(tmp_path, "alpha", "1-4", *there) as first:
            wait_until(lambda: "missing: vehicles 5-8\n" in served.out, "it says who is missing")
            unnamed = there[2:]  # there is only one run
            with host(tmp_path, "beta", "5-8", *unnamed, *shared) as late:
                assert (late.wait().code, first.wait().code) == (0, 0)
        outcome = served.wait()
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.startswith("waiting for vehicles 1-8; to join, on any machine:\n")
    assert "the fleet is complete\n" in outcome.out
    logs = [read_log(tmp_path / name / "run.mcap") for name in ("alone", "out")]
    assert logs[0].result["fingerprint"] == logs[1].result["fingerprint"]
    for role in ("world", "channel"):
        assert (tmp_path / "out" / "logs" / f"{role}.log").read_text() == ""  # nobody was refused


def test_a_machine_that_holds_up_the_steps_is_named(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(STEPPED)
    assert zenvoy(tmp_path, "run", "s.yaml", "--bus", "in-process", "--out", "alone").code == 0
    with (
        serving(tmp_path, STEPPED) as (served, there),
        host(tmp_path, "alpha", "1-4", *there),
        host(tmp_path, "beta", "5-8", *there) as slow,
    ):
        log = tmp_path / "out" / "run.mcap"
        served.wait_for_cycles(log)
        hold_up(slow, "beta", served, log)
        outcome = served.wait()
    assert (outcome.code, outcome.err) == (0, "")
    alone, whole = (read_log(tmp_path / name / "run.mcap") for name in ("alone", "out"))
    said = whole.result["held_up"]
    assert re.fullmatch(r"vehicles 5-8 on beta held up \S+ % of the steps, by \S+ ms each", said)
    assert said in outcome.out
    assert whole.result["fingerprint"] == alone.result["fingerprint"]
    assert "held_up" not in alone.result


def test_a_machine_that_is_lost_is_named(tmp_path: Path) -> None:
    short = ("--set", "stall_limit_s=2")
    with (
        serving(tmp_path, LONG, *short) as (served, there),
        host(tmp_path, "alpha", "1-4", *there),
        host(tmp_path, "beta", "5-8", *there) as lost,
    ):
        served.wait_for_cycles(tmp_path / "out" / "run.mcap")
        lost.send_to_group(signal.SIGKILL)
        outcome = served.wait()
    assert outcome.code == 3
    assert re.match(r"vehicle-0[5-8]( and . more)? stalled: .* \(on beta\)\n", outcome.err)


def test_what_does_not_fit_a_run_is_refused(tmp_path: Path) -> None:
    with serving(tmp_path, LONG, "--vehicles-per-process", "4") as (_, there):

        def refused(*options: str) -> str:
            outcome = zenvoy(tmp_path, "join", *there, *options)
            assert (outcome.code, outcome.out) == (2, "")
            return outcome.err

        assert refused("--vehicles", "1-9").startswith("--vehicles 1-9: is not in [1, 8], the")
        assert refused("--vehicles", "3-8").startswith(
            "--vehicles 3-8: has only a part of the process vehicles-01-04; allowed: all of its"
        )
        assert refused("--vehicles", "1-4", "--vehicles-per-process", "2") == (
            "--vehicles-per-process 2: the run has 4; zenvoy serve sets it for all machines\n"
        )
        assert refused("--vehicles", "1-8").startswith(f"--certs {tmp_path}/keys: has no vehicles-")
        line = "--vehicles 0-4: is not N or N-M with 1 <= N <= M, as 21-40\n"
        assert refused("--vehicles", "0-4") == line
