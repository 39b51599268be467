"""Bases are small logs from which mutants are made. A mutation changes a base."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Final, NamedTuple

from tests.log_surgery import Record, taken_apart
from tests.logs import chunk_every, write_log
from tests.streamed_log import Log, read_log

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


@dataclass(frozen=True, slots=True)
class Base:
    """A log from which mutants are made."""

    content: bytes
    log: Log
    scenarios: tuple[bytes, ...]
    """The effective scenarios of all bases, its own among them."""

    @property
    def records(self) -> list[Record]:
        """Return the records of the log."""
        return taken_apart(self.content)


class Mutation(NamedTuple):
    """A change of a log, which may have no effect."""

    change: Callable[[Base, Random], bytes]
    must_report: bool = True
    """Whether every effect must be reported."""


def bases(folder: Path) -> list[Base]:
    """Return small logs with several chunks each. One is of an interrupted run."""
    paths = [
        write_log(folder / f"{name}.mcap", scenario, clock=chunk_every(5))
        for name, scenario in _SCENARIOS.items()
    ]
    interrupted = folder / "interrupted.mcap"
    clock = chunk_every(1_000)  # one chunk, and the same bytes in every process
    chain = _SCENARIOS["chain"]
    paths.append(write_log(interrupted, chain, until_cycle=12, lost="vehicle-03", clock=clock))
    logs = [read_log(path) for path in paths]
    scenarios = tuple(log.attachments["effective.json"] for log in logs)
    return [Base(path.read_bytes(), log, scenarios) for path, log in zip(paths, logs, strict=True)]
