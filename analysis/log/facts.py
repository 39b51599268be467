"""Reads what a log holds besides its messages, and replaces the parts that are damaged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pydantic import ValidationError

from zenvoy.analysis.log.checks import Check
from zenvoy.analysis.log.records import CUT_EARLY, LogError, Pass
from zenvoy.bus.log_format import EFFECTIVE
from zenvoy.bus.log_metadata import NOTES, RESULT, RUN, RunMetadata, read_result, read_run
from zenvoy.scenarios import Scenario

_UNKNOWN: Final = "unknown"


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """What a log holds besides its messages.

    `whole` is False where the file is cut. `result` is empty where the cut is before it, and
    `counts` counts the messages up to the cut. `read_cycles` is the number of rows of /fleet/truth
    that can be used.
    """

    run: dict[str, str]
    result: dict[str, str]
    repair: dict[str, str]
    """Metadata zenvoy.repair; {} where the log was not repaired."""
    laws: dict[str, str]
    """The scenario's own laws by name: the reference in the scenario, and the package."""
    scenario: Scenario
    counts: dict[str, int]
    whole: bool
    read_cycles: int
    checks: tuple[Check, ...]

    @property
    def duration_s(self) -> float:
        """The duration that the scenario asks for, s."""
        return self.scenario.cycles * self.scenario.period_ns * 1e-9

    @property
    def read_s(self) -> float:
        """The simulated time up to which the log could be read, s."""
        return max(0, self.read_cycles - 1) * self.scenario.period_ns * 1e-9

    @property
    def cut(self) -> str | None:
        """A sentence on how far a cut log could be read; None for a whole log."""
        if self.whole:
            return None
        return f"the log is cut: read up to {self.read_s:g} s of {self.duration_s:g} s"

    @property
    def faults(self) -> tuple[str, ...]:
        """A sentence for each check that failed, except for the cut."""
        return tuple(c.says for c in self.checks if c.holds is False and c.name != "end")


@dataclass(frozen=True, slots=True, kw_only=True)
class Metadata:
    """zenvoy.run and zenvoy.result with every entry that readers rely on, and their faults."""

    run: dict[str, str]
    result: dict[str, str]
    faults: tuple[str, ...]


def scenario_of(path: Path, log: Pass) -> Scenario:
    """Return the scenario of the log at `path` after a pass over it; raises LogError."""
    if RUN not in log.metadata and (log.whole or log.counts or log.metadata):
        raise LogError(f"{path}: an MCAP file, but not the log of a run")
    if RUN not in log.metadata or EFFECTIVE not in log.attachments:
        raise LogError(f"{path}: {CUT_EARLY}")
    try:
        return Scenario.model_validate_json(log.attachments[EFFECTIVE].data)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        says = " ".join(f"{place}: {first['msg']}".split())
        raise LogError(f"{path}: its {EFFECTIVE} is not valid: {printable(says)}") from error


def metadata_of(path: Path, log: Pass, scenario: Scenario) -> Metadata:
    """Return the metadata of a log; entries that are missing or invalid come from `scenario`."""
    run, faults = read_run(
        printable_values(log.metadata[RUN]),
        instead=RunMetadata(
            scenario=path.stem,
            seed=scenario.seed,
            cycles=scenario.cycles,
            period_ns=scenario.period_ns,
            vehicles=scenario.fleet.size,
            bus=_UNKNOWN,
            run=_UNKNOWN,
            python=_UNKNOWN,
            machine=_UNKNOWN,
        ),
    )
    if RESULT not in log.metadata:
        return Metadata(run=run, result={}, faults=tuple(faults))
    result, others = read_result(printable_values(log.metadata[RESULT]))
    return Metadata(run=run, result=result, faults=(*faults, *others))


def printable(text: str) -> str:
    """Return text from a file on one line and without control characters."""
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def printable_values(metadata: Mapping[str, str]) -> dict[str, str]:
    """Return metadata with printable names and values; the notes keep their lines."""
    return {
        printable(key): "\n".join(printable(line) for line in value.split("\n"))
        if key == NOTES
        else printable(value)
        for key, value in metadata.items()
    }
