"""CPU time of large fleets, by role, and of 40 processes beside the bare barrier of their messages.

    python -m benchmarks.size 40 200 1000 --duration-s 10
    python -m benchmarks.size 1000 --vehicles-per-process 250
    python -m benchmarks.size --floor

CPU time hardly depends on what else the machine does, wall time does. A fleet's figures leave out
the command itself, which starts the processes and sums up the log. `--floor` takes the difference
of a long and a short run, so that starts cancel out.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from collections import defaultdict
from contextlib import suppress
from pathlib import Path

from benchmarks.bare_zenoh import WARM_UP_CYCLES, Sizes, bare_barrier
from benchmarks.waiting import ends_within

_TICKS_PER_S = os.sysconf("SC_CLK_TCK")
_CYCLES_PER_S = 10
_SAMPLED_EVERY_S = 0.1


def fleet_cpu_s(vehicles: int, per_process: str, duration_s: float) -> dict[str, float]:
    """Return the CPU time of a run of quickstart by role, s."""
    with tempfile.TemporaryDirectory(prefix="zenvoy-size-") as folder:
        command = [sys.executable, "-m", "zenvoy.cli", "run", "quickstart"]
        command += ["--out", f"{folder}/run"]
        command += ["--set", f"fleet.size={vehicles}", "--duration-s", f"{duration_s:g}"]
        command += ["--vehicles-per-process", per_process]
        seen: dict[int, tuple[str, float]] = {}
        with subprocess.Popen(command, stdout=subprocess.DEVNULL) as run:
            while not ends_within(run, _SAMPLED_EVERY_S):
                seen |= _children(run.pid)
        if run.returncode:
            raise RuntimeError(f"{' '.join(command)} ended with {run.returncode}")
    found: dict[str, float] = defaultdict(float)
    for name, cpu_s in seen.values():
        found[name.partition("-")[0].removesuffix("s")] += cpu_s
    return found


def _children(parent: int) -> dict[int, tuple[str, float]]:
    """Return name and CPU time, s, of each process that a run has forked, by its id."""
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError, IndexError):  # it has just ended
            stat = (folder / "stat").read_text().rpartition(")")[2].split()
            title = (folder / "cmdline").read_bytes().partition(b"\0")[0].decode().split()
            if int(stat[1]) == parent and title[0] == "zenvoy":
                found[int(folder.name)] = title[1], sum(map(int, stat[11:13])) / _TICKS_PER_S
    return found


def floor(vehicles: int = 40, cycles: int = 300) -> tuple[float, float]:
    """Return the CPU time per cycle, ms, of a process per vehicle, and of the bare barrier."""
    long, short = (
        sum(fleet_cpu_s(vehicles, "1", count / _CYCLES_PER_S).values())
        for count in (2 * cycles, cycles)
    )
    bare = [_bare_cpu_s(vehicles, count) for count in (2 * cycles, cycles)]
    return 1e3 * (long - short) / cycles, 1e3 * (bare[0] - bare[1]) / cycles


def _bare_cpu_s(vehicles: int, cycles: int) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    bare_barrier(vehicles, cycles - WARM_UP_CYCLES, Sizes.of_fleet(vehicles), lookahead=1)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("vehicles", type=int, nargs="*")
    parser.add_argument("--vehicles-per-process", default="auto")
    parser.add_argument("--duration-s", type=float, default=10.0)
    parser.add_argument("--floor", action="store_true")
    options = parser.parse_args()
    for vehicles in options.vehicles:
        found = fleet_cpu_s(vehicles, options.vehicles_per_process, options.duration_s)
        total_s, cycles = sum(found.values()), options.duration_s * _CYCLES_PER_S
        roles = ", ".join(f"{role} {found[role]:.2f}" for role in ("world", "channel", "vehicle"))
        each_us = 1e6 * total_s / (cycles * vehicles)
        print(f"{vehicles} vehicles: {total_s:.2f} s of CPU time ({roles}), ", end="")
        print(f"{each_us:.0f} µs per vehicle and cycle; load {os.getloadavg()[0]:.1f}")
    if options.floor:
        ours_ms, bare_ms = floor()
        print(
            f"40 processes: {ours_ms:.1f} ms of CPU time per cycle, bare barrier {bare_ms:.1f} ms"
        )
        print(f"ratio {ours_ms / bare_ms:.2f}; load {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
