"""Runs every command that reads logs on mutated logs: none may end in a traceback, or hang.

    python -m tests.mutated_logs [MUTANTS] [--seed SEED] [--draw PICTURES]

Mutants are made of a few small logs, on three levels: bytes of the file, records of MCAP, and
messages, where all checksums hold again. Each goes through `info --verify`, `analyze`, `export` and
`compare`. Pictures take nearly all of the time of `analyze` and `compare`, and depend on nothing
but the data: those of data that were drawn before are not drawn again, nor, after the first
PICTURES, any others; all that is computed for them is.

Prints a table by kind of mutant, at SIGTERM that of the mutants so far, and exits with 1 if one
ended in a traceback, took more than a minute, or was read without a word.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import random
import signal
import struct
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field, replace
from io import StringIO
from pathlib import Path
from types import FrameType
from typing import Any, Final, NamedTuple

import numpy as np
from mcap.opcode import Opcode
from typer.main import get_command

from tests.conftest import Log, Logged, read_log
from tests.log_surgery import (
    Record,
    chunk_of,
    content_of,
    put_together,
    record_of,
    taken_apart,
    with_content,
    with_data_crc,
    written_anew,
)
from tests.logs import chunk_every, write_log
from zenvoy.analysis import LogError, load
from zenvoy.analysis.page.drawing import Drawn, drawn
from zenvoy.analysis.page.section import Picture
from zenvoy.bus.log_metadata import CHECKSUM, RESULT, RUN, sealed
from zenvoy.cli import analyze as commands
from zenvoy.cli.app import app

LIMIT_S: Final = 60
_MEMORY: Final = Path("/dev/shm")  # a disk that others use as well takes longer than all the rest
_EXTREME: Final = (0, 1, 0xFF, 1 << 20, 1 << 31, 1 << 32, (1 << 63) - 1, 1 << 63, (1 << 64) - 1)
_SCENARIOS: Final = {
    "chain": """
duration_s: 2
seed: 3
fleet: {size: 3}
road: {type: open}
channel: {loss: {p: 0.2}}
control: {model: FM}
events: [{vehicle: 1, at_s: 0.5, duration_s: 0.5, deceleration_mps2: 2}]
""",
    "ring": """
