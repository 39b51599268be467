"""The chapter on V2V agrees with closed forms, scipy, plain loops, and the log itself."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.patches import Rectangle
from scipy import stats

from tests.logs import write_log
from zenvoy.analysis import load
from zenvoy.analysis.chapters.v2v import v2v_section
from zenvoy.analysis.chapters.v2v_pictures import draw_bursts
from zenvoy.analysis.chapters.v2v_sheets import link_groups
from zenvoy.analysis.log.columns import Table
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.ages import ages
from zenvoy.analysis.measures.links import (
    Delivery,
    by_distance,
    delivery,
    geometric,
    latencies,
    loss_bursts,
    wilson,
)
from zenvoy.analysis.page.drawing import drawn
from zenvoy.analysis.page.section import Section, Sheet
from zenvoy.bus import messages_pb2 as pb

LTE = """
duration_s: 40
seed: 3
fleet: {size: 8}
control: {model: BCM, v2v_wait_ms: 30, system_delay_ms: 100}
channel: {technology: lte-a-pro, loss: {p: 0.3}}
"""
PERIOD_NS, WAIT_NS = 100, 30
DELIVERED, LATE, LOST, OUT = (
    pb.OUTCOME_DELIVERED,
    pb.OUTCOME_LATE,
    pb.OUTCOME_LOST,
    pb.OUTCOME_OUT_OF_RANGE,
)


@pytest.fixture(scope="module")
def run(folder: Path) -> Run:
    return load(write_log(folder / "lte.mcap", LTE))


@pytest.fixture(scope="module")
def section(run: Run) -> Section:
    return v2v_section(run)


@st.composite
def tables(draw: st.DrawFn) -> Table:
    """Draw columns of /v2v/frames: 3 vehicles, some cycles, any outcome of each frame."""
    rows: list[tuple[int, ...]] = []
    for cycle in range(draw(st.integers(1, 8))):
        for source in (1, 2, 3):
            for destination in {1, 2, 3} - {source}:
                latency = draw(st.sampled_from([-2, -1, 0, 29, 30, 31, 99, 130, 131, 350]))
                rows.append((cycle, source, destination, latency))
    cycle, source, destination, latency = np.array(rows, dtype=np.int64).T
    known_in = -((WAIT_NS - latency) // PERIOD_NS)
    outcome = np.where(known_in == 0, DELIVERED, LATE)
    outcome = np.where(latency == -1, LOST, np.where(latency == -2, OUT, outcome))
    sent = cycle * PERIOD_NS
    return {
        "cycle": cycle.astype(np.uint32),
        "source": source.astype(np.uint16),
        "destination": destination.astype(np.uint16),
        "sequence": cycle.astype(np.uint32),
        "sent_ns": sent,
        "arrived_ns": np.where(latency >= 0, sent + latency, -1),
        "latency_ns": np.maximum(latency, -1),
        "distance": (37.5 * np.abs(source - destination)).astype(np.float32),
        "outcome": outcome.astype(np.uint8),
    }


def table_of(outcomes: Sequence[int], **columns: Any) -> Table:
    """Return frames of one link with these outcomes in order, and other columns as given."""
    number = len(outcomes)
    table: Table = {
        "cycle": np.arange(number, dtype=np.uint32),
        "source": np.full(number, 1, np.uint16),
        "destination": np.full(number, 2, np.uint16),
        "sequence": np.arange(number, dtype=np.uint32),
        "outcome": np.array(outcomes, np.uint8),
    }
    return {**table, **{name: np.asarray(values) for name, values in columns.items()}}


# Delivery


@given(st.integers(0, 10_000), st.integers(1, 10_000))
def test_wilson_agrees_with_scipy(successes: int, trials: int) -> None:
    successes = min(successes, trials)
    low, high = wilson(np.array([successes]), np.array([trials]))
    expected = stats.binomtest(successes, trials).proportion_ci(method="wilson")
    np.testing.assert_allclose((low[0], high[0]), (expected.low, expected.high), atol=1e-12)


def test_wilson_intervals_at_the_ends() -> None:
    low, high = wilson(np.array([0, 0, 7]), np.array([0, 7, 7]))
    assert (low[0], high[0]) == (0.0, 1.0)  # there are no trials
    assert low[1] == 0.0 < high[1] < 0.5
    assert 0.5 < low[2] < high[2] == 1.0


def test_delivery_by_hand() -> None:
    outcomes = delivery(table_of([DELIVERED, LATE, LOST, OUT, DELIVERED, LOST]))
    assert outcomes == Delivery(sent=5, delivered=3, late=1, lost=2)


def test_distances_by_hand() -> None:
    outcomes = [DELIVERED, LOST, LATE, DELIVERED, OUT]
    distance = np.array([0.0, 9.0, 11.0, 95.0, 2_000.0], np.float32)
    found = by_distance(table_of(outcomes, distance=distance), bins=10)
    np.testing.assert_array_equal(found.edges_m, np.arange(11) * 10.0)
    np.testing.assert_array_equal(found.sent, [2, 1, 0, 0, 0, 0, 0, 0, 0, 1])
    np.testing.assert_array_equal(found.delivered, [1, 1, 0, 0, 0, 0, 0, 0, 0, 1])


@given(
    st.lists(
        st.tuples(st.floats(0, 60_000, width=32), st.sampled_from([DELIVERED, LATE, LOST, OUT])),
        min_size=1,
        max_size=50,
    ),
    st.integers(1, 30),
)
def test_each_frame_is_in_one_bin(rows: list[tuple[float, int]], bins: int) -> None:
    frames = table_of(
        [outcome for _, outcome in rows],
        distance=np.array([distance for distance, _ in rows], np.float32),
    )
    found, outcomes = by_distance(frames, bins), delivery(frames)
    assert found.sent.sum() == outcomes.sent
    assert found.delivered.sum() == outcomes.delivered
    assert len(found.sent) == len(found.edges_m) - 1 <= bins + 1
    for at, (low, high) in enumerate(zip(found.edges_m, found.edges_m[1:], strict=False)):
        width = high - low
        inside = [o for d, o in rows if low + 1e-4 * width <= d < high - 1e-4 * width]
        assert found.sent[at] >= sum(outcome != OUT for outcome in inside)


# Latency


@given(st.lists(st.integers(-1, 500_000_000), min_size=1, max_size=60))
def test_latencies_agree_with_numpy(latency_ns: list[int]) -> None:
    outcomes = [LOST if latency < 0 else DELIVERED for latency in latency_ns]
    found = latencies(table_of(outcomes, latency_ns=np.array(latency_ns)))
    known = np.array([latency for latency in latency_ns if latency >= 0])
    if not known.size:
        assert found is None
        return
    assert found is not None
    assert found.counts.sum() == len(known)
    assert found.mean_ms == pytest.approx(known.mean() * 1e-6)
    for share in (0.01, 0.5, 0.95, 1.0):
        expected = np.quantile(known, share, method="inverted_cdf")
        below = expected * 1e-6 - found.quantile_ms(share)
        assert -1e-9 < below < found.width_ns * 1e-6 + 1e-9


# Bursts


def naive_bursts(frames: Table) -> dict[int, int]:
    """Return the lengths of runs of losses, link by link, and their counts."""
    lengths: dict[int, int] = {}
    rows = zip(
        *(frames[name].tolist() for name in ("source", "destination", "outcome")), strict=True
    )
    links: dict[tuple[int, int], list[bool]] = {}
    for source, destination, outcome in rows:
        links.setdefault((source, destination), []).append(outcome == LOST)
    for fates in links.values():
        for lost, group in groupby(fates):
            if lost:
                length = len(list(group))
                lengths[length] = lengths.get(length, 0) + 1
    return lengths


@given(tables())
def test_bursts_agree_with_a_plain_count(frames: Table) -> None:
    found = loss_bursts(frames, 3)
    assert {length: number for length, number in enumerate(found) if number} == naive_bursts(frames)


def test_missing_numbers_end_a_burst() -> None:
    frames = table_of([LOST] * 5, sequence=np.array([0, 1, 3, 4, 5], np.uint32))
    np.testing.assert_array_equal(loss_bursts(frames, 2), [0, 0, 1, 1])
    np.testing.assert_array_equal(loss_bursts(table_of([DELIVERED]), 2), [0])


def test_bursts_at_the_largest_numbers_are_distinguished() -> None:
    last = 2**32 - 1
    frames = table_of(
        [LOST, LOST],
        source=np.array([1, 1], np.uint16),
        destination=np.array([2, 3], np.uint16),
        sequence=np.array([last, 0], np.uint32),
    )
    np.testing.assert_array_equal(loss_bursts(frames, 10_000), [0, 2])


@given(st.floats(0.0, 0.9))
def test_the_geometric_law_agrees_with_scipy(p: float) -> None:
    share = geometric(p, 2_000)
    assert share[0] == 0.0
    assert share.sum() == pytest.approx(1.0)
    assert (share * np.arange(2_001)).sum() == pytest.approx(1.0 / (1.0 - p))
    np.testing.assert_allclose(share[1:20], stats.geom(1.0 - p).pmf(np.arange(1, 20)), atol=1e-15)


# Age of information


def naive_age(frames: Table, source: int, destination: int, cycle: int) -> int:
    """Return the age by definition: t_k less the time of the newest frame by then, or -1."""
    known = [
        cycle - int(sent // PERIOD_NS)
        for of, to, sent, arrived in zip(
            *(frames[name] for name in ("source", "destination", "sent_ns", "arrived_ns")),
            strict=True,
        )
        if (of, to) == (source, destination) and 0 <= arrived <= cycle * PERIOD_NS + WAIT_NS
    ]
    return min(known, default=-1)


@settings(deadline=None)
@given(tables())
def test_ages_agree_with_their_definition(frames: Table) -> None:
    found = ages(frames, 3, PERIOD_NS, WAIT_NS)
    arrives = frames["arrived_ns"] >= 0
    links = sorted(set(zip(frames["source"][arrives], frames["destination"][arrives], strict=True)))
    assert list(zip(found.source, found.destination, strict=True)) == links
    assert len(found.cycles) == frames["cycle"][-1] + 1
    for column, (source, destination) in enumerate(links):
        for cycle, age in enumerate(found.cycles[:, column].tolist()):
            assert age == naive_age(frames, source, destination, cycle), (
                source,
                destination,
                cycle,
            )
    everyone = np.ones(len(links), dtype=np.bool_)
    known = found.cycles[found.cycles >= 0]
    assert found.of(everyone).sum() == known.size
    assert (found.of(everyone) * np.arange(len(found.of(everyone)))).sum() == known.sum()
    assert found.before_first(everyone) == found.cycles.size - known.size
    for column, mean in enumerate(found.mean()):
        of_link = found.cycles[found.cycles[:, column] >= 0, column]
        assert np.isnan(mean) if not of_link.size else mean == pytest.approx(of_link.mean())


@pytest.mark.parametrize("wait_ms", [0, 30, 99])
def test_ages_equal_those_that_vehicles_log(folder: Path, wait_ms: int) -> None:
    """Every vehicle logs the age of its data from the vehicle behind, as age_ns."""
    text = LTE.replace("v2v_wait_ms: 30", f"v2v_wait_ms: {wait_ms}")
    run = load(write_log(folder / f"wait{wait_ms}.mcap", text.replace("_s: 40", "_s: 10")))
    period_ns, wait_ns = run.scenario.period_ns, run.scenario.v2v_wait_ns
    found = ages(run.frames, 8, period_ns, wait_ns)
    behind = link_groups(found, run)["vehicle behind"]
    assert behind.sum() == 8
    order = np.argsort(found.destination[behind])
    age = found.cycles[:, behind][:, order].astype(np.int64)
    reported = run.estimate["age_ns"]
    np.testing.assert_array_equal(np.where(age < 0, -1, age * period_ns), reported)
    assert len(np.unique(reported)) > 3


# The section


def sheet(section: Section, name: str) -> Sheet:
    return next(sheet for sheet in section.sheets if sheet.name == name)


def column(of: Sheet, name: str) -> list[Any]:
    return [row[of.columns.index(name)] for row in of.rows]


def test_the_sheets_agree_with_the_log(run: Run, section: Section) -> None:
    assert section.notes == ()
    outcome, latency = run.frames["outcome"], run.frames["latency_ns"]
    table = sheet(section, "v2v-delivery")
    assert column(table, "technology") == ["lte-a-pro"]
    assert column(table, "sent") == [400 * 8 * 7]
    assert column(table, "lost") == [int((outcome == LOST).sum())]
    assert column(table, "of them late") == [int((outcome == LATE).sum())]
    assert column(table, "delivered, %") == [pytest.approx(100.0 * (outcome != LOST).mean())]
    known = latency[latency >= 0] * 1e-6
    table = sheet(section, "v2v-latency")
    assert column(table, "mean, ms") == [pytest.approx(known.mean())]
    for name, share in (("median", 50), ("95th percentile", 95), ("longest", 100)):
        expected = np.percentile(known, share)
        assert column(table, f"{name}, ms") == [pytest.approx(expected, abs=2e-2)]
    distances = sheet(section, "v2v-distance")
    assert sum(column(distances, "sent")) == 400 * 8 * 7
    for ratio, low, high in zip(
        *(column(distances, name) for name in ("delivered, %", "95 % from, %", "95 % to, %")),
        strict=True,
    ):
        assert low < ratio < high


def test_independent_losses_follow_the_geometric_law(section: Section) -> None:
    bursts = sheet(section, "v2v-bursts")
    number = np.array(column(bursts, "bursts"), float)
    expected = np.array(column(bursts, "share if independent, %")) / 100.0 * number.sum()
    enough = expected >= 5.0
    lumped = np.append(number[enough], number[~enough].sum())
    law = np.append(expected[enough], number.sum() - expected[enough].sum())
    assert stats.chisquare(lumped, law).pvalue > 0.001


def test_the_section_has_the_ages(run: Run, section: Section) -> None:
    table = sheet(section, "v2v-age")
    assert column(table, "data of") == ["vehicle ahead", "vehicle behind", "all in range"]
    assert column(table, "links") == [8, 8, 56]
    behind = run.estimate["age_ns"][run.estimate["age_ns"] >= 0] * 1e-6
    row = dict(zip(table.columns, table.rows[1], strict=True))
    assert row["mean, ms"] == pytest.approx(behind.mean())
    assert row["oldest, ms"] == pytest.approx(behind.max())
    expected = [np.quantile(behind, share, method="inverted_cdf") for share in (0.5, 0.95)]
    assert [row["median, ms"], row["95th percentile, ms"]] == pytest.approx(expected)
    assert row["older than 1000 ms, %"] == pytest.approx(100.0 * (behind > 1000.0).mean())


def test_pictures_can_be_drawn(section: Section) -> None:
    assert [picture.name for picture in section.pictures] == [
        "v2v-latency",
        "v2v-delivery",
        "v2v-age",
        "v2v-age-map",
        "v2v-bursts",
    ]
    for picture in section.pictures:
        files = drawn(picture)
        assert files.png.startswith(b"\x89PNG")
        assert b"</svg>" in files.svg
        assert len(files.svg) < 1_000_000
        assert picture.caption.endswith(".")


def test_bursts_of_any_length_can_be_drawn() -> None:
    bursts = np.zeros(401, dtype=np.int64)
    bursts[[1, 2, 40, 400]] = [90, 9, 2, 1]
    shares = 100.0 * np.array([90, 9, 2, 1]) / 102
    for ratio in (1e-9, 0.3, 0.999):
        (long,) = (figure := draw_bursts(bursts, ratio)).axes
        logged, law = long.get_lines()
        assert np.asarray(logged.get_xdata()).tolist() == [1, 2, 40, 400]
        np.testing.assert_allclose(np.asarray(logged.get_ydata(), float), shares)
        assert np.asarray(law.get_xdata()).tolist()[0] == 1
        figure.savefig(BytesIO())
        (short,) = (figure := draw_bursts(bursts[:2], ratio)).axes
        (bar,) = short.patches
        assert isinstance(bar, Rectangle)
        assert bar.get_height() == 100.0
        figure.savefig(BytesIO())


def test_every_row_has_a_cell_for_each_column(section: Section) -> None:
    for of in section.sheets:
        assert {len(row) for row in of.rows} == {len(of.columns)}


@pytest.mark.parametrize(
    ("change", "sheets", "notes"),
    [
        (
            ("ieee80211p", "p: 0"),
            {"v2v-delivery", "v2v-distance", "v2v-latency", "v2v-age"},
            (
                "Every decision had the frames of its own cycle, so all ages are 0.",
                "No frame was lost, so there are no bursts of losses.",
            ),
        ),
        (
            ("ieee80211p", "p: 1"),
            {"v2v-delivery", "v2v-distance"},
            ("Every frame was lost, so there is neither latency nor age of information.",),
        ),
        (
            ("5g-mmwave", "p: 0.3"),
            {"v2v-delivery", "v2v-distance", "v2v-latency", "v2v-age", "v2v-bursts"},
            (),
        ),
    ],
)
def test_channels_without_loss_without_delivery_and_of_short_range_have_sections(
    folder: Path, change: tuple[str, str], sheets: set[str], notes: tuple[str, ...]
) -> None:
    technology, loss = change
    text = LTE.replace("lte-a-pro", technology).replace("p: 0.3", loss).replace("_s: 40", "_s: 5")
    found = v2v_section(load(write_log(folder / "other.mcap", text)))
    assert {of.name for of in found.sheets} == sheets
    assert found.notes == notes
    for picture in found.pictures:
        drawn(picture)


def test_a_run_without_frames_has_a_note(folder: Path) -> None:
    found = v2v_section(load(write_log(folder / "none.mcap", LTE, until_cycle=0)))
    assert found.notes == ("No frame was logged, so there is nothing to show.",)
    apart = LTE.replace("lte-a-pro", "5g-mmwave").replace("size: 8", "size: 3, gap_m: 200")
    far = v2v_section(load(write_log(folder / "far.mcap", apart.replace("_s: 40", "_s: 2"))))
    assert far.notes == ("No frame was in range of a receiver, so there is nothing to show.",)
    assert (far.sheets, far.pictures) == ((), ())


def test_links_end_with_the_open_road(folder: Path) -> None:
    text = LTE + "road: {type: open}\n"
    run = load(write_log(folder / "open.mcap", text.replace("_s: 40", "_s: 5")))
    found = ages(run.frames, 8, run.scenario.period_ns, run.scenario.v2v_wait_ns)
    groups = link_groups(found, run)
    assert {name: int(links.sum()) for name, links in groups.items()} == {
        "vehicle ahead": 7,
        "vehicle behind": 7,
        "all in range": 56,
    }
    ahead = groups["vehicle ahead"]
    np.testing.assert_array_equal(found.source[ahead] + 1, found.destination[ahead])
