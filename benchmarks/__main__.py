"""`python -m benchmarks`: measures the speed on this machine, prints it, and writes results.md.

All rows run once per round, so that a temporary load affects all of them.
"""

import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

from rich.console import Console

from benchmarks.arrays import array_rate, in_process_rate
from benchmarks.bare_zenoh import Sizes, bare_barrier
from benchmarks.channel import CHANNELS, cycle_ms
from benchmarks.convoy import convoy_rate
from benchmarks.facts import facts
from benchmarks.helics_federates import helics_steps
from benchmarks.realtime import delivery_p99_ms
from benchmarks.tables import Part, Row, markdown, rates_of, table_of
from zenvoy.scenarios import Channel

RESULTS = Path(__file__).with_name("results.md")
PACKAGES = ("eclipse-zenoh", "helics", "cavsandbox", "libsumo")
VEHICLES, PERIOD_S = 40, 0.1  # as in the paper's case 15


def _bare(vehicles: int, cycles: int) -> Row:
    rate = partial(bare_barrier, vehicles, cycles, Sizes.of_fleet(vehicles))
    return Row(f"bare Zenoh barrier, {vehicles} vehicles", rate)


def _overlapped(vehicles: int, cycles: int) -> Row:
    rate = partial(bare_barrier, vehicles, cycles, Sizes.of_fleet(vehicles), lookahead=1)
    return Row(f"bare Zenoh barrier, overlapped, {vehicles} vehicles", rate)


def _convoy(vehicles: int, cycles: int, per_process: int = 1) -> Row:
    rate = partial(convoy_rate, vehicles, cycles, "zenoh", per_process)
    return Row(f"Zenvoy, {_processes(vehicles, per_process)}", rate)


def _realtime(vehicles: int, per_process: int = 1) -> Row:
    rate = partial(delivery_p99_ms, vehicles, per_process)
    return Row(f"real time, {_processes(vehicles, per_process)}", rate)


def _processes(vehicles: int, per_process: int) -> str:
    if per_process == 1:
        return f"{vehicles} vehicle processes"
    return f"{vehicles} vehicles, {per_process} to a process"


def _in_process() -> float:
    """Return the vehicle-seconds that Zenvoy simulates per second in one process."""
    return VEHICLES * PERIOD_S * convoy_rate(VEHICLES, 300, "in-process")


def _cavsandbox() -> float:
    """Return the same for CAVSandbox, in a separate process so that other rows do not suffer."""
    command = [sys.executable, "-m", "benchmarks.cavsandbox_platoon"]
    return float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def _channel_us(channel: Channel, vehicles: int) -> float:
    return 1e3 * cycle_ms(channel, vehicles)


def _sumo(commands: str) -> float:
    """Return the same for SUMO alone, or with speeds that Python reads and sets."""
    command = [sys.executable, "-m", "benchmarks.sumo_road", str(VEHICLES), "500", commands]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return float(printed.splitlines()[-1])  # libsumo may print a warning first


def _arrays(vehicles: int, runs: int, duration_s: float) -> Row:
    name = f"arrays, {vehicles:,} vehicles, {runs} {'runs' if runs > 1 else 'run'}"
    return Row(name, partial(array_rate, vehicles, runs, duration_s))


