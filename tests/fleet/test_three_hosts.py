"""A run across three hosts with addresses of their own, over links that delay, drop and break.

The first host serves the run, over TLS; two others join with half of the vehicles each.
"""

from __future__ import annotations

import re
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

import pytest

from tests.conftest import LIMIT_S, Command, command, wait_until, zenvoy
from tests.fleet.joining import meeting
from tests.fleet.networks import Host, require_netem, star
from tests.let_pass import let_pass
from tests.streamed_log import read_log

STEPPED: Final = """
duration_s: 200
fleet: {size: 8}
channel: {loss: {p: 0.1}}
"""
LONG: Final = STEPPED.replace("duration_s: 200", "duration_s: 100000")
_CUT_S: Final = 3.0
_SLOW_S: Final = 5.0


@pytest.fixture
def hosts() -> Iterator[list[Host]]:
    """Yield three hosts."""
    with star(["a", "b", "c"]) as made:
        yield made


@contextmanager
def serving(folder: Path, host: Host, scenario: str, *options: str) -> Iterator[Command]:
    """Serve a scenario on a host."""
    (folder / "s.yaml").write_text(scenario)
    groups = ("--group", "1-4", "--group", "5-8", "--host", "10.77.1.1", "--host", "10.77.2.1")
    assert zenvoy(folder, "certs", "keys", "--vehicles", "8", *groups).code == 0
    locked = ("--listen", "tls/0.0.0.0:7447", "--certs", "keys", "--out", "out")
    with host.inside(), command(folder, "serve", "s.yaml", *locked, *options) as started:
        wait_until((folder / "out" / "connect.json").exists, "it says where to connect to")
        yield started


@contextmanager
def joined(folder: Path, host: Host, vehicles: str) -> Iterator[Command]:
    """Join the run on a host with some vehicles."""
    (folder / host.name).mkdir()
    there = ("--run", meeting(folder)["run"], "--certs", str(folder / "keys"))
    doors = [("--connect", f"tls/{host.server}:{port}") for port in (7447, 7448)]
    share = ("--vehicles", vehicles, "--host", host.name, "--out", "out")
    limit = ("--timeout-s", f"{LIMIT_S:g}")
    with (
        host.inside(),
        command(folder / host.name, "join", *share, *there, *doors[0], *doors[1], *limit) as one,
    ):
        yield one


@pytest.mark.parametrize("links", ["plain", "delay and loss"])
def test_three_hosts_write_the_log_of_one_though_a_link_is_cut(
    tmp_path: Path, hosts: list[Host], links: str
) -> None:
    a, b, c = hosts
    if links == "delay and loss":
        require_netem(c)
        b.shape("delay", "1ms")
        c.shape("delay", "4ms", "loss", "1%")
    (tmp_path / "s.yaml").write_text(STEPPED)
    assert zenvoy(tmp_path, "run", "s.yaml", "--bus", "in-process", "--out", "alone").code == 0
    patient = ("--set", f"stall_limit_s={LIMIT_S:g}")
    with serving(tmp_path, a, STEPPED, *patient) as served, joined(tmp_path, b, "1-4") as first:
        wait_until(lambda: "missing: vehicles 5-8\n" in served.out, "it says who is missing")
        with joined(tmp_path, c, "5-8") as late:
            served.wait_for_cycles(tmp_path / "out" / "run.mcap")
            c.cut()
            let_pass(_CUT_S)
            assert "written to" not in served.out  # the run has not ended before the cut
            c.heal()
            outcome = served.wait()
            assert (first.wait().code, late.wait().code) == (0, 0)
    assert (outcome.code, outcome.err) == (0, "")
    logs = [read_log(tmp_path / name / "run.mcap") for name in ("alone", "out")]
    assert logs[0].result["fingerprint"] == logs[1].result["fingerprint"]


@pytest.mark.parametrize("how", ["cut off", "stopped"])
def test_a_host_that_is_lost_or_stuck_is_named(tmp_path: Path, hosts: list[Host], how: str) -> None:
    a, b, c = hosts
    short = ("--set", "stall_limit_s=3")
    with (
        serving(tmp_path, a, LONG, *short) as served,
        joined(tmp_path, b, "1-4"),
        joined(tmp_path, c, "5-8") as lost,
    ):
        served.wait_for_cycles(tmp_path / "out" / "run.mcap")
        if how == "cut off":
            c.cut()
        else:
            lost.send_to_group(signal.SIGSTOP)
        outcome = served.wait()
        lost.send_to_group(signal.SIGCONT)
    assert outcome.code == 3
    assert re.match(r"vehicle-0[5-8]( and . more)? stalled: .* \(on c\)\n", outcome.err)


def test_a_slow_host_is_named_as_the_one_that_holds_up_the_steps(
    tmp_path: Path, hosts: list[Host]
) -> None:
    a, b, c = hosts
    short = STEPPED.replace("duration_s: 200", "duration_s: 20")
    patient = ("--set", f"stall_limit_s={LIMIT_S:g}")
    with (
        serving(tmp_path, a, short, *patient) as served,
        joined(tmp_path, b, "1-4"),
        joined(tmp_path, c, "5-8") as slow,
    ):
        served.wait_for_cycles(tmp_path / "out" / "run.mcap")
        slow.send_to_group(signal.SIGSTOP)
        let_pass(_SLOW_S)
        slow.send_to_group(signal.SIGCONT)
        outcome = served.wait()
    assert (outcome.code, outcome.err) == (0, "")
    said = read_log(tmp_path / "out" / "run.mcap").result["held_up"]
    assert re.fullmatch(r"vehicles 5-8 on c held up \S+ % of the steps, by \S+ ms each", said)
    assert said in outcome.out
