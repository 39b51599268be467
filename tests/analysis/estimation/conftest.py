"""Fixture of the run whose estimates the tests of this folder judge."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.logs import write_log
from zenvoy.analysis import load
from zenvoy.analysis.log.load import Run

PBCM = """
duration_s: 30
seed: 3
fleet: {size: 6}
control: {model: PBCM, v2v_wait_ms: 50, system_delay_ms: 100}
channel: {technology: lte-a-pro, loss: {p: 0.2}}
sensors: {error: 0.1}
events:
  - {vehicle: 3, at_s: 5, duration_s: 2, deceleration_mps2: 3}
  - {vehicle: 4, at_s: 4, duration_s: 1, deceleration_mps2: 1}
"""


@pytest.fixture(scope="module")
def run(folder: Path) -> Run:
    return load(write_log(folder / "pbcm.mcap", PBCM))
