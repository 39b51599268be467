"""`zenvoy view` serves the page of a log until it is asked to end."""

from __future__ import annotations

import http.client
import json
import os
import re
import signal
import socket
from pathlib import Path
from typing import Final
from urllib.parse import urlsplit

import psutil
import pytest
from mcap.writer import MCAP0_MAGIC

from tests.analysis.view.pages import address_in
from tests.conftest import command, wait_until
from tests.logs import write_log
from zenvoy.analysis.log.load import load
from zenvoy.analysis.log.records import CUT_EARLY
from zenvoy.cli.app import app
from zenvoy.cli.usage import outcome

SCENARIO: Final = "{duration_s: 2, fleet: {size: 4}}"


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
        ended = viewer.wait()
    assert (ended.code, ended.err) == (0, "")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["missing.mcap"], "missing.mcap: No such file or directory"),
        (["text.mcap"], "text.mcap: not an MCAP file"),
        (["empty.mcap"], f"empty.mcap: {CUT_EARLY}"),
        (["head.mcap"], f"head.mcap: {CUT_EARLY}"),
        (["head.mcap", "--foxglove"], f"head.mcap: {CUT_EARLY}"),
        (["--port", "70000", "text.mcap"], "--port 70000: is not at most 65535"),
    ],
)
def test_bad_input_is_refused(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text.mcap").write_text("neither a log nor anything else")
    for name, content in (("empty.mcap", b""), ("head.mcap", MCAP0_MAGIC)):
        (tmp_path / name).write_bytes(content)
        os.utime(tmp_path / name, ns=(0, 0))  # nobody has written to it for long
    assert outcome(app, ["view", *arguments]) == 2
    assert capsys.readouterr() == ("", f"{message}\n")


def test_a_port_that_is_taken_is_refused(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert outcome(app, ["view", str(log), "--port", str(port)]) == 2
    assert capsys.readouterr() == ("", f"--port {port}: Address already in use\n")


RUN: Final = "{duration_s: 5, fleet: {size: 4}}"


def test_a_run_is_shown_and_stays_the_same(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(RUN)
    with command(tmp_path, "run", "s.yaml", "--out", "shown", "--view") as shown:
        address = address_in(shown)
        assert get(address, "/")[0] == 200  # before, while or after it runs
        wait_until(lambda: "the page stays" in shown.out, "the run has ended")
        wait_until(lambda: json.loads(get(address, "/state")[1])["whole"], "the log is read")
        state = json.loads(get(address, "/state")[1])
        assert (state["last"], state["end"]) == (50, "complete")
        shown.wait_for_children({"view"})
        shown.send_to_group(signal.SIGINT)
        ended = shown.wait()
        assert (ended.code, ended.err) == (0, "")
        assert shown.left() == []
    plain = load(write_log(tmp_path / "plain.mcap", RUN))
    assert load(tmp_path / "shown" / "run.mcap").fingerprint == plain.fingerprint


def test_the_page_dies_with_its_run(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(RUN)
    arguments = ("run", "s.yaml", "--engine", "in-process", "--out", "out", "--view")
    with command(tmp_path, *arguments) as shown:
        shown.wait_for_children({"view"})
        shown.send(signal.SIGKILL)
        shown.wait()
        assert shown.left() == []


def test_a_run_outlives_its_page(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(RUN)
    arguments = ("run", "s.yaml", "--engine", "in-process", "--out", "out", "--view")
    with command(tmp_path, *arguments) as shown:
        shown.wait_for_children({"view"})
        shown.send_to_child("view", signal.SIGKILL)
        ended = shown.wait()
    assert ended.code == 0
    assert "the page has ended" in ended.err
    assert load(tmp_path / "out" / "run.mcap").cycles == 50
