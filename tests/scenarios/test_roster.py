"""Groups, sets of vehicles and schedules give each vehicle its settings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.scenarios import (
    Control,
    Fleet,
    Gains,
    Group,
    MultiNode,
    Scenario,
    ScenarioError,
    Switch,
)
from zenvoy.scenarios import load as load_scenario
from zenvoy.scenarios.schema.roster import Settings, group_members, roster
from zenvoy.scenarios.schema.sets import drawn, members

HUMANS = frozenset({2, 5})


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("all", {1, 2, 3, 4, 5, 6}),
        ("3", {3}),
        ("2-4", {2, 3, 4}),
        ("2 - 4, 6", {2, 3, 4, 6}),
        ("humans", {2, 5}),
        ("humans, 1", {1, 2, 5}),
        ("not humans", {1, 3, 4, 6}),
        ("not 1-3, humans", {4, 6}),
    ],
)
def test_sets_are_read_as_they_are_written(text: str, expected: set[int]) -> None:
    assert members(text, 6, {"humans": HUMANS}) == expected


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("7", "7 is not within 1-6, the vehicles of fleet.size"),
        ("0-2", "0-2 is not within 1-6, the vehicles of fleet.size"),
        ("4-2", "4-2 is not within 1-6, the vehicles of fleet.size"),
        ("robots", "'robots' is not a vehicle, a range or one of all, humans"),
        ("", "'' is not a vehicle, a range or one of all, humans"),
        ("1,,2", "'' is not a vehicle, a range or one of all, humans"),
    ],
)
def test_wrong_sets_are_refused(text: str, message: str) -> None:
    with pytest.raises(ValueError, match="is n") as refusal:
        members(text, 6, {"humans": HUMANS})
    assert str(refusal.value) == message


@given(st.floats(0, 1), st.integers(2, 200), st.integers(0, 2**63 - 1))
def test_a_share_is_drawn_by_seed_and_name(share: float, size: int, seed: int) -> None:
    chosen = drawn("humans", share, size, seed)
    assert len(chosen) == round(share * size)
    assert chosen <= set(range(1, size + 1))
    assert chosen == drawn("humans", share, size, seed)
    more = drawn("humans", min(1.0, share + 0.2), size, seed)
    assert chosen <= more  # a higher penetration rate adds vehicles and takes none away


def test_another_seed_or_name_draws_others() -> None:
    chosen = {drawn(name, 0.5, 40, seed) for name in ("a", "b") for seed in range(20)}
    assert len(chosen) == 40


def test_every_vehicle_is_equally_likely_to_be_drawn() -> None:
    counts = dict.fromkeys(range(1, 11), 0)
    for seed in range(2_000):
        for vehicle in drawn("humans", 0.3, 10, seed):
            counts[vehicle] += 1
    # 600 ± 4.5 standard deviations of a binomial count
    assert all(508 < count < 692 for count in counts.values()), counts


def test_the_schedule_switches_vehicles_without_a_model_of_their_own() -> None:
    scenario = Scenario(
        fleet=Fleet(
            size=6,
            groups=(
                Group(name="humans", vehicles="2, 5", model="FM", beacons=False),
                Group(name="tail", vehicles="5-6", gains=Gains(k_d=0.3), desired_gap_m=50.0),
            ),
        ),
        control=Control(
            model="BCM",
            schedule=(
                Switch(at_s=10, model="PBCM"),
                Switch(at_s=20, model="MBCM", vehicles="1-2"),
                Switch(at_s=20, model="FM", vehicles="not 1-2"),
            ),
            multi_node=MultiNode(neighbours=2),
        ),
    )
    settings = roster(scenario)
    assert [own.program for own in settings] == [
        ((0, "BCM"), (10_000_000_000, "PBCM"), (20_000_000_000, "MBCM")),
        ((0, "FM"), (20_000_000_000, "MBCM")),
        ((0, "BCM"), (10_000_000_000, "PBCM"), (20_000_000_000, "FM")),
        ((0, "BCM"), (10_000_000_000, "PBCM"), (20_000_000_000, "FM")),
        ((0, "FM"), (20_000_000_000, "FM")),
        ((0, "BCM"), (10_000_000_000, "PBCM"), (20_000_000_000, "FM")),
    ]
    assert [own.beacons for own in settings] == [True, False, True, True, False, True]
    assert [own.gains.k_d for own in settings] == [0.1, 0.1, 0.1, 0.1, 0.3, 0.3]
    assert [own.desired_gap_m for own in settings] == [37.5] * 4 + [50.0] * 2


def test_later_groups_win_and_may_name_earlier_ones() -> None:
    groups = (
        Group(name="slow", vehicles="1-3", desired_speed_mps=20.0, model="FM"),
        Group(name="rest", vehicles="not slow", desired_speed_mps=0.0),
        Group(name="third", vehicles="3", desired_speed_mps=25.0),
    )
    scenario = Scenario(fleet=Fleet(size=5, groups=groups))
    assert group_members(scenario)["rest"] == {4, 5}
    speeds = [own.desired_speed_mps for own in roster(scenario)]
    assert speeds == [20.0, 20.0, 25.0, 0.0, 0.0]
    assert [own.models for own in roster(scenario)] == [{"FM"}] * 3 + [{"PBCM"}] * 2


def test_all_mistakes_in_groups_are_reported(tmp_path: Path) -> None:
    file = tmp_path / "s.yaml"
    file.write_text(
        """\
