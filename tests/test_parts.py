"""Large payloads come through in parts; what does not fit together is refused."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus.errors import PayloadError
from zenvoy.bus.parts import MAX_PAYLOAD_BYTES, Joiner, split

sizes = st.integers(1, 4 * MAX_PAYLOAD_BYTES)


@given(sizes, sizes)
def test_interleaved_streams_come_together_again(one: int, other: int) -> None:
    payloads = {"one": bytes(i % 251 for i in range(one)), "other": bytes([7]) * other}
    joiner = Joiner()
    queues = {stream: list(split(payload)) for stream, payload in payloads.items()}
    whole: dict[str, bytes] = {}
    while any(queues.values()):
        for stream, queue in queues.items():
            if queue:
                piece, attachment = queue.pop(0)
                assert len(piece) <= MAX_PAYLOAD_BYTES
                joined = joiner.join(stream, piece, attachment)
                assert (joined is None) == bool(queue)
                if joined is not None:
                    whole[stream] = joined
    assert whole == payloads


def test_a_lost_part_spoils_its_payload_and_no_other() -> None:
    joiner = Joiner()
    first, _, third = split(bytes(3 * MAX_PAYLOAD_BYTES))
    assert joiner.join("s", *first) is None
    with pytest.raises(PayloadError, match="part 2 of 3 after 1"):
        joiner.join("s", *third)
    pieces = list(split(bytes(range(256)) * 500))
    assert [joiner.join("s", *piece) for piece in pieces][-1] == bytes(range(256)) * 500


@pytest.mark.parametrize(
    "attachment", [b"", b"1234567", struct.pack("<II", 3, 2), struct.pack("<II", 0, 0)]
)
def test_an_attachment_that_makes_no_sense_is_refused(attachment: bytes) -> None:
    with pytest.raises(PayloadError):
        Joiner().join("s", b"piece", attachment)
