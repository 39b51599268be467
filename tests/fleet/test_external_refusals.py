"""A vehicle that does not fit a run, or does not join, is refused in one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import zenvoy
from tests.fleet.joining import STEPPED, meeting, running


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
            "--without, --listen, --router and --vehicles-per-process need processes; "
            "allowed: --engine processes",
        ),
        (
            ("--vehicles-per-process", "2", "--bus", "in-process"),
            "--without, --listen, --router and --vehicles-per-process need processes; "
            "allowed: --engine processes",
        ),
        (
            ("--listen", "127.0.0.1:7447"),
            "--listen 127.0.0.1:7447: is not tls/<host>:<port> or tcp/<host>:<port> with a "
            "port in [1, 65534]; an IPv6 address stands in brackets",
        ),
        (
            ("--listen", "tcp/127.0.0.1:65535"),
            "--listen tcp/127.0.0.1:65535: is not tls/<host>:<port> or tcp/<host>:<port> with a "
            "port in [1, 65534]; an IPv6 address stands in brackets",
        ),
        (
            ("--listen", "tcp/0.0.0.0:7447"),
            "--listen tcp/0.0.0.0:7447: lets anybody on the network in; allowed: tls/0.0.0.0 with "
            "--certs DIR, tcp/127.0.0.1, or --insecure",
        ),
        (
            ("--listen", "tls/0.0.0.0:7447"),
            "--listen tls/0.0.0.0:7447: needs --certs DIR, a folder that zenvoy certs makes",
        ),
        (
            ("--certs", "keys"),
            "--certs keys: needs an endpoint with TLS, as --listen tls/HOST:PORT",
        ),
        (
            ("--listen", "tls/0.0.0.0:27447", "--certs", "none"),
            "--certs none: has no authority.pem; zenvoy certs makes it",
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
