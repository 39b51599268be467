"""A frame is logged as late if no receiver reports it, whatever the order of the reports."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.frame_table import FRAME_COLUMNS, FRAMES_CODEC, frame_table
from zenvoy.world.commands import CommandReader
from zenvoy.world.realtime_rows import frames_of
from zenvoy.world.timings import Timings

SIZE = 4
READER = CommandReader(0)
FRAME = st.tuples(
    st.integers(1, SIZE),  # source
    st.integers(1, SIZE),  # destination
    st.integers(0, 3),  # arrival, ns
    st.sampled_from([pb.OUTCOME_DELIVERED, pb.OUTCOME_LOST]),
)
REPORT = st.tuples(st.integers(1, SIZE), st.integers(1, SIZE), st.integers(0, 3))


def logged_outcomes(
    frames: Sequence[tuple[int, int, int, int]],
    reports: Sequence[tuple[int, int, int]],
    there: Collection[int],
) -> list[int]:
    """Return the outcomes that are logged of frames, (source, destination, arrival, outcome)."""
    source, destination, arrived_ns, outcome = np.array(frames, dtype=np.int64).reshape(-1, 4).T
    columns = dict.fromkeys(FRAME_COLUMNS, np.zeros(len(frames))) | {
        "source": source,
        "destination": destination,
        "arrived_ns": arrived_ns,
        "outcome": outcome,
    }
    payload = FRAMES_CODEC.encode(cycle=1, time_ns=0, **columns)
    timings = Timings(SIZE)
    for vehicle in range(1, SIZE + 1):
        command = pb.Command(vehicle=vehicle)
        own = [(sender, at_ns) for sender, receiver, at_ns in reports if receiver == vehicle]
        command.timing.source.extend(sender for sender, _ in own)
        command.timing.arrived_ns.extend(at_ns for _, at_ns in own)
        command.timing.came_ns.extend(0 for _ in own)
        timings.put(READER.read([command.SerializeToString()]), np.zeros(1, dtype=np.int64))
    logged = pb.Frames.FromString(frames_of(1, 0, [frame_table(payload)], timings, sorted(there)))
    return list(logged.outcome)


@given(
    frames=st.lists(FRAME, max_size=12),
    reports=st.lists(REPORT, max_size=12),
    there=st.sets(st.integers(1, SIZE)),
)
def test_delivered_frames_without_a_report_are_late(
    frames: list[tuple[int, int, int, int]],
    reports: list[tuple[int, int, int]],
    there: set[int],
) -> None:
    expected = [
        pb.OUTCOME_LATE
        if kind == pb.OUTCOME_DELIVERED and to in there and (by, to, at_ns) not in set(reports)
        else kind
        for by, to, at_ns, kind in frames
    ]
    assert logged_outcomes(frames, reports, there) == expected


def test_a_vehicle_cannot_report_the_frames_of_another() -> None:
    """Rows are compared by one number each, which times far apart must not make overflow."""
    lowest, far_ns = -(2**63), 1_000_000_000
    frames = [(2, 1, 500, pb.OUTCOME_DELIVERED), (2, 3, far_ns, pb.OUTCOME_DELIVERED)]
    forged = [(2, 3, lowest), (2, 3, lowest + 1), (2, 3, 500 - 2 * (far_ns + 1))]
    assert logged_outcomes(frames, forged, {1, 2, 3}) == [pb.OUTCOME_LATE] * 2
