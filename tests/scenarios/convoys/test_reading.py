"""Recordings of OpenACC and other tables of several cars are read as the platoon that they show."""

from __future__ import annotations

import gzip
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.recorded_convoys import CARS, Platoon, long_text, openacc_text, platoon, wide_text
from zenvoy.scenarios.convoys.columns import Columns
from zenvoy.scenarios.convoys.convoy import Convoy
from zenvoy.scenarios.convoys.cutting import Choice
from zenvoy.scenarios.convoys.errors import ConvoyError
from zenvoy.scenarios.convoys.kept import RECORDED, leader_csv, recorded_csv
from zenvoy.scenarios.convoys.reading import read_convoy, read_openacc, read_table

WIDE = Columns(time="t_ms", time_unit="ms", speed="v_{} [km/h]", position="x_{}")
LONG = Columns(time="time", vehicle="id", position="x", speed="v", unit="m/s")


@pytest.fixture(scope="module")
def found() -> Platoon:
    return platoon()


def read(folder: Path, text: str, **choice: Any) -> Convoy:
    path = folder / "drive_part7.csv"
    path.write_text(text)
    return read_openacc(path, Choice(**choice))


def same(convoy: Convoy, found: Platoon, cars: slice = slice(None)) -> None:
    np.testing.assert_allclose(convoy.time_s, found.time_s[: len(convoy.time_s)], atol=1e-9)
    np.testing.assert_allclose(convoy.speed, found.speed[:, cars], atol=1e-4)
    np.testing.assert_allclose(convoy.gap[:, 1:], found.gap[:, cars][:, 1:], atol=1e-4)
    assert np.isnan(convoy.gap[:, 0]).all()


def test_openacc(tmp_path: Path, found: Platoon) -> None:
    convoy = read(tmp_path, openacc_text(found))
    same(convoy, found)
    assert (convoy.name, convoy.cars) == ("drive_part7", CARS)
    assert convoy.setting == "ACC, short setting"
    assert convoy.told["from"] == "780 s, of 780 s"


@pytest.mark.parametrize(
    ("about", "setting"),
    [
        ({"ACC": "0", "Distance_setting": ""}, "humans"),
        ({"Distance_setting": "L"}, "ACC, long setting"),
        ({"Distance_setting": ""}, "ACC"),
    ],
)
def test_the_lines_above_tell_who_drove(
    tmp_path: Path, found: Platoon, about: dict[str, str], setting: str
) -> None:
    assert read(tmp_path, openacc_text(found, about=about)).setting == setting


def test_a_packed_file(tmp_path: Path, found: Platoon) -> None:
    path = tmp_path / "mixed-run.csv.gz"
    path.write_bytes(gzip.compress(openacc_text(found).encode()))
    convoy = read_openacc(path, Choice())
    same(convoy, found)
    assert (convoy.name, convoy.setting) == ("mixed-run", "mixed")


def test_a_wide_table_with_units(tmp_path: Path, found: Platoon) -> None:
    (tmp_path / "t.csv").write_text(wide_text(found))
    same(read_table(tmp_path / "t.csv", WIDE, Choice()), found)


def test_speeds_from_positions(tmp_path: Path, found: Platoon) -> None:
    (tmp_path / "t.csv").write_text(wide_text(found))
    columns = Columns(time="t_ms", time_unit="ms", position="x_{}")
    convoy = read_table(tmp_path / "t.csv", columns, Choice())
    np.testing.assert_allclose(convoy.speed[1:-1], found.speed[1:-1], atol=0.01)


def test_a_long_table_is_ordered_by_position(tmp_path: Path, found: Platoon) -> None:
    (tmp_path / "t.csv").write_text(long_text(found))
    convoy = read_table(tmp_path / "t.csv", LONG, Choice())
    same(convoy, found)
    assert convoy.cars == CARS


