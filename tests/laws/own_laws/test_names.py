"""A scenario names a law, and its code is found by that name: in a file, or in a package."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import zenvoy as api
from tests.conftest import zenvoy
from tests.idm import IDM
from zenvoy.analysis.log.load import load
from zenvoy.bus import messages_pb2 as pb
from zenvoy.studies.cell import Cell


def test_code_is_found_beside_the_scenario_from_any_working_folder(laws: Path) -> None:
    folder = laws / "deep"
    folder.mkdir()
    shutil.copy(laws / "idm.py", folder)
    (folder / "s.yaml").write_text('control: {model: "idm:smith"}')
    assert zenvoy(laws, "check", "deep/s.yaml").code == 0
    assert zenvoy(laws, "check", "quickstart", "--set", "control.model=idm:smith").code == 0


def test_code_from_elsewhere_runs_only_with_permission(laws: Path) -> None:
    (laws.parent / "away.py").write_text(IDM)
    (laws / "s.yaml").write_text('control: {model: "../away.py:smith"}')
    assert zenvoy(laws, "check", "s.yaml").code == 2
    assert zenvoy(laws, "check", "s.yaml", "--allow-code").code == 0
    with pytest.raises(api.ScenarioError, match="is not beside the scenario"):
        api.scenario(laws / "s.yaml")
    found = api.scenario(laws / "s.yaml", allow_code=True).scenario.control.model
    assert found.startswith("../away.py:smith#")


def test_a_law_of_an_installed_package_is_found_by_its_entry_point(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    site, scenarios = tmp_path / "site", tmp_path / "scenarios"
    facts = site / "smith_laws-1.2.dist-info"
    for folder in (site / "smith_laws", facts, scenarios):
        folder.mkdir(parents=True)
    (site / "smith_laws" / "__init__.py").write_text(IDM)
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: smith-laws\nVersion: 1.2\n")
    (facts / "top_level.txt").write_text("smith_laws\n")
    (facts / "entry_points.txt").write_text("[zenvoy.laws]\nSmith = smith_laws:smith\n")
    monkeypatch.setenv("PYTHONPATH", str(site))
    (scenarios / "s.yaml").write_text(
        "duration_s: 2\nfleet: {size: 3}\ncontrol: {model: Smith, parameters: {a: 1.0}}\n"
    )
    prints = set()
    for bus in ("in-process", "zenoh"):
        outcome = zenvoy(scenarios, "run", "s.yaml", "--bus", bus, "--out", bus)
        assert outcome.code == 0, outcome.err
        run = load(scenarios / bus / "run.mcap")
        prints.add(run.fingerprint)
        law = run.laws[pb.MODE_OWN]
        assert (law.name, law.version) == ("Smith", "smith-laws 1.2")
        assert law.reference.startswith("smith_laws:smith#")
    assert len(prints) == 1
    monkeypatch.delenv("PYTHONPATH")
    outcome = zenvoy(scenarios, "check", "s.yaml")
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith("control.model: 'Smith' is not one of FM, BCM, MBCM, PBCM, CACC")


def test_a_changed_source_is_another_law(laws: Path) -> None:
    shown = zenvoy(laws, "show", "mixed.yaml").out
    assert "idm:smith#" in shown
    (laws / "shown.yaml").write_text(shown)
    assert zenvoy(laws, "check", "shown.yaml").code == 0
    changed = IDM.replace("1.4", "1.5") + "\nopen('ran', 'w').close()\n"
    (laws / "idm.py").write_text(changed)
    outcome = zenvoy(laws, "check", "shown.yaml")
    assert outcome.code == 2
    assert "its source has changed" in outcome.err
    assert not (laws / "ran").exists()  # it is not run to find that out


def test_a_study_notices_a_changed_source(laws: Path) -> None:
    cell = Cell(scenario=str(laws / "mixed.yaml"), seed=1)
    before = cell.key()
    assert cell.key() == before
    (laws / "idm.py").write_text(IDM.replace("1.4", "1.5"))
    assert cell.key() != before
