"""A chunk with a false header is refused, and no content takes gigabytes."""

from __future__ import annotations

import subprocess
import sys
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import zstandard

from tests.damaged_logs import written
from tests.log_surgery import (
    Record,
    chunk_of,
    chunks_among,
    put_together,
    record_of,
    taken_apart,
    with_data_crc,
)
from zenvoy.analysis import LogError, load


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"uncompressed_size": 1 << 63}, "unpacks to 9223372036854775808 bytes"),
        ({"uncompressed_size": 1_000}, "not to 1000 as it says"),
        ({"compression": "zst"}, "compressed with 'zst'; known: zstd, lz4"),
        ({"compression": "lz4"}, "cannot be unpacked"),
        ({"uncompressed_crc": 1}, "does not match its CRC"),
    ],
)
def test_a_chunk_with_a_false_header_is_damage(
    path: Path, content: bytes, change: dict[str, Any], says: str
) -> None:
    records = taken_apart(content)
    at = chunks_among(records)[2]
    records[at] = record_of(replace(chunk_of(records[at]), **change))
    with pytest.raises(LogError, match=says) as refused:
        load(written(path, put_together(records)))
    assert "\n" not in str(refused.value)
    assert "--salvage" in str(refused.value)


def bomb(records: list[Record], size: int, claimed: int | None) -> bytes:
    """Return a log with a chunk that unpacks to `size` zeros, and claims `claimed`."""
    compressor = zstandard.ZstdCompressor(write_content_size=claimed is None).compressobj(
        size=size if claimed is None else -1
    )
    block, parts, crc = bytes(1 << 20), [], 0
    for _ in range(size >> 20):
        parts.append(compressor.compress(block))
        crc = zlib.crc32(block, crc)
    parts.append(compressor.flush())
    at = chunks_among(records)[2]
    changed = replace(
        chunk_of(records[at]),
        data=b"".join(parts),
        uncompressed_size=size if claimed is None else claimed,
        uncompressed_crc=crc,
    )
    records = [*records[:at], record_of(changed), *records[at + 1 :]]
    return with_data_crc(put_together(records))


@pytest.mark.parametrize("claimed", [None, 1 << 20, 60 << 20])
def test_a_chunk_that_unpacks_to_gigabytes_does_not_take_that_memory(
    path: Path, content: bytes, claimed: int | None
) -> None:
    """It may state that size, a smaller one, or none."""
    log = written(path, bomb(taken_apart(content), 1 << 30, claimed))
    assert log.stat().st_size < 1_000_000
    program = """
import resource, sys
from zenvoy.analysis import LogError, load
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
try:
    load(sys.argv[1])
except LogError as error:
    print(error)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""
    done = subprocess.run(
        [sys.executable, "-c", program, str(log)],
        capture_output=True,
        text=True,
        check=True,
    )
    says, more_kib = done.stdout.splitlines()
    assert "damaged at byte" in says
    assert int(more_kib) < 200 << 10
