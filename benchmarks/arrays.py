"""The array engine against the in-process bus: the paper's case 15, in vehicle-seconds."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from time import process_time

from zenvoy.fleet.arrays.batch import Batch
from zenvoy.fleet.folder import make_folder
from zenvoy.fleet.run import run
from zenvoy.scenarios import Loaded, load

SCENARIO = "paper/case-15"


def _loaded(vehicles: int, duration_s: float, seed: int) -> Loaded:
    return load(SCENARIO, (f"fleet.size={vehicles}",), seed=seed, duration_s=duration_s)


def array_rate(vehicles: int, runs: int, duration_s: float) -> float:
    """Return the vehicle-seconds per second of CPU of a batch of runs, without a log.

    Everything counts from the loaded scenarios to the last cycle, in a process that just started.
    """
    arguments = (str(vehicles), str(runs), str(duration_s))
    command = [sys.executable, "-m", "benchmarks.arrays", *arguments]
    return float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def in_process_rate(vehicles: int, duration_s: float) -> float:
    """Return the vehicle-seconds per second of CPU of one run in process, with its log."""
    loaded = _loaded(vehicles, duration_s, 1)
    with tempfile.TemporaryDirectory(prefix="zenvoy-arrays-") as folder:
        out = make_folder(Path(folder, "run"), loaded.name)
        start_s = process_time()
        run(loaded, out, "in-process")
        return vehicles * duration_s / (process_time() - start_s)


def main() -> None:
    """Print the rate of a batch: its vehicles, runs and seconds are the arguments."""
    vehicles, runs, duration_s = int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
    scenarios = [_loaded(vehicles, duration_s, seed).scenario for seed in range(1, runs + 1)]
    start_s = process_time()
    for _ in Batch(scenarios).cycles():
        pass
    print(vehicles * runs * duration_s / (process_time() - start_s))


if __name__ == "__main__":
    main()
