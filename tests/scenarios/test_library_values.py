"""The built-in scenarios have the values that they should: of the paper, of norms, of theory."""

from __future__ import annotations

import re
from math import pi
from typing import Any, Final

import numpy as np
import pytest

from zenvoy.scenarios import Scenario, Sine, Trace, builtin, load, roster, technologies

S_NS: Final = 1_000_000_000
PROBES: Final = [name for name, _ in builtin() if name.startswith("probes/")]

# The paper's cases --------------------------------------------------------------------------

CASES: Final = [
    (model, error, delay_ms)
    for model in ("FM", "BCM", "MBCM", "PBCM")
    for error in (0.03, 0.1)
    for delay_ms in (100, 200)
]


@pytest.mark.parametrize(("number", "case"), list(enumerate(CASES, start=1)))
def test_cases_have_the_values_of_the_paper(number: int, case: tuple[str, float, int]) -> None:
    model, error, delay_ms = case
    scenario = load(f"paper/case-{number:02}").scenario
    base = load("paper/base").scenario
    assert scenario.control.model == "FM"
    phases = ((0, "FM"),) if model == "FM" else ((0, "FM"), (10 * S_NS, model))
    assert {own.program for own in roster(scenario)} == {phases}
    assert scenario.sensors.error == error
    assert scenario.v2v_wait_ns + scenario.system_delay_ns == delay_ms * 1_000_000
    assert 50 <= scenario.control.system_delay_ms <= 120  # the paper's t_sys
    technology = scenario.channel.technology.name
    assert technology == {100: "ieee80211p", 200: "lte-a-pro"}[delay_ms]
    for section in ("duration_s", "period_ms", "seed", "road", "fleet", "estimator", "events"):
        assert getattr(scenario, section) == getattr(base, section)
    what = f"Case {number} of the paper: {model} (throughout|after 10 s of FM), {error * 100:g} % "
    assert re.match(f"{what}measurement error, {delay_ms / 1e3} s delay$", scenario.description)


def test_the_cases_share_the_setting_of_the_paper() -> None:
    base = load("paper/base").scenario
    assert (base.duration_s, base.fleet.size, base.ring_length_m) == (500.0, 40, 1500.0)
    (brake,) = base.brakes
    values = (brake.vehicle, brake.at_s, brake.duration_s, brake.deceleration_mps2)
    assert values == (5, 10.0, 2.0, 3.0)
    assert base.channel.loss.p == 0.0


# One scenario for each technology -----------------------------------------------------------


def test_scenarios_of_technologies_differ_in_technology_and_wait_only() -> None:
    first = load("technologies/ieee80211p").scenario.model_dump()
    for name in technologies():
        values = load(f"technologies/{name}").scenario.model_dump()
        assert values["channel"]["technology"]["name"] == name
        for key in ("description", "control.v2v_wait_ms", "channel.technology"):
            *parents, last = key.split(".")
            holder, model = values, first
            for parent in parents:
                holder, model = holder[parent], model[parent]
            holder[last] = model[last]
        assert values == first


def test_heavy_loss_is_the_quickstart_with_half_the_frames() -> None:
    settings = ["channel.loss.p=0.5", f"description={load('heavy-loss').scenario.description}"]
    assert load("heavy-loss").scenario == load("quickstart", settings).scenario


# Lead vehicles ------------------------------------------------------------------------------


def test_the_trace_is_its_part_of_the_drive_cycle() -> None:
    """UN Regulation No. 83 gives the Extra-Urban Driving Cycle in seconds and km/h."""
    corners = [(61, 70), (111, 70), (119, 50), (188, 50), (201, 70), (251, 70)]
    corners += [(286, 100), (316, 100)]
    scenario = load("lead/trace").scenario
    (trace,) = scenario.events
    assert isinstance(trace, Trace)
    seconds, kmh = zip(*corners, strict=True)
    assert [time_s for time_s, _ in trace.points] == [second - 61 for second in seconds]
    assert [speed * 3.6 for _, speed in trace.points] == pytest.approx(kmh, abs=1e-3)
    assert scenario.fleet.speed_mps == trace.points[0][1]
    assert scenario.road.type == load("lead/sine").scenario.road.type == "open"
    assert trace.vehicle == load("lead/sine").scenario.profiles[0].vehicle == 1


# Probes of string stability -----------------------------------------------------------------


@pytest.mark.parametrize("name", PROBES)
def test_a_probe_is_free_of_noise_and_of_limits(name: str) -> None:
    scenario = load(name).scenario
    assert (scenario.sensors.error, scenario.channel.loss.p) == (0.0, 0.0)
    assert scenario.road.type == "open"
    (chirp,) = scenario.profiles
    assert isinstance(chirp, Sine)
    assert (chirp.vehicle, chirp.end_ns <= scenario.duration_s * S_NS) == (1, True)
    assert chirp.to_frequency_hz is not None
    frequency = np.linspace(chirp.frequency_hz, chirp.to_frequency_hz, 10_000)
    gain = fm_gain(scenario, frequency)
    assert gain.max() > 1.01  # FM amplifies, and the sweep passes the frequencies at which it does
    assert frequency[0] < frequency[gain.argmax()] < frequency[-1]
    # FM amplifies most, and more with every vehicle
    swing = chirp.amplitude_mps * 2 * pi * frequency * np.maximum(gain, 1.0) ** scenario.fleet.size
    assert swing.max() < 0.5 * scenario.control.acceleration_limit_mps2


def fm_gain(scenario: Scenario, frequency_hz: np.ndarray[Any, Any]) -> Any:
    """Return |v_i / v_(i-1)| of FM, whose command is held for a period after its delay."""
    gains = scenario.control.gains
    delay_s = (scenario.v2v_wait_ns + scenario.system_delay_ns + 0.5 * scenario.period_ns) * 1e-9
    s = 2j * pi * frequency_hz
    late = np.exp(-s * delay_s)
    numerator = (gains.k_v * s + gains.k_d) * late
    return np.abs(numerator / (s**2 + ((gains.k_v + gains.k_c) * s + gains.k_d) * late))
