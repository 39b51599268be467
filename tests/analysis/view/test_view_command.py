"""`zenvoy view` serves the page of a log until it is asked to end."""

from __future__ import annotations

import http.client
import json
import re
import signal
import socket
from pathlib import Path
from urllib.parse import urlsplit

import psutil
import pytest

from tests.analysis.view.pages import address_in
from tests.conftest import command, zenvoy
from tests.logs import write_log

SCENARIO = "{duration_s: 2, fleet: {size: 4}}"


@pytest.fixture(scope="module")
def log(folder: Path) -> Path:
    return write_log(folder / "run.mcap", SCENARIO)


def get(address: str, path: str, **headers: str) -> tuple[int, bytes]:
    """Return status and body of an answer."""
    connection = http.client.HTTPConnection(urlsplit(address).netloc, timeout=30)
    try:
        connection.request("GET", path, headers=headers)
        answer = connection.getresponse()
        assert "default-src 'none'" in answer.headers["Content-Security-Policy"]
        return answer.status, answer.read()
    finally:
        connection.close()


def test_a_page_is_served_on_loopback_until_ctrl_c(tmp_path: Path, log: Path) -> None:
    with command(tmp_path, "view", str(log), "--port", "0") as viewer:
        address = address_in(viewer)
        listening = [c.laddr.ip for c in psutil.Process(viewer.pid).net_connections("tcp")]
        assert set(listening) == {"127.0.0.1"}
        status, page = get(address, "/")
        assert status == 200
        for name in re.findall(rb'(?:href|src)="(\w[\w.]*)"', page):
            assert get(address, f"/{name.decode()}")[0] == 200, name
        status, state = get(address, "/state")
        assert (status, json.loads(state)["last"]) == (200, 20)
        status, facts = get(address, "/about")
        assert (status, json.loads(facts)["vehicles"]) == (200, 4)
        assert len(get(address, "/cycles?from=0&to=20")[1]) > 20 * 4 * 8
        assert get(address, "/cycles?from=x")[0] == 400
        assert get(address, "/cycles?from=999999999999999")[0] == 400
        assert get(address, "/links?vehicles=1,x")[0] == 200
        assert get(address, "/../server.py")[0] in {403, 404}
        assert get(address, "/state", Host="evil.example")[0] == 403
        assert get(address, "/", Origin="http://evil.example")[0] == 403
        viewer.send(signal.SIGINT)
        outcome = viewer.wait()
    assert (outcome.code, outcome.err) == (0, "")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["missing.mcap"], "missing.mcap: No such file or directory"),
        (["text.mcap"], "text.mcap: not an MCAP file"),
        (["--port", "70000", "text.mcap"], "--port 70000: is not at most 65535"),
    ],
)
def test_bad_input_is_refused(tmp_path: Path, arguments: list[str], message: str) -> None:
    (tmp_path / "text.mcap").write_text("neither a log nor anything else")
    outcome = zenvoy(tmp_path, "view", *arguments)
    assert (outcome.code, outcome.out, outcome.err) == (2, "", f"{message}\n")


def test_a_port_that_is_taken_is_refused(tmp_path: Path, log: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        outcome = zenvoy(tmp_path, "view", str(log), "--port", str(port))
    expected = f"--port {port}: Address already in use\n"
    assert (outcome.code, outcome.err) == (2, expected)
