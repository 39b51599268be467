"""Laws of the library take their parameters from `parameters`, which is checked and filled in."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.scenarios.conftest import Refusal
from zenvoy.laws.library import acc, idm
from zenvoy.scenarios import effective_yaml, load, roster
from zenvoy.vehicles.control import controllers


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "control: {model: ACC, parameters: {headway: 1}}",
            "control.parameters.headway: unknown key; did you mean 'headway_s'? allowed: "
            "headway_s, lambda_per_s, standstill_m  (s.yaml, line 1)",
        ),
        (
            "control:\n  model: ACC\n  parameters: {headway_s: 0}",
            "control.parameters.headway_s: 0 is not in (0, 1e9]  (s.yaml, line 3)",
        ),
        (
            "fleet: {groups: [{name: a, vehicles: 1, model: IDM, parameters: {exponent: 4.5}}]}",
            "fleet.groups.0.parameters.exponent: 4.5 is not a whole number  (s.yaml, line 1)",
        ),
        (
            "control: {schedule: [{at_s: 1, model: IDM, parameters: {free_speed_mps: .nan}}]}",
            "control.schedule.0.parameters.free_speed_mps: nan is not a finite number"
            "  (s.yaml, line 1)",
        ),
        (
            "control: {parameters: {headway_s: 1}}",
            "control.parameters: given without a model; allowed with the model of a law that has "
            "parameters  (s.yaml, line 1)",
        ),
    ],
)
def test_wrong_parameters_are_refused(refusal: Refusal, text: str, message: str) -> None:
    assert refusal(text) == message


def test_parameters_of_the_fleet_count_wherever_its_law_is_named(tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"
    path.write_text("""
fleet:
  size: 4
  groups:
    - {name: patient, vehicles: 2, model: IDM, parameters: {headway_s: 2}}
    - {name: others, vehicles: 3, model: ACC}
control:
  model: IDM
  parameters: {standstill_m: 3}
  schedule: [{at_s: 1, vehicles: 3, model: IDM}]
""")
    loaded = load(path).scenario
    found = [
        [controller.parameters for _, controller in controllers(loaded, settings)]
        for settings in roster(loaded)
    ]
    fleet = idm.Parameters(standstill_m=3)
    assert found == [[fleet], [idm.Parameters(headway_s=2)], [acc.Parameters(), fleet], [fleet]]
    path.write_text(effective_yaml(loaded))
    assert load(path).scenario == loaded
    assert "acceleration_mps2: 1.0" in path.read_text()


def test_a_gap_that_no_law_keeps_is_not_noted(tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"
    text = "fleet: {size: 4, gap_m: 30}\ncontrol: {model: ACC, neighbour_state: %s}"
    path.write_text(text % "radar")
    assert load(path).notes == ()
    path.write_text(text % "position")  # which a lost beacon leaves to FM
    assert [note.key for note in load(path).notes] == ["control.desired_gap_m"]
