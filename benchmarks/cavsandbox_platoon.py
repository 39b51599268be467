"""CAVSandbox for comparison: a string of cars under CACC in one process, as its manual runs it.

40 cars 37.5 m apart at 30 m/s. The first follows a speed profile that brakes by 6 m/s at 10 s; the
others run CACC on a radar with noise and delay, a Kalman filter, and V2V messages at 10 Hz with a
second Kalman filter that fuses them. A workbook holds all settings that it has; the rest stays as
it is (its step of 10 ms, actuators with lag). The time covers its loop without a window, and the
writing of its CSV.

`python -m benchmarks.cavsandbox_platoon` prints only the rate, for `python -m benchmarks`. So
pandas and pygame, its dependencies, stay out of the process that measures the others.
"""

import sys
import tempfile
import time
from pathlib import Path

import pandas as pd
from cacc_sim import SimulationLoop, load_vehicles

VEHICLES = 40
GAP_M = 37.5
SPEED_MPS = 30.0
LENGTH_M = 5.0
STANDSTILL_GAP_M = 2.0
WARM_UP_S = 2.0
SIMULATED_S = 20.0
STEPS_PER_S = 100
LOG_RATE_HZ = 10


def platoon_rate() -> float:
    """Return vehicle-seconds simulated per second of wall time; RuntimeError if cars collide."""
    with tempfile.TemporaryDirectory(prefix="zenvoy-cavsandbox-") as folder:
        _run(Path(folder), WARM_UP_S)
        return VEHICLES * SIMULATED_S / _run(Path(folder), SIMULATED_S)


def _run(folder: Path, duration_s: float) -> float:
    """Run once and return the wall time, s."""
    workbook = folder / "platoon.xlsx"
    _write(workbook, duration_s)
    vehicles, config = load_vehicles(str(workbook))
    loop = SimulationLoop(vehicles, config)
    start_ns = time.perf_counter_ns()
    log = loop.run()
    log.to_csv(folder / "data.csv", index=False)
    elapsed_s = (time.perf_counter_ns() - start_ns) * 1e-9
    if len(log) != round(VEHICLES * duration_s * LOG_RATE_HZ):
        raise RuntimeError("cars collided in CAVSandbox")
    return elapsed_s


def _write(workbook: Path, duration_s: float) -> None:
    headway_s = (GAP_M - LENGTH_M - STANDSTILL_GAP_M) / SPEED_MPS
    settings = {
        "duration_s": duration_s,
        "simulation_speed": 0,  # no window
        "sensor_model": "kalman",
        "comms_model": "v2v",
        "bsm_packet_drop_rate": 0.0,
        "cacc_target_headway_s": headway_s,
        "cacc_s0_m": STANDSTILL_GAP_M,
        "log_rate_hz": LOG_RATE_HZ,
        "a_max_mps2": 3.0,
        "a_min_mps2": -3.0,
        "master_seed": 1,
    }
    profile = {  # the speed reaches the value of a row at the time of the next row
        "time_s": [0.0, 10.0, 12.0],
        "value": [SPEED_MPS, SPEED_MPS - 6.0, SPEED_MPS],
        "transition": "ramp",
    }
    with pd.ExcelWriter(workbook) as sheets:
        pd.Series(settings).to_excel(sheets, sheet_name="simulation", header=False)
        pd.DataFrame(_vehicles()).to_excel(sheets, sheet_name="vehicles", index=False)
        pd.DataFrame(profile).to_excel(sheets, sheet_name="profile", index=False)


def _vehicles() -> list[dict[str, object]]:
    """Return a row for each car, from the first to the last."""
    return [
        {
            "vehicle_id": i,
            "model": "CACCModel" if i > 1 else "LEAD_PROFILE",
            "initial_position_m": (VEHICLES - i) * GAP_M,
            "initial_speed_mps": SPEED_MPS,
            "desired_speed_mps": 1.2 * SPEED_MPS,
            "vehicle_length_m": LENGTH_M,
            "leader_id": i - 1 if i > 1 else None,
            "filter": "passthrough",
        }
        for i in range(1, VEHICLES + 1)
    ]


if __name__ == "__main__":
    sys.stdout.write(f"{platoon_rate()}\n")
