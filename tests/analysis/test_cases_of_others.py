"""Cases from the public issue trackers of other tools pass in Zenvoy.

Traces in the forms of SUMO, Plexe, OpenACC and drive cycles are in tests/recordings.py, Plexe's
braking platoon is in test_plexe_braking.py, and netem's gemodel and state are in
test_burst_loss.py.
Federates that die, freeze or join late are in test_chaos.py and test_external_vehicle.py (HELICS
229, 441, 853, 2534, 2795: others hang, and no message names the process that they wait for).
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from tests.logs import write_log
from tests.streamed_log import read_log
from zenvoy.analysis import load
from zenvoy.bus import messages_pb2 as pb

PLATOON = """
duration_s: 20
road: {type: open}
fleet: {size: 4, gap_m: 15, speed_mps: 25}
control: {model: CACC, desired_gap_m: 15, desired_speed_mps: 25}
sensors: {error: 0}
"""


def test_plexe_25_cacc_falls_back_when_no_beacon_arrives(tmp_path: Path) -> None:
    """Users ask for ACC if no beacon arrives. Here a vehicle falls back to FM, and returns."""
    silence = "channel: {outages: [{from_s: 5, until_s: 13}]}\n"
    log = load(write_log(tmp_path / "run.mcap", PLATOON + silence))
    modes = [set(log.estimate["mode"][cycle, 1:]) for cycle in (40, 100, 180)]
    assert modes[0] == modes[2] == {pb.MODE_CACC}
    assert pb.MODE_CACC not in modes[1]
    assert not any(event.kind == pb.EVENT_COLLISION for event in log.events)


def test_artery_333_dynamic_beacons_are_fewer_than_fixed_ones(tmp_path: Path) -> None:
    """Both kinds give equally many CAMs there. At 25 m/s a CAM is due every 4 m, so every 0.2 s."""
    fixed = load(write_log(tmp_path / "fixed.mcap", PLATOON))
    cams = load(write_log(tmp_path / "cams.mcap", PLATOON + "beacons: {rule: etsi-cam}\n"))
    sent = [len(np.unique(run.frames["sequence"])) for run in (fixed, cams)]
    assert sent == [200, 100]


def test_plotjuggler_1037_both_times_of_a_message_are_the_same(tmp_path: Path) -> None:
    """PlotJuggler reads one of the times, and takes it for time since 1970."""
    log = read_log(write_log(tmp_path / "run.mcap", PLATOON.replace("20", "1")))
    assert {one.log_time - one.publish_time for one in log.messages} == {0}
    assert min(one.log_time for one in log.messages) == 946_684_800 * 10**9


@pytest.mark.parametrize("length", [1 << 40, (1 << 63) - 1])
def test_mcap_1220_a_length_beyond_the_file_takes_no_memory(tmp_path: Path, length: int) -> None:
    """There a file whose end looks like a record of many gigabytes causes a MemoryError."""
    path = write_log(tmp_path / "run.mcap", PLATOON.replace("20", "1"))
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2] + b"\x06" + struct.pack("<Q", length) + b"\0" * 9)
    assert any("the log is cut" in note for note in load(path).notes)


def test_mcap_697_a_cut_log_reports_how_far_it_is_read(tmp_path: Path) -> None:
    """There users see only an unexpected end of file."""
    path = write_log(tmp_path / "run.mcap", PLATOON)
    path.write_bytes(path.read_bytes()[:-2_000])
    assert any(note.startswith("the log is cut: read up to ") for note in load(path).notes)
