"""Columns of flat messages hold what protobuf reads, and any other message is left to protobuf."""

from __future__ import annotations

from itertools import combinations
from typing import Any, Final

import numpy as np
import pytest
from google.protobuf.message import DecodeError
from hypothesis import example, given
from hypothesis import strategies as st

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.flat_reading import FlatReader
from zenvoy.bus.topics import COMMAND

LONGS: Final = st.integers(-(2**63), 2**63 - 1)
FRAMES: Final = st.lists(st.tuples(st.integers(1, 40), LONGS, LONGS), max_size=3)


@st.composite
def commands(draw: st.DrawFn) -> pb.Command:
    """Draw a command with any of its fields."""
    command = pb.Command(
        cycle=draw(st.integers(0, 2**32 - 1)),
        time_ns=draw(LONGS),
        vehicle=draw(st.integers(0, 40)),
        acceleration=draw(st.floats()),
        logged=draw(st.lists(st.floats(), max_size=3)),
    )
    command.mode = draw(st.sampled_from([pb.MODE_UNSPECIFIED, pb.MODE_PBCM, pb.MODE_OWN]))
    if draw(st.booleans()):
        command.behind.gap = draw(st.floats(min_value=1.0))
    if draw(st.booleans()):
        command.timing.sensed_ns = draw(st.integers(1, 9))
        frames = draw(FRAMES)
        command.timing.source.extend(source for source, _, _ in frames)
        command.timing.came_ns.extend(came_ns for _, _, came_ns in frames)
    return command


def values(message: Any, prefix: str = "") -> dict[str, list[Any]]:
    """Return the fields that a message has, as lists, with the names that columns have."""
    found: dict[str, list[Any]] = {}
    for field, value in message.ListFields():
        name = prefix + field.name
        if field.message_type is not None:
            found |= values(value, f"{name}_")
        else:
            found[name] = list(value) if field.is_repeated else [value]
    return found


@given(st.lists(commands(), min_size=1, max_size=6))
@example([pb.Command(vehicle=3, ahead=pb.LinkEstimate())])  # a nested message without numbers
def test_columns_hold_what_protobuf_reads(given_messages: list[pb.Command]) -> None:
    payloads = [one.SerializeToString() for one in given_messages]
    found = FlatReader(pb.Command.DESCRIPTOR).read(payloads)
    has_empty = any(
        one.HasField(name) and not getattr(one, name).ByteSize()
        for one in given_messages
        for name in ("ahead", "behind", "timing")
    )
    if has_empty or not all(payloads):
        assert found is None
        return
    assert found is not None
    assert sorted(at for group in found for at in group.at.tolist()) == [*range(len(payloads))]
    for group in found:
        for at, fields in zip(group.at.tolist(), group.fields, strict=True):
            expected = values(given_messages[at])
            assert set(expected) == set(fields.dtype.names)
            for name, numbers in expected.items():
                np.testing.assert_array_equal(np.ravel(fields[name]), numbers)


@given(commands(), st.data())
def test_a_damaged_message_is_read_as_protobuf_reads_it_or_not_at_all(
    command: pb.Command, data: st.DataObject
) -> None:
    payload = command.SerializeToString()
    at, end = sorted(data.draw(st.integers(0, len(payload))) for _ in range(2))
    payload = payload[:at] + data.draw(st.binary(max_size=end - at + 2)) + payload[end:]
    found = FlatReader(pb.Command.DESCRIPTOR).read([payload])
    if found is None:
        return
    ((_, (fields,)),) = found
    expected = values(COMMAND.decode(payload))
    for name in fields.dtype.names:
        zeros = [0] * fields[name].size
        np.testing.assert_array_equal(np.ravel(fields[name]), expected.get(name, zeros))
    assert set(expected) <= set(fields.dtype.names)


