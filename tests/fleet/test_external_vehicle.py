"""Other programs take part as vehicles: without Zenvoy, or with `zenvoy vehicle`."""

from __future__ import annotations

import ast
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.as_child import as_child
from tests.conftest import LIMIT_S, command, wait_until, zenvoy
from tests.fleet.joining import (
    STEPPED,
    commanded,
    free_ports,
    has_happened,
    joining,
    meeting,
    running,
)
from tests.streamed_log import read_log
from zenvoy.bus import messages_pb2 as pb

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "external_vehicle" / "vehicle.py"


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
    tmp_path: Path,
) -> None:
    (tmp_path / "s.yaml").write_text(STEPPED)
    assert zenvoy(tmp_path, "run", "s.yaml", "--bus", "in-process", "--out", "alone").code == 0
    here = tuple(f"tcp/127.0.0.1:{port}" for port in free_ports())
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
