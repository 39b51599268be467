"""In real time, vehicles that share a process as arrays do what single ones do, late or not."""

from __future__ import annotations

import hashlib
import tempfile
from functools import lru_cache
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.fleet.realtime_agents.runs import MS, QUIET, of, scenario
from tests.fleet.realtime_agents.stops import (
    check_goes_on_with_the_newest_senses,
    decides,
    held_from,
)
from tests.fleet.realtime_agents.test_equal_to_lock_step import DATA, SCENARIOS
from tests.virtual_time import Delay, VirtualBus, in_lock_step
from zenvoy.bus.agent import Envelope
from zenvoy.bus.realtime_agent import RealtimeAgent
from zenvoy.bus.topics import RECEIVE
from zenvoy.bus.vehicle_processes import vehicle_processes
from zenvoy.channel.realtime import RealtimeChannel
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.arrays.suited import suited
from zenvoy.vehicles.realtime_arrays import RealtimeArrayVehicles
from zenvoy.vehicles.shared_process import RealtimeVehicles
from zenvoy.world.realtime import RealtimeWorld

Kind = type[RealtimeArrayVehicles | RealtimeVehicles]


def shared(
    of_run: Scenario, kind: Kind, per_process: int, delay: Delay = lambda *_: 0
) -> VirtualBus:
    """Return the bus of a run whose vehicles share processes of a kind, after the run."""
    placed = vehicle_processes(of_run.fleet.size, per_process)
    assert all(process.is_shared for process in placed)
    agents: list[RealtimeAgent] = [RealtimeChannel(of_run, placed), RealtimeWorld(of_run)]
    bus = VirtualBus([*agents, *(kind(of_run, process) for process in placed)], delay)
    bus.run()
    return bus


@pytest.mark.parametrize("text", SCENARIOS.values(), ids=SCENARIOS.keys())
def test_without_lateness_they_equal_lock_step_bit_for_bit(tmp_path: Path, text: str) -> None:
    of_run = scenario(tmp_path, text)
    assert suited(of_run, range(1, of_run.fleet.size + 1), ())
    bus, stepped = shared(of_run, RealtimeArrayVehicles, of_run.fleet.size), in_lock_step(of_run)
    assert bus.refused == 0
    for topic in DATA:
        assert of(topic, bus.logged) == of(topic, stepped), topic


@lru_cache
def of_text(text: str) -> Scenario:
    with tempfile.TemporaryDirectory() as folder:
        return scenario(Path(folder), text)


@settings(max_examples=25)
@given(
    text=st.sampled_from(sorted(SCENARIOS.values())),
    seed=st.integers(0, 2**32),
    most_ms=st.sampled_from([1, 8, 30, 90]),
)
def test_they_equal_single_vehicles_whatever_is_late(text: str, seed: int, most_ms: int) -> None:
    of_run = of_text(text)

    def late(envelope: Envelope, now_ns: int) -> int:
        """Delay what goes to one process at one time by the same time, as one message is.

        The commands of arrays are one message, which the world reads as one.
        """
        digest = hashlib.sha256(f"{seed} {envelope.topic.name} {now_ns}".encode()).digest()
        return int.from_bytes(digest[:4], "little") % (most_ms * MS)

    every = of_run.fleet.size
    arrays, single = (
        shared(of_run, kind, every, late) for kind in (RealtimeArrayVehicles, RealtimeVehicles)
    )
    assert arrays.logged == single.logged
    assert arrays.together > 0 == single.together


def test_a_process_that_was_stopped_goes_on_with_the_newest_senses(tmp_path: Path) -> None:
    of_run = scenario(tmp_path, QUIET.replace("BCM", "PBCM"))
    held: list[int] = []
    realtime = shared(of_run, RealtimeArrayVehicles, 2, held_from([3, 4], held)).logged
    assert len(held) > 20
    check_goes_on_with_the_newest_senses(realtime)


def test_senses_that_never_come_leave_a_gap_of_their_cycles(tmp_path: Path) -> None:
    of_run = scenario(tmp_path, QUIET.replace("BCM", "PBCM"))

    def lost(envelope: Envelope, now_ns: int) -> int | None:
        to_it = envelope.topic.name == "sense" and envelope.vehicle in {3, 4}
        return None if to_it and 1000 * MS <= now_ns < 2000 * MS else 0

    realtime = shared(of_run, RealtimeArrayVehicles, 2, lost).logged
    assert decides(realtime, 3) == [not 10 <= cycle < 20 for cycle in range(40)]


def test_frames_that_come_again_are_refused(tmp_path: Path) -> None:
    of_run = scenario(tmp_path, QUIET)
    placed = vehicle_processes(of_run.fleet.size, of_run.fleet.size)
    again: list[Envelope] = []

    class Twice(RealtimeChannel):
        """A channel whose deliveries come twice."""

        def act(self, now_ns: int) -> list[Envelope]:
            sent = super().act(now_ns)
            deliveries = [one for one in sent if one.topic is RECEIVE]
            again.extend(deliveries)
            return [*sent, *deliveries]

    agents = [RealtimeArrayVehicles(of_run, process) for process in placed]
    bus = VirtualBus([Twice(of_run, placed), RealtimeWorld(of_run), *agents])
    bus.run()
    assert bus.refused == len(again) >= of_run.cycles - 1
    assert bus.logged == shared(of_run, RealtimeArrayVehicles, of_run.fleet.size).logged
