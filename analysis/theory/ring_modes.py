"""Modes of a ring after a disturbance: how fast each decays, measured and by theory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.stability import Decay, decay, lasting, mode_amplitude
from zenvoy.analysis.theory.chain import Member
from zenvoy.analysis.theory.disturbed import Disturbed
from zenvoy.analysis.theory.ring import Mode, eigenvalue, modes, roots
from zenvoy.scenarios import roster

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_MAX_MODES: Final = 20  # higher modes decay before they can be measured
_FOLLOWED: Final = 0.02  # a mode is followed until it has fallen to this share
_MIN_ROWS: Final = 20  # for a fit
_MIN_R2: Final = 0.9  # a worse fit is not reported
_ABOVE_NOISE: Final = 3.0  # times the amplitude before the disturbance
_BEFORE_S: Final = 5.0


@dataclass(frozen=True, kw_only=True, eq=False)
class ModeRow:
    """A mode of the ring, measured and by theory."""

    number: int
    amplitude: Complexes
    """Amplitude after the disturbance (T,), m."""
    fitted: int
    """Number of rows of `amplitude` that the fit uses."""
    measured: Decay | None
    """Result of the fit; None where the mode is too weak or the fit is poor."""
    theory: Mode | None


@dataclass(frozen=True, kw_only=True, eq=False)
class Modes:
    """Modes 1, 2, … of a ring from `time_s` (T,) on; an open road has none, and a note says so."""

    time_s: Floats
    rows: tuple[ModeRow, ...]
    alike: Member | None
    size: int
    notes: tuple[str, ...]

    @property
    def slowest(self) -> ModeRow | None:
        """The mode that decays slowest: by theory, or else among those that were measured."""
        by_theory = [(row.theory.rate, row) for row in self.rows if row.theory]
        measured = [(row.measured.rate, row) for row in self.rows if row.measured]
        return max(by_theory or measured, key=lambda pair: pair[0], default=(0.0, None))[1]

    def by_theory(self, row: ModeRow) -> Complexes | None:
        """Return the amplitude by theory: its exponents, with weights fitted to the rows."""
        if self.alike is None or self.alike.coupling is None or not row.fitted:
            return None
        _, gains, delay_s, lag_s = self.alike
        lam = eigenvalue(self.alike.coupling, np.array([2.0 * np.pi * row.number / self.size]))
        exponents = roots(lam, gains, delay_s, lag_s)[:, 0]
        powers = np.exp((self.time_s - self.time_s[0])[:, None] * exponents[None, :])
        used = row.fitted
        weights = np.linalg.lstsq(powers[:used], row.amplitude[:used], rcond=None)[0]
        return np.asarray(powers @ weights)


def measured_modes(run: Run, case: Disturbed) -> Modes:
    """Return the modes from the end of the disturbance on."""
    ring_m = run.scenario.ring_length_m
    alike = case.theory.alike if case.theory else None
    after = case.time_s > case.disturbance.end_s
    time_s = case.time_s[after]
    notes: list[str] = []
    rows: list[ModeRow] = []
    if ring_m is None:
        notes.append("An open road has no modes, so only gains and waves are shown.")
    elif len(time_s) < _MIN_ROWS:
        notes.append("The disturbance lasts as long as the record, so modes cannot be measured.")
    else:
        if case.theory and not alike:
            notes.append("Vehicles differ in law or gains, so there is no theory of the modes.")
        start_s = case.disturbance.start_s
        before = (run.time_s > start_s - _BEFORE_S) & (run.time_s <= start_s)
        position = run.truth["position"]
        parts = position[before], position[case.rows][after]
        exponents = 3 if any(settings.lag_s for settings in roster(run.scenario)) else 2
        rows = [
            _row(parts, ring_m, number, (case.period_s, exponents), mode)
            for number, mode in enumerate(_by_theory(alike, run.vehicles), start=1)
        ]
    return Modes(
        time_s=time_s, rows=tuple(rows), alike=alike, size=run.vehicles, notes=tuple(notes)
    )


def _by_theory(alike: Member | None, n: int) -> Sequence[Mode | None]:
    if alike is None or alike.coupling is None:
        return [None] * min(n // 2, _MAX_MODES)
    return modes(alike.coupling, alike.gains, n, alike.delay_s, alike.lag_s, _MAX_MODES)


def _row(
    parts: tuple[Floats, Floats],
    ring_m: float,
    number: int,
    fit: tuple[float, int],
    mode: Mode | None,
) -> ModeRow:
    """Measure a mode from the positions before and after the disturbance.

    `fit` has the period of the rows, s, and the number of exponents.
    """
    before, after = (mode_amplitude(part, ring_m, number) for part in parts)
    fitted = lasting(after, _FOLLOWED)
    noise = float(np.sqrt(np.mean(np.abs(before) ** 2))) if before.size else 0.0
    stands_out = float(np.abs(after).max()) >= _ABOVE_NOISE * noise
    found = decay(after[:fitted], *fit) if stands_out and fitted >= _MIN_ROWS else None
    return ModeRow(
        number=number,
        amplitude=after,
        fitted=fitted,
        measured=found if found is not None and found.r2 >= _MIN_R2 else None,
        theory=mode,
    )
