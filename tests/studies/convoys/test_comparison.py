"""Laws behind recorded leaders, a share of equipped cars, and the page about both."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from tests.recorded_convoys import Platoon, platoon
from zenvoy.analysis.measures.growth import growth_per_vehicle, growths
from zenvoy.scenarios import Scenario, roster
from zenvoy.scenarios.convoys.convoy import Convoy
from zenvoy.studies.convoys.behind import (
    LEAD_IN_S,
    Motion,
    after_lead_in,
    motions,
    recorded,
    settled,
    under,
)
from zenvoy.studies.convoys.calibration import Calibration, calibrate
from zenvoy.studies.convoys.comparison import FITTED, Behind, Compared, best_of, chain
from zenvoy.studies.convoys.findings import findings
from zenvoy.studies.convoys.page import write_page
from zenvoy.studies.convoys.penetration import (
    SHARES,
    Mixed,
    Point,
    Task,
    mixed,
    stopping_share,
    values_for,
)
from zenvoy.studies.convoys.tables import growth_sheet, shares_sheet


def convoy_of(found: Platoon, name: str, setting: str) -> Convoy:
    cars = ("LEAD", "CAR_B", "CAR_C", "CAR_D")
    return Convoy(
        name=name,
        cars=cars,
        time_s=found.time_s,
        speed=found.speed,
        gap=found.gap,
        setting=setting,
    )


@pytest.fixture(scope="module")
def convoys() -> list[Convoy]:
    return [
        convoy_of(platoon(15.0), "one", "humans"),
        convoy_of(platoon(15.0, hz=0.08), "two", "humans"),
    ]


@pytest.fixture(scope="module")
def fits(convoys: list[Convoy]) -> dict[tuple[str, str], Calibration]:
    one, two = convoys
    return {
        (law, convoy.name): calibrate(convoy, law, bounds={}, hold_out=[other], jobs=2)
        for law in FITTED
        for convoy, other in ((one, two), (two, one))
    }


def test_the_law_of_the_cars_moves_as_they_do(convoys: list[Convoy]) -> None:
    values = under(convoys[0], "FM")
    values["control"] |= {"gains": {"k_d": 0.1, "k_v": 0.4, "k_c": 0.0}, "desired_gap_m": 25.0,
                          "system_delay_ms": 0, "v2v_wait_ms": 0}  # fmt: skip
    (found,) = motions(values)
    real = recorded(convoys[0])
    # A command is kept for 0.1 s, while the cars of the recording react at once.
    np.testing.assert_allclose(found.speed, real.speed, atol=0.05)
    np.testing.assert_allclose(found.gap, real.gap, atol=0.1)
    assert found.collisions == 0


def test_a_settled_convoy_begins_evenly_and_then_follows_the_leader(convoys: list[Convoy]) -> None:
    values = settled(under(convoys[0], "FM"))
    scenario = Scenario.model_validate(values)
    assert scenario.duration_s == LEAD_IN_S + 15.0
    assert set(scenario.fleet.gaps_at_start_m) == {scenario.control.desired_gap_m}
    (whole,) = motions(values)
    found = after_lead_in(whole, 0.1)
    np.testing.assert_allclose(found.speed[:, 0], convoys[0].speed[:, 0], atol=1e-3)
    assert found.speed[0] == pytest.approx([15.0] * 4, abs=0.01)


def test_collisions_are_counted(convoys: list[Convoy]) -> None:
    values = under(convoys[0], "FM")
    values["control"] |= {"gains": {"k_d": 0.0, "k_v": 0.0, "k_c": 0.5}, "desired_speed_mps": 25.0}
    assert motions(values)[0].collisions > 0


def test_without_equipped_cars_the_fitted_ones_drive(
    convoys: list[Convoy], fits: dict[tuple[str, str], Calibration]
) -> None:
    today = fits["FM", "one"]
    none = mixed(Task(today, Point("one", 0.0, True, False), (1, 2)))
    motion = chain(today)
    assert len(none.growth) == 1
    assert none.growth[0] == pytest.approx(growth_per_vehicle(motion.speed), abs=1e-6)
    assert none.growth[0] == pytest.approx(growth_per_vehicle(convoys[0].speed), abs=0.01)
    assert none.smallest_gap_m[0] == pytest.approx(motion.gap.min(), abs=1e-6)


def test_equipped_cars_have_pbcm_with_default_gains(
    fits: dict[tuple[str, str], Calibration],
) -> None:
    values = values_for(fits["FM", "one"], Point("one", 0.5, False, False))
    scenario = Scenario.model_validate({**values, "seed": 3})
    settings = roster(scenario)
    equipped = [one.phases[0].model == "PBCM" for one in settings]
    assert 0 < sum(equipped) < 4
    assert [one.beacons for one in settings] == equipped
    assert {one.gains.k_d for one, has in zip(settings, equipped, strict=True) if has} == {0.1}
    whole = values_for(fits["FM", "one"], Point("one", 1.0, True, False))
    assert all(one.phases[0].model == "PBCM" for one in roster(Scenario.model_validate(whole)))


@pytest.mark.parametrize(
    ("growth", "share"),
    [
        ([1.2, 1.1, 1.05, 1.02, 1.01, 1.001], None),
        ([0.9, 0.8, 0.7, 0.7, 0.7, 0.7], 0.0),
        ([1.2, 1.1, 1.1, 1.1, 1.1, 0.9], 0.9),
        ([1.1, 0.9, 1.1, 0.9, 0.9, 0.9], 0.5),  # a share at which it grows again does not stop it
        ([1.1, 1.1, 1.0, 1.0, 1.0, 1.0], 0.4),
    ],
)
def test_the_share_that_stops_the_growth(growth: list[float], share: float | None) -> None:
    found = stopping_share(growth)
    assert found == (None if share is None else pytest.approx(share))


def test_the_best_law_has_the_smallest_error_held_out(
    fits: dict[tuple[str, str], Calibration],
) -> None:
    assert best_of(fits) == "FM"  # by which the cars were made


@pytest.fixture
def found(convoys: list[Convoy], fits: dict[tuple[str, str], Calibration]) -> Compared:
    """Return a comparison whose motions and growths are made up."""
    quiet = [recorded(convoy) for convoy in convoys]
    loud = [Motion(15.0 + 2.0 * (one.speed - 15.0), one.gap - 1.0, 1) for one in quiet]
    behind = [
        Behind(recording=convoy.name, model=model, begun=some[k], settled=some[k])
        for model, some in (("FM", quiet), ("PBCM", loud))
        for k, convoy in enumerate(convoys)
    ]
    growth = {"one": [1.2, 1.1, 1.05, 1.02, 1.01, 0.98], "two": [1.1, 1.08, 1.04, 1.02, 1.0, 0.9]}
    return Compared(
        convoys=convoys,
        behind=behind,
        fits=fits,
        chains={key: quiet[key[1] == "two"] for key in fits},
        mixed={
            Point(name, share, beacon, start): Mixed([at], [2.0], [0])
            for name, values in growth.items()
            for share, at in zip(SHARES, values, strict=True)
            for beacon in (True, False)
            for start in (True, False)
        },
        seeds=1,
    )


def test_the_tables_say_what_was_found(found: Compared) -> None:
    growth = growth_sheet(found, settled=True)
    assert [row[0] for row in growth.rows] == ["recorded", "FM", "PBCM"]
    assert growth.rows[0] == ("recorded", growth.rows[1][1])  # FM moved as recorded, and so
    assert growth.rows[2][1] == growth.rows[0][1]  # did PBCM, but twice as much at each place
    shares = shares_sheet(found, settled=False, all_beacon=True)
    assert [row[-1] for row in shares.rows] == ["87 %", "80 %"]


def test_the_findings_are_sentences_with_the_figures(found: Compared) -> None:
    said = findings(found)
    all_growths = np.concatenate([growths(convoy.speed) for convoy in found.convoys])
    told = f"by a median factor of {np.median(all_growths):.3f} from car to car (95 % interval "
    assert said[0].startswith(f"Recorded, humans: the swing grows {told}")
    assert said[0].endswith("6 pairs of cars).")
    assert any(line.startswith("FM fits cars of today best.") for line in said)
    assert any("in 2 it stops from 80 %, 87 % on" in line for line in said)


def test_the_page_has_its_tables_and_pictures(tmp_path: Path, found: Compared) -> None:
    files = write_page(found, tmp_path / "real", "zenvoy convoys a b")
    page = (tmp_path / "real.md").read_text()
    assert page.startswith("# Real convoys\n\nWritten by `zenvoy convoys a b` of Zenvoy")
    assert "CC BY 4.0" in page
    for name in ("one-run", "growth", "shares"):
        assert f"](real/{name}.png)" in page
        assert (tmp_path / "real" / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    assert all(path.exists() for path in files)
    with (tmp_path / "real" / "recordings.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["recording"] for row in rows] == ["one", "two"]
    again = write_page(found, tmp_path / "real", "zenvoy convoys a b")
    assert [path.name for path in again] == [path.name for path in files]
    assert (tmp_path / "real.md").read_text() == page
