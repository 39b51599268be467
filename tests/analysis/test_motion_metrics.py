"""Figures of merit of motion match hand calculations, closed forms and invariants."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from zenvoy.analysis.measures.metrics import largest_gaps, max_distance, min_distance, smallest_gaps
from zenvoy.analysis.measures.motion import (
    at_limits,
    counted_flow,
    crossings,
    flow_by_density,
    jerk,
    over_runs,
    over_windows,
    rms,
    speed_spread,
)
from zenvoy.analysis.measures.safety import (
    share_below,
    smallest,
    time_exposed,
    time_headway,
    time_integrated,
    time_to_collision,
)
from zenvoy.analysis.measures.spans import Disturbance, Span, distances, disturbances, spans
from zenvoy.bus import messages_pb2 as pb
from zenvoy.links.distance import gaps
from zenvoy.scenarios import Limits

Floats = NDArray[np.float64]

fleets = st.tuples(st.integers(1, 12), st.integers(2, 15)).flatmap(
    lambda shape: hnp.arrays(np.float64, shape, elements=st.floats(0.1, 200.0))
)


# --- distances ----------------------------------------------------------------------------------


@given(fleets)
def test_the_mean_gap_of_the_ring_is_its_length_over_n(gap: Floats) -> None:
    """MinDistance ≤ mean gap ≤ MaxDistance holds on the ring and on the open road."""
    n = gap.shape[1]
    length = float(gap[0].sum())
    gap = gap * (length / gap.sum(axis=1, keepdims=True))  # every row fills the ring
    position = 1000.0 - np.cumsum(gap, axis=1)
    ring = gaps(position, length)
    np.testing.assert_allclose(ring.mean(axis=1), length / n)
    for road in (ring, gaps(position, None)):
        mean = np.nanmean(road, axis=1)
        assert (min_distance(road) <= mean + 1e-9).all()
        assert (max_distance(road) >= mean - 1e-9).all()
        assert (smallest_gaps(road).min(axis=1) == np.nanmin(road, axis=1)).all()
        assert (largest_gaps(road).max(axis=1) == np.nanmax(road, axis=1)).all()


def test_error_bars_of_windows_by_hand() -> None:
    time = np.arange(0.0, 4.0, 0.5)  # two windows of 2 s
    values = np.array([[1.0, 3.0]] * 4 + [[5.0, 5.0], [7.0, 7.0]] * 2)
    middles, band = over_windows(time, values, 2.0)
    assert middles.tolist() == [1.0, 3.0]
    assert band.mean.tolist() == [2.0, 6.0]
    assert band.std.tolist() == [1.0, 1.0]


def test_an_incomplete_window_at_the_end_counts_if_it_is_long_enough() -> None:
    time, values = np.arange(11.0), np.arange(11.0)[:, None]
    assert over_windows(time, values, 5.0)[0].tolist() == [2.5, 7.5]  # the row at 10 s alone: no
    assert over_windows(time, values, 4.0)[0].tolist() == [2.0, 6.0, 10.0]  # 8, 9, 10 s: yes
    assert over_windows(time, values, 100.0)[1].mean.tolist() == [5.0]


def test_a_band_spans_several_runs() -> None:
    band = over_runs(np.array([[1.0, 5.0], [3.0, 5.0], [5.0, 5.0]]))
    assert band.mean.tolist() == [3.0, 5.0]
    assert band.std.tolist() == [2.0, 0.0]
    alone = over_runs(np.array([[1.0, 2.0]]))
    assert alone.mean.tolist() == [1.0, 2.0]
    assert np.isnan(alone.std).all()


def test_a_braking_has_its_spans() -> None:
    brakes = [Disturbance(2, start, end, "", "brake") for start, end in ((10, 12), (20, 21))]
    found = {span.name: span for span in spans(brakes, 100.0)}
    assert found == {
        "before_braking": Span("before_braking", 5.0, 10.0),
        "dip": Span("dip", 10.0, 51.0),
        "end": Span("end", 95.0, math.inf),
    }
    assert [span.name for span in spans([], 100.0)] == ["end"]


def test_a_trace_has_no_spans_of_braking() -> None:
    trace = Disturbance(1, 10.0, 30.0, "", "trace")
    assert [span.name for span in spans([trace], 100.0)] == ["before_disturbance", "dip", "end"]


def test_distances_are_extremes_in_a_dip_and_means_otherwise() -> None:
    time = np.array([1.0, 2.0, 3.0, 4.0])
    low, high = np.array([9.0, 1.0, 2.0, 6.0]), np.array([10.0, 12.0, 20.0, 13.0])
    assert distances(Span("dip", 1.0, 3.0), time, low, high) == (1.0, 20.0)  # without the row at 1
    assert distances(Span("end", 1.0, 3.0), time, low, high) == (1.5, 16.0)
    assert distances(Span("end", 7.0, 9.0), time, low, high) is None


def test_disturbances_equal_those_of_the_log() -> None:
    def event(kind: pb.EventKind.ValueType, time_s: int, vehicle: int) -> pb.Event:
        return pb.Event(kind=kind, time_ns=time_s * 10**9, vehicle=vehicle, text="x")

    events = [
        event(pb.EVENT_TRACE, 2, 1),
        event(pb.EVENT_BRAKE, 3, 5),
        event(pb.EVENT_BRAKE_END, 3, 4),
        event(pb.EVENT_COLLISION, 4, 7),
        event(pb.EVENT_BRAKE_END, 5, 5),
        event(pb.EVENT_BRAKE, 6, 5),
        event(pb.EVENT_BRAKE_END, 7, 5),
    ]
    assert disturbances(events) == [
        Disturbance(1, 2.0, math.inf, "x", "trace"),
        Disturbance(5, 3.0, 5.0, "x", "brake"),
        Disturbance(5, 6.0, 7.0, "x", "brake"),
    ]


# --- safety -------------------------------------------------------------------------------------


def test_time_to_collision_by_hand() -> None:
    """Gaps between fronts are 25, 15 and 20 m. The second closes at 5 m/s, the first at 2 m/s."""
    gap = np.array([[25.0, 15.0, 20.0]])
    speed = np.array([[20.0, 25.0, 18.0]])
    ring = time_to_collision(gap, speed, 5.0, 60.0)
    np.testing.assert_allclose(ring, [[10.0, 2.0, np.inf]])
    opened = time_to_collision(np.array([[np.nan, 15.0, 20.0]]), speed, 5.0, None)
    np.testing.assert_allclose(opened, [[np.nan, 2.0, np.inf]])
    assert smallest(ring).tolist() == smallest(opened).tolist() == [2.0]
    assert time_to_collision(np.array([[4.9, 9.0]]), np.array([[3.0, 1.0]]), 5.0, 20.0)[0, 0] == 0.0


def test_exposed_and_integrated_times_agree_with_closed_forms() -> None:
    """A steady approach at 10 m/s from 60 m is below 4 s for 4 s, by 2 s on average."""
    time = np.arange(0.0, 6.0, 1e-3)
    gap = np.stack([np.full(6000, np.nan), 5.0 + 60.0 - 10.0 * time], axis=1)
    speed = np.tile([20.0, 30.0], (6000, 1))
    ttc = time_to_collision(gap, speed, 5.0, None)
    np.testing.assert_allclose(smallest(ttc), 6.0 - time)
    assert time_exposed(ttc, 4.0, 1e-3) == pytest.approx(4.0, abs=2e-3)
    assert time_integrated(ttc, 4.0, 1e-3) == pytest.approx(8.0, abs=1e-2)
    assert time_exposed(ttc, 1.5, 1e-3) == pytest.approx(1.5, abs=2e-3)
    assert time_integrated(ttc, 1.5, 1e-3) == pytest.approx(1.125, abs=1e-2)
    assert share_below(ttc, 1.5) == pytest.approx(0.25, abs=1e-3)  # of the one that follows


@given(fleets, st.floats(0.1, 30.0), st.floats(0.1, 5.0))
def test_exposure_grows_with_the_threshold(gap: Floats, speed: float, threshold: float) -> None:
    moving = speed + np.sin(np.arange(gap.size, dtype=np.float64)).reshape(gap.shape)
    ttc = time_to_collision(gap, moving, 5.0, float(gap[0].sum()))
    assert (ttc >= 0.0).all()
    exposed = time_exposed(ttc, threshold, 0.1)
    assert 0.0 <= exposed <= time_exposed(ttc, 2.0 * threshold, 0.1) <= 0.1 * gap.size + 1e-9
    assert time_integrated(ttc, threshold, 0.1) <= exposed * threshold + 1e-9
    assert share_below(ttc, threshold) == pytest.approx(exposed / (0.1 * gap.size))


def test_nobody_approaches_in_an_even_flow() -> None:
    ttc = time_to_collision(np.full((3, 4), 37.5), np.full((3, 4), 30.0), 5.0, 150.0)
    assert np.isinf(ttc).all()
    assert smallest(ttc).tolist() == [math.inf] * 3
    assert time_exposed(ttc, 4.0, 0.1) == share_below(ttc, 4.0) == 0.0
    assert share_below(np.full((2, 1), np.nan), 4.0) == 0.0


def test_headway_by_hand() -> None:
    gap = np.array([[np.nan, 37.5, 20.0, 10.0]])
    found = time_headway(gap, np.array([[30.0, 30.0, 10.0, 0.0]]))
    np.testing.assert_allclose(found, [[np.nan, 1.25, 2.0, np.nan]])


# --- acceleration, flow -------------------------------------------------------------------------


def test_spread_limit_rms_and_jerk_by_hand() -> None:
    assert speed_spread(np.array([[28.0, 32.0], [30.0, 30.0]])).tolist() == [2.0, 0.0]
    a = np.array([[3.0, -3.0, 2.9, 0.0]])
    limits = [Limits(-3.0, 3.0), Limits(-3.0, 3.0), Limits(-4.0, 2.9), Limits(-1.0, 1.0)]
    assert at_limits(a, limits).tolist() == [[True, True, True, False]]
    assert rms(a) == pytest.approx(math.sqrt((9.0 + 9.0 + 8.41) / 4.0))
    np.testing.assert_allclose(jerk(np.array([[0.0], [0.3], [0.1]]), 0.1), [[3.0], [-2.0]])


def test_rms_of_a_sine_and_of_its_jerk_in_closed_form() -> None:
    """They are A / √2 and A ω / √2."""
    time = np.arange(0.0, 2.0 * np.pi / 0.7 * 5.0, 1e-3)
    a = 1.3 * np.sin(0.7 * time)[:, None]
    assert rms(a) == pytest.approx(1.3 / math.sqrt(2.0), rel=1e-3)
    assert rms(jerk(a, 1e-3)) == pytest.approx(1.3 * 0.7 / math.sqrt(2.0), rel=1e-3)


def steady(n: int, gap_m: float, speed: float, seconds: float) -> tuple[Floats, Floats]:
    time = np.arange(0.0, seconds + 1e-9, 0.1)
    start = np.arange(n - 1.0, -1.0, -1.0) * gap_m
    return time, start[None] + speed * time[:, None]


def test_an_even_flow_passes_v_over_gap_vehicles() -> None:
    """30 m/s and 37.5 m give 0.8 vehicles/s, or 2880 per hour, by every count."""
    time, position = steady(40, 37.5, 30.0, 500.0)
    speed = np.full_like(position, 30.0)
    np.testing.assert_allclose(flow_by_density(position, speed, 1500.0), 2880.0)
    np.testing.assert_allclose(flow_by_density(position, speed, None), 2880.0)
    ring = crossings(time, position, 0.0, 1500.0)
    assert len(ring) == 400
    assert counted_flow(ring, 500.0) == 2880.0
    np.testing.assert_allclose(np.diff(ring), 1.25)
    road = crossings(time, position, float(position[0, 0]), None)
    assert len(road) == 39  # those behind the first, which is there already
    assert counted_flow(road, None) == pytest.approx(2880.0)


def test_crossings_by_hand() -> None:
    time = np.array([0.0, 10.0])
    position = np.array([[5.0, -4.0, -20.0], [100.0, 12.0, -10.0]])
    np.testing.assert_allclose(crossings(time, position, 0.0, None), [2.5])
    # on a ring of 30 m the first passes at 30, 60 and 90 m, the second at 0
    np.testing.assert_allclose(
        crossings(time, position, 0.0, 30.0), [2.5, 25 / 9.5, 55 / 9.5, 85 / 9.5]
    )
    assert counted_flow(np.array([1.0]), None) is None
    assert counted_flow(np.zeros(0), None) is None
    assert counted_flow(np.zeros(0), 10.0) == 0.0


@given(st.integers(2, 12), st.floats(6.0, 80.0), st.floats(1.0, 40.0))
def test_counted_and_computed_flow_agree_on_the_ring(n: int, gap_m: float, speed: float) -> None:
    time, position = steady(n, gap_m, speed, 30.0)
    length = n * gap_m
    computed = flow_by_density(position, np.full_like(position, speed), length)[0]
    counted = counted_flow(crossings(time, position, 0.25 * gap_m, length), 30.0)
    assert counted == pytest.approx(computed, abs=3600.0 / 30.0 + 1e-6)  # to one vehicle
