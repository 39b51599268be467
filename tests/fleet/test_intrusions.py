"""Nobody gets into a run without a certificate, nor beyond what the certificate allows.

All attempts are made on one run in lock-step, over TLS: first while it waits for vehicle 2, then
while it runs. Its log has the fingerprint of a run that nobody disturbs.
"""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import pytest

from tests.as_child import as_child
from tests.conftest import LIMIT_S, command, wait_until, zenvoy
from tests.fleet.joining import STEPPED, free_ports, joining, meeting
from tests.intrusions.keys import make_keys
from tests.streamed_log import Log, read_log

ROOT: Final = Path(__file__).parents[2]
# Attempts to put, delete or show something, by the door that the log must name them at.
FORGERIES: Final = {
    ("world", "vehicle/1/command by vehicle-3."): "commands another vehicle",
    ("world", "vehicle/*/command by vehicle-3."): "commands all vehicles at once",
    ("world", "process/vehicles-01-04/command by vehicle-3."): "commands as a shared process",
    ("world", "vehicle/1/sense by vehicle-3."): "puts another's senses",
    ("channel", "vehicle/1/beacon by vehicle-3."): "beacons as another vehicle",
    ("channel", "vehicle/1/sense by vehicle-3."): "reads another's senses",
    ("world", "alive/vehicle-02 by vehicle-3."): "shows a token of somebody else's",
    ("channel", "channel/positions by vehicle-3."): "tells the channel positions",
    ("world", "channel/links by vehicle-3."): "tells the world what was received",
    ("world", "vehicle/1/command by observer."): "commands though it only looks on",
    ("world", "vehicle/1/command by channel."): "commands with the channel's certificate",
    ("channel", "vehicle/1/beacon by world."): "beacons with the world's certificate",
    ("world", "** by vehicle-3."): "reads everything at the world",
    ("channel", "** by vehicle-3."): "reads everything at the channel",
}
HANDSHAKES: Final = (
    "peer sent no certificates",
    "UnknownIssuer",
    "certificate expired",
    "not valid yet",
)


@dataclass(frozen=True, slots=True)
class Stormed:
    """What came of a run on which all attempts were made."""

    failed: dict[str, bool]  # by attempt, as far as the intruder can tell
    heard: dict[str, list[str]]  # keys of messages, by the attempt to read them
    log: Log
    undisturbed: Log
    told: dict[str, str]  # the text logs of world and channel


@pytest.fixture(scope="module")
def stormed(tmp_path_factory: pytest.TempPathFactory) -> Stormed:
    """Return what came of all attempts, made once."""
    folder = tmp_path_factory.mktemp("stormed")
    (folder / "s.yaml").write_text(STEPPED)
    make_keys(folder)
    assert zenvoy(folder, "run", "s.yaml", "--bus", "in-process", "--out", "alone").code == 0
    doors = tuple(f"tls/127.0.0.1:{port}" for port in free_ports())
    patient = ("--set", f"stall_limit_s={2 * LIMIT_S:g}")
    locked = ("--without", "2", "--listen", doors[0], "--certs", "keys")
    with command(folder, "run", "s.yaml", "--out", "out", *locked, *patient) as started:
        wait_until((folder / "out" / "connect.json").exists, "it says where to connect to")
        run = meeting(folder)["run"]
        storm = as_child(sys.executable, "-m", "tests.intrusions", str(folder), run, *doors)
        pipe = subprocess.PIPE
        with subprocess.Popen(storm, stdin=pipe, stdout=pipe, text=True, cwd=ROOT) as intruders:
            assert intruders.stdin is not None
            assert intruders.stdout is not None
            failed = json.loads(intruders.stdout.readline())
            intruders.stdin.write("send\n")
            intruders.stdin.flush()
            there = ("--run", run, "--connect", doors[0], "--connect", doors[1])
            asks = ("--certs", str(folder / "keys"), "--timeout-s", f"{LIMIT_S:g}")
            with joining(folder, "--id", "2", *there, *asks) as honest:
                outcome = started.wait(2 * LIMIT_S)
                assert (outcome.code, outcome.err) == (0, "")
                assert honest.wait().code == 0
            intruders.stdin.close()
            heard = json.loads(intruders.stdout.readline())
    logs = folder / "out" / "logs"
    told = {role: (logs / f"{role}.log").read_text() for role in ("world", "channel")}
    alone, log = (read_log(folder / name / "run.mcap") for name in ("alone", "out"))
    return Stormed(failed, heard, log, alone, told)


def test_the_run_has_the_fingerprint_of_one_that_nobody_disturbs(stormed: Stormed) -> None:
    assert stormed.log.result["fingerprint"] == stormed.undisturbed.result["fingerprint"]
    assert stormed.log.result["end"] == "complete"


def test_every_attempt_to_come_in_or_to_ask_fails(stormed: Stormed) -> None:
    assert len(stormed.failed) + len(stormed.heard) + len(FORGERIES) >= 34
    assert [what for what, failed in stormed.failed.items() if not failed] == []


def test_nobody_hears_what_is_not_meant_for_it(stormed: Stormed) -> None:
    heard = dict(stormed.heard)
    clock = heard.pop("observer: reads the clock")
    assert len(heard) >= 9
    assert clock  # to look on is allowed, and the attempts were made on a run that has begun
    assert {what: keys for what, keys in heard.items() if keys} == {}


@pytest.mark.parametrize("why", HANDSHAKES)
def test_a_refused_connection_is_told_with_its_reason(stormed: Stormed, why: str) -> None:
    assert why in stormed.told["world"]


@pytest.mark.parametrize(("door", "key"), FORGERIES, ids=list(FORGERIES.values()))
def test_what_a_certificate_does_not_allow_is_told(stormed: Stormed, door: str, key: str) -> None:
    assert f"/{key}" in stormed.told[door]


def test_no_message_of_an_intruder_has_reached_an_agent(stormed: Stormed) -> None:
    """World and channel refuse nothing themselves, since nothing has come as far as them."""
    for text in stormed.told.values():
        reasons = {line.split(": ")[2].split(",")[0] for line in lines(text, ": refused: ")}
        assert reasons <= {"unauthorized", "connection"}


def lines(text: str, part: str) -> list[str]:
    """Return the lines with a part."""
    return [line for line in text.splitlines() if part in line]
