"""`zenvoy repair`, from a damaged log to a complete one and the exit code."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from zenvoy.analysis.log.records import LogError
from zenvoy.analysis.log.repair import RepairError, repair
from zenvoy.cli import exits


def repair_log(
    log: Path, out: Path | None, salvage: bool, console: Console, errors: Console
) -> int:
    """Write a complete log, and print its faults and gaps; return the exit code."""
    try:
        repaired = repair(log, out, salvage=salvage)
    except LogError as error:
        errors.print(str(error))
        return exits.BAD_INPUT
    except RepairError as error:
        errors.print(str(error))
        return exits.BAD_INPUT
    except OSError as error:
        errors.print(f"the repaired log cannot be written: {error.strerror or error}")
        return exits.FAILED
    if repaired is None:
        console.print(f"{log}: complete; there is nothing to repair", soft_wrap=True)
        return exits.OK
    for fault in repaired.found:
        errors.print(f"{log}: {fault}")
    for fault in repaired.facts.faults:
        errors.print(f"{repaired.path}: {fault}")
    facts = repaired.facts
    gap = "" if facts.result.get("end") != "damaged" else " before the first gap"
    text = f"{repaired.path}: {facts.read_s:g} s of {facts.duration_s:g} s{gap}"
    console.print(text, soft_wrap=True)
    return exits.OK
