"""Files that are no logs of Zenvoy are refused with a line that says why."""

from __future__ import annotations

from pathlib import Path

import pytest
from mcap.writer import Writer

from zenvoy.analysis import LogError, load


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "not an MCAP file"),
        (b"\x89MCAP", "not an MCAP file"),
        (b"speed,gap\n1,2\n" * 50, "not an MCAP file"),
        (b"\x89MCAP0\r\n", "cut before the scenario"),
    ],
)
def test_a_file_that_is_no_log_is_refused(tmp_path: Path, content: bytes, says: str) -> None:
    (tmp_path / "a.mcap").write_bytes(content)
    with pytest.raises(LogError, match=says):
        load(tmp_path / "a.mcap")


def test_a_file_that_cannot_be_opened_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"missing\.mcap: No such file"):
        load(tmp_path / "missing.mcap")
    with pytest.raises(LogError, match="Is a directory"):
        load(str(tmp_path))


@pytest.mark.parametrize("ends", [True, False])
def test_a_log_of_another_program_is_refused(tmp_path: Path, ends: bool) -> None:
    other = tmp_path / "other.mcap"
    with other.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="", library="another")
        schema = writer.register_schema("text", "", b"")
        channel = writer.register_channel("/fleet/truth", "text", schema)
        writer.add_message(channel, 1, b"\xff\xff hello", 1)
        if ends:
            writer.finish()
        else:
            writer.flush()
    with pytest.raises(LogError, match="an MCAP file, but not the log of a run"):
        load(other)
