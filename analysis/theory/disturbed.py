"""The motion after a run's first disturbance, and what linear theory predicts for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.spans import Disturbance, first_disturbance
from zenvoy.analysis.measures.stability import Arrivals, Norms, arrivals, norms
from zenvoy.analysis.measures.stretches import Stretch, main_stretch, stretches
from zenvoy.analysis.theory.chain import follow, is_stable
from zenvoy.analysis.theory.of_run import NoTheoryError, Theory, theory_of

Floats = NDArray[np.float64]

_MIN_ROWS: Final = 20  # of a stretch
_BEFORE_S: Final = 5.0  # the speed before the disturbance is the mean over this time
_NOISY: Final = 0.02  # of the disturbance; more scatter before it is worth a note
_MIN_DEPTH: Final = 0.05  # of the disturbed vehicle's dip; shallower dips are not followed
_NOISE_FACTOR: Final = 5.0  # standard deviations that noise hardly reaches in a minute
_DIP_NOISE_FACTOR: Final = 3.0  # those that it hardly reaches in the seconds of a dip
_LEFT_OUT: Final = 0.01  # of the energy of a response, at its end
_MAX_VEHICLES: Final = 150  # for theory, which solves a matrix of all vehicles per frequency


@dataclass(frozen=True, kw_only=True, eq=False)
class Disturbed:
    """A linear stretch of a run with T rows and n vehicles, and its theory.

    As a rule the stretch begins with the disturbance (`from_start`). Then deviations are from the
    mean speed before it. A stretch that begins later, after a standstill, does not begin at rest.
    Then deviations are from each vehicle's own mean, and there is no prediction, as theory does not
    know the initial motion.
    """

    disturbance: Disturbance
    time_s: Floats
    """Times of the rows, (T,)."""
    deviation: Floats
    """Deviations of the speeds, (T, n), m/s."""
    predicted: Floats | None
    """Deviations by theory if the disturbed vehicle moves as it did, (T, n), m/s."""
    response_rows: int
    """The first rows, with nearly all of the predicted response; norms are taken over them."""
    backwards: NDArray[np.int64]
    """Indices of the vehicles that the disturbance reaches backwards, the disturbed one first."""
    forwards: NDArray[np.int64]
    """The same forwards, if some laws look behind. On a ring the two meet halfway round."""
    noise: float
    """Standard deviation of speeds without a disturbance, m/s."""
    rows: slice
    from_start: bool
    stretches: tuple[Stretch, ...]
    """All linear stretches of the run; this is one of them."""
    theory: Theory | None
    notes: tuple[str, ...]

    @property
    def period_s(self) -> float:
        """Time from one row to the next, s."""
        return float(self.time_s[1] - self.time_s[0])

    @property
    def source(self) -> int:
        """Index of the disturbed vehicle."""
        return self.disturbance.vehicle - 1

    @property
    def above_noise(self) -> NDArray[np.bool_]:
        """Which vehicles (n,) deviate by clearly more than the noise."""
        largest = np.abs(self.deviation[: self.response_rows]).max(axis=0)
        return np.asarray(largest > max(_NOISE_FACTOR * self.noise, 1e-6))

    def gains(self, deviation: Floats) -> Norms:
        """Return the norms of all vehicles (n,) over the measured ones of the disturbed one."""
        measured = norms(self.deviation[: self.response_rows], self.period_s)
        found = norms(deviation[: self.response_rows], self.period_s)
        source = self.source
        return Norms(found.l2 / measured.l2[source], found.linf / measured.linf[source])

    @property
    def has_dip(self) -> bool:
        """Whether the disturbance is a braking, whose dip in speed can be followed."""
        return self.disturbance.kind == "brake" and self.from_start

    def dips(self, deviation: Floats, order: NDArray[np.int64]) -> Arrivals:
        """Return when the dip of a braking reached the vehicles of `backwards` or `forwards`."""
        depth = max(0.0, -float(deviation[:, order[0]].min()))
        brakes_s = min(self.disturbance.end_s, self.time_s[-1]) - self.disturbance.start_s
        least = max(_MIN_DEPTH * depth, _DIP_NOISE_FACTOR * self.noise, 1e-9)
        return arrivals(self.time_s, deviation, order, least, 5.0 + 3.0 * brakes_s)


class _Motion(NamedTuple):
    """The part of `Disturbed` that depends on how the stretch begins."""

    deviation: Floats
    predicted: Floats | None
    response_rows: int
    noise: float
    notes: list[str]


def disturbed(run: Run) -> Disturbed | str:
    """Return the motion after a run's first disturbance, or a sentence on why there is none."""
    first = first_disturbance(run.events)
    if first is None:
        return "No vehicle was disturbed, so there are no gains, waves or modes to measure."
    found, notes = stretches(run, first)
    stretch = main_stretch(found)
    if stretch is None or stretch.rows < _MIN_ROWS:
        return " ".join([*notes, "Too little time is left after the disturbance to analyse it."])
    theory, why = _theory(run, stretch)
    if stretch.from_start:
        motion = _from_rest(run, first, stretch, theory)
        notes += [*motion.notes, *why]
    else:
        motion = _from_motion(run, stretch)
        notes += motion.notes
    backwards, forwards = _reached(run, first.vehicle - 1, theory)
    return Disturbed(
        disturbance=first,
        time_s=run.time_s[stretch.low : stretch.high],
        deviation=motion.deviation,
        predicted=motion.predicted,
        response_rows=motion.response_rows,
        backwards=backwards,
        forwards=forwards,
        noise=motion.noise,
        rows=slice(stretch.low, stretch.high),
        from_start=stretch.from_start,
        stretches=tuple(found),
        theory=theory,
        notes=tuple(notes),
    )


