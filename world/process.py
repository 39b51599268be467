"""The world process: its agent on the Zenoh bus, with the recorder beside it."""

from __future__ import annotations

import socket
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

import zenoh

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.by_hand import Brake, asked
from zenvoy.bus.clock import wall_ns
from zenvoy.bus.errors import StalledError, StoppedError, VehicleLostError
from zenvoy.bus.far_clock import offer_clock
from zenvoy.bus.joining import OnArrival, offer
from zenvoy.bus.memory import give_back_large_blocks, keep_large_blocks
from zenvoy.bus.realtime import RealtimeBus
from zenvoy.bus.topics import CLOCK, EVENTS, vehicle_name
from zenvoy.bus.wiring import Wiring
from zenvoy.bus.zenoh_bus import ZenohBus
from zenvoy.scenarios import Scenario
from zenvoy.values.wording import spans
from zenvoy.world.lock_step import LockStepWorld
from zenvoy.world.pace import HeldUp
from zenvoy.world.realtime import RealtimeWorld
from zenvoy.world.recorder import Labels, Recorder

_STEPS_BETWEEN: Final = 20  # between words on who holds up the run

_LARGE_FLEET: Final = 250  # vehicles; their frames fill megabytes in every cycle


def run_world(
    scenario: Scenario,
    labels: Labels,
    path: Path,
    wiring: Wiring,
    on_clock: Callable[[pb.Clock], None],
    on_arrival: OnArrival,
    on_held_up: Callable[[str], None],
    by_hand: socket.socket | None = None,
) -> None:
    """Run the world and log to the end of the run; raises BusError, or OSError for a full disk.

    `on_clock`, `on_arrival` and `on_held_up` tell the caller of its progress, of processes that
    come and go, and now and then of a machine that holds up the run ("": none). In real time,
    requests of a person come through `by_hand`.
    The log at `path` is finished properly in any case, if possible, and says how the run ended.
    """
    if scenario.fleet.size < _LARGE_FLEET:
        give_back_large_blocks()
    else:
        keep_large_blocks()
    with Recorder(path, labels, wall_ns) as recorder:
        bus, run_to_end = _world_on_bus(scenario, wiring, recorder, by_hand)
        reported = ""

        def tick(clock: pb.Clock) -> None:
            nonlocal reported
            bus.publish(CLOCK, clock.SerializeToString())
            on_clock(clock)
            if clock.cycle % _STEPS_BETWEEN == 0:
                before, reported = reported, recorder.held_up(clock.wall_ns)
                if reported != before:
                    on_held_up(reported)

        recorder.on_clock = tick
        bus.on_idle = recorder.flush_if_due
        effective = labels.effective_json.encode()
        offered: list[object] = []

        def on_open(session: zenoh.Session) -> None:
            state = (wiring.run, len(wiring.vehicles), wiring.shared_processes)
            offered.extend(offer(session, *state, lambda: effective, on_arrival))
            if scenario.clock == "realtime":
                offered.append(offer_clock(session, wiring.run))

        bus.on_open = on_open
        try:
            with bus:
                try:
                    run_to_end()
                except StoppedError:  # the open session still knows which are lost
                    _end(recorder, bus.lost_processes())
                    raise
                recorder.close()  # before the session, which may wait for a frozen peer
        except StoppedError:
            if recorder.end != "stopped":  # stopped before the first cycle
                _end(recorder, [])
            raise


def _world_on_bus(
    scenario: Scenario, wiring: Wiring, recorder: Recorder, by_hand: socket.socket | None
) -> tuple[ZenohBus | RealtimeBus, Callable[[], None]]:
    """Return the bus with the world for the scenario's clock, and a function that runs it."""
    if scenario.clock == "realtime":
        world = RealtimeWorld(scenario)
        live = RealtimeBus(world, wiring, scenario.speed, recorder.log)
        recorder.overruns = lambda: world.overruns
        absent = wiring.absent
        return live, lambda: _run_in_real_time(live, world, recorder, scenario, absent, by_hand)
    stepped = LockStepWorld(scenario)
    bus = ZenohBus(stepped, wiring, recorder.log)
    recorder.held_up = lambda wall_ns: _in_words(stepped.pace.slowest(wall_ns), bus.hosts)

    def run_to_end() -> None:
        recorder.start_clock()
        bus.run()

    return bus, run_to_end


def _in_words(held_up: HeldUp | None, hosts: Mapping[int, str]) -> str:
    """Return which vehicles held up the steps; hosts: the machine of each vehicle."""
    if held_up is None:
        return ""
    host, share, by_ns = held_up
    vehicles = spans(sorted(vehicle for vehicle, its in hosts.items() if its == host))
    whom = f"vehicles {vehicles} on {host}"
    return f"{whom} held up {100 * share:.3g} % of the steps, by {by_ns * 1e-6:,.0f} ms each"


def _run_in_real_time(
    bus: RealtimeBus,
    world: RealtimeWorld,
    recorder: Recorder,
    scenario: Scenario,
    absent: frozenset[int],
    by_hand: socket.socket | None,
) -> None:
    """Run to the end in real time, and log processes that are lost or come back as events."""
    start_ns = bus.start()
    world.start(start_ns)
    recorder.start_clock(start_ns)
    lost = {vehicle_name(vehicle, scenario.fleet.size) for vehicle in absent}
    stall_ns = round(scenario.stall_limit_s * 1e9 * scenario.speed)

    def notice() -> None:
        recorder.flush_if_due()  # a slow clock may have a second between cycles
        _look_at_channel(world, stall_ns)
        if by_hand is not None:
            for request in asked(by_hand):
                if isinstance(request, Brake):
                    world.brake(request.vehicle)
                else:
                    world.lose(request.share)
        for name, there in bus.comings_and_goings():
            if there != (name in lost):
                continue  # it joins for the first time
            lost.symmetric_difference_update({name})
            kind = pb.EVENT_PROCESS_BACK if there else pb.EVENT_PROCESS_LOST
            now_ns = bus.now_ns
            event = pb.Event(
                cycle=now_ns // scenario.period_ns, time_ns=now_ns, kind=kind, text=name
            )
            recorder.log(EVENTS, now_ns, event.SerializeToString())

    bus.run(notice)
    if world.lost:
        raise VehicleLostError(world.lost, recorder.time_ns * 1e-9)
    # If vehicles have not heard each other for longer than beacons count, the run is incomplete.
    _look_at_channel(world, scenario.beacon_age_limit_ns)


def _look_at_channel(world: RealtimeWorld, limit_ns: int) -> None:
    """Raise StalledError if the channel has been silent for longer than `limit_ns`."""
    if world.channel_silent_ns > limit_ns:
        silent_s = world.channel_silent_ns * 1e-9
        raise StalledError(f"no frames for the last {silent_s:.1f} s of the run", ("channel",))


def _end(recorder: Recorder, lost: list[str]) -> None:
    """Log the last events of a run that was asked to end."""
    recorder.end = "stopped"
    time_ns = recorder.time_ns
    events = [pb.Event(time_ns=time_ns, kind=pb.EVENT_PROCESS_LOST, text=name) for name in lost]
    events.append(pb.Event(time_ns=time_ns, kind=pb.EVENT_STOPPED, text="asked to end"))
    for event in events:
        recorder.log(EVENTS, time_ns, event.SerializeToString())
