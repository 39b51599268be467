"""A run writes its endpoints to connect.json, and guests read and check them."""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import Outcome, zenvoy
from zenvoy.bus.topics import plain_name
from zenvoy.fleet.guests import FILE, GuestsError, endpoints_of, guests, read_endpoints
from zenvoy.fleet.process_id import ProcessId

MET = endpoints_of("r1", Path("/sockets"), ["tcp/127.0.0.1:7001"])
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=8,
)


def test_endpoints_of_a_run_are_read_back(tmp_path: Path) -> None:
    MET.write(tmp_path)
    assert read_endpoints(tmp_path) == MET
    assert MET.world == ("unixsock-stream//sockets/world", "tcp/127.0.0.1:7001")
    assert MET.channel == ("unixsock-stream//sockets/channel", "tcp/127.0.0.1:7002")


def test_the_file_of_a_killed_run_is_recognised_as_stale(tmp_path: Path) -> None:
    """A later process may have the same id, but it has another start time."""
    own = ProcessId.own()
    replace(MET, command=replace(own, started=own.started - 1)).write(tmp_path)
    with pytest.raises(GuestsError, match=r"the run was killed, and has left connect.json behind"):
        read_endpoints(tmp_path)
    elsewhere = replace(MET, command=replace(own, started=1, boot="another machine's"))
    elsewhere.write(tmp_path)
    assert read_endpoints(tmp_path) == elsewhere


@pytest.mark.parametrize(
    ("written", "wrong"),
    [
        ({"world": []}, "world: Tuple should have at least 1 item"),
        ({"channel": [7]}, "channel: 0: Input should be a valid string"),
        ({"world": "tcp/a:1"}, "world: Input should be a valid array"),
        ({"run": 7}, "run: Input should be a valid string"),
        ({"run": "**"}, "run: Value error, '\\*\\*' cannot be the name of a run"),
    ],
)
def test_wrong_content_is_refused(tmp_path: Path, written: dict[str, Any], wrong: str) -> None:
    good: dict[str, Any] = {"run": "r1", "world": ["tcp/a:1"], "channel": ["tcp/a:2"]}
    (tmp_path / FILE).write_text(json.dumps(good))
    assert read_endpoints(tmp_path).run == "r1"
    (tmp_path / FILE).write_text(json.dumps(good | written))
    with pytest.raises(GuestsError, match=rf"connect\.json is not valid: {wrong}"):
        read_endpoints(tmp_path)


@pytest.mark.parametrize("text", ["", "{", "[" * 60_000, "nothing", '{"run": NaN}', "7" * 99_999])
def test_a_file_that_is_no_json_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / FILE).write_text(text)
    with pytest.raises(GuestsError, match=r"connect\.json is not valid"):
        read_endpoints(tmp_path)


@given(JSON)
def test_any_json_raises_the_same_error(
    tmp_path_factory: pytest.TempPathFactory, written: object
) -> None:
    folder = tmp_path_factory.mktemp("met")
    (folder / FILE).write_text(json.dumps(written))
    with pytest.raises(GuestsError):
        read_endpoints(folder)


def test_only_a_regular_file_is_read(tmp_path: Path) -> None:
    """A reader of a FIFO would wait forever."""
    os.mkfifo(tmp_path / FILE)
    with pytest.raises(GuestsError, match=r"has no connect.json"):
        read_endpoints(tmp_path)


@contextmanager
def free_port() -> Iterator[int]:
    """Yield a port on which nobody listens, nor on the next."""
    with socket.create_server(("127.0.0.1", 0)) as held:
        port = held.getsockname()[1]
    yield port if port < 65_534 else port - 2


@pytest.mark.parametrize(
    "endpoint",
    [
        "tcp/127.0.0.1:٧٤٤٧",
        "tcp/127.0.0.1:7447#a",
        "tcp/127.0.0.1:",
        "tcp/:7447",
        "tcp/::1:7447",
        "tcp/[::1:7447",
        "tcp/a b:7447",
        "tcp/127.0.0.1:0",
        "tcp/127.0.0.1:999999",
        "udp/127.0.0.1:7447",
        "",
    ],
)
def test_a_wrong_endpoint_is_refused(endpoint: str) -> None:
    with pytest.raises(
        GuestsError, match=r"is not tls/<host>:<port> or tcp/<host>:<port> with a port"
    ):
        guests((), [endpoint], 4)


@pytest.mark.parametrize("shift", [0, 1])
def test_overlapping_ports_are_refused(shift: int) -> None:
    """The channel listens on the next port, which may be the first port of another endpoint."""
    with free_port() as port:
        here = [f"tcp/127.0.0.1:{port}", f"tcp/127.0.0.1:{port + shift}"]
        with pytest.raises(GuestsError, match=f"port {port + shift}: Address already in use"):
            guests((), here, 4)


def refused(folder: Path, *arguments: str) -> str:
    """Return the message with which `zenvoy vehicle` refuses its input."""
    outcome: Outcome = zenvoy(folder, "vehicle", "--id", "1", *arguments)
    assert outcome.code == 2, outcome
    assert outcome.err.count("\n") == 1, outcome
    return outcome.err


@pytest.mark.parametrize("name", ["a*", "$*", "**", "", "a//b", "a#b?c", "$x", "@x", "a b", "ä"])
def test_only_a_plain_name_becomes_a_key(name: str) -> None:
    with pytest.raises(ValueError, match="cannot be the name of a run; allowed: up to 100 of"):
        plain_name(name)


def test_a_vehicle_refuses_wrong_names_and_times(tmp_path: Path) -> None:
    there = ("--connect", "tcp/127.0.0.1:1")
    assert refused(tmp_path, "--run", "**", *there).startswith(
        "--run: '**' cannot be the name of a run"
    )
    for time_s in ("1e30", "nan", "0", "-1", "inf"):
        error = refused(tmp_path, "--run", "r", "--timeout-s", time_s, *there)
        assert error == f"--timeout-s {float(time_s):g}: is not in [0.1, 86400]\n"


def test_ipv6_endpoints_work(tmp_path: Path) -> None:
    with socket.socket(socket.AF_INET6, socket.SOCK_STREAM) as six:
        try:
            six.bind(("::1", 0))
        except OSError:
            pytest.skip("this machine has no IPv6 on its loopback")
        port = min(six.getsockname()[1], 65_000)
    (tmp_path / "s.yaml").write_text("duration_s: 2\nfleet: {size: 3}")
    outcome = zenvoy(tmp_path, "run", "s.yaml", "--out", "o", "--listen", f"tcp/[::1]:{port}")
    assert (outcome.code, outcome.err) == (0, "")
