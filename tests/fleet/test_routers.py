"""Runs whose processes all connect to a Zenoh router, over TLS; nobody else listens."""

from __future__ import annotations

import json
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Final

import pytest

from tests.as_child import as_child
from tests.conftest import LIMIT_S, Command, command, wait_until, zenvoy
from tests.fleet.joining import STEPPED, joining, meeting
from tests.fleet.slow_machine import hold_up
from tests.intrusions.keys import HOSTS, REVOKED, SIZE, make_keys
from tests.router import Router, locked_endpoint, router
from tests.streamed_log import read_log
from zenvoy import run
from zenvoy.bus import messages_pb2 as pb
from zenvoy.fleet.authority import make_certificates, validity_of
from zenvoy.fleet.routers import write_router

ROOT: Final = Path(__file__).parents[2]
EIGHT: Final = STEPPED.replace("size: 4", "size: 8").replace("duration_s: 20", "duration_s: 5")
# Attempts that the router must have refused: the key, and whose certificate it was.
MODES: Final = ("as a peer", "as a router")
FORGERIES: Final = (
    (r"vehicle/1/command", "vehicle-3"),
    (r"vehicle/\*/command", "vehicle-3"),
    (r"process/vehicles-01-04/command", "vehicle-3"),
    (r"vehicle/1/beacon", "vehicle-3"),
    (r"vehicle/1/sense", "vehicle-3"),
    (r"\*/\*/sense", "vehicle-3"),
    (r"alive/vehicle-02", "vehicle-3"),
    (r"alive/channel", "vehicle-3"),
    (r"channel/links", "vehicle-3"),
    (r"vehicle/4/command", "vehicle-3"),
    (r"vehicle/1/command", "observer"),
    (r"vehicle/1/command", "channel"),
    (r"vehicle/1/beacon", "world"),
)


@pytest.fixture(scope="module")
def routed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, Router]]:
    """Yield a folder with certificates of eight vehicles, and a router that lets them in."""
    folder, endpoint = tmp_path_factory.mktemp("routed"), locked_endpoint()
    groups = ("--group", "1-4", "--group", "5-8")
    opened = ("--router", endpoint, "--vehicles-per-process", "4")
    assert zenvoy(folder, "certs", "keys", "--vehicles", "8", *groups, *opened).code == 0
    with router(folder, folder / "keys" / "router.json5", endpoint) as started:
        yield folder, started


@contextmanager
def serving(routed: tuple[Path, Router], name: str, *options: str) -> Iterator[Command]:
    """Serve a run in a folder of its own, through the router."""
    folder, door = routed
    (folder / name).mkdir()
    (folder / name / "s.yaml").write_text(EIGHT)
    through = ("--router", door.endpoint, "--certs", str(folder / "keys"), "--out", "out")
    with command(folder / name, "serve", "s.yaml", *through, *options) as started:
        wait_until((folder / name / "out" / "connect.json").exists, f"{name} is there")
        yield started


@contextmanager
def host(routed: tuple[Path, Router], name: str, vehicles: str, *options: str) -> Iterator[Command]:
    """Join a run through the router with some vehicles."""
    folder, door = routed
    (folder / name).mkdir()
    through = ("--router", door.endpoint, "--certs", str(folder / "keys"), "--out", "out")
    patient = ("--timeout-s", f"{LIMIT_S:g}")
    with command(
        folder / name, "join", "--vehicles", vehicles, *through, *patient, *options
    ) as started:
        yield started


def test_two_runs_at_once_do_not_see_each_other(routed: tuple[Path, Router]) -> None:
    folder, _ = routed
    (folder / "s.yaml").write_text(EIGHT)
    alone = [run(folder / "s.yaml", seed=seed, engine="in-process").fingerprint for seed in (1, 2)]
    with ExitStack() as stack:
        first = stack.enter_context(serving(routed, "first", "--vehicles-per-process", "4"))
        hosts = [stack.enter_context(host(routed, "alpha", "1-4"))]  # there is only one run
        wait_until(lambda: "missing: vehicles 5-8\n" in first.out, "it says who is missing")
        second = stack.enter_context(serving(routed, "second", "--seed", "2"))
        wait_until(lambda: "to join, on any machine" in second.out, "the second waits, too")
        with host(routed, "unsure", "5-8") as unsure:
            outcome = unsure.wait()
        names = [meeting(folder / name)["run"] for name in ("first", "second")]
        assert outcome.code == 2
        assert outcome.err == (
            "--run: is needed, because there are 2 runs, with the vehicles there: "
            f"{names[0]} (4 of 8 vehicles), {names[1]} (0 of 8 vehicles)\n"
        )
        for name, vehicles in ((names[1], "1-4"), (names[1], "5-8"), (names[0], "5-8")):
            one = host(routed, f"h{len(hosts)}", vehicles, "--run", name)
            hosts.append(stack.enter_context(one))
        for served in (first, second):
            outcome = served.wait(2 * LIMIT_S)
            assert (outcome.code, outcome.err) == (0, "")
        assert [one.wait().code for one in hosts] == [0, 0, 0, 0]
    for name, fingerprint in zip(("first", "second"), alone, strict=True):
        log = read_log(folder / name / "out" / "run.mcap")
        assert log.result["fingerprint"] == fingerprint
        for role in ("world", "channel"):  # nothing of the other run has come
            assert (folder / name / "out" / "logs" / f"{role}.log").read_text() == ""


