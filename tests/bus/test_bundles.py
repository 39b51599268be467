"""Which vehicles share a process, and how their messages are bundled."""

from __future__ import annotations

from typing import Final

import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.bundles import pack, unpack
from zenvoy.bus.errors import PayloadError
from zenvoy.bus.topics import BEACON, LINKS, SENSE
from zenvoy.bus.vehicle_processes import VehicleProcess, vehicle_processes

PARCELS: Final = st.lists(st.tuples(st.integers(1, 2**32 - 1), st.binary()), min_size=1)


def test_neighbours_share_a_process() -> None:
    assert vehicle_processes(5, 2) == (
        VehicleProcess("vehicles-01-02", (1, 2)),
        VehicleProcess("vehicles-03-04", (3, 4)),
        VehicleProcess("vehicle-05", (5,)),
    )
    assert vehicle_processes(3, 1) == tuple(
        VehicleProcess(f"vehicle-0{one}", (one,)) for one in (1, 2, 3)
    )
    assert vehicle_processes(120, 100)[1] == VehicleProcess(
        "vehicles-101-120", tuple(range(101, 121))
    )
    assert vehicle_processes(6, 3, without={2, 4, 5, 6}) == (
        VehicleProcess("vehicles-01-03", (1, 3)),
    )
    both = (VehicleProcess("vehicles-01-02", (1, 2)), VehicleProcess("vehicle-04", (4,)))
    assert vehicle_processes(4, 2, without={3}) == both


@given(
    size=st.integers(1, 300),
    per_process=st.integers(1, 400),
    without=st.sets(st.integers(1, 300), max_size=20),
)
def test_every_vehicle_is_in_one_process(size: int, per_process: int, without: set[int]) -> None:
    placed = vehicle_processes(size, per_process, without)
    assert [one for process in placed for one in process.vehicles] == [
        one for one in range(1, size + 1) if one not in without
    ]
    assert all(1 <= len(process.vehicles) <= per_process for process in placed)
    assert len({process.name for process in placed}) == len(placed)
    assert sorted(process.name for process in placed if process.is_shared) == [
        process.name for process in placed if process.is_shared
    ]


@given(PARCELS)
def test_packed_parcels_are_unpacked(parcels: list[tuple[int, bytes]]) -> None:
    assert unpack(pack(parcels)) == parcels


@given(st.binary(max_size=100))
def test_random_bytes_are_refused_by_name_or_are_parcels(rubbish: bytes) -> None:
    try:
        parcels = unpack(rubbish)
    except PayloadError:
        return
    assert unpack(pack(parcels) if parcels else b"") == parcels


def test_columns_of_a_bundle_have_equal_length() -> None:
    with pytest.raises(PayloadError, match="2 vehicles, 1 payloads"):
        unpack(pb.Bundle(vehicle=[1, 2], payload=[b"a"]).SerializeToString())
    with pytest.raises(PayloadError, match="not a bundle"):
        unpack(pack([(1, b"abc")])[:-1])


def test_keys_of_a_process() -> None:
    assert SENSE.shared_key("r1", "vehicles-01-02") == "zenvoy/r1/process/vehicles-01-02/sense"
    assert BEACON.keys("r1") == "zenvoy/r1/*/*/beacon"
    assert LINKS.keys("r1") == LINKS.key("r1")
    with pytest.raises(ValueError, match="links is not a stream of vehicles"):
        LINKS.shared_key("r1", "vehicles-01-02")