@pytest.mark.parametrize(
    "payload",
    [
        pb.Command(mode=pb.MODE_OWN).SerializeToString() * 2,  # a field that comes twice
        pb.Command(cycle=1).SerializeToString() + b"\x80\x01\x00",  # an unknown field
        b"\x30\xff\x01",  # an enum of two bytes
        b"\x0d\x01\x00",  # cut
        b"\x72\x05\x1a\x00",  # a nested message that is cut
        b"\x0d" + b"\x80" * 20,
        b"\x8d\x80\x80\x80\x80\x00\x05\x00\x00\x00",  # a tag of 6 bytes, which protobuf refuses
        b"\x7a\x88\x80\x80\x80\x80\x00" + bytes(8),  # a column with such a length
        b"\x3a\x89\x80\x80\x80\x80\x00\x09" + bytes(8),  # a nested message with such a length
        pb.Command(cycle=1, logged=[1.0] * 3_000).SerializeToString(),  # too large to keep its form
        b"",
    ],
)
def test_messages_that_are_not_flat_are_left_to_protobuf(payload: bytes) -> None:
    assert FlatReader(pb.Command.DESCRIPTOR).read([payload]) is None


@pytest.mark.parametrize("more", range(10))
def test_a_padded_tag_is_read_only_where_protobuf_reads_it(more: int) -> None:
    payload = b"\x8d" + b"\x80" * more + b"\x00" + b"\x05\x00\x00\x00"
    try:
        command = pb.Command.FromString(payload)
    except DecodeError:
        command = None
    found = FlatReader(pb.Command.DESCRIPTOR).read([payload])
    assert (found is None) == (command is None)
    if found is not None and command is not None:
        assert found[0].fields["cycle"].tolist() == [command.cycle] == [5]


def test_messages_of_one_size_may_have_several_forms() -> None:
    first, second = pb.Command(time_ns=1), pb.Command(effective_ns=2)
    payloads = [one.SerializeToString() for one in (first, second, first)]
    found = FlatReader(pb.Command.DESCRIPTOR).read(payloads)
    assert found is not None
    assert [group.at.tolist() for group in found] == [[0, 2], [1]]
    assert found[0].fields["time_ns"].tolist() == [1, 1]
    assert found[1].fields["effective_ns"].tolist() == [2]


def test_a_nested_message_in_two_parts_is_read_as_one() -> None:
    """A machine whose clock is measured appends its offset to the timing of its commands."""
    first, second = pb.Command(), pb.Command()
    first.timing.sensed_ns, second.timing.clock_error_ns = 3, 4
    payload = first.SerializeToString() + second.SerializeToString()
    found = FlatReader(pb.Command.DESCRIPTOR).read([payload])
    assert found is not None
    ((_, fields),) = found
    assert fields["timing_sensed_ns"].tolist() == [3]
    assert fields["timing_clock_error_ns"].tolist() == [4]


def test_messages_in_very_many_forms_are_left_to_protobuf() -> None:
    """Each form of one size costs another look at all the messages that are left."""
    names = [field.name for field in pb.LinkEstimate.DESCRIPTOR.fields if field.name != "gap"]
    sides = [(side, name) for side in ("ahead", "behind") for name in names]
    payloads = []
    for chosen in combinations(sides, 3):
        command = pb.Command()
        for side, name in chosen:
            setattr(getattr(command, side), name, 1)
        payloads.append(command.SerializeToString())
    assert FlatReader(pb.Command.DESCRIPTOR).read(payloads) is None
    assert FlatReader(pb.Command.DESCRIPTOR).read(payloads[:3]) is not None


def test_a_message_that_is_not_flat_leaves_the_others_flat() -> None:
    payloads = [pb.Command(cycle=cycle).SerializeToString() for cycle in (1, 2, 3, 4)]
    payloads[2] += b"\xa0\x06\x01"  # an unknown field
    payloads.insert(0, b"\xa0\x06\x01\x00\x00")  # as long as the others
    found, left = FlatReader(pb.Command.DESCRIPTOR).read_most(payloads)
    assert left == [0, 3]
    ((at, fields),) = found
    assert at.tolist() == [1, 2, 4]
    assert fields["cycle"].tolist() == [1, 2, 4]


def test_very_many_sizes_become_known_over_several_reads() -> None:
    reader = FlatReader(pb.Command.DESCRIPTOR)
    payloads = [pb.Command(logged=[1.0] * n).SerializeToString() for n in range(1, 51)]
    left = [len(reader.read_most(payloads)[1]) for _ in range(4)]
    assert left == [30, 10, 0, 0]
