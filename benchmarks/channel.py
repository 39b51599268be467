"""CPU time of a channel's cycle, for 40 to 1,000 vehicles, each with 20 others in range.

`python -m benchmarks.channel` prints a table for several kinds of channel.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from statistics import median
from typing import Final

import numpy as np
from rich.console import Console
from rich.table import Table

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.mailbox import Mailbox
from zenvoy.bus.topics import BEACON, POSITIONS
from zenvoy.channel.lock_step import LockStepChannel
from zenvoy.scenarios import (
    Channel,
    Fleet,
    GilbertElliott,
    Latency,
    Loss,
    Medium,
    PathLoss,
    Road,
    Scenario,
)

SIZES: Final = (40, 100, 200, 500, 1_000)
GAP_M: Final = 95.0  # ten vehicles within the kilometre of 802.11p, on either side
CYCLES: Final = 30
SETTLING: Final = 5  # cycles in which the tables of links fill
CHANNELS: Final[Mapping[str, Channel]] = {
    "802.11p as it is": Channel(),
    "bursts, gamma latency": Channel(
        loss=Loss(p=0.01, gilbert_elliott=GilbertElliott(p=0.02, r=0.3)),
        latency=Latency(distribution="gamma", mean_ms=20, std_ms=5),
    ),
    "received power": Channel(loss=Loss(path_loss=PathLoss())),
    "carrier sense": Channel(medium=Medium(access="csma")),
}


def cycle_ms(channel: Channel, vehicles: int) -> float:
    """Return the median CPU time of a cycle, ms, from the beacons to deliveries and links.

    It includes decoding the beacons, but not sending and receiving messages over Zenoh.
    """
    scenario = Scenario(
        duration_s=CYCLES * 0.1,
        road=Road(type="open"),
        fleet=Fleet(size=vehicles, gap_m=GAP_M),
        channel=channel,
    )
    agent, mailbox = LockStepChannel(scenario), Mailbox()
    start = -GAP_M * np.arange(vehicles, dtype=np.float64)
    spent = []
    for cycle in range(CYCLES):
        time_ns = cycle * scenario.period_ns
        position = pb.Positions(cycle=cycle, time_ns=time_ns, position=start + 3.0 * cycle)
        payloads = [_beacon(cycle, time_ns, vehicle) for vehicle in range(1, vehicles + 1)]
        where = position.SerializeToString()
        begin = time.process_time()
        mailbox.put(POSITIONS, 0, where)
        for vehicle, payload in enumerate(payloads, 1):
            mailbox.put(BEACON, vehicle, payload)
        barrier = agent.barrier
        assert barrier is not None
        agent.step(barrier.now_ns, mailbox.take(barrier))
        spent.append(time.process_time() - begin)
    return 1e3 * median(spent[SETTLING:])


def _beacon(cycle: int, time_ns: int, vehicle: int) -> bytes:
    beacon = pb.Beacon(cycle=cycle, time_ns=time_ns, vehicle=vehicle, sequence=cycle)
    beacon.planned_from_ns.append(time_ns)
    beacon.planned_acceleration.append(0.1)
    return beacon.SerializeToString()


def main() -> None:
    """Print the table."""
    table = Table("channel", *(f"{size} vehicles" for size in SIZES), title="CPU per cycle, ms")
    for name, channel in CHANNELS.items():
        table.add_row(name, *(f"{cycle_ms(channel, size):.1f}" for size in SIZES))
    Console().print(table)


if __name__ == "__main__":
    main()