fleet:
  size: 10
  groups:
    - {name: humans, share: 0.4, model: FM, beacons: false}
    - {name: all, vehicles: 1}
    - {name: humans, vehicles: 11}
    - {name: both, vehicles: 1, share: 0.5}
    - {name: neither}
control:
  model: MBCM
  multi_node: {neighbours: 5, weights: [1, 2, 3]}
  schedule:
    - {at_s: 10, model: PBCM}
    - {at_s: 10, model: BCM, vehicles: not humans}
    - {at_s: 10, model: BCM, vehicles: humens}
"""
    )
    with pytest.raises(ScenarioError) as refusal:
        load_scenario(file)
    assert str(refusal.value).replace(str(tmp_path) + "/", "").splitlines() == [
        "fleet.size: 10 is not at least 11, which MBCM needs on the ring  (s.yaml, line 2)",
        "fleet.groups.1.name: 'all' has another meaning in a set of vehicles  (s.yaml, line 5)",
        "fleet.groups.2.name: 'humans' is already the name of another group  (s.yaml, line 6)",
        "fleet.groups.2.vehicles: 11 is not within 1-10, the vehicles of fleet.size"
        "  (s.yaml, line 6)",
        "fleet.groups.3: both vehicles and share; allowed: one of the two  (s.yaml, line 7)",
        "fleet.groups.4: neither vehicles nor share; allowed: one of the two  (s.yaml, line 8)",
        "control.multi_node.weights: 3 numbers, not one for each of"
        " control.multi_node.neighbours (5)  (s.yaml, line 11)",
        "control.schedule.2.vehicles: 'humens' is not a vehicle, a range or one of"
        " all, humans, both, neither  (s.yaml, line 15)",
    ]


@pytest.mark.parametrize("weights", ["sum", [], [0, 0], [1, -1], [1, "x"], [True], 3, None])
def test_wrong_weights_are_refused(tmp_path: Path, weights: object) -> None:
    file = tmp_path / "s.yaml"
    file.write_text(f"control: {{multi_node: {{weights: {weights!r}}}}}".replace("None", "null"))
    with pytest.raises(ScenarioError, match="is not least-squares, uniform, or a list of numbers"):
        load_scenario(file)


def test_seeds_share_settings_unless_they_draw_a_group() -> None:
    def of_seed(seed: int, **group: Any) -> tuple[Settings, ...]:
        return roster(Scenario(seed=seed, fleet=Fleet(groups=(Group(name="a", **group),))))

    assert of_seed(1, vehicles="1-3", model="FM") is of_seed(2, vehicles="1-3", model="FM")
    assert of_seed(1, share=0.5, model="FM") != of_seed(2, share=0.5, model="FM")
    assert of_seed(1, share=0.5, model="FM") == of_seed(1, share=0.5, model="FM")
