"""A run across three hosts with addresses of their own, over links that delay, drop and break.

The first host serves the run, over TLS; two others join with half of the vehicles each.
"""

from __future__ import annotations

import re
import signal
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Final

import pytest

from tests.complaints import complaints
from tests.conftest import LIMIT_S, Command, command, wait_until, zenvoy
from tests.fleet.hosts import TIMED
from tests.fleet.joining import meeting
from tests.fleet.networks import Host, require_netem, star
from tests.fleet.relayed_link import relayed
from tests.fleet.slow_machine import hold_up
from tests.let_pass import let_pass
from tests.streamed_log import read_log
from zenvoy.bus import messages_pb2 as pb

STEPPED: Final = """
duration_s: 200
fleet: {size: 8}
channel: {loss: {p: 0.1}}
"""
LONG: Final = STEPPED.replace("duration_s: 200", "duration_s: 100000")
_FAR_S: Final = 0.008
_CUT_S: Final = 3.0


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


@pytest.mark.parametrize("links", ["plain", "netem", "relayed"])
def test_three_hosts_write_the_log_of_one_though_a_link_is_cut(
    tmp_path: Path, hosts: list[Host], links: str
) -> None:
    """A link may also delay and drop packets, by the kernel or by a relay."""
    a, b, c = hosts
    # Delays and lost packets hold up the steps, so a shorter run outlasts the cut.
    scenario = STEPPED if links == "plain" else STEPPED.replace("duration_s: 200", "duration_s: 60")
    (tmp_path / "s.yaml").write_text(scenario)
    assert zenvoy(tmp_path, "run", "s.yaml", "--bus", "in-process", "--out", "alone").code == 0
    patient = ("--set", f"stall_limit_s={LIMIT_S:g}")
    with ExitStack() as stack:
        if links == "netem":
            require_netem(c)
            b.shape("delay", "1ms")
            c.shape("delay", "4ms", "loss", "1%")
        relay = None
        if links == "relayed":
            relay = stack.enter_context(relayed(a, c, delay_s=0.004, loss=0.01))
        served = stack.enter_context(serving(tmp_path, a, scenario, *patient))
        first = stack.enter_context(joined(tmp_path, b, "1-4"))
        wait_until(lambda: "missing: vehicles 5-8\n" in served.out, "it says who is missing")
        late = stack.enter_context(joined(tmp_path, c, "5-8"))
        served.wait_for_cycles(tmp_path / "out" / "run.mcap")
        c.cut()
        let_pass(_CUT_S)
        assert "written to" not in served.out  # the run has not ended before the cut
        c.heal()
        outcome = served.wait()
        assert (first.wait().code, late.wait().code) == (0, 0)
        if relay is not None:
            assert 0 < relay.lost < 0.1 * relay.carried
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
        log = tmp_path / "out" / "run.mcap"
        served.wait_for_cycles(log)
        hold_up(slow, "c", served, log)
        outcome = served.wait()
    assert (outcome.code, outcome.err) == (0, "")
    said = read_log(tmp_path / "out" / "run.mcap").result["held_up"]
    assert re.fullmatch(r"vehicles 5-8 on c held up \S+ % of the steps, by \S+ ms each", said)
    assert said in outcome.out


def test_in_real_time_a_clock_is_known_as_well_as_its_link_is_fast(
    tmp_path: Path, hosts: list[Host]
) -> None:
    """Both hosts have the clock of the first, so every bound must contain an offset of 0."""
    a, b, c = hosts
    with (
        relayed(a, c, delay_s=_FAR_S, loss=0.0),
        serving(tmp_path, a, TIMED, "--vehicles-per-process", "4") as served,
        joined(tmp_path, b, "1-4") as near,
        joined(tmp_path, c, "5-8") as far,
    ):
        outcome = served.wait()
        assert (outcome.code, outcome.err) == (0, "")
        assert (near.wait().code, far.wait().code) == (0, 0)
    assert complaints(tmp_path / "out") == []
    log = read_log(tmp_path / "out" / "run.mcap")
    rows = [pb.RealTime.FromString(message.data) for message in log.of("/realtime")]
    errors_ns: dict[str, list[int]] = {"near": [], "far": []}
    for row in rows:
        offsets = zip(row.clock_offset_ns, row.clock_error_ns, strict=True)
        for vehicle, (offset_ns, error_ns) in enumerate(offsets, 1):
            if error_ns >= 0:  # it has sent a command
                errors_ns["near" if vehicle <= 4 else "far"].append(error_ns)
                assert abs(offset_ns) <= error_ns
    assert min(errors_ns["far"]) > _FAR_S * 1e9
    assert 0 < min(errors_ns["near"]) < min(errors_ns["far"])
    assert min(len(found) for found in errors_ns.values()) > 4
