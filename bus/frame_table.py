"""The table of the frames of a cycle, as the channel sends it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, NamedTuple

from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.packed import PackedCodec

FRAMES_CODEC: Final = PackedCodec(pb.Frames.DESCRIPTOR)
"""Encodes and decodes a pb.Frames."""

FRAME_COLUMNS: Final = (
    "source",
    "destination",
    "sequence",
    "sent_ns",
    "arrived_ns",
    "latency_ns",
    "distance",
    "outcome",
)
"""Fields of a pb.Frames with one number per frame and receiver. `hops` has as many, or none."""


class FrameTable(NamedTuple):
    """A serialized pb.Frames, and its fields as arrays.

    Columns have a row per frame and receiver, except `cycle` and `time_ns`, which are 0-d, and
    `busy_ratio`, which is by vehicle. `busy_ratio` and `hops` may be empty.
    """

    payload: bytes
    columns: Mapping[str, NDArray[Any]]

    def __len__(self) -> int:
        return len(self.columns["source"])


def frame_table(payload: bytes) -> FrameTable:
    """Decode a serialized pb.Frames; raises ValueError if its columns do not match."""
    columns = FRAMES_CODEC.decode(payload)
    rows = len(columns["source"])
    if any(len(columns[name]) != rows for name in FRAME_COLUMNS):
        raise ValueError("columns of frames differ in length")
    if len(columns["hops"]) not in {0, rows}:
        raise ValueError(f"{len(columns['hops'])} hops of {rows} frames")
    return FrameTable(payload, columns)
