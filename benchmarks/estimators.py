"""`python -m benchmarks.estimators`: compares the filters in time and error; writes estimators.md.

The time is that of one step of a link (predict for each period since the last reading, then
update), next to filterpy's own KalmanFilter without precomputed gains. The filters take the same
readings in turn, block by block, so that compared times were measured within a few milliseconds.
The error is that in the paper's case 15, run with each filter and read from its log.
"""

import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from statistics import median
from typing import Final, Literal, NamedTuple

import numpy as np
from filterpy.kalman import KalmanFilter
from rich.console import Console
from rich.markdown import Markdown

from benchmarks.facts import facts
from zenvoy.analysis import read_fleet, summarize
from zenvoy.bus.topics import TRUTH
from zenvoy.scenarios import Estimator
from zenvoy.vehicles.filters import state_filter
from zenvoy.vehicles.gains import gain_schedule
from zenvoy.vehicles.linear import linear_model

KINDS: Final[tuple[Literal["kalman", "ekf", "ukf"], ...]] = ("kalman", "ekf", "ukf")
PLAIN: Final = "filterpy's KalmanFilter, predict and update"
RESULTS: Final = Path(__file__).with_name("estimators.md")

ROUNDS: Final = 5  # each computes its gains again, as each run does
WARM_UP_STEPS: Final = 1_000
BLOCKS: Final = 100
BLOCK_STEPS: Final = 20
PERIOD_NS: Final = 100_000_000
VARIANCES: Final = (4.6875, 3.0)  # ±10 % of 37.5 m and 30 m/s
MISSED: Final = 0.2

SEEDS: Final = (1, 2)
DURATION_S: Final = 100

Inputs = Sequence[float]
Reading = tuple[float, ...]
Step = Callable[[Inputs, Reading, tuple[float, ...]], None]


class Plain:
    """filterpy's KalmanFilter, called as in its documentation."""

    def __init__(self) -> None:
        self.kalman = KalmanFilter(dim_x=2, dim_z=2, dim_u=1)
        self.kalman.F, self.kalman.B, self.kalman.Q = linear_model(PERIOD_NS * 1e-9, 0.5, 2)
        self.kalman.H, self.kalman.P = np.eye(2), np.diag(VARIANCES)

    def step(self, inputs: Inputs, z: Reading, variances: tuple[float, ...]) -> None:
        """Predict for each input, then update."""
        for a in inputs:
            self.kalman.predict(u=np.array([[a]]))
        self.kalman.update(np.array(z).reshape(-1, 1), R=np.diag(variances))


def steps_of(missed: float, seed: int) -> Iterator[tuple[Inputs, Reading]]:
    """Yield inputs and readings of a link on which this fraction of the readings is missing."""
    random = np.random.default_rng(seed)
    for _ in range(WARM_UP_STEPS + BLOCKS * BLOCK_STEPS):
        inputs = random.uniform(-1.0, 1.0, random.geometric(1.0 - missed)).tolist()
        yield inputs, tuple((np.array([37.5, 0.0]) + random.normal(0.0, 1.0, 2)).tolist())


def block_us(step: Step, block: Sequence[tuple[Inputs, Reading]]) -> float:
    """Return the mean CPU time of a step over a block of readings, µs."""
    start_ns = time.process_time_ns()
    for inputs, z in block:
        step(inputs, z, VARIANCES)
    return (time.process_time_ns() - start_ns) * 1e-3 / len(block)


def times_us(missed: float) -> list[dict[str, float]]:
    """Return the time of a step by filter, µs, for each block of each round."""
    blocks = []
    for seed in range(ROUNDS):
        gain_schedule.cache_clear()
        filters = {PLAIN: Plain().step}
        filters |= {kind: state_filter(Estimator(kind=kind), PERIOD_NS).step for kind in KINDS}
        readings = steps_of(missed, seed)
        for inputs, z in islice(readings, WARM_UP_STEPS):
            for step in filters.values():
                step(inputs, z, VARIANCES)
        while block := list(islice(readings, BLOCK_STEPS)):
            blocks.append({name: block_us(step, block) for name, step in filters.items()})
    return blocks


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """The result of a run of case 15: RMSE in m/s and m, CPU time, and true positions."""

    speed: float
    gap: float
    speed_read: float
    gap_read: float
    cpu_s: float
    positions: np.ndarray[tuple[int, ...], np.dtype[np.float64]]


