"""The channel process: its agent on the Zenoh bus."""

from __future__ import annotations

from zenvoy.bus.zenoh_bus import Wiring, ZenohBus
from zenvoy.channel.agent import ChannelAgent
from zenvoy.scenarios import Scenario


def run_channel(scenario: Scenario, wiring: Wiring) -> None:
    """Carry frames to the end of the run; raises BusError."""
    with ZenohBus(ChannelAgent(scenario), wiring) as bus:
        bus.run()
