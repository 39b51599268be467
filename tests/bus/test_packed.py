"""Columns are encoded and decoded as protobuf does."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from google.protobuf.message import DecodeError
from hypothesis import given, settings
from hypothesis import strategies as st

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.packed import PackedCodec

FRAMES = PackedCodec(pb.Frames.DESCRIPTOR)
TRUTH = PackedCodec(pb.FleetTruth.DESCRIPTOR)
CLOCK = PackedCodec(pb.Clock.DESCRIPTOR)

u32 = st.integers(0, 2**32 - 1)
i64 = st.integers(-(2**63), 2**63 - 1)
f64 = st.floats(allow_nan=True, allow_infinity=True)
f32 = st.floats(width=32)


@st.composite
def frames(draw: st.DrawFn) -> dict[str, Any]:
    rows = draw(st.integers(0, 40))

    def column(values: st.SearchStrategy[Any]) -> list[Any]:
        return draw(st.lists(values, min_size=rows, max_size=rows))

    return {
        "cycle": draw(u32),
        "time_ns": draw(i64),
        "source": column(u32),
        "destination": column(u32),
        "sequence": column(u32),
        "sent_ns": column(i64),
        "arrived_ns": column(i64),
        "latency_ns": column(i64),
        "distance": column(f32),
        "outcome": column(u32),
        "busy_ratio": column(f32),
        "hops": column(u32),
    }


def assert_same(values: Any, expected: Any) -> None:
    np.testing.assert_array_equal(np.asarray(values), np.asarray(expected))


@given(st.lists(st.lists(st.tuples(u32, i64), max_size=4), max_size=5))
def test_columns_of_several_messages_are_those_of_each(parts: list[list[tuple[int, int]]]) -> None:
    rows = np.array([row for part in parts for row in part], dtype=np.int64).reshape(-1, 2)
    ends = np.cumsum([len(part) for part in parts], dtype=np.int64)
    found = FRAMES.encode_each(ends, source=rows[:, 0], arrived_ns=rows[:, 1])
    alone = [
        FRAMES.encode(source=[one for one, _ in part], arrived_ns=[ns for _, ns in part])
        for part in parts
    ]
    assert list(found) == alone


@settings(deadline=None)
@given(frames())
def test_protobuf_reads_what_the_codec_encodes(values: dict[str, Any]) -> None:
    message = pb.Frames.FromString(FRAMES.encode(**values))
    for name, value in values.items():
        assert_same(getattr(message, name), value)
    # The bytes are equal where no single field is 0: protobuf leaves such a field out.
    if values["cycle"] and values["time_ns"]:
        assert FRAMES.encode(**values) == message.SerializeToString(deterministic=True)


@settings(deadline=None)
@given(frames())
def test_the_codec_decodes_what_protobuf_writes(values: dict[str, Any]) -> None:
    decoded = FRAMES.decode(pb.Frames(**values).SerializeToString())
    assert set(decoded) == set(values)
    for name, value in values.items():
        assert_same(decoded[name], value)
        assert decoded[name].ndim == (1 if isinstance(value, list) else 0)


@settings(deadline=None)
@given(u32, i64, st.lists(f64, max_size=300), st.lists(f64, max_size=3))
def test_columns_of_doubles_of_any_length(
    cycle: int, time_ns: int, position: list[float], speed: list[float]
) -> None:
    payload = TRUTH.encode(
        cycle=cycle, time_ns=time_ns, position=np.array(position), speed=np.array(speed)
    )
    message = pb.FleetTruth.FromString(payload)
    assert_same(list(message.position), position)
    decoded = TRUTH.decode(payload)
    assert_same(decoded["position"], position)
    assert_same(decoded["speed"], speed)
    assert decoded["acceleration"].shape == (0,)  # left out
    assert decoded["time_ns"] == time_ns


@settings(deadline=None)
@given(st.builds(pb.Clock, cycle=u32, time_ns=i64, wall_ns=i64, real_time_factor=f64, overruns=u32))
def test_single_fields_are_read_back(clock: pb.Clock) -> None:
    decoded = CLOCK.decode(clock.SerializeToString())
    again = pb.Clock.FromString(CLOCK.encode(**decoded))
    assert (again.cycle, again.time_ns, again.overruns) == (
        clock.cycle,
        clock.time_ns,
        clock.overruns,
    )
    factor = clock.real_time_factor
    assert again.real_time_factor == factor or math.isnan(factor)


def test_an_empty_payload_is_a_message_of_zeros() -> None:
    decoded = TRUTH.decode(b"")
    assert decoded["cycle"] == 0
    assert decoded["position"].shape == (0,)


WHOLE = TRUTH.encode(cycle=1, time_ns=5, position=[1.0, 2.0], speed=[3.0])


@given(st.integers(0, len(WHOLE)))
def test_a_cut_payload_is_refused_or_ends_between_fields(length: int) -> None:
    ends = {0, 5, 14, 14 + 18, 14 + 18 + 10}
    if length in ends:
        TRUTH.decode(WHOLE[:length])
    else:
        with pytest.raises(ValueError, match=r"is cut|ends in a number"):
            TRUTH.decode(WHOLE[:length])


def test_a_column_that_ends_within_a_number_is_refused() -> None:
    """Protobuf refuses it too: 12 bytes are no whole number of doubles."""
    payload = b"\x1a\x0c" + b"\x00" * 12
    with pytest.raises(DecodeError):
        pb.FleetTruth.FromString(payload)
    with pytest.raises(ValueError, match="position"):
        TRUTH.decode(payload)


def test_a_column_in_two_pieces_is_not_half_lost() -> None:
    """Protobuf allows it, but nobody writes it. It may be joined or refused, never truncated."""
    payload = TRUTH.encode(position=[1.0, 2.0]) + TRUTH.encode(position=[3.0])
    assert list(pb.FleetTruth.FromString(payload).position) == [1.0, 2.0, 3.0]
    try:
        position = TRUTH.decode(payload)["position"].tolist()
    except ValueError:
        return
    assert position == [1.0, 2.0, 3.0]


def test_a_field_of_another_type_is_refused() -> None:
    for payload in (
        b"\x08\x01",  # the cycle as a varint
        b"\xf8\x07\x01",  # field 127
        pb.FleetEstimate(age_ns=[1], behind_gap=[1.0]).SerializeToString(),
    ):
        with pytest.raises(ValueError, match="unknown field"):
            TRUTH.decode(payload)


@pytest.mark.parametrize("kind", [pb.Sense, pb.Command, pb.Event, pb.Receive, pb.Links])
def test_fields_of_other_than_fixed_width_are_refused(kind: Any) -> None:
    with pytest.raises(TypeError, match="is not of fixed width"):
        PackedCodec(kind.DESCRIPTOR)


@pytest.mark.parametrize("kind", [pb.FleetTruth, pb.FleetRadar, pb.FleetEstimate, pb.FleetCommand])
def test_every_fleet_message_consists_of_columns(kind: Any) -> None:
    assert set(PackedCodec(kind.DESCRIPTOR).decode(b"")) == set(kind.DESCRIPTOR.fields_by_name)


def test_one_column_is_replaced() -> None:
    values = {"cycle": 3, "source": [1, 2], "distance": [1.5, 2.5], "outcome": [1, 3]}
    payload = FRAMES.encode(**values)
    changed = FRAMES.with_column(payload, "outcome", np.array([2, 3]))
    assert changed == FRAMES.encode(**values | {"outcome": [2, 3]})
    with pytest.raises(ValueError, match="field outcome has 2 numbers, not 3"):
        FRAMES.with_column(payload, "outcome", np.array([1, 2, 3]))
    with pytest.raises(ValueError, match="field hops has 0 numbers, not 1"):
        FRAMES.with_column(payload, "hops", np.array([1]))
