"""The chapter on V2V agrees with the log, and its pictures can be drawn."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.patches import Rectangle
from scipy import stats

from tests.analysis.v2v.frames import LATE, LOST, LTE
from tests.logs import write_log
from zenvoy.analysis import load
from zenvoy.analysis.chapters.v2v import v2v_section
from zenvoy.analysis.chapters.v2v_pictures import draw_bursts
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.page.drawing import drawn
from zenvoy.analysis.page.section import Section, Sheet


@pytest.fixture(scope="module")
def run(folder: Path) -> Run:
    return load(write_log(folder / "lte.mcap", LTE))


@pytest.fixture(scope="module")
def section(run: Run) -> Section:
    return v2v_section(run)


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