def _from_motion(run: Run, stretch: Stretch) -> _Motion:
    """Return the motion in a stretch that begins after a standstill, when vehicles are moving."""
    low_s, high_s = run.time_s[stretch.low], run.time_s[stretch.high - 1]
    note = (
        f"This chapter covers {low_s:g} s to {high_s:g} s. That stretch does not begin at rest, so "
        "deviations are from each vehicle's mean speed in it, and there is no linear theory."
    )
    return _Motion(fluctuation(run, stretch), None, stretch.rows, 0.0, [note])


def fluctuation(run: Run, stretch: Stretch) -> Floats:
    """Return the deviations (T, n) of speeds from each vehicle's mean over a stretch, m/s."""
    speed = run.truth["speed"][stretch.low : stretch.high]
    return np.asarray(speed - speed.mean(axis=0))


def _from_rest(run: Run, first: Disturbance, stretch: Stretch, theory: Theory | None) -> _Motion:
    """Return the motion in a stretch that begins with the disturbance of a settled fleet."""
    speed, source = run.truth["speed"], first.vehicle - 1
    before = (run.time_s > first.start_s - _BEFORE_S) & (run.time_s <= first.start_s)
    before[max(0, stretch.low - 1)] = True  # long periods may have no row within _BEFORE_S
    deviation = speed[stretch.low : stretch.high] - speed[before].mean()
    scatter = float(speed[before].std())
    # Noise cannot be more than what is left at the end, when the disturbance has decayed.
    at_end = speed[stretch.low : stretch.high][-stretch.rows // 10 :]
    noise = min(scatter, float(at_end.std()))
    notes = []
    if scatter > _NOISY * np.abs(deviation[:, source]).max():
        notes.append(
            f"The speeds scatter by {scatter:.2g} m/s even before the disturbance. This noise is "
            "in what was measured, but not in the theory."
        )
    predicted = None
    if theory is not None:
        predicted, why = _predicted(run, stretch, theory, deviation[:, source], source)
        notes += [*theory.caveats, *why]
    rows = stretch.rows if predicted is None else _response_rows(predicted)
    return _Motion(deviation, predicted, rows, noise, notes)


def _predicted(
    run: Run, stretch: Stretch, theory: Theory, motion: Floats, source: int
) -> tuple[Floats | None, list[str]]:
    """Return the deviations (T, n) that theory predicts, or None and a note on why there are none.

    `motion` (T,) is the deviation of the disturbed vehicle.
    """
    if run.vehicles > _MAX_VEHICLES:
        return None, [f"Theory by vehicle is left out for more than {_MAX_VEHICLES} vehicles."]
    if not is_stable(theory.members):
        return None, ["By theory the fleet is unstable, so it has no response to a disturbance."]
    period_s = float(run.time_s[stretch.low + 1] - run.time_s[stretch.low])
    ring = run.scenario.road.type == "ring"
    return follow(motion, period_s, theory.members, source, ring=ring), []


def _response_rows(predicted: Floats) -> int:
    """Return the number of rows that hold all but a small share of the response's energy.

    A response that has not died out at the end has a constant power there, which is subtracted.
    """
    power = (predicted * predicted).sum(axis=1)
    at_end = power[-max(1, len(power) // 10) :].mean()
    if at_end >= power.mean():  # it does not die out
        return len(power)
    energy = np.cumsum(power - at_end)
    return int(np.argmax(energy >= (1.0 - _LEFT_OUT) * energy.max())) + 1


def _reached(
    run: Run, source: int, theory: Theory | None
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the indices of the vehicles that the disturbance reaches backwards and forwards.

    Without a law that looks behind, it only goes backwards.
    """
    n, ring = run.vehicles, run.scenario.road.type == "ring"
    both = theory is not None and any(m.coupling and m.coupling.behind for m in theory.members)
    back, forth = (n // 2, (n - 1) // 2) if ring else (n - 1 - source, source)
    if not both:
        back, forth = (n - 1 if ring else back), 0
    return (source + np.arange(back + 1)) % n, (source - np.arange(forth + 1)) % n


def _theory(run: Run, stretch: Stretch) -> tuple[Theory | None, list[str]]:
    """Return the theory of a stretch, or None and a note on why there is none."""
    try:
        return theory_of(run, run.time_s[stretch.low], run.time_s[stretch.high - 1]), []
    except NoTheoryError as error:
        return None, [f"There is no linear theory for this run: {error}"]
