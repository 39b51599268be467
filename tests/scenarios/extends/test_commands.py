"""Commands show the whole scenario, log it, and refuse a wrong base in one line."""

from __future__ import annotations

import json
from pathlib import Path

from tests.conftest import zenvoy
from tests.scenarios.extends.conftest import BASE
from tests.streamed_log import read_log
from zenvoy.scenarios import Scenario, load


def test_the_command_shows_the_whole_scenario_and_the_log_keeps_both(tmp_path: Path) -> None:
    text = "extends: base.yaml\nduration_s: 1\nevents: []\n"
    (tmp_path / "base.yaml").write_text(BASE)
    (tmp_path / "s.yaml").write_text(text)
    shown = zenvoy(tmp_path, "show", "s.yaml", "--set", "seed=8")
    assert (shown.code, shown.err) == (0, "")
    assert "extends" not in shown.out
    (tmp_path / "whole.yaml").write_text(shown.out)
    whole = load(tmp_path / "whole.yaml").scenario
    assert whole == load(tmp_path / "s.yaml", ["seed=8"]).scenario
    assert (whole.seed, whole.duration_s, whole.fleet.size) == (8, 1.0, 9)

    ran = zenvoy(tmp_path, "run", "s.yaml", "--bus", "in-process", "--seed", "8", "--out", "out")
    assert ran.code == 0, ran
    log = read_log(tmp_path / "out" / "run.mcap")
    assert log.attachments["scenario.yaml"].decode() == text
    effective = log.attachments["effective.json"].decode()
    assert Scenario.model_validate_json(effective) == whole
    assert "extends" not in json.loads(effective)


def test_the_command_refuses_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text("extends: nowhere\n")
    refused = zenvoy(tmp_path, "check", "s.yaml")
    assert refused.code == 2
    assert refused.err.startswith("extends: 'nowhere' is neither a file nor a built-in scenario; ")
    assert refused.err.count("\n") == 1
