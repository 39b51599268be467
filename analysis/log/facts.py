"""What stands in a log beside its messages, made good where it is damaged."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pydantic import ValidationError

from zenvoy.analysis.log.checks import Check
from zenvoy.analysis.log.records import LogError, Pass
from zenvoy.bus.log_format import EFFECTIVE, EPOCH_NS, RESULT, RUN
from zenvoy.scenarios import Scenario

_UNKNOWN: Final = "unknown"
_RESULT_NUMBERS: Final = ("cycles", "simulated_s", "wall_s", "real_time_factor")
_OF_RESULT: Final = ("end", "fingerprint", *_RESULT_NUMBERS)


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
    instead = {
        "scenario": path.stem,
        "seed": str(scenario.seed),
        "cycles": str(scenario.cycles),
        "period_ns": str(scenario.period_ns),
        "vehicles": str(scenario.fleet.size),
        "epoch_ns": str(EPOCH_NS),
        **dict.fromkeys(("bus", "run", "python", "machine"), _UNKNOWN),
    }
    run, result = shown_facts(log.metadata[RUN]), shown_facts(log.metadata.get(RESULT, {}))
    faults = []
    for key, value in instead.items():
        if key not in run:
            faults.append(f"metadata {RUN} has no {key}")
        elif value.isdecimal() and not run[key].isdecimal():
            faults.append(f"metadata {RUN}: {key}: {run[key]!r} is not a number")
        else:
            continue
        run[key] = value
    if RESULT in log.metadata:
        faults += [f"metadata {RESULT} has no {key}" for key in _OF_RESULT if key not in result]
    for key in _RESULT_NUMBERS:
        if key in result and not _is_number(result[key], whole=key == "cycles"):
            faults.append(f"metadata {RESULT}: {key}: {result.pop(key)!r} is not a number")
    return Metadata(run=run, result=result, faults=tuple(faults))


def shown(text: str) -> str:
    """Text of a file as it can be printed: on one line, with no control characters."""
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def shown_facts(facts: Mapping[str, str]) -> dict[str, str]:
    """Metadata as it can be printed."""
    return {shown(key): shown(value) for key, value in facts.items()}


def _is_number(text: str, *, whole: bool) -> bool:
    try:
        number = float(text)
    except ValueError:
        return False
    return math.isfinite(number) and number >= 0 and (not whole or text.isdecimal())
