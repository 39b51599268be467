"""A log is read while it is written: it may end inside a record, and grow before the next read."""

from __future__ import annotations

from io import BytesIO, RawIOBase
from pathlib import Path
from typing import TYPE_CHECKING

from tests.streamed_log import read_log, read_stream
from zenvoy import run, scenario

if TYPE_CHECKING:
    from _typeshed import WriteableBuffer


class Growing(RawIOBase):
    """A file that ends inside a record for one read, and is whole afterwards."""

    def __init__(self, content: bytes, end: int) -> None:
        super().__init__()
        self._parts = [BytesIO(content[:end]), BytesIO(), BytesIO(content[end:])]

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: WriteableBuffer, /) -> int:
        taken = self._parts[0].readinto(buffer)
        if not taken and len(self._parts) > 1:
            self._parts.pop(0)
        return taken


def test_a_log_that_grows_while_it_is_read_is_read_up_to_its_end_then(tmp_path: Path) -> None:
    short = scenario("quickstart", duration_s=1.0, fleet={"size": 6})
    log = run(short, engine="in-process", out=tmp_path / "out").log
    messages, content = read_log(log).messages, log.read_bytes()
    found = []
    for end in range(1_000, len(content), 7):
        part = read_stream(Growing(content, end)).messages
        assert part == messages[: len(part)]
        found.append(len(part))
    assert found == sorted(found)
    assert (found[0], found[-1]) == (0, len(messages))
