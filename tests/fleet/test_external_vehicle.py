"""Other programs take part as vehicles: without Zenvoy, or with `zenvoy vehicle`."""

from __future__ import annotations

import ast
import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.as_child import as_child
from tests.conftest import (
    LIMIT_S,
    Command,
    Log,
    command,
    read_log,
    wait_until,
    zenvoy,
)
from zenvoy.bus import messages_pb2 as pb

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "external_vehicle" / "vehicle.py"
IN_CPP = os.environ.get("ZENVOY_VEHICLE_CPP")
# Far longer than any test waits.
LONG = """
duration_s: 100000
fleet: {size: 3}
control: {v2v_wait_ms: 50, system_delay_ms: 60, beacon_age_limit_ms: 500}
"""
STEPPED = """
duration_s: 20
fleet: {size: 4}
channel: {loss: {p: 0.1}}
"""


@contextmanager
def running(folder: Path, *arguments: str) -> Iterator[Command]:
    """Start a long run in real time, and wait until it has cycles. Its folder is out."""
    (folder / "long.yaml").write_text(LONG)
    options = ("--realtime", "--out", "out", *arguments)
    with command(folder, "run", "long.yaml", *options) as started:
        started.wait_for_children({"world", "channel"})
        started.wait_for_cycles(folder / "out" / "run.mcap")
        yield started


@contextmanager
def joining(folder: Path, *arguments: str) -> Iterator[Command]:
    """Start `zenvoy vehicle` in its own folder beside that of the run."""
    own = folder / "-".join(["vehicle", *arguments[1:2]])
    own.mkdir()
    with command(own, "vehicle", *arguments) as started:
        yield started


@pytest.fixture(scope="module")
def messages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the messages that protoc generates."""
    out = tmp_path_factory.mktemp("messages")
    protoc = (sys.executable, "-m", "grpc_tools.protoc", f"-I{ROOT / 'bus'}")
    subprocess.run([*protoc, f"--python_out={out}", "messages.proto"], check=True)
    return out


@contextmanager
def without_zenvoy(
    folder: Path, messages: Path, *program: str
) -> Iterator[subprocess.Popen[bytes]]:
    """Run a program as vehicle 2, without Zenvoy on its path. It ends with the context."""
    environment = {**os.environ, "PYTHONPATH": str(messages)}
    with subprocess.Popen(
        as_child(*program, "2", str(folder / "out" / "connect.json")), env=environment
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def events(log: Log) -> list[tuple[int, int, str]]:
    """Return kind, vehicle and text of the events of a run so far."""
    found = [pb.Event.FromString(message.data) for message in log.of("/events")]
    return [(event.kind, event.vehicle, event.text) for event in found]


def has_happened(folder: Path, *wanted: tuple[int, int, str]) -> bool:
    """Return whether the log of the run has all these events, in this order."""
    found = iter(events(read_log(folder / "out" / "run.mcap")))
    return all(event in found for event in wanted)


def meeting(folder: Path) -> dict[str, Any]:
    """Return the content of the run's connect.json."""
    endpoints: dict[str, Any] = json.loads((folder / "out" / "connect.json").read_text())
    return endpoints


def commanded(folder: Path, vehicle: int) -> list[pb.RealTime]:
    """Return the rows of the cycles in which the vehicle has sent a command."""
    log = read_log(folder / "out" / "run.mcap")
    rows = [pb.RealTime.FromString(message.data) for message in log.of("/realtime")]
    return [row for row in rows if row.commanded_ns[vehicle - 1] >= 0]


def test_the_example_is_short_and_does_not_import_zenvoy() -> None:
    text = EXAMPLE.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 100
    in_cpp = EXAMPLE.with_suffix(".cpp").read_text(encoding="utf-8").splitlines()
    assert len([line for line in in_cpp if line and not line.lstrip().startswith("//")]) <= 100
    tree = ast.walk(ast.parse(text))
    modules = {alias.name for node in tree if isinstance(node, ast.Import) for alias in node.names}
    assert {"zenoh", "messages_pb2"} <= modules
    assert modules - sys.stdlib_module_names == {"zenoh", "messages_pb2"}
    tree = ast.walk(ast.parse(text))
    froms = {node.module for node in tree if isinstance(node, ast.ImportFrom)}
    assert froms <= sys.stdlib_module_names


def test_a_vehicle_without_zenvoy_drives_in_a_fleet(tmp_path: Path, messages: Path) -> None:
    drives_in_a_fleet(tmp_path, messages, sys.executable, str(EXAMPLE))
    cycles = commanded(tmp_path, 2)
    assert any(2 in row.destination for row in cycles)  # it has heard the others
    for row in cycles:
        assert row.decided_ns[1] >= row.time_ns + 50_000_000  # not before v2v_wait


@pytest.mark.skipif(IN_CPP is None, reason="make external-cpp builds it")
def test_a_vehicle_in_another_language_drives_in_a_fleet(tmp_path: Path, messages: Path) -> None:
    assert IN_CPP is not None
    drives_in_a_fleet(tmp_path, messages, str(Path(IN_CPP).absolute()))


