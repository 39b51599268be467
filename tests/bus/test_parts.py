"""Large payloads are sent in parts. Parts that do not fit together are refused."""

from __future__ import annotations

import struct
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus.errors import PayloadError
from zenvoy.bus.parts import MAX_PAYLOAD_BYTES, Joiner, split

sizes = st.integers(1, 4 * MAX_PAYLOAD_BYTES)


@given(sizes, sizes)
def test_interleaved_streams_are_joined_again(one: int, other: int) -> None:
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
    assert joiner.join("s", *third) is None
    pieces = list(split(bytes(range(256)) * 500))
    assert [joiner.join("s", *piece) for piece in pieces][-1] == bytes(range(256)) * 500


@given(st.integers(2, 4), st.data())
def test_pieces_of_others_in_between_change_nothing(parts: int, data: st.DataObject) -> None:
    """The other pieces include a repeat of the last piece, and pieces that stay incomplete."""
    joiner = Joiner()
    payload = bytes(range(250)) * (parts * MAX_PAYLOAD_BYTES // 250)
    old = [list(split(bytes([number]) * len(payload))) for number in range(3)]
    for piece in split(payload):
        for stray in data.draw(st.lists(st.sampled_from([pieces[0] for pieces in old]))):
            with suppress(PayloadError):
                assert joiner.join("s", *stray) is None
        joined = joiner.join("s", *piece)
        with suppress(PayloadError):
            assert joiner.join("s", *piece) is None
    assert joined == payload


def test_a_piece_that_was_changed_spoils_its_payload() -> None:
    joiner = Joiner()
    (first, attachment), second = split(bytes(2 * MAX_PAYLOAD_BYTES))
    assert joiner.join("s", first[:-1] + b"!", attachment) is None
    with pytest.raises(PayloadError, match="does not match its checksum"):
        joiner.join("s", *second)
    assert [joiner.join("s", *piece) for piece in ((first, attachment), second)][1] is not None


def test_a_piece_that_comes_again_is_refused() -> None:
    joiner = Joiner()
    first, second = split(bytes(2 * MAX_PAYLOAD_BYTES))
    joiner.join("s", *first)
    with pytest.raises(PayloadError, match="part 0 of 2 comes again"):
        joiner.join("s", *first)
    assert joiner.join("s", *second) == bytes(2 * MAX_PAYLOAD_BYTES)


def test_incomplete_payloads_are_dropped_oldest_first() -> None:
    joiner = Joiner(max_kept_bytes=10 * MAX_PAYLOAD_BYTES)
    payloads = [bytes([number]) * 2 * MAX_PAYLOAD_BYTES for number in range(50)]
    for payload in payloads:
        assert joiner.join("s", *next(split(payload))) is None
    seconds = [list(split(payload))[1] for payload in reversed(payloads)]
    joined = [joiner.join("s", *second) is not None for second in seconds]
    assert joined == [True] * 9 + [False] * 41


@pytest.mark.parametrize(
    "attachment",
    [
        b"",
        b"1234567",
        struct.pack("<II", 0, 2),
        struct.pack("<III", 3, 2, 0),
        struct.pack("<III", 0, 0, 0),
        struct.pack("<III", 0, 2**32 - 1, 0),
    ],
)
def test_an_attachment_that_makes_no_sense_is_refused(attachment: bytes) -> None:
    with pytest.raises(PayloadError):
        Joiner().join("s", b"piece", attachment)