def test_the_length_makes_gaps_of_positions(tmp_path: Path, found: Platoon) -> None:
    (tmp_path / "t.csv").write_text(long_text(found))
    convoy = read_table(tmp_path / "t.csv", LONG, Choice(length_m=4.0))
    np.testing.assert_allclose(convoy.gap[:, 1:], found.gap[:, 1:] + 1.0, atol=1e-3)


def test_cars_that_are_missing_cut_the_platoon(tmp_path: Path, found: Platoon) -> None:
    """Without the speeds of car 2, the longest chain is cars 3 and 4."""
    rows = openacc_text(found).splitlines()
    cells = [row.split(",") for row in rows]
    for row in cells[6:]:
        row[4] = ""
    convoy = read(tmp_path, "\n".join(map(",".join, cells)))
    assert convoy.cars == ("CAR_C", "CAR_D")
    assert convoy.told["cars left out"] == "LEAD_CAR, CAR_B"
    same(convoy, found, slice(2, 4))


def test_a_short_hole_is_bridged_and_a_long_one_is_not(tmp_path: Path, found: Platoon) -> None:
    cells = [row.split(",") for row in openacc_text(found).splitlines()]
    for row in cells[106:114]:  # 0.9 s from value to value
        row[7] = ""
    for row in cells[506:530]:
        row[7] = ""
    convoy = read(tmp_path, "\n".join(map(",".join, cells)))
    assert convoy.time_s[-1] == pytest.approx(49.9)
    assert convoy.told["values bridged"] == "8"
    np.testing.assert_allclose(convoy.speed[:, 2], found.speed[:500, 2], atol=0.05)


def test_chosen_cars_and_times(tmp_path: Path, found: Platoon) -> None:
    text = openacc_text(found)
    convoy = read(tmp_path, text, cars=("2", "CAR_C"), from_s=790.0, to_s=800.0)
    assert convoy.cars == ("CAR_B", "CAR_C")
    np.testing.assert_allclose(convoy.speed, found.speed[100:201, 1:3], atol=1e-4)


def test_gaps_below_zero_may_be_skipped(tmp_path: Path, found: Platoon) -> None:
    below = found._replace(gap=np.where(found.time_s[:, None] < 5.0, -0.25, found.gap))
    convoy = read(tmp_path, openacc_text(below), skip_negative_gaps=True)
    assert convoy.told["from"] == "785 s, of 780 s"


def test_a_hundred_hertz_become_ten(tmp_path: Path, found: Platoon) -> None:
    fine = Platoon(found.time_s / 10.0, found.speed, found.gap)
    (tmp_path / "t.csv").write_text(
        "t,v_a,v_b,g_b\n"
        + "".join(
            f"{t:.2f},{v[0]:.5f},{v[1]:.5f},{g[1]:.5f}\n" for t, v, g in zip(*fine, strict=True)
        )
    )
    columns = Columns(time="t", speed="v_{}", gap="g_{}", unit="m/s")
    convoy = read_table(tmp_path / "t.csv", columns, Choice())
    np.testing.assert_allclose(convoy.time_s, np.arange(61) * 0.1)
    np.testing.assert_allclose(convoy.speed, found.speed[::10, :2], atol=1e-4)


def test_what_is_kept_is_read_again(tmp_path: Path, found: Platoon) -> None:
    convoy = read(tmp_path, openacc_text(found))
    folder = tmp_path / "kept"
    folder.mkdir()
    (folder / RECORDED).write_text(recorded_csv(convoy))
    for path in (folder, folder / RECORDED):
        again = read_convoy(path, Choice())
        same(again, found)
        assert (again.name, again.cars) == ("kept", CARS)
        assert again.setting == convoy.setting
    assert leader_csv(convoy).startswith("time_s,speed_mps\n0.000,15.0000\n0.100,15.03")


def test_a_file_of_another_kind_is_refused(tmp_path: Path, found: Platoon) -> None:
    (tmp_path / "t.csv").write_text(long_text(found))
    with pytest.raises(ConvoyError, match="neither a file of OpenACC nor what zenvoy import"):
        read_convoy(tmp_path / "t.csv", Choice())
