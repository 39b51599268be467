"""The metadata records of a log: how each is written and read."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.log_format import EPOCH_NS

RUN: Final = "zenvoy.run"
"""The program and the scenario that made the log. Written first."""
RESULT: Final = "zenvoy.result"
"""How the run ended. Written last."""
LAWS: Final = "zenvoy.laws"
"""Laws that are not in the library, by mode; present only if the run has such laws."""
REPAIR: Final = "zenvoy.repair"
"""What a repair found and left out; present only in repaired logs."""

CHECKSUM: Final = "sha256"
"""Key of a metadata record for the checksum of its other entries."""

NOTES: Final = "notes"
"""Key of zenvoy.run for the notes on the scenario, one per line."""

HELD_UP: Final = "held_up"
"""Key of zenvoy.result for the machine that held up the run."""

_VERSION: Final = "version."
_OPTIONAL: Final = frozenset({"vehicles_per_process", NOTES})


@dataclass(frozen=True, slots=True, kw_only=True)
class RunMetadata:
    """The record zenvoy.run. Its keys are the names of the fields."""

    scenario: str
    """Name of the scenario."""
    seed: int
    cycles: int
    """Number of cycles that the scenario asks for."""
    period_ns: int
    vehicles: int
    bus: str
    run: str
    """Name of the run, as in keys."""
    vehicles_per_process: int = 1
    notes: tuple[str, ...] = ()
    """Notes on the scenario, one per line; the record has no such entry if there are none."""
    epoch_ns: int = EPOCH_NS
    python: str
    machine: str
    versions: Mapping[str, str] = field(default_factory=dict)
    """Versions of packages by name; each has an entry `version.<name>`."""

    def written(self) -> dict[str, str]:
        """Return the entries of the record, in the order in which a log has them."""
        return {
            "scenario": self.scenario,
            "seed": str(self.seed),
            "cycles": str(self.cycles),
            "period_ns": str(self.period_ns),
            "vehicles": str(self.vehicles),
            "bus": self.bus,
            "run": self.run,
            "vehicles_per_process": str(self.vehicles_per_process),
            **({NOTES: "\n".join(self.notes)} if self.notes else {}),
            "epoch_ns": str(self.epoch_ns),
            "python": self.python,
            "machine": self.machine,
            **{f"{_VERSION}{name}": version for name, version in self.versions.items()},
        }


def read_run(entries: Mapping[str, str], instead: RunMetadata) -> tuple[dict[str, str], list[str]]:
    """Return the entries of zenvoy.run, corrected, and a sentence on each correction.

    An entry that readers rely on comes from `instead` if it is missing, or if it should be a number
    but is not.
    """
    read, faults = dict(entries), []
    for key, value in instead.written().items():
        if key in _OPTIONAL or key.startswith(_VERSION):
            continue
        if key not in read:
            faults.append(f"metadata {RUN} has no {key}")
        elif isinstance(getattr(instead, key), int) and not read[key].isdecimal():
            faults.append(f"metadata {RUN}: {key}: {read[key]!r} is not a number")
        else:
            continue
        read[key] = value
    return read, faults


def read_epoch_ns(entries: Mapping[str, str]) -> int:
    """Return the epoch of the log's times from zenvoy.run, ns; EPOCH_NS if it has none."""
    text = entries.get("epoch_ns", "")
    return int(text) if text.isdecimal() else EPOCH_NS


def versions_of(entries: Mapping[str, str]) -> dict[str, str]:
    """Return the versions that zenvoy.run names, by package."""
    return {
        name.removeprefix(_VERSION): version
        for name, version in entries.items()
        if name.startswith(_VERSION)
    }


@dataclass(frozen=True, slots=True, kw_only=True)
class ResultMetadata:
    """The record zenvoy.result: how the run ended."""

    end: str
    """"complete", "stopped", "cut", "damaged", or the error that ended the run."""
    fingerprint: str
    cycles: int
    """Number of the last cycle in the log."""
    clock: pb.Clock
    """Clock message of the last cycle."""
    held_up: str = ""
    """Which machine held up the run, in words; the record has no such entry if none did."""

    def written(self) -> dict[str, str]:
        """Return the entries of the record, in the order in which a log has them."""
        return {
            "end": self.end,
            "fingerprint": self.fingerprint,
            "cycles": str(self.cycles),
            "simulated_s": simulated_s(self.clock.time_ns),
            "wall_s": f"{self.clock.wall_ns * 1e-9:.6f}",
            "real_time_factor": f"{self.clock.real_time_factor:.6f}",
            **({HELD_UP: self.held_up} if self.held_up else {}),
        }


def simulated_s(time_ns: int) -> str:
    """Return the simulated time as written in zenvoy.result, s."""
    return f"{time_ns * 1e-9:.9g}"


_RESULT_WORDS: Final = ("end", "fingerprint")
_RESULT_NUMBERS: Final = ("cycles", "simulated_s", "wall_s", "real_time_factor")


def read_result(entries: Mapping[str, str]) -> tuple[dict[str, str], list[str]]:
    """Return the valid entries of zenvoy.result, and a sentence on each fault.

    An entry that should be a number but is not is left out.
    """
    read = dict(entries)
    faults = [
        f"metadata {RESULT} has no {key}"
        for key in (*_RESULT_WORDS, *_RESULT_NUMBERS)
        if key not in read
    ]
    for key in _RESULT_NUMBERS:
        if key in read and not _is_number(read[key], whole=key == "cycles"):
            faults.append(f"metadata {RESULT}: {key}: {read.pop(key)!r} is not a number")
    return read, faults


def sealed(entries: Mapping[str, str]) -> dict[str, str]:
    """Return the entries of a metadata record with their checksum as the last one."""
    return {**entries, CHECKSUM: checksum(entries)}


def unsealed(entries: Mapping[str, str]) -> dict[str, str]:
    """Return the entries of a metadata record without their checksum."""
    return {key: value for key, value in entries.items() if key != CHECKSUM}


def checksum(entries: Mapping[str, str]) -> str:
    """Return the SHA-256 over the entries of a record in order of key, except CHECKSUM itself."""
    digest = hashlib.sha256()
    for key in sorted(entries):
        if key != CHECKSUM:
            for text in (key, entries[key]):
                data = text.encode()
                digest.update(len(data).to_bytes(8, "little") + data)
    return digest.hexdigest()


def _is_number(text: str, *, whole: bool) -> bool:
    try:
        number = float(text)
    except ValueError:
        return False
    return math.isfinite(number) and number >= 0 and (not whole or text.isdecimal())