duration_s: 1.5
seed: 4
fleet: {size: 5}
channel: {technology: lte-a-pro}
control: {model: PBCM, v2v_wait_ms: 30}
""",
}


class Mutant(NamedTuple):
    """A log that is not what it was."""

    kind: str
    content: bytes
    audible: bool
    """Whether what was changed must be reported."""


@dataclass(frozen=True, slots=True)
class Base:
    """A log that mutants are made of."""

    content: bytes
    log: Log

    @property
    def records(self) -> list[Record]:
        """Its records."""
        return taken_apart(self.content)


def bases(folder: Path) -> list[Base]:
    """Small logs with several chunks each; one of them is of an interrupted run."""
    paths = [
        write_log(folder / f"{name}.mcap", scenario, clock=chunk_every(5))
        for name, scenario in _SCENARIOS.items()
    ]
    interrupted = folder / "interrupted.mcap"
    clock = chunk_every(1_000)  # one chunk, and the same bytes in every process
    chain = _SCENARIOS["chain"]
    paths.append(write_log(interrupted, chain, until_cycle=12, lost="vehicle-03", clock=clock))
    return [Base(path.read_bytes(), read_log(path)) for path in paths]


class Mutator:
    """Makes mutants, in an order that the seed fixes."""

    def __init__(self, of: list[Base], seed: int) -> None:
        self._bases = of
        self._random = random.Random(seed)
        self._kinds: dict[str, tuple[Callable[[Base], bytes], bool]] = {
            "flipped bit": (self._flipped, True),
            "other bytes": (self._bytes, True),
            "cut": (self._cut, True),
            "bytes gone": (self._gone, True),
            "bytes more": (self._more, True),
            "zeros": (self._zeros, True),
            "other opcode": (self._opcode, True),
            "record dropped": (self._dropped, True),
            "record doubled": (self._doubled, True),
            "records swapped": (self._swapped, True),
            "other number in a record": (self._number, True),
            "chunk dropped, CRC good": (self._chunk_dropped, True),
            "chunk doubled, CRC good": (self._chunk_doubled, True),
            "chunks swapped, CRC good": (self._chunks_swapped, True),
            "chunk with other fields": (self._chunk_fields, True),
            "chunk without a CRC": (self._chunk_without_crc, False),
            "chunk of other content": (self._chunk_content, False),  # also of wall time
            "metadata": (self._metadata, True),
            "metadata, sealed": (self._metadata_sealed, False),
            "effective.json": (self._effective, False),
            "message dropped": (self._message_dropped, True),
            "message doubled": (self._message_doubled, True),
            "messages without order": (self._messages_shuffled, True),
            "topic gone": (self._topic_gone, False),  # that of wall time is in no fingerprint
            "payload": (self._payload, True),
            "payload cut": (self._payload_cut, True),
            "other number in a payload": (self._payload_number, True),
        }

    def mutants(self) -> Iterator[Mutant]:
        """Mutants without end, of all kinds in turn."""
        while True:
            for kind, (make, audible) in self._kinds.items():
                base = self._random.choice(self._bases)
                content = make(base)
                if content != base.content:
                    yield Mutant(kind, content, audible)

    def _place(self, content: bytes) -> int:
        return self._random.randrange(len(content))

    def _flipped(self, base: Base) -> bytes:
        at = self._place(base.content)
        changed = base.content[at] ^ 1 << self._random.randrange(8)
        return base.content[:at] + bytes([changed]) + base.content[at + 1 :]

    def _bytes(self, base: Base) -> bytes:
        at, size = self._place(base.content), self._random.choice((1, 2, 8, 100))
        noise = self._random.randbytes(size)
        return (base.content[:at] + noise + base.content[at + size :])[: len(base.content)]

    def _cut(self, base: Base) -> bytes:
        return base.content[: self._place(base.content)]

    def _gone(self, base: Base) -> bytes:
        at, size = self._place(base.content), self._random.choice((1, 8, 1_000))
        return base.content[:at] + base.content[at + size :]

    def _more(self, base: Base) -> bytes:
        at = self._random.choice((self._place(base.content), len(base.content)))
        return base.content[:at] + self._random.randbytes(9) + base.content[at:]

    def _zeros(self, base: Base) -> bytes:
        at, size = self._place(base.content), self._random.choice((4, 100, 4_000))
        return (base.content[:at] + bytes(size) + base.content[at + size :])[: len(base.content)]

    def _opcode(self, base: Base) -> bytes:
        records = base.records
        at = self._random.randrange(len(records))
        records[at] = records[at]._replace(opcode=self._random.randrange(256))
        return put_together(records)

    def _dropped(self, base: Base) -> bytes:
        records = base.records
        del records[self._random.randrange(len(records))]
        return put_together(records)

    def _doubled(self, base: Base) -> bytes:
        records = base.records
        at = self._random.randrange(len(records))
        records.insert(at, records[at])
        return put_together(records)

    def _swapped(self, base: Base) -> bytes:
        records = base.records
        i, j = (self._random.randrange(len(records)) for _ in range(2))
        records[i], records[j] = records[j], records[i]
        return put_together(records)

    def _number(self, base: Base) -> bytes:
        """Eight, four or two bytes of a record, near its beginning, become an extreme number."""
        records = base.records
        at = self._random.randrange(len(records))
        opcode, body = records[at]
        form = self._random.choice(("<Q", "<I", "<H"))
        size = struct.calcsize(form)
        start = self._random.randrange(max(1, min(48, len(body) - size)))
        number = struct.pack(form, self._random.choice(_EXTREME) % (1 << 8 * size))
        if opcode == Opcode.DATA_END and number == bytes(size):
            return base.content  # a checksum of 0 is none, and all data are as they were
        records[at] = Record(opcode, (body[:start] + number + body[start + size :])[: len(body)])
        return put_together(records)

    def _chunks(self, base: Base) -> tuple[list[Record], list[int]]:
        records = base.records
        return records, [i for i, record in enumerate(records) if record.opcode == Opcode.CHUNK]

    def _chunk_dropped(self, base: Base) -> bytes:
        records, chunks = self._chunks(base)
        del records[self._random.choice(chunks)]
        return with_data_crc(put_together(records))

    def _chunk_doubled(self, base: Base) -> bytes:
        records, chunks = self._chunks(base)
        at = self._random.choice(chunks)
        records.insert(self._random.choice(chunks), records[at])
        return with_data_crc(put_together(records))

    def _chunks_swapped(self, base: Base) -> bytes:
        records, chunks = self._chunks(base)
        i, j = (self._random.choice(chunks) for _ in range(2))
        records[i], records[j] = records[j], records[i]
        return with_data_crc(put_together(records))

    def _chunk_fields(self, base: Base) -> bytes:
        """Another compression, another size, another CRC, or a part of its content."""
        records, chunks = self._chunks(base)
        at = self._random.choice(chunks)
        chunk = chunk_of(records[at])
        where = self._place(chunk.data)
        change: dict[str, Any] = self._random.choice(
            [
                {"compression": self._random.choice(("", "lz4", "zst", "gzip", "ZSTD"))},
                {"uncompressed_size": self._random.choice(_EXTREME)},
                {"uncompressed_crc": self._random.randrange(1, 1 << 32)},
                {"data": chunk.data[:where]},
            ]
        )
        records[at] = record_of(replace(chunk, **change))
        return with_data_crc(put_together(records))

    def _chunk_without_crc(self, base: Base) -> bytes:
        """Whether the byte that changes matters to what it unpacks to is for zstd to say."""
        records, chunks = self._chunks(base)
        at = self._random.choice(chunks)
        chunk = chunk_of(records[at])
        where = self._place(chunk.data)
        data = chunk.data[:where] + self._random.randbytes(1) + chunk.data[where + 1 :]
        records[at] = record_of(replace(chunk, uncompressed_crc=0, data=data))
        return with_data_crc(put_together(records))

    def _chunk_content(self, base: Base) -> bytes:
        """Bytes within a chunk change, and its sizes and CRC hold all the same."""
        records, chunks = self._chunks(base)
        at = self._random.choice(chunks)
        data = bytearray(content_of(chunk_of(records[at])))
        for _ in range(self._random.choice((1, 1, 10))):
            data[self._random.randrange(len(data))] = self._random.randrange(256)
        if self._random.random() < 0.2:
            del data[self._random.randrange(len(data)) :]
        records[at] = record_of(with_content(chunk_of(records[at]), bytes(data)))
        return with_data_crc(put_together(records))

    def _changed_metadata(self, base: Base) -> tuple[str, dict[str, str]]:
        name = self._random.choice((RUN, RESULT))
        metadata = dict(base.log.metadata[name])
        key = self._random.choice([key for key in metadata if key != CHECKSUM])
        value = metadata[key]
        other = (
            value[::-1],
            "",
            "x",
            "-1",
            "1e400",
            "nan",
            "9" * 400,
            f"{value}1",
            "[/b]\n\x1b[2J",
        )
        if self._random.random() < 0.3:
            del metadata[key]
        else:
            metadata[key] = self._random.choice(other)
        return name, metadata

    def _metadata(self, base: Base) -> bytes:
        name, metadata = self._changed_metadata(base)
        if metadata == base.log.metadata[name]:
            return base.content
        return written_anew(replace(base.log, metadata={**base.log.metadata, name: metadata}))

    def _metadata_sealed(self, base: Base) -> bytes:
        name, metadata = self._changed_metadata(base)
        metadata.pop(CHECKSUM, None)
        changed = {**base.log.metadata, name: sealed(metadata)}
        return written_anew(replace(base.log, metadata=changed))

    def _effective(self, base: Base) -> bytes:
        """The scenario of another log, or one with other bytes in it."""
        text = bytearray(base.log.attachments["effective.json"])
        if self._random.random() < 0.3:
            text = bytearray(self._random.choice(self._bases).log.attachments["effective.json"])
        digits = [i for i, byte in enumerate(text) if chr(byte).isdigit()]
        for _ in range(self._random.choice((1, 1, 3))):
            text[self._random.choice(digits)] = ord(self._random.choice("0123456789"))
        if self._random.random() < 0.2:
            del text[self._random.randrange(len(text)) :]
        changed = {**base.log.attachments, "effective.json": bytes(text)}
        return written_anew(replace(base.log, attachments=changed))

    def _anew(self, base: Base, change: Callable[[Logged], list[Logged]], share: float) -> bytes:
        """Put some messages through a change, at least one; none of wall time."""
        data = [i for i, message in enumerate(base.log.messages) if message.topic != "/clock"]
        at = self._random.choice(data)

        def changed(number: int, message: Logged) -> list[Logged]:
            chosen = number == at or (message.topic != "/clock" and self._random.random() < share)
            return change(message) if chosen else [message]

        return written_anew(base.log, changed)

    def _message_dropped(self, base: Base) -> bytes:
        return self._anew(base, lambda _: [], self._random.choice((0, 0.5, 1)))

    def _message_doubled(self, base: Base) -> bytes:
        return self._anew(base, lambda message: [message, message], 0.1)

    def _messages_shuffled(self, base: Base) -> bytes:
        messages = list(base.log.messages)
        self._random.shuffle(messages)
        return written_anew(replace(base.log, messages=messages))

    def _topic_gone(self, base: Base) -> bytes:
        gone = self._random.choice([channel.topic for channel in base.log.channels.values()])
        kept = [message for message in base.log.messages if message.topic != gone]
        return written_anew(replace(base.log, messages=kept))

    def _payload(self, base: Base) -> bytes:
        def change(message: Logged) -> list[Logged]:
            data = bytearray(message.data)
            data[self._random.randrange(len(data))] ^= self._random.randrange(1, 256)
            return [message._replace(data=bytes(data))]

        return self._anew(base, change, self._random.choice((0, 0, 0.2)))

    def _payload_cut(self, base: Base) -> bytes:
        def change(message: Logged) -> list[Logged]:
            size = self._random.randrange(len(message.data))
            return [message._replace(data=message.data[:size])]

        return self._anew(base, change, self._random.choice((0, 0, 0.2)))

    def _payload_number(self, base: Base) -> bytes:
        """Eight bytes become a number that no run holds: NaN, infinity, very large or small."""

        def change(message: Logged) -> list[Logged]:
            number = self._random.choice(
                (float("nan"), float("inf"), -1e300, 1e8, 0.0, -1.0, 5e-324, 1e-300)
            )
            size = len(message.data)
            at = size - 8 * self._random.randrange(1, max(2, size // 8))
            data = (message.data[:at] + struct.pack("<d", number) + message.data[at + 8 :])[:size]
            return [message._replace(data=data if data != message.data else b"")]

        return self._anew(base, change, self._random.choice((0, 0, 0.2)))


@dataclass(slots=True)
class Outcome:
    """What became of the mutants, by kind; of those that went wrong, how."""

    reported: Counter[str] = field(default_factory=Counter)
    """Read with notes."""
    unnoticed: Counter[str] = field(default_factory=Counter)
    """Read without a word, of kinds where that is no fault."""
    refused: Counter[str] = field(default_factory=Counter)
    tried: int = 0
    wrong: list[str] = field(default_factory=list)
    slowest: tuple[float, str] = (0.0, "")
    drawn: int = 0
    not_drawn: int = 0


class SlowError(Exception):
    """A command has taken too long."""


class Trial:
    """Runs the commands on mutants in a folder of its own."""

    def __init__(self, folder: Path, pictures: int) -> None:
        self._folder = folder
        self._pictures = pictures
        self._forms: dict[tuple[bytes, str], Drawn] = {}
        self._data = b""
        self._zenvoy = get_command(app)
        self.outcome = Outcome()

    def run(self, number: int, mutant: Mutant) -> None:
        """Take a mutant through every command."""
        path = self._folder / "mutant.mcap"
        path.write_bytes(mutant.content)
        self._data = _data_of(path)
        texts, codes = [], []
        out = ("--out", str(self._folder / "out"))
        for arguments in (
            ("info", "--verify", str(path)),
            ("analyze", str(path), *out),
            ("export", str(path), "--to", "parquet" if number % 2 else "csv", *out),
            ("compare", str(path), str(path), "--label", "a", "--label", "b", *out),
        ):
            start = time.monotonic()
            code, text = self._command(number, mutant.kind, arguments)
            took = time.monotonic() - start, f"{arguments[0]} of {number}, {mutant.kind}"
            self.outcome.slowest = max(self.outcome.slowest, took)
            codes.append(code)
            texts.append(text)
        self._judge(number, mutant, codes, texts)

    def _judge(self, number: int, mutant: Mutant, codes: list[int], texts: list[str]) -> None:
        if any(code not in {0, 1, 2} for code in codes) or codes[1:].count(1):
            self.outcome.wrong.append(f"{number} {mutant.kind}: exit codes {codes}")
        elif codes[0] == 2:
            self.outcome.refused[mutant.kind] += 1
            if len(set(codes)) != 1 or any(t.count("\n") != 1 for t in texts[:3]):
                self.outcome.wrong.append(f"{number} {mutant.kind}: {codes} {texts}")
        elif all(texts):
            self.outcome.reported[mutant.kind] += 1
        elif mutant.audible:
            self.outcome.wrong.append(f"{number} {mutant.kind}: not a word in one of {texts}")
        else:
            self.outcome.unnoticed[mutant.kind] += 1

    def _command(self, number: int, kind: str, arguments: tuple[str, ...]) -> tuple[int, str]:
        """Exit code, and what was printed on stderr."""
        errors = StringIO()
        try:
            with _limited(), self._drawing(), redirect_stdout(StringIO()), redirect_stderr(errors):
                code = self._zenvoy.main([*arguments], prog_name="zenvoy", standalone_mode=False)
        except SlowError:
            self.outcome.wrong.append(f"{number} {kind}: {arguments[0]} takes too long")
            return -1, ""
        except Exception as error:  # noqa: BLE001  # whatever it is, it would be a traceback
            trace = "".join(traceback.format_exception(error)[-6:])
            self.outcome.wrong.append(f"{number} {kind}: {arguments[0]}: {trace}")
            return -1, ""
        return int(code or 0), errors.getvalue()

    @contextmanager
    def _drawing(self) -> Iterator[None]:
        """Draw pictures of data that were not drawn before, as long as there are some left."""

        def draw(picture: Picture) -> Drawn:
            key = self._data, picture.name
            if key not in self._forms:
                if self.outcome.drawn >= self._pictures:
                    self.outcome.not_drawn += 1
                    return Drawn(png=b"", svg=b"<svg/>", width_in=1.0, height_in=1.0)
                self.outcome.drawn += 1
                self._forms[key] = drawn(picture)
            return self._forms[key]

        module: Any = commands
        module.drawn = draw
        try:
            yield
        finally:
            module.drawn = drawn


def _data_of(path: Path) -> bytes:
    """A digest of all that pictures depend on; of a log that is refused, nothing."""
    try:
        run = load(path)
    except LogError:
        return b""
    digest = hashlib.sha256(run.scenario.model_dump_json().encode())
    for table in (run.truth, run.radar, run.estimate, run.command, run.frames):
        for column in table.values():
            digest.update(np.ascontiguousarray(column).tobytes())
    for event in run.events:
        digest.update(event.SerializeToString())
    return digest.digest()


@contextmanager
def _limited() -> Iterator[None]:
    def stop(_signal: int, _frame: FrameType | None) -> None:
        raise SlowError

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(LIMIT_S)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def tried(
    mutants: int,
    seed: int,
    pictures: int,
    *,
    say: Callable[[Outcome, list[str]], None] = lambda _, __: None,
    enough: Callable[[], bool] = lambda: False,
) -> Outcome:
    """Make mutants and take each through the commands; `say` gets what went wrong after each."""
    with tempfile.TemporaryDirectory(dir=_MEMORY if _MEMORY.is_dir() else None) as name:
        folder = Path(name)
        mutator = Mutator(bases(folder), seed)
        trial = Trial(folder, pictures)
        for number, mutant in zip(range(mutants), mutator.mutants(), strict=False):
            before = len(trial.outcome.wrong)
            trial.run(number, mutant)
            trial.outcome.tried += 1
            say(trial.outcome, trial.outcome.wrong[before:])
            if enough():
                break
        return trial.outcome


def _say(outcome: Outcome, wrong: list[str]) -> None:
    for text in wrong:
        print(text, file=sys.stderr, flush=True)
    if outcome.tried % 100 == 0:
        print(outcome.tried, "wrong:", len(outcome.wrong), file=sys.stderr, flush=True)


def main() -> int:
    """Entry point of the module."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutated_logs")
    parser.add_argument("mutants", type=int, nargs="?", default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--draw", type=int, default=400, metavar="PICTURES")
    arguments = parser.parse_args()
    asked: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: asked.append(number))
    os.environ.setdefault("COLUMNS", "400")  # lines that are not wrapped take less time
    outcome = tried(
        arguments.mutants, arguments.seed, arguments.draw, say=_say, enough=lambda: bool(asked)
    )
    print(f"{outcome.tried} mutants")
    kinds = sorted(outcome.refused | outcome.reported | outcome.unnoticed)
    print(f"{'kind':<28}{'refused':>9}{'notes':>9}{'silent':>9}")
    for kind in kinds:
        counts = (outcome.refused[kind], outcome.reported[kind], outcome.unnoticed[kind])
        print(f"{kind:<28}" + "".join(f"{count:>9}" for count in counts))
    print(f"pictures: {outcome.drawn} drawn, {outcome.not_drawn} not drawn")
    print("slowest command: {:.1f} s, {}".format(*outcome.slowest))
    print(f"wrong: {len(outcome.wrong)}")
    for wrong in outcome.wrong[:50]:
        print(wrong)
    return bool(outcome.wrong)


if __name__ == "__main__":
    sys.exit(main())
