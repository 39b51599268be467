"""Happenings of a run are described in words, and marked on every time axis."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Final

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.logs import write_log
from zenvoy.analysis.chapters.v2v import v2v_section
from zenvoy.analysis.log.load import Run, load
from zenvoy.analysis.page import style
from zenvoy.analysis.page.happenings import Happening, happenings, impairments, sentences, timeline
from zenvoy.analysis.page.marks import mark, united
from zenvoy.scenarios import Scenario

BUSY: Final = """
duration_s: 12
fleet: {size: 5, groups: [{name: old, vehicles: 4}]}
control:
  model: BCM
  schedule:
    - {at_s: 3, model: PBCM}
    - {at_s: 3.5, vehicles: 2, desired_gap_m: 40, desired_speed_mps: 29, ramp_s: 2}
channel:
  outages:
    - {from_s: 5, until_s: 7}
    - {from_s: 9, source: 3, destination: not old}
    - {from_s: 40, until_s: 50}
  rules:
    - {from_s: 2, until_s: 30, from_m: 20, loss: {p: 0.5}}
    - {source: 2-3, latency: {distribution: fixed, mean_ms: 5}}
events:
  - {vehicle: 2, at_s: 4, duration_s: 1, deceleration_mps2: 3, return_s: 2}
  - {type: sine, vehicle: 1, at_s: 6, duration_s: 20, amplitude_mps: 1, frequency_hz: 0.1}
  - {vehicle: 2, at_s: 60, duration_s: 1, deceleration_mps2: 3}
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return load(write_log(tmp_path_factory.mktemp("busy") / "run.mcap", BUSY))


def test_all_happenings_are_listed_in_order(run: Run) -> None:
    """Happenings after the end are left out."""
    assert happenings(run) == [
        Happening("rule", 0.0, math.inf, "changed latency from vehicles 2-3"),
        Happening("rule", 2.0, math.inf, "changed loss on the road from 20 m to the end"),
        Happening("switch", 3.0, 3.0, "switch to PBCM"),
        Happening(
            "manoeuvre",
            3.5,
            5.5,
            "new targets of vehicle 2: desired gap 40 m, desired speed 29 m/s",
        ),
        Happening("brake", 4.0, 5.0, "vehicle 2 brakes with 3 m/s²"),
        Happening("trace", 5.0, 7.0, "vehicle 2 follows a return to its speed before the brake"),
        Happening("outage", 5.0, 7.0, "outage: no frame gets through"),
        Happening("trace", 6.0, math.inf, "vehicle 1 follows a sine, 30 ± 1 m/s, 0.1 Hz"),
        Happening(
            "outage", 9.0, math.inf, "outage: no frame gets through from vehicle 3 to not old"
        ),
    ]


def test_the_timeline_ends_with_the_run(run: Run) -> None:
    found = timeline(run)
    assert found is not None
    assert {len(row) for row in found.rows} == {len(found.columns)}
    assert max(float(row[1]) for row in found.rows if row[1] is not None) == 12.0
    assert [row[1] for row in found.rows if row[2] == "switch to PBCM"] == [None]


def test_a_calm_run_has_no_happenings(tmp_path: Path) -> None:
    calm = load(write_log(tmp_path / "run.mcap", "{duration_s: 1, fleet: {size: 4}}"))
    assert happenings(calm) == []
    assert timeline(calm) is None


def test_a_collision_is_listed(tmp_path: Path) -> None:
    brake = "vehicle: 1, at_s: 0.5, duration_s: 3, deceleration_mps2: 9"
    crash = f"{{duration_s: 3, fleet: {{size: 3, gap_m: 6}}, events: [{{{brake}}}]}}"
    found = happenings(load(write_log(tmp_path / "run.mcap", crash)))
    assert "vehicle 2 collides with the vehicle ahead" in [each.text for each in found]


def test_outages_are_listed_in_the_chapter_on_v2v(run: Run) -> None:
    notes = v2v_section(run).notes
    assert notes[0] == "From 5 s to 7 s: outage: no frame gets through."
    assert "From 9 s to the end: outage: no frame gets through from vehicle 3 to not old." in notes
    assert "Through the whole run: changed latency from vehicles 2-3." in notes


@pytest.mark.parametrize(
    ("outage", "sentence"),
    [
        ("{}", "Through the whole run: outage: no frame gets through."),
        ('{"source": "6"}', "Through the whole run: outage: no frame gets through from vehicle 6."),
        (
            '{"from_s": 2, "until_s": 3, "from_m": 4, "to_m": 5.5}',
            "From 2 s to 3 s: outage: no frame gets through on the road from 4 m to 5.5 m.",
        ),
    ],
)
def test_outages_are_described_in_words(outage: str, sentence: str) -> None:
    scenario = Scenario.model_validate_json(f'{{"channel": {{"outages": [{outage}]}}}}')
    assert sentences(impairments(scenario, 10.0), 10.0) == [sentence]


# --- on axes ------------------------------------------------------------------------------------

SPANS: Final = st.tuples(st.floats(0, 100), st.floats(0, 100)).map(sorted)


@given(st.lists(SPANS, max_size=20), st.floats(0, 100))
def test_united_spans_are_disjoint_and_cover_the_same_times(
    spans: list[list[float]], at: float
) -> None:
    found = united([(low, high) for low, high in spans])
    assert all(before[1] < after[0] for before, after in pairwise(found))
    assert any(low <= at <= high for low, high in found) == any(a <= at <= b for a, b in spans)


def labels(found: list[Happening], *, image: bool = False) -> set[str]:
    _, axes = style.subplots(height_in=2.0)
    axes.plot([10.0, 20.0], [0.0, 1.0])
    axes.set_xlim(10.0, 20.0)
    mark(axes, found, image=image)
    assert axes.get_xlim() == (10.0, 20.0)
    return set(axes.get_legend_handles_labels()[1])


@pytest.mark.parametrize("image", [False, True])
def test_happenings_within_the_axis_are_marked(image: bool) -> None:
    inside = [
        Happening("brake", 12.0, 14.0, ""),
        Happening("outage", 0.0, 11.0, ""),
        Happening("switch", 15.0, 15.0, ""),
        Happening("manoeuvre", 16.0, 18.0, ""),
    ]
    outside = [
        Happening("outage", 2.0, 9.0, ""),
        Happening("switch", 0.0, 0.0, ""),
        Happening("rule", 0.0, math.inf, ""),  # the whole axis: a mark would show nothing
    ]
    assert labels(inside, image=image) == {"brake", "outage", "switch", "manoeuvre"}
    assert labels(outside, image=image) == set()


def test_many_of_a_kind_are_one_artist() -> None:
    many = [Happening("brake", k / 1000.0, k / 1000.0 + 0.0005, "") for k in range(20_000)]
    _, axes = style.subplots(height_in=2.0)
    axes.set_xlim(0.0, 20.0)
    mark(axes, many)
    assert len(axes.collections) == 1
