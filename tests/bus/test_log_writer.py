"""The log writer keeps a small index of chunks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mcap.reader import make_reader

from zenvoy.bus.log_writer import LogWriter


def test_the_index_of_chunks_takes_little_memory_and_is_written_unchanged(
    tmp_path: Path,
) -> None:
    file = tmp_path / "many.mcap"
    chunks_written = 1_000
    with file.open("wb") as stream:
        writer: Any = LogWriter(stream)
        writer.start()
        schema = writer.register_schema("x", "", b"")
        channels = [writer.register_channel(f"/{name}", "", schema) for name in "abcdefg"]
        for number in range(chunks_written):
            for channel in channels:
                writer.add_message(channel, 1 + number, b"x" * (number % 90), 1 + number)
            writer.flush()
        kept = writer._Writer__chunk_indices.nbytes
        writer.finish()
    assert kept < 100 * chunks_written
    with file.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert len(summary.chunk_indexes) == chunks_written
        for index in summary.chunk_indexes[::97]:
            assert len(index.message_index_offsets) == len(channels)
        times = [message.log_time for _, _, message in reader.iter_messages()]
    assert times == sorted(times)
    assert len(times) == len(channels) * chunks_written
