"""A run from its disturbance on: deviations by vehicle, and what linear theory makes of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.load import Run
from zenvoy.analysis.run_theory import NoTheoryError, Theory, theory_of
from zenvoy.analysis.spans import Disturbance, disturbances
from zenvoy.analysis.stability import Arrivals, Norms, arrivals, norms
from zenvoy.analysis.theory_chain import follow
from zenvoy.bus import messages_pb2 as pb

Floats = NDArray[np.float64]

_FEWEST: Final = 20  # rows
_BEFORE_S: Final = 5.0  # the speed before the disturbance is the mean over this
_STANDS_MPS: Final = 0.1
_NOISY: Final = 0.02  # of the disturbance
_SHARE: Final = 0.05  # of the disturbed vehicle's dip: less is not followed
_NOISES: Final = 5.0  # standard deviations: noise alone will hardly reach it in a minute
_DIP_NOISES: Final = 3.0  # nor these within the seconds in which a dip is looked for
_GONE: Final = 0.01  # of the energy
_NEARLY: Final = 0.999  # of the limit
_MANY: Final = 0.05  # of all vehicles
_AFTER_S: Final = 5.0  # a hard braking may drive its neighbours to their limits, too
_MOST: Final = 150  # vehicles: a matrix of them is solved for each frequency


@dataclass(frozen=True, kw_only=True, eq=False)
class Disturbed:
    """From the disturbance to the end of what is linear.

    time_s (T,); deviation (T, n) of the speeds from that before, m/s; predicted (T, n): what
    theory says the others do when the disturbed one moves as it did, None where it says nothing.
    behind, ahead: indices of the vehicles that it reaches backwards and forwards, the disturbed
    one first. Forwards it goes where some look behind; on the ring the two then meet half-way
    round. noise: standard deviation of speeds, m/s, where nothing is going on.
    """

    disturbance: Disturbance
    time_s: Floats
    deviation: Floats
    predicted: Floats | None
    felt: int
    behind: NDArray[np.int64]
    ahead: NDArray[np.int64]
    noise: float
    rows: slice
    theory: Theory | None
    notes: tuple[str, ...]

    @property
    def period_s(self) -> float:
        """Of the rows."""
        return float(self.time_s[1] - self.time_s[0])

    @property
    def source(self) -> int:
        """Index of the disturbed vehicle."""
        return self.disturbance.vehicle - 1

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Vehicles (n,) whose deviation stands out of the noise."""
        largest = np.abs(self.deviation[: self.felt]).max(axis=0)
        return np.asarray(largest > max(_NOISES * self.noise, 1e-6))

    def gains(self, deviation: Floats) -> Norms:
        """Norms of all vehicles, each (n,), over those measured at the disturbed one."""
        measured = norms(self.deviation[: self.felt], self.period_s)
        found = norms(deviation[: self.felt], self.period_s)
        source = self.source
        return Norms(found.l2 / measured.l2[source], found.linf / measured.linf[source])

    def dips(self, deviation: Floats, order: NDArray[np.int64]) -> Arrivals:
        """Where the dip of a braking was when, along `behind` or `ahead`."""
        depth = max(0.0, -float(deviation[:, order[0]].min()))
        brakes_s = min(self.disturbance.end_s, self.time_s[-1]) - self.disturbance.start_s
        least = max(_SHARE * depth, _DIP_NOISES * self.noise, 1e-9)
        return arrivals(self.time_s, deviation, order, least, 5.0 + 3.0 * brakes_s)


