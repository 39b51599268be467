"""Outages are set by time, link and stretch of road."""

from __future__ import annotations

from typing import Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from zenvoy.channel.outages import Outages
from zenvoy.scenarios import Channel, Fleet, Group, Outage, Road, Scenario, ScenarioError, load

S_NS: Final = 1_000_000_000
SIZE: Final = 6
SOURCE, DESTINATION = (
    index[~np.eye(SIZE, dtype=bool)] for index in np.indices((SIZE, SIZE), dtype=np.int64)
)
POSITION: Final = np.arange(SIZE - 1, -1, -1.0) * 40  # on a ring of 240 m, vehicle 1 ahead


def lost(*outages: Outage, at_s: float = 0.0, road: Road | None = None) -> set[tuple[int, int]]:
    """Return the links, as (sender, receiver), that an outage takes at that time."""
    scenario = Scenario(
        fleet=Fleet(size=SIZE, gap_m=40.0, groups=(Group(name="tail", vehicles="5-6"),)),
        road=road or Road(),
        channel=Channel(outages=outages),
    )
    mask = Outages(scenario).lost(SOURCE, DESTINATION, POSITION, round(at_s * S_NS))
    return set() if mask is None else links(mask)


def links(mask: NDArray[np.bool_]) -> set[tuple[int, int]]:
    return set(zip((SOURCE[mask] + 1).tolist(), (DESTINATION[mask] + 1).tolist(), strict=True))


ALL: Final = links(np.ones(len(SOURCE), dtype=np.bool_))


def test_an_outage_includes_its_begin_and_excludes_its_end() -> None:
    outage = Outage(from_s=2.0, until_s=3.0)
    assert [bool(lost(outage, at_s=at_s)) for at_s in (1.9, 2.0, 2.9, 3.0)] == [
        False,
        True,
        True,
        False,
    ]
    assert lost(outage, at_s=2.0) == ALL


def test_an_outage_without_end_lasts() -> None:
    assert lost(Outage(from_s=2.0), at_s=1e6) == ALL


def test_an_outage_of_a_link_is_one_way() -> None:
    assert lost(Outage(source="3", destination="2")) == {(3, 2)}
    assert lost(Outage(source="tail", destination="not tail")) == {
        (s, d) for s in (5, 6) for d in (1, 2, 3, 4)
    }


def test_an_outage_of_a_stretch_takes_senders_and_receivers_in_it() -> None:
    inside = {3, 4}  # at 120 and 80 m
    assert lost(Outage(from_m=80.0, to_m=120.0)) == {
        (s, d) for s, d in ALL if s in inside or d in inside
    }
    assert lost(Outage(from_m=190.0)) == {(s, d) for s, d in ALL if 1 in {s, d}}  # at 200 m
    assert lost(Outage(to_m=0.0)) == {(s, d) for s, d in ALL if 6 in {s, d}}


def test_a_stretch_over_the_seam_of_the_ring() -> None:
    inside = {1, 6}  # at 200 and 0 m
    assert lost(Outage(from_m=190.0, to_m=10.0)) == {
        (s, d) for s, d in ALL if s in inside or d in inside
    }


def test_positions_are_wrapped_on_the_ring_and_not_on_the_open_road() -> None:
    once_around = Outage(from_m=240.0 + 80.0, to_m=240.0 + 120.0)
    assert lost(once_around) == set()
    assert lost(once_around, road=Road(type="open")) == set()
    scenario = Scenario(
        fleet=Fleet(size=SIZE, gap_m=40.0),
        channel=Channel(outages=(Outage(from_m=80.0, to_m=120.0),)),
    )
    mask = Outages(scenario).lost(SOURCE, DESTINATION, POSITION + 7 * 240.0, 0)
    assert mask is not None
    assert links(mask) == lost(Outage(from_m=80.0, to_m=120.0))


@given(
    st.lists(
        st.builds(
            Outage,
            source=st.sampled_from([None, "1-3", "tail"]),
            destination=st.sampled_from([None, "2", "not 4"]),
            from_m=st.none() | st.floats(0, 240),
            to_m=st.none() | st.floats(0, 240),
        ),
        max_size=4,
    )
)
def test_outages_add_up(outages: list[Outage]) -> None:
    assert lost(*outages) == set().union(*(lost(outage) for outage in outages))


def test_a_scenario_without_outages_computes_none() -> None:
    assert Outages(Scenario()).lost(SOURCE, DESTINATION, POSITION, 0) is None


@pytest.mark.parametrize(
    ("outage", "message"),
    [
        (
            "{source: 99}",
            "channel.outages.0.source: 99 is not within 1-",
        ),
        (
            "{destination: trucks}",
            "channel.outages.0.destination: 'trucks' is not a vehicle, a range or one of all",
        ),
        (
            "{from_s: 5, until_s: 5}",
            "channel.outages.0.until_s: 5 is not later than channel.outages.0.from_s (5)",
        ),
    ],
)
def test_impossible_outages_are_refused(outage: str, message: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        load("quickstart", [f"channel.outages=[{outage}]"])
    assert message in str(refused.value)


def test_a_stretch_that_ends_before_it_begins_is_refused_on_the_open_road() -> None:
    with pytest.raises(ScenarioError) as refused:
        load("quickstart", ["road.type=open", "channel.outages=[{from_m: 9, to_m: 8}]"])
    assert "channel.outages.0.to_m: 8 is less than channel.outages.0.from_m (9)" in str(
        refused.value
    )
