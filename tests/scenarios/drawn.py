"""Draws scenarios with all their keys."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

from zenvoy.laws import builtin
from zenvoy.scenarios import (
    Brake,
    Channel,
    Control,
    Estimator,
    Fleet,
    Gains,
    Group,
    Loss,
    MultiNode,
    Platoon,
    Road,
    Scenario,
    Sensors,
    Sine,
    Switch,
    Trace,
    technologies,
)

_CACC = builtin()["CACC"].mode or 0

positive = st.floats(min_value=1e-6, max_value=1e9)
non_negative = st.floats(min_value=0, max_value=1e9)
# The parameters of the other laws are filled in on reading, and some need a larger ring. What is
# read back of their scenarios is tested in test_library.py.
models: st.SearchStrategy[str] = st.sampled_from(
    [name for name, law in builtin().items() if law.mode is not None and law.mode <= _CACC]
)

gains = st.builds(Gains, k_d=non_negative, k_v=non_negative, k_c=non_negative)
weights: st.SearchStrategy[Any] = st.sampled_from(["least-squares", "uniform", [0.5], (2.0,)])


def groups(size: int) -> st.SearchStrategy[Group]:
    settings = {
        "name": st.from_regex(r"[A-Za-z][A-Za-z0-9_]*", fullmatch=True).filter(
            lambda name: name not in {"all", "not"}
        ),
        "model": st.none() | models,
        "gains": st.none() | gains,
        "desired_speed_mps": st.none() | non_negative,
        "beacons": st.booleans(),
    }
    vehicles = st.sampled_from(["all", 1, [1, "2-3"], f"not {size}", "1 - 2"])
    return st.builds(Group, share=st.floats(0, 1), **settings) | st.builds(
        Group, vehicles=vehicles, **settings
    )


@st.composite
def _profiles(draw: st.DrawFn, vehicle: int, period_ms: float) -> Sine | Trace:
    if draw(st.booleans()):
        times_ms = sorted(draw(st.sets(st.integers(0, 10**12), min_size=2, max_size=9)))
        points = tuple((ms / 1000, draw(non_negative)) for ms in times_ms)
        return Trace(vehicle=vehicle, at_s=draw(non_negative), points=points)
    mean_mps = draw(non_negative)
    frequencies = st.floats(1e-6, 499.0 / period_ms)
    return Sine(
        vehicle=vehicle,
        at_s=draw(non_negative),
        duration_s=draw(positive),
        mean_mps=mean_mps,
        amplitude_mps=draw(st.floats(0, mean_mps)),
        frequency_hz=draw(frequencies),
        to_frequency_hz=draw(st.none() | frequencies),
    )


@st.composite
def scenarios(draw: st.DrawFn) -> Scenario:
    size = draw(st.integers(3, 10_000))
    length_m = draw(st.floats(0.1, 1e6))
    period_ms = draw(st.floats(1, 10_000))
    longer = st.floats(1.01, 100).map(lambda factor: length_m * factor)
    switches_ms = sorted(draw(st.sets(st.integers(0, 10**12), max_size=4)))
    brakes = st.builds(
        Brake,
        vehicle=st.integers(1, size),
        at_s=non_negative,
        duration_s=positive,
        deceleration_mps2=positive,
    )
    speeds = [draw(_profiles(vehicle, period_ms)) for vehicle in (1, size)]
    return Scenario(
        description=draw(st.text(max_size=40)),
        duration_s=draw(st.floats(10, 1e9)),
        period_ms=period_ms,
        seed=draw(st.integers(0, 2**63 - 1)),
        stall_limit_s=draw(positive),
        on_collision=draw(st.sampled_from(["continue", "stop"])),
        road=Road(type=draw(st.sampled_from(["ring", "open"]))),
        fleet=Fleet(
            size=size,
            length_m=length_m,
            gap_m=draw(longer),
            speed_mps=draw(non_negative),
            groups=tuple(draw(st.lists(groups(size), max_size=3, unique_by=lambda g: g.name))),
        ),
        control=Control(
            model=draw(models),
            schedule=tuple(Switch(at_s=ms / 1000, model=draw(models)) for ms in switches_ms),
            gains=draw(gains),
            multi_node=MultiNode(neighbours=draw(st.just(1)), weights=draw(weights)),
            platoon=Platoon(size=draw(st.none() | st.integers(2, 10_000))),
            neighbour_state=draw(st.sampled_from(["radar", "position"])),
            desired_gap_m=draw(longer),
            desired_speed_mps=draw(non_negative),
            acceleration_limit_mps2=draw(positive),
            v2v_wait_ms=period_ms * draw(st.floats(0, 0.99)),
            system_delay_ms=draw(non_negative),
            beacon_age_limit_ms=draw(positive),
        ),
        sensors=Sensors(
            error=draw(st.floats(0, 0.999)),
            distribution=draw(st.sampled_from(["uniform", "gaussian"])),
            position_std_m=draw(non_negative),
        ),
        estimator=Estimator(
            kind=draw(st.sampled_from(["kalman", "ekf", "ukf"])),
            acceleration_std_mps2=draw(positive),
        ),
        channel=Channel(
            technology=draw(st.sampled_from(list(technologies().values()))),
            loss=Loss(p=draw(st.floats(0, 1))),
            frame_bytes=draw(st.integers(1, 65_535)),
            bit_rate_mbps=draw(st.none() | st.floats(0.001, 1e9)),
        ),
        events=tuple(draw(st.permutations([*draw(st.lists(brakes, max_size=3)), *speeds]))),
    )