def run_of(kind: str, seed: int) -> Run:
    """Run case 15 with this kind of filter on the in-process bus."""
    with tempfile.TemporaryDirectory(prefix="zenvoy-estimators-") as folder:
        out = Path(folder, "run")
        command = [sys.executable, "-m", "zenvoy.cli", "run", "paper/case-15"]
        command += ["--bus", "in-process", "--set", f"estimator.kind={kind}"]
        command += ["--seed", str(seed), "--duration-s", str(DURATION_S), "--out", str(out)]
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        subprocess.run(command, check=True, capture_output=True)
        cpu_s = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        summary = summarize(out / "run.mcap")
        return Run(
            speed=summary["speed"]["estimated"]["rmse"],
            gap=summary["gap"]["estimated"]["rmse"],
            speed_read=summary["speed"]["measured"]["rmse"],
            gap_read=summary["gap"]["measured"]["rmse"],
            cpu_s=cpu_s,
            positions=read_fleet(out / "run.mcap")[TRUTH.log_name]["position"],
        )


class Table(NamedTuple):
    """A Markdown table; the first column is text, the others are numbers."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]

    @property
    def lines(self) -> list[str]:
        """The lines of the table."""
        rule = ["---", *["---:"] * (len(self.head) - 1)]
        return [f"| {' | '.join(row)} |" for row in (self.head, rule, *self.rows)]


def time_table() -> Table:
    """Return the time of a step, and its ratio to filterpy's KalmanFilter in the same block."""
    columns = [times_us(0.0), times_us(MISSED)]
    rows = []
    for name in (PLAIN, *KINDS):
        row = [name]
        for blocks in columns:
            ratio = median(block[name] / block[PLAIN] for block in blocks)
            row += [f"{median(block[name] for block in blocks):.1f}", f"{ratio:.3f}"]
        rows.append(row)
    missed = f"{MISSED:.0%} missed"
    return Table(("filter", "every reading comes, µs", "ratio", f"{missed}, µs", "ratio"), rows)


def error_table() -> Table:
    """Return the RMSE of each filter and seed, with that of the readings for comparison."""
    head = ("filter, seed", "own speed, m/s", "gap ahead, m", "farthest from kalman, m", "CPU, s")
    rows = []
    for seed in SEEDS:
        runs = {kind: run_of(kind, seed) for kind in KINDS}
        plain = runs["kalman"]
        rows.append(
            (f"readings, {seed}", f"{plain.speed_read:.6f}", f"{plain.gap_read:.6f}", "", "")
        )
        for kind, run in runs.items():
            apart = f"{np.abs(run.positions - plain.positions).max():.1e}"
            figures = (f"{run.speed:.6f}", f"{run.gap:.6f}", apart, f"{run.cpu_s:.1f}")
            rows.append((f"{kind}, {seed}", *figures))
    return Table(head, rows)


def main() -> None:
    """Measure, print and write."""
    measured_on = facts(("filterpy", "numpy"))
    blocks = f"{ROUNDS * BLOCKS} blocks of {BLOCK_STEPS} steps"
    lines = [
        "# Estimators compared",
        "",
        "Written by `python -m benchmarks.estimators`; docs/estimators.md discusses the results.",
        "",
        *measured_on,
        "",
        f"CPU time of one step of a link: medians over {blocks}. The ratio is the median of the",
        "ratios within the blocks.",
        "",
        *time_table().lines,
        "",
        f"RMSE in the paper's case 15 ({DURATION_S} s, 40 vehicles, in-process), the largest",
        "distance of a vehicle from its position with `kalman`, and the user CPU time of the run.",
        "",
        *error_table().lines,
        "",
    ]
    RESULTS.write_text("\n".join(lines), encoding="utf-8")
    Console().print(Markdown("\n".join(lines)))


if __name__ == "__main__":
    main()
