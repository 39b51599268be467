"""A fit finds the numbers with which a convoy was made, for any law that looks ahead."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.studies.convoys.conftest import convoy_of, scenario_of
from zenvoy.scenarios import Scenario
from zenvoy.scenarios.convoys.errors import ConvoyError
from zenvoy.scenarios.convoys.folder import files_of
from zenvoy.studies.convoys.calibration import calibrate, model_named, task_for
from zenvoy.studies.convoys.groups import names_of, scenario_values

OWN = """
from dataclasses import dataclass
from zenvoy.laws import Law

@dataclass(frozen=True)
class Parameters:
    gain: float = 0.2
    time_gap_s: float = 1.0
    label: str = "x"

def follow(seen, own):
    error = seen.ahead.p - seen.length_m - 3.0 - own.time_gap_s * seen.speed
    return own.gain * error + 0.6 * seen.ahead.v

MINE = Law(name="Mine", acceleration=follow, parameters=Parameters)
"""


def test_fm_is_found_again(tmp_path: Path) -> None:
    gains = {"k_d": 0.16, "k_v": 0.45, "k_c": 0.0}
    scenario = scenario_of({"model": "FM", "gains": gains, "desired_gap_m": 23.0})
    convoy = convoy_of(scenario, tmp_path / "run")
    found = calibrate(convoy, model_named("fm"), bounds={}, jobs=2)
    for fit in found.fits:
        assert fit.rms_gap_m < 0.01
        assert fit.values["k_d"] == pytest.approx(0.16, rel=0.02)
        assert fit.values["k_v"] == pytest.approx(0.45, rel=0.02)
        assert fit.values["desired_gap_m"] == pytest.approx(23.0, abs=0.1)


def test_acc_is_found_again_and_holds_on_another_recording(tmp_path: Path) -> None:
    control = {"model": "ACC", "parameters": {"headway_s": 1.4, "lambda_per_s": 0.3}}
    convoy = convoy_of(scenario_of(control), tmp_path / "run")
    brake = {"type": "brake", "vehicle": 1, "at_s": 5.0, "duration_s": 2.0,
             "deceleration_mps2": 3.0}  # fmt: skip
    other = convoy_of(scenario_of(control, events=[brake]), tmp_path / "other")
    found = calibrate(convoy, model_named("acc"), bounds={}, hold_out=[other], jobs=2)
    for fit, held in zip(found.fits, found.held, strict=True):
        assert fit.values["headway_s"] == pytest.approx(1.4, rel=0.02)
        assert fit.values["lambda_per_s"] == pytest.approx(0.3, rel=0.02)
        assert [one.recording for one in held] == ["other"]
        assert held[0].rms_gap_m < 0.05


def test_a_law_of_ones_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(OWN)
    model = model_named("mine.py:MINE")
    convoy = convoy_of(scenario_of({"model": "ACC"}), tmp_path / "run")
    task = task_for(convoy, model, {"gain": (0.1, 0.3)})
    assert [(one.name, one.low, one.high, one.of) for one in task.free] == [
        ("gain", 0.1, 0.3, "law"),
        ("time_gap_s", 0.1, 10.0, "law"),
    ]
    found = calibrate(convoy, model, bounds={}, jobs=2)
    assert max(fit.rms_gap_m for fit in found.fits) < 1.0
    groups = scenario_values(found, tmp_path / "out")["fleet"]["groups"]
    assert [group["model"] for group in groups] == ["../mine.py:MINE"] * 2
    assert set(groups[0]["parameters"]) == {"gain", "time_gap_s"}


def test_the_scenario_of_a_fit_drives_as_the_fit(tmp_path: Path) -> None:
    convoy = convoy_of(scenario_of({"model": "IDM"}), tmp_path / "run")
    found = calibrate(convoy, model_named("idm"), bounds={}, jobs=2)
    values = scenario_values(found)
    assert set(files_of(convoy, values)) == {"leader.csv", "recorded.csv", "scenario.yaml"}
    points = list(zip(convoy.time_s.tolist(), convoy.speed[:, 0].tolist(), strict=True))
    values["events"] = [{"type": "trace", "vehicle": 1, "at_s": 0, "points": points}]
    again = convoy_of(Scenario.model_validate(values), tmp_path / "again")
    assert abs(again.gap - convoy.gap)[:, 1].max() < 0.5
    assert found.fits[0].rms_gap_m < 0.1


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("PBCM", "--law: PBCM uses what others report; allowed: a law that looks ahead by its own "
                 "radar only"),
        ("cacc", "--law: CACC uses what others report; allowed: a law that looks ahead by its own "
                 "radar only"),
        ("no.py:X", "--law: 'no.py:X': there is no file no.py"),
    ],
)  # fmt: skip
def test_laws_that_cannot_be_fitted_are_refused(name: str, line: str) -> None:
    with pytest.raises(ConvoyError) as refused:
        model_named(name)
    assert str(refused.value) == line


def test_a_bound_of_another_number_is_refused(tmp_path: Path) -> None:
    convoy = convoy_of(scenario_of({"model": "ACC"}, duration_s=10), tmp_path / "run")
    with pytest.raises(ConvoyError) as refused:
        task_for(convoy, "ACC", {"k_d": (0.1, 0.2)})
    assert str(refused.value) == (
        "--bound: 'k_d' is not a number of ACC; "
        "allowed: one of headway_s, lambda_per_s, standstill_m"
    )


def test_groups_have_names_of_their_own() -> None:
    assert names_of(["A-B", "A B", "3", "Ä", "A_B"]) == [
        "A_B",
        "A_B_no2",
        "car_3",
        "car",
        "A_B_no3",
    ]
