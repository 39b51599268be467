"""What a log tells of the estimates behind the commands of a cycle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from zenvoy.vehicles.arrays.decisions import Decisions, Known
from zenvoy.vehicles.arrays.filters import LinkFilters
from zenvoy.vehicles.arrays.vehicles import Vehicles

Array = NDArray[np.float64] | NDArray[np.int64]
Columns = dict[str, Array]


def estimates(vehicles: Vehicles, decisions: Decisions) -> Columns:
    """Return the columns of /fleet/estimate for all vehicles of a batch, as `FleetEstimate`.

    What a vehicle does not estimate is NaN.
    """
    period_ns, cycle = vehicles.timing.period_ns, vehicles.cycle
    heard = vehicles.links.behind[0].cycle
    columns: Columns = {
        "mode": decisions.mode,
        "age_ns": np.where(heard < 0, -1, (cycle - heard) * period_ns),
    }
    known, predicted = vehicles.estimators, vehicles.predicted
    if known is None or predicted is None:
        return columns | _nothing(len(heard))
    does = vehicles.estimates
    assert known.speed.v is not None
    columns["speed"] = _of(does, known.speed.v)
    columns["speed_std"] = _of(does, known.speed.covariances.std()[0])
    columns["predicted_speed"] = _of(does, predicted.speed)
    columns |= _link("ahead", known.link_ahead, predicted.ahead, does, period_ns)
    columns |= _link("behind", known.link_behind, predicted.behind, does, period_ns)
    return columns


def _link(
    side: str, link: LinkFilters, predicted: Known, does: NDArray[np.bool_], period_ns: int
) -> Columns:
    measured = does & (link.measured >= 0)
    gap_std, speed_std = link.covariances.std()
    return {
        f"{side}_gap": _of(measured, link.p),
        f"{side}_speed": _of(measured, link.v),
        f"{side}_gap_std": _of(measured, gap_std),
        f"{side}_speed_std": _of(measured, speed_std),
        f"{side}_predicted_gap": _of(measured, predicted.state.p),
        f"{side}_predicted_speed": _of(measured, predicted.state.v),
        f"{side}_measured_ns": np.where(measured, link.measured * period_ns, -1),
    }


def _nothing(count: int) -> Columns:
    nan, never = np.full(count, np.nan), np.full(count, -1, dtype=np.int64)
    names = ("gap", "speed", "gap_std", "speed_std", "predicted_gap", "predicted_speed")
    columns: Columns = dict.fromkeys(("speed", "speed_std", "predicted_speed"), nan)
    for side in ("ahead", "behind"):
        columns |= {f"{side}_{name}": nan for name in names} | {f"{side}_measured_ns": never}
    return columns


def _of(mask: NDArray[np.bool_], values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(mask, values, np.nan)
