"""Fleets without noise and loss move as linear theory predicts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.logs import write_log
from zenvoy.analysis.log.load import Run, load
from zenvoy.analysis.measures.stability import response
from zenvoy.analysis.theory.chain import frequency_response
from zenvoy.analysis.theory.disturbed import Disturbed, disturbed
from zenvoy.analysis.theory.laws import FM, Coupling, is_string_stable, peak_gain, transfer
from zenvoy.analysis.theory.of_run import theory_of
from zenvoy.analysis.theory.ring import slowest_mode
from zenvoy.analysis.theory.ring_modes import ModeRow, measured_modes
from zenvoy.scenarios import Gains

Floats = NDArray[np.float64]

# Gentle enough that no vehicle comes near ±3 m/s², the limit of acceleration.
BRAKE = "{type: brake, vehicle: 1, at_s: 5, duration_s: 2, deceleration_mps2: 0.5}"
CHIRP = """{type: sine, vehicle: 1, at_s: 5, duration_s: 60, amplitude_mps: 0.3,
            frequency_hz: 0.01, to_frequency_hz: 0.15}"""


def ran(folder: Path, scenario: str, event: str = BRAKE) -> tuple[Run, Disturbed]:
    text = f"sensors: {{error: 0}}\nevents: [{event}]\n{scenario}"
    run = load(write_log(folder / "run.mcap", text))
    case = disturbed(run)
    assert isinstance(case, Disturbed), case
    assert np.abs(run.truth["acceleration"]).max() < 2.9
    assert case.noise < 1e-3
    return run, case


def gain_per_vehicle(run: Run, case: Disturbed) -> tuple[Floats, Floats]:
    """Return frequencies (rad/s), and the gain per vehicle: the root of the gain of all."""
    acceleration = run.truth["acceleration"][case.rows]
    found = response(acceleration[:, 0], acceleration[:, -1], case.period_s, 0.05)
    return found.omega, np.abs(found.ratio) ** (1.0 / (run.vehicles - 1))


# --- FM on the open road ------------------------------------------------------------------------


def test_the_peak_gain_of_fm_agrees_with_theory(tmp_path: Path) -> None:
    """The delay is small, since cycles have 20 ms and vehicles do not wait."""
    run, case = ran(
        tmp_path,
        """
duration_s: 70
period_ms: 20
fleet: {size: 4}
road: {type: open}
control: {model: FM, v2v_wait_ms: 0, system_delay_ms: 0}
""",
    )
    omega, gain = gain_per_vehicle(run, case)
    peak = peak_gain(run.scenario.control.gains)
    assert peak.gain > 1.1
    assert gain.max() == pytest.approx(peak.gain, rel=0.01)
    assert omega[gain.argmax()] == pytest.approx(peak.omega, abs=2.0 * np.pi / 65.0)
    slow = omega < 2.0
    theory = np.abs(transfer(omega[slow], run.scenario.control.gains, 0.01))
    np.testing.assert_allclose(gain[slow], theory, rtol=0.01)


@pytest.mark.parametrize(("delay_ms", "period_ms"), [(300, 100), (89, 500)])
def test_delay_and_half_a_period_raise_the_peak_as_theory_says(
    tmp_path: Path, delay_ms: int, period_ms: int
) -> None:
    run, case = ran(
        tmp_path,
        f"""
duration_s: 120
period_ms: {period_ms}
fleet: {{size: 5}}
road: {{type: open}}
control: {{model: FM, v2v_wait_ms: 11, system_delay_ms: {delay_ms}}}
""",
    )
    omega, gain = gain_per_vehicle(run, case)
    delay_s = (11 + delay_ms + period_ms / 2) * 1e-3
    gains = run.scenario.control.gains
    theory = np.abs(transfer(omega, gains, delay_s))
    assert peak_gain(gains, delay_s).gain > 1.03 * peak_gain(gains).gain
    assert gain.max() == pytest.approx(theory.max(), rel=0.01)
    without_hold = np.abs(transfer(omega, gains, delay_s - period_ms / 2 * 1e-3))
    assert abs(without_hold.max() - gain.max()) > 3.0 * abs(theory.max() - gain.max())


def test_a_string_stable_fm_damps(tmp_path: Path) -> None:
    run, case = ran(
        tmp_path,
        """
duration_s: 120
fleet: {size: 5}
road: {type: open}
control: {model: FM, gains: {k_d: 0.04, k_v: 0.5, k_c: 0.1}}
""",
        CHIRP,
    )
    assert is_string_stable(run.scenario.control.gains)
    omega, gain = gain_per_vehicle(run, case)
    assert gain.max() < 1.0
    theory = np.abs(transfer(omega, run.scenario.control.gains, 0.15))
    seen = theory > 0.5  # for four vehicles that is a sixteenth
    np.testing.assert_allclose(gain[seen], theory[seen], rtol=0.02)


# --- strings ------------------------------------------------------------------------------------


STRINGS = {
    "BCM": "road: {type: open}\ncontrol: {model: BCM}\nfleet: {size: 7}",
    "MBCM": "road: {type: open}\ncontrol: {model: MBCM}\nfleet: {size: 9}",
    "uniform MBCM of two": """
control: {model: MBCM, multi_node: {neighbours: 2, weights: uniform}}
fleet: {size: 7}""",
    "PBCM": "control: {model: PBCM}\nfleet: {size: 6}",
    "FM with a lag": """
