"""Spacing may be given from bumper to bumper or from front to front."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

import pytest

from tests import recordings
from tests.scenarios.test_library import run
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.topics import EVENTS
from zenvoy.scenarios import Scenario, ScenarioError, effective_yaml, load

DOCS: Final = Path(__file__).parents[2] / "docs"


def scenario_of(folder: Path, text: str, *settings: str) -> Scenario:
    (folder / "s.yaml").write_text(text)
    return load(folder / "s.yaml", settings).scenario


ALL: Final = """
fleet:
  length_m: 4
  bumper_gap_m: 6
  groups: [{name: tail, vehicles: 3-4, desired_bumper_gap_m: 10}, {name: rest, vehicles: 1-2}]
  size: 4
control:
  model: FM
  desired_bumper_gap_m: 5
  schedule:
    - {at_s: 3, desired_bumper_gap_m: 8, ramp_s: 2}
    - {at_s: 5, model: CACC}
"""


def test_the_two_spacings_differ_by_the_length(tmp_path: Path) -> None:
    scenario = scenario_of(tmp_path, ALL)
    assert (scenario.fleet.gap_m, scenario.control.desired_gap_m) == (10.0, 9.0)
    assert [group.desired_gap_m for group in scenario.fleet.groups] == [14.0, None]
    assert [switch.desired_gap_m for switch in scenario.control.schedule] == [12.0, None]
    longer = scenario_of(tmp_path, ALL, "fleet.length_m=12")
    assert (longer.fleet.gap_m, longer.control.desired_gap_m) == (18.0, 17.0)
    assert scenario_of(tmp_path, "fleet: {bumper_gap_m: 5}").fleet.gap_m == 10.0
    text = effective_yaml(scenario)
    assert "bumper_gap_m" not in text
    assert scenario_of(tmp_path, text) == scenario


@pytest.mark.parametrize(
    ("text", "settings", "reported"),
    [
        ("fleet: {gap_m: 30}", [], "front-to-front"),
        ("fleet: {bumper_gap_m: 30}", [], "bumper-to-bumper"),
        ("control: {desired_bumper_gap_m: 30}", [], "bumper-to-bumper"),
        (
            "fleet: {groups: [{name: a, vehicles: 2, desired_bumper_gap_m: 9}]}",
            [],
            "bumper-to-bumper",
        ),
        ("control: {schedule: [{at_s: 3, desired_bumper_gap_m: 9}]}", [], "bumper-to-bumper"),
        ("fleet: {bumper_gap_m: 30}", ["fleet.gap_m=20"], "front-to-front"),
        ("fleet: {gap_m: 30}", ["fleet.bumper_gap_m=20"], "bumper-to-bumper"),
        ("fleet: {bumper_gap_m: 30, reported_gaps: front-to-front}", [], "front-to-front"),
        ("fleet: {gap_m: 30, reported_gaps: bumper-to-bumper}", [], "bumper-to-bumper"),
    ],
)
def test_a_scenario_is_reported_with_the_gaps_that_count_in_it(
    tmp_path: Path, text: str, settings: list[str], reported: str
) -> None:
    scenario = scenario_of(tmp_path, text, *settings)
    assert scenario.fleet.reported_gaps == reported
    assert scenario_of(tmp_path, effective_yaml(scenario)) == scenario


def test_a_scenario_that_extends_one_with_bumper_gaps_is_reported_so(tmp_path: Path) -> None:
    (tmp_path / "base.yaml").write_text("fleet: {bumper_gap_m: 6}\n")
    reported = scenario_of(tmp_path, "extends: base.yaml\nduration_s: 9\n").fleet.reported_gaps
    assert reported == "bumper-to-bumper"
    replaced = "extends: base.yaml\nfleet: {gap_m: 20}\n"
    assert scenario_of(tmp_path, replaced).fleet.reported_gaps == "front-to-front"


def test_the_later_spacing_wins(tmp_path: Path) -> None:
    (tmp_path / "base.yaml").write_text("fleet: {gap_m: 30}\ncontrol: {desired_bumper_gap_m: 20}\n")
    extended = "extends: base.yaml\nfleet: {bumper_gap_m: 7}\ncontrol: {desired_gap_m: 12}\n"
    scenario = scenario_of(tmp_path, extended)
    assert (scenario.fleet.gap_m, scenario.control.desired_gap_m) == (12.0, 12.0)
    scenario = scenario_of(tmp_path, extended, "fleet.gap_m=50", "control.desired_bumper_gap_m=1")
    assert (scenario.fleet.gap_m, scenario.control.desired_gap_m) == (50.0, 6.0)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            "fleet: {gap_m: 10, bumper_gap_m: 5}",
            "fleet.bumper_gap_m: given together with gap_m; allowed: one of the two",
        ),
        (
            "control: {schedule: [{at_s: 1, desired_gap_m: 10, desired_bumper_gap_m: 5}]}",
            "control.schedule.0.desired_bumper_gap_m: given together with desired_gap_m; "
            "allowed: one of the two",
        ),
        ("fleet: {bumper_gap_m: 0}", "fleet.bumper_gap_m: 0 is not in (0, 1e9]"),
        ("fleet: {bumper_gap_m: .nan}", "fleet.bumper_gap_m: nan is not in (0, 1e9]"),
        ("control: {desired_bumper_gap_m: x}", "control.desired_bumper_gap_m: 'x' is not a number"),
        (
            "fleet: {bumpergap_m: 5}",
            "fleet.bumpergap_m: unknown key; did you mean 'bumper_gap_m'? allowed: size, length_m, "
            "gap_m, bumper_gap_m, speed_mps, initial_gaps_m, initial_speeds_mps, reported_gaps, "
            "groups",
        ),
    ],
)
def test_wrong_spacings_are_refused(tmp_path: Path, text: str, line: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        scenario_of(tmp_path, text)
    assert str(caught.value) == f"{line}  ({tmp_path / 's.yaml'}, line 1)"


# The pages for users of other tools -----------------------------------------------------------

BLOCKS: Final = [
    (page, text)
    for page in ("from-plexe", "from-sumo")
    for text in re.findall(
        r"^ *```yaml\n(.*?)^ *```", (DOCS / f"{page}.md").read_text(), re.S | re.M
    )
]


@pytest.mark.parametrize(("page", "text"), BLOCKS)
def test_scenarios_of_the_pages_run(tmp_path: Path, page: str, text: str) -> None:
    (tmp_path / "s.yaml").write_text(text)
    (tmp_path / "fcd.csv").write_text(recordings.FCD)
    loaded = load(tmp_path / "s.yaml").scenario
    assert loaded.fleet.gap_m > loaded.fleet.length_m
    log = run(load(tmp_path / "s.yaml", duration_s=7.0).scenario)
    kinds = {pb.Event.FromString(data).kind for data in log.get(EVENTS, [])}
    assert pb.EVENT_COLLISION not in kinds


def test_the_keys_that_the_pages_name_exist() -> None:
    """In tables, keys of Zenvoy are in the second column. laws.md has the parameters of laws."""
    known = (DOCS / "scenarios.md").read_text() + (DOCS / "laws.md").read_text()
    for page in ("from-plexe", "from-sumo"):
        rows = re.findall(r"^\| [^|]+ \| ([^|]+) \|", (DOCS / f"{page}.md").read_text(), re.M)
        keys = [key for row in rows for key in re.findall(r"`([a-z_0-9.]+)`", row)]
        keys = [key for key in keys if not key.endswith(".mcap")]
        assert len(keys) > 5
        for key in keys:
            assert f"`{key.rpartition('.')[2]}`" in known or f"`{key}`" in known, key