def disturbed(run: Run) -> Disturbed | str:
    """The first disturbance of a run and what came of it; in words why there is none."""
    first = next(iter(disturbances(run.events)), None)
    if first is None:
        return "No vehicle was disturbed: of gains, waves and modes there is nothing to measure."
    source = first.vehicle - 1
    low, high, notes = _window(run, first)
    if high - low < _FEWEST:
        few = "Too little is left after the disturbance to tell what became of it."
        return " ".join([*notes, few])
    speed = run.truth["speed"]
    before = (run.time_s > first.start_s - _BEFORE_S) & (run.time_s <= first.start_s)
    before[max(0, low - 1)] = True  # of long periods none may lie within
    deviation = speed[low:high] - speed[before].mean()
    scatter = float(speed[before].std())
    noise = min(scatter, float(speed[low:high][-(high - low) // 10 :].std()))
    if scatter > _NOISY * np.abs(deviation[:, source]).max():
        notes.append(
            f"Before the disturbance the speeds already scatter by {scatter:.2g} m/s: noise that "
            "is in what was measured, and not in the theory."
        )
    theory, told = _theory(run, run.time_s[low], run.time_s[high - 1])
    behind, ahead = _orders(run, source, theory)
    predicted = None
    if theory is not None and run.vehicles <= _MOST:
        period_s = float(run.time_s[low + 1] - run.time_s[low])
        ring = run.scenario.road.type == "ring"
        predicted = follow(deviation[:, source], period_s, theory.members, source, ring=ring)
    elif theory is not None:
        told.append(f"More than {_MOST} vehicles: no theory of each of them.")
    return Disturbed(
        disturbance=first,
        time_s=run.time_s[low:high],
        deviation=deviation,
        predicted=predicted,
        felt=high - low if predicted is None else _felt(predicted),
        behind=behind,
        ahead=ahead,
        noise=noise,
        rows=slice(low, high),
        theory=theory,
        notes=(*notes, *told),
    )


def _felt(predicted: Floats) -> int:
    """Rows until all but a little of the energy beyond that of the end has come."""
    power = (predicted * predicted).sum(axis=1)
    rest = power[-max(1, len(power) // 10) :].mean()
    if rest >= power.mean():  # it does not die out
        return len(power)
    energy = np.cumsum(power - rest)
    return int(np.argmax(energy >= (1.0 - _GONE) * energy.max())) + 1


def _orders(
    run: Run, source: int, theory: Theory | None
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    n, ring = run.vehicles, run.scenario.road.type == "ring"
    both = theory is not None and any(m.coupling and m.coupling.behind for m in theory.members)
    back, forth = (n // 2, (n - 1) // 2) if ring else (n - 1 - source, source)
    if not both:
        back, forth = (n - 1 if ring else back), 0
    return (source + np.arange(back + 1)) % n, (source - np.arange(forth + 1)) % n


def _window(run: Run, first: Disturbance) -> tuple[int, int, list[str]]:
    """Rows from the disturbance to the first thing that is not linear, or not of it."""
    time_s = run.time_s
    ends = [(float(time_s[-1]) + 1.0, "")]
    for event in run.events:
        at_s = event.time_ns * 1e-9
        if event.kind == pb.EVENT_COLLISION and at_s > first.start_s:
            ends.append((at_s, f"a collision of vehicle {event.vehicle}"))
        if event.kind == pb.EVENT_MODEL and at_s > first.start_s:
            ends.append((at_s, f"the switch to {event.text}"))
    for other in disturbances(run.events):
        if other.vehicle != first.vehicle:
            ends.append((other.start_s, f"the disturbance of vehicle {other.vehicle}"))
    at_limit_s = _at_limit(run, first)
    if at_limit_s is not None:
        ends.append((at_limit_s, "many vehicles at their acceleration limits"))
    stands = run.truth["speed"].min(axis=1) < _STANDS_MPS
    standing = np.flatnonzero(stands & (time_s > first.start_s))
    if standing.size:
        ends.append((float(time_s[standing[0]]), "a standstill"))
    end_s, why = min(ends)
    low = int(np.searchsorted(time_s, first.start_s - 1e-9))
    high = int(np.searchsorted(time_s, end_s - 1e-9))
    notes = [f"What came after {end_s:g} s is left out: {why}."] if why else []
    return low, high, notes


def _at_limit(run: Run, first: Disturbance) -> float | None:
    """When, after the disturbance, so many are at their limits for a second that it tells, s."""
    limit = run.scenario.control.acceleration_limit_mps2 * _NEARLY
    at_limit = (np.abs(run.truth["acceleration"]) >= limit).sum(axis=1)
    rows = max(1, round(1.0 / (run.scenario.period_ns * 1e-9)))
    mean = np.convolve(at_limit, np.ones(rows) / rows)[: len(at_limit)]
    many = (mean > max(1.5, _MANY * run.vehicles)) & (run.time_s > first.end_s + _AFTER_S)
    return float(run.time_s[np.argmax(many)]) if many.any() else None


def _theory(run: Run, low_s: float, high_s: float) -> tuple[Theory | None, list[str]]:
    try:
        theory = theory_of(run, low_s, high_s)
    except NoTheoryError as error:
        return None, [f"No linear theory beside what was measured: {error}"]
    return theory, list(theory.caveats)
