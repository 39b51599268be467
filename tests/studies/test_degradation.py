"""`zenvoy degradation` runs every point, and writes tables and figures of them."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from tests.conftest import zenvoy
from tests.logs import write_log
from zenvoy.analysis import load as load_log
from zenvoy.analysis.measures.digest import Digest, digest
from zenvoy.analysis.page.drawing import drawn
from zenvoy.analysis.page.files import csv_bytes
from zenvoy.analysis.paper.degradation import IMPAIRMENTS, MODELS, QUANTITIES, Point, picture, sheet
from zenvoy.scenarios import Scenario, load
from zenvoy.studies.degradation import plan, settings

SHORT = """
duration_s: 6
fleet: {size: 7}
events: [{vehicle: 2, at_s: 1, duration_s: 1, deceleration_mps2: 3}]
"""


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Digest:
    return digest(load_log(write_log(tmp_path_factory.mktemp("run") / "run.mcap", SHORT)))


def of(point: Point) -> Scenario:
    return load("paper/case-15", settings(point)).scenario


def test_every_point_is_its_own_run() -> None:
    cells = plan(2, 30.0)
    levels = sum(len(impairment.levels) for impairment in IMPAIRMENTS)
    assert len(cells) == levels * len(MODELS) * 2
    assert len({cell for of_point in cells.values() for cell in of_point}) == 2 * len(cells)
    for of_point in cells.values():
        assert [cell.seed for cell in of_point] == [1, 2]
        assert of_point[0].load().scenario.duration_s == 30.0


def test_each_degradation_changes_its_setting() -> None:
    scenario = of(Point("loss", 70.0, "BCM", True))
    assert scenario.channel.loss.p == pytest.approx(0.7)
    assert scenario.control.schedule[0].model == "BCM"
    assert scenario.beacon_age_limit_ns == 1_000_000_000
    scenario = of(Point("latency", 300.0, "PBCM", False))
    assert scenario.channel.latency.mean_ms == 300.0
    assert scenario.beacon_age_limit_ns > 500 * 1_000_000_000
    for burst in (2.0, 20.0):
        model = of(Point("burst", burst, "MBCM", True)).channel.loss.gilbert_elliott
        assert model.r is not None
        assert 1.0 / model.r == pytest.approx(burst)  # mean length of a burst
        assert model.p / (model.p + model.r) == pytest.approx(0.3)  # share of frames lost


def test_a_run_has_its_figures(short: Digest) -> None:
    smallest, spread = (quantity.of(short) for quantity in QUANTITIES)
    second_half, last = short.time_s >= 3.0, short.time_s >= short.time_s[-1] - 20.0
    assert smallest == short.min_distance[second_half].min()
    assert spread == pytest.approx(short.spread[last].mean())


def test_the_table_and_the_figure_are_written(short: Digest) -> None:
    runs = {point: [short] * 2 for point in plan(1, None)}
    table = sheet(runs)
    assert len(table.rows) == len(runs)
    assert all(len(row) == len(table.columns) for row in table.rows)
    rows = list(csv.DictReader(csv_bytes(table).decode().splitlines()))
    assert float(rows[0]["MinDistance, m"]) == pytest.approx(QUANTITIES[0].of(short), rel=1e-6)
    assert float(rows[0]["± 95 %, m"]) == 0.0  # the same run twice
    alone = sheet({point: [short] for point in runs})
    assert alone.rows[0][alone.columns.index("± 95 %, m")] is None
    drawing = drawn(picture(runs, "…"))
    assert drawing.png.startswith(b"\x89PNG")


def test_a_refused_command_leaves_no_files(tmp_path: Path) -> None:
    outcome = zenvoy(tmp_path, "degradation", "--seeds", "0")
    assert outcome.code == 2
    assert "--seeds" in outcome.err
    assert not (tmp_path / "docs").exists()
