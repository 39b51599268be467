"""A person brakes and kills vehicles of a run in real time from its page, and the log says so."""

from __future__ import annotations

import http.client
import re
import signal
from pathlib import Path
from typing import Final
from urllib.parse import urlsplit

import pytest

from tests.analysis.view.pages import address_in
from tests.conftest import command, read_log, wait_until
from tests.fleet_of_three import scenario_of
from zenvoy.analysis.log.load import load
from zenvoy.analysis.view.controls import NO_CONTROLS, Controls
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.by_hand import ask_to_brake, asked_to_brake, pair
from zenvoy.bus.topics import EVENTS
from zenvoy.world.agent import World

SCENARIO: Final = "{duration_s: 600, clock: realtime, fleet: {size: 4}}"


def test_requests_arrive_in_order_and_neither_end_blocks() -> None:
    asks, asked = pair()
    with asks, asked:
        assert list(asked_to_brake(asked)) == []
        assert [ask_to_brake(asks, vehicle) for vehicle in (3, 1, 10_000)] == [True] * 3
        assert list(asked_to_brake(asked)) == [3, 1, 10_000]
        while ask_to_brake(asks, 2):  # nobody reads, and at some time it is full
            pass
        assert set(asked_to_brake(asked)) == {2}
        asked.close()
        assert not ask_to_brake(asks, 1)


def test_only_those_who_know_the_key_may_act() -> None:
    controls = Controls(key="secret", acts={"brake": lambda _, __: True})
    assert controls.refusal("secret", "brake") is None
    assert "address" in (controls.refusal("", "brake") or "")
    assert "address" in (controls.refusal("é", "brake") or "")
    assert "kill" in (controls.refusal("secret", "kill") or "")
    assert NO_CONTROLS.refusal("", "brake") is not None


def test_a_brake_by_hand_brakes_and_is_an_event(tmp_path: Path) -> None:
    world = World(scenario_of(tmp_path, "{fleet: {size: 3}, duration_s: 10}"))
    world.begin(0)
    world.begin(1)
    world.brake(2, 200_000_000)
    events = []
    speeds = {}
    for cycle in range(2, 40):
        begun = world.begin(cycle)
        truth = next(row for row in begun.rows if row.topic.message is pb.FleetTruth)
        speeds[cycle] = pb.FleetTruth.FromString(truth.payload).speed
        for envelope in world.events(cycle, [], begun.collided):
            assert envelope.topic is EVENTS
            events.append(pb.Event.FromString(envelope.payload))
    assert [(event.kind, event.vehicle, event.time_ns, event.text) for event in events] == [
        (pb.EVENT_BRAKE, 2, 200_000_000, "3 m/s², by hand"),
        (pb.EVENT_BRAKE_END, 2, 2_200_000_000, ""),
    ]
    assert speeds[22] == pytest.approx([30.0, 24.0, 30.0])
    assert speeds[39] == pytest.approx([30.0, 24.0, 30.0])  # no law drives here


def post(address: str, act: str, vehicle: int, key: str) -> tuple[int, str]:
    connection = http.client.HTTPConnection(urlsplit(address).netloc, timeout=30)
    try:
        headers = {"X-Zenvoy-Key": key}
        connection.request("POST", f"/acts?act={act}&vehicle={vehicle}", headers=headers)
        answer = connection.getresponse()
        return answer.status, answer.read().decode()
    finally:
        connection.close()


def test_a_run_in_real_time_is_braked_and_a_vehicle_killed(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(SCENARIO)
    log = tmp_path / "out" / "run.mcap"
    with command(tmp_path, "run", "s.yaml", "--out", "out", "--view") as shown:
        address = address_in(shown)
        found = re.search(r"/#(\S+)", shown.out)
        assert found is not None
        key = found[1]
        shown.wait_for_children({"view", "world", "channel", "vehicle-03"})
        shown.wait_for_cycles(log)
        assert post(address, "brake", 2, "guessed")[0] == 403
        assert post(address, "brake", 5, key)[0] == 400
        assert post(address, "brake", 2, key) == (200, "")
        assert post(address, "kill", 3, key) == (200, "")
        wait_until(lambda: "vehicle-03" not in shown.left(0.0), "vehicle 3 has been killed")
        assert post(address, "kill", 3, key)[0] == 409
        wait_until(
            lambda: b"vehicle-03" in b"".join(_events(log)), "the log says that vehicle 3 is lost"
        )
        shown.send_to_group(signal.SIGINT)
        assert shown.wait().code == 130
        assert shown.left() == []
    events = [(event.kind, event.vehicle, event.text) for event in load(log).events]
    assert (pb.EVENT_BRAKE, 2, "3 m/s², by hand") in events
    assert (pb.EVENT_PROCESS_LOST, 0, "vehicle-03") in events


def _events(log: Path) -> list[bytes]:
    return [message.data for message in read_log(log).of(EVENTS.log_name)]
