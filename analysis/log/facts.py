"""What stands in a log beside its messages, made good where it is damaged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pydantic import ValidationError

from zenvoy.analysis.log.checks import Check
from zenvoy.analysis.log.records import LogError, Pass
from zenvoy.bus.log_format import EFFECTIVE
from zenvoy.bus.log_metadata import RESULT, RUN, RunMetadata, read_result, read_run
from zenvoy.scenarios import Scenario

_UNKNOWN: Final = "unknown"


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """What stands in the log beside its messages.

    `whole` is False where the file is cut; `result` is empty where the cut is before it, and
    `counts` are those of the messages up to the cut. `read_cycles` are the rows of /fleet/truth
    that can be counted on.
    """

    run: dict[str, str]
    result: dict[str, str]
    repair: dict[str, str]
    """Metadata zenvoy.repair; {} where the log was not repaired."""
    laws: dict[str, str]
    """Laws of the scenario's own by name: what the scenario calls them, and their package."""
    scenario: Scenario
    counts: dict[str, int]
    whole: bool
    read_cycles: int
    checks: tuple[Check, ...]

    @property
    def duration_s(self) -> float:
        """How long the run was to be, s."""
        return self.scenario.cycles * self.scenario.period_ns * 1e-9

    @property
    def read_s(self) -> float:
        """Up to where the log could be read, s."""
        return max(0, self.read_cycles - 1) * self.scenario.period_ns * 1e-9

    @property
    def cut(self) -> str | None:
        """A sentence that says up to where a cut log could be read; None for a whole one."""
        if self.whole:
            return None
        return f"the log is cut: read up to {self.read_s:g} s of {self.duration_s:g} s"

    @property
    def faults(self) -> tuple[str, ...]:
        """Sentences on what does not hold of what the log says of itself, a cut apart."""
        return tuple(c.says for c in self.checks if c.holds is False and c.name != "end")


@dataclass(frozen=True, slots=True, kw_only=True)
class Metadata:
    """zenvoy.run and zenvoy.result with every entry that readers rely on, and what was amiss."""

    run: dict[str, str]
    result: dict[str, str]
    faults: tuple[str, ...]


def scenario_of(path: Path, log: Pass) -> Scenario:
    """Scenario of the log at `path` after a pass over it; raises LogError."""
    if RUN not in log.metadata and (log.whole or log.counts or log.metadata):
        raise LogError(f"{path}: an MCAP file, but not the log of a run")
    if RUN not in log.metadata or EFFECTIVE not in log.attachments:
        raise LogError(f"{path}: cut off before it says what it is the log of")
    try:
        return Scenario.model_validate_json(log.attachments[EFFECTIVE].data)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        says = " ".join(f"{place}: {first['msg']}".split())
        raise LogError(f"{path}: {EFFECTIVE} in it: {shown(says)}") from error


def metadata_of(path: Path, log: Pass, scenario: Scenario) -> Metadata:
    """Metadata of the log at `path`: what is missing or no number is taken from elsewhere."""
    run, faults = read_run(
        shown_facts(log.metadata[RUN]),
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
    result, others = read_result(shown_facts(log.metadata[RESULT]))
    return Metadata(run=run, result=result, faults=(*faults, *others))


def shown(text: str) -> str:
    """Text of a file as it can be printed: on one line, with no control characters."""
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def shown_facts(facts: Mapping[str, str]) -> dict[str, str]:
    """Metadata as it can be printed."""
    return {shown(key): shown(value) for key, value in facts.items()}
