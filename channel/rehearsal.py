"""The channel of a scenario with a fleet at constant speed, without controllers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.mailbox import Mailbox
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import BEACON, LINKS, POSITIONS
from zenvoy.channel.lock_step import LockStepChannel
from zenvoy.scenarios import Scenario, roster

_FRAMES: Final = PackedCodec(pb.Frames.DESCRIPTOR)


def rehearse(scenario: Scenario) -> Iterator[dict[str, NDArray[Any]]]:
    """Yield the columns of /v2v/frames of each cycle, from the agent of the channel process.

    All vehicles keep the initial speed of the first one. Vehicles with beacons send one in every
    cycle.
    """
    agent, mailbox = LockStepChannel(scenario), Mailbox()
    fleet = scenario.fleet
    start = np.array(fleet.positions_at_start_m) - fleet.positions_at_start_m[0]
    silent = [not settings.beacons for settings in roster(scenario)]
    for cycle in range(scenario.cycles):
        time_ns = cycle * scenario.period_ns
        position = start + fleet.speeds_at_start_mps[0] * time_ns * 1e-9
        where = pb.Positions(cycle=cycle, time_ns=time_ns, position=position.tolist())
        mailbox.put(POSITIONS, 0, where.SerializeToString())
        for vehicle in range(1, fleet.size + 1):
            beacon = pb.Beacon(
                cycle=cycle,
                time_ns=time_ns,
                vehicle=vehicle,
                sequence=cycle,
                silent=silent[vehicle - 1],
            )
            mailbox.put(BEACON, vehicle, beacon.SerializeToString())
        while (barrier := agent.barrier) is not None and mailbox.met(barrier):
            for envelope in agent.step(barrier.now_ns, mailbox.take(barrier)):
                if envelope.topic is LINKS:
                    yield _FRAMES.decode(LINKS.decode(envelope.payload).frames)
