"""The estimates behind the commands of a cycle, as in a log."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.laws import Relative
from zenvoy.vehicles.arrays.decisions import Decisions
from zenvoy.vehicles.arrays.shared_links import Logged
from zenvoy.vehicles.arrays.vehicles import Vehicles

Array = NDArray[Any]


class Estimates:
    """The columns of /fleet/estimate for all vehicles of a batch, (runs · n,), by name.

    A column is computed when it is first used, which must be in its own cycle. It is NaN for a
    vehicle that does not estimate it.
    """

    def __init__(self, vehicles: Vehicles, decisions: Decisions) -> None:
        self.vehicles, self.decisions = vehicles, decisions
        self._found: dict[str, Array] = {}
        self._logged: dict[str, Logged] = {}
        self._stds: dict[str, Array] = {}

    def __getitem__(self, name: str) -> Array:
        found = self._found.get(name)
        if found is None:
            found = self._found[name] = _COLUMNS[name](self)
        return found

    @property
    def speed(self) -> Array:
        """Estimates of the own speeds at the start of the cycle, m/s."""
        known = self.vehicles.estimation
        return self._of_estimating(None if known is None else known.speed.v)

    @property
    def speed_std(self) -> Array:
        """Standard deviation of `speed`, m/s."""
        known = self.vehicles.estimation
        return self._of_estimating(None if known is None else known.speed.covariances.std()[0])

    @property
    def predicted_speed(self) -> Array:
        """Predicted own speeds at the time at which the commands take effect, m/s."""
        known = self.vehicles.estimation
        predicted = None if known is None else known.predicted
        return self._of_estimating(None if predicted is None else predicted.speed)

    @property
    def age_ns(self) -> Array:
        """The age of the newest beacon of the vehicle behind, ns; -1 if there is none yet."""
        heard = self.vehicles.links.behind[0].cycle
        since = self.vehicles.cycle - heard
        return np.where(heard < 0, -1, since * self.vehicles.timing.period_ns)

    def of_link(self, side: str, column: Callable[[Estimates, str], Array]) -> Array:
        """Return a column of a link; it is NaN where the link has not been measured yet."""
        if self.vehicles.estimation is None:
            return self._filled(np.nan)
        return np.where(self._measured(side), column(self, side), np.nan)

    def measured_ns(self, side: str) -> Array:
        """Return the time of the newest reading of a link, ns; -1 if there is none yet."""
        if self.vehicles.estimation is None:
            return self._filled(-1)
        measured = self.logged(side).measured
        return np.where(self._measured(side), measured * self.vehicles.timing.period_ns, -1)

    def logged(self, side: str) -> Logged:
        """Return the estimates of the links to the vehicles `ahead` or `behind`."""
        found = self._logged.get(side)
        if found is None:
            assert self.vehicles.estimation is not None
            found = self._logged[side] = self.vehicles.estimation.logged(side, self.vehicles.cycle)
        return found

    def predicted(self, side: str) -> Relative:
        """Return the predictions of the links to the vehicles `ahead` or `behind`."""
        known = self.vehicles.estimation
        assert known is not None
        assert known.predicted is not None
        return known.predicted.ahead.state if side == "ahead" else known.predicted.behind.state

    def std(self, side: str) -> Array:
        """Return the standard deviations of a link, (2, runs · n), computed once per cycle."""
        found = self._stds.get(side)
        if found is None:
            found = self._stds[side] = self.logged(side).std()
        return found

    def _measured(self, side: str) -> Array:
        known = self.vehicles.estimation
        assert known is not None
        return known.roles.estimate & (self.logged(side).measured >= 0)

    def _of_estimating(self, values: Array | None) -> Array:
        known = self.vehicles.estimation
        if known is None or values is None:
            return self._filled(np.nan)
        return np.where(known.roles.estimate, values, np.nan)

    def _filled(self, value: float) -> Array:
        return np.full(len(self.decisions.mode), value)


_OF_LINK: Final[dict[str, Callable[[Estimates, str], Array]]] = {
    "gap": lambda of, side: of.logged(side).state.p,
    "speed": lambda of, side: of.logged(side).state.v,
    "gap_std": lambda of, side: of.std(side)[0],
    "speed_std": lambda of, side: of.std(side)[1],
    "predicted_gap": lambda of, side: of.predicted(side).p,
    "predicted_speed": lambda of, side: of.predicted(side).v,
}


def _on(side: str, column: Callable[[Estimates, str], Array]) -> Callable[[Estimates], Array]:
    return lambda of: of.of_link(side, column)


def _measured_on(side: str) -> Callable[[Estimates], Array]:
    return lambda of: of.measured_ns(side)


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
    **{f"{side}_measured_ns": _measured_on(side) for side in ("ahead", "behind")},
}

NEIGHBOURS: Final = "neighbours"
"""The column that only fleets with MBCM have."""

ESTIMATES: Final = tuple(name for name in _COLUMNS if name != NEIGHBOURS)
"""The columns that every fleet has, as in `pb.FleetEstimate`."""

OF_WHOLE: Final = frozenset({"age_ns", *(name for name in ESTIMATES if "predicted" in name)})
"""The columns that only a `whole` batch has for every vehicle: not every decision needs them."""
