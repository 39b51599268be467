"""dCACC is Ploeg's law while it hears the vehicle ahead, and estimates its acceleration if not."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
import pytest

import zenvoy
from zenvoy.analysis.log.export import export
from zenvoy.analysis.log.load import Run, load
from zenvoy.bus import messages_pb2 as pb
from zenvoy.laws import Motion, Observation, Output, Relative, Setpoint
from zenvoy.laws.law import SILENT
from zenvoy.laws.library import dcacc, ploeg
from zenvoy.laws.singer import Singer, Track, corrected, predicted, steady_gains

NAN = float("nan")
OWN = dcacc.Parameters()
SEEN = Observation(
    20.0,
    Setpoint(0.1, 0.5, 0.05, 37.5, 25.0),
    Relative(18.0, 0.6),
    predecessor=Motion(20.6, NAN, command=-1.5),
    period_s=0.02,
    acceleration=0.25,
    length_m=5.0,
)
TRACK = Track(17.5, 0.4, -0.8)
SINGER = Singer(0.8, 1.68, 0.17, 0.13)


def decided(seen: Observation, *state: float) -> Output:
    return dcacc.graceful(seen._replace(state=state), OWN)


def next_track() -> Track:
    gains = steady_gains(SINGER, 0.02)
    return corrected(predicted(TRACK, 0.25, SINGER, 0.02), SEEN.ahead, gains)


def test_with_a_report_the_command_is_that_of_ploeg() -> None:
    found = decided(SEEN, 0.3, *TRACK)
    expected = ploeg.headway(SEEN._replace(state=(0.3,)), ploeg.Parameters())
    assert found.acceleration == expected.acceleration
    assert found.state == (expected.acceleration, *next_track())


def test_without_a_report_the_estimate_takes_the_place_of_the_command() -> None:
    found = decided(SEEN._replace(predecessor=SILENT), 0.3, *TRACK)
    estimate = next_track().a
    instead = SEEN._replace(predecessor=Motion(NAN, NAN, command=estimate), state=(0.3,))
    assert found.acceleration == ploeg.headway(instead, ploeg.Parameters()).acceleration
    assert found.logged == (estimate,)


def test_the_track_begins_at_the_first_reading() -> None:
    found = decided(SEEN, NAN, NAN, NAN, NAN)
    assert found.state[1:] == (18.0, 0.6, 0.0)


# --- runs ---

SCENARIO: Final = """
duration_s: 90
period_ms: 50
road: {type: open}
fleet: {size: 3, bumper_gap_m: 22, speed_mps: 25}
control:
  model: MODEL
  parameters: {headway_s: 0.8}
  desired_bumper_gap_m: 22
  desired_speed_mps: 25
  acceleration_limit_mps2: 6
  system_delay_ms: 0
  v2v_wait_ms: 0
  beacon_age_limit_ms: 200
sensors: {error: 0}
"""
SINE: Final = """
events:
  - type: sine
    vehicle: 1
    at_s: 2
    duration_s: 88
    mean_mps: 25
    amplitude_mps: 1
    frequency_hz: 0.05
"""
MUTE: Final = "groups: [{name: mute, vehicles: all, beacons: false}]"
LATE: Final = slice(900, 1_700)  # rows, after the start has died away


def ran(folder: Path, *changes: tuple[str, str]) -> Run:
    text = SCENARIO + SINE
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    folder.mkdir()
    (folder / "s.yaml").write_text(text)
    return load(zenvoy.run(folder / "s.yaml", engine="arrays", out=folder / "run").log)


def silent(folder: Path, std: str = "1.68") -> Run:
    return ran(
        folder,
        ("MODEL", "dCACC"),
        ("speed_mps: 25}", f"speed_mps: 25, {MUTE}}}"),
        ("headway_s: 0.8", f"headway_s: 0.8, acceleration_std_mps2: {std}"),
    )


def test_a_run_without_losses_is_that_of_ploeg(tmp_path: Path) -> None:
    runs = [ran(tmp_path / model, ("MODEL", model)) for model in ("Ploeg", "dCACC")]
    np.testing.assert_array_equal(runs[0].truth["position"], runs[1].truth["position"])


def test_in_silence_the_estimate_is_near_the_truth(tmp_path: Path) -> None:
    run = silent(tmp_path / "silent")
    assert set(run.estimate["mode"][1:, 1:].ravel()) == {pb.MODE_DCACC}
    estimate = run.estimate["dCACC.acceleration_ahead"]
    assert run.units["/fleet/estimate"]["dCACC.acceleration_ahead"] == "m/s²"
    for vehicle in (1, 2):
        ahead = run.truth["acceleration"][LATE, vehicle - 1]
        assert np.abs(estimate[LATE, vehicle] - ahead).max() < 0.3 * np.abs(ahead).max()


def gain(std: str) -> float:
    """Return what a follower makes of a speed of 0.05 Hz ahead, in silence, from cycle to cycle.

    Every acceleration is constant within a cycle. So with z = e^(s T) a command becomes a speed by
    T / (z - 1), a position by T² (z + 1) / (2 (z - 1)²), and a reading of itself by 1 / z.
    """
    period_s, own, unit = 0.05, ploeg.Parameters(headway_s=0.8), np.eye(3)
    z = np.exp(2j * np.pi * 0.05 * period_s)
    v, p = period_s / (z - 1), period_s**2 * (z + 1) / (2 * (z - 1) ** 2)
    model = Singer(0.8, float(std), 0.17, 0.13)
    gains, nothing = steady_gains(model, period_s), Relative(0.0, 0.0)
    columns = [predicted(Track(*one), 0.0, model, period_s) for one in unit]
    kept = np.array([corrected(one, nothing, gains) for one in columns]).T  # the filter is linear
    fed = np.array(corrected(Track(0.0, 0.0, 0.0), Relative(p, v), gains))
    estimate = np.linalg.solve(z * unit - kept, z * fed)[2]
    share = period_s / own.headway_s
    lag = share * z / (z - 1 + share)
    own_part = own.k_p * (p + own.headway_s * v) + own.k_d * (v + own.headway_s / z)
    return float(abs(lag * (own.k_p * p + own.k_d * v + estimate) / (1 + lag * own_part)))


@pytest.mark.parametrize("std", ["1.68", "0.000001"])
def test_in_silence_swings_grow_as_theory_says(tmp_path: Path, std: str) -> None:
    """With hardly any noise in the model the estimate is 0: the law feeds nothing forward."""
    run = silent(tmp_path / "silent", std)
    first, second, third = np.ptp(run.truth["speed"][LATE], axis=0)
    expected = gain(std)
    assert second / first == pytest.approx(expected, rel=1e-3)
    assert third / second == pytest.approx(expected, rel=1e-3)
    assert (expected > 1.15) == (std != "1.68")


def test_exports_name_the_law_and_its_column(tmp_path: Path) -> None:
    run = silent(tmp_path / "silent")
    (file,) = [path for path in export(run, tmp_path / "csv", "csv") if "estimate" in path.name]
    with file.open() as lines:
        assert next(lines).endswith(',"dCACC.acceleration_ahead_mps2"\n')
        assert '"dCACC"' in next(lines) + next(lines)
