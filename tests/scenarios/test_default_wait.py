"""The default wait for frames fits the technology of the channel."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.conftest import zenvoy
from tests.scenarios.conftest import Write
from zenvoy.scenarios import Scenario, load


@pytest.mark.parametrize(
    ("settings", "wait_ms"),
    [
        ((), 11.0),
        (("channel.technology=lte-a-pro",), 81.0),
        (("channel.technology=ieee80211px",), 11.0),
        (("channel.technology=5g-mmwave",), 11.0),
        (("channel.frame_bytes=30000",), 50.0),
        (("channel.bit_rate_mbps=0.1",), 34.0),
        (("control.v2v_wait_ms=null",), 11.0),
        (("channel.technology=lte-a-pro", "control.v2v_wait_ms=20"), 20.0),
        (("channel.technology=lte-a-pro", "control.v2v_wait_ms=0"), 0.0),
        (("channel.technology=lte-a-pro", "period_ms=81"), 0.0),
        (("period_ms=10",), 0.0),
        (("clock=realtime",), 26.0),
        (("clock=realtime", "speed=2"), 41.0),
        (("clock=realtime", "channel.technology=lte-a-pro"), 90.5),
        (("clock=realtime", "period_ms=20"), 15.5),
    ],
)
def test_the_default_wait_fits_the_technology(
    write: Write, settings: tuple[str, ...], wait_ms: float
) -> None:
    write("{}")
    scenario = load("s.yaml", settings).scenario
    assert scenario.control.v2v_wait_ms == wait_ms
    assert scenario.v2v_wait_ns == round(wait_ms * 1e6)
    assert scenario.control.system_delay_ms == 89.0  # does not depend on the radio
    assert Scenario.model_validate_json(scenario.model_dump_json()) == scenario


@pytest.mark.parametrize("technology", ["ieee80211p", "ieee80211px", "lte-a-pro", "5g-mmwave"])
def test_no_frame_is_late_by_default(tmp_path: Path, technology: str) -> None:
    """This is the README's example, shortened. A wait of 11 ms makes every LTE-A Pro frame late."""
    settings = ("--set", f"channel.technology={technology}", "--set", "channel.loss.p=0.3")
    command = ("run", "quickstart", "--bus", "in-process", "--duration-s", "11", *settings)
    assert zenvoy(tmp_path, *command, "--strict", "--out", "r").code == 0
    summary = json.loads((tmp_path / "r/summary.json").read_text())
    assert summary["frames"]["delivered"] > 0
    assert summary["frames"]["late"] == 0