def drives_in_a_fleet(tmp_path: Path, messages: Path, *program: str) -> None:
    """Check that vehicle 2 joins, is stopped, goes on, and ends with the run."""
    with running(tmp_path, "--without", "2") as started:
        wait_until(lambda: has_happened(tmp_path, (pb.EVENT_SILENT, 2, "")), "2 is missed")
        with without_zenvoy(tmp_path, messages, *program) as example:
            joined = (
                (pb.EVENT_PROCESS_BACK, 0, "vehicle-02"),
                (pb.EVENT_SILENT_END, 2, ""),
            )
            wait_until(lambda: has_happened(tmp_path, *joined), "it has joined")
            wait_until(lambda: len(commanded(tmp_path, 2)) > 30, "it has driven for 3 s")
            example.send_signal(signal.SIGSTOP)
            stopped = (*joined, (pb.EVENT_SILENT, 2, ""))
            wait_until(lambda: has_happened(tmp_path, *stopped), "it is silent")
            example.send_signal(signal.SIGCONT)
            back = (*stopped, (pb.EVENT_SILENT_END, 2, ""))
            wait_until(lambda: has_happened(tmp_path, *back), "it goes on")
            started.send(signal.SIGTERM)
            assert started.wait().code == 130
            assert example.wait(LIMIT_S) == 0  # it has seen that the world is gone
    log = read_log(tmp_path / "out" / "run.mcap")
    assert log.whole
    modes = [pb.FleetEstimate.FromString(m.data).mode[1] for m in log.of("/fleet/estimate")]
    assert pb.MODE_FM in modes
    assert {pb.MODE_UNSPECIFIED, pb.MODE_FM} == set(modes)
    cycles = commanded(tmp_path, 2)
    assert any(2 in row.source for row in cycles)  # others have heard it
    assert not (tmp_path / "out" / "connect.json").exists()
    assert "malformed" not in (tmp_path / "out" / "logs" / "world.log").read_text()
    assert "malformed" not in (tmp_path / "out" / "logs" / "channel.log").read_text()


def test_a_vehicle_joins_in_place_of_one_that_was_killed(tmp_path: Path) -> None:
    with running(tmp_path) as started:
        started.wait_for_children({"vehicle-03"})
        started.send_to_child("vehicle-03", signal.SIGKILL)
        lost = ((pb.EVENT_PROCESS_LOST, 0, "vehicle-03"), (pb.EVENT_SILENT, 3, ""))
        wait_until(lambda: has_happened(tmp_path, *lost), "it is missed")
        endpoints = meeting(tmp_path)
        ends = ("--connect", endpoints["world"][0], "--connect", endpoints["channel"][0])
        with joining(tmp_path, "--id", "3", "--run", endpoints["run"], *ends) as joined:
            back = (
                *lost,
                (pb.EVENT_PROCESS_BACK, 0, "vehicle-03"),
                (pb.EVENT_SILENT_END, 3, ""),
            )
            wait_until(lambda: has_happened(tmp_path, *back), "it is back")
            assert joined.out == f"vehicle-03 has joined {endpoints['run']}\n"
            again = zenvoy(tmp_path, "vehicle", "--id", "3", "--run", "out")
            assert (again.code, again.err) == (2, "--id 3: vehicle-03 is in the run already\n")
            joined.send(signal.SIGINT)
            assert (joined.wait().code, joined.wait().err) == (130, "")
            gone = (*back, (pb.EVENT_PROCESS_LOST, 0, "vehicle-03"))
            wait_until(lambda: has_happened(tmp_path, *gone), "it has left")
        started.send(signal.SIGTERM)
        assert started.wait().code == 130
    last = commanded(tmp_path, 3)[-1]
    assert last.sensed_ns[2] >= last.time_ns


def test_a_vehicle_that_has_joined_ends_with_the_run(tmp_path: Path) -> None:
    with running(tmp_path, "--without", "3") as started:
        assert "vehicle-03" not in started.children()
        with joining(tmp_path, "--id", "3", "--run", str(tmp_path / "out")) as joined:
            here = (pb.EVENT_PROCESS_BACK, 0, "vehicle-03")
            wait_until(lambda: has_happened(tmp_path, here), "it has joined")
            started.send(signal.SIGTERM)
            assert started.wait().code == 130
            outcome = joined.wait()
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.endswith("the run has ended\n")


