"""How long a vehicle waits for its technology, where a scenario does not say it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.channel import Channel
    from zenvoy.scenarios.schema.scenario import Scenario

# Of wall time: what a process needs on a machine that is busy, so that few frames come too late.
_SLACK_MS: Final = 15.0


def frame_ms(channel: Channel) -> float:
    """Time of a frame on the air, ms, by the bit rate alone."""
    return channel.frame_bytes * 8 / (channel.radio.bit_rate_mbps * 1e3)


def own_wait_ms(scenario: Scenario) -> float:
    """The longest delay of the technology and the time of a frame, up to the next whole ms.

    In real time some slack is added, at most half of what is left of the period. 0, which is to
    decide on what is at hand, where not even the wait fits into a period.
    """
    channel, period_ms = scenario.channel, scenario.period_ns * 1e-6
    wait_ms = float(math.ceil(channel.radio.delay_ms[1] + frame_ms(channel)))
    if wait_ms >= period_ms:
        return 0.0
    if scenario.clock == "realtime":
        wait_ms += min(_SLACK_MS * scenario.speed, (period_ms - wait_ms) / 2)
    return wait_ms
