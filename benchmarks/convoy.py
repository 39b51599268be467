"""Zenvoy's own rate: the paper's case 15 with other fleet sizes, read from the log."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from zenvoy.analysis.log.arrays import messages
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.topics import CLOCK

WARM_UP_CYCLES = 120  # the controller switches at 10 s


def convoy_rate(vehicles: int, cycles: int, bus: str, per_process: int = 1) -> float:
    """Return the cycles per second of wall time over `cycles` after the warm-up, from `/clock`.

    per_process is the number of vehicles in a process, on Zenoh.
    """
    duration_s = (WARM_UP_CYCLES + cycles) / 10
    with tempfile.TemporaryDirectory(prefix="zenvoy-convoy-") as folder:
        out = Path(folder, "run")
        command = [sys.executable, "-m", "zenvoy.cli", "run", "paper/case-15", "--bus", bus]
        command += ["--vehicles-per-process", f"{per_process}"]
        command += ["--set", f"fleet.size={vehicles}", "--duration-s", f"{duration_s}"]
        subprocess.run([*command, "--out", str(out)], check=True, capture_output=True)
        clocks = [
            pb.Clock.FromString(bytes(data))
            for _, data in messages(out / "run.mcap", [CLOCK.log_name])
        ]
    first, last = clocks[WARM_UP_CYCLES], clocks[-1]
    return (last.cycle - first.cycle) / ((last.wall_ns - first.wall_ns) * 1e-9)