def test_in_lock_step_the_run_waits_for_a_guest_and_writes_the_same_log(
    tmp_path: Path, free_ports: tuple[int, int]
) -> None:
    (tmp_path / "s.yaml").write_text(STEPPED)
    assert zenvoy(tmp_path, "run", "s.yaml", "--bus", "in-process", "--out", "alone").code == 0
    here = tuple(f"tcp/127.0.0.1:{port}" for port in free_ports)
    patient = ("--set", f"stall_limit_s={LIMIT_S}")
    guests = ("--without", "2", "--without", "4", "--listen", here[0])
    with command(tmp_path, "run", "s.yaml", "--out", "out", *guests, *patient) as started:
        wait_until((tmp_path / "out" / "connect.json").exists, "it says where to connect to")
        endpoints = meeting(tmp_path)
        assert (endpoints["world"][1], endpoints["channel"][1]) == here
        over_tcp = ("--run", endpoints["run"], "--connect", here[0], "--connect", here[1])
        with (
            joining(tmp_path, "--id", "2", "--run", str(tmp_path / "out")) as near,
            joining(tmp_path, "--id", "4", *over_tcp) as far,
        ):
            outcome = started.wait()
            assert (outcome.code, outcome.err) == (0, "")
            assert (near.wait().code, far.wait().code) == (0, 0)
    assert "without vehicle 2; to join it: zenvoy vehicle --id 2 --run out\n" in outcome.out
    logs = [read_log(tmp_path / name / "run.mcap") for name in ("alone", "out")]
    assert logs[0].result["fingerprint"] == logs[1].result["fingerprint"]


@pytest.fixture
def free_ports() -> tuple[int, int]:
    """Return two successive ports on which nobody listens."""
    for port in range(7447, 7647, 2):
        with socket.socket() as first, socket.socket() as second:
            try:
                first.bind(("127.0.0.1", port))
                second.bind(("127.0.0.1", port + 1))
            except OSError:
                continue
        return port, port + 1
    pytest.fail("no free ports")


def test_in_lock_step_a_vehicle_that_does_not_join_is_named(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(STEPPED)
    options = ("--without", "2", "--set", "stall_limit_s=1")
    outcome = zenvoy(tmp_path, "run", "s.yaml", "--out", "out", *options)
    assert outcome.code == 3
    assert "vehicle/2/receive" in outcome.err or "vehicle-02" in outcome.err


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (("--without", "21"), "--without 21: is not in [1, 20], the vehicles of fleet.size (20)"),
        (("--without", "0"), "--without 0: is not in [1, 20], the vehicles of fleet.size (20)"),
        (
            ("--without", "2", "--bus", "in-process"),
            "--without, --listen and --vehicles-per-process need processes; "
            "allowed: --engine processes",
        ),
        (
            ("--vehicles-per-process", "2", "--bus", "in-process"),
            "--without, --listen and --vehicles-per-process need processes; "
            "allowed: --engine processes",
        ),
        (
            ("--listen", "127.0.0.1:7447"),
            "--listen 127.0.0.1:7447: is not tcp/<host>:<port> with a port in [1, 65534]; "
            "an IPv6 address stands in brackets",
        ),
        (
            ("--listen", "tcp/127.0.0.1:65535"),
            "--listen tcp/127.0.0.1:65535: is not tcp/<host>:<port> with a port in [1, 65534]; "
            "an IPv6 address stands in brackets",
        ),
    ],
)
def test_a_run_refuses_wrong_options_of_guests(
    tmp_path: Path, arguments: tuple[str, ...], line: str
) -> None:
    outcome = zenvoy(tmp_path, "run", "quickstart", "--out", "out", *arguments)
    assert (outcome.code, outcome.err) == (2, line + "\n")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (
            ("--run", "none"),
            "--run none: has no connect.json; name the folder of a run under way, or use --connect",
        ),
        (
            ("--run", "r1", "--connect", "unixsock-stream/none", "--timeout-s", "0.5"),
            "--run r1: no answer within 0.5 s from unixsock-stream/none",
        ),
        (
            ("--run", "r1", "--connect", "here"),
            "--run r1: here: no endpoint such as tcp/<host>:<port> or unixsock-stream/<path>",
        ),
    ],
)
def test_a_vehicle_without_a_run_is_refused(
    tmp_path: Path, arguments: tuple[str, ...], line: str
) -> None:
    outcome = zenvoy(tmp_path, "vehicle", "--id", "1", *arguments)
    assert (outcome.code, outcome.out, outcome.err) == (2, "", line + "\n")


def test_a_vehicle_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    with running(tmp_path, "--without", "3", "--set", "stall_limit_s=2"):
        endpoints = meeting(tmp_path)
        world = ("--connect", endpoints["world"][0])
        outcome = zenvoy(tmp_path, "vehicle", "--id", "4", "--run", "out")
        assert (outcome.code, outcome.err) == (
            2,
            "--id 4: is not in [1, 3], the vehicles of the run\n",
        )
        outcome = zenvoy(tmp_path, "vehicle", "--id", "1", "--run", endpoints["run"], *world)
        assert (outcome.code, outcome.err) == (2, "--id 1: vehicle-01 is in the run already\n")
        outcome = zenvoy(tmp_path, "vehicle", "--id", "3", "--run", endpoints["run"], *world)
        assert outcome.code == 2
        assert outcome.err.startswith("vehicle-03: no progress for 2 s, waiting for a reader of ")
        assert outcome.err.endswith(
            "/beacon; --connect needs an endpoint of the world and one of the channel\n"
        )
        outcome = zenvoy(
            tmp_path, "vehicle", "--id", "3", "--run", "another", *world, "--timeout-s", "1"
        )
        assert (outcome.code, outcome.err) == (
            2,
            f"--run another: no answer within 1 s from {endpoints['world'][0]}\n",
        )
