"""The channel process: its agent on the Zenoh bus."""

from __future__ import annotations

from zenvoy.bus.memory import keep_large_blocks
from zenvoy.bus.realtime import RealtimeBus
from zenvoy.bus.wiring import Wiring
from zenvoy.bus.zenoh_bus import ZenohBus
from zenvoy.channel.lock_step import LockStepChannel
from zenvoy.channel.realtime import RealtimeChannel
from zenvoy.scenarios import Scenario


def run_channel(scenario: Scenario, wiring: Wiring) -> None:
    """Run the channel to the end of the run; in real time, until it is asked to end.

    Raises BusError.
    """
    keep_large_blocks()
    shared = wiring.shared_processes
    if scenario.clock == "realtime":
        with RealtimeBus(RealtimeChannel(scenario, shared), wiring, scenario.speed) as bus:
            bus.run()
        return
    with ZenohBus(LockStepChannel(scenario, shared), wiring) as bus:
        bus.run()
