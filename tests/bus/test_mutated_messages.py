"""The processes of a run refuse mutated messages, and the run goes on unchanged.

docs/robustness.md says what is claimed, and what is not.
"""

from __future__ import annotations

import math
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Final

import pytest

from tests.attack.attacker import FIRST_CYCLE
from tests.attack.mutator import MARK
from tests.conftest import LIMIT_S, run
from tests.fleet_of_three import FLEET, MOST_LINES
from tests.streamed_log import Log, read_log
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.mailbox import WINDOW

ALONE: Final = ("vehicle-01", "vehicle-02", "vehicle-03")
TOGETHER: Final = ("vehicles-01-02", "vehicle-03")
AS_ARRAYS: Final = ("vehicles-01-03",)


def under_attack(
    folder: Path, scenario: str, vehicles: tuple[str, ...] = ALONE
) -> tuple[Log, dict[str, Counter[str]]]:
    """Return the log of an attacked run, and the refusals of each process by reason."""
    folder.mkdir()
    (folder / "s.yaml").write_text(scenario)
    arguments = [str(folder / "s.yaml"), str(folder / "out"), "200"]
    arguments.append(str(4 - len(vehicles)))
    ended = subprocess.run(
        [sys.executable, "-m", "tests.attack", *arguments],
        cwd=Path(__file__).parents[2],
        capture_output=True,
        text=True,
        timeout=2 * LIMIT_S,
        check=False,
    )
    assert (ended.returncode, ended.stderr) == (0, ""), ended.stderr
    log = read_log(folder / "out" / "run.mcap")
    assert log.result["end"] == "complete"
    logs = {path.stem: path for path in (folder / "out" / "logs").iterdir()}
    assert logs.keys() == {"world", "channel", "attacker", *vehicles}
    assert logs.pop("attacker").read_text() == ""
    return log, {name: refused(name, path.read_text()) for name, path in logs.items()}


def refused(name: str, text: str) -> Counter[str]:
    """Return the counts at the end of a process's log. The log must be short."""
    lines = text.splitlines()
    assert len(lines) <= MOST_LINES
    assert len(set(lines)) == len(lines)
    assert all(line.startswith(f"{name}: ") for line in lines)
    reasons = {line.split(": ")[2].split(",")[0] for line in lines if ": refused: " in line}
    counts = Counter({why: int(n) for n, why in re.findall(r"(\d+) (\w+)", lines[-1])})
    assert lines[-1].startswith(f"{name}: messages refused: ")
    assert reasons <= counts.keys()
    return counts


@pytest.mark.parametrize("vehicles", [ALONE, AS_ARRAYS], ids=["alone", "as arrays"])
def test_a_run_in_lock_step_keeps_its_fingerprint(
    tmp_path: Path, vehicles: tuple[str, ...]
) -> None:
    # 1,000 cycles of 200 mutants each, however busy the machine is.
    scenario = f"duration_s: 100\n{FLEET}"
    attacked, counts = under_attack(tmp_path / "attacked", scenario, vehicles)
    alone = run(tmp_path / "alone", scenario, "--bus", "in-process")
    assert attacked.result["fingerprint"] == alone.result["fingerprint"]
    assert sum(map(Counter.total, counts.values())) >= 100_000
    for name, reasons in counts.items():
        assert reasons.total() >= 5_000, name
        expected = {"malformed", "foreign", "stale", "early", "duplicate", "mistimed"}
        if name in AS_ARRAYS:  # a message is for all of its vehicles, and a mutant for one
            expected -= {"duplicate", "mistimed"}
        assert reasons.keys() >= expected, name


@pytest.mark.parametrize("vehicles", [ALONE, TOGETHER], ids=["alone", "together"])
def test_a_run_in_real_time_logs_no_mutant(tmp_path: Path, vehicles: tuple[str, ...]) -> None:
    scenario = f"duration_s: 5\nclock: realtime\n{FLEET}"
    log, counts = under_attack(tmp_path / "attacked", scenario, vehicles)
    assert log.result["cycles"] == "50"
    assert all(reasons.total() >= 500 for reasons in counts.values())
    for name, reasons in counts.items():
        assert reasons.keys() >= {"malformed", "foreign", "stale", "mistimed"}, name
    commands = [pb.FleetCommand.FromString(message.data) for message in log.of("/fleet/command")]
    decided = [a for row in commands for a in row.acceleration if not math.isnan(a)]
    assert len(decided) > len(commands)  # of three each; the rest had no time left
    assert MARK not in decided
    assert max(map(abs, decided)) <= 3.0
    alone = run(tmp_path / "alone", f"{scenario}\nspeed: 1", "--set", "clock=lock-step")
    assert fates(log) <= fates(alone)
    heard = [
        row
        for message in log.of("/realtime")
        for row_of_cycle in [pb.RealTime.FromString(message.data)]
        for row in zip(
            row_of_cycle.source, row_of_cycle.destination, row_of_cycle.arrived_ns, strict=True
        )
    ]
    assert len(set(heard)) == len(heard)


def fates(log: Log) -> set[tuple[int, ...]]:
    """Return the outcome of each frame, without lateness; each frame has one."""
    tables = [pb.Frames.FromString(message.data) for message in log.of("/v2v/frames")]
    rows = [
        row
        for table in tables
        for row in zip(
            table.source, table.destination, table.sequence, table.latency_ns, strict=True
        )
    ]
    assert len(set(rows)) == len(rows)
    return set(rows)


def test_the_attack_begins_when_messages_can_be_stale() -> None:
    assert FIRST_CYCLE > WINDOW
