"""Wrong faults are refused with a line each; faults that never happen are noted."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import pytest

from tests.scenarios.conftest import Refusal
from zenvoy.scenarios import Fault, load

TYPES = (
    "sensor-blind, sensor-frozen, sensor-biased, sensor-drifting, sensor-jumping, "
    "transmitter-silent, transmitter-babbling, transmitter-repeating, transmitter-lying, "
    "actuator-stuck, process-killed, process-frozen, process-slowed"
)


@pytest.mark.parametrize(
    ("fault", "line"),
    [
        ("{type: broken, vehicles: 3, at_s: 1}", f"faults.0.type: 'broken' is not one of {TYPES}"),
        (
            "{type: sensor-biased, vehicles: 3, at_s: 1, gap_m: 0}",
            "faults.0: changes nothing; allowed: gap_m or relative_speed_mps or position_m or "
            "speed_mps or acceleration_mps2 other than 0",
        ),
        (
            "{type: sensor-biased, vehicles: 41, at_s: 1, gap_m: 1}",
            "faults.0.vehicles: 41 is not within 1-40, the vehicles of fleet.size",
        ),
        (
            "{type: sensor-blind, sensor: speed, vehicles: 3, at_s: 1}",
            "faults.0.sensor: 'speed' is not radar",
        ),
        (
            "{type: sensor-jumping, share: 0, gap_m: 1, vehicles: 3, at_s: 1}",
            "faults.0.share: 0 is not in (0, 1]",
        ),
        (
            "{type: actuator-stuck, vehicles: 3, at_s: 1, duration_s: 0}",
            "faults.0.duration_s: 0 is not in (0, 1e9]",
        ),
        (
            "{type: transmitter-silent, vehicles: 3, at_s: 1, position_m: 2}",
            "faults.0.position_m: unknown key; allowed: type, vehicles, at_s, duration_s",
        ),
        ("3", f"faults.0: 3 is not a mapping; its type: one of {TYPES}"),
    ],
)
def test_a_wrong_fault_is_refused(refusal: Refusal, fault: str, line: str) -> None:
    assert refusal(f"faults:\n  - {fault}\n") == f"{line}  (s.yaml, line 2)"


def test_a_fault_after_the_end_is_noted(tmp_path: Path) -> None:
    text = "duration_s: 5\nfaults:\n  - {type: transmitter-silent, vehicles: 3, at_s: 5}\n"
    (tmp_path / "s.yaml").write_text(text)
    (note,) = load(tmp_path / "s.yaml").notes
    assert (note.key, note.text) == ("faults.0.at_s", "begins at 5 s, but the run ends at 5 s")


def test_a_fault_in_words_has_its_amounts(tmp_path: Path) -> None:
    faults = """
  - {type: sensor-drifting, vehicles: 1, at_s: 1, gap_mps: 0.5, speed_mps2: -1}
  - {type: sensor-jumping, vehicles: 1, at_s: 1, share: 5%, gap_m: -3}
  - {type: actuator-stuck, vehicles: 1, at_s: 1}
"""
    (tmp_path / "s.yaml").write_text(f"faults:{faults}")
    assert [fault.words for fault in load(tmp_path / "s.yaml").scenario.faults] == [
        "sensor drifting: gap +0.5 m/s, speed -1 m/s²",
        "sensor jumping: gap ±3 m in 5 % of cycles",
        "actuator stuck",
    ]


def test_a_kind_of_fault_without_words_cannot_be_made() -> None:
    class Nameless(Fault):
        type: Literal["nameless"]

    with pytest.raises(TypeError, match="abstract method words"):
        Nameless(type="nameless", vehicles="3", at_s=1.0)  # type: ignore[abstract]  # as tested
