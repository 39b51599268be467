"""Wrong events that set a speed are refused, and so are two of one vehicle that overlap."""

from __future__ import annotations

import pytest

from tests.refusals import refusal_of
from tests.scenarios.conftest import Here
from zenvoy.scenarios import (
    load,
)

CSV = "time_s,speed_mps\n0,30\n0.5,30.25\n2,28\n"
HEAD = "events:\n- {type: trace, vehicle: 1, at_s: 0"
WAVE = "events:\n- {type: sine, vehicle: 1, at_s: 0, duration_s: 100, "


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        (f"{HEAD}}}", ["events.0: neither file nor points is given; allowed: one of the two"]),
        (
            f"{HEAD}, file: drive.csv, points: [[0, 1], [1, 1]]}}",
            ["events.0.file: given together with points; allowed: one of the two"],
        ),
        (f"{HEAD}, file: 3}}", ["events.0.file: 3 is not text, the name of a CSV file"]),
        (f"{HEAD}, points: 3}}", ["events.0.points: 3 is not a list"]),
        (
            f"{HEAD}, points: [[0, 1]]}}",
            ["events.0.points: a list of 1 is not a list of 2 to 60000 points"],
        ),
        (
            f"{HEAD}, points: [[0, 1], 3, [2], [3, 4, 5], [], [x, -1]]}}",
            [
                "events.0.points.1: 3 is not a list of 2",
                "events.0.points.2.1: missing; allowed: a number in [0, 1e9]",
                "events.0.points.3: a list of 3 is not a list of 2",
                "events.0.points.4.0: missing; allowed: a number in [0, 1e9]",
                "events.0.points.4.1: missing; allowed: a number in [0, 1e9]",
                "events.0.points.5.0: 'x' is not a number",
                "events.0.points.5.1: -1 is not in [0, 1e9]",
            ],
        ),
        (
            f"{HEAD}, points: [[0, 1], [1, 2]], deceleration_mps2: 3}}",
            [
                "events.0.deceleration_mps2: unknown key; allowed: type, vehicle, at_s, file, "
                "column, time_column, unit, time_unit, time, where, points"
            ],
        ),
        (
            f"{WAVE}amplitud_mps: 1, frequency_hz: 0.1}}",
            [
                "events.0.amplitude_mps: missing; allowed: a number in [0, 1e9]",
                "events.0.amplitud_mps: unknown key; did you mean 'amplitude_mps'? allowed: type, "
                "vehicle, at_s, duration_s, mean_mps, amplitude_mps, frequency_hz, to_frequency_hz",
            ],
        ),
        (
            f"{WAVE}amplitude_mps: 31, frequency_hz: 0.1}}",
            ["events.0.amplitude_mps: 31 is not in [0, 30], up to mean_mps (30)"],
        ),
        (
            f"{WAVE}amplitude_mps: 1, frequency_hz: 5, to_frequency_hz: 4.9}}",
            [
                "events.0.frequency_hz: 5 is not less than 5, half the rate of period_ms (100)",
            ],
        ),
        (
            f"{WAVE}amplitude_mps: 1, frequency_hz: 0.1, to_frequency_hz: fast}}",
            ["events.0.to_frequency_hz: 'fast' is not a number or null"],
        ),
        (
            f"{WAVE}amplitude_mps: 1, frequency_hz: 0, to_frequency_hz: 7}}",
            [
                "events.0.frequency_hz: 0 is not in (0, 1e9]",
                "events.0.to_frequency_hz: 7 is not less than 5, half the rate of period_ms (100)",
            ],
        ),
        (
            f"{HEAD}, vehicle: 41, points: [[0, 1], [1, 2]]}}".replace("vehicle: 1, ", ""),
            ["events.0.vehicle: 41 is not in [1, 40], the vehicles of fleet.size (40)"],
        ),
    ],
)
def test_wrong_events_are_refused(here: Here, text: str, lines: list[str]) -> None:
    here(text, CSV)
    assert refusal_of("s.yaml").splitlines() == [f"{line}  (s.yaml, line 2)" for line in lines]


OVERLAP = """
events:
- {type: sine, vehicle: 1, at_s: 10, duration_s: 100, amplitude_mps: 1, frequency_hz: 0.1}
- {type: trace, vehicle: 1, at_s: 100, points: [[10, 30], [20, 31]]}
- {type: trace, vehicle: 2, at_s: 100, points: [[0, 30], [20, 31]]}
- {type: brake, vehicle: 1, at_s: 20, duration_s: 5, deceleration_mps2: 3}
"""


def test_overlapping_speeds_of_one_vehicle_are_refused(here: Here) -> None:
    assert len(load(here(OVERLAP, "")).scenario.profiles) == 3  # they touch
    assert refusal_of("s.yaml", "events.1.at_s=99.9").splitlines() == [
        "events.1: begins at 109.9 s, before events.0 of the same vehicle ends (110 s)"
        "  (--set events.1.at_s=99.9)",
    ]
    assert refusal_of("s.yaml", "events.1.at_s=99.9", "events.2.vehicle=1").splitlines() == [
        "events.2: begins at 100 s, before events.0 of the same vehicle ends (110 s)"
        "  (--set events.2.vehicle=1)",
        "events.1: begins at 109.9 s, before events.2 of the same vehicle ends (120 s)"
        "  (--set events.2.vehicle=1)",
    ]


def test_a_refused_value_does_not_make_speeds_overlap(here: Here) -> None:
    here(OVERLAP, "")
    assert refusal_of("s.yaml", "events.1.points=[]").splitlines() == [
        "events.1.points: a list of 0 is not a list of 2 to 60000 points"
        "  (--set events.1.points=[])"
    ]
    assert refusal_of("s.yaml", "events.1.at_s=soon").splitlines() == [
        "events.1.at_s: 'soon' is not a number  (--set events.1.at_s=soon)"
    ]
