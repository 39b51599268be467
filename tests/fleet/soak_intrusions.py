"""10,000 connections in a minute do not disturb a run in lock-step; `make soak` runs this."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from time import monotonic
from typing import Final

from tests.conftest import LIMIT_S, command, wait_until, zenvoy
from tests.fleet.joining import free_ports
from tests.intrusions.crowd import knock
from tests.streamed_log import read_log

CONNECTIONS: Final = 10_000
WITHIN_S: Final = 60.0
_AT_ONCE: Final = 50
LONG_STEPPED: Final = """
duration_s: 2400
fleet: {size: 4}
channel: {loss: {p: 0.1}}
"""


def test_ten_thousand_connections_in_a_minute_do_not_disturb_a_run(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(LONG_STEPPED)
    reference = ("--engine", "in-process", "--out", "alone")
    with command(tmp_path, "run", "s.yaml", *reference) as alone:
        assert alone.wait(20 * LIMIT_S).code == 0
    assert zenvoy(tmp_path, "certs", "keys", "--vehicles", "4").code == 0
    port = free_ports()[0]
    locked = ("--listen", f"tls/127.0.0.1:{port}", "--certs", "keys")
    with command(tmp_path, "run", "s.yaml", "--out", "out", *locked) as started:
        started.wait_for_children({"world", "channel"})
        wait_until((tmp_path / "out" / "connect.json").exists, "the doors are open")
        started.wait_for_cycles(tmp_path / "out" / "run.mcap")
        begin = monotonic()
        with ThreadPoolExecutor(_AT_ONCE) as crowd:
            share = CONNECTIONS // _AT_ONCE
            reached = sum(crowd.map(lambda _: knock(("127.0.0.1", port), share), range(_AT_ONCE)))
        lasted_s = monotonic() - begin
        during = (tmp_path / "out" / "connect.json").exists()
        outcome = started.wait(20 * LIMIT_S)
    print(f"{reached} of {CONNECTIONS} connections reached the door, in {lasted_s:.0f} s")
    assert during, "the run has ended before the crowd"
    assert (outcome.code, outcome.err) == (0, "")
    results = [read_log(tmp_path / name / "run.mcap").result for name in ("alone", "out")]
    assert results[0]["fingerprint"] == results[1]["fingerprint"]
    assert "refused: connection" in (tmp_path / "out" / "logs" / "world.log").read_text()
    assert lasted_s < WITHIN_S
    assert reached > 0.9 * CONNECTIONS
