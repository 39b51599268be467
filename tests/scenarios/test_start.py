"""A scenario may give the gap and the speed of each vehicle at the start."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.conftest import zenvoy
from tests.refused import refused
from zenvoy.analysis.log.load import load as load_log
from zenvoy.fleet.folder import LOG
from zenvoy.scenarios import Scenario, load
from zenvoy.world.fleet import Fleet

OPEN = """
duration_s: 5
road: {type: open}
fleet:
  size: 4
  initial_gaps_m: [12.25, 30, 17.1]
  initial_speeds_mps: [20, 21, 19.5, 20]
control: {model: PBCM}
"""


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            "fleet: {size: 4, initial_gaps_m: [10, 20]}",
            "fleet.initial_gaps_m: 2 numbers, not one less than fleet.size (4): "
            "the first vehicle has no gap  (s.yaml, line 1)",
        ),
        (
            "fleet:\n  size: 3\n  initial_speeds_mps: [10, 20]",
            "fleet.initial_speeds_mps: 2 numbers, not one for each of fleet.size (3)"
            "  (s.yaml, line 3)",
        ),
        (
            "fleet: {size: 3, initial_gaps_m: [10, 4.5]}",
            "fleet.initial_gaps_m.1: 4.5 is not greater than fleet.length_m (5)  (s.yaml, line 1)",
        ),
        (
            "fleet: {size: 3, gap_m: 10, initial_gaps_m: [12, 14]}\ncontrol: {desired_gap_m: 10}",
            "fleet.initial_gaps_m: they leave 4 m of the ring (30 m) to the first vehicle, not "
            "more than fleet.length_m (5)  (s.yaml, line 1)",
        ),
        (
            "fleet: {size: 3, initial_gaps_m: [10, .nan]}",
            "fleet.initial_gaps_m.1: nan is not in (0, 1e9]  (s.yaml, line 1)",
        ),
        (
            "fleet: {size: 3, initial_speeds_mps: [10, -1, 2]}",
            "fleet.initial_speeds_mps.1: -1 is not in [0, 1e9]  (s.yaml, line 1)",
        ),
        (
            "fleet: {size: 3, initial_speeds_mps: 10}",
            "fleet.initial_speeds_mps: 10 is not a list or null  (s.yaml, line 1)",
        ),
    ],
)
def test_a_wrong_start_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, line: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert refused(Path(), text) == [line]


def test_positions_add_up_the_gaps_from_the_last_vehicle_on(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(OPEN)
    fleet = load(tmp_path / "s.yaml").scenario.fleet
    assert fleet.positions_at_start_m == (17.1 + 30 + 12.25, 17.1 + 30, 17.1, 0.0)
    assert fleet.gaps_at_start_m == (12.25, 30.0, 17.1)


def test_an_even_start_is_as_before() -> None:
    fleet = Scenario.model_validate({"fleet": {"size": 4, "gap_m": 33.3, "speed_mps": 7}}).fleet
    assert fleet.positions_at_start_m == tuple(np.arange(3.0, -1.0, -1.0) * 33.3)
    assert fleet.speeds_at_start_mps == (7.0,) * 4


def test_all_engines_start_so_and_log_the_same(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(OPEN)
    prints = set()
    for engine in ("processes", "in-process", "arrays"):
        outcome = zenvoy(tmp_path, "run", "s.yaml", "--engine", engine, "--out", engine)
        assert outcome.code == 0, outcome
        log = load_log(tmp_path / engine / LOG)
        prints.add(log.fingerprint)
        assert log.truth["speed"][0].tolist() == [20, 21, 19.5, 20]
        assert np.allclose(-np.diff(log.truth["position"][0]), [12.25, 30, 17.1])
    assert len(prints) == 1


def test_on_a_ring_the_first_vehicle_has_the_rest() -> None:
    fleet = {"size": 4, "gap_m": 20.0, "initial_gaps_m": [12.25, 30.0, 17.1]}
    scenario = Scenario.model_validate({"fleet": fleet})
    assert Fleet(scenario).gaps == pytest.approx([80.0 - 59.35, 12.25, 30.0, 17.1])


def test_an_uneven_start_has_no_note_on_the_even_gap(tmp_path: Path) -> None:
    text = OPEN.replace("{model: PBCM}", "{desired_speed_mps: 20}")
    (tmp_path / "s.yaml").write_text(text)
    assert load(tmp_path / "s.yaml").notes == ()


def test_the_first_vehicle_keeps_its_own_speed(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(OPEN)
    (note,) = load(tmp_path / "s.yaml").notes
    assert note.text == ("30 is not fleet.initial_speeds_mps.0 (20), which the first vehicle keeps")
