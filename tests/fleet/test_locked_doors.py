"""Vehicles of other machines enter a run with a certificate over TLS."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import zenoh

from tests.conftest import LIMIT_S, command, wait_until, zenvoy
from tests.fleet.joining import STEPPED, free_ports, joining, meeting
from tests.intrusions.intruder import member
from tests.streamed_log import read_log
from zenvoy.bus.topics import CLOCK, TRUTH


@contextmanager
def reading(keys: Path, name: str, run: str, endpoint: str) -> Iterator[dict[str, list[bytes]]]:
    """Read the clock and the truth with a certificate, and try to put; yield what comes."""
    heard: dict[str, list[bytes]] = {CLOCK.name: [], TRUTH.name: []}
    with member(endpoint, keys, name) as session:
        for topic in (CLOCK, TRUTH):

            def note(sample: zenoh.Sample, at: str = topic.name) -> None:
                heard[at].append(sample.payload.to_bytes())

            others = zenoh.Locality.REMOTE
            session.declare_subscriber(topic.key(run), note, allowed_origin=others)
            session.put(topic.key(run), b"nonsense")
        yield heard


def test_a_guest_over_tls_writes_the_same_log_while_others_look_on(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(f"{STEPPED}public_truth: true\n")
    assert zenvoy(tmp_path, "run", "s.yaml", "--bus", "in-process", "--out", "alone").code == 0
    assert zenvoy(tmp_path, "certs", "keys", "--vehicles", "4").code == 0
    here = tuple(f"tls/127.0.0.1:{port}" for port in free_ports())
    patient = ("--set", f"stall_limit_s={LIMIT_S}")
    locked = ("--without", "2", "--listen", here[0], "--certs", "keys")
    with command(tmp_path, "run", "s.yaml", "--out", "out", *locked, *patient) as started:
        wait_until((tmp_path / "out" / "connect.json").exists, "it says where to connect to")
        name = meeting(tmp_path)["run"]
        over_tls = ("--run", name, "--connect", here[0], "--connect", here[1])
        certs = ("--certs", str(tmp_path / "keys"))
        with (
            reading(tmp_path / "keys", "observer", name, here[0]) as heard,
            reading(tmp_path / "keys", "vehicle-3", name, here[0]) as heard_by_vehicle,
            joining(tmp_path, "--id", "2", *over_tls, *certs) as far,
        ):
            outcome = started.wait()
            assert (outcome.code, outcome.err) == (0, "")
            assert far.wait().code == 0
    logs = [read_log(tmp_path / name / "run.mcap") for name in ("alone", "out")]
    assert logs[0].result["fingerprint"] == logs[1].result["fingerprint"]
    logged = {message.data for message in logs[1].of("/fleet/truth")}
    assert heard[TRUTH.name]  # some may be dropped
    assert heard[CLOCK.name]
    assert set(heard[TRUTH.name]) <= logged
    assert heard_by_vehicle[TRUTH.name] == []
    assert heard_by_vehicle[CLOCK.name]
    assert (tmp_path / "out" / "logs" / "channel.log").read_text() == ""  # nobody was refused
    told = (tmp_path / "out" / "logs" / "world.log").read_text()
    assert [line for line in told.splitlines() if "unauthorized" not in line] == []


def test_an_open_port_beyond_this_machine_needs_consent_and_is_warned_of(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(STEPPED)
    everywhere = f"tcp/0.0.0.0:{free_ports()[0]}"
    outcome = zenvoy(tmp_path, "run", "s.yaml", "--out", "o", "--listen", everywhere, "--insecure")
    assert outcome.code == 0
    assert outcome.err == (
        f"warning: {everywhere} is open to anybody on the network, who can read all senses and "
        "command all vehicles\n"
    )
