"""Built-in scenarios are listed, and have the values that are documented."""

from __future__ import annotations

from pathlib import Path

import pytest

from zenvoy.scenarios import (
    Brake,
    Channel,
    Control,
    Fleet,
    Loss,
    Road,
    Scenario,
    Sensors,
    Switch,
    builtin,
    load,
    technologies,
)


def test_the_library_is_listed_with_descriptions() -> None:
    listed = dict(builtin())
    assert {"quickstart", "paper/case-15"} <= listed.keys()
    assert all(text and "\n" not in text for text in listed.values())


def test_cases_are_listed_in_order_of_their_numbers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "paper").mkdir()
    for name in ("quickstart", "paper/case-15", "paper/case-2"):
        (tmp_path / f"{name}.yaml").write_text(f"description: about {name}\n")
    (tmp_path / "notes.txt").touch()
    monkeypatch.setattr("zenvoy.scenarios.reading.library.files", lambda _: tmp_path)
    names = ["paper/case-2", "paper/case-15", "quickstart"]
    assert builtin() == [(name, f"about {name}") for name in names]


def test_quickstart_has_its_documented_values() -> None:
    loaded = load("quickstart")
    assert loaded.name == "quickstart"
    assert loaded.scenario == Scenario(
        description=loaded.scenario.description,
        duration_s=60,
        fleet=Fleet(size=20),
        control=Control(model="PBCM"),
        sensors=Sensors(error=0.03),
        channel=Channel(technology=technologies()["ieee80211p"], loss=Loss(p=0.05)),
        events=(Brake(vehicle=5, at_s=10, duration_s=2, deceleration_mps2=3),),
    )


def test_case_15_has_the_values_of_the_paper() -> None:
    loaded = load("paper/case-15")
    assert loaded.name == "paper/case-15"
    assert loaded.scenario == Scenario(
        description=loaded.scenario.description,
        duration_s=500,
        road=Road(type="ring"),
        fleet=Fleet(size=40),
        control=Control(
            model="FM",
            schedule=(Switch(at_s=10, model="PBCM"),),
            v2v_wait_ms=11,
            system_delay_ms=89,
        ),
        sensors=Sensors(error=0.1),
        channel=Channel(loss=Loss(p=0)),
        events=(Brake(vehicle=5, at_s=10, duration_s=2, deceleration_mps2=3),),
    )
    assert loaded.scenario.v2v_wait_ns + loaded.scenario.system_delay_ns == 100_000_000
    assert loaded.scenario.ring_length_m == 1500.0
