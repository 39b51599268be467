"""A babbling transmitter takes up time on the air, and no more than there is."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.faults import scenario_with
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.in_process import InProcessBus
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import FRAMES, Topic
from zenvoy.channel.access import Access
from zenvoy.fleet.agents import agents_of

_CODEC: Final = PackedCodec(pb.Frames.DESCRIPTOR)
CSMA: Final = {"medium": {"access": "csma"}}


def frames(*faults: dict[str, Any], **medium: Any) -> list[dict[str, NDArray[Any]]]:
    """Return the frames of each cycle of a run of 2 s, in which faults are in force from 1 s on."""
    given = [{**fault, "vehicles": 3, "at_s": 1.0} for fault in faults]
    channel = {"medium": {"access": "csma", **medium}}
    scenario = scenario_with(given, size=6, duration_s=2.0, channel=channel)
    log: list[dict[str, NDArray[Any]]] = []

    def keep(topic: Topic[Any], _: int, payload: bytes) -> None:
        if topic is FRAMES:
            log.append(_CODEC.decode(payload))

    InProcessBus(agents_of(scenario), keep).run()
    return log


def test_the_medium_is_busy_as_long_as_the_frames_take() -> None:
    plain, babbles = frames(), frames({"type": "transmitter-babbling", "frames_per_cycle": 20})
    on_air_ns = Access(scenario_with([], channel=CSMA)).on_air_ns
    for cycle in range(20):
        more = babbles[cycle]["busy_ratio"] - plain[cycle]["busy_ratio"]
        expected = 20 * on_air_ns / 1e8 if cycle >= 10 else 0.0
        # Frames that overlap count once, and a frame may run into the next cycle.
        np.testing.assert_allclose(more, expected, atol=2.5 * on_air_ns / 1e8)


def test_nothing_changes_before_the_fault() -> None:
    plain, babbles = frames(), frames({"type": "transmitter-babbling", "frames_per_cycle": 500})
    for cycle in range(10):
        for name, column in plain[cycle].items():
            assert np.array_equal(column, babbles[cycle][name])


def test_a_medium_that_is_full_makes_beacons_wait_and_collide() -> None:
    plain, babbles = frames(), frames({"type": "transmitter-babbling", "frames_per_cycle": 5_000})
    late = np.concatenate([one["latency_ns"] for one in babbles[10:]])
    early = np.concatenate([one["latency_ns"] for one in plain[10:]])
    assert late[late >= 0].mean() > early[early >= 0].mean()
    outcomes = np.concatenate([one["outcome"] for one in babbles[10:]])
    assert pb.OUTCOME_COLLIDED in outcomes
    busy = np.concatenate([one["busy_ratio"] for one in babbles[10:]])
    assert busy.min() > 0.5
    assert busy.max() <= 1.0


def test_without_carrier_sense_it_is_refused() -> None:
    fault = {"type": "transmitter-babbling", "vehicles": 3, "at_s": 1.0, "frames_per_cycle": 9}
    with pytest.raises(ValueError, match="transmitter-babbling needs channel"):
        scenario_with([fault])
