"""Measures how well fleets of several sizes keep to the wall clock, from their logs.

`python -m benchmarks.realtime [--duration-s 120] [SIZE …]` prints a table.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from rich.console import Console
from rich.table import Table

from zenvoy.analysis.log.load import load
from zenvoy.analysis.measures.punctuality import (
    Punctuality,
    missed_decisions,
    punctuality,
    quantiles,
)

SIZES: Final = (10, 20, 40, 100, 200)
SCENARIO: Final = "quickstart"  # up to 53 vehicles, all are in range of each other
# Without these settings vehicles decide 0.6 ms after the frames of a cycle are due, which is too
# soon for any machine.
SLACK: Final = ("control.v2v_wait_ms=25", "control.system_delay_ms=75")


@dataclass(frozen=True, slots=True, kw_only=True)
class Kept:
    """How well a run kept to the clock.

    `missed` of the `due` frames missed their decision. `cores` is the CPU time of all processes
    divided by the wall time.
    """

    punctuality: Punctuality
    missed: int
    due: int
    cores: float


def keep(
    vehicles: int,
    duration_s: float,
    settings: tuple[str, ...] = SLACK,
    scenario: str = SCENARIO,
    per_process: int = 1,
) -> Kept:
    """Run a fleet of this size in real time, with `per_process` vehicles in a process."""
    with tempfile.TemporaryDirectory(prefix="zenvoy-realtime-") as folder:
        out = Path(folder, "run")
        command = [sys.executable, "-m", "zenvoy.cli", "run", scenario, "--realtime"]
        command += ["--vehicles-per-process", f"{per_process}"]
        for setting in (f"fleet.size={vehicles}", *settings):
            command += ["--set", setting]
        before = _cpu_s()
        subprocess.run(
            [*command, "--duration-s", f"{duration_s}", "--out", str(out)],
            check=True,
            capture_output=True,
        )
        spent_s = _cpu_s() - before
        run = load(out / "run.mcap")
        found = punctuality(run)
        if found is None:
            raise RuntimeError(f"{vehicles} vehicles: the log has no timing of any cycle")
        missed, due = missed_decisions(run)
    return Kept(punctuality=found, missed=missed, due=due, cores=spent_s / duration_s)


def delivery_p99_ms(vehicles: int, per_process: int = 1, duration_s: float = 20.0) -> float:
    """Return the 99th percentile of the lateness of deliveries, ms."""
    kept = keep(vehicles, duration_s, per_process=per_process)
    found = quantiles(kept.punctuality.delivery)
    return float("nan") if found is None else found.p99


def _cpu_s() -> float:
    """Return the CPU time of all ended children and their children, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _row(kept: Kept) -> list[str]:
    found = kept.punctuality
    cells = []
    for lateness in (found.cycle, found.sense, found.delivery, found.command):
        of = quantiles(lateness)
        cells.append("-" if of is None else f"{of.p50:.2f} / {of.p99:.2f} / {of.max:.1f}")
    return [
        *cells,
        f"{found.commands_late} + {found.commands_missing}",
        f"{100 * kept.missed / max(1, kept.due):.1f} %",
        str(found.overruns),
        f"{found.drift_ms:+.2f}",
        f"{kept.cores:.2f}",
    ]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sizes", nargs="*", type=int, default=SIZES, help="vehicles")
    parser.add_argument("--duration-s", type=float, default=120.0)
    parser.add_argument("--vehicles-per-process", type=int, default=1)
    parser.add_argument("--scenario", default=SCENARIO)
    parser.add_argument("--set", action="append", dest="settings", help=f"instead of {SLACK}")
    options = parser.parse_args()
    settings = SLACK if options.settings is None else tuple(options.settings)
    table = Table(
        "vehicles",
        "cycle",
        "sense",
        "delivery",
        "command",
        "late + missing",
        "missed",
        "overruns",
        "drift",
        "cores",
        title="Lateness, ms: median / 99th percentile / maximum",
    )
    for vehicles in options.sizes:
        kept = keep(
            vehicles, options.duration_s, settings, options.scenario, options.vehicles_per_process
        )
        table.add_row(str(vehicles), *_row(kept))
    Console(width=200).print(table)


if __name__ == "__main__":
    main()
