"""A delivery has the frames of several vehicles, and each beacon once."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.deliveries import Delivery, decode
from zenvoy.bus.errors import PayloadError

HEARD: Final = st.lists(
    st.lists(st.tuples(st.integers(0, 3), st.integers(0, 2**62)), max_size=4),
    min_size=1,
    max_size=5,
)
"""For each receiver, the frames that it hears: which of four beacons, and when it arrived."""

BEACONS: Final = [b"one", b"two", b"", b"four"]
SENDERS: Final = [3, 7, 8, 1_000]


def delivery(heard: list[list[tuple[int, int]]]) -> Delivery:
    rows = [row for each in heard for row in each]
    return Delivery(
        cycle=9,
        vehicle=np.arange(len(heard)) * 2 + 1,
        time_ns=np.arange(len(heard)) + 50,
        ends=np.cumsum([len(each) for each in heard]),
        arrived_ns=np.array([arrived_ns for _, arrived_ns in rows], dtype=np.int64),
        beacon=np.array([beacon for beacon, _ in rows], dtype=np.int64),
        source=np.array(SENDERS),
        beacons=BEACONS,
    )


def receives(heard: list[list[tuple[int, int]]]) -> list[tuple[int, pb.Receive]]:
    return [
        (
            2 * at + 1,
            pb.Receive(
                cycle=9,
                time_ns=at + 50,
                vehicle=2 * at + 1,
                source=[SENDERS[beacon] for beacon, _ in each],
                arrived_ns=[arrived_ns for _, arrived_ns in each],
                beacon=[BEACONS[beacon] for beacon, _ in each],
            ),
        )
        for at, each in enumerate(heard)
    ]


def read(found: Delivery) -> list[tuple[int, pb.Receive]]:
    return [(vehicle, pb.Receive.FromString(one)) for vehicle, one in found.receives()]


@given(HEARD)
def test_a_delivery_is_a_receive_for_each_vehicle(heard: list[list[tuple[int, int]]]) -> None:
    assert read(delivery(heard)) == receives(heard)
    assert read(decode(delivery(heard).encode())) == receives(heard)


@given(HEARD, st.sets(st.integers(0, 4)))
def test_a_part_has_the_beacons_that_its_vehicles_hear(
    heard: list[list[tuple[int, int]]], chosen: set[int]
) -> None:
    some = sorted(chosen & set(range(len(heard))))
    part = delivery(heard).of(np.array(some, dtype=np.int64))
    assert read(part) == [receives(heard)[at] for at in some]
    used = {beacon for at in some for beacon, _ in heard[at]}
    assert sorted(part.source.tolist()) == [SENDERS[beacon] for beacon in sorted(used)]


@pytest.mark.parametrize(
    "change",
    [
        {"ends": np.array([2, 1])},
        {"ends": np.array([1, 3])},
        {"beacon": np.array([0, 4])},
        {"vehicle": np.array([3, 1])},
        {"vehicle": np.array([1])},
        {"arrived_ns": np.array([5])},
        {"source": np.array([3])},
        {"vehicle": np.array([], dtype=np.int64)},
    ],
)
def test_columns_that_do_not_match_are_refused(change: dict[str, Any]) -> None:
    columns = {name: getattr(delivery([[(0, 5)], [(3, 6)]]), name) for name in Delivery.__slots__}
    assert decode(Delivery(**columns).encode()).cycle == 9
    with pytest.raises(PayloadError):
        decode(Delivery(**(columns | change)).encode())


@given(st.binary(max_size=60))
def test_random_bytes_are_refused_by_name_or_are_a_delivery(rubbish: bytes) -> None:
    try:
        list(decode(rubbish).receives())
    except PayloadError:
        return
