"""A person brakes and kills vehicles, and changes the loss, from the page of a run in real time."""

from __future__ import annotations

import http.client
import re
import signal
from pathlib import Path
from typing import Final
from urllib.parse import urlsplit

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.analysis.view.pages import address_in
from tests.conftest import Command, command, wait_until
from tests.fleet.hosts import host, serving
from tests.fleet_of_three import scenario_of
from tests.streamed_log import read_log
from zenvoy.analysis.log.load import load
from zenvoy.analysis.view.controls import NO_CONTROLS, Act, Controls
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.by_hand import Brake, Lose, ask, asked, pair
from zenvoy.bus.topics import EVENTS, POSITIONS
from zenvoy.channel.transmission import Transmission
from zenvoy.links.sent_frames import Scene
from zenvoy.scenarios import Scenario
from zenvoy.world.agent import World

SCENARIO: Final = "{duration_s: 600, clock: realtime, fleet: {size: 4}}"
HOSTS: Final = SCENARIO.replace("4", "8")


def test_requests_arrive_in_order_and_neither_end_blocks() -> None:
    asks, is_asked = pair()
    with asks, is_asked:
        assert list(asked(is_asked)) == []
        requests: list[Brake | Lose] = [Brake(3), Lose(0.35), Brake(10_000), Lose(0.0)]
        assert [ask(asks, request) for request in requests] == [True] * 4
        received = list(asked(is_asked))
        assert received == requests
        assert [type(request) for request in received] == [Brake, Lose, Brake, Lose]
        while ask(asks, Brake(2)):  # nobody reads, and at some time it is full
            pass
        assert set(asked(is_asked)) == {Brake(2)}
        is_asked.close()
        assert not ask(asks, Brake(1))


def test_only_those_who_know_the_key_may_act() -> None:
    controls = Controls(
        key="secret", acts={"brake": Act(of="vehicle", allowed=range(1, 3), do=lambda _, __: True)}
    )
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
        for envelope in world.events(cycle, None, begun.collided):
            assert envelope.topic is EVENTS
            events.append(pb.Event.FromString(envelope.payload))
    assert [(event.kind, event.vehicle, event.time_ns, event.text) for event in events] == [
        (pb.EVENT_BRAKE, 2, 200_000_000, "3 m/s², by hand"),
        (pb.EVENT_BRAKE_END, 2, 2_200_000_000, ""),
    ]
    assert speeds[22] == pytest.approx([30.0, 24.0, 30.0])
    assert speeds[39] == pytest.approx([30.0, 24.0, 30.0])  # no law drives here


def test_a_loss_by_hand_is_an_event_and_reaches_the_channel(tmp_path: Path) -> None:
    world = World(scenario_of(tmp_path, "{fleet: {size: 3}, duration_s: 10}"))
    world.begin(0)
    world.lose(0.25, 100_000_000)
    begun = world.begin(1)
    (event,) = [
        pb.Event.FromString(envelope.payload) for envelope in world.events(1, None, begun.collided)
    ]
    assert (event.kind, event.vehicle, event.time_ns) == (pb.EVENT_LOSS, 0, 100_000_000)
    assert event.text == "25 % of all frames besides, by hand"
    (where,) = [one for one in begun.messages if one.topic is POSITIONS]
    assert pb.Positions.FromString(where.payload).loss_by_hand == 0.25


@given(st.sampled_from([0.0, 0.1, 0.5, 1.0]), st.sampled_from([0.0, 0.2, 1.0]))
def test_a_loss_by_hand_is_added_to_that_of_the_scenario(by_hand: float, own: float) -> None:
    """Over 200 cycles of 90 frames the share is within four standard deviations."""
    scenario = Scenario.model_validate(
        {"fleet": {"size": 10}, "road": {"type": "open"}, "channel": {"loss": {"p": own}}}
    )
    transmission = Transmission(scenario)
    speaks = np.ones(10, dtype=np.bool_)
    lost, of = 0, 0
    for cycle in range(200):
        scene = Scene(cycle, cycle * 100_000_000, -37.5 * np.arange(10.0), None)
        outcome = transmission.of(speaks, np.full(10, cycle), scene, by_hand).outcomes.outcome
        lost, of = lost + int((outcome == pb.OUTCOME_LOST).sum()), of + len(outcome)
    share = by_hand + own - by_hand * own
    assert abs(lost / of - share) <= 4.0 * (share * (1.0 - share) / of) ** 0.5


def post(address: str, act: str, number: int, key: str) -> tuple[int, str]:
    connection = http.client.HTTPConnection(urlsplit(address).netloc, timeout=30)
    try:
        headers = {"X-Zenvoy-Key": key}
        name = "percent" if act == "lose" else "vehicle"
        connection.request("POST", f"/acts?act={act}&{name}={number}", headers=headers)
        answer = connection.getresponse()
        return answer.status, answer.read().decode()
    finally:
        connection.close()


def shown_at(command: Command) -> tuple[str, str]:
    """Return the address of a page, and the key that lets it interfere."""
    address = address_in(command)
    found = re.search(r"/#(\S+)", command.out)
    assert found is not None
    return address, found[1]


def test_a_run_in_real_time_is_braked_and_a_vehicle_killed(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(SCENARIO)
    log = tmp_path / "out" / "run.mcap"
    with command(tmp_path, "run", "s.yaml", "--out", "out", "--view") as shown:
        address, key = shown_at(shown)
        shown.wait_for_children({"view", "world", "channel", "vehicle-03"})
        shown.wait_for_cycles(log)
        assert post(address, "brake", 2, "guessed")[0] == 403
        assert [post(address, "brake", vehicle, key)[0] for vehicle in (0, 5)] == [400, 400]
        assert post(address, "brake", 2, key) == (200, "")
        assert post(address, "lose", 101, key)[0] == 400
        assert post(address, "lose", 100, key) == (200, "")
        wait_until(lambda: b"100 % of all" in b"".join(_events(log)), "the log has the loss")
        assert post(address, "lose", 0, key) == (200, "")
        wait_until(lambda: b"".join(_events(log)).count(b"0 % of all") == 2, "no loss any more")
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
    begin, end = (event.time_ns for event in load(log).events if event.kind == pb.EVENT_LOSS)
    frames = load(log).frames
    between = (frames["sent_ns"] >= begin) & (frames["sent_ns"] < end)
    assert between.any()
    assert (frames["outcome"][between] == pb.OUTCOME_LOST).all()
    assert not (frames["outcome"][frames["sent_ns"] < begin] == pb.OUTCOME_LOST).any()


def test_a_run_over_several_machines_is_shown_where_it_is_served(tmp_path: Path) -> None:
    """Its page can brake vehicles, whose processes are elsewhere, and cannot kill them."""
    log = tmp_path / "out" / "run.mcap"
    with serving(tmp_path, HOSTS, "--view") as (served, there):
        address, key = shown_at(served)
        with host(tmp_path, "alpha", "1-4", *there), host(tmp_path, "beta", "5-8", *there):
            served.wait_for_cycles(log)
            assert post(address, "kill", 3, key)[0] == 403
            assert post(address, "brake", 6, key) == (200, "")
            wait_until(lambda: b"by hand" in b"".join(_events(log)), "the log has the brake")
            served.send_to_group(signal.SIGINT)
            assert served.wait().code == 130
    brakes = [event.vehicle for event in load(log).events if event.kind == pb.EVENT_BRAKE]
    assert brakes == [6]


def _events(log: Path) -> list[bytes]:
    return [message.data for message in read_log(log).of(EVENTS.log_name)]
