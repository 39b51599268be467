"""The built-in scenarios have the values that they should, and each of them runs."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from importlib.resources import files
from math import pi
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from ruamel.yaml import YAML

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.in_process import InProcessBus
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import EVENTS, FRAMES, TRUTH, Topic
from zenvoy.fleet.agents import agents_of
from zenvoy.scenarios import (
    Loaded,
    Scenario,
    Sine,
    Trace,
    builtin,
    effective_yaml,
    load,
    roster,
    technologies,
)

ROOT: Final = Path(__file__).parents[2]
NAMES: Final = [name for name, _ in builtin()]
S_NS: Final = 1_000_000_000


def run(scenario: Scenario) -> dict[Topic[Any], list[bytes]]:
    """Return the messages that the log of a run would have, by topic."""
    log: dict[Topic[Any], list[bytes]] = {}

    def keep(topic: Topic[Any], _time_ns: int, data: bytes) -> None:
        log.setdefault(topic, []).append(data)

    InProcessBus(agents_of(scenario), keep).run()
    return log


def shortened(name: str) -> Loaded:
    """Load a scenario with few vehicles and three seconds, and move its events into them."""
    whole = load(name).scenario
    settings = ["duration_s=3", f"fleet.size={min(7, whole.fleet.size)}"]  # MBCM needs 7
    for i, group in enumerate(whole.fleet.groups):
        settings += [f"fleet.groups.{i}.vehicles=1-4"] if group.vehicles else []
    settings += [f"events.{i}.at_s=1" for i, _ in enumerate(whole.events)]
    settings += [f"faults.{i}.at_s=1" for i, _ in enumerate(whole.faults)]
    settings += [f"control.schedule.{i}.at_s={i + 1}" for i, _ in enumerate(whole.control.schedule)]
    return load(name, settings)


@pytest.mark.parametrize("name", NAMES)
def test_each_scenario_runs_to_the_end(name: str) -> None:
    scenario = shortened(name).scenario
    log = run(scenario)
    truth = [pb.FleetTruth.FromString(data) for data in log[TRUTH]]
    assert [row.time_ns for row in truth[:: scenario.cycles]] == [0, 3 * S_NS]
    assert all(np.isfinite(row.position).all() for row in truth)
    events = [pb.Event.FromString(data) for data in log[EVENTS]] if EVENTS in log else []
    kinds = {event.kind for event in events}
    assert not kinds & {pb.EVENT_COLLISION, pb.EVENT_STOPPED}
    assert (pb.EVENT_BRAKE in kinds) == bool(scenario.brakes)
    assert (pb.EVENT_FAULT in kinds) == bool(scenario.faults)
    returns = any(brake.return_s is not None for brake in scenario.brakes)  # it counts as a trace
    assert (pb.EVENT_TRACE in kinds) == (bool(scenario.profiles) or returns)
    schedule = scenario.control.schedule
    assert (pb.EVENT_MODEL in kinds) == any(switch.model for switch in schedule)
    assert (pb.EVENT_TARGET in kinds) == any(switch.targets for switch in schedule)


@pytest.mark.parametrize("name", NAMES)
def test_frames_are_in_time_unless_they_are_lost(name: str) -> None:
    """The wait of each scenario fits its technology."""
    scenario = shortened(name).scenario
    log = run(scenario)
    codec = PackedCodec(pb.Frames.DESCRIPTOR)
    outcomes = np.concatenate([codec.decode(data)["outcome"] for data in log[FRAMES]])
    allowed = {pb.OUTCOME_DELIVERED, pb.OUTCOME_OUT_OF_RANGE, pb.OUTCOME_LOST}
    if any(fault.type == "transmitter-babbling" for fault in scenario.faults):
        allowed |= {pb.OUTCOME_COLLIDED, pb.OUTCOME_LATE}
    assert set(outcomes.tolist()) <= allowed
    loss = load(name).scenario.channel.loss
    lost = float(np.mean(outcomes == pb.OUTCOME_LOST))
    bursts = loss.gilbert_elliott
    # 30 cycles of 7 vehicles or so: 1260 frames, so ±0.1 is six standard deviations. In bursts of
    # 10 frames, about 14 neighbouring frames count as one.
    share, margin = (bursts.p / (bursts.p + bursts.r), 0.3) if bursts.p else (loss.p, 0.1)
    assert lost == pytest.approx(share, abs=margin if share else 0.0)


@pytest.mark.parametrize("name", NAMES)
def test_each_scenario_is_written_and_read_back(name: str, tmp_path: Path) -> None:
    scenario = load(name).scenario
    path = tmp_path / "s.yaml"
    path.write_text(effective_yaml(scenario))
    assert load(path).scenario == scenario


def test_each_scenario_has_its_own_description() -> None:
    lines = [description for _, description in builtin()]
    assert len(set(lines)) == len(lines)
    assert all(0 < len(line) <= 100 and line.isprintable() for line in lines)


def _leaves(values: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    if not isinstance(values, dict):
        yield path, values
        return
    for key, value in values.items():
        yield from _leaves(value, (*path, key))


EXTENSIONS: Final = [name for name in NAMES if re.search("^extends:", load(name).text, re.M)]


@pytest.mark.parametrize("name", EXTENSIONS)
def test_an_extension_has_only_what_differs(name: str) -> None:
    written = YAML(typ="safe", pure=True).load(load(name).text)
    base = dict(_leaves(load(written.pop("extends")).scenario.model_dump(mode="json")))
    assert [path for path, value in _leaves(written) if base.get(path) == value] == []


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


@pytest.mark.parametrize("name", [name for name in NAMES if name.startswith("probes/")])
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


# The package --------------------------------------------------------------------------------


def test_the_package_includes_every_file_of_the_library() -> None:
    """The test applies package-data as setuptools does."""
    data = tomllib.loads((ROOT / "pyproject.toml").read_text())
    patterns = data["tool"]["setuptools"]["package-data"]["*"]
    folder = ROOT / "scenarios"
    taken = {path for pattern in patterns for path in folder.glob(pattern)}
    assert [p for p in folder.rglob("*") if p.suffix in {".yaml", ".csv"} and p not in taken] == []
    names = {p.relative_to(folder).with_suffix("").as_posix() for p in folder.rglob("*.yaml")}
    assert names == {*NAMES, *(f"radios/{name}" for name in technologies())}
    assert all(files("zenvoy.scenarios").joinpath(f"{name}.yaml").is_file() for name in NAMES)
