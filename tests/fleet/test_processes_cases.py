"""The paper's cases, mixes and platoons have the same bits with and without processes."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import pytest

from tests.conftest import zenvoy
from tests.streamed_log import read_log

SHORT: Final = ["--duration-s", "2.5", "--set", "fleet.size=8", "--set", "events.0.at_s=0.5"]
CASES: Final = [f"paper/case-{number:02}" for number in range(1, 17)]
MIXED: Final = ["mixed/humans", "mixed/platoons", "mixed/half-converted"]


def fingerprint(folder: Path, scenario: str, bus: str) -> str:
    """Return the fingerprint of a shortened run: half a second of FM, then the case's own model."""
    folder.mkdir()
    settings = [*SHORT, "--bus", bus]
    if scenario in CASES[4:]:
        settings += ["--set", "control.schedule.0.at_s=0.4"]
    if scenario == "mixed/half-converted":
        settings += ["--set", "fleet.groups.0.vehicles=1-4", "--set", "control.schedule.0.at_s=0.4"]
        settings += ["--set", "control.schedule.1.at_s=1"]
    if scenario == "mixed/platoons":
        settings += ["--set", "control.platoon.size=4"]
    outcome = zenvoy(folder, "run", scenario, "--out", "out", *settings)
    assert (outcome.code, outcome.err) == (0, ""), outcome
    log = read_log(folder / "out" / "run.mcap")
    assert log.result["end"] == "complete"
    return log.result["fingerprint"]


@pytest.mark.parametrize("scenario", [*CASES, *MIXED])
def test_both_buses_write_the_same(tmp_path: Path, scenario: str) -> None:
    found = {bus: fingerprint(tmp_path / bus, scenario, bus) for bus in ("zenoh", "in-process")}
    assert found["zenoh"] == found["in-process"]
