"""Frames are delivered by destination, then arrival, then number, however far apart they arrive."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus import messages_pb2 as pb
from zenvoy.channel.delivery import Air

SIZE = 4
ARRIVALS_NS = st.one_of(st.integers(-1, 5), st.just(2**62))
FRAME = st.tuples(st.integers(0, SIZE - 1), st.integers(0, SIZE - 1), ARRIVALS_NS)
CYCLES = st.lists(st.tuples(st.lists(FRAME, max_size=8), st.integers(0, 6)), max_size=4)


@given(CYCLES)
def test_frames_are_delivered_once_in_order_of_arrival(
    cycles: list[tuple[list[tuple[int, int, int]], int]],
) -> None:
    air, flying = Air(SIZE), list[tuple[int, int, int, bytes]]()
    vehicles = range(1, SIZE + 1)
    for cycle, (frames, until_ns) in enumerate([*cycles, ([], 2**62)]):
        payloads = {vehicle: b"%d of %d" % (cycle, vehicle) for vehicle in vehicles}
        table = np.array(frames, dtype=np.int64).reshape(-1, 3)
        air.send(payloads, *table.T)
        flying += [
            (to + 1, at_ns, cycle * SIZE + by, payloads[by + 1])
            for by, to, at_ns in frames
            if at_ns >= 0
        ]
        assert air.next_ns == min((at_ns for _, at_ns, *_ in flying), default=None)
        due = sorted(frame for frame in flying if frame[1] <= until_ns)
        flying = [frame for frame in flying if frame[1] > until_ns]
        for envelope in air.deliver(cycle, until_ns, vehicles):
            receive = pb.Receive.FromString(envelope.payload)
            expected = [frame for frame in due if frame[0] == envelope.vehicle]
            assert list(receive.arrived_ns) == [at_ns for _, at_ns, *_ in expected]
            assert list(receive.beacon) == [beacon for *_, beacon in expected]
