"""A vehicle that stands still from 1 s on, and goes on at 2.56 s."""

from __future__ import annotations

from collections.abc import Collection
from typing import Final

import numpy as np
import pytest

from tests.fleet.realtime_agents.logged import fates, rows
from tests.fleet.realtime_agents.runs import MS
from tests.virtual_time import Delay, Logged
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope

_FROM_NS: Final = 1000 * MS
_BACK_NS: Final = 2560 * MS


def held_from(vehicles: Collection[int], held: list[int]) -> Delay:
    """Return a delay that holds messages to a process until it goes on, then one by one.

    `held` gets the times of these messages, ns.
    """

    def delay(envelope: Envelope, now_ns: int) -> int:
        to_it = envelope.topic.reader == "vehicle" and envelope.vehicle in vehicles
        if to_it and _FROM_NS <= now_ns < _BACK_NS:
            held.append(now_ns)
            return _BACK_NS - now_ns + len(held) * MS // 10
        return 0

    return delay


def check_goes_on_with_the_newest_senses(realtime: Logged) -> None:
    """Check that vehicle 3 sends nothing for the cycles that it missed, and estimates again."""
    sent = {sequence for source, _, sequence in fates(realtime) if source == 3}
    assert sent == {*range(10), *range(25, 40)}
    assert decides(realtime, 3) == [cycle in sent for cycle in range(40)]
    estimate = rows("/fleet/estimate", pb.FleetEstimate, realtime)[25]
    truth = rows("/fleet/truth", pb.FleetTruth, realtime)[25]
    assert estimate.speed[2] == pytest.approx(truth.speed[2], abs=3.0)
    assert estimate.mode[2] == pb.MODE_PBCM


def decides(realtime: Logged, vehicle: int) -> list[bool]:
    """Return by cycle whether a vehicle has sent a command."""
    commands = rows("/fleet/command", pb.FleetCommand, realtime)
    return [not np.isnan(row.acceleration[vehicle - 1]) for row in commands]
