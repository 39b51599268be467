"""`zenvoy mixed-traffic`: its studies, on short runs, and their tables and pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.conftest import zenvoy
from zenvoy.analysis.page.drawing import picture_files
from zenvoy.scenarios import load
from zenvoy.studies.batches import run_batch
from zenvoy.studies.mixed import penetration, pictures, ring
from zenvoy.studies.mixed.flow import FIGURES, Span
from zenvoy.studies.sweeps.study_file import read_study
from zenvoy.studies.sweeps.sweep import Made, make_runs

Points = dict[penetration.Line, list[penetration.Point]]

SPANS = ring.Spans(Span(1.0, 3.0), Span(4.0, 6.0))


def made(study: dict[str, Any], folder: Path) -> Made:
    return make_runs(read_study(study), out=folder, jobs=2, on_line=lambda _: None)


@pytest.fixture(scope="module")
def driven(folder: Path) -> tuple[ring.Driven, ...]:
    return ring.driven(made(ring.study(2, 6.0), folder / "ring"), SPANS)


def test_the_ring_has_a_row_for_each_figure_and_car(driven: tuple[ring.Driven, ...]) -> None:
    cars = [one.car for one in driven]
    assert cars == [ring.NOBODY, "FollowerStopper", "PI", "LCC"]
    sheet = ring.sheet(driven)
    assert len(sheet.rows) == len(FIGURES) * len(cars)
    row = dict(zip(sheet.columns, sheet.rows[1], strict=True))
    assert (row["controlled car"], row["seeds"]) == ("FollowerStopper", 2)
    before, after = (
        [flow.std_mps for flow in flows] for flows in (driven[1].before, driven[1].after)
    )
    assert row["before"] == pytest.approx(sum(before) / 2)
    assert row["after"] == pytest.approx(sum(after) / 2)
    changes = [100.0 * (b / a - 1.0) for a, b in zip(before, after, strict=True)]
    assert row["change, %"] == pytest.approx(sum(changes) / 2)
    published = {row[0]: row[-1] for row in sheet.rows if row[2] == "PI"}
    assert {name: change for name, change in published.items() if change} == ring.PUBLISHED
    assert all(row[-1] is None for row in sheet.rows if row[2] in (ring.NOBODY, "LCC"))


def test_all_cars_are_alike_before_the_control(driven: tuple[ring.Driven, ...]) -> None:
    assert all(one.before == driven[0].before for one in driven)


def test_the_control_begins_when_its_scenarios_say() -> None:
    assert ring.spans(700.0) == ring.Spans(Span(250.0, 300.0), Span(650.0, 700.0))


@pytest.fixture(scope="module")
def points(folder: Path) -> Points:
    study = penetration.study("ring/equipped", 2, 6.0, shares=(0, 0.5, 1))
    study["axes"]["fleet.groups.0.model"] = ["PBCM"]
    return penetration.lines("ring/equipped", made(study, folder / "equipped"), 6.0)


def test_a_share_of_nobody_is_the_same_with_and_without_beacons(points: Points) -> None:
    heard, silent = (points[penetration.Line("ring/equipped", "PBCM", b)] for b in (True, False))
    assert [point.share for point in heard] == [0.0, 0.5, 1.0]
    figures = [
        [(point.std_mps, point.flow_per_h, point.collisions) for point in of_line]
        for of_line in (heard, silent)
    ]
    assert figures[0][0] == figures[1][0]
    assert figures[0][2] == figures[1][2]
    assert figures[0][1] != figures[1][1]
    assert all(point.growth_per_s is None for point in silent)
    alone, _, equipped = (point.growth_per_s for point in heard)
    assert alone is not None
    assert equipped is not None
    assert alone.mean > 0.01
    assert equipped.mean < 0.0
    sheet = penetration.sheet(points)
    assert len(sheet.rows) == 6
    assert sheet.rows[1][:5] == ("ring/equipped", "PBCM", "yes", 50.0, 2)


def test_pictures_are_drawn(driven: tuple[ring.Driven, ...], points: Points) -> None:
    (run,) = run_batch([load("ring/pi", duration_s=3.0)], {"/fleet/truth": ("speed",)})
    files = picture_files(
        [
            pictures.speeds({ring.NOBODY: run, "PI": run}, 1.0),
            pictures.spread(driven, 3.0),
            pictures.penetration(points),
        ]
    )
    assert set(files) == {
        f"{name}.{form}"
        for name in ("ring-speeds", "ring-spread", "penetration")
        for form in ("png", "svg")
    }


def test_a_run_that_ends_before_the_control_is_refused(tmp_path: Path) -> None:
    outcome = zenvoy(tmp_path, "mixed-traffic", "--duration-s", "300")
    assert outcome.code == 2
    text = "--duration-s 300 s: a car is controlled from 300 s on; allowed: more"
    assert outcome.err.strip() == text
    assert not {"docs", "runs"} & {path.name for path in tmp_path.iterdir()}
