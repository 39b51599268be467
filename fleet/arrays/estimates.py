"""The estimates behind the commands of a cycle, as in a log."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.vehicles.arrays.covariances import Covariances
from zenvoy.vehicles.arrays.decisions import Decisions
from zenvoy.vehicles.arrays.filters import LinkFilters
from zenvoy.vehicles.arrays.vehicles import Vehicles
from zenvoy.vehicles.arrays.view import Known

Array = NDArray[Any]


class Estimates:
    """The columns of /fleet/estimate for all vehicles of a batch, (runs · n,), by name.

    A column is computed when it is first used, which must be in its own cycle. It is NaN for a
    vehicle that does not estimate it.
    """

    def __init__(self, vehicles: Vehicles, decisions: Decisions) -> None:
        self.vehicles, self.decisions = vehicles, decisions
        self._found: dict[str, Array] = {}
        self._stds: dict[int, Array] = {}

    def __getitem__(self, name: str) -> Array:
        found = self._found.get(name)
        if found is None:
            found = self._found[name] = _COLUMNS[name](self)
        return found

    @property
    def speed(self) -> Array:
        """Estimates of the own speeds at the start of the cycle, m/s."""
        known = self.vehicles.estimators
        return self._of_estimating(None if known is None else known.speed.v)

    @property
    def speed_std(self) -> Array:
        """The standard deviation of `speed`, m/s."""
        known = self.vehicles.estimators
        return self._of_estimating(None if known is None else self.std(known.speed.covariances)[0])

    @property
    def predicted_speed(self) -> Array:
        """Predictions of the own speeds when the commands take effect, m/s."""
        predicted = self.vehicles.predicted
        return self._of_estimating(None if predicted is None else predicted.speed)

    @property
    def age_ns(self) -> Array:
        """The age of the newest beacon of the vehicle behind, ns; -1 if there is none yet."""
        heard = self.vehicles.links.behind[0].cycle
        since = self.vehicles.cycle - heard
        return np.where(heard < 0, -1, since * self.vehicles.timing.period_ns)

    def link(self, side: str) -> tuple[LinkFilters, Known] | None:
        """Return filters and predictions of the link to the vehicle `ahead` or `behind`."""
        known, predicted = self.vehicles.estimators, self.vehicles.predicted
        if known is None or predicted is None:
            return None
        if side == "ahead":
            return known.link_ahead, predicted.ahead
        return known.link_behind, predicted.behind

    def of_link(self, side: str, column: Callable[[LinkFilters, Known], Array]) -> Array:
        """Return a column of a link; it is NaN where the link has not been measured yet."""
        found = self.link(side)
        if found is None:
            return self._filled(np.nan)
        return np.where(self._measured(found[0]), column(*found), np.nan)

    def measured_ns(self, side: str) -> Array:
        """Return the time of the newest reading of a link, ns; -1 if there is none yet."""
        found = self.link(side)
        if found is None:
            return self._filled(-1)
        link, _ = found
        return np.where(self._measured(link), link.measured * self.vehicles.timing.period_ns, -1)

    def std(self, covariances: Covariances) -> Array:
        """Return the standard deviations of states; they are computed once per cycle."""
        found = self._stds.get(id(covariances))
        if found is None:
            found = self._stds[id(covariances)] = covariances.std()
        return found

    def _measured(self, link: LinkFilters) -> Array:
        return self.vehicles.estimates & (link.measured >= 0)

    def _of_estimating(self, values: Array | None) -> Array:
        does = self.vehicles.estimates
        return self._filled(np.nan) if values is None else np.where(does, values, np.nan)

    def _filled(self, value: float) -> Array:
        return np.full(len(self.vehicles.estimates), value)


_OF_LINK: Final[dict[str, Callable[[Estimates, str], Array]]] = {
    "gap": lambda of, side: of.of_link(side, lambda link, _: link.p),
    "speed": lambda of, side: of.of_link(side, lambda link, _: link.v),
    "gap_std": lambda of, side: of.of_link(side, lambda link, _: of.std(link.covariances)[0]),
    "speed_std": lambda of, side: of.of_link(side, lambda link, _: of.std(link.covariances)[1]),
    "predicted_gap": lambda of, side: of.of_link(side, lambda _, known: known.state.p),
    "predicted_speed": lambda of, side: of.of_link(side, lambda _, known: known.state.v),
    "measured_ns": lambda of, side: of.measured_ns(side),
}


def _on(side: str, column: Callable[[Estimates, str], Array]) -> Callable[[Estimates], Array]:
    return lambda of: column(of, side)


_COLUMNS: Final[dict[str, Callable[[Estimates], Array]]] = {
    "mode": lambda of: of.decisions.mode,
    "neighbours": lambda of: of.decisions.neighbours,
    "age_ns": lambda of: of.age_ns,
    "speed": lambda of: of.speed,
    "speed_std": lambda of: of.speed_std,
    "predicted_speed": lambda of: of.predicted_speed,
    **{
        f"{side}_{name}": _on(side, column)
        for side in ("ahead", "behind")
        for name, column in _OF_LINK.items()
    },
}

NEIGHBOURS: Final = "neighbours"
"""The column that only fleets with MBCM have."""

ESTIMATES: Final = tuple(name for name in _COLUMNS if name != NEIGHBOURS)
"""The columns that every fleet has, as in `pb.FleetEstimate`."""

OF_WHOLE: Final = frozenset({"age_ns", *(name for name in ESTIMATES if "predicted" in name)})
"""The columns that only a `whole` batch has for every vehicle: not every decision needs them."""
