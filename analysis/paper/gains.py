"""Two orderings of the paper for other gains: a table and a picture from short runs."""

from __future__ import annotations

from functools import partial
from itertools import product, starmap
from typing import Final, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from zenvoy.analysis.measures.digest import Digest
from zenvoy.analysis.measures.statistics import Mean, mean_of
from zenvoy.analysis.page.section import Picture, Sheet
from zenvoy.analysis.page.style import subplots
from zenvoy.analysis.paper.evidence import MODELS, Evidence, settled


class GainSet(NamedTuple):
    """Gains of distance (s⁻²), of relative speed (s⁻¹) and of the desired speed (s⁻¹)."""

    k_d: float
    k_v: float
    k_c: float

    @property
    def fm_string_stable(self) -> bool:
        """Whether FM damps disturbances of every frequency in linear theory."""
        return self.k_c**2 + 2 * self.k_v * self.k_c >= 2 * self.k_d

    def label(self, model: str) -> str:
        """Return the label of the runs of a model with these gains."""
        return f"gains/{self.k_d:g},{self.k_v:g},{self.k_c:g}/{model}"


GAINS: Final = tuple(
    starmap(GainSet, product((0.05, 0.1, 0.2), (0.25, 0.5, 1.0), (0.02, 0.05, 0.1)))
)

_ORDERINGS: Final = (("PBCM", "MBCM"), ("BCM", "FM"))


def has_gains(evidence: Evidence) -> bool:
    """Return whether the evidence has the runs with other gains."""
    return GAINS[0].label("FM") in evidence.runs


def sheet(evidence: Evidence) -> Sheet:
    """Return a row per set of gains: MinDistance of each model, and whether the orderings hold."""
    rows = []
    for gains in GAINS:
        ends = [evidence.over(gains.label(model), _min_distance).text(3) for model in MODELS]
        orderings = [_holds(_difference(evidence, gains, *pair)) for pair in _ORDERINGS]
        rows.append((*gains, "yes" if gains.fm_string_stable else "no", *ends, *orderings))
    n = len(evidence[GAINS[0].label("FM")])
    seeds = "seed 1" if n == 1 else f"means over {n} seeds with their 95 % intervals"
    return Sheet(
        name="gains",
        title="MinDistance of each model by gains.",
        columns=(
            "k_d, s⁻²",
            "k_v, s⁻¹",
            "k_c, s⁻¹",
            "FM string-stable",
            *(f"{model}, m" for model in MODELS),
            *(f"{better} over {worse}" for better, worse in _ORDERINGS),
        ),
        rows=tuple(rows),
        note=f"MinDistance, mean from 60 to 120 s, error 10 %, delay 0.1 s, {seeds}. An ordering is"
        " open where the 95 % interval of the difference, seed by seed, includes 0. In linear"
        " theory FM is string-stable if k_c² + 2 k_v k_c ≥ 2 k_d.",
    )


def picture(evidence: Evidence) -> Picture:
    """Return the picture of both differences over the gains."""
    return Picture(
        name="gains",
        caption="Two orderings of the paper for other gains: MinDistance (mean from 60 to 120 s;"
        " error 10 %, delay 0.1 s) of PBCM minus that of MBCM, and of BCM minus that of FM, with"
        " the 95 % interval over the seeds. Blue: the ordering holds. Red: it does not.",
        draw=partial(_draw, evidence),
    )


def _min_distance(run: Digest) -> float:
    return settled(run, "min_distance", 60.0, 120.0)


def _difference(evidence: Evidence, gains: GainSet, better: str, worse: str) -> Mean:
    """Return the difference of MinDistance of two models; their runs have the same seeds."""
    pairs = zip(evidence[gains.label(better)], evidence[gains.label(worse)], strict=True)
    return mean_of([_min_distance(one) - _min_distance(other) for one, other in pairs])


def _holds(difference: Mean) -> str:
    if np.isnan(difference.mean):  # the runs end before
        return "unknown"
    if difference.low <= 0.0 <= difference.high:
        return "open"
    return "yes" if difference.mean > 0.0 else "no"


def _draw(evidence: Evidence) -> Figure:
    k_d, k_v, k_c = (sorted(set(values)) for values in zip(*GAINS, strict=True))
    figure, axes = subplots(2, len(k_c), height_in=5.2, sharex=True, sharey=True)
    for row, (better, worse) in enumerate(_ORDERINGS):
        for place, c in zip(axes[row], k_c, strict=True):
            found = [
                [_difference(evidence, GainSet(d, v, c), better, worse) for d in k_d] for v in k_v
            ]
            means = np.array([[one.mean for one in of_row] for of_row in found])
            limit = max(1e-9, float(np.abs(means).max()))
            place.imshow(means, cmap="RdBu", vmin=-limit, vmax=limit, origin="lower", aspect="auto")
            for (y, x), value in np.ndenumerate(means):
                dark = abs(value) > 0.6 * limit
                place.text(
                    x, y, _text(found[y][x]), ha="center", va="center", color="w" if dark else "k"
                )
            place.set_title(f"{better} - {worse}, m; $k_c$ = {c:g} s⁻¹")
            place.set_xticks(range(len(k_d)), [f"{d:g}" for d in k_d])
            place.set_yticks(range(len(k_v)), [f"{v:g}" for v in k_v])
            place.grid(visible=False)
    for place in axes[1]:
        place.set_xlabel("$k_d$, s⁻²")
    for place in axes[:, 0]:
        place.set_ylabel("$k_v$, s⁻¹")
    return figure


def _text(difference: Mean) -> str:
    half = (difference.high - difference.low) / 2.0
    return f"{difference.mean:+z.2f}" + ("" if np.isnan(half) else f"\n± {half:.2f}")
