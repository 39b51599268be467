"""The muster of a run knows who is missing, and on which machine each process runs."""

from __future__ import annotations

from zenvoy.bus.vehicle_processes import vehicle_processes
from zenvoy.fleet.muster import Muster
from zenvoy.fleet.progress import Arrival


def test_who_comes_is_no_longer_missing() -> None:
    muster = Muster(vehicle_processes(6, 2))
    assert muster.missing == [1, 2, 3, 4, 5, 6]
    assert muster.note(Arrival("vehicles-03-04", "", True))
    assert not muster.note(Arrival("vehicles-03-04", "beta", True))
    assert not muster.note(Arrival("channel", "", True))
    assert muster.missing == [1, 2, 5, 6]
    assert muster.host_of("vehicles-03-04 and 2 more") == "beta"
    assert muster.host_of("vehicles-01-02") == ""
    assert muster.note(Arrival("vehicles-03-04", "", False))
    assert muster.missing == [1, 2, 3, 4, 5, 6]
