"""Ages of information agree with their definition, and with those that vehicles log."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings

from tests.analysis.v2v.frames import LTE, PERIOD_NS, WAIT_NS, tables
from tests.logs import write_log
from zenvoy.analysis import load
from zenvoy.analysis.chapters.v2v_sheets import link_groups
from zenvoy.analysis.log.columns import Table
from zenvoy.analysis.measures.ages import ages


def naive_age(frames: Table, source: int, destination: int, cycle: int) -> int:
    """Return the age by definition: t_k less the time of the newest frame by then, or -1."""
    known = [
        cycle - int(sent // PERIOD_NS)
        for of, to, sent, arrived in zip(
            *(frames[name] for name in ("source", "destination", "sent_ns", "arrived_ns")),
            strict=True,
        )
        if (of, to) == (source, destination) and 0 <= arrived <= cycle * PERIOD_NS + WAIT_NS
    ]
    return min(known, default=-1)


@settings(deadline=None)
@given(tables())
def test_ages_agree_with_their_definition(frames: Table) -> None:
    found = ages(frames, 3, PERIOD_NS, WAIT_NS)
    arrives = frames["arrived_ns"] >= 0
    links = sorted(set(zip(frames["source"][arrives], frames["destination"][arrives], strict=True)))
    assert list(zip(found.source, found.destination, strict=True)) == links
    assert len(found.cycles) == frames["cycle"][-1] + 1
    for column, (source, destination) in enumerate(links):
        for cycle, age in enumerate(found.cycles[:, column].tolist()):
            assert age == naive_age(frames, source, destination, cycle), (
                source,
                destination,
                cycle,
            )
    everyone = np.ones(len(links), dtype=np.bool_)
    known = found.cycles[found.cycles >= 0]
    assert found.of(everyone).sum() == known.size
    assert (found.of(everyone) * np.arange(len(found.of(everyone)))).sum() == known.sum()
    assert found.before_first(everyone) == found.cycles.size - known.size
    for column, mean in enumerate(found.mean()):
        of_link = found.cycles[found.cycles[:, column] >= 0, column]
        assert np.isnan(mean) if not of_link.size else mean == pytest.approx(of_link.mean())


@pytest.mark.parametrize("wait_ms", [0, 30, 99])
def test_ages_equal_those_that_vehicles_log(folder: Path, wait_ms: int) -> None:
    """Every vehicle logs the age of its data from the vehicle behind, as age_ns."""
    text = LTE.replace("v2v_wait_ms: 30", f"v2v_wait_ms: {wait_ms}")
    run = load(write_log(folder / f"wait{wait_ms}.mcap", text.replace("_s: 40", "_s: 10")))
    period_ns, wait_ns = run.scenario.period_ns, run.scenario.v2v_wait_ns
    found = ages(run.frames, 8, period_ns, wait_ns)
    behind = link_groups(found, run)["vehicle behind"]
    assert behind.sum() == 8
    order = np.argsort(found.destination[behind])
    age = found.cycles[:, behind][:, order].astype(np.int64)
    reported = run.estimate["age_ns"]
    np.testing.assert_array_equal(np.where(age < 0, -1, age * period_ns), reported)
    assert len(np.unique(reported)) > 3


def test_links_end_with_the_open_road(folder: Path) -> None:
    text = LTE + "road: {type: open}\n"
    run = load(write_log(folder / "open.mcap", text.replace("_s: 40", "_s: 5")))
    found = ages(run.frames, 8, run.scenario.period_ns, run.scenario.v2v_wait_ns)
    groups = link_groups(found, run)
    assert {name: int(links.sum()) for name, links in groups.items()} == {
        "vehicle ahead": 7,
        "vehicle behind": 7,
        "all in range": 56,
    }
    ahead = groups["vehicle ahead"]
    np.testing.assert_array_equal(found.source[ahead] + 1, found.destination[ahead])
