"""Protobuf reads the flat messages that `struct` writes."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from google.protobuf.descriptor import Descriptor
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.flat import ColumnEncoder, FlatEncoder
from zenvoy.bus.flat_arrays import FlatTable

numbers = st.floats(allow_nan=False)
times = st.integers(-(2**63), 2**63 - 1)
counts = st.integers(0, 2**32 - 1)
links = st.tuples(numbers, numbers)
PLAN = (
    "planned_from_ns",
    "planned_acceleration",
    "silent",
    "commanded_acceleration",
    "odometer",
    "offset",
)


@given(counts, times, counts, links, st.tuples(numbers, numbers, numbers))
def test_a_sense_is_read_back(
    cycle: int,
    time_ns: int,
    vehicle: int,
    link: tuple[float, float],
    motion: tuple[float, float, float],
) -> None:
    encoder = FlatEncoder(pb.Sense.DESCRIPTOR, leave_out=("wall_start_ns",))
    position, speed, acceleration = motion
    payload = encoder.encode(
        cycle=cycle,
        time_ns=time_ns,
        vehicle=vehicle,
        ahead_gap=link[0],
        ahead_speed=link[1],
        position=position,
        speed=speed,
        acceleration=acceleration,
    )
    assert pb.Sense.FromString(payload) == pb.Sense(
        cycle=cycle,
        time_ns=time_ns,
        vehicle=vehicle,
        ahead=pb.Link(gap=link[0], speed=link[1]),
        position=position,
        speed=speed,
        acceleration=acceleration,
    )


def test_fields_are_given_by_name_in_any_order() -> None:
    encoder = FlatEncoder(pb.Sense.DESCRIPTOR, leave_out=("wall_start_ns",))
    values = {name: number + 1 for number, name in enumerate(encoder.names)}
    backwards = dict(reversed(values.items()))
    assert encoder.encode(**backwards) == encoder.encode(**values)
    sense = pb.Sense.FromString(encoder.encode(**backwards))
    assert (sense.ahead.gap, sense.ahead.speed) == (values["ahead_gap"], values["ahead_speed"])
    assert (sense.position, sense.speed) == (values["position"], values["speed"])


def test_a_field_that_is_missing_unknown_or_without_its_name_is_refused() -> None:
    encoder = FlatEncoder(pb.Sense.DESCRIPTOR, leave_out=("wall_start_ns",))
    values = dict.fromkeys(encoder.names, 1)
    with pytest.raises(TypeError, match="vehicle"):
        encoder.encode(**{name: 1 for name in values if name != "vehicle"})
    with pytest.raises(TypeError, match="gap"):
        encoder.encode(**values, gap=1)
    with pytest.raises(TypeError):
        encoder.encode(*values.values())
    with pytest.raises(struct.error):
        encoder.encode(**(values | {"cycle": -1}))


def of_link(name: str, *values: float) -> dict[str, float]:
    fields = pb.LinkEstimate.DESCRIPTOR.fields
    return {f"{name}_{field.name}": value for field, value in zip(fields, values, strict=True)}


@given(st.lists(numbers, min_size=17, max_size=17), st.lists(times, min_size=5, max_size=5))
def test_a_command_is_read_back(values: list[float], instants: list[int]) -> None:
    (a, *ahead), behind, own = values[:7], values[7:13], values[13:16]
    encoder = FlatEncoder(pb.Command.DESCRIPTOR, leave_out=("timing", "logged"))
    payload = encoder.encode(
        cycle=3,
        time_ns=instants[0],
        vehicle=7,
        effective_ns=instants[1],
        acceleration=a,
        mode=pb.MODE_PBCM,
        **of_link("ahead", *ahead, instants[2]),
        **of_link("behind", *behind, instants[3]),
        **dict(zip(("speed", "speed_std", "predicted_speed"), own, strict=True)),
        age_ns=instants[4],
        neighbours=2,
    )
    command = pb.Command.FromString(payload)
    assert (command.cycle, command.vehicle, command.mode) == (3, 7, pb.MODE_PBCM)
    assert (command.time_ns, command.effective_ns) == (instants[0], instants[1])
    assert command.acceleration == a
    assert _of(command.ahead) == (*ahead, instants[2])
    assert _of(command.behind) == (*behind, instants[3])
    assert [command.speed, command.speed_std, command.predicted_speed] == own
    assert (command.age_ns, command.neighbours) == (instants[4], 2)


def test_a_field_that_is_left_out_is_absent() -> None:
    encoder = FlatEncoder(pb.Beacon.DESCRIPTOR, leave_out=("ahead", *PLAN))
    payload = encoder.encode(
        cycle=1, time_ns=2, vehicle=3, sequence=4, position=5.0, speed=6.0, acceleration=7.0
    )
    beacon = pb.Beacon.FromString(payload)
    assert not beacon.HasField("ahead")
    assert beacon == pb.Beacon(
        cycle=1, time_ns=2, vehicle=3, sequence=4, position=5.0, speed=6.0, acceleration=7.0
    )


@pytest.mark.parametrize(
    "descriptor", [pb.Beacon.DESCRIPTOR, pb.Event.DESCRIPTOR, pb.Frames.DESCRIPTOR]
)
def test_a_type_that_is_not_flat_is_refused(descriptor: Descriptor) -> None:
    with pytest.raises(TypeError, match="is not a number of fixed width"):
        FlatEncoder(descriptor)


@pytest.mark.parametrize("cycle", [-1, 2**32])
def test_numbers_that_do_not_fit_are_refused(cycle: int) -> None:
    encoder = FlatEncoder(pb.Sense.DESCRIPTOR)
    with pytest.raises(struct.error):
        encoder.encode(**(dict.fromkeys(encoder.names, 1) | {"cycle": cycle}))


def _of(link: pb.LinkEstimate) -> tuple[float, ...]:
    return (
        link.gap,
        link.speed,
        link.gap_std,
        link.speed_std,
        link.predicted_gap,
        link.predicted_speed,
        link.measured_ns,
    )


@given(st.lists(times, max_size=40), st.lists(numbers, max_size=40))
def test_columns_are_read_back(instants: list[int], values: list[float]) -> None:
    planned_from = ColumnEncoder(pb.Beacon.DESCRIPTOR, "planned_from_ns")
    planned = ColumnEncoder(pb.Beacon.DESCRIPTOR, "planned_acceleration")
    plan = pb.Beacon(planned_from_ns=instants, planned_acceleration=values)
    assert planned_from.encode(instants) + planned.encode(values) == plan.SerializeToString()


@pytest.mark.parametrize("name", ["cycle", "ahead", "silent"])
def test_a_field_that_is_no_column_of_numbers_is_refused(name: str) -> None:
    with pytest.raises(TypeError, match=f"Beacon.{name} is not a column"):
        ColumnEncoder(pb.Beacon.DESCRIPTOR, name)


@given(st.lists(st.tuples(counts, times, links, numbers), min_size=1, max_size=5))
def test_a_table_writes_and_reads_what_messages_one_by_one_do(
    rows: list[tuple[int, int, tuple[float, float], float]],
) -> None:
    flat = FlatEncoder(pb.Beacon.DESCRIPTOR, leave_out=PLAN)
    planned = ColumnEncoder(pb.Beacon.DESCRIPTOR, "planned_acceleration")
    table = FlatTable([*flat.pieces, planned.piece(2)])
    same = dict.fromkeys(("sequence", "position", "acceleration"), 1)
    alone = [
        flat.encode(
            cycle=7, time_ns=time_ns, vehicle=one, speed=speed, ahead_gap=gap, ahead_speed=rate,
            **same,
        )
        + planned.encode((gap, speed))
        for one, time_ns, (gap, rate), speed in rows
    ]  # fmt: skip
    vehicle, time_ns, ahead, speed = (list(column) for column in zip(*rows, strict=True))
    gap, rate = zip(*ahead, strict=True)
    plans = list(zip(gap, speed, strict=True))
    columns = {"vehicle": vehicle, "time_ns": time_ns, "ahead_gap": gap, "ahead_speed": rate}
    columns |= {"speed": speed, "planned_acceleration": plans}
    together = table.encode(len(rows), cycle=7, **columns, **same)
    assert together == alone
    read = table.decode(together)
    assert read is not None
    for name, column in columns.items():
        assert read[name].tolist() == np.array(column).tolist()


def test_a_table_reads_no_message_of_another_form() -> None:
    flat = FlatEncoder(pb.Sense.DESCRIPTOR)
    table = FlatTable(flat.pieces)
    message = flat.encode(**dict.fromkeys(flat.names, 1))
    other_tag = bytes([message[0] ^ 8]) + message[1:]
    assert table.decode([message]) is not None
    for wrong in (message[:-1], message + b"\0", other_tag, b""):
        assert table.decode([message, wrong]) is None
