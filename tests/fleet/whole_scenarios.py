"""Draws scenarios with all that the array engine runs."""

from __future__ import annotations

import json
from typing import Any, Final

from hypothesis import strategies as st

from zenvoy.laws import builtin
from zenvoy.scenarios import Scenario


def fraction(most: float = 1.0) -> st.SearchStrategy[float]:
    return st.floats(0.0, most, allow_subnormal=False)


LAWS: Final = st.sampled_from(list(builtin()))
LOSS: Final = st.fixed_dictionaries(
    {"p": fraction()},
    optional={
        "corrupt": fraction(),
        "by_distance": st.just([[0, 0.1], [80, 0.8]]),
        "gilbert_elliott": st.fixed_dictionaries({"p": fraction(), "r": fraction()}),
        "four_state": st.fixed_dictionaries({"p13": fraction(0.5), "p32": fraction(0.5)}),
    },
)
LATENCY: Final = st.one_of(
    st.just({"distribution": "technology"}),
    st.builds(lambda ms: {"distribution": "fixed", "mean_ms": ms}, st.floats(0, 500)),
    st.builds(
        lambda low, span, order: {
            "distribution": "uniform",
            "min_ms": low,
            "max_ms": low + span,
            "reorder": order,
        },
        st.floats(0, 200),
        st.floats(1, 300),
        st.booleans(),
    ),
    st.just({"distribution": "gamma", "mean_ms": 60, "std_ms": 40, "max_ms": 400}),
    st.just(
        {"distribution": "samples", "samples_ms": [5, 20, 150], "sender_offset": {"max_ms": 90}}
    ),
)
VEHICLE: Final = st.fixed_dictionaries(
    {"actuator_lag_s": st.sampled_from([None, 0.001, 0.1, 0.5, 3.0])},
    optional={
        "max_acceleration_mps2": st.floats(0.5, 5.0),
        "max_deceleration_mps2": st.floats(0.5, 9.0),
    },
)


@st.composite
def whole_scenarios(draw: st.DrawFn) -> Scenario:
    """Draw fleets of 2 to 12, for some seconds, with all that the array engine runs."""
    size = draw(st.integers(2, 12))
    ring = draw(st.booleans())
    several = st.lists(
        st.builds(lambda a, b: f"{min(a, b)}-{max(a, b)}", *[st.integers(1, size)] * 2), max_size=2
    )
    groups = [
        {
            "name": f"g{number}",
            "vehicles": members,
            "vehicle": draw(VEHICLE),
            "model": draw(LAWS),
            "beacons": draw(st.booleans()),
        }
        for number, members in enumerate(draw(several))
    ]
    if draw(st.booleans()):
        some = {"name": "some", "share": draw(fraction()), "model": draw(LAWS)}
        groups.append({**some, "vehicle": draw(VEHICLE)})
    schedule = [
        {"at_s": draw(st.floats(0.1, 3.0)), "model": draw(LAWS)},
        {"at_s": 3.0, "desired_speed_mps": 25.0, "ramp_s": draw(st.sampled_from([0.0, 1.5]))},
    ]
    events: list[dict[str, Any]] = []
    if draw(st.booleans()):
        who = draw(st.integers(1, size))
        brake = {
            "type": "brake",
            "vehicle": who,
            "at_s": 1.0,
            "duration_s": draw(st.floats(0.1, 3)),
        }
        events.append({**brake, "deceleration_mps2": draw(st.floats(0.5, 9.0))})
    if draw(st.booleans()):
        sine = {"type": "sine", "vehicle": 1, "at_s": 0.5, "duration_s": 2.0, "mean_mps": 20.0}
        events.append({**sine, "amplitude_mps": 3.0, "frequency_hz": 0.5})
    rules = draw(st.lists(st.fixed_dictionaries({"loss": LOSS, "latency": LATENCY}), max_size=1))
    outages = [{"from_s": 1.0, "until_s": 2.5, "source": "1-2"}] if draw(st.booleans()) else []
    period_ms = draw(st.sampled_from([100.0, 100.0, 50.0]))
    wait_ms = draw(st.sampled_from([0.0, 10.4, 11.0, 0.5 * period_ms, period_ms - 1.0]))
    values = {
        "duration_s": draw(st.floats(1.0, 6.0)),
        "period_ms": period_ms,
        "seed": draw(st.integers(0, 2**63 - 1)),
        "on_collision": draw(st.sampled_from(["continue", "stop"])),
        "road": {"type": "ring" if ring else "open"},
        "fleet": {
            "size": size,
            "gap_m": draw(st.floats(5.5, 60.0)),
            "speed_mps": draw(st.floats(0.0, 35.0)),
            "groups": groups,
        },
        "vehicle": draw(VEHICLE),
        "control": {
            "model": draw(LAWS),
            "schedule": schedule,
            "multi_node": {"neighbours": draw(st.integers(1, 3))},
            "platoon": {"size": draw(st.sampled_from([None, 2]))},
            "neighbour_state": draw(st.sampled_from(["radar", "position"])),
            "v2v_wait_ms": wait_ms,
            "system_delay_ms": draw(st.one_of(st.just(89.0), st.floats(0.0, 350.0))),
            "beacon_age_limit_ms": draw(st.sampled_from([150.0, 1000.0, 1e6])),
        },
        "beacons": draw(
            st.sampled_from(
                [
                    {"rule": "every-cycle"},
                    {"rule": "every-nth", "every": 3},
                    {"period_ms": 200.0},
                    {"period_ms": 300.0, "staggered": True},
                ]
            )
        ),
        "sensors": {
            "error": draw(st.sampled_from([0.0, 0.03, 0.1])),
            "distribution": draw(st.sampled_from(["uniform", "gaussian"])),
            "position_std_m": draw(st.sampled_from([0.0, 1.0])),
        },
        "channel": {
            "range_m": draw(st.sampled_from([40.0, 100.0, 1000.0])),
            "broadcast": draw(st.booleans()),
            "loss": draw(LOSS),
            "latency": draw(LATENCY),
            "rules": rules,
            "outages": outages,
        },
        "events": events,
    }
    return _valid(values)


def _valid(values: dict[str, Any]) -> Scenario:
    """Return the scenario, or a plainer one if its drawn values exclude each other."""
    if "SPBCM" in json.dumps(values):
        values = {**values, "control": {**values["control"], "neighbour_state": "radar"}}
    try:
        return Scenario.model_validate(values)
    except ValueError:
        plain = {**values, "control": {**values["control"], "model": "FM", "schedule": []}}
        plain["fleet"] = {**values["fleet"], "groups": []}
        return Scenario.model_validate({**plain, "events": []})
