"""The default of v2v_wait_ms: how long a vehicle waits for frames of its technology."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.channel import Channel
    from zenvoy.scenarios.schema.scenario import Scenario

# Wall time that processes need on a busy machine so that few frames are late.
_SLACK_MS: Final = 15.0


def frame_ms(channel: Channel) -> float:
    """Return the time of a frame on the air, ms, from the bit rate alone."""
    return channel.frame_bytes * 8 / (channel.radio.bit_rate_mbps * 1e3)


def own_wait_ms(scenario: Scenario) -> float:
    """Return the longest delay of the technology plus the time of a frame, rounded up to whole ms.

    In real time some slack is added, at most half of the rest of the period. If the wait does not
    fit into a period, it is 0: a vehicle decides with the data that it has.
    """
    channel, period_ms = scenario.channel, scenario.period_ns * 1e-6
    wait_ms = float(math.ceil(channel.radio.delay_ms[1] + frame_ms(channel)))
    if wait_ms >= period_ms:
        return 0.0
    if scenario.clock == "realtime":
        wait_ms += min(_SLACK_MS * scenario.speed, (period_ms - wait_ms) / 2)
    return wait_ms