CYCLES = Part(
    "cycles/s",
    [
        _convoy(10, 800),
        _convoy(40, 300),
        _convoy(40, 300, 10),
        _convoy(100, 100),
        _convoy(100, 100, 25),
        Row("Zenvoy, 40 vehicles in one process", partial(convoy_rate, 40, 300, "in-process")),
        _bare(10, 800),
        _bare(40, 300),
        _bare(100, 100),
        _overlapped(40, 300),
        Row("HELICS (zmq), 40 federates", partial(helics_steps, 40, 300, "zmq")),
        Row("HELICS (ipc), 40 federates", partial(helics_steps, 40, 300, "ipc")),
    ],
)
STRINGS = Part(
    "vehicle-seconds/s",
    [
        Row("Zenvoy, case 15, 40 vehicles in one process", _in_process),
        Row("CAVSandbox, CACC, 40 vehicles in one process", _cavsandbox),
    ],
    """\
Seconds of simulated time, times 40 vehicles, per second of wall time on one core. The two programs
do not compute the same:

- Zenvoy takes 10 cycles per simulated second, CAVSandbox 100 steps (its workbook has no setting
  for that). The values times 10 and 100 are the updates of a vehicle per second.
- In a cycle of Zenvoy every vehicle encodes, decodes and checks its messages, the channel decides
  on every frame at each of the 39 receivers, and everything is logged. The control is bilateral
  (PBCM), with a filter for each of two links and one for the own speed. Motion is exact.
- In a step of CAVSandbox every vehicle reads a radar with delay and correlated noise. It runs a
  Kalman filter on the readings, a second one that fuses V2V messages, CACC, and actuators with lag.
  A message is the acceleration of the vehicle ahead, ten times a second, here without delay or
  loss. A vehicle receives no other messages, and none is encoded.
- Zenvoy's value covers the cycles after the first 12 s, with their MCAP log. CAVSandbox's value
  covers its loop and its CSV at 10 rows per second and vehicle, without start, window or plots.
""",
)
CHANNEL = Part(
    "µs of CPU per cycle",
    [
        Row(f"{name}, {size:,} vehicles", partial(_channel_us, channel, size))
        for name, channel in CHANNELS.items()
        for size in (40, 200, 1_000)
    ],
    """\
CPU time of the channel's agent for a cycle in which every vehicle sends a beacon and has 20 others
in range. It includes decoding the beacons, deliveries and the log, but not Zenoh.
""",
)
REALTIME = Part(
    "ms",
    [
        *(_realtime(size) for size in (10, 20, 40)),
        _realtime(40, 10),
        _realtime(100, 25),
    ],
    """\
Lateness of deliveries against the instants drawn for them, 99th percentile over 20 s in real time.
The scenario is quickstart with other fleet sizes and decisions 25 ms after the start of a cycle.
docs/real-time.md has more values, from longer runs.
""",
)
STUDIES = Part(
    "vehicle-seconds per second of CPU",
    [
        Row("in process, 40 vehicles, 1 run, with its log", partial(in_process_rate, 40, 100.0)),
        _arrays(40, 1, 500.0),
        _arrays(40, 30, 500.0),
        _arrays(40, 10, 200.0),
        _arrays(40, 100, 200.0),
        _arrays(40, 300, 100.0),
        _arrays(200, 1, 200.0),
        _arrays(1_000, 1, 100.0),
        Row("SUMO, 40 vehicles", partial(_sumo, "alone")),
        Row("SUMO, 40 vehicles, Python reads and sets each speed", partial(_sumo, "commands")),
    ],
    """\
Seconds of simulated time, times vehicles, times runs, per second of CPU on one core. The scenario
is the paper's case 15 (PBCM, a filter for each of two links and one for the own speed, errors of
readings). Arrays run without a log, from the loaded scenarios to the last cycle. SUMO moves
vehicles on a straight road under its own car-following model, 10 steps per second, without V2V,
errors or filters. Divided by the vehicles, a rate of one run says how many times real time it is.
The ratios are medians over the rounds.
""",
    ratios=True,
)
PARTS = (CYCLES, STRINGS, CHANNEL, STUDIES, REALTIME)


def main() -> None:
    # Raise an exception on SIGTERM, so that processes and socket folders are cleaned up.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    console = Console()
    measured_on = facts(PACKAGES)
    rates = rates_of(PARTS, console)
    for part in PARTS:
        console.print(table_of(part, rates))
    RESULTS.write_text(markdown(measured_on, PARTS, rates), encoding="utf-8")


if __name__ == "__main__":
    main()