def test_a_run_in_real_time_of_several_machines_goes_through_a_router(
    routed: tuple[Path, Router],
) -> None:
    folder, _ = routed
    with (
        serving(routed, "live", "--realtime", "--vehicles-per-process", "4") as served,
        host(routed, "gamma", "1-4") as one,
        host(routed, "delta", "5-8") as other,
    ):
        outcome = served.wait()
        assert (outcome.code, outcome.err) == (0, "")
        assert (one.wait().code, other.wait().code) == (0, 0)
    log = read_log(folder / "live" / "out" / "run.mcap")
    assert log.result["end"] == "complete"
    rows = [pb.RealTime.FromString(message.data) for message in log.of("/realtime")]
    offsets_ns = [offset_ns for row in rows for offset_ns in row.clock_offset_ns]
    errors_ns = [error_ns for row in rows for error_ns in row.clock_error_ns]
    measured = [one for one in zip(offsets_ns, errors_ns, strict=True) if one[1] >= 0]
    assert len(measured) > len(errors_ns) / 2
    assert all(abs(offset_ns) <= error_ns for offset_ns, error_ns in measured)  # it is one clock


def test_a_slow_machine_behind_a_router_is_named(routed: tuple[Path, Router]) -> None:
    folder, _ = routed
    patient = ("--duration-s", "100000", "--set", f"stall_limit_s={2 * LIMIT_S:g}")
    with (
        serving(routed, "held", *patient, "--vehicles-per-process", "4") as served,
        host(routed, "epsilon", "1-4"),
        host(routed, "zeta", "5-8", "--host", "zeta") as slow,
    ):
        log = folder / "held" / "out" / "run.mcap"
        served.wait_for_cycles(log)
        hold_up(slow, "zeta", served, log)
        assert "vehicles 5-8 on zeta held up" in served.out
        served.send(signal.SIGINT)
        assert served.wait().code == 130


def test_a_router_keeps_intruders_out(tmp_path: Path) -> None:
    """The same attempts as on a run with doors of its own, and those of peers and routers."""
    (tmp_path / "s.yaml").write_text(STEPPED)
    make_keys(tmp_path)
    alone = run(tmp_path / "s.yaml", engine="in-process").fingerprint
    endpoint = locked_endpoint()
    renew_revoked(tmp_path / "keys", tmp_path / "renewed")
    config = write_router(tmp_path / "renewed", endpoint, SIZE, 1)
    patient = ("--set", f"stall_limit_s={2 * LIMIT_S:g}")
    through = ("--router", endpoint, "--certs")
    out = ("--out", "out", "--without", "2", *patient)
    with (
        router(tmp_path, config, endpoint, tells_refusals=True) as door,
        command(tmp_path, "run", "s.yaml", *out, *through, "renewed") as started,
    ):
        wait_until((tmp_path / "out" / "connect.json").exists, "it says where to connect to")
        name = meeting(tmp_path)["run"]
        storm = as_child(
            sys.executable, "-m", "tests.intrusions", str(tmp_path), name, endpoint, endpoint
        )
        pipe = subprocess.PIPE
        with subprocess.Popen(storm, stdin=pipe, stdout=pipe, text=True, cwd=ROOT) as intruders:
            assert intruders.stdin is not None
            assert intruders.stdout is not None
            failed = json.loads(intruders.stdout.readline())
            intruders.stdin.write("send\n")
            intruders.stdin.flush()
            there = ("--run", name, *through, str(tmp_path / "keys"), "--timeout-s", f"{LIMIT_S:g}")
            with joining(tmp_path, "--id", "2", *there) as honest:
                outcome = started.wait(2 * LIMIT_S)
                assert (outcome.code, outcome.err) == (0, "")
                assert honest.wait().code == 0
            intruders.stdin.close()
            heard = json.loads(intruders.stdout.readline())
        told = door.log.read_text(errors="replace")
    assert read_log(tmp_path / "out" / "run.mcap").result["fingerprint"] == alone
    assert len(failed) + len(heard) + len(FORGERIES) >= 34
    # A router's rules are for any run, and a vehicle may ask a run that it may enter.
    answered = {f"{as_what}: asks for any scenario" for as_what in ("router", *MODES)}
    assert {what for what, has_failed in failed.items() if not has_failed} == answered
    assert heard.pop("observer: reads the clock")  # as it may
    assert {what: keys for what, keys in heard.items() if keys} == {}
    for key, who in FORGERIES:
        forged = rf"\({who}\.\w+\).* is unauthorized to .*\(ingress\) on zenvoy/{name}/{key}\b"
        assert re.search(forged, told), (key, who)
    for why in ("peer sent no certificates", "UnknownIssuer", "certificate expired"):
        assert why in told


def renew_revoked(keys: Path, renewed: Path) -> None:
    """Copy certificates, with a proper one for the vehicle of the run whose own was revoked."""
    shutil.copytree(keys, renewed)
    for suffix in ("pem", "key"):
        (renewed / f"{REVOKED}.{suffix}").unlink()
    make_certificates(renewed, [REVOKED], HOSTS, validity_of(2))
