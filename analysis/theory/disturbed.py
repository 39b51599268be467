"""A run from its disturbance on: deviations by vehicle, and what linear theory makes of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.spans import Disturbance, first_disturbance
from zenvoy.analysis.measures.stability import Arrivals, Norms, arrivals, norms
from zenvoy.analysis.measures.stretches import Stretch, main_stretch, stretches
from zenvoy.analysis.theory.chain import follow, is_stable
from zenvoy.analysis.theory.of_run import NoTheoryError, Theory, theory_of

Floats = NDArray[np.float64]

_FEWEST: Final = 20  # rows
_BEFORE_S: Final = 5.0  # the speed before the disturbance is the mean over this
_NOISY: Final = 0.02  # of the disturbance
_SHARE: Final = 0.05  # of the disturbed vehicle's dip: less is not followed
_NOISES: Final = 5.0  # standard deviations: noise alone will hardly reach it in a minute
_DIP_NOISES: Final = 3.0  # nor these within the seconds in which a dip is looked for
_GONE: Final = 0.01  # of the energy
_MOST: Final = 150  # vehicles: a matrix of them is solved for each frequency


@dataclass(frozen=True, kw_only=True, eq=False)
class Disturbed:
    """A stretch that is linear, as a rule from the disturbance on.

    time_s (T,); deviation (T, n) of the speeds from that before, m/s; predicted (T, n): what
    theory says the others do when the disturbed one moves as it did, None where it says nothing.
    from_start: the stretch begins with the disturbance. One that begins later, after a standstill,
    does not begin at rest: then deviations are from each vehicle's mean in it, and theory, which
    does not know in what motion it began, is not asked.
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
    from_start: bool
    stretches: tuple[Stretch, ...]
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

    @property
    def has_dip(self) -> bool:
        """Whether there is the dip of a braking to follow."""
        return self.disturbance.kind == "brake" and self.from_start

    def dips(self, deviation: Floats, order: NDArray[np.int64]) -> Arrivals:
        """Where the dip of a braking was when, along `behind` or `ahead`."""
        depth = max(0.0, -float(deviation[:, order[0]].min()))
        brakes_s = min(self.disturbance.end_s, self.time_s[-1]) - self.disturbance.start_s
        least = max(_SHARE * depth, _DIP_NOISES * self.noise, 1e-9)
        return arrivals(self.time_s, deviation, order, least, 5.0 + 3.0 * brakes_s)


def disturbed(run: Run) -> Disturbed | str:
    """The first disturbance of a run and what came of it; in words why there is none."""
    first = first_disturbance(run.events)
    if first is None:
        return "No vehicle was disturbed: of gains, waves and modes there is nothing to measure."
    found, notes = stretches(run, first)
    stretch = main_stretch(found)
    if stretch is None or stretch.rows < _FEWEST:
        few = "Too little is left after the disturbance to tell what became of it."
        return " ".join([*notes, few])
    of_stretch = _from_start if stretch.from_start else _from_motion
    return of_stretch(run, first, stretch, tuple(found), notes)


def _from_motion(
    run: Run,
    first: Disturbance,
    stretch: Stretch,
    found: tuple[Stretch, ...],
    notes: list[str],
) -> Disturbed:
    """A stretch that begins in the middle of things."""
    low, high, _ = stretch
    theory, _ = _theory(run, run.time_s[low], run.time_s[high - 1])
    behind, ahead = _orders(run, first.vehicle - 1, theory)
    told = (
        f"What follows is of {run.time_s[low]:g} s to {run.time_s[high - 1]:g} s. It does not "
        "begin at rest: deviations are from each vehicle's mean speed there, and linear theory is "
        "not asked."
    )
    return Disturbed(
        disturbance=first,
        time_s=run.time_s[low:high],
        deviation=fluctuation(run, stretch),
        predicted=None,
        felt=high - low,
        behind=behind,
        ahead=ahead,
        noise=0.0,
        rows=slice(low, high),
        from_start=False,
        stretches=found,
        theory=theory,
        notes=(*notes, told),
    )


def fluctuation(run: Run, stretch: Stretch) -> Floats:
    """Deviations (T, n) of speeds from each vehicle's mean over a stretch, m/s."""
    speed = run.truth["speed"][stretch.low : stretch.high]
    return np.asarray(speed - speed.mean(axis=0))


def _from_start(
    run: Run,
    first: Disturbance,
    stretch: Stretch,
    found: tuple[Stretch, ...],
    notes: list[str],
) -> Disturbed:
    """A stretch that begins with the disturbance, of a fleet that has settled before it."""
    source = first.vehicle - 1
    low, high, _ = stretch
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
    if theory is not None and run.vehicles > _MOST:
        told.append(f"More than {_MOST} vehicles: no theory of each of them.")
    elif theory is not None and not is_stable(theory.members):
        told.append("By theory vehicles swing by themselves: no response to a disturbance.")
    elif theory is not None:
        period_s = float(run.time_s[low + 1] - run.time_s[low])
        ring = run.scenario.road.type == "ring"
        predicted = follow(deviation[:, source], period_s, theory.members, source, ring=ring)
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
        from_start=True,
        stretches=found,
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


def _theory(run: Run, low_s: float, high_s: float) -> tuple[Theory | None, list[str]]:
    try:
        theory = theory_of(run, low_s, high_s)
    except NoTheoryError as error:
        return None, [f"No linear theory beside what was measured: {error}"]
    return theory, list(theory.caveats)
