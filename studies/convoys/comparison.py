"""Everything that the page on real convoys tells, computed from recordings."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from zenvoy.scenarios.convoys.convoy import Convoy
from zenvoy.studies.convoys.behind import Motion, after_lead_in, motions, settled, under
from zenvoy.studies.convoys.calibration import Calibration, calibrate
from zenvoy.studies.convoys.groups import scenario_values
from zenvoy.studies.convoys.parallel import mapped
from zenvoy.studies.convoys.penetration import SHARES, Mixed, Point, Task, mixed

FITTED: Final = ("IDM", "FM", "ACC")
_PERIOD_S: Final = 0.1
_FREER: Final = 1.2
_FREEST_MPS: Final = 70.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Behind:
    """A law behind the leader of a recording: begun as recorded, and settled before."""

    recording: str
    model: str
    begun: Motion
    settled: Motion


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Compared:
    """Recordings, laws behind their leaders, fits, chains of fitted cars, and mixed convoys.

    fits and chains are by law and recording.
    """

    convoys: Sequence[Convoy]
    behind: Sequence[Behind]
    fits: Mapping[tuple[str, str], Calibration]
    chains: Mapping[tuple[str, str], Motion]
    mixed: Mapping[Point, Mixed]
    seeds: int

    @property
    def models(self) -> list[str]:
        """The laws behind the leaders, in their order."""
        return list(dict.fromkeys(one.model for one in self.behind))

    @property
    def settings(self) -> list[str]:
        """How the cars were driven, once each, in order of the recordings."""
        return list(dict.fromkeys(one.setting for one in self.convoys))

    @property
    def best(self) -> str:
        """The law that fits best: of the smallest median error on held-out recordings.

        Where no car was recorded twice, the errors of the fits themselves decide.
        """
        return best_of(self.fits)


def compare(
    convoys: Sequence[Convoy],
    models: Sequence[str],
    *,
    seeds: int,
    jobs: int,
    say: Callable[[str], None],
) -> Compared:
    """Return everything about these recordings and laws; says what it does."""
    pairs = list(product(convoys, models))
    behind = mapped(_behind, pairs, jobs, lambda _, one: say(f"{one.recording}: {one.model}"))
    fits = {}
    for law, convoy in product(FITTED, convoys):
        others = [one for one in convoys if one is not convoy and one.setting == convoy.setting]
        fits[law, convoy.name] = calibrate(
            convoy, law, bounds=bounds_for(law, convoy), hold_out=others, jobs=jobs
        )
        say(f"{convoy.name}: {law} fitted")
    keys = list(fits)
    chains = mapped(chain, [fits[key] for key in keys], jobs, lambda *_: None)
    best = best_of(fits)
    say(f"{best} fits best")
    tasks = [
        Task(fits[best, convoy.name], Point(convoy.name, share, beacon, begun), range(1, seeds + 1))
        for convoy, share, beacon, begun in product(convoys, SHARES, (True, False), (True, False))
    ]
    found = mapped(mixed, tasks, jobs, lambda k, _: say(_told(tasks[k].point)))
    return Compared(
        convoys=convoys,
        behind=behind,
        fits=fits,
        chains=dict(zip(keys, chains, strict=True)),
        mixed={task.point: one for task, one in zip(tasks, found, strict=True)},
        seeds=seeds,
    )


def bounds_for(law: str, convoy: Convoy) -> dict[str, tuple[float, float]]:
    """Return ranges by which a fitted car can also follow elsewhere.

    The free speed of IDM is above all that was driven. Otherwise a fit may take a car that keeps
    its gap for one that can go no faster.
    """
    if law != "IDM":
        return {}
    return {"free_speed_mps": (_FREER * float(convoy.speed.max()), _FREEST_MPS)}


def held_errors(found: Calibration) -> list[float]:
    """Return the held-out error of the gap of each car that has one, m."""
    return [math.sqrt(np.mean([one.rms_gap_m**2 for one in held])) for held in found.held if held]


def best_of(fits: Mapping[tuple[str, str], Calibration]) -> str:
    """Return the law whose errors on held-out recordings have the smallest median."""
    held: dict[str, list[float]] = {}
    own: dict[str, list[float]] = {}
    for (law, _), found in fits.items():
        held.setdefault(law, []).extend(held_errors(found))
        own.setdefault(law, []).extend(fit.rms_gap_m for fit in found.fits)
    errors = held if all(held.values()) else own
    return min(errors, key=lambda law: float(np.median(errors[law])))


def _behind(pair: tuple[Convoy, str]) -> Behind:
    convoy, model = pair
    values = under(convoy, model)
    (begun,), (after,) = motions(values), motions(settled(values))
    return Behind(
        recording=convoy.name,
        model=model,
        begun=begun,
        settled=after_lead_in(after, _PERIOD_S),
    )


def chain(found: Calibration) -> Motion:
    """Return the motion of all fitted cars behind the leader alone."""
    values = scenario_values(found)
    values["events"] = under(found.convoy, "FM")["events"]
    return motions(values)[0]


def _told(point: Point) -> str:
    others = "all send beacons" if point.all_beacon else "the others are silent"
    begun = "settled" if point.settled else "begun as recorded"
    return f"{point.recording}: {point.share:.0%} equipped, {others}, {begun}"
