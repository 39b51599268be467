"""A trial passes mutants through the commands that read logs, and judges the output.

A mutant must not end in a traceback, or take long, or be read without a report. Pictures take
nearly all of the time of `analyze` and `compare`, and depend on the data only. So equal data are
drawn once, and after a number of pictures no more are drawn. All data for pictures are still
computed.
"""

from __future__ import annotations

import hashlib
import signal
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from io import StringIO
from itertools import islice
from pathlib import Path
from types import FrameType
from typing import Any, Final

import numpy as np
from typer.main import get_command

from tests.mutated_logs.bases import bases
from tests.mutated_logs.mutants import Mutant, mutants
from zenvoy.analysis import LogError, load
from zenvoy.analysis.page.drawing import Drawn, drawn
from zenvoy.analysis.page.section import Picture
from zenvoy.cli import analyze as commands
from zenvoy.cli.app import app

LIMIT_S: Final = 60
_MEMORY: Final = Path("/dev/shm")  # a shared disk would take longer than all the rest


@dataclass(slots=True)
class Outcome:
    """The fates of mutants by kind, and descriptions of what went wrong."""

    reported: Counter[str] = field(default_factory=Counter)
    """Read with notes."""
    unnoticed: Counter[str] = field(default_factory=Counter)
    """Read without a report, of kinds that need none."""
    refused: Counter[str] = field(default_factory=Counter)
    tried: int = 0
    wrong: list[str] = field(default_factory=list)
    slowest: tuple[float, str] = (0.0, "")
    drawn: int = 0
    not_drawn: int = 0


class SlowError(Exception):
    """A command takes too long."""


class Trial:
    """Runs the commands on mutants in its own folder."""

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
        elif mutant.must_report:
            self.outcome.wrong.append(f"{number} {mutant.kind}: not a word in one of {texts}")
        else:
            self.outcome.unnoticed[mutant.kind] += 1

    def _command(self, number: int, kind: str, arguments: tuple[str, ...]) -> tuple[int, str]:
        """Return the exit code and the output on stderr."""
        errors = StringIO()
        try:
            with _limited(), self._drawing(), redirect_stdout(StringIO()), redirect_stderr(errors):
                code = self._zenvoy.main([*arguments], prog_name="zenvoy", standalone_mode=False)
        except SlowError:
            self.outcome.wrong.append(f"{number} {kind}: {arguments[0]} takes too long")
            return -1, ""
        except Exception as error:  # noqa: BLE001 - what ends in a traceback is a finding
            trace = "".join(traceback.format_exception(error)[-6:])
            self.outcome.wrong.append(f"{number} {kind}: {arguments[0]}: {trace}")
            return -1, ""
        return int(code or 0), errors.getvalue()

    @contextmanager
    def _drawing(self) -> Iterator[None]:
        """Draw pictures of new data, up to the limit of pictures."""

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
    """Return a digest of all that pictures depend on, or nothing for a refused log."""
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
    count: int,
    seed: int,
    pictures: int,
    *,
    say: Callable[[Outcome, list[str]], None] = lambda _, __: None,
    enough: Callable[[], bool] = lambda: False,
) -> Outcome:
    """Pass mutants through the commands. `say` gets what went wrong after each."""
    with tempfile.TemporaryDirectory(dir=_MEMORY if _MEMORY.is_dir() else None) as name:
        folder = Path(name)
        trial = Trial(folder, pictures)
        for number, mutant in enumerate(islice(mutants(bases(folder), seed), count)):
            before = len(trial.outcome.wrong)
            trial.run(number, mutant)
            trial.outcome.tried += 1
            say(trial.outcome, trial.outcome.wrong[before:])
            if enough():
                break
        return trial.outcome