road: {type: open}
fleet: {size: 5}
vehicle: {actuator_lag_s: 0.5}
control: {model: FM, gains: {k_d: 0.1, k_v: 0.5, k_c: 0.2}}""",
    "lags that differ": """
road: {type: open}
control: {model: BCM}
vehicle: {actuator_lag_s: 0.2}
fleet: {size: 6, groups: [{name: slow, vehicles: "3,5", vehicle: {actuator_lag_s: 0.8}}]}""",
    "a mix on the ring": """
control: {model: FM}
fleet:
  size: 10
  groups:
    - {name: linked, vehicles: 2-5, model: BCM}
    - {name: many, vehicles: 8, model: MBCM, gains: {k_d: 0.2, k_v: 0.8, k_c: 0.1}}""",
}


@pytest.mark.parametrize("scenario", STRINGS.values(), ids=STRINGS)
def test_a_string_moves_as_theory_says(tmp_path: Path, scenario: str) -> None:
    """From the motion of the first vehicle, theory predicts the speeds of all others."""
    _, case = ran(tmp_path, f"duration_s: 90\n{scenario}", CHIRP)
    assert case.predicted is not None
    assert case.notes == ()
    largest = np.abs(case.deviation[:, case.source]).max()
    others = np.arange(case.deviation.shape[1]) != case.source
    assert np.abs(case.deviation[:, others]).max() > 0.3 * largest
    assert np.abs(case.predicted - case.deviation).max() < 0.02 * largest


def test_the_gain_of_a_bilateral_string_agrees_with_theory(tmp_path: Path) -> None:
    run, case = ran(tmp_path, "duration_s: 120\n" + STRINGS["BCM"])
    assert case.theory is not None
    acceleration = run.truth["acceleration"][case.rows]
    for vehicle in (1, 3, 6):
        found = response(acceleration[:, 0], acceleration[:, vehicle], case.period_s, 0.05)
        slow = found.omega < 1.0
        theory = frequency_response(found.omega[slow], case.theory.members, 0, ring=False)
        np.testing.assert_allclose(
            np.abs(found.ratio[slow]), np.abs(theory[:, vehicle]), rtol=0.02, atol=2e-3
        )


# --- the ring -----------------------------------------------------------------------------------


def slowest_modes(folder: Path, scenario: str) -> dict[int, ModeRow]:
    event = "{type: brake, vehicle: 3, at_s: 2, duration_s: 2, deceleration_mps2: 0.5}"
    run, case = ran(folder, scenario, event)
    return {row.number: row for row in measured_modes(run, case).rows}


@pytest.mark.parametrize(
    "settings",
    [
        "control: {model: BCM}",
        "control: {model: MBCM}",
        "control: {model: PBCM}",
        "control: {model: BCM}\nvehicle: {actuator_lag_s: 0.5}",
        "control: {model: PBCM}\nvehicle: {actuator_lag_s: 0.5}",
    ],
)
def test_modes_of_the_ring_decay_as_theory_says(tmp_path: Path, settings: str) -> None:
    rows = slowest_modes(tmp_path, f"duration_s: 100\nfleet: {{size: 12}}\n{settings}")
    for number in (1, 2, 3):
        measured, theory = rows[number].measured, rows[number].theory
        assert measured is not None
        assert theory is not None
        assert measured.rate == pytest.approx(theory.rate, rel=0.01)
        assert measured.omega == pytest.approx(theory.omega, rel=0.01, abs=1e-3)
        assert measured.r2 > 0.999


def test_bcm_decays_as_its_polynomial_says(tmp_path: Path) -> None:
    """The modes solve s² + (k_v λ + k_c) s + k_d λ = 0, λ = 2 (1 - cos(2π/7)), almost undelayed."""
    rows = slowest_modes(
        tmp_path,
        """
duration_s: 50
period_ms: 20
fleet: {size: 7}
control: {model: BCM, v2v_wait_ms: 11, system_delay_ms: 0}
""",
    )
    lam = 2.0 * (1.0 - np.cos(2.0 * np.pi / 7.0))
    slow = np.roots([1.0, 0.5 * lam + 0.05, 0.1 * lam])
    measured = rows[1].measured
    assert measured is not None
    assert measured.rate == pytest.approx(slow.real.max(), rel=0.05)
    assert measured.omega == pytest.approx(abs(slow.imag).max(), rel=0.05)


def test_fm_grows_on_the_ring_as_theory_says(tmp_path: Path) -> None:
    scenario = "duration_s: 60\nfleet: {size: 14}\ncontrol: {model: FM}"
    rows = slowest_modes(tmp_path, scenario)
    fastest = slowest_mode(FM, Gains(), 14, 0.15)
    assert fastest.rate > 0.02
    measured = rows[fastest.number].measured
    assert measured is not None
    assert measured.rate == pytest.approx(fastest.rate, rel=0.01)
    assert measured.omega == pytest.approx(fastest.omega, rel=0.01)


def test_theory_of_a_short_chain_has_the_weights_that_vehicles_use(tmp_path: Path) -> None:
    """With weights 0.5, 0.3, 0.2, a vehicle with one neighbour on each side uses 1."""
    text = """
    duration_s: 3
    road: {type: open}
    fleet: {size: 4}
    control: {model: MBCM, multi_node: {neighbours: 3, weights: [0.5, 0.3, 0.2]}}
    """
    run = load(write_log(tmp_path / "run.mcap", text))
    members = theory_of(run, 1.0, 3.0).members
    assert members[1].coupling == members[2].coupling == Coupling((1.0,), (1.0,))
