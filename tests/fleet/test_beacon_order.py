"""A platoon whose beacons are rarer than its decisions swings, with beacons at once or in turn."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Final

import numpy as np
import pytest
from numpy.typing import NDArray

from zenvoy.fleet.arrays.batch import Batch
from zenvoy.scenarios import load

OMEGA: Final = 2.0 * math.pi * 0.2  # of the leader's speed, rad/s
SWING: Final = 2.7778 * OMEGA  # of the leader's acceleration, m/s²
CYCLE_S: Final = 0.02

SCENARIO: Final = f"""
duration_s: 120
period_ms: {1e3 * CYCLE_S:g}
road: {{type: open}}
fleet: {{size: 8, length_m: 4, bumper_gap_m: 5, speed_mps: 27.7778}}
control: {{model: CACC, desired_bumper_gap_m: 5, acceleration_limit_mps2: 8, system_delay_ms: 0,
  desired_speed_mps: 27.7778}}
sensors: {{error: 0}}
events:
  - {{type: sine, vehicle: 1, at_s: 5, duration_s: 115, mean_mps: 27.7778, amplitude_mps: 2.7778,
     frequency_hz: 0.2}}
"""


def amplitudes(folder: Path, beacons: str) -> NDArray[np.float64]:
    """Return the amplitudes of the gaps of vehicles 2 to 8 at 0.2 Hz over the last 20 s, m."""
    (folder / "s.yaml").write_text(f"{SCENARIO}beacons: {beacons}\n")
    cycles = Batch([load(folder / "s.yaml").scenario]).cycles()
    position = np.array([cycle.position for cycle in cycles])[-1000:]
    angle = OMEGA * CYCLE_S * np.arange(1000)
    columns = np.column_stack([np.cos(angle), np.sin(angle), np.ones(1000)])
    parts, *_ = np.linalg.lstsq(columns, -np.diff(position, axis=1), rcond=None)
    return np.asarray(np.hypot(parts[0], parts[1]))


def test_swings_of_gaps_fall_along_a_platoon_whose_beacons_are_sent_at_once(tmp_path: Path) -> None:
    found = amplitudes(tmp_path, "{period_ms: 100}")
    assert (found[2:] / found[1:-1] < 0.6).all()


@pytest.mark.parametrize(
    "beacons", ["{period_ms: 100, staggered: true}", "{rule: every-nth, every: 5}"]
)
def test_swings_of_gaps_do_not_fall_where_vehicles_send_in_turn(
    tmp_path: Path, beacons: str
) -> None:
    """A vehicle hears the leader in cycle 0, and the vehicle ahead one cycle later than that one.

    What the vehicle ahead reports is up to date whenever it is sent. So each vehicle acts half a
    cycle later than the one ahead, as c1 is 0.5, and the gaps swing by what that costs.
    """
    found = amplitudes(tmp_path, beacons)
    apart = SWING * OMEGA * 0.5 * CYCLE_S  # of the accelerations of two neighbours, m/s²
    follows = abs(1j * OMEGA * (1j * OMEGA + 0.1))  # the leader's weight is c1 · ξ · ω_n, s⁻¹
    assert found[3:6] == pytest.approx(apart / follows, rel=0.08)
    assert found[6] > found[5]  # vehicle 7 sends in cycle 1 again
