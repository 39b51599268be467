"""The page's data are those of the log, of any cycle."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from numpy.typing import NDArray

from tests.analysis.view.watching import CYCLES, SCENARIO, unpack, watched
from tests.logs import chunk_every, write_log
from zenvoy.analysis.log.load import Run, load
from zenvoy.analysis.view.overview import POINTS, Overview
from zenvoy.analysis.view.picture import COLUMNS, TOTALS
from zenvoy.links.distance import gaps


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


@pytest.mark.parametrize(("cycles", "vehicles"), [(1, 2), (5_000, 40), (36_000_000, 10_000)])
def test_an_overview_has_a_limit(cycles: int, vehicles: int) -> None:
    overview = Overview(cycles, vehicles)
    assert (cycles // overview.stride) + 1 <= POINTS + 1
    assert len(overview.vehicles) <= POINTS
    assert overview.vehicles[0] == 0
