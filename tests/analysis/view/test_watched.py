"""The page's data are those of the log, of any cycle, also while the log grows."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from numpy.typing import NDArray

from tests.logs import chunk_every, write_log
from zenvoy.analysis.log.load import Run, load
from zenvoy.analysis.log.records import LogError
from zenvoy.analysis.view.growing_log import GrowingLog
from zenvoy.analysis.view.overview import POINTS, Overview
from zenvoy.analysis.view.picture import COLUMNS, TOTALS
from zenvoy.analysis.view.watched import WatchedRun
from zenvoy.links.distance import gaps

CYCLES: Final = 60
SCENARIO: Final = """
duration_s: 6
fleet: {size: 5}
control: {v2v_wait_ms: 50, system_delay_ms: 70}
channel: {technology: lte-a-pro, loss: {p: 0.2}}
events: [{type: brake, vehicle: 2, at_s: 1, duration_s: 1, deceleration_mps2: 2}]
"""


def unpack(block: bytes) -> dict[str, NDArray[Any]]:
    """Return the arrays of a block, as the page reads them."""
    length = int.from_bytes(block[:4], "little")
    found, at = {}, 4 + length
    for name, dtype, shape in json.loads(block[4:at])["arrays"]:
        assert at % 8 == 0
        count = int(np.prod(shape))
        found[name] = np.frombuffer(block, dtype, count, at).reshape(shape)
        at += -(-count * np.dtype(dtype).itemsize // 8) * 8
    assert at == len(block)
    return found


def watched(path: Path) -> WatchedRun:
    """Return a run of which everything that the log has is read."""
    made = WatchedRun(path)
    while made.extend():
        pass
    return made


@pytest.fixture(scope="module")
def log(folder: Path) -> Path:
    """Return the log of a run, with many small chunks."""
    return write_log(folder / "run.mcap", SCENARIO, clock=chunk_every(7))


@pytest.fixture(scope="module")
def run(log: Path) -> Run:
    """Return the run as other readers load it."""
    return load(log)


def column(block: dict[str, NDArray[Any]], name: str) -> NDArray[Any]:
    return block["columns"][:, list(COLUMNS).index(name)]


def total(block: dict[str, NDArray[Any]], name: str) -> NDArray[Any]:
    return block["totals"][:, list(TOTALS).index(name)]


@pytest.mark.parametrize(("first", "last"), [(0, CYCLES), (13, 13), (20, 41), (55, 1000)])
def test_cycles_are_those_of_the_log(log: Path, run: Run, first: int, last: int) -> None:
    block = unpack(watched(log).cycles(first, last, 1, ()))
    rows = slice(first, min(last, CYCLES) + 1)
    assert_array_equal(block["cycle"], np.arange(CYCLES + 1)[rows])
    truth = run.truth["position"][rows]
    assert_array_equal(block["position"], truth)
    assert_array_equal(column(block, "speed"), run.truth["speed"][rows].astype(np.float32))
    assert_array_equal(
        column(block, "gap"), gaps(truth, run.scenario.ring_length_m).astype(np.float32)
    )
    decided = slice(first, min(last, CYCLES - 1) + 1)  # no decision follows the last cycle
    count = decided.stop - decided.start
    for name, values in {
        "read_gap": run.radar["gap"],
        "estimated_gap": run.estimate["ahead_gap"],
        "estimated_speed": run.estimate["speed"],
        "command": run.command["acceleration"],
        "mode": run.estimate["mode"],
    }.items():
        assert_array_equal(column(block, name)[:count], values[decided].astype(np.float32))


def test_some_vehicles_and_one_cycle_in_some(log: Path) -> None:
    made = watched(log)
    whole = unpack(made.cycles(0, CYCLES, 1, ()))
    part = unpack(made.cycles(5, 50, 10, (4, 2, 9)))  # there is no vehicle 9
    assert_array_equal(part["cycle"], [10, 20, 30, 40, 50])
    assert_array_equal(part["vehicle"], [4, 2])
    assert_array_equal(part["position"], whole["position"][10:51:10][:, [3, 1]])
    assert_array_equal(part["columns"], whole["columns"][10:51:10][:, :, [3, 1]])
    assert_array_equal(part["totals"], whole["totals"][10:51:10])


def test_frames_are_those_of_the_log(log: Path, run: Run) -> None:
    made = watched(log)
    frames = run.frames
    rows = unpack(made.links(10, 12, (2,)))
    cycles = np.round(frames["sent_ns"] / run.scenario.period_ns)
    mask = (cycles >= 10) & (cycles <= 12)
    mask &= (frames["source"] == 2) | (frames["destination"] == 2)
    for name in ("source", "destination", "outcome"):
        assert_array_equal(rows[name], frames[name][mask])
    arrived = frames["arrived_ns"][mask]
    assert_array_equal(rows["arrived"], np.where(arrived < 0, -1.0, arrived * 1e-9))
    assert len(rows["cycle"]) == 3 * 8
    near = unpack(made.links(10, 10, ()))  # between neighbours, also across the ring's seam
    assert set(zip(near["source"], near["destination"], strict=True)) == {
        pair for a in range(1, 6) for pair in ((a, a % 5 + 1), (a % 5 + 1, a))
    }


def test_the_ends_of_an_open_road_are_no_neighbours(tmp_path: Path) -> None:
    log = write_log(tmp_path / "open.mcap", "duration_s: 1\nroad: {type: open}\nfleet: {size: 4}\n")
    near = unpack(watched(log).links(5, 5, ()))
    pairs = set(zip(near["source"].tolist(), near["destination"].tolist(), strict=True))
    assert pairs == {(1, 2), (2, 1), (2, 3), (3, 2), (3, 4), (4, 3)}


def test_totals_count_every_frame_once(log: Path, run: Run) -> None:
    block = unpack(watched(log).cycles(0, CYCLES - 1, 1, ()))
    counted = sum(total(block, name) for name in ("delivered", "late", "lost", "collided"))
    assert_array_equal(counted, np.full(CYCLES, 20))
    assert total(block, "lost").sum() == np.isin(run.frames["outcome"], (3, 5)).sum()
    heard, missed = column(block, "heard"), column(block, "missed")
    assert_array_equal((heard + missed).sum(axis=1), counted)


def test_events_facts_and_overview(log: Path, run: Run) -> None:
    made = watched(log)
    state = made.state(0)
    assert (state["last"], state["end"], state["whole"]) == (CYCLES, "complete", True)
    found = [(event["time"], event["vehicle"], event["text"]) for event in state["events"]]
    assert found == [(event.time_ns * 1e-9, event.vehicle, event.text) for event in run.events]
    assert {"BRAKE", "BRAKE_END"} <= {event["kind"] for event in state["events"]}
    assert made.state(1)["events"] == state["events"][1:]
    assert "vehicle 2 brakes, 2 m/s²" in [event["words"] for event in state["events"]]
    facts = made.about()
    json.dumps(facts)
    assert (facts["vehicles"], facts["ring"], facts["chosen"]) == (5, 5 * 37.5, [2])
    overview = unpack(made.overview(0))
    assert_array_equal(overview["cycle"], np.arange(CYCLES + 1))
    assert_array_equal(overview["speed"], run.truth["speed"].astype(np.float32))
    later = unpack(made.overview(58))
    assert_array_equal(later["cycle"], [58, 59, 60])


def test_the_last_modes_are_known_at_the_end_of_a_run(log: Path, run: Run) -> None:
    """The last cycle has a truth and no decisions."""
    made = watched(log)
    assert made.last == CYCLES
    for _ in range(2):
        picture = made.decided()
        assert picture is not None
        modes = picture.columns[list(COLUMNS).index("mode")]
        assert_array_equal(modes, run.estimate["mode"][-1])


def test_a_log_is_read_on_as_it_grows(log: Path, folder: Path) -> None:
    """At whatever byte the file ends for the moment, what is shown is right."""
    content, grown = log.read_bytes(), folder / "grown.mcap"
    final = watched(log)
    expected = unpack(final.cycles(0, CYCLES, 1, ()))
    made = WatchedRun(grown)
    shown = -1
    for size in [*range(0, len(content), 1_777), len(content)]:
        grown.write_bytes(content[:size])
        while made.extend():
            pass
        if not made.begun or made.last < 0:
            continue
        assert made.last >= shown
        shown = made.last
        now = unpack(made.cycles(0, CYCLES, 1, ()))
        assert_array_equal(now["cycle"], np.arange(shown + 1))
        assert_array_equal(now["columns"], expected["columns"][: shown + 1])
    assert made.whole
    assert made.state(0) == final.state(0)
    assert made.overview(0) == final.overview(0)


def test_a_cut_log_is_shown_as_far_as_it_goes(log: Path, folder: Path) -> None:
    cut = folder / "cut.mcap"
    cut.write_bytes(log.read_bytes()[: log.stat().st_size // 2])
    os.utime(cut, (2e9, 2e9))  # just now, however slow the machine is
    made = watched(cut)
    assert 10 < made.last < CYCLES
    state = made.state(0)
    assert (made.whole, state["end"], state["still"]) == (False, None, False)
    os.utime(cut, ns=(0, 0))  # nobody has written to it for long
    made.extend()
    assert made.state(0)["still"]
    cut.write_bytes(log.read_bytes())
    while made.extend():
        pass
    state = made.state(0)
    assert (made.whole, state["end"], state["still"]) == (True, "complete", False)


def test_a_log_that_is_not_there_yet_is_not_still(folder: Path) -> None:
    assert not GrowingLog(folder / "later.mcap").is_still()


def test_a_run_may_pause_for_its_stall_limit(log: Path, folder: Path) -> None:
    """A lock-step run waits so long for a vehicle that somebody debugs."""
    patient = write_log(folder / "patient.mcap", SCENARIO + "stall_limit_s: 1000")
    for path, is_still in ((log, True), (patient, False)):
        cut = folder / "pause.mcap"
        cut.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
        modified_s = cut.stat().st_mtime - 100
        os.utime(cut, (modified_s, modified_s))
        assert watched(cut).state(0)["still"] == is_still


def test_what_is_no_log_is_refused(folder: Path) -> None:
    other = folder / "other.mcap"
    other.write_bytes(b"neither MCAP nor anything else")
    with pytest.raises(LogError, match="not an MCAP file"):
        WatchedRun(other).extend()
    with pytest.raises(LogError, match="No such file"):
        WatchedRun(folder / "missing.mcap").extend()


def test_a_damaged_chunk_is_reported_and_the_rest_is_shown(log: Path, folder: Path) -> None:
    content = bytearray(log.read_bytes())
    made = watched(log)
    place = made._log.chunks[4]
    content[place.at + 80] ^= 0xFF
    damaged = folder / "damaged.mcap"
    damaged.write_bytes(content)
    read = watched(damaged)
    assert read.decided() is not None
    (fault,) = read.state(0)["faults"]
    assert f"{damaged}: damaged at byte" in fault
    points = unpack(read.overview(0))
    assert len(points["cycle"]) == CYCLES + 1
    assert 0 < np.isnan(points["totals"][:, 0]).sum() < 30


@pytest.mark.parametrize(("cycles", "vehicles"), [(1, 2), (5_000, 40), (36_000_000, 10_000)])
def test_an_overview_has_a_limit(cycles: int, vehicles: int) -> None:
    overview = Overview(cycles, vehicles)
    assert (cycles // overview.stride) + 1 <= POINTS + 1
    assert len(overview.vehicles) <= POINTS
    assert overview.vehicles[0] == 0
