"""A scenario may use percent, merge keys and anchors, and may come through a pipe."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.scenarios.conftest import Write
from zenvoy.scenarios import ScenarioError, load


def refusal() -> str:
    with pytest.raises(ScenarioError) as caught:
        load("s.yaml")
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "value"),
    [("5%", 0.05), ("5 %", 0.05), ("33.3%", 0.333), (".5%", 0.005), ("100%", 1.0), ("0 %", 0.0)],
)
def test_a_fraction_may_be_written_in_percent(write: Write, text: str, value: float) -> None:
    write(f"channel: {{loss: {{p: {text}}}}}")
    assert load("s.yaml").scenario.channel.loss.p == value
    assert load("quickstart", [f"channel.loss.p={text}"]).scenario.channel.loss.p == value


def test_percent_is_allowed_wherever_a_fraction_is(write: Write) -> None:
    write(
        """
        sensors: {error: 3%}
        fleet: {groups: [{name: humans, share: 60 %}]}
        control: {platoon: {c1: 50%}}
        channel:
          duplicate: 1%
          latency: {sender_offset: {keep: 20%}}
          loss:
            corrupt: 2%
            by_distance: [[0, 1%], [100, 50%]]
            gilbert_elliott: {p: 5%, r: 30%, one_minus_h: 80%, one_minus_k: 1%}
            four_state: {p13: 1%, p31: 70%, p32: 10%, p23: 20%, p14: 1%}
        """
    )
    scenario = load("s.yaml").scenario
    assert scenario.sensors.error == 0.03
    assert scenario.fleet.groups[0].share == 0.6
    assert scenario.channel.loss.by_distance == ((0.0, 0.01), (100.0, 0.5))
    assert scenario.channel.loss.gilbert_elliott.one_minus_h == 0.8


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("channel: {loss: {p: 150%}}", "channel.loss.p: '150%' is not in [0, 1]"),
        ("sensors: {error: 100 %}", "sensors.error: '100 %' is not in [0, 1)"),
        ("channel: {loss: {p: 5 per cent}}", "channel.loss.p: '5 per cent' is not a number"),
        ("channel: {loss: {p: '5%%'}}", "channel.loss.p: '5%%' is not a number"),
        ("duration_s: 5%", "duration_s: '5%' is not a number"),
    ],
)
def test_wrong_percent_is_refused(write: Write, text: str, message: str) -> None:
    write(text)
    assert refusal() == f"{message}  (s.yaml, line 1)"


def test_merge_keys_add_the_keys_that_are_not_given(write: Write) -> None:
    write(
        """
        x-brake: &brake {at_s: 10, duration_s: 2, deceleration_mps2: 3}
        x-late: &late {at_s: 20}
        events:
          - {<<: *brake, vehicle: 5}
          - {vehicle: 6, <<: [*late, *brake]}
          - {at_s: 30, vehicle: 7, <<: *brake}
        """
    )
    events = load("s.yaml").scenario.events
    assert [(event.vehicle, event.at_s) for event in events] == [(5, 10), (6, 20), (7, 30)]


def test_a_merged_mapping_may_merge_another(write: Write) -> None:
    write("x-a: &a {k_d: 0.2}\nx-b: &b {<<: *a, k_v: 0.6}\ncontrol: {gains: {<<: *b, k_c: 0.1}}\n")
    gains = load("s.yaml").scenario.control.gains
    assert (gains.k_d, gains.k_v, gains.k_c) == (0.2, 0.6, 0.1)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "fleet: {<<: 3, size: 4}",
            "fleet.<<: neither a mapping nor a list of mappings; << merges nothing else"
            "  (s.yaml, line 1)",
        ),
        (
            "fleet: {<<: {size: 3}, <<: {size: 4}}",
            "fleet.<<: given twice, first in s.yaml, line 1; allowed: once  (s.yaml, line 1)",
        ),
        (
            "x-f: &f\n  siz: 3\nfleet: {<<: *f}",
            "fleet.siz: unknown key; did you mean 'size'? allowed: size, length_m, gap_m, "
            "bumper_gap_m, speed_mps, initial_gaps_m, initial_speeds_mps, reported_gaps, groups"
            "  (s.yaml, line 2)",
        ),
        (
            "fleet: &f {<<: *f}",
            "more than the limit of 50 levels  (s.yaml, line 1)",
        ),
    ],
)
def test_wrong_merge_keys_are_refused(write: Write, text: str, message: str) -> None:
    write(text)
    assert refusal() == message


def test_top_level_keys_that_begin_with_x_are_ignored(write: Write) -> None:
    write("x-note: {any: [thing, !!int x]}\nx-: 3\nseed: 4\n")
    assert load("s.yaml").scenario.seed == 4
    write("fleet: {x-size: 3}\n")
    assert refusal().startswith("fleet.x-size: unknown key")


def test_a_scenario_may_be_piped_in(tmp_path: Path) -> None:
    (tmp_path / "base.yaml").write_text("fleet: {size: 7}\n")

    def check(text: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "zenvoy.cli", "check", "-"]
        return subprocess.run(
            command, input=text, text=True, capture_output=True, check=False, cwd=tmp_path
        )

    outcome = check("extends: base.yaml\nduration_s: 3\n")
    assert (outcome.returncode, outcome.stdout) == (
        0,
        "stdin: valid; 7 vehicles, 3 s\nruns on arrays\n",
    )
    outcome = check("seed: -1\n")
    assert outcome.returncode == 2
    assert "(standard input, line 1)" in outcome.stderr


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("quikstart", "quickstart"),
        ("quickstart.yaml", "quickstart"),
        ("QuickStart", "quickstart"),
        ("case-15", "paper/case-15"),
        ("Case15", "paper/case-15"),
        ("lte-a-pro", "technologies/lte-a-pro"),
        ("paper/case_15", "paper/case-15"),
        ("half_converted", "mixed/half-converted"),
        ("s", "s.yaml"),
        ("s.yml", "s.yaml"),
    ],
)
def test_misspelt_names_get_a_suggestion(write: Write, name: str, meant: str) -> None:
    write("{}")
    with pytest.raises(ScenarioError, match=f"did you mean '{meant}'"):
        load(name)


def test_files_beside_a_base_are_not_suggested(write: Write) -> None:
    write("extends: secre\n")
    Path("secret.yaml").write_text("{}")
    assert "secret" not in refusal()
